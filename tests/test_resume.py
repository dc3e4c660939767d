"""A run that was cut off goes on from its checkpoint to the same result, to the last bit."""

import dataclasses
import json
import math
import shutil
import signal

import numpy as np
import pytest
import warp as wp
from resume_checks import (
    SCENES,
    STIFF,
    assert_same_folder,
    cut_between,
    cut_off,
    loaded,
    press,
    samples,
    timeless,
)

from warpdrape import DefectThresholds
from warpdrape.cadence import read_cadence
from warpdrape.dynamics.loading import Loading
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.moving_arrays import moving_arrays, read_bytes, write_bytes
from warpdrape.dynamics.stepping import Stepper
from warpdrape.errors import InputError, RunFailed
from warpdrape.recorder import Recorder
from warpdrape.restart import read_restart
from warpdrape.state import all_arrays
from warpdrape.tools.motion import Path

FRAMES = 8


@pytest.fixture(autouse=True)
def few_looks(monkeypatch):
    """Each look at the energies of a paced run costs as much as a block of these."""
    monkeypatch.setattr("warpdrape.timing.LOOKS", 16)


LESS_OFTEN = ("friction between fibres", "membranes, exact")


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.slow) if n in LESS_OFTEN else n for n in SCENES],
)
def test_a_run_that_was_cut_off_ends_as_one_that_was_not(name, tmp_path, monkeypatch):
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    expected = SCENES[name]().run(whole, frames=FRAMES, checkpoint=2)
    cut_off(SCENES[name](), cut, 5, monkeypatch)
    assert (cut / "checkpoint.npz").exists() and not (cut / "summary.json").exists()
    result = SCENES[name]().run(resume=cut)
    assert expected.completed and expected.summary["steps"] > 200
    assert_same_folder(cut, whole)
    assert timeless(result.summary) == timeless(expected.summary)
    for one, other in zip(result.plies, expected.plies, strict=True):
        assert np.abs(one.points - one.rest_points).max() > 1e-3
        np.testing.assert_array_equal(one.points, other.points)


def in_the_midst(frame, loading):
    """On the way to the second frame, with steps done and to do."""
    return frame == 1 and loading.left > 0


def after_a_look(frame, loading):
    """The same at the last step of a stretch: the pace to come has just been chosen."""
    return frame == 1 and loading.left == 0 and not loading.come_to(2)


def before_its_end(frame, loading):
    """After the last step to a frame, which is not yet recorded; the third is the last one."""
    return loading.left == 0 and loading.come_to(frame + 1)


BETWEEN = [(name, in_the_midst) for name in SCENES]
BETWEEN += [("paced", after_a_look), ("coupon", before_its_end)]
QUICK = ("paced", "loaded", "turning", "coupon")


@pytest.mark.parametrize(
    ("name", "when"),
    [pytest.param(*b, marks=[] if b[0] in QUICK else pytest.mark.slow) for b in BETWEEN],
)
def test_a_run_that_was_cut_off_between_frames_ends_as_one_that_was_not(
    name, when, tmp_path, monkeypatch
):
    SCENES[name]().run(tmp_path / "whole", frames=3, checkpoint=3)
    cut_between(SCENES[name](), tmp_path / "cut", when, monkeypatch)
    restart = read_restart(tmp_path / "cut")
    assert restart.frame == (2 if when is before_its_end else 1)
    assert restart.tally.steps > restart.tally.steps_before > 0
    assert (restart.clock.left > 0) == (when is in_the_midst)
    again = SCENES[name]().run(resume=tmp_path / "cut")
    assert again.completed
    assert_same_folder(tmp_path / "cut", tmp_path / "whole")


@pytest.mark.parametrize("disk_is_full", [False, True])
def test_what_a_signal_ends_goes_on_from_where_it_was(disk_is_full, tmp_path, monkeypatch):
    """A checkpoint is kept then, in the midst of a frame too; the one before, if it cannot be."""
    press().run(tmp_path / "whole", frames=2)
    block, done = Stepper.block, []

    def asked(self):
        block(self)
        done.append(1)
        if 1.5 * len(done) * self._model.timing.search_every > self._model.timing.steps:
            before.setdefault("steps", read_restart(tmp_path / "run").tally.steps)
            if len(before) == 1:
                before["more"] = signal.raise_signal(signal.SIGTERM)
                if disk_is_full:
                    monkeypatch.setattr("warpdrape.restart.write_checkpoint", full)

    def full(*_, **__):
        raise RunFailed("checkpoint.npz could not be written (No space left on device)")

    before = {}
    monkeypatch.setattr(Stepper, "block", asked)
    stopped = press().run(tmp_path / "run", frames=2, checkpoint=1)
    monkeypatch.undo()
    assert stopped.summary["message"] == "asked to end by SIGTERM"
    restart = read_restart(tmp_path / "run")
    assert (restart.tally.steps == before["steps"]) == disk_is_full
    if not disk_is_full:
        assert restart.clock.left > 0
        assert restart.tally.steps == len(done) * restart.timing.search_every
    assert press().run(resume=tmp_path / "run").completed
    assert_same_folder(tmp_path / "run", tmp_path / "whole")


def test_a_run_that_was_cut_off_between_frames_is_not_extended(tmp_path, monkeypatch):
    cut_between(press(), tmp_path / "cut", in_the_midst, monkeypatch)
    longer = dataclasses.replace(press(), duration=8e-3)
    with pytest.raises(InputError, match="cut off between frames 1 and 2: let it come to its end"):
        longer.run(resume=tmp_path / "cut", extend=True)


def test_seconds_are_kept_between_frames_and_frames_are_not():
    for text, between in (("5", False), ("2s", True), ("auto", True)):
        cadence = read_cadence(text)
        assert cadence.due(0, math.inf, 0.0) and cadence.due(None, 1e6, 0.01) == between
        assert cadence.due(3, 1.9, 0.1) is False and cadence.due(None, 1.9, 0.1) is False
        assert cadence.due(5, 2.1, 0.02) is True


def test_parts_on_threads_go_on_to_the_bit_too(tmp_path, monkeypatch):
    expected = press().run(tmp_path / "whole", frames=4, threads=2)
    cut_off(press(), tmp_path / "cut", 3, monkeypatch, frames=4, threads=2)
    result = press().run(resume=tmp_path / "cut")
    assert json.loads((tmp_path / "cut" / "run.json").read_text("utf-8"))["threads"] == 2
    assert_same_folder(tmp_path / "cut", tmp_path / "whole")
    assert timeless(result.summary) == timeless(expected.summary)


@pytest.mark.slow
def test_a_run_may_be_cut_off_again_and_again(tmp_path, monkeypatch):
    press().run(tmp_path / "whole", frames=FRAMES)
    cut_off(press(), tmp_path / "cut", 1, monkeypatch, every=1)
    for frame in (2, 3, 7):
        earlier = tmp_path / f"to {frame}"
        (tmp_path / "cut").rename(earlier)
        cut_off(press(), tmp_path / "cut", frame, monkeypatch, every=1, resume=earlier)
    press().run(resume=tmp_path / "cut")
    assert_same_folder(tmp_path / "cut", tmp_path / "whole")


@pytest.mark.slow
def test_a_blow_up_after_a_restart_shows_the_same_last_good_frame(tmp_path, monkeypatch):
    """The first look after a restart finds it: the last good frame is the checkpoint's."""

    def spoil(self, state):
        if self.tally.steps > 0.6 * self._model.timing.steps:
            state.tools.impulse.fill_(np.nan)
        return take_down(self, state)

    take_down = Recorder._take_down
    monkeypatch.setattr(Recorder, "_take_down", spoil)
    whole = press().run(tmp_path / "whole", frames=FRAMES, checkpoint=1)
    cut_off(press(), tmp_path / "cut", 4, monkeypatch, every=3)
    (tmp_path / "cut" / "checkpoint.npz").unlink()
    shutil.copy(tmp_path / "whole" / "checkpoint.npz", tmp_path / "cut")  # the last good frame's
    for name in ("scene.usdc", "history.csv"):
        shutil.copy(tmp_path / "whole" / name, tmp_path / "cut")
        (tmp_path / "cut" / f".{name.replace('.', '.partial.')}").unlink()
    again = press().run(resume=tmp_path / "cut")
    assert "is nan" in again.summary["message"] and not again.completed
    assert timeless(again.summary) == timeless(whole.summary)
    np.testing.assert_array_equal(again.plies[1].points, whole.plies[1].points)


@pytest.mark.slow
def test_a_finished_run_ends_again_as_it_did(tmp_path):
    whole = press().run(tmp_path / "run", frames=2)
    before = {f.name: f.read_bytes() for f in (tmp_path / "run").iterdir()}
    again = press().run(resume=tmp_path / "run")
    assert timeless(again.summary) == timeless(whole.summary)
    after = {f.name: f.read_bytes() for f in (tmp_path / "run").iterdir()}
    for name in ("history.csv", "run.json", "scene.usdc"):
        assert before[name] == after[name]


def moved_on(scene, blocks=40, threads=1):
    """A model's stepper after some blocks of its first frame."""
    model = build_model(scene, "cpu", 4)
    state = initial_state(model)
    stepper, loading = Stepper(model, state, threads), Loading(scene, model.timing)
    stepper.begin(loading.stretch(1))
    for _ in range(blocks):
        stepper.block()
    return model, state, stepper, loading


@pytest.mark.parametrize("threads", [1, 2])
def test_nothing_that_steps_write_is_left_out(threads):
    """Any array whose bytes change in a block is among those kept, whoever holds it.

    But for the shapes of plies, which every search makes before it reads them: they may be spoilt.
    """
    scene = press(STIFF, clamped=True)
    model, state, stepper, _ = moved_on(scene, 3, threads)
    surfaces = next(each for each in model.contacts if each.name == "ply surfaces")
    made = (surfaces.normals, surfaces.hollows)
    for array in made:
        array.fill_(math.nan)
    held = every_array([model, stepper.parts])
    before = {at: array.numpy().tobytes() for at, array in held.items()}
    for _ in range(20):
        stepper.block()
    changed = {at for at, array in held.items() if array.numpy().tobytes() != before[at]}
    kept = {array.ptr for array in moving_arrays(stepper.parts).values()}
    assert len(changed) > 15 and changed <= kept | {array.ptr for array in made}
    for array in made:
        assert np.isfinite(array.numpy()).all()  # a search came, and no step read what was spoilt
    assert np.isfinite(state.plies.x.numpy()).all()
    assert len(held) > len(kept)  # it looked at more than those


def every_array(things):
    """Every Warp array that can be reached, by its address."""
    found, seen, left = {}, set(), list(things)
    while left:
        thing = left.pop()
        if id(thing) in seen:
            continue
        seen.add(id(thing))
        if isinstance(thing, wp.array):
            if thing.size:
                found[thing.ptr] = thing
        elif isinstance(thing, list | tuple | set):
            left += thing
        elif isinstance(thing, dict):
            left += thing.values()
        elif isinstance(thing, wp.Mesh):
            left.append(thing.points)
        elif type(thing).__module__.startswith("warpdrape"):
            left += vars(thing).values() if hasattr(thing, "__dict__") else []
    return found


def test_a_state_must_not_hold_what_no_checkpoint_would_keep():
    @dataclasses.dataclass(frozen=True)
    class Memory:
        pushed: list

    with pytest.raises(TypeError, match="pushed is a list"):
        list(all_arrays((None, Memory([1.0]))))


def test_all_that_changes_on_the_host_is_in_its_record(tmp_path):
    """Loading, watch and recorder keep what they change in one record each."""
    scene = press(kinetic_limit=0.3)
    model, state, stepper, loading = moved_on(scene, 1)
    recorder = Recorder(model, None, loading)
    recorder.record(state, 0)
    kept = {
        loading: {"clock"},
        recorder.watch: {"seen"},
        # Rows are in their file; the last good frame is taken from the state again.
        recorder: {"tally", "_rows", "_plies", "_measured", "_loose"},
        stepper: {"blocks", "_asking"},  # the latter follows from the former
    }
    before = {thing: plainly(thing) for thing in kept}
    stepper.block()
    recorder.tally.steps += model.timing.search_every
    loading.stretch(1)
    loading.adapt(1.0, 0.5)
    recorder.watch.seen.squeezed = "deep"
    recorder.record(state, 1)
    for thing, names in kept.items():
        now = plainly(thing)
        assert {name for name in now if now[name] != before[thing][name]} <= names


def plainly(thing):
    """Attributes as texts or, where these would not show a change, as they are."""
    return {
        name: repr(value) if dataclasses.is_dataclass(value) else value
        for name, value in {n: v for n, v in vars(thing).items()}.items()
        if isinstance(value, int | float | str | None) or dataclasses.is_dataclass(value)
    } | {name: id(value) for name, value in vars(thing).items() if name in ("_plies", "_loose")}


def test_bytes_of_arrays_go_there_and_back():
    _, _, stepper, _ = moved_on(press(STIFF), 5)
    arrays = moving_arrays(stepper.parts)
    saved = read_bytes(arrays)
    other = moving_arrays(moved_on(press(STIFF), 0)[2].parts)
    assert other.keys() == arrays.keys()
    write_bytes(other, saved)
    for name, array in other.items():
        assert array.numpy().tobytes() == arrays[name].numpy().tobytes(), name
    short = {**saved, "plies.x": saved["plies.x"][1:]}
    with pytest.raises(ValueError, match=r"plies\.x is not the array"):
        write_bytes(other, short)
    with pytest.raises(ValueError, match=r"plies\.v is not the array"):
        write_bytes(other, {name: b for name, b in saved.items() if name != "plies.v"})


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


def test_what_acts_goes_on_where_it_is_when_a_run_is_extended(tmp_path):
    """Pressures and forces may not jump; the press keeps its pace, however long its run."""
    loaded().run(tmp_path / "run", frames=2)

    def later(**changes):
        return dataclasses.replace(loaded(), duration=6e-3, **changes)

    air = loaded().pressures[0]
    jump = dataclasses.replace(air, pressure=[(1e-3, 0.0), (4e-3, 900.0)])
    plate = loaded().tools[2]
    harder = dataclasses.replace(plate, motion=dataclasses.replace(plate.motion, force=9.0))
    heavier = dataclasses.replace(plate, motion=dataclasses.replace(plate.motion, mass=0.5))
    for scene, words in (
        (later(pressures=[jump]), "pressure 'air' would go from -300 to -900 Pa at once"),
        (
            later(tools=[*loaded().tools[:2], harder]),
            "force of tool 'plate' would go from 2 to 9 N",
        ),
        (later(tools=[*loaded().tools[:2], heavier]), "floating of tool 'plate' = "),
        (later(process_duration=5.0), "process_duration over duration = "),
    ):
        with pytest.raises(InputError, match=words):
            scene.run(resume=tmp_path / "run", extend=True)
    longer = later().run(resume=tmp_path / "run", extend=True)
    record = json.loads((tmp_path / "run" / "run.json").read_text("utf-8"))
    assert longer.completed and record["duration_s"] == pytest.approx(6e-3)
    assert record["process_duration_s"] == pytest.approx(6.0)


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


def test_a_run_without_checkpoints_leaves_none(tmp_path):
    press().run(tmp_path / "run", frames=1, checkpoint="none")
    assert not (tmp_path / "run" / "checkpoint.npz").exists()


@pytest.mark.slow
def test_a_run_killed_before_its_first_checkpoint_begins_anew(tmp_path, monkeypatch):
    press().run(tmp_path / "whole", frames=2)
    cut_off(press(), tmp_path / "cut", 0, monkeypatch, frames=2)
    assert not (tmp_path / "cut" / "checkpoint.npz").exists()
    press().run(resume=tmp_path / "cut", frames=2)
    assert_same_folder(tmp_path / "cut", tmp_path / "whole")


@pytest.mark.slow
def test_more_frames_are_those_of_a_run_that_was_longer_from_the_start(tmp_path):
    """With the same steps, as here where both are planned alike, the same to the bit."""
    long = dataclasses.replace(press(), duration=8e-3)
    long.run(tmp_path / "whole", frames=8)
    press().run(tmp_path / "run", frames=4)
    press().run(resume=tmp_path / "run", extend=True, frames=8)
    mine, theirs = (samples(tmp_path / name / "scene.usdc") for name in ("run", "whole"))
    assert mine.keys() == theirs.keys()
    for name, value in mine.items():
        np.testing.assert_array_equal(np.asarray(value), np.asarray(theirs[name]), err_msg=name)
    assert mine["times"] == (0.0, 8.0)


def gone_on(way, start=4e-3, first=(0.002, 0.0, -0.006)):
    """The press with a ball that goes on from where it was."""
    scene, ball = press(), press().tools[1]
    path = Path(times=[start, start + 4e-3], positions=[first, np.add(first, way)])
    tools = [scene.tools[0], dataclasses.replace(ball, motion=path), scene.tools[2]]
    return dataclasses.replace(scene, tools=tools, duration=8e-3)


def test_a_stroke_goes_on_and_what_would_jump_is_refused(tmp_path):
    whole = press().run(tmp_path / "run", frames=4)
    before = {f.name: f.read_bytes() for f in (tmp_path / "run").iterdir()}
    for scene, words in (
        (gone_on((0, 0, -2e-3), first=(0, 0, -6e-3)), "'ball' would jump 2 mm from where it is"),
        (gone_on((0, 0, -0.02)), "cannot be extended at 7.5 m/s: its tools came to 2.2"),
        (press(), "has come to frame 4, 0.004 s: to extend it, give a longer duration"),
        (dataclasses.replace(gone_on((0, 0, -2e-3)), friction=0.1), "friction = 0.1"),
    ):
        with pytest.raises(InputError, match=words):
            scene.run(resume=tmp_path / "run", extend=True)
    after = {f.name: f.read_bytes() for f in (tmp_path / "run").iterdir()}
    assert after == before
    result = gone_on((0, 0, -2e-3)).run(resume=tmp_path / "run", extend=True)
    assert result.completed and len(result.history["time_s"]) == 9
    assert result.history["ball_displacement_m"][-1] == pytest.approx(8e-3, rel=1e-9)
    first = {name: column[:5] for name, column in result.history.items()}
    for name, column in whole.history.items():
        if name != "ball_displacement_m":  # along the way as a whole, which has turned
            np.testing.assert_array_equal(first[name], column)


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
