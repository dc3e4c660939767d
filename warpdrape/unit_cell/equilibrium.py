"""The state of least energy under given strains, or tensions, and what it takes to hold it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpdrape.errors import RunFailed
from warpdrape.unit_cell.crossings import (
    add_crossings,
    contact,
    crossing_energy,
    crossing_friction,
)
from warpdrape.unit_cell.model import Model, Scalar, stretches
from warpdrape.unit_cell.sides import add_sides, narrowing_energy, side_energy, side_friction
from warpdrape.unit_cell.stretching import add_yarn, yarn_energy, yarn_strain

TOLERANCE = 1e-12
"""Largest force left, over the stiffest yarn's EA [-]."""
ROUNDING = 1e-14
"""… over the largest stiffness times the largest height, below which numbers cannot tell [-]."""
NEAR = 1e3
"""Times these that are taken where they do not get smaller any more [-]."""
ITERATIONS, HALVINGS = 120, 40
COMPLEX_STEP = 1e-30
FREE_STEP = 1e-6
"""Strain over which derivatives by strain are taken that only lead the search."""


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A cell at rest under load.

    Attributes:
        strain: ε1, ε2 [-], γ [rad], and by how much warp and weft are narrower [-], shape [5].
        state: coefficients of both paths [m].
        energy: of a unit cell [J].
        tension: T1, T2 [N per yarn].
        couple: C_s of the elastic forces [N·m per cell].
        friction: C_s of friction where everything slides, without sign [N·m per cell].
        squeeze: largest squeeze of sections at crossovers [-].
        yarn_strain: of a warp, a weft yarn itself [-].
        iterations: that it took.
    """

    strain: np.ndarray
    state: np.ndarray
    energy: float
    tension: np.ndarray
    couple: float
    friction: float
    squeeze: float
    yarn_strain: tuple[float, float]
    iterations: int


def energy(model: Model, state: np.ndarray, strain: np.ndarray) -> Scalar:
    """Energy of one repeat, n unit cells [J].

    Args:
        model: the cell.
        state: coefficients of both paths [m].
        strain: as of an `Equilibrium`; complex ones give derivatives by a complex step.
    """
    parts = model.parts(state)
    along, across, _, _ = stretches(strain)
    found = crossing_energy(model, state, strain)
    for family, (path, stretch) in enumerate(zip(parts, (along, across), strict=True)):
        found = found + yarn_energy(model.yarns[family], path, stretch)
        found = found + side_energy(model, family, path, strain)
        found = found + narrowing_energy(model, family, strain)
    return found + 0.5 * _anchor(model) * np.sum(state - model.woven) ** 2


def _anchor(model: Model) -> float:
    """Stiffness of a spring that keeps the ply's height, on which nothing depends [N/m]."""
    return 1e-6 * max(model.cell.stiffness) / max(model.cell.cell)


def derivatives(
    model: Model, state: np.ndarray, strain: np.ndarray, second: bool = True
) -> tuple[np.ndarray, np.ndarray | None]:
    """First and, if wanted, second derivatives of `energy` by the state."""
    n = len(state)
    gradient = np.zeros(n)
    hessian = np.zeros((n, n)) if second else None
    add_crossings(model, state, strain, gradient, hessian)
    first = model.yarns[0].count
    for family, part in enumerate((slice(None, first), slice(first, None))):
        views = gradient[part], None if hessian is None else hessian[part, part]
        add_yarn(model.yarns[family], state[part], 1.0 + strain[family], *views)
        add_sides(model, family, state[part], strain, *views)
    anchor = _anchor(model)
    gradient = gradient + anchor * np.sum(state - model.woven)
    return gradient, None if hessian is None else hessian + anchor


def strain_forces(
    model: Model, state: np.ndarray, strain: np.ndarray, which: Sequence[int] = range(5)
) -> np.ndarray:
    """∂W/∂strain of a repeat [J], exact, by complex steps (Squire and Trapp 1998)."""
    found = np.zeros(len(which))
    for place, k in enumerate(which):
        moved = strain.astype(complex)
        moved[k] += 1j * COMPLEX_STEP
        found[place] = np.imag(energy(model, state, moved)) / COMPLEX_STEP
    return found


def settle(
    model: Model,
    strain: np.ndarray,
    start: Equilibrium | None = None,
    tension: tuple[float, float] | None = None,
) -> Equilibrium:
    """Find the state of least energy.

    Args:
        model: the cell.
        strain: ε1, ε2, γ; with tensions the first two are where the search begins.
        start: a state at rest to begin with; as woven if None.
        tension: T1, T2 [N per yarn] that are held in place of strains.

    Raises:
        RunFailed: none is found.
    """
    place = np.concatenate([strain, np.zeros(2) if start is None else start.strain[3:]])
    state = model.woven if start is None else start.state
    if not np.isfinite(energy(model, state, place)):
        place[3:], state = 0.0, model.woven
    pull = np.zeros(5)
    if tension is not None:
        pull[:2] = np.array(tension) * model.cell.cell * model.cell.weave.repeat
    search = _Search(model, pull, [3, 4] if tension is None else [0, 1, 3, 4])
    shift, tries, size, limit = 0.0, 0, math.inf, 0.0
    for iteration in range(1, ITERATIONS + 1):
        gradient, hessian = search.bordered(state, place)
        before, size = size, search.size(gradient)
        limit = _limit(model, state, hessian)
        if size <= limit or before <= size <= NEAR * limit:
            return _equilibrium(model, place, state, iteration)
        step, shift = _downhill(gradient, hessian, shift)
        reached = search.along(state, place, step, gradient, limit)
        if reached is not None:
            (state, place), tries = reached, 0
        elif tries < 3 and size > NEAR * limit:
            shift, tries = max(10.0 * shift, 1e-6), tries + 1
        else:
            break
    if size <= NEAR * limit:
        return _equilibrium(model, place, state, iteration)
    raise RunFailed(
        f"the unit cell finds no rest at ε1 = {100 * place[0]:.4g} %, ε2 = {100 * place[1]:.4g} %, "
        f"γ = {math.degrees(place[2]):.4g}°: give a smaller largest_angle or largest_strain, or a "
        "lower compaction_exponent"
    )


def _limit(model: Model, state: np.ndarray, hessian: np.ndarray) -> float:
    """What of `_size` is as good as nothing [J]."""
    stiffest = float(np.diag(hessian)[: len(state)].max()) * float(np.abs(state).max())
    force = max(TOLERANCE * max(model.cell.stiffness), ROUNDING * stiffest)
    return force * min(model.cell.cell)


@dataclass(frozen=True, eq=False)
class _Search:
    """What is looked for: least energy less the work of held tensions.

    Attributes:
        model: the cell.
        pull: ∂W/∂strain that is held [J], shape [5].
        free: which strains are not given.
    """

    model: Model
    pull: np.ndarray
    free: list[int]

    def potential(self, state: np.ndarray, strain: np.ndarray) -> float:
        """What is least at rest [J]."""
        return float(np.real(energy(self.model, state, strain))) - float(self.pull @ strain)

    def forces(self, state: np.ndarray, strain: np.ndarray) -> np.ndarray:
        """Derivatives of the potential by the free strains [J]."""
        return strain_forces(self.model, state, strain, self.free) - self.pull[self.free]

    def bordered(self, state: np.ndarray, strain: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """First and second derivatives by state and free strains, the latter by differences."""
        gradient, hessian = derivatives(self.model, state, strain)
        n = len(state)
        whole = np.zeros((n + len(self.free),) * 2)
        whole[:n, :n] = hessian
        for column, k in enumerate(self.free):
            moved = [strain + sign * FREE_STEP * np.eye(5)[k] for sign in (1.0, -1.0)]
            up, down = (derivatives(self.model, state, at, second=False)[0] for at in moved)
            whole[:n, n + column] = whole[n + column, :n] = (up - down) / (2.0 * FREE_STEP)
            up, down = (self.forces(state, at) for at in moved)
            whole[n:, n + column] = (up - down) / (2.0 * FREE_STEP)
        whole[n:, n:] = 0.5 * (whole[n:, n:] + whole[n:, n:].T)
        return np.append(gradient, self.forces(state, strain)), whole

    def size(self, gradient: np.ndarray) -> float:
        """Largest force left, times a cell's length [J]."""
        n = len(gradient) - len(self.free)
        inner = float(np.abs(gradient[:n]).max()) * min(self.model.cell.cell)
        return max(inner, float(np.abs(gradient[n:]).max()))

    def along(self, state, strain, step, gradient, limit):
        """State and strain on the way where the potential is lower, or the forces are; or None."""
        n = len(state)
        begun, slope, size = self.potential(state, strain), float(gradient @ step), None
        share = 1.0
        for _ in range(HALVINGS):
            moved = strain.copy()
            moved[self.free] += share * step[n:]
            there = state + share * step[:n]
            found = self.potential(there, moved)
            if found <= begun + 1e-4 * share * slope:
                return there, moved
            if abs(found - begun) <= 1e-12 * (abs(begun) + abs(self.pull @ strain) + limit):
                size = self.size(gradient) if size is None else size
                if self.size(self.bordered(there, moved)[0]) < size:
                    return there, moved
            share *= 0.5
        return None


def _downhill(gradient: np.ndarray, hessian: np.ndarray, shift: float) -> tuple[np.ndarray, float]:
    """Newton's step, the matrix lifted by a share of its diagonal until it is positive."""
    diagonal = np.abs(np.diag(hessian))
    diagonal = np.maximum(diagonal, 1e-12 * diagonal.max())
    while True:
        try:
            lower = np.linalg.cholesky(hessian + np.diag((shift + 1e-13) * diagonal))
            step = -np.linalg.solve(lower.T, np.linalg.solve(lower, gradient))
            return step, 0.1 * shift if shift > 1e-12 else 0.0
        except np.linalg.LinAlgError:
            shift = max(4.0 * shift, 1e-9)


def _equilibrium(model, strain, state, iterations) -> Equilibrium:
    cells = model.cell.weave.repeat
    forces = strain_forces(model, state, strain)
    parts = model.parts(state)
    friction = crossing_friction(model, state, strain) + sum(
        side_friction(model, family, path, strain) for family, path in enumerate(parts)
    )
    strains = [
        float(yarn_strain(y, p, 1.0 + e))
        for y, p, e in zip(model.yarns, parts, strain[:2], strict=True)
    ]
    return Equilibrium(
        strain,
        state,
        float(np.real(energy(model, state, strain))) / cells,
        forces[:2] / (cells * np.array(model.cell.cell)),
        float(forces[2]) / cells,
        friction / cells,
        float(np.max(contact(model, state, strain).squeeze, initial=0.0)),
        (strains[0], strains[1]),
        iterations,
    )
