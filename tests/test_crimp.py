"""Crimp interchange against its closed form, and as the gradient of its energy."""

import numpy as np
import pytest
import warp as wp
from law_checks import PLAIN, SPACING, UNEQUAL, assert_tension_is_gradient, away_from, fabric

from warpdrape.errors import InputError
from warpdrape.kernels.materials import crimp
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.law_curves import sample_tensions
from warpdrape.materials.law_data import tension_struct
from warpdrape.materials.laws import CrimpInterchange, LinearTension


@pytest.mark.parametrize("law", [PLAIN, UNEQUAL])
def test_crimp_tension_is_the_gradient_of_its_energy(law):
    rng = np.random.default_rng(2)
    cloth = fabric(law)
    strains = rng.uniform(0.0, 0.02, (300, 2))
    assert_tension_is_gradient(cloth, away_from(strains, [0.0]))
    anywhere = away_from(rng.uniform(-0.05, 0.05, (300, 2)), [0.0])
    slack = (sample_tensions(fabric(law, factor=0.0), anywhere)[0] <= 0.0).any(axis=1)
    assert 20 < slack.sum() < 280
    assert_tension_is_gradient(cloth, anywhere[slack])


def test_crimp_in_python_equals_the_kernel():
    cloth = fabric(UNEQUAL)
    law = tension_struct(cloth)
    for strain in ((0.01, 0.002), (-0.004, 0.02), (-0.3, -0.5), (1.0, -1.0), (-1.0, -1.0)):
        line, energy = sample_tensions(cloth, np.array([strain]))
        called = crimp.crimp_tension(law, wp.vec2d(*strain))
        np.testing.assert_allclose([float(n) for n in called], line[0], rtol=1e-12)
        assert np.isfinite(line).all()
        assert float(crimp.crimp_energy(law, wp.vec2d(*strain))) == pytest.approx(
            energy[0], rel=1e-12
        )


def balanced_tensions(law, strain):
    """T1, T2 [N per yarn] of taut saw-tooth yarns, by a root finder on the printed formulas."""
    from scipy.optimize import brentq

    spacing = np.array([law.spacing_warp, law.spacing_weft])
    crimps = np.array([law.crimp_warp, law.crimp_weft])
    stiffness = np.array([law.stiffness_warp, law.stiffness_weft])
    angle = np.arccos(1 / (1 + crimps))
    rest = spacing / np.cos(angle)
    height = (spacing * np.tan(angle)).sum()

    def state(h1):
        h = np.array([h1, height - h1])
        across = spacing * (1 + np.asarray(strain))
        length = np.sqrt(across**2 + h**2)
        pull = stiffness * (length / rest - 1)
        return pull * h / length, pull * across / length

    root = brentq(lambda h1: np.subtract(*state(h1)[0]), 0, height, xtol=1e-18, rtol=1e-15)
    return state(root)[1]


@pytest.mark.parametrize("law", [PLAIN, UNEQUAL])
def test_crimp_tension_holds_the_balance(law):
    cloth = fabric(law)
    strains = np.random.default_rng(3).uniform(5e-4, 0.02, (60, 2))
    exact = np.array([balanced_tensions(law, e) for e in strains])
    taut = (exact > 0).all(axis=1)
    assert taut.sum() > 40
    found = sample_tensions(cloth, strains[taut])[0] * cloth.yarn_width
    np.testing.assert_allclose(found, exact[taut], rtol=1e-10, atol=1e-9)


# Reference table: T11/T22 [N per yarn] at ε22 = 0, ½ ε11, ε11, 2 ε11, rounded to 4 decimals.
CRIMP_TABLE = {
    0.001: ((18.2860, 16.2439), (26.0355, 24.5790), (33.5956, 33.5956), (48.0770, 53.4619)),
    0.004: ((86.8758, 58.0697), (111.2472, 92.5743), (134.3873, 134.3873), (174.9423, 233.7671)),
    0.010: (
        (256.2879, 117.0170),
        (297.0379, 213.9959),
        (335.9920, 335.9920),
        (398.5439, 622.3548),
    ),
}


def test_crimp_tension_against_the_reference_table():
    cloth = fabric(PLAIN)
    for strain, row in CRIMP_TABLE.items():
        strains = strain * np.array([[1, 0], [1, 0.5], [1, 1], [1, 2]])
        forces = sample_tensions(cloth, strains)[0] * cloth.yarn_width
        np.testing.assert_allclose(forces, row, atol=5.1e-5)


def test_crimp_without_the_other_family_carries_nothing_until_straight():
    cloth = fabric(PLAIN, factor=0.0)
    strains = np.array([[0.002, -0.2], [0.0039, -0.2], [0.006, -0.2], [0.010, -0.2]])
    forces = sample_tensions(cloth, strains)[0] * cloth.yarn_width
    straight = 34e3 * (1 + strains[:, 0]) / 1.004 - 34e3
    np.testing.assert_allclose(forces[:, 0], np.maximum(straight, 0), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(forces[:, 0], [0, 0, 67.7291, 203.1873], atol=5.1e-5)
    np.testing.assert_array_equal(forces[:, 1], 0.0)


def test_crimp_without_crimp_is_linear():
    straight = CrimpInterchange(SPACING, SPACING, 0.0, 0.0, 34e3, 34e3)
    strains = np.random.default_rng(4).uniform(-0.01, 0.01, (50, 2))
    linear = sample_tensions(fabric(LinearTension(34e3, 34e3), cell=(SPACING, SPACING)), strains)
    found = sample_tensions(fabric(straight), strains)
    np.testing.assert_allclose(found[0], linear[0], rtol=1e-9)
    np.testing.assert_allclose(found[1], linear[1], rtol=1e-9)


def test_crimp_spacing_must_be_that_of_the_cell():
    with pytest.raises(InputError, match=r"spacing_warp = 0\.0052 m must equal cell_warp"):
        Fabric(name="x", areal_density=1.0, thickness=1e-3, tension=PLAIN)
