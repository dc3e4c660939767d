"""Fabrics with any law, and the check that a tension is the gradient of its energy."""

import math

import numpy as np

from warpdrape.materials.fabric import Fabric
from warpdrape.materials.law_curves import sample_tensions
from warpdrape.materials.laws import CrimpInterchange, NoShear, TabulatedTension

SPACING = 5.2e-3
PLAIN = CrimpInterchange(SPACING, SPACING, 0.004, 0.004, 34e3, 34e3)
UNEQUAL = CrimpInterchange(4e-3, 6e-3, 0.012, 0.003, 30e3, 55e3)


def fabric(law, shear_law=None, cell=(1.35e-3, 1.33e-3), factor=0.01, angle=math.pi / 2):
    if isinstance(law, CrimpInterchange):
        cell = (law.spacing_warp, law.spacing_weft)
    return Fabric(
        name="test",
        areal_density=0.6,
        thickness=6e-4,
        tension=law,
        shear=shear_law or NoShear(),
        cell_warp=cell[0],
        cell_weft=cell[1],
        compressive_factor=factor,
        yarn_angle=angle,
    )


def crimp_table(n=11, m=9, largest=0.01):
    """A table with a potential: the crimp law's own tensions [N per yarn]."""
    source = fabric(PLAIN)
    axes = np.linspace(0, largest, n), np.linspace(0, largest, m)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    forces = sample_tensions(source, grid.reshape(-1, 2))[0] * source.yarn_width
    return TabulatedTension(*axes, *np.moveaxis(forces.reshape(n, m, 2), 2, 0))


def energy_slope(energy, at, step, direction):
    """Fourth-order central difference of an energy sampled at many points."""
    d = step * direction
    near = energy(at + d) - energy(at - d)
    far = energy(at + 2 * d) - energy(at - 2 * d)
    return (8 * near - far) / (12 * step)


def assert_tension_is_gradient(cloth, strains, step=2e-6, tolerance=1e-8):
    tensions, _ = sample_tensions(cloth, strains)
    scale = np.abs(tensions).max()
    assert scale > 1e3
    for family, direction in enumerate(np.eye(2)):
        slope = energy_slope(lambda e: sample_tensions(cloth, e)[1], strains, step, direction)
        np.testing.assert_allclose(tensions[:, family], slope, atol=tolerance * scale)


def away_from(strains, borders, gap=1e-5):
    """Leave out strains so near a kink of the tension that a difference would straddle it."""
    near = np.abs(strains[:, :, None] - np.asarray(borders)).min(axis=2) < gap
    return strains[~near.any(axis=1)]
