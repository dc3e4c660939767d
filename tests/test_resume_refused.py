"""A run does not go on as another, nor from what is no run; nothing is touched then."""

import dataclasses

import numpy as np
import pytest
from resume_checks import cut_off, loaded, press

from warpdrape import DefectThresholds
from warpdrape.errors import InputError

OTHERS = [
    (lambda s: dataclasses.replace(s, friction=0.3), {}, "friction = 0.3, the run's 0.2"),
    (lambda s: dataclasses.replace(s, duration=5e-3), {}, "duration = 0.005, the run's 0.004"),
    (lambda s: dataclasses.replace(s, gravity=(0, 0, 0)), {}, "gravity = "),
    (lambda s: press(safety=0.8), {}, "numerics: safety = 0.8, the run's 0.9"),
    (lambda s: s, {"frames": 7}, "frames = 7, the run's 4"),
    (lambda s: s, {"threads": 2}, "threads = 2, the run's 1"),
    (
        lambda s: dataclasses.replace(
            s,
            plies=[dataclasses.replace(s.plies[0], fabric=stiffer(s.plies[0].fabric)), s.plies[1]],
        ),
        {},
        "bending of the fabric of ply 'low' is another",
    ),
    (lambda s: dataclasses.replace(s, plies=finer(s.plies)), {}, "mesh of ply 'high' is another"),
    (lambda s: dataclasses.replace(s, tools=s.tools[:2]), {}, r"tools = \['ring', 'ball'\]"),
    (
        lambda s: dataclasses.replace(s, tools=[*s.tools[:2], s.tools[2].turned((0, 0, 1), 1e-9)]),
        {},
        "surface of tool 'plate' is another",
    ),
    (
        lambda s: dataclasses.replace(
            s,
            tools=[
                s.tools[0],
                dataclasses.replace(
                    s.tools[1], motion=dataclasses.replace(s.tools[1].motion, ramp=0.31)
                ),
                s.tools[2],
            ],
        ),
        {},
        "motion of tool 'ball' is another",
    ),
    (
        lambda s: dataclasses.replace(s, ply_friction=loaded().ply_friction),
        {},
        "ply_friction = {'type': 'Friction'",
    ),
    (lambda s: dataclasses.replace(s, springs=loaded().springs), {}, r"springs = \['grip'\]"),
    (lambda s: dataclasses.replace(s, pressures=loaded().pressures), {}, "pressures = "),
    (
        lambda s: dataclasses.replace(s, defects=DefectThresholds(bridge_gap=2.0)),
        {},
        "defects: bridge_gap = 2.0, the run's 1.0",
    ),
]


def stiffer(fabric):
    bending = dataclasses.replace(fabric.bending, warp=2.0000001e-4)
    return dataclasses.replace(fabric, bending=bending)


def finer(plies):
    mesh = plies[1].mesh
    vertices = np.array(mesh.vertices)
    vertices[len(vertices) // 2] += 1e-9
    return [plies[0], dataclasses.replace(plies[1], mesh=type(mesh)(vertices, mesh.triangles))]


@pytest.fixture(scope="module")
def cut(tmp_path_factory):
    folder = tmp_path_factory.mktemp("refused") / "run"
    with pytest.MonkeyPatch.context() as patch:
        cut_off(press(), folder, 2, patch, frames=4)
    return folder


@pytest.mark.parametrize(("changed", "options", "words"), OTHERS)
def test_what_differs_is_refused_by_name_and_nothing_is_touched(changed, options, words, cut):
    before = {f.name: f.read_bytes() for f in cut.iterdir()}
    with pytest.raises(InputError, match=f"cannot go on: {words}"):
        changed(press()).run(resume=cut, **options)
    assert {f.name: f.read_bytes() for f in cut.iterdir()} == before


def test_another_version_or_other_kernels_are_refused(cut, monkeypatch):
    from warpdrape.results import fingerprint

    monkeypatch.setattr(fingerprint, "versions", lambda: dict.fromkeys(fingerprint.COMPUTES, "9"))
    with pytest.raises(InputError, match="version of warpdrape = '9', the run's "):
        press().run(resume=cut)
    monkeypatch.undo()
    monkeypatch.setattr(fingerprint, "_sources", lambda _: iter("other kernels"))
    with pytest.raises(InputError, match="kernels is another"):
        press().run(resume=cut)


def test_no_run_no_resume(tmp_path):
    with pytest.raises(InputError, match=r"nowhere does not exist: give the folder of a run"):
        press().run(resume=tmp_path / "nowhere")
    with pytest.raises(InputError, match=r"holds no run: give the folder of one"):
        press().run(resume=tmp_path)
    with pytest.raises(InputError, match="a run goes on in its own folder"):
        press().run(tmp_path / "out", resume=tmp_path)
    with pytest.raises(InputError, match="extend needs a run with a checkpoint"):
        press().run(extend=True)


@pytest.mark.parametrize("every", ["", "0", "-3", "2.5", "often", "3 days", None, True, 1.5, "1e3"])
def test_how_often_is_read_or_refused(every):
    with pytest.raises(InputError, match=r"checkpoint = .* must be frames such as 5"):
        press().run(checkpoint=every)


def test_frames_or_rows_of_another_run_are_refused_and_nothing_is_touched(cut):
    for name in (".scene.partial.usdc", ".history.partial.csv"):
        path, own = cut / name, (cut / name).read_bytes()
        for other in (own[:150], own[:100] + bytes([own[100] ^ 1]) + own[101:]):
            path.write_bytes(other)
            before = {f.name: f.read_bytes() for f in cut.iterdir()}
            with pytest.raises(InputError, match="does not hold the"):
                press().run(resume=cut)
            assert {f.name: f.read_bytes() for f in cut.iterdir()} == before
        path.write_bytes(own)
