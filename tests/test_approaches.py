"""A scene's approach: chosen by name, run and recorded like the others, refused where it cannot."""

import dataclasses
import json
from dataclasses import replace

import numpy as np
import pytest
from test_engine import small_press
from test_hypoelastic import SHEET
from test_threads import assert_same_bits, state_after

import warpdrape as wd
from warpdrape import Numerics, Ply, Scene
from warpdrape.approaches import APPROACHES
from warpdrape.cli import main
from warpdrape.dynamics.interactions import MEMBRANES
from warpdrape.errors import InputError
from warpdrape.scenes import circular_table, hemisphere, picture_frame

STRESSED = ("green_naghdi", "fibre_frame")


def formed(approach, **changes):
    small = {"cells": 6, "travel": 0.05, "duration": 0.02, "fast": True}
    scene = hemisphere.build(approach=approach, **{**small, **changes})
    numerics = replace(scene.numerics, yarn_softening=36.0, yarn_recovery=0.0)  # that all know
    return replace(scene, numerics=numerics).run(frames=5)


def test_every_approach_of_the_dynamics_has_its_membrane():
    assert set(MEMBRANES) == {n for n, m in APPROACHES.items() if m == "warpdrape.simulation"}


def test_a_hemisphere_in_the_yarns_frame_is_the_semi_discrete_one():
    """Within 0.5° and 1 mm, as asked; in that of Green and Naghdi yarns stretch instead."""
    one, other, polar = map(formed, ("semi_discrete", "fibre_frame", "green_naghdi"))
    apart = np.abs(one.plies[0].shear_angle_deg - other.plies[0].shear_angle_deg)
    assert one.plies[0].max_shear_deg > 10.0 and apart.max() < 0.5
    assert np.abs(one.plies[0].points - other.plies[0].points).max() < 1e-3
    energy = [result.history["internal_j"][-1] for result in (one, other)]
    assert energy[1] == pytest.approx(energy[0], rel=0.02)  # stored, and work on the stresses
    for result in (one, other, polar):
        assert result.summary["energy_error"] < 0.02
        assert result.history["yarn_j"][-1] > 0.0 and result.history["shear_j"][-1] > 0.0
        assert np.isfinite(result.plies[0].line_tension).all()
    strains = [result.plies[0].strain.max() for result in (one, other, polar)]
    assert strains[1] == pytest.approx(strains[0], rel=0.1)
    assert strains[2] > 5.0 * strains[0]
    warned = [
        "did not turn with the yarns" in str(r.summary["warnings"]) for r in (one, other, polar)
    ]
    assert warned == [False, False, True]


@pytest.mark.parametrize("approach", STRESSED)
def test_threads_compute_what_one_part_after_another_does(approach):
    scene = small_press(approach=approach)
    together, _ = state_after(2, True, scene, blocks=40)
    alone, _ = state_after(2, False, scene, blocks=40)
    assert_same_bits(together, alone)
    assert any("patches" in name and values["tension"].any() for name, values in together.items())


@pytest.mark.parametrize("approach", STRESSED)
def test_selective_mass_scaling_keeps_its_step(approach):
    numerics = Numerics(mass_scaling="selective", minimum_time_step=1.2e-5)
    scene = small_press(numerics=numerics, clamps=[], approach=approach)
    result = scene.run(frames=3)
    assert result.completed and result.summary["energy_error"] < 0.02
    assert result.summary["stable_time_step_s"] >= 1.2e-5


def test_the_picture_frame_is_far_too_stiff_in_the_frame_of_r():
    """By its closed form for yarns that resist compression a hundredth: see docs/approaches.md."""
    small = {"edge": 0.05, "mesh": "crossed", "shear_angle_deg": 20.0, "duration": 0.02}
    force = {
        approach: picture_frame.build(approach=approach, **small)
        .run(frames=4)
        .history["frame_force_n"]
        for approach in ("semi_discrete", *STRESSED)
    }
    assert force["fibre_frame"][-1] == pytest.approx(force["semi_discrete"][-1], rel=0.01)
    assert force["green_naghdi"][-1] > 30.0 * force["semi_discrete"][-1]


def test_an_isotropic_sheet_has_no_yarns_to_follow():
    ply = Ply.rectangle("sheet", SHEET, 0.02, cells=1)
    scene = Scene(name="sheet", plies=[ply], duration=1e-4, approach="fibre_frame")
    with pytest.raises(InputError, match=r"'fibre_frame' follows yarns, .*'sheet' is an isotropic"):
        scene.run()
    assert dataclasses.replace(scene, approach="green_naghdi").run(frames=1).completed


def test_an_unknown_approach_is_refused_with_the_nearest(capsys):
    with pytest.raises(InputError, match=r"unknown approach 'fiber_frame'.*fibre_frame"):
        hemisphere.build(approach="fiber_frame")
    assert main(["run", "hemisphere", "--set", "approach=green-naghdi"]) == 2
    assert "green_naghdi" in capsys.readouterr().err


def test_a_run_says_by_which_approach_and_goes_on_by_no_other(tmp_path):
    scene = small_press(duration=2e-4, approach="fibre_frame")
    scene.run(tmp_path / "run", frames=2)
    record = json.loads((tmp_path / "run" / "run.json").read_text("utf-8"))
    summary = json.loads((tmp_path / "run" / "summary.json").read_text("utf-8"))
    assert record["approach"] == summary["approach"] == "fibre_frame"
    other = dataclasses.replace(scene, approach="green_naghdi")
    with pytest.raises(InputError, match="approach = 'green_naghdi', the run's 'fibre_frame'"):
        other.run(resume=tmp_path / "run")


def test_a_sheet_on_a_table_takes_it_too():
    assert (
        circular_table.build(approach="green_naghdi", case="isotropic").approach == "green_naghdi"
    )


@pytest.mark.parametrize("approach", ["green_naghdi", "fibre_frame", "fishnet"])
def test_rubber_is_refused_with_the_approach_that_takes_it(approach):
    bag = wd.Fabric.rubber("bag", thickness=1e-3, density=1150.0, c10=1e5)
    ply = wd.Ply.rectangle("bag", bag, 0.1, cells=4, z=0.02)
    plate = wd.Tool.plate(width=0.3, height=0.3)
    scene = wd.Scene(name="bag", plies=[ply], tools=[plate], duration=0.01, approach=approach)
    with pytest.raises(wd.InputError, match=r"'bag'.*: take approach = 'semi_discrete'"):
        scene.run(frames=1)
    assert dataclasses.replace(scene, approach="semi_discrete").run(frames=1).completed
