"""What a user gets from a run that blows up: the place, the last good frame, whole files."""

import csv
import json
import math

import numpy as np
import pytest
from pxr import Usd

from warpdrape import cli
from warpdrape.scenes import hemisphere
from warpdrape.timing import choose_step

SMALL = {"cells": 6, "duration": 0.005, "accuracy": "reference", "brake": 0.3}


@pytest.mark.parametrize("factor", [3.0, 20.0])
def test_a_run_that_blows_up(factor, tmp_path, capsys, monkeypatch):
    """Three times the stable step blows up after a frame or so, twenty times at once."""

    def unstable(scene, stable):
        return factor * choose_step(scene, stable)

    monkeypatch.setattr("warpdrape.timing.choose_step", unstable)
    settings = [f"--set={name}={value}" for name, value in SMALL.items()]
    argv = ["run", "hemisphere", *settings, "--out", str(tmp_path), "--frames", "10", "--quiet"]
    assert cli.main(argv) == 1
    said, complaint = capsys.readouterr()
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert summary["status"] == "failed"
    assert complaint == f"warpdrape: error: {summary['message']}\n"
    for words in ("in ply 'ply_0', triangle ", "lower safety"):
        assert words in summary["message"]
    when = float(summary["message"].split(" at ")[1].split(" ms")[0]) * 1e-3
    duration = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))["duration_s"]
    assert summary["simulated_s"] < when < duration
    assert when - summary["simulated_s"] < 1.01 * duration / 10
    assert "last good frame" in said
    _check_files_are_whole_and_finite(tmp_path, summary)


def test_energy_from_nowhere(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("warpdrape.dynamics.energy.Energies.unbalanced", 1e9)
    out = str(tmp_path)
    assert cli.main(["run", "hemisphere", "--set", "cells=6", "--out", out, "--quiet"]) == 1
    complaint = capsys.readouterr().err
    assert "energy grew without work at 0 ms" in complaint
    assert "in ply 'ply_0', triangle" in complaint
    assert json.loads((tmp_path / "summary.json").read_text())["status"] == "failed"


def test_a_number_that_is_not_finite_never_reaches_the_files(tmp_path, capsys, monkeypatch):
    from warpdrape.simulation import Stepper

    block = Stepper.block

    def spoil(self):
        block(self)
        if 3 * self._state.step.numpy()[0] > 2 * self._model.timing.steps_per_frame:
            shift = self._state.tools.shift.numpy()
            if shift[0, 2] < -0.02:  # past the first frames
                self._state.tools.impulse.fill_(math.nan)

    monkeypatch.setattr(Stepper, "block", spoil)
    settings = [f"--set={name}={value}" for name, value in SMALL.items()]
    argv = ["run", "hemisphere", *settings, "--out", str(tmp_path), "--frames", "5", "--quiet"]
    assert cli.main(argv) == 1
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert "punch_force_n is nan" in summary["message"]
    assert summary["simulated_s"] > 0.0
    _check_files_are_whole_and_finite(tmp_path, summary)


@pytest.mark.parametrize("which", ["strain", "line_tension"])
def test_a_triangle_that_is_not_finite_is_named(which, tmp_path, monkeypatch):
    from warpdrape.recorder import measure

    frames = []

    def spoilt(model, state):
        measured = measure(model, state)
        frames.append(1)
        if len(frames) > 3:
            measured[0].fields[0][which][17, 1] = math.nan
        return measured

    monkeypatch.setattr("warpdrape.recorder.measure", spoilt)
    result = hemisphere.build(**SMALL).run(tmp_path, frames=5)
    message = result.summary["message"]
    assert "in ply 'ply_0', triangle 17: its values are not finite" in message
    assert len(result.history["time_s"]) == 3
    _check_files_are_whole_and_finite(tmp_path, result.summary)


def _check_files_are_whole_and_finite(folder, summary):
    assert sorted(f.name for f in folder.iterdir()) == [
        "checkpoint.npz",
        "history.csv",
        "run.json",
        "scene.usdc",
        "summary.json",
    ]
    for name in ("summary.json", "run.json"):
        text = (folder / name).read_text(encoding="utf-8")
        assert "NaN" not in text and "Infinity" not in text
    with open(folder / "history.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert float(rows[-1]["time_s"]) == pytest.approx(summary["simulated_s"])
    assert np.isfinite([float(value) for row in rows for value in row.values()]).all()
    stage = Usd.Stage.Open(str(folder / "scene.usdc"))
    assert stage.GetEndTimeCode() == len(rows) - 1
    points = stage.GetPrimAtPath("/World/plies/ply_0").GetAttribute("points")
    for time in range(len(rows)):
        assert np.isfinite(np.array(points.Get(time))).all()
