"""A unit cell in splines: what of it never changes, and its state as woven, free of stress.

All warp yarns are alike, and all weft yarns, so that one of each is looked at, over its repeat,
with the crossovers on it and one neighbour beside it: energies are those of one repeat of yarn,
n unit cells of one crossover each.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from warpdrape.unit_cell.cell import SECTIONS, UnitCell
from warpdrape.unit_cell.path import woven_height
from warpdrape.unit_cell.splines import spline_basis, spline_value, through

Scalar = Any
"""A number: a float, or complex where a derivative is taken by a complex step."""
GAUSS = 4
"""Points of an element, along a yarn."""


@dataclass(frozen=True, eq=False)
class Yarn:
    """One yarn over a repeat; x runs along the sheet as woven.

    Attributes:
        count: of splines.
        step: length of an element [m].
        places: integration points [m], shape [point].
        weights: theirs [m], shape [point].
        slopes: of the splines there [1/m], shape [point, count].
        curvatures: … second derivatives [1/m²].
        woven: coefficients of its path as woven [m], shape [count].
        rest_length: of the path as woven [m].
        rest_curvature: of it at the points [1/m].
        rest_weights: lengths along it for which the points stand [m].
        stiffness: EA [N].
        bending: B [N·m²].
        slack: stiffness in compression over EA [-].
    """

    count: int
    step: float
    places: np.ndarray
    weights: np.ndarray
    slopes: np.ndarray
    curvatures: np.ndarray
    woven: np.ndarray
    rest_length: float
    rest_curvature: np.ndarray
    rest_weights: np.ndarray
    stiffness: float
    bending: float
    slack: float


@dataclass(frozen=True, eq=False)
class Model:
    """A cell ready to be loaded.

    Attributes:
        cell: the cell.
        yarns: warp and weft.
        grid: places in a patch of contact, ξ and η from −1 to 1, shape [q].
        grid_weights: theirs, shape [q].
        thickness: of both yarns together over the patches [m], along the warp and along the weft
            from the crossover's middle, shape [crossover, q, q].
    """

    cell: UnitCell
    yarns: tuple[Yarn, Yarn]
    grid: np.ndarray
    grid_weights: np.ndarray
    thickness: np.ndarray

    @property
    def woven(self) -> np.ndarray:
        """Coefficients of both paths as woven [m]."""
        return np.concatenate([yarn.woven for yarn in self.yarns])

    def parts(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients of the warp's path, and of the weft's."""
        return state[: self.yarns[0].count], state[self.yarns[0].count :]


def build_model(cell: UnitCell, elements: int = 8, points: int = 9) -> Model:
    """Take a cell apart into splines.

    Args:
        cell: the cell.
        elements: of a yarn from crossover to crossover, even.
        points: of a patch of contact, along each yarn; odd, so that one is in its middle.
    """
    yarns = (_yarn(cell, 0, elements), _yarn(cell, 1, elements))
    grid, weights = np.polynomial.legendre.leggauss(points)
    shape = (1.0 - grid**2) ** SECTIONS[cell.section]
    nominal = cell.height[1] * shape[:, None] + cell.height[0] * shape[None, :]
    bare = Model(cell, yarns, grid, weights, np.zeros(0))
    # where the sections would overlap as woven, they have given way to each other
    apart = middle_distances(bare, bare.woven, 0.5 * cell.width[1], 0.5 * cell.width[0])
    return replace(bare, thickness=np.minimum(nominal, 2.0 * apart))


def patch_places(
    model: Model, half_warp: Scalar, half_weft: Scalar
) -> tuple[np.ndarray, np.ndarray]:
    """Where the patches' points are on the repeats of warp and weft [m], shape [crossover, q].

    Args:
        model: the cell.
        half_warp: half of a patch along the warp, on the sheet as woven [m].
        half_weft: … along the weft.
    """
    weave, lengths = model.cell.weave, model.cell.cell
    numbers = np.arange(weave.repeat)
    offsets = np.array([weave.weft_offset(int(j)) for j in numbers])
    return (
        lengths[0] * numbers[:, None] + half_warp * model.grid,
        half_weft * model.grid - lengths[1] * offsets[:, None],
    )


def middle_distances(
    model: Model, state: np.ndarray, half_warp: Scalar, half_weft: Scalar
) -> np.ndarray:
    """From middle line to middle line over the patches [m], shape [crossover, q, q].

    Negative where the yarn is on the wrong side. Arguments as of `patch_places`.
    """
    on_warp, on_weft = (
        spline_value(path, places, yarn.step)
        for path, places, yarn in zip(
            model.parts(state), patch_places(model, half_warp, half_weft), model.yarns, strict=True
        )
    )
    signs = np.array(model.cell.weave.signs)[:, None, None]
    return signs * (on_warp[:, :, None] - on_weft[:, None, :])


def _yarn(cell: UnitCell, family: int, elements: int) -> Yarn:
    signs = (cell.weave.signs, cell.weave.weft_signs())[family]
    spacing, count = cell.cell[family], elements * cell.weave.repeat
    step = spacing / elements
    nodes = step * np.arange(count)
    amplitude, crossed = cell.amplitudes[family], cell.width[1 - family]
    woven = through(woven_height(nodes, signs, amplitude, spacing, crossed), step)
    gauss, weights = np.polynomial.legendre.leggauss(GAUSS)
    places = (nodes[:, None] + 0.5 * step * (gauss + 1.0)).ravel()
    weights = np.tile(0.5 * step * weights, count)
    slopes, curvatures = (spline_basis(places, count, step, order) for order in (1, 2))
    long = np.sqrt(1.0 + (slopes @ woven) ** 2)
    return Yarn(
        count,
        step,
        places,
        weights,
        slopes,
        curvatures,
        woven,
        float(weights @ long),
        (curvatures @ woven) / long**3,
        weights * long,
        cell.stiffness[family],
        cell.bending[family],
        cell.slack,
    )


def stretches(strain: np.ndarray) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Stretch along warp and weft, sine and cosine of the angle between them.

    Args:
        strain: ε1, ε2, γ and what follows, shape [5]; complex ones are taken, too.
    """
    return 1.0 + strain[0], 1.0 + strain[1], np.cos(strain[2]), np.sin(strain[2])
