"""A run folder read back is the result that the run returned; a damaged one is refused."""

import dataclasses
import json
import shutil

import numpy as np
import pytest
from pxr import Sdf, Usd, Vt

import warpdrape as wd
from warpdrape.results.fields import FIELDS, fields_of
from warpdrape.results.result import FormedPly
from warpdrape.results.usd import PlyFrame
from warpdrape.scenes import hemisphere

SINGLE = 2.0**-24  # half a unit in the last place of a number in single precision, over it


@pytest.fixture
def copy(pressed, tmp_path):
    """A copy of a run folder, to be spoilt."""
    return shutil.copytree(pressed[1], tmp_path / "copy")


def same(one, other):
    """Whether arrays are equal but for being kept in single precision."""
    assert one.shape == other.shape and one.dtype == other.dtype
    if one.dtype.kind == "f":
        return bool((np.abs(one - other) <= 1.01 * SINGLE * np.abs(one) + 1e-38).all())
    return bool((one == other).all())


def test_it_is_the_result_of_the_run_in_single_precision(pressed):
    ran, folder = pressed
    read = wd.read_run(folder)
    assert [ply.name for ply in read.plies] == ["ply_0", "ply_1", "ply_2"]
    for one, other in zip(ran.plies, read.plies, strict=True):
        assert one.wrinkling is not None and other.wrinkling is None
        for field in dataclasses.fields(FormedPly)[1:]:
            if field.name == "wrinkling":
                continue
            if field.name in ("yarn_slide", "temperature"):  # crossovers are pinned, plies are dry
                assert getattr(one, field.name) is getattr(other, field.name) is None
                continue
            assert same(getattr(one, field.name), getattr(other, field.name)), field.name
        assert np.ptp(np.sign(other.shear_angle)) == 2.0  # signed, either way
    for one, other in zip(ran.tools, read.tools, strict=True):
        assert one.name == other.name and same(one.triangles.astype(np.int32), other.triangles)
        # vertices are a start in single precision and a way in double
        np.testing.assert_allclose(one.vertices, other.vertices, atol=0.25 * SINGLE)
    assert json.dumps(read.summary) == json.dumps(json.loads((folder / "summary.json").read_text()))
    assert list(read.history) == list(ran.history)
    assert all((read.history[name] == ran.history[name]).all() for name in ran.history)
    assert read.completed and read.time_s == ran.time_s


def test_any_frame_can_be_asked_for(pressed):
    folder = pressed[1]
    flat = wd.read_run(folder, frame=0)
    np.testing.assert_array_equal(flat.plies[0].points, flat.plies[0].rest_points)
    assert flat.time_s == 0.0 and "shown at 0 ms" in repr(flat)
    way = wd.read_run(folder).tools[0].vertices - flat.tools[0].vertices
    moved = wd.read_run(folder).history["punch_displacement_m"][-1]
    np.testing.assert_allclose(way, np.tile([0.0, 0.0, -moved], (len(way), 1)), atol=1e-9)
    for frame in range(5):
        read, back = wd.read_run(folder, frame=frame), wd.read_run(folder, frame=frame - 5)
        assert read.frame == back.frame == frame
        for ply in read.plies:
            shear = read.history[f"{ply.name}_max_shear_deg"][frame]
            assert ply.max_shear_deg == pytest.approx(shear, rel=1e-6)
    for frame in (5, -6, 1.5, True):
        with pytest.raises(wd.InputError, match=f"frame = {frame} "):
            wd.read_run(folder, frame=frame)


def test_every_quantity_of_a_frame_is_listed_once_and_read():
    listed = [field.name for field in FIELDS]
    assert sorted(listed) == sorted({f.name for f in dataclasses.fields(PlyFrame)} - {"points"})
    assert len({field.column for field in FIELDS}) == len(FIELDS)


def test_a_ply_without_bending_and_without_neighbours_has_none_of_their_fields(tmp_path):
    scene = hemisphere.build(cells=4, bending="none", travel=0.01, duration=0.004)
    ran = scene.run(tmp_path, frames=1)
    read = wd.read_run(tmp_path)
    for ply in (ran.plies[0], read.plies[0]):
        assert ply.curvature is ply.slip is ply.contact_pressure is None
        assert ply.tool_pressure is not None
        assert {f.name for f in FIELDS} - {f.name for f in fields_of(ply)} == {
            "warp_curvature",
            "weft_curvature",
            "slip",
            "contact_pressure",
            "warp_slide",
            "weft_slide",
            "temperature",
        }


def test_a_failed_run_is_read_too(tmp_path, monkeypatch):
    from warpdrape.simulation import Stepper

    blocks = []
    block = Stepper.block

    def interrupted(self):
        blocks.append(1)
        if len(blocks) > 400:
            raise KeyboardInterrupt
        block(self)

    monkeypatch.setattr(Stepper, "block", interrupted)
    ran = hemisphere.build(cells=4, travel=0.02, duration=0.01).run(tmp_path, frames=20)
    read = wd.read_run(tmp_path)
    assert not ran.completed and not read.completed
    assert read.frame == len(ran.history["time_s"]) - 1 < 20
    assert same(ran.plies[0].points, read.plies[0].points)


def cut(name, share):
    def spoil(folder):
        data = (folder / name).read_bytes()
        (folder / name).write_bytes(data[: int(share * len(data))])

    return spoil


def remove(name):
    return lambda folder: (folder / name).unlink()


def write(name, text):
    return lambda folder: (folder / name).write_text(text, encoding="utf-8")


def unfinished(folder):
    (folder / "summary.json").unlink()
    (folder / "scene.usdc").rename(folder / ".scene.partial.usdc")
    (folder / "history.csv").rename(folder / ".history.partial.csv")


def without_a_row(folder):
    lines = (folder / "history.csv").read_text("utf-8").splitlines(keepends=True)
    (folder / "history.csv").write_text("".join(lines[:-1]), "utf-8")


def authored(change):
    """Change the stage."""

    def spoil(folder):
        layer = Sdf.Layer.FindOrOpen(str(folder / "scene.usdc"))
        stage = Usd.Stage.Open(layer)
        change(stage.GetPrimAtPath("/World/plies/ply_1"))
        layer.Save()

    return spoil


def shorten(name, frame=4):
    def change(prim):
        attribute = prim.GetAttribute(name)
        attribute.Set(Vt.FloatArray(attribute.Get(frame)[:-1]), frame)

    return authored(change)


def not_finite(prim):
    attribute = prim.GetAttribute("primvars:warpStrain")
    values = list(attribute.Get(4))
    values[3] = float("nan")
    attribute.Set(Vt.FloatArray(values), 4)


def refer(folder):
    (folder / "other.usda").write_text('#usda 1.0\ndef "World" {}\n')
    layer = Sdf.Layer.FindOrOpen(str(folder / "scene.usdc"))
    layer.subLayerPaths.append("other.usda")
    layer.Save()


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (shutil.rmtree, "does not exist"),
        (remove("summary.json"), "holds no summary.json: give that of a finished run"),
        (remove("scene.usdc"), "holds no scene.usdc"),
        (remove("history.csv"), "holds no history.csv"),
        (unfinished, "but an unfinished one: wait for the run"),
        (write("summary.json", '{"status": "comp'), "is not readable JSON"),
        (write("summary.json", "[" * 100_000), "is not readable JSON"),
        (write("summary.json", "[1]"), "is no summary of a run"),
        (
            write("summary.json", '{"status": "failed", "message": "x"}'),
            "before its first frame: x",
        ),
        (write("summary.json", '{"status": "failed"}'), "before its first frame"),
        (write("summary.json", '{"status": "completed"}'), "no usable message, warnings, approach"),
        (write("summary.json", '{"a": NaN}'), "not readable JSON (NaN is no number)"),
        (write("summary.json", '{"a": 1e999}'), "not readable JSON (1e999 is no number)"),
        (write("summary.json", f'{{"a": {10**400}}}'), "is no number): run the scene again"),
        (write("history.csv", "time_s,x\n0,1\n1\n"), "is no table of numbers"),
        (write("history.csv", ""), "is no table of numbers"),
        (write("history.csv", "time_s\nfar\n"), "is no table of numbers"),
        (write("history.csv", "time_s\nnan\n"), "not finite"),
        (without_a_row, "scene.usdc has 5 frames and history.csv 4"),
        (cut("scene.usdc", 0.5), "is not a readable USD file"),
        (cut("scene.usdc", 0.99), "is not a readable USD file"),
        (write("scene.usdc", ""), "is not a readable USD file"),
        (shorten("primvars:warpTension"), "ply_1: warpTension has shape (143,), not"),
        (shorten("primvars:toolPressure"), "ply_1: toolPressure has shape (84,), not"),
        (authored(not_finite), "ply_1: warpStrain has shape (144,), not finite"),
        (authored(lambda p: p.RemoveProperty("primvars:weft")), "ply 'ply_1' lacks weft"),
        (authored(lambda p: p.GetStage().RemovePrim(p.GetPath())), "of different runs, or damaged"),
        (
            authored(lambda p: p.GetAttribute("faceVertexIndices").Set([0, 1, 999] * 144)),
            "'ply_1' has triangles of vertices that it lacks",
        ),
        (refer, "refers to another file, other.usda"),
    ],
)
def test_what_is_no_whole_run_is_refused_in_a_sentence(spoil, words, copy):
    spoil(copy)
    with pytest.raises(wd.InputError) as refused:
        wd.read_run(copy)
    assert words in str(refused.value) and "\n" not in str(refused.value)
    assert str(copy) in str(refused.value)


def test_a_file_is_no_folder(pressed):
    with pytest.raises(wd.InputError, match="is a file"):
        wd.read_run(pressed[1] / "scene.usdc")


def test_a_run_that_failed_at_once_says_why(copy):
    (copy / "scene.usdc").unlink()
    write("summary.json", '{"status": "failed", "message": "energy grew"}')(copy)
    with pytest.raises(wd.InputError, match="as the run failed: energy grew"):
        wd.read_run(copy)


def test_nothing_in_the_folder_is_executed(copy, tmp_path):
    mark = tmp_path / "mark"
    for name in ("scene.py", "conftest.py", "__init__.py", "usdGenSchema.py"):
        (copy / name).write_text(f"open({str(mark)!r}, 'w')\n")
    record = json.loads((copy / "run.json").read_text("utf-8"))
    (copy / "run.json").write_text(json.dumps(record | {"script": str(copy / "scene.py")}))
    assert wd.read_run(copy).completed
    assert not mark.exists()
