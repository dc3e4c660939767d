"""Long runs say what they will take, and take no more memory with more frames."""

import re

import numpy as np
import psutil
import pytest
from pxr import Usd

from warpdrape import announcement
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.results.usd import PlyFrame, PlyShape, UsdWriter
from warpdrape.scenes import hemisphere
from warpdrape.state import all_arrays

VERTICES, TRIANGLES, MARKED = 20_000, 40_000, 20
FRAME_MB = (12 * VERTICES + announcement.PER_TRIANGLE * TRIANGLES) / 1e6


def test_memory_does_not_grow_with_frames(tmp_path, monkeypatch):
    monkeypatch.setattr("warpdrape.results.usd.SAVE_EVERY", 0.0)
    chance = np.random.default_rng(0)
    triangles = chance.integers(0, VERTICES, (TRIANGLES, 3))
    shape = PlyShape("ply_0", chance.random((VERTICES, 3)), triangles)
    directions = chance.random((TRIANGLES, 3))
    taken = []
    with UsdWriter(tmp_path / "scene.usdc", [shape]) as writer:
        for frame in range(3 * MARKED):
            values = [chance.random(TRIANGLES) for _ in range(5)]
            points = chance.random((VERTICES, 3))
            writer.write(frame, 0.1 * frame, [PlyFrame(points, directions, directions, *values)])
            taken.append(psutil.Process().memory_full_info().uss / 1e6)
    written = (tmp_path / "scene.usdc").stat().st_size / 1e6
    assert written > 3 * MARKED * 0.5 * FRAME_MB
    assert taken[-1] - taken[MARKED] < 4 * FRAME_MB  # of 2 · MARKED frames since
    assert Usd.Stage.Open(str(tmp_path / "scene.usdc")).GetEndTimeCode() == 3 * MARKED - 1


def test_a_long_run_says_what_it_will_take_and_changes_nothing(monkeypatch):
    scene = hemisphere.build(cells=6)
    model = build_model(scene, "cpu", 10)
    state = initial_state(model)
    before = {name: array.numpy().tobytes() for name, array, _ in all_arrays(state)}
    short = announcement.announcement(model, state, 0, written=False)
    assert re.fullmatch(
        rf"{model.timing.steps:,} steps of [\d.]+ µs, [\d.]+ [MG]B of memory", short
    )
    monkeypatch.setattr(announcement, "LONG", 0.0)
    monkeypatch.setattr(announcement, "time_phases", lambda *_: {"a": 2e-3, "b": 1e-3})
    half = announcement.announcement(model, state, 5, written=True)
    seconds = 3e-3 * model.timing.steps / 2
    words = announcement.in_words(seconds)
    assert f"{model.timing.steps // 2:,} steps" in half and f", {words} or more on one" in half
    monkeypatch.undo()
    monkeypatch.setattr(announcement, "LONG", 0.0)
    assert "or more on one thread" in announcement.announcement(model, state, 0, written=True)
    assert before == {name: array.numpy().tobytes() for name, array, _ in all_arrays(state)}


@pytest.mark.slow
def test_the_space_that_was_announced_is_what_frames_take(tmp_path):
    sizes = []
    for frames in (2, 12):
        scene = hemisphere.build(cells=10, duration=0.01)
        scene.run(tmp_path, frames=frames, overwrite=True)
        sizes.append((tmp_path / "scene.usdc").stat().st_size)
    each = announcement.frame_bytes(build_model(scene, "cpu", 2))
    assert 0.6 < (sizes[1] - sizes[0]) / (10 * each) < 1.05  # what is zero takes no space
