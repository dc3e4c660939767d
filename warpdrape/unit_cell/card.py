"""A loaded cell as the tables of a fabric's card."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from warpdrape.calibration.card_file import quantity
from warpdrape.calibration.locking import DEFINITION, locking_angle
from warpdrape.unit_cell.cell import FAMILIES
from warpdrape.unit_cell.cell_file import ASSUMED, Plan
from warpdrape.unit_cell.loading import ShearCurve, TensionTable

SIMULATED = "simulated"
NOTED = 0.01
"""Share of the largest couple from which on a card says what was made of it [-]."""
FLAT = 181
"""Points of the shear curve in which calibration's locking angle is looked for."""


def card_tables(
    plan: Plan, table: TensionTable, curve: ShearCurve, versions: Mapping[str, str]
) -> dict[str, Any]:
    """Everything that a card holds.

    Args:
        plan: the cell.
        table: its tensions.
        curve: its shear.
        versions: of what computed it.
    """
    source = source_text(plan, versions)
    given = plan.source or f"given for the unit cell {plan.name}"
    cell = plan.cell
    tables: dict[str, Any] = {"name": plan.name, "description": _description(plan)}
    tables["doubts"] = doubts(plan)
    tables["areal_density"] = quantity(
        1e3 * areal_density(plan),
        "g/m²",
        f"yarns, spacings and crimps of the {source}",
        "",
        SIMULATED,
    )
    tables["thickness"] = quantity(
        1e3 * thickness(plan), "mm", source, "as woven, under no pressure", SIMULATED
    )
    for along, family in enumerate(FAMILIES):
        tables[f"cell_{family}"] = quantity(1e3 * cell.cell[along], "mm", given, "", plan.status)
    tables["fibre_density"] = quantity(1e-3 * plan.fibre_density, "g/cm³", given, "", plan.status)
    tables["compressive_factor"] = quantity(
        cell.slack, "-", "yarns buckle and hardly resist compression", "", "assumed"
    )
    if curve.locking is not None:
        tables["locking_angle"] = quantity(
            math.degrees(curve.locking), "deg", source, _locking_words(curve), SIMULATED
        )
    tables["tension"] = _tension(plan, table, source)
    tables["shear"] = _shear(plan, curve, source)
    return tables


def source_text(plan: Plan, versions: Mapping[str, str]) -> str:
    """What every simulated value comes from."""
    with_ = ", ".join(f"{name} {versions[name]}" for name in ("warpdrape", "numpy", "scipy"))
    return f"unit cell of a {plan.cell.weave.name} weave, beams in contact ({with_})"


def _description(plan: Plan) -> str:
    return plan.description or f"{plan.cell.weave.name} weave from a simulated unit cell"


def doubts(plan: Plan) -> list[str]:
    """What is uncertain about the fabric as a whole."""
    found = [
        "Simulated, not measured: yarns are beams whose sections are squeezed where they touch. "
        "They slide along themselves without friction, do not break or twist, and do not get wider "
        "or thicker as they are squeezed. Shear is that of held tensions, whatever the strain."
    ]
    if plan.assumed:
        values = ", ".join(f"{name} {ASSUMED[name]}" for name in plan.assumed)
        found.append(f"Assumed, since not given: {values}.")
    return found


def areal_density(plan: Plan) -> float:
    """Mass of the ply per area [kg/m²]."""
    cell = plan.cell
    per_yarn = zip(plan.linear_density, cell.crimps, cell.spacing, strict=True)
    return sum(mass * (1.0 + crimp) / spacing for mass, crimp, spacing in per_yarn)


def thickness(plan: Plan) -> float:
    """From the lowest to the highest point of the yarns, as woven [m]."""
    cell = plan.cell
    return max(2.0 * a + h for a, h in zip(cell.amplitudes, cell.height, strict=True))


def _locking_words(curve: ShearCurve) -> str:
    even = np.linspace(0.0, curve.angles[-1], FLAT)
    other, steeper = locking_angle(even, np.interp(even, curve.angles, curve.couples))
    touch = (
        "they do not touch up to the end of the curve"
        if curve.touching is None
        else f"they touch at {math.degrees(curve.touching):.3g}°"
    )
    return (
        "from where on neighbours have less room than their width as woven, cos γ = width over "
        f"spacing; narrower by then, {touch}; another definition, {DEFINITION}, gives "
        f"{math.degrees(other):.3g}° ({steeper:.2g} times steeper)"
    )


def _percent(axis: np.ndarray) -> str:
    return f"{100 * axis[0]:.3g} to {100 * axis[-1]:.3g} %"


def _tension(plan: Plan, table: TensionTable, source: str) -> dict[str, Any]:
    ranges = " and ".join(_percent(axis) for axis in table.strains)
    doubt = (
        f"simulated for strains of {ranges}, beyond which it is extrapolated; at the most yarns "
        f"themselves are strained by {100 * table.yarn_strain:.3g} %, and do not break, and "
        f"thinned by {100 * table.squeeze:.3g} % where they cross"
    )
    law: dict[str, Any] = {"law": "table"}
    for family, axis in zip(FAMILIES, table.strains, strict=True):
        law[f"strain_{family}"] = quantity(100 * axis, "%", source, "", SIMULATED)
    for family, values in zip(FAMILIES, table.tensions, strict=True):
        law[f"tension_{family}"] = quantity(values, "N", source, doubt, SIMULATED)
    return law


def _rising(simulated: np.ndarray) -> tuple[np.ndarray, float]:
    """Couples that do not fall, from none, and by how much they did, over the largest [-]."""
    couples = np.maximum.accumulate(np.maximum(simulated, 0.0))
    couples[0] = 0.0
    return couples, float((couples - simulated).max() / max(couples[-1], 1e-300))


def _shear(plan: Plan, curve: ShearCurve, source: str) -> dict[str, Any]:
    held = " and ".join(f"{t:.3g}" for t in plan.loads.shear_tension)
    end = math.degrees(curve.angles[-1])
    share = curve.friction[-1] / max(curve.couples[-1], 1e-300)
    doubt = (
        f"yarn tensions held at {held} N (warp, weft): the couple grows with them; friction is "
        f"{100 * share:.2g} % of it at {end:.3g}°; ends there: {curve.end}; beyond it is "
        "extrapolated"
    )
    if curve.skew > NOTED:
        doubt += f"; the weave shears {100 * curve.skew:.2g} % harder one way: the mean is given"
    couples, fallen = _rising(1e3 * curve.couples)
    if fallen > NOTED:
        doubt += (
            f"; the simulated couple falls on its way, by {100 * fallen:.2g} % of its largest at "
            "the most: kept level there"
        )
    return {
        "law": "table",
        "angles": quantity(np.degrees(curve.angles), "deg", source, "", SIMULATED),
        "couples": quantity(couples, "N·mm", source, doubt, SIMULATED),
    }
