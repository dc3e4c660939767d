"""The isotropic membrane of the paper's Figure 3c: gradient, objectivity, plane stress."""

import numpy as np
import pytest
from element_checks import (
    SIZE,
    deformed,
    energy_gradient,
    forces,
    measured,
    membrane_of,
    patch_ply,
    rotations,
)
from law_checks import fabric

from warpdrape.blanks.ply import Ply
from warpdrape.materials.laws import IsotropicMembrane

STIFFNESS, POISSON = 2e4, 0.3
SHEET = fabric(IsotropicMembrane(STIFFNESS, POISSON))


def sheet(warp_angle=0.0, pattern="random"):
    return Ply.rectangle("sheet", SHEET, 0.04, 0.03, edge=SIZE, mesh=pattern, warp_angle=warp_angle)


def test_force_is_minus_the_gradient_of_the_energy(device):
    rng = np.random.default_rng(1)
    ply = patch_ply(SHEET, "triangle", 200, rng)
    membrane = membrane_of(ply, device)
    x = deformed(ply, "triangle", rng, (-0.05, 0.1), shear_deg=30.0, noise=0.05)
    f = forces(membrane, x, device).reshape(-1, 9)
    scale = np.abs(f).max(axis=1)
    assert scale.min() > 1e-3 * STIFFNESS * SIZE
    slope = energy_gradient(membrane, x, "triangle", device).reshape(-1, 9)
    assert (np.abs(f + slope).max(axis=1) / scale).max() < 3e-9


def test_rigid_motion_gives_no_force_and_forces_balance(device):
    ply = sheet()
    membrane = membrane_of(ply, device)
    rng = np.random.default_rng(2)
    for turn in rotations(rng, 5):
        x = ply.rest_points @ turn.T + (0.1, -0.2, 0.05)
        rounding = 20 * 3e-17 * STIFFNESS
        assert np.abs(forces(membrane, x, device)).max() < rounding
        assert np.abs(forces(membrane, x * (1 + 1e-9), device)).max() > rounding
    x += 0.05 * SIZE * rng.uniform(-1, 1, x.shape)
    f = forces(membrane, x, device)
    scale = np.abs(f).sum()
    assert scale > 1.0
    assert np.abs(f.sum(axis=0)).max() < 1e-14 * scale
    assert np.abs(np.cross(x, f).sum(axis=0)).max() < 1e-14 * scale


def test_material_axes_do_not_matter(device):
    # Where the yarns would lie is a mere choice of axes for an isotropic law.
    rng = np.random.default_rng(3)
    straight, turned = sheet(), sheet(warp_angle=0.7)
    x = straight.rest_points + 0.05 * SIZE * rng.uniform(-1, 1, straight.rest_points.shape)
    first, second = (forces(membrane_of(ply, device), x, device) for ply in (straight, turned))
    assert np.abs(first).max() > 1.0
    np.testing.assert_allclose(second, first, atol=1e-11 * np.abs(first).max())


def test_uniaxial_tension_contracts_by_poissons_ratio(device):
    # In Green-Lagrange strains E2 = −ν E1 leaves the sides free, and W = A E h E1²/2.
    ply = sheet()
    green = 0.02
    stretch = np.sqrt([1 + 2 * green, 1 - 2 * POISSON * green])
    x = ply.rest_points * (*stretch, 1.0)
    f = forces(membrane_of(ply, device), x, device)
    ends = np.isclose(np.abs(ply.rest_points[:, 0]), 0.02)
    pull = STIFFNESS * green * stretch[0] * 0.03
    right = ply.rest_points[:, 0] > 0.0199
    assert f[right, 0].sum() == pytest.approx(-pull, rel=1e-12)
    assert np.abs(f[~ends]).max() < 1e-12 * pull
    assert np.abs(f[:, 1:]).max() < 1e-12 * pull
    strain, tension, energy = measured(membrane_of(ply, device), x, device)
    np.testing.assert_allclose(strain, np.broadcast_to(stretch - 1, strain.shape), atol=1e-13)
    # Per initial width: the second Piola–Kirchhoff stress times the stretch.
    carried = STIFFNESS * green * strain[:, 0] + STIFFNESS * green
    np.testing.assert_allclose(tension[:, 0], carried, rtol=1e-12)
    np.testing.assert_allclose(tension[:, 1], 0.0, atol=1e-10)
    assert energy.sum() == pytest.approx(0.5 * STIFFNESS * green**2 * 0.04 * 0.03, rel=1e-12)


def test_pure_shear_has_the_modulus_of_an_isotropic_sheet(device):
    # E12 = γ/2 and W = A G h γ²/2, G = E/(2 (1 + ν)).
    ply = sheet()
    slide = 1e-4
    x = ply.rest_points + slide * ply.rest_points[:, [1]] * (1.0, 0.0, 0.0)
    energy = measured(membrane_of(ply, device), x, device)[2].sum()
    shear = 0.5 * STIFFNESS / (1 + POISSON)
    assert energy == pytest.approx(0.5 * shear * slide**2 * 0.04 * 0.03, rel=1e-7)
