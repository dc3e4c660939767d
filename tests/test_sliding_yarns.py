"""Whole runs of yarns that slide: coupons, presses, threads; what cannot be is refused."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from law_checks import PLAIN, fabric
from sliding_checks import COUPLE, FREE, HOLD, YARNS, Led, blank, cloth, scene_of
from test_engine import small_press
from test_threads import assert_same_bits, state_after

import warpdrape as wd
from warpdrape.blanks.yarn_chains import chain_yarns
from warpdrape.coupons.coupon import steady_pull
from warpdrape.errors import InputError
from warpdrape.forces.ply_net import net_of
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.numerics import Numerics
from warpdrape.scenes import bias_extension, biaxial_tension, hemisphere
from warpdrape.setup import Clamp


def test_bias_extension_with_strong_crossovers_is_that_of_pinned_ones():
    material = dataclasses.replace(
        load_fabric("carbon_interlock"),
        bending=None,
        compressive_factor=1.0,
        crossover=wd.Crossover(**HOLD | FREE | {"stiffness_warp": 1e7, "stiffness_weft": 1e7}),
    )
    small = {"edge": 0.025, "shear_angle_deg": 30.0, "duration": 0.03}
    result = bias_extension.build(fabric=material, approach="sliding_yarns", **small).run(frames=40)
    assert abs(result.summary["coupon"]["force_error"]) < 0.01  # as asked at 30°
    assert result.summary["energy_error"] < 1e-3
    assert 0.0 < np.abs(result.plies[0].yarn_slide).max() < 1e-5


def test_what_a_fabric_lacks_is_said():
    ply = blank(fabric(YARNS, COUPLE))
    scene = scene_of(ply)
    with pytest.raises(InputError, match=r"needs the \[crossover\] of fabric 'test' of ply 'p'"):
        scene.run()
    assert dataclasses.replace(scene, approach="yarns", duration=1e-4).run(frames=1).completed


def test_biaxial_tension_with_crimp_is_that_of_the_closed_form():
    """Crossovers that hold: nothing slides in a uniform stretch, and families pull each other."""
    material = dataclasses.replace(
        load_fabric("synthetic_plain_crimp"), crossover=wd.Crossover(**HOLD | FREE)
    )
    ends = {"warp_strain": 0.008, "weft_strain": 0.004, "edge": 0.025, "duration": 0.01}
    scene = biaxial_tension.build(fabric=material, approach="sliding_yarns", **ends)
    result = scene.run(frames=10)
    coupon = result.summary["coupon"]
    for family in ("warp", "weft"):
        exact = coupon[f"closed_form_{family}_force_n"]
        assert exact > 1000.0 and coupon[f"{family}_force_n"] == pytest.approx(exact, rel=1e-3)
    assert result.summary["energy_error"] < 1e-3


def test_a_yarn_of_crimp_is_drawn_through_the_weft_that_it_waves_round():
    """Its end pulled, the weft held at both sides: F is the sum of what the crossings take."""
    material = cloth(PLAIN, factor=0.01, **{**HOLD, "slip_force_warp": 0.5, "slip_force_weft": 5.0})
    ply = blank(material, cells=4, mesh="diagonal")
    clamps = [
        Clamp(name="sides", ply="p", where=lambda p: np.abs(p[:, 1]) > 0.0149, yarns="held"),
        Clamp(
            name="end",
            ply="p",
            where=lambda p: (p[:, 0] > 0.0149) & (np.abs(p[:, 1]) < 1e-6),
            motion=steady_pull((1e-3, 0.0, 0.0), 6e-3),
            follow=(1.0, 0.0, 0.0),
        ),
    ]
    scene = scene_of(ply, clamps=clamps, numerics=Numerics(damping=500.0))
    result = dataclasses.replace(scene, duration=6e-3, gravity=(0.0, 0.0, 0.0)).run(frames=12)
    assert result.completed and result.summary["energy_error"] < 2e-3
    chains, slip = chain_yarns(net_of(ply)), result.history["yarn_slip_j"]
    slide = result.plies[0].yarn_slide[chains.vertices]
    at = ply.rest_points[chains.vertices]
    middle = (np.abs(at[:, 1]) < 1e-6) & (at[:, 0] < 0.0149)
    assert slide[middle, 0].max() < -1e-4  # towards +x
    crossings = chains.areas[middle] / material.cell_area
    lost = 0.5 * crossings * (-slide[middle, 0] - 0.5 / HOLD["stiffness_warp"])
    assert slip[-1] == pytest.approx(lost.sum(), rel=0.1)  # less where the yarn's end went by
    assert slip[-1] < lost.sum() and slip[-1] > 0.3 * result.history["end_work_j"][-1]


def sliding_press(aligned=True, **changes):
    """Two plies on a table, whose crossovers slip early."""
    hold = {"slip_force_warp": 2e-3, "slip_force_weft": 2e-3}
    hold |= {"stiffness_warp": 100.0, "stiffness_weft": 100.0, "friction": 0.1}
    plies, square = [], small_press().plies[0].mesh
    for ply in small_press().plies:
        angle = ply.warp_angle if aligned else 0.0
        mesh = blank(cells=12, mesh="aligned", warp_angle=angle).mesh if aligned else square
        material = dataclasses.replace(ply.fabric, crossover=wd.Crossover(**hold))
        plies.append(dataclasses.replace(ply, mesh=mesh, fabric=material, warp_angle=angle))
    return small_press(plies=plies, clamps=[], approach="sliding_yarns", **changes)


def test_threads_compute_what_one_part_after_another_does():
    scene = sliding_press()
    together, _ = state_after(2, True, scene, blocks=40)
    alone, _ = state_after(2, False, scene, blocks=40)
    assert_same_bits(together, alone)
    slides = [values for name, values in together.items() if name.endswith(".slides")]
    assert len(slides) == 2 and all(values["s"].any() for values in slides)


def test_a_press_balances_its_energy_and_shows_its_slides():
    result = sliding_press().run(frames=3)
    assert result.completed and result.summary["energy_error"] < 0.01
    history = result.history
    assert history["yarn_slip_j"][-1] > 1e-4 * history["external_work_j"][-1]
    assert (np.diff(history["yarn_slip_j"]) > 0.0).all() and history["crossover_j"][-1] > 0.0
    assert history["yarn_motion_j"][-1] < 0.01 * history["external_work_j"][-1]
    for ply in result.plies:
        assert ply.yarn_slide.shape == (len(ply.points), 2)
        frame = ply.frame()
        np.testing.assert_array_equal(frame.weft_slide, ply.yarn_slide[:, 1])


def test_selective_mass_scaling_keeps_its_step():
    numerics = Numerics(mass_scaling="selective", minimum_time_step=1.2e-5)
    result = sliding_press(aligned=False, numerics=numerics).run(frames=3)
    assert result.completed and result.summary["energy_error"] < 0.02
    assert result.summary["stable_time_step_s"] >= 1.2e-5


def test_crossovers_that_crowd_are_warned_of():
    material = cloth(slip_force_warp=1e-6, slip_force_weft=1e-6)
    led = Led(blank(material))
    chains = led.of.chains
    slide = np.zeros((len(led.scene.plies[0].mesh.vertices), 2))
    assert led.of.warnings(slide) == []
    first = np.flatnonzero(chains.family == 0)[0]
    slide[chains.ends[first, 1], 0] = -0.25 * chains.lengths[first]
    (words,) = led.of.warnings(slide)
    assert words.startswith(
        f"1 of {len(chains.ends)} bars of ply 'p' have let so much yarn out, 25 %"
    )
    slide[chains.ends[first, 1], 0] = -10.0 * chains.lengths[first]  # its end has gone by
    assert led.of.warnings(slide) == []


def test_a_press_softens_yarns_that_slide_less():
    """What they stretch they do not slide; an accuracy that softens none, and others, as ever."""
    material = load_fabric(Path(__file__).parents[1] / "examples" / "sliding_interlock.toml")
    for accuracy, softening in (("draft", 9.0), ("standard", 9.0), ("reference", 1.0)):
        built = {"fabric": material, "accuracy": accuracy, "cells": 6}
        scene = hemisphere.build(approach="sliding_yarns", **built)
        assert scene.numerics.yarn_softening == softening
        scene = hemisphere.build(approach="yarns", **built)
        assert scene.numerics.yarn_softening == (1.0 if accuracy == "reference" else 100.0)


@pytest.mark.slow
def test_coupled_laws_in_a_press_are_those_of_pinned_yarns_where_nothing_slides():
    """Crossings that hold 100 N: shear, draw-in, force and energy of the press as of `yarns`."""
    held = {name: 2e7 if "stiff" in name else 100.0 for name in HOLD}
    card = load_fabric("synthetic_plain_crimp")
    results = []
    for approach, hold in (("yarns", held), ("sliding_yarns", held), ("sliding_yarns", HOLD)):
        scene = hemisphere.build(
            cells=6,
            approach=approach,
            fabric=dataclasses.replace(card, crossover=wd.Crossover(**hold)),
        )
        numerics = dataclasses.replace(scene.numerics, yarn_softening=9.0, yarn_recovery=0.0)
        results.append(dataclasses.replace(scene, numerics=numerics).run(frames=6))
        assert results[-1].completed and results[-1].summary["energy_error"] < 0.01
    pinned, stuck, loose = (result.summary["plies"][0] for result in results)
    assert pinned["max_shear_deg"] > 30.0
    assert stuck["max_shear_deg"] == pytest.approx(pinned["max_shear_deg"], abs=0.2)
    for name in ("warp", "bias"):
        assert stuck["draw_in_m"][name] == pytest.approx(pinned["draw_in_m"][name], abs=2e-4)
    one, other, _ = (result.history["punch_force_n"].max() for result in results)
    assert other == pytest.approx(one, rel=0.01)
    assert stuck["max_slide_warp_m"] < 1e-7 < loose["max_slide_warp_m"]
