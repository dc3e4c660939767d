"""What the kernels read of a fabric's laws: structs per area of the sheet, functions, stiffness."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
import warp as wp

from warpdrape.errors import InputError
from warpdrape.kernels.materials import crimp, isotropic, rubber, shear, tension
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.laws import (
    CrimpInterchange,
    IsotropicMembrane,
    LinearTension,
    MooneyRivlin,
    NoShear,
    ShearTable,
    TabulatedTension,
    Unwoven,
)
from warpdrape.materials.spline import SplineEnergy, fit_energy

SAMPLES_PER_INTERVAL = 4
"""Points per spline interval at which a table's stiffness is looked at."""
LEAST_STIFFNESS = 1e-6
"""Stiffness of a family that a table gives none, over the largest in the table [-]."""

_fitted = lru_cache(maxsize=16)(fit_energy)


def tension_struct(fabric: Fabric, device: Any = None) -> Any:
    """Build the kernels' struct of a fabric's tension law, as line tensions [N/m]."""
    match fabric.tension:
        case LinearTension():
            return _linear_struct(fabric, fabric.tension)
        case TabulatedTension():
            return _tabulated_struct(fabric, fabric.tension, device)
        case CrimpInterchange():
            return _crimp_struct(fabric, fabric.tension)
        case IsotropicMembrane():
            law = isotropic.IsotropicMembrane()
            law.stiffness = fabric.tension.stiffness
            law.poisson = fabric.tension.poisson
            return law
        case MooneyRivlin():
            law = rubber.MooneyRivlin()
            law.c10 = fabric.tension.c10 * fabric.thickness
            law.c01 = fabric.tension.c01 * fabric.thickness
            return law


def _linear_struct(fabric: Fabric, yarns: LinearTension) -> tension.LinearTension:
    b1, b2 = fabric.yarn_width
    law = tension.LinearTension()
    law.stiffness = wp.vec2d(yarns.warp / b1, yarns.weft / b2)
    law.compressive_factor = fabric.compressive_factor
    return law


def _tabulated_struct(
    fabric: Fabric, table: TabulatedTension, device: Any
) -> tension.TabulatedTension:
    energy = _fitted(table, fabric.yarn_width)
    if energy.warning:
        warnings.warn(f"fabric {fabric.name!r}: {energy.warning}", stacklevel=3)
    own, _ = _table_stiffness(energy)
    law = tension.TabulatedTension()
    law.origin = wp.vec2d(*energy.origin)
    law.spacing = wp.vec2d(*energy.spacing)
    law.intervals = wp.vec2i(*energy.intervals)
    law.stiffness = wp.vec2d(*own)
    law.compressive_stiffness = wp.vec2d(*(fabric.compressive_factor * own))
    law.coefficients = wp.array(energy.coefficients, dtype=wp.float64, device=device)
    return law


def _crimp_struct(fabric: Fabric, yarns: CrimpInterchange) -> crimp.CrimpInterchange:
    law = crimp.CrimpInterchange()
    law.spacing = wp.vec2d(yarns.spacing_warp, yarns.spacing_weft)
    law.length = wp.vec2d(*yarns.lengths)
    law.height = wp.vec2d(*yarns.heights)
    law.stiffness = wp.vec2d(yarns.stiffness_warp, yarns.stiffness_weft)
    law.cell_area = fabric.cell_area
    law.compressive_factor = fabric.compressive_factor
    return law


def shear_struct(fabric: Fabric, device: Any = None) -> Any:
    """Build the kernels' struct of a fabric's shear law, as couples per area [N/m]."""
    if isinstance(fabric.shear, ShearTable):
        return _curve_struct(fabric, fabric.shear, device)
    coefficients = () if isinstance(fabric.shear, NoShear) else fabric.shear.coefficients
    padded = np.zeros(4)
    padded[: len(coefficients)] = np.asarray(coefficients) / fabric.cell_area
    law = shear.ShearPolynomial()
    law.coefficients = wp.vec4d(*padded)
    return law


def _curve_struct(fabric: Fabric, table: ShearTable, device: Any) -> shear.ShearCurve:
    angles = np.asarray(table.angles)
    couples = np.asarray(table.couples) / fabric.cell_area
    slopes = table.slopes / fabric.cell_area
    steps = np.diff(angles)
    mean = (couples[:-1] + couples[1:]) / 2 + steps * (slopes[:-1] - slopes[1:]) / 12
    energies = np.concatenate([[0.0], np.cumsum(steps * mean)])
    law = shear.ShearCurve()
    for name, values in (
        ("angles", angles),
        ("couples", couples),
        ("slopes", slopes),
        ("energies", energies),
    ):
        setattr(law, name, wp.array(values, dtype=wp.float64, device=device))
    return law


def membrane_functions(fabric: Fabric) -> tuple[Callable, Callable, Callable, Callable, type, type]:
    """Return ``(tension, tension_energy, shear, shear_energy, Tension, Shear)`` of a yarn fabric.

    These are the arguments of `kernels.membrane.make_yarn_membrane`.

    Raises:
        InputError: the fabric is an isotropic membrane, which has kernels of its own.
    """
    match fabric.tension:
        case LinearTension():
            pull = (tension.linear_tension, tension.linear_energy, tension.LinearTension)
        case TabulatedTension():
            pull = (tension.tabulated_tension, tension.tabulated_energy, tension.TabulatedTension)
        case CrimpInterchange():
            pull = (crimp.crimp_tension, crimp.crimp_energy, crimp.CrimpInterchange)
        case _:
            raise InputError(f"fabric {fabric.name!r} is an isotropic membrane and has no yarns")
    if isinstance(fabric.shear, ShearTable):
        twist = (shear.curve_couple, shear.curve_energy, shear.ShearCurve)
    else:
        twist = (shear.polynomial_couple, shear.polynomial_energy, shear.ShearPolynomial)
    return pull[0], pull[1], twist[0], twist[1], pull[2], twist[2]


def tension_stiffness(fabric: Fabric) -> tuple[float, float]:
    """Bound the stiffness of the sheet along its yarns [N/m], for the stable time step.

    diag(n1, n2) is nowhere less than the Hessian of the energy: ∂N_α/∂ε_α plus what the other
    family adds. For a table, inside it.
    """
    law = fabric.tension
    b1, b2 = fabric.yarn_width
    match law:
        case LinearTension():
            return law.warp / b1, law.weft / b2
        case TabulatedTension():
            own, cross = _table_stiffness(_fitted(law, fabric.yarn_width))
            bound = own * (1 + fabric.compressive_factor) + cross
            return float(bound[0]), float(bound[1])
        case CrimpInterchange():
            # Straightening only softens: EA p²/(l S) at a fixed height is the stiffest.
            compressed = fabric.compressive_factor
            return (
                law.stiffness_warp / b1 * (1 / (1 + law.crimp_warp) + compressed),
                law.stiffness_weft / b2 * (1 / (1 + law.crimp_weft) + compressed),
            )
        case IsotropicMembrane():
            bound = law.stiffness / (1 - abs(law.poisson))
            return bound, bound
        case MooneyRivlin():
            bound = 6.0 * law.shear_modulus * fabric.thickness  # E h/(1 − ν), ν = ½
            return bound, bound


def taut_stiffness(fabric: Fabric) -> tuple[float, float]:
    """The least stiffness of the sheet along its yarns while they are taut [N/m].

    A table's is that of its toe, where crimp goes, from one of its steps on: within that a kink at
    rest, from slack to taut, is rounded. Of other laws, which have no toe or keep its geometry
    however weak the yarns are, it is that of `tension_stiffness`.
    """
    law = fabric.tension
    if not isinstance(law, TabulatedTension):
        return tension_stiffness(fabric)
    energy, flat = _fitted(law, fabric.yarn_width), np.zeros(1)
    steps = 2.0 * np.asarray(energy.spacing)  # of the table: knots lie half as far apart
    warp, weft = (
        strains[strains >= min(step, strains[-1]) - 1e-12]
        for strains, step in zip(_sampled_strains(energy), steps, strict=True)
    )
    return (
        float(energy.derivative(warp, flat, (2, 0)).min()),
        float(energy.derivative(flat, weft, (0, 2)).min()),
    )


def _table_stiffness(energy: SplineEnergy) -> tuple[np.ndarray, np.ndarray]:
    """Largest ∂N_α/∂ε_α of both families, and |∂N1/∂ε2|, inside a table [N/m]."""
    strains = _sampled_strains(energy)
    own = [energy.derivative(*strains, order).max() for order in ((2, 0), (0, 2))]
    cross = np.abs(energy.derivative(*strains, (1, 1))).max()
    floor = LEAST_STIFFNESS * max(*own, cross)
    return np.maximum(own, floor), np.full(2, cross)


def _sampled_strains(energy: SplineEnergy) -> tuple[np.ndarray, np.ndarray]:
    """Strains inside a table, some in every interval [-]."""
    grid = zip(energy.origin, energy.spacing, energy.intervals, strict=True)
    warp, weft = (o + h * np.linspace(0, n, SAMPLES_PER_INTERVAL * n + 1) for o, h, n in grid)
    return warp, weft


def shear_stiffness(fabric: Fabric, up_to_angle: float) -> float:
    """Largest |dC/dγ| [N/m] from 0 to a shear angle [rad]."""
    if isinstance(fabric.tension, Unwoven):
        return initial_shear_stiffness(fabric)
    angles = np.linspace(0.0, up_to_angle, 1001)
    return float(np.abs(fabric.shear.slope(angles)).max()) / fabric.cell_area


def initial_shear_stiffness(fabric: Fabric) -> float:
    """C'(0) [N/m]."""
    if isinstance(fabric.tension, IsotropicMembrane):
        return fabric.tension.stiffness / (2 * (1 + fabric.tension.poisson))
    if isinstance(fabric.tension, MooneyRivlin):
        return fabric.tension.shear_modulus * fabric.thickness
    return float(fabric.shear.slope(0.0)) / fabric.cell_area
