"""Contact where yarns cross: sections squeezed between two middle lines, point by point.

Over a patch as large as both yarns' widths the middle lines are d apart, and the yarns t/2 where
they just touch. Both are squeezed by e = 1 − 2d/t: W = ∫ (t/2) ψ(e) dA, pressure −∂W/∂d = p(e) dA.
A patch grows with 1/cos γ as the ply shears, so that yarns are pressed on their flanks, too: points
of a section, each with its dA, come closer to its middle as it gets narrower.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpdrape.unit_cell.model import Model, Scalar, middle_distances, patch_places, stretches
from warpdrape.unit_cell.splines import spline_basis


@dataclass(frozen=True, eq=False)
class Contact:
    """The patches' points.

    Attributes:
        half_warp: half of a patch along the warp, on the sheet as woven [m].
        half_weft: … along the weft.
        weight: area for which a point stands [m²], shape [q, q].
        squeeze: e there [-], shape [crossover, q, q].
    """

    half_warp: Scalar
    half_weft: Scalar
    weight: np.ndarray
    squeeze: np.ndarray


def contact(model: Model, state: np.ndarray, strain: np.ndarray) -> Contact:
    """How sections are squeezed in a state, under strains."""
    along, across, sine, _ = stretches(strain)
    warp, weft = model.cell.width
    half_warp = 0.5 * weft * (1.0 - strain[4]) / (sine * along)
    half_weft = 0.5 * warp * (1.0 - strain[3]) / (sine * across)
    weight = model.grid_weights[:, None] * model.grid_weights * (0.25 * warp * weft / sine)
    apart = middle_distances(model, state, half_warp, half_weft)
    return Contact(half_warp, half_weft, weight, 1.0 - 2.0 * apart / model.thickness)


def crossing_energy(model: Model, state: np.ndarray, strain: np.ndarray) -> Scalar:
    """Energy of the crossovers on one repeat of a warp yarn [J]; infinite where lines cross."""
    at = contact(model, state, strain)
    if np.real(at.squeeze).max() >= 1.0:
        return np.inf
    return np.sum(at.weight * 0.5 * model.thickness * model.cell.compaction.energy(at.squeeze))


def add_crossings(
    model: Model,
    state: np.ndarray,
    strain: np.ndarray,
    gradient: np.ndarray,
    hessian: np.ndarray | None = None,
) -> None:
    """Add first, and second, derivatives of `crossing_energy` by both paths."""
    at, law = contact(model, state, strain), model.cell.compaction
    force = at.weight * law.stress(at.squeeze)
    signs = np.array(model.cell.weave.signs)[:, None]
    n = model.yarns[0].count
    places = patch_places(model, at.half_warp, at.half_weft)
    on_warp, on_weft = (
        spline_basis(at_places, yarn.count, yarn.step)
        for at_places, yarn in zip(places, model.yarns, strict=True)
    )
    gradient[:n] -= np.einsum("jp,jpn->n", signs * force.sum(axis=2), on_warp)
    gradient[n:] += np.einsum("jq,jqn->n", signs * force.sum(axis=1), on_weft)
    if hessian is None:
        return
    rigid = at.weight * law.stiffness(at.squeeze) * 2.0 / model.thickness
    hessian[:n, :n] += np.einsum("jpm,jp,jpn->mn", on_warp, rigid.sum(axis=2), on_warp)
    hessian[n:, n:] += np.einsum("jqm,jq,jqn->mn", on_weft, rigid.sum(axis=1), on_weft)
    mixed = np.einsum("jpm,jpn->mn", on_warp, rigid @ on_weft)
    hessian[:n, n:] -= mixed
    hessian[n:, :n] -= mixed.T


def crossing_friction(model: Model, state: np.ndarray, strain: np.ndarray) -> float:
    """Couple of sliding friction at the crossovers of a repeat [N·m]: Σ μ N r."""
    at = contact(model, state, strain)
    along, across, _, cosine = stretches(strain)
    x = (along * at.half_warp * model.grid)[:, None]
    y = (across * at.half_weft * model.grid)[None, :]
    arm = np.sqrt(x**2 + y**2 + 2.0 * cosine * x * y)
    force = at.weight * model.cell.compaction.stress(at.squeeze)
    return model.cell.friction * float(np.sum(force * arm))
