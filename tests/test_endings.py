"""However a run ends, its status, its message, its warnings and its exit status say the same."""

import json
from dataclasses import replace

import numpy as np
import pytest

import warpdrape as wd
from warpdrape import cli
from warpdrape.dynamics.stepping import Stepper
from warpdrape.errors import RunFailed
from warpdrape.results.quasi_static import LEAST_LOADED, was_loaded
from warpdrape.results.summary_text import summary_text
from warpdrape.results.usd import UsdWriter
from warpdrape.scenes import hemisphere
from warpdrape.timing import choose_step

SMALL = {"cells": 4, "duration": 0.002}


def broken(*_):
    raise ZeroDivisionError("of the\n  scene")


def held_ply(**options):
    """A ply that two clamps hold at rest: nothing is loaded."""
    ply = wd.Ply.rectangle("p", "carbon_interlock", 0.1, cells=2)
    clamp = wd.Clamp(name="all", ply="p", where=lambda p: p[:, 0] < 0.0, **options)
    return wd.Scene(name="held", plies=[ply], clamps=[clamp], duration=1e-3, gravity=(0, 0, 0))


def spoil(monkeypatch, how):
    """Let runs end in some way."""
    if how in ("blown up", "unstable"):
        monkeypatch.setattr("warpdrape.timing.choose_step", lambda s, dt: 20 * choose_step(s, dt))
    if how == "energy at the end":
        monkeypatch.setattr("warpdrape.results.soundness.energy_error", lambda *_: 0.5)
    if how == "energy at once":
        monkeypatch.setattr("warpdrape.dynamics.energy.Energies.unbalanced", 1e9)
    errors = {"interrupted": KeyboardInterrupt(), "a fault of ours": ValueError("odd")}
    if how in errors:

        def block(self):
            raise errors[how]

        monkeypatch.setattr(Stepper, "block", block)
    if how == "disk full":

        def save(self):
            if not self._spoilt:
                self._spoilt = True
                raise RunFailed("no room for scene.usdc: free some space")

        monkeypatch.setattr(UsdWriter, "save", save)


@pytest.mark.parametrize(
    ("how", "status", "words"),
    [
        ("well", "completed", "not quasi-static"),
        ("report broken", "completed", "report failed: ZeroDivisionError: of the scene"),
        ("files broken", "completed", "files could not be written: ZeroDivisionError"),
        ("blown up", "failed", "blew up at"),
        ("unstable", "failed", "lower safety"),  # not that a floating holder leaves no room
        ("energy at the end", "failed", "50.0 % of the energy is unbalanced"),
        ("energy at once", "failed", "energy grew without work"),
        ("interrupted", "failed", "interrupted by the user"),
        ("a fault of ours", "failed", "stopped by an unexpected ValueError: odd"),
        ("disk full", "failed", "no room for scene.usdc"),
    ],
)
def test_status_and_message_agree(how, status, words, tmp_path, monkeypatch, capsys):
    longer = {"duration": 0.02} if how == "blown up" else {}
    scene = hemisphere.build(**{**SMALL, **longer})
    if how == "report broken":
        scene = replace(scene, report=broken)
    if how == "files broken":
        scene = replace(scene, write=broken)
    spoil(monkeypatch, how)
    monkeypatch.setattr("warpdrape.scenes.hemisphere.build", lambda: scene)
    argv = ["run", "hemisphere", "--out", str(tmp_path), "--frames", "3", "--quiet"]
    ended = cli.main(argv)
    said, complaint = capsys.readouterr()
    summary = json.loads((tmp_path / "summary.json").read_text("utf-8"))
    assert summary["status"] == status
    assert words in summary["message"] and "\n" not in summary["message"]
    assert (ended == 0) == (status == "completed")
    assert bool(complaint) == (status == "failed")
    if "warnings" not in summary or not said:
        return
    if status == "completed":
        assert summary["message"] == "; ".join(summary["warnings"])
    else:
        assert summary["message"] not in summary["warnings"]
    assert summary_text(summary).startswith(status.capitalize())
    assert all(f"warning: {warning}" in said for warning in summary["warnings"])


def test_a_run_without_fault_says_completed_only(tmp_path):
    result = hemisphere.build(cells=8, travel=0.01, duration=0.1).run(frames=10)
    assert result.summary["warnings"] == []
    assert (result.summary["status"], result.summary["message"]) == ("completed", "completed")


@pytest.mark.parametrize("away", [(0.0, 0.0, 0.0), (0.0, 0.0, 1e-9)])
def test_where_nothing_was_loaded_no_longer_duration_is_asked_for(away):
    result = held_ply(motion=wd.Stroke(travel=away, duration=1e-3)).run(frames=2)
    summary = result.summary
    assert result.completed and not summary["loaded"] and not summary["quasi_static"]
    (warning,) = summary["warnings"]
    assert warning.startswith("nothing was loaded: the plies stored at most")
    assert "lengthen" not in summary["message"]
    assert "no ply was stretched, sheared or bent" in summary_text(summary)
    assert "NOT quasi-static" not in summary_text(summary)


def test_a_hasty_load_is_still_called_hasty():
    summary = held_ply(motion=wd.Stroke(travel=(0, 0, 1e-3), duration=1e-3)).run(frames=2).summary
    assert summary["loaded"] and not summary["quasi_static"]
    assert "lengthen the duration" in summary["message"]
    assert " at the end: NOT quasi-static" in summary_text(summary | {"kinetic_ratio_loaded": 0.09})
    calm_end = summary | {"kinetic_ratio": 4e-4, "kinetic_ratio_loaded": 0.19}
    words = "internal energy 0.04 % at the end, 19 % in the mean under load: NOT quasi-static"
    assert words in summary_text(calm_end)


def test_loaded_is_a_thousandth_of_the_shear_that_counts_as_hardly_loaded():
    for share, loaded in ((0.9, False), (1.1, True)):
        history = {"internal_j": np.array([0.0, share * LEAST_LOADED * 3.0, 0.0])}
        assert was_loaded(history, 3.0) is loaded
