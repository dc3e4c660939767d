"""The unit cell against saw-tooth yarns, its own energy, and straight neighbours that touch."""

from __future__ import annotations

import math

import numpy as np

from warpdrape.coupons.closed_forms import crimp_tensions
from warpdrape.materials.laws import CrimpInterchange
from warpdrape.unit_cell.cell import UnitCell
from warpdrape.unit_cell.compaction import YarnCompaction
from warpdrape.unit_cell.equilibrium import COMPLEX_STEP, settle
from warpdrape.unit_cell.model import Model, build_model
from warpdrape.unit_cell.sides import side_energy
from warpdrape.unit_cell.weave import plain, twill
from warpdrape.verification.case import CaseResult, absolute, relative

SPACING, STIFFNESS, CRIMP = 5.2e-3, 34e3, 0.004
"""Of the saw-tooth yarns [m], [N], [-]."""
THIN = 0.02
"""Their width over the spacing [-]."""
SOFT = YarnCompaction(5e3, 8.0)


def unit_cell(quick: bool) -> list[CaseResult]:
    """All cases; with fewer elements if quick."""
    return [*saw_tooth(16 if quick else 32), order(), *work(), touching()]


def saw_tooth_law() -> CrimpInterchange:
    """The law that thin stiff yarns should follow."""
    return CrimpInterchange(SPACING, SPACING, CRIMP, CRIMP, STIFFNESS, STIFFNESS)


def thin_model(elements: int) -> Model:
    """Yarns thin beside their spacing, whose sections do not give way and that hardly bend."""
    height = saw_tooth_law().heights[0]
    cell = UnitCell(
        weave=plain(),
        spacing=(SPACING, SPACING),
        width=(THIN * SPACING, THIN * SPACING),
        height=(height, height),
        stiffness=(STIFFNESS, STIFFNESS),
        bending=(1e-9, 1e-9),
        compaction=YarnCompaction(1e15, 2.0),
    )
    return build_model(cell, elements, points=5)


def saw_tooth(elements: int) -> list[CaseResult]:
    """Warp tension at three ratios of strain; splines round the teeth's corners."""
    model, cases = thin_model(elements), []
    for name, ratio in (("equal strains", 1.0), ("weft strain half", 0.5), ("weft held", 0.0)):
        strain = (0.004, 0.004 * ratio)
        found = settle(model, np.array([*strain, 0.0])).tension[0]
        exact = crimp_tensions(saw_tooth_law(), *strain)[0]
        limit = 0.08 / elements
        cases.append(relative(f"unit cell, saw tooth, {name}: warp", found, exact, limit, "N"))
    return cases


def order() -> CaseResult:
    """How the saw tooth's error falls with the element: a corner is as wide as one."""
    exact = crimp_tensions(saw_tooth_law(), 0.004, 0.0)[0]
    errors = [
        abs(settle(thin_model(n), np.array([0.004, 0.0, 0.0])).tension[0] / exact - 1.0)
        for n in (8, 16, 32)
    ]
    rate = 0.5 * math.log2(errors[0] / errors[-1])
    return absolute("unit cell, saw tooth, weft held: order in the element", rate, 1.0, 0.35)


def thick_model() -> Model:
    """Wide yarns in contact, warp and weft unlike."""
    cell = UnitCell(
        weave=twill(),
        spacing=(5.2e-3, 4.8e-3),
        width=(4.1e-3, 3.9e-3),
        height=(0.6e-3, 0.5e-3),
        stiffness=(44e3, 38e3),
        bending=(1e-7, 2e-7),
        compaction=SOFT,
    )
    return build_model(cell, elements=6, points=7)


def work() -> list[CaseResult]:
    """∂W/∂ε1 = L1 T1 and ∂W/∂γ = C_s, by differences of the energy between states at rest."""
    model, at = thick_model(), np.array([0.006, 0.005, 0.6])
    rest, cases = settle(model, at), []
    for name, k, step, given, unit in (
        ("L1 T1", 0, 1e-5, rest.tension[0] * model.cell.cell[0], "N·m"),
        ("couple", 2, 1e-3, rest.couple, "N·m"),
    ):
        ends = [settle(model, at + way * step * np.eye(3)[k], rest).energy for way in (1, -1)]
        slope = (ends[0] - ends[1]) / (2.0 * step)
        cases.append(relative(f"unit cell, {name}: slope of the energy", slope, given, 1e-3, unit))
    return cases


def touching() -> CaseResult:
    """Straight neighbours beyond cos γ = w/s: C_s = A L p(e) s sin γ/w, e = 1 − s cos γ/w."""
    width, spacing, height = 4.1e-3, 5.2e-3, 0.6e-3
    cell = UnitCell(
        weave=plain(),
        spacing=(spacing, spacing),
        width=(width, width),
        height=(height, height),
        stiffness=(44e3, 44e3),
        bending=(1e-7, 1e-7),
        compaction=SOFT,
        crimp=(0.0, None),
    )
    model = build_model(cell, elements=6, points=7)
    angle = math.acos(width / spacing) + 0.1
    squeeze = 1.0 - spacing * math.cos(angle) / width
    pressed = float(SOFT.stress(np.array(squeeze)))
    exact = cell.sections[0] * cell.cell[0] * pressed * spacing * math.sin(angle) / width
    strain = np.array([0.0, 0.0, angle + 1j * COMPLEX_STEP, 0.0, 0.0])
    pushed = np.imag(side_energy(model, 0, model.parts(model.woven)[0], strain)) / COMPLEX_STEP
    found = float(pushed) / cell.weave.repeat
    return relative("unit cell, straight neighbours: couple", found, exact, 1e-9, "N·m")
