"""What a user gets from a run that blows up: the place, the last good frame, whole files."""

import csv
import json
import math
import re
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest
from pxr import Usd

import warpdrape as wd
from warpdrape import cli
from warpdrape.dynamics.energy import balance, measure
from warpdrape.dynamics.loading import Loading
from warpdrape.dynamics.stepping import Stepper
from warpdrape.errors import RunFailed
from warpdrape.growth import OF_CONTACTS, why_it_grew
from warpdrape.results.snapshot import read_plies
from warpdrape.scenes import hemisphere
from warpdrape.simulation import prepare
from warpdrape.timing import choose_step
from warpdrape.watch import Watch

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
    assert "last good frame" in said and "never touched" not in said  # the rest did not come
    _check_files_are_whole_and_finite(tmp_path, summary)


def test_energy_from_nowhere(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("warpdrape.dynamics.energy.Energies.unbalanced", 1e9)
    out = str(tmp_path)
    assert cli.main(["run", "hemisphere", "--set", "cells=6", "--out", out, "--quiet"]) == 1
    complaint = capsys.readouterr().err
    assert "energy grew without work at 0 ms" in complaint
    assert "in ply 'ply_0', triangle" in complaint
    assert json.loads((tmp_path / "summary.json").read_text())["status"] == "failed"


def overrun(monkeypatch, times):
    """Take so many times the step that is stable."""
    monkeypatch.setattr(
        "warpdrape.timing.choose_step", lambda scene, stable: times * choose_step(scene, stable)
    )


def loose(scene, safety=1.0):
    """Without what holds yarns still at their corner."""
    numerics = {"yarn_softening": 1.0, "minimum_time_step": None, "yarn_viscosity": 0.0}
    return replace(scene, numerics=replace(scene.numerics, safety=safety, **numerics))


def test_energy_that_grows_is_named_and_the_advice_helps(monkeypatch):
    overrun(monkeypatch, 2.6)
    press = hemisphere.build(cells=8, duration=0.01)
    message = loose(press).run(quiet=True, frames=20).summary["message"]
    assert "energy grew without work" in message and "lower safety" in message
    assert re.search(r"what is fastest is (pressed by tool|touching nothing)", message)
    assert "most of the energy came as " in message
    assert loose(press, safety=0.4).run(quiet=True, frames=3).completed


def test_growth_is_laid_to_the_tools_that_press_there():
    scene = hemisphere.build(cells=8, duration=1e-4)
    model, state = prepare(scene, "cpu", 1)
    with closing(Stepper(model, state, 1)) as stepper:
        stepper.begin(Loading(model.scene, model.timing).stretch(1))
        for _ in range(60):
            stepper.block()
    measured = measure(model, state)
    pressed = sum(each.pressing.get("tool_pressure", 0.0) for each in measured) > 0.0
    names = [f"tool {tool.name!r}" for tool in scene.tools]
    for vertex in (int(np.argmax(pressed.sum(axis=0))), int(np.argmin(pressed.sum(axis=0)))):
        said = why_it_grew(scene, {"motion": 1.0, "energy of contacts": 0.5}, measured, 0, vertex)
        touching = [name for row, name in enumerate(names) if pressed[row, vertex]]
        assert [name for name in names if name in said] == touching
        assert ("touching nothing" in said) == (not touching)
        assert ("contact_share" in said) == bool(touching)
    assert "refine ply 'ply_0'" in why_it_grew(scene, {OF_CONTACTS[0]: 1.0}, measured, 0, vertex)


def test_what_was_there_a_frame_before_has_not_grown():
    """Friction that lost 5 kJ on the way is not what 1 kJ of motion came as."""
    scene = hemisphere.build(cells=6, duration=0.005)
    model, state = prepare(scene, "cpu", 1)
    measured = measure(model, state)
    rest = balance(model, state, measured)
    rubbed = replace(rest, friction=5e3, tool_work=rest.tool_work + 5e3)
    plies = read_plies(model, state, measured)
    watch = Watch(model)
    watch.look(state, plies, rubbed, measured, 0.0)
    with pytest.raises(RunFailed, match="most of the energy came as motion"):
        watch.look(state, plies, replace(rubbed, kinetic=1e3), measured, 1e-3)


@pytest.mark.parametrize(("times", "words"), [(2.4, "energy grew without"), (4.0, "blew up")])
def test_without_tools_nothing_is_laid_to_contact(times, words, monkeypatch):
    overrun(monkeypatch, times)
    sheet = wd.Ply.rectangle("sheet", "carbon_interlock", 0.1, cells=4)
    held = wd.Clamp(name="held", ply="sheet", where=lambda points: points[:, 0] < -0.049)
    scene = wd.Scene(name="flag", plies=[sheet], clamps=[held], gravity=(0, 0, -9.81), duration=0.1)
    message = loose(scene).run(quiet=True, frames=1000).summary["message"]
    assert words in message and "; lower safety" in message
    assert "contact" not in message and "tool" not in message
    assert loose(scene, safety=0.25).run(quiet=True, frames=10).completed


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
