"""Tabulated tensions: the fitted energy, its gradient, and what lies outside the table."""

import numpy as np
import pytest
from law_checks import SPACING, assert_tension_is_gradient, away_from, crimp_table, fabric

from warpdrape.errors import InputError
from warpdrape.materials.law_curves import sample_tensions
from warpdrape.materials.law_data import tension_stiffness, tension_struct
from warpdrape.materials.laws import TabulatedTension
from warpdrape.materials.spline import fit_energy

WIDTH = (SPACING, SPACING)


@pytest.fixture(scope="module")
def table():
    return crimp_table()


def table_of(tensions, n=7, m=6, largest=0.01):
    """Table of a function (ε1, ε2) → (T1, T2) [N per yarn]."""
    axes = np.linspace(0, largest, n), np.linspace(0, largest, m)
    return TabulatedTension(*axes, *tensions(*np.meshgrid(*axes, indexing="ij")))


def test_linear_table_is_fitted_exactly():
    energy = fit_energy(table_of(lambda a, b: (3e4 * a + 1e4 * b, 1e4 * a + 4e4 * b)), WIDTH)
    assert energy.misfit < 1e-12
    assert energy.warning == ""
    assert energy.coefficients.shape == (15, 13)  # knots lie half as far apart as the strains
    at = np.array([0.0, 0.0033, 0.01])
    warp, weft = np.meshgrid(at, at, indexing="ij")
    exact = (1.5e4 * warp**2 + 1e4 * warp * weft + 2e4 * weft**2) / SPACING
    np.testing.assert_allclose(energy.derivative(at, at, (0, 0)), exact, atol=1e-10)
    np.testing.assert_allclose(energy.derivative(at, at, (1, 1)), 1e4 / SPACING, rtol=1e-8)


def test_widths_of_the_yarns_enter_the_energy():
    # N1 = T1/b1, N2 = T2/b2 and L1 ∂T1/∂ε2 = L2 ∂T2/∂ε1, b1/b2 = L2/L1.
    energy = fit_energy(
        table_of(lambda a, b: (3e4 * a + 2e4 * b, 1e4 * a + 4e4 * b)), (2 * SPACING, SPACING)
    )
    assert energy.misfit < 1e-12


def test_smooth_table_is_fitted_better_on_a_finer_grid():
    misfits = [fit_energy(crimp_table(n, n), WIDTH).misfit for n in (4, 8, 16, 32)]
    assert misfits[0] < 1e-3
    assert misfits[3] < 0.01 * misfits[0]


@pytest.mark.parametrize("onset", [0.0031, 0.004, 0.0052])
def test_yarns_that_are_slack_stay_slack(onset):
    """Tension sets in within a step of the table: two steps before there is none of it."""
    stiffness, largest = 3e4, 0.01

    def taut(strain):
        return stiffness * np.maximum(strain - onset, 0.0)

    axis = np.linspace(-largest, largest, 15)
    warp, weft = np.meshgrid(axis, axis, indexing="ij")
    energy = fit_energy(TabulatedTension(axis, axis, taut(warp), taut(weft)), WIDTH)
    assert energy.misfit < 0.02
    step, most = axis[1] - axis[0], taut(largest)
    fine = np.linspace(-largest, largest, 401)
    tension = SPACING * energy.derivative(fine, axis, (1, 0))
    slack = tension[fine < onset - 2.0 * step]
    assert len(slack) > 200
    assert np.abs(slack).max() < 1e-3 * most  # with knots at whole steps 1 %
    further = (fine < onset - 4.0 * step) & (fine > onset - 6.0 * step)
    assert np.abs(tension[further]).max() < 1e-5 * most  # ripples die out
    assert np.abs(tension - taut(fine)[:, None]).max() < 0.5 * stiffness * step


def test_energy_at_rest_is_zero():
    axis = np.linspace(-0.004, 0.01, 8)
    warp, weft = np.meshgrid(axis, axis, indexing="ij")
    cloth = fabric(TabulatedTension(axis, axis, 3e4 * warp, 3e4 * weft), cell=WIDTH)
    tensions, energies = sample_tensions(cloth, np.zeros((1, 2)))
    assert abs(energies[0]) < 1e-12
    np.testing.assert_allclose(tensions, 0.0, atol=1e-6)


def test_table_without_a_potential_is_refused():
    with pytest.raises(InputError, match="no potential"):
        fit_energy(table_of(lambda a, b: (1e4 * a + 3e4 * b, -3e4 * a + 1e4 * b)), WIDTH)


def test_table_with_a_poor_potential_is_warned_about():
    cloth = fabric(table_of(lambda a, b: (3e4 * a + 1.5e3 * b, -1.5e3 * a + 3e4 * b)), cell=WIDTH)
    with pytest.warns(UserWarning, match="potential only within"):
        tension_struct(cloth)


def test_table_of_one_family_only():
    cloth = fabric(table_of(lambda a, b: (3e4 * a, 0 * b)), cell=WIDTH)
    strains = np.random.default_rng(1).uniform(-0.02, 0.02, (50, 2))
    tensions, energies = sample_tensions(cloth, strains)
    assert np.isfinite(tensions).all() and np.isfinite(energies).all()
    assert np.abs(tensions[:, 1]).max() < 1e-3 * np.abs(tensions[:, 0]).max()


def test_table_of_zeros_is_refused():
    with pytest.raises(InputError, match="all zero"):
        fit_energy(table_of(lambda a, b: (0 * a, 0 * b)), WIDTH)


def test_tabulated_tension_is_the_gradient_of_its_energy(table):
    rng = np.random.default_rng(5)
    cloth = fabric(table, cell=(SPACING, SPACING))
    borders = [0.0, 0.01]
    for low, high in ((0.0, 0.01), (-0.005, 0.015), (-0.1, 0.05)):
        # The step is far below the strain over which a tension fades below the table.
        strains = away_from(rng.uniform(low, high, (400, 2)), borders, gap=5e-5)
        assert_tension_is_gradient(cloth, strains, step=1e-6, tolerance=2e-8)


def test_tabulated_tension_is_continuous_across_borders(table):
    cloth = fabric(table, cell=(SPACING, SPACING))
    along = np.linspace(-0.005, 0.015, 101)
    for border in (0.0, 0.01):
        for family in (0, 1):
            gap = 1e-11
            sides = []
            for side in (-gap, gap):
                strains = np.stack([np.full_like(along, border + side), along], axis=1)
                sides.append(sample_tensions(cloth, strains[:, ::-1] if family else strains)[0])
            assert np.abs(sides[0]).max() > 1e3
            stiffest = max(tension_stiffness(cloth))
            np.testing.assert_allclose(sides[0], sides[1], atol=8 * gap * stiffest)


def test_tabulated_tension_is_safe_outside_its_table(table):
    cloth = fabric(table, cell=(SPACING, SPACING))
    pressed = np.stack([np.linspace(-0.2, 0, 50), np.full(50, 0.005)], axis=1)
    found = sample_tensions(cloth, pressed)[0]
    assert (found[:, 1] > 0).all()  # a slack warp does not press the stretched weft together
    resistance = cloth.compressive_factor * tension_stiffness(cloth)[0]
    assert (found[:-1, 0] >= 1.1 * resistance * pressed[:-1, 0]).all()
    stretched = np.stack([np.linspace(0.01, 0.05, 50), np.full(50, 0.004)], axis=1)
    assert (np.diff(sample_tensions(cloth, stretched)[0][:, 0]) > 0).all()
