"""Yarns that get narrower, and neighbours of one family, which come closer as the ply shears.

A yarn w wide is squeezed by b to w (1 − b): W = ∫ A ψ(b) dx. Two like sections, h high, that are D
apart and Δz above each other touch where ρ² = (D/w(1 − b))² + (Δz/h)² = 1, as ellipses do, and are
squeezed by e = 1 − ρ: W = ∫ A ψ(e) dx per yarn, which has half of a neighbour on either side. Which
part of a neighbour is beside a yarn moves on with the shear, by s sin γ. Yarns that nothing else
presses touch at cos γ = w/s.
"""

from __future__ import annotations

import numpy as np

from warpdrape.unit_cell.model import Model, Scalar, stretches
from warpdrape.unit_cell.splines import spline_basis, spline_value


def distance(model: Model, family: int, strain: np.ndarray) -> Scalar:
    """D between the middle lines of neighbours [m]."""
    along, across, sine, _ = stretches(strain)
    return model.cell.spacing[family] * (across, along)[family] * sine


def neighbour_places(model: Model, family: int, strain: np.ndarray) -> np.ndarray:
    """Where on its own repeat the neighbour is that lies beside a yarn's points [m]."""
    along, across, _, cosine = stretches(strain)
    weave, cell = model.cell.weave, model.cell.cell
    own, other = ((along, across), (across, along))[family]
    moved = (weave.move, weave.weft_offset(1))[family] * cell[family]
    return model.yarns[family].places - moved - model.cell.spacing[family] * cosine * other / own


def width(model: Model, family: int, strain: np.ndarray) -> Scalar:
    """Of a yarn as it is squeezed [m]."""
    return model.cell.width[family] * (1.0 - strain[3 + family])


def narrowing_energy(model: Model, family: int, strain: np.ndarray) -> Scalar:
    """Energy of one repeat of a yarn that is squeezed to its width [J].

    One that would get wider resists as at the start of being squeezed.
    """
    law, squeeze = model.cell.compaction, strain[3 + family]
    volume = model.cell.sections[family] * model.cell.cell[family] * model.cell.weave.repeat
    if np.real(squeeze) < 0.0:
        return 0.5 * volume * law.pressure * law.exponent * squeeze**2
    return volume * law.energy(squeeze)[()]


def _above(model: Model, family: int, path: np.ndarray, strain: np.ndarray) -> np.ndarray:
    """Δz at a yarn's points [m], own less the neighbour's."""
    yarn = model.yarns[family]
    beside = neighbour_places(model, family, strain)
    return spline_value(path, yarn.places, yarn.step) - spline_value(path, beside, yarn.step)


def side_energy(model: Model, family: int, path: np.ndarray, strain: np.ndarray) -> Scalar:
    """Energy of one repeat of a yarn with its neighbours [J]."""
    apart = distance(model, family, strain) / width(model, family, strain)
    if np.real(apart) >= 1.0:
        return 0.0
    above = _above(model, family, path, strain)
    rho = np.sqrt(apart**2 + (above / model.cell.height[family]) ** 2)
    if np.real(rho).min() <= 0.0:
        return np.inf
    area = model.cell.sections[family]
    return area * (model.yarns[family].weights @ model.cell.compaction.energy(1.0 - rho))


def add_sides(
    model: Model,
    family: int,
    path: np.ndarray,
    strain: np.ndarray,
    gradient: np.ndarray,
    hessian: np.ndarray | None = None,
) -> None:
    """Add first, and second, derivatives of `side_energy` by the path."""
    cell = model.cell
    apart = float(distance(model, family, strain) / width(model, family, strain))
    if apart >= 1.0:
        return
    above, yarn = _above(model, family, path, strain), model.yarns[family]
    rows = spline_basis(yarn.places, yarn.count, yarn.step) - spline_basis(
        neighbour_places(model, family, strain), yarn.count, yarn.step
    )
    height = cell.height[family]
    rho = np.sqrt(apart**2 + (above / height) ** 2)
    size = cell.sections[family] * model.yarns[family].weights
    stress = size * cell.compaction.stress(1.0 - rho)
    slope = above / (height**2 * rho)
    gradient -= (stress * slope) @ rows
    if hessian is None:
        return
    rigid = size * cell.compaction.stiffness(1.0 - rho)
    bend = apart**2 / (height**2 * rho**3)
    hessian += (rows.T * (rigid * slope**2 - stress * bend)) @ rows


def side_force(model: Model, family: int, path: np.ndarray, strain: np.ndarray) -> float:
    """Force −∂W/∂D with which neighbours press each other apart, over a repeat [N]."""
    wide = float(width(model, family, strain))
    apart = float(distance(model, family, strain)) / wide
    if apart >= 1.0:
        return 0.0
    above = _above(model, family, path, strain)
    rho = np.sqrt(apart**2 + (above / model.cell.height[family]) ** 2)
    stress = model.cell.compaction.stress(1.0 - rho)
    size = model.cell.sections[family] * model.yarns[family].weights
    return float(np.sum(size * stress * apart / rho) / wide)


def side_friction(model: Model, family: int, path: np.ndarray, strain: np.ndarray) -> float:
    """Couple of neighbours that slide along each other as the ply shears [N·m]: μ N D."""
    force = side_force(model, family, path, strain)
    return model.cell.friction * force * float(distance(model, family, strain))
