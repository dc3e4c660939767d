"""All fits that a file of tests allows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from warpdrape.calibration.bands import DRAWS, Band
from warpdrape.calibration.bending import LoopFit, StiffnessFit, fit_cantilever, fit_loops
from warpdrape.calibration.biaxial_table import TableFit, fit_table
from warpdrape.calibration.card_file import draft
from warpdrape.calibration.compaction import CompactionFit, fit_compaction, pressed
from warpdrape.calibration.friction import FrictionFit, fit_friction, readings
from warpdrape.calibration.kinds import FACES, FAMILIES
from warpdrape.calibration.polynomial import fit_polynomial
from warpdrape.calibration.preparation import loading_curves
from warpdrape.calibration.shear import (
    Disagreement,
    ShearFit,
    ShearSpecimen,
    alone,
    disagreements,
    fit_shear,
    shear_specimens,
)
from warpdrape.calibration.tension import (
    BiaxialPoints,
    LinearFit,
    YarnCurve,
    fit_crimp,
    fit_failure,
    fit_linear,
    yarn_curve,
)
from warpdrape.calibration.tests_file import Plan
from warpdrape.coupons.coupon import check_woven
from warpdrape.errors import InputError
from warpdrape.materials.fabric import Fabric

SHEAR = ("picture_frame", "bias_extension", "shear_loop")


@dataclass(frozen=True, eq=False)
class Fits:
    """What the tests say; None or empty where there is no test of it.

    Attributes:
        draft: the fabric without what the tests tell, for its cell and its mass.
        shear: the curve that the card has.
        shear_apart: kind of test → the fit of its specimens alone.
        polynomial: coefficients [N/m] and largest distance from the curve, where one is asked for.
        disagreements: between kinds of shear test.
        strips: uniaxial tension curves.
        linear: family → its yarns' stiffness.
        failure: family → strain at which its strips failed.
        biaxial: what biaxial tests measured.
        crimp: crimps [-] and stiffnesses [N] of crimp interchange, where asked for.
        table: tensions over both strains, where asked for.
        cantilevers: family → stiffness.
        loops: family → moment curve.
        friction: "tool" or "ply" → coefficients.
        compaction: thickness under pressure.
    """

    draft: Fabric
    shear: ShearFit | None = None
    shear_apart: Mapping[str, ShearFit] = field(default_factory=dict)
    polynomial: tuple[Band, float] | None = None
    disagreements: tuple[Disagreement, ...] = ()
    strips: tuple[YarnCurve, ...] = ()
    linear: Mapping[str, LinearFit] = field(default_factory=dict)
    failure: Mapping[str, Band] = field(default_factory=dict)
    biaxial: tuple[BiaxialPoints, ...] = ()
    crimp: Band | None = None
    table: TableFit | None = None
    cantilevers: Mapping[str, StiffnessFit] = field(default_factory=dict)
    loops: Mapping[str, LoopFit] = field(default_factory=dict)
    friction: Mapping[str, FrictionFit] = field(default_factory=dict)
    compaction: CompactionFit | None = None


def fit_all(plan: Plan, draws: int = DRAWS) -> Fits:
    """Fit every law that the tests tell.

    Args:
        plan: the tests, read.
        draws: of the bootstrap.

    Raises:
        InputError: a test cannot be used, or a law that is asked for lacks its tests.
    """
    kept = dict(plan.fabric)
    tells = {
        "tension": bool(plan.of("uniaxial_tension", "biaxial_tension")),
        "shear": bool(plan.of(*SHEAR)),
        "bending": bool(plan.of("cantilever", "bending_loop")),
        "compaction": bool(plan.of("compaction")),
    }
    if "tension" not in kept and not tells["tension"]:
        raise InputError(
            f"{plan.file}: no test tells the yarns' tension: add uniaxial or biaxial ones, or give "
            "[fabric.tension]"
        )
    for name, told in tells.items():
        if told:
            kept.pop(name, None)
    if tells["compaction"] and "thickness" not in kept:
        kept["thickness"] = {"value": 1.0, "unit": "mm", "status": "assumed", "source": "to come"}
    cloth = draft(kept, plan.file)
    check_woven(cloth)
    found = {"draft": cloth, **_shear(plan, draws), **_tension(plan, cloth, draws)}
    found |= _bending(plan, cloth, draws)
    friction = {}
    for face in FACES:
        tests = [t for t in plan.of("sled", "friction_table") if t.values["against"] == face]
        if tests:
            friction[face] = fit_friction([r for t in tests for r in readings(t)], draws)
    return Fits(**found, friction=friction, compaction=_compaction(plan, cloth, draws))


def _shear(plan: Plan, draws: int) -> dict:
    apart: dict[str, ShearFit] = {}
    specimens: list[ShearSpecimen] = []
    keep = plan.laws["shear_offset"] == "keep"
    for kind in SHEAR:
        own = [s for test in plan.of(kind) for s in shear_specimens(test)]
        if own:
            apart[kind] = fit_shear(own, keep_offset=keep, draws=draws)
        if plan.laws["shear_from"] in ("both", kind):
            specimens += own
    if not apart:
        return {}
    if not specimens:
        raise InputError(f"{plan.file}: shear_from = {plan.laws['shear_from']!r} has no test")
    kinds = {s.kind for s in specimens}
    one = len(kinds) == 1
    together = [alone(s) for s in specimens]
    shear = apart[kinds.pop()] if one else fit_shear(together, keep_offset=keep, draws=draws)
    polynomial = None
    if plan.laws["shear"] == "polynomial":
        polynomial = fit_polynomial(shear, max(20, draws // 4))
    return {
        "shear": shear,
        "shear_apart": apart,
        "polynomial": polynomial,
        "disagreements": tuple(disagreements(apart)),
    }


def _tension(plan: Plan, cloth: Fabric, draws: int) -> dict:
    law, strips, biaxial = plan.laws["tension"], [], []
    widths = dict(zip(FAMILIES, cloth.yarn_width, strict=True))
    for test in plan.of("uniaxial_tension"):
        family = test.values["family"]
        for curve in loading_curves(test):
            strips.append(
                yarn_curve(test.name, family, curve, test.values["width"], widths[family])
            )
    for test in plan.of("biaxial_tension"):
        for s in test.specimens:
            strains = np.stack([s.columns["strain_warp"], s.columns["strain_weft"]], axis=1)
            forces = np.stack([s.columns["force_warp"], s.columns["force_weft"]], axis=1)
            tensions = forces * np.array(cloth.yarn_width) / test.values["width"]
            biaxial.append(BiaxialPoints(test.name, s.name, strains, tensions, s.weight))
    if not strips and not biaxial:
        return {}
    failed = {f: fit_failure([c for c in strips if c.family == f], draws) for f in FAMILIES}
    failure = {family: band for family, band in failed.items() if band is not None}
    found: dict = {"strips": tuple(strips), "failure": failure, "biaxial": tuple(biaxial)}
    if law == "linear":
        by_family = {f: [c for c in strips if c.family == f] for f in FAMILIES}
        missing = [f for f in FAMILIES if not by_family[f]]
        if missing:
            raise InputError(
                f"{plan.file}: no uniaxial test of {' nor '.join(missing)}: add one for the linear "
                'law, or choose tension = "crimp" or "table" with biaxial tests'
            )
        found["linear"] = {f: fit_linear(c, draws) for f, c in by_family.items()}
    elif not biaxial:
        raise InputError(f'{plan.file}: tension = "{law}" needs a biaxial test: add one')
    elif law == "crimp":
        spacing = np.array([cloth.cell_warp, cloth.cell_weft])
        found["crimp"] = fit_crimp(strips, biaxial, spacing, max(20, draws // 10))
    else:
        found["table"] = fit_table(biaxial, cloth.yarn_width, max(20, draws // 10))
    return found


def _bending(plan: Plan, cloth: Fabric, draws: int) -> dict:
    found: dict = {"cantilevers": {}, "loops": {}}
    for family in FAMILIES:
        hung = [t for t in plan.of("cantilever") if t.values["family"] == family]
        bent = [t for t in plan.of("bending_loop") if t.values["family"] == family]
        if hung:
            found["cantilevers"][family] = fit_cantilever(hung, cloth.areal_density, draws)
        if bent:
            found["loops"][family] = fit_loops(bent, draws)
    curve = plan.laws["bending"] == "curve"
    told = [f for f in FAMILIES if f in found["loops"] or (f in found["cantilevers"] and not curve)]
    if (found["loops"] or found["cantilevers"]) and len(told) < 2:
        missing = " and ".join(f for f in FAMILIES if f not in told)
        raise InputError(
            f"{plan.file}: no {'bending_loop' if curve else 'cantilever or bending_loop'} test of "
            f"{missing}: a card's bending needs both families"
        )
    return found


def _compaction(plan: Plan, cloth: Fabric, draws: int) -> CompactionFit | None:
    tests = plan.of("compaction")
    if not tests:
        return None
    given = {t.values["contact_pressure"] for t in tests if "contact_pressure" in t.values}
    if len(given) > 1:
        raise InputError(f"{plan.file}: compaction tests differ in contact_pressure: give one")
    solid = None
    if cloth.fibre_density is not None:
        solid = cloth.areal_density / cloth.fibre_density
    elif plan.laws["compaction"] == "power":
        raise InputError(f"{plan.file}: the power law of compaction needs [fabric.fibre_density]")
    return fit_compaction(
        [p for t in tests for p in pressed(t)],
        contact_pressure=given.pop() if given else None,
        solid=solid,
        draws=draws,
    )
