"""Yarns as chains of bars against closed forms: coupons, pull-out with slip."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from warpdrape.materials.crossover import Crossover
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.verification.case import CaseResult, absolute, relative

RISE = {"slip_force": 1.0, "stiffness": 2e5, "length": 0.05, "sides": 1, "travel": 6e-5}
"""A pull-out up to where the whole bundle slips, held so stiffly that it slips crossing by crossing
(β L = 3)."""
ANGLE_DEG = 30.0
HOLDING = Crossover(
    slip_force_warp=100.0, slip_force_weft=100.0, stiffness_warp=1e6, stiffness_weft=1e6
)
"""Crossings that let nothing through, in a stretch that is alike everywhere."""


def yarns(quick: bool) -> Iterator[CaseResult]:
    """All cases of this file."""
    yield from coupons(quick)
    yield from pull_out(quick)


def coupons(quick: bool) -> Iterator[CaseResult]:
    """Pinned crossovers: picture frame and bias extension at 30°, biaxial tension with crimp."""
    from warpdrape.scenes import bias_extension, biaxial_tension, picture_frame

    at_30 = {"approach": "yarns", "shear_angle_deg": ANGLE_DEG}
    inextensible = replace(load_fabric("carbon_interlock"), compressive_factor=1.0, bending=None)
    edge = 0.025 if quick else 0.0125
    for words, scene in (
        ("picture frame", picture_frame.build(edge=2 * edge, duration=0.08, **at_30)),
        (
            "bias extension",
            bias_extension.build(fabric=inextensible, edge=edge, duration=0.05, **at_30),
        ),
    ):
        coupon = scene.run(frames=40).summary["coupon"]
        force, exact = coupon["force_n"], coupon["closed_form_force_n"]
        yield relative(f"bars of yarns: {words}, force at 30°", force, exact, 0.01, "N")
    held = replace(load_fabric("synthetic_plain_crimp"), crossover=HOLDING)
    for bars, approach in (("bars of yarns", "yarns"), ("yarns that slide", "sliding_yarns")):
        scene = biaxial_tension.build(
            fabric=held, approach=approach, weft_strain=0.004, edge=edge, duration=0.01
        )
        coupon = scene.run().summary["coupon"]
        for family in ("warp", "weft"):
            force, exact = coupon[f"{family}_force_n"], coupon[f"closed_form_{family}_force_n"]
            words = f"{bars}: biaxial tension with crimp, {family} force"
            yield relative(words, force, exact, 1e-3, "N")


def pull_out(quick: bool) -> Iterator[CaseResult]:
    """A bundle pulled out of a patch: its rise on ever finer meshes, and its fall."""
    from warpdrape.scenes import yarn_pull_out

    off, meshes = [], (4, 8) if quick else (4, 8, 16)
    for squares in meshes:
        parameters = RISE | {"edge": RISE["length"] / squares}
        scene = yarn_pull_out.build(duration=0.004, **parameters)
        measured, exact = _forces(scene)
        off.append(float(np.abs(measured - exact).max() / exact.max()))
        words = f"yarn pull-out, {squares} squares: rise of the force, worst error over the largest"
        yield absolute(words, off[-1], 0.0, 0.03 * (4.0 / squares) ** 2 + 1e-3)
    rate = math.log(off[0] / off[1]) / math.log(2.0)
    yield absolute("yarn pull-out: rate of the rise's convergence", rate, 2.0, 0.5)
    edge = 0.01 if quick else 0.005
    scene = yarn_pull_out.build(travel=0.035, edge=edge, duration=0.02 if quick else 0.03)
    measured, exact = _forces(scene)
    for part in (0.25, 0.5, 1.0):
        at = int(part * len(exact)) - 1
        name = f"yarn pull-out: force at {100 * exact[at] / exact.max():.0f} % of the largest"
        yield relative(name, float(measured[at]), float(exact[at]), 0.01, "N")


def _forces(scene) -> tuple[np.ndarray, np.ndarray]:
    """Mean forces between frames [N], by the work of the bundle's end and in closed form."""
    from warpdrape.scenes import yarn_pull_out

    result = scene.run(frames=40)
    parameters = scene.parameters
    cloth = scene.plies[0].fabric
    exact = yarn_pull_out.closed_form(cloth, parameters["length"], parameters["edge"])
    pulled, work = result.history["end_displacement_m"], result.history["end_work_j"]
    return np.diff(work) / np.diff(pulled), exact.mean_force(pulled)
