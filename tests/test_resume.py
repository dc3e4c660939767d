"""A run that was cut off goes on from its checkpoint to the same result, to the last bit."""

import dataclasses
import json
import math
import shutil
import signal

import numpy as np
import pytest
from resume_checks import SCENES, assert_same_folder, cut_between, cut_off, press, timeless

from warpdrape.cadence import read_cadence
from warpdrape.dynamics.stepping import Stepper
from warpdrape.errors import InputError, RunFailed
from warpdrape.recorder import Recorder
from warpdrape.restart import read_restart

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
