"""Laws of yarns and shear: tension and couple are the gradients of their energies."""

import math

import numpy as np
import pytest
import warp as wp
from law_checks import (
    PLAIN,
    SPACING,
    UNEQUAL,
    assert_tension_is_gradient,
    away_from,
    crimp_table,
    energy_slope,
    fabric,
)

from warpdrape.errors import InputError
from warpdrape.kernels.materials import shear, tension
from warpdrape.materials.law_curves import sample_couples, sample_tensions
from warpdrape.materials.law_data import (
    initial_shear_stiffness,
    membrane_functions,
    shear_stiffness,
    shear_struct,
    tension_stiffness,
    tension_struct,
)
from warpdrape.materials.laws import (
    CrimpInterchange,
    IsotropicMembrane,
    LinearTension,
    ShearPolynomial,
    ShearTable,
    TabulatedTension,
    falling_angle,
)

INTERLOCK = ShearPolynomial((0.37044e-3, -0.84105e-3, 1.03113e-3))
CURVE = ShearTable(np.radians([0, 5, 20, 35, 50, 60]), [0, 0.3e-4, 1e-4, 1.2e-4, 2.9e-4, 7.2e-4])


@pytest.mark.parametrize("factor", [0.0, 0.01, 1.0])
def test_linear_tension_is_the_gradient_of_its_energy(factor):
    rng = np.random.default_rng(1)
    strains = away_from(rng.uniform(-0.02, 0.02, (200, 2)), [0.0])
    assert_tension_is_gradient(fabric(LinearTension(46e3, 48e3), factor=factor), strains)


def test_linear_tension_in_python():
    law = tension_struct(fabric(LinearTension(46e3, 48e3), cell=(1.25e-3, 1.6e-3)))
    force = tension.linear_tension(law, wp.vec2d(0.01, -0.01))
    assert float(force[0]) == pytest.approx(46e3 * 0.01 / 1.6e-3, rel=1e-14)
    assert float(force[1]) == pytest.approx(-0.01 * 48e3 * 0.01 / 1.25e-3, rel=1e-14)
    energy = tension.linear_energy(law, wp.vec2d(0.01, -0.01))
    assert float(energy) == pytest.approx(
        0.5 * 0.01 * (float(force[0]) - float(force[1])), rel=1e-14
    )


def hessians(cloth, strains, step=1e-7):
    columns = [
        sample_tensions(cloth, strains + step * d)[0]
        - sample_tensions(cloth, strains - step * d)[0]
        for d in np.eye(2)
    ]
    matrix = np.stack(columns, axis=-1) / (2 * step)
    return (matrix + matrix.transpose(0, 2, 1)) / 2


@pytest.mark.parametrize("kind", ["linear", "plain", "unequal", "table"])
def test_tension_stiffness_is_an_upper_bound_and_a_near_one(kind):
    laws = {"linear": LinearTension(46e3, 48e3), "plain": PLAIN, "unequal": UNEQUAL}
    cell = (SPACING, SPACING) if kind == "table" else (1.35e-3, 1.33e-3)
    cloth = fabric(crimp_table() if kind == "table" else laws[kind], cell=cell)
    strains = away_from(np.random.default_rng(6).uniform(-0.01, 0.02, (2000, 2)), [0, 0.01], 1e-6)
    bound = np.array(tension_stiffness(cloth))
    scaled = hessians(cloth, strains) / np.sqrt(np.outer(bound, bound))
    largest = np.linalg.eigvalsh(scaled).max()
    assert 0.6 < largest < 1.0 + 1e-6


SHEARS = {
    "polynomial": INTERLOCK,
    "four terms": ShearPolynomial((4e-4, -5e-4, 3e-4, 2e-4)),
    "curve": CURVE,
}


@pytest.mark.parametrize("name", SHEARS)
def test_couple_is_the_slope_of_its_energy_and_odd(name):
    cloth = fabric(LinearTension(1e4, 1e4), SHEARS[name])
    angles = np.linspace(-1.3, 1.3, 201)
    couples, energies = sample_couples(cloth, angles)
    assert np.abs(couples).max() > 50
    slope = energy_slope(lambda a: sample_couples(cloth, a)[1], angles, 1e-5, 1.0)
    np.testing.assert_allclose(couples, slope, atol=1e-8 * np.abs(couples).max())
    np.testing.assert_allclose(couples, -couples[::-1], atol=1e-13)
    np.testing.assert_allclose(energies, energies[::-1], atol=1e-13)
    np.testing.assert_allclose(couples * cloth.cell_area, SHEARS[name].couple(angles), rtol=1e-12)
    assert (energies >= 0).all()
    assert energies[100] == 0.0


def test_shear_polynomial_in_python():
    law = shear_struct(fabric(LinearTension(1e4, 1e4), INTERLOCK, cell=(1 / 740, 1 / 750)))
    cell = 1 / 740 / 750
    # Tabulated couples of the reference fabric [N·mm per cell].
    for degrees, couple in ((5, 0.03177), (30, 0.11381), (45, 0.19163), (70, 1.72552)):
        angle = wp.float64(math.radians(degrees))
        found = float(shear.polynomial_couple(law, angle)) * cell * 1e3
        assert found == pytest.approx(couple, abs=6e-6)
    assert float(shear.polynomial_energy(law, wp.float64(0.0))) == 0.0


def test_curve_is_linear_and_continuous_past_its_last_point():
    cloth = fabric(LinearTension(1e4, 1e4), CURVE)
    last = CURVE.angles[-1]
    couples, _ = sample_couples(cloth, last + np.array([-1e-9, 0.0, 1e-9, 0.1, 0.2]))
    np.testing.assert_allclose(couples[:3], couples[1], rtol=1e-6)
    np.testing.assert_allclose(couples[4] - couples[3], couples[3] - couples[1], rtol=1e-9)
    assert couples[3] > couples[1]


def test_curve_does_not_fall_between_its_points():
    couples, _ = sample_couples(fabric(LinearTension(1e4, 1e4), CURVE), np.linspace(0, 1.2, 500))
    assert (np.diff(couples) >= 0).all()


def test_shear_stiffness_is_the_largest_slope():
    cloth = fabric(LinearTension(1e4, 1e4), INTERLOCK)
    initial = 0.37044e-3 / cloth.cell_area
    assert initial_shear_stiffness(cloth) == pytest.approx(initial)
    assert shear_stiffness(cloth, 0.3) == pytest.approx(initial)
    assert shear_stiffness(cloth, 1.2) == pytest.approx(INTERLOCK.slope(1.2) / cloth.cell_area)
    assert initial_shear_stiffness(fabric(LinearTension(1e4, 1e4))) == 0.0
    membrane = fabric(IsotropicMembrane(1e4, 0.3))
    assert shear_stiffness(membrane, 1.0) == pytest.approx(1e4 / 2.6)
    assert tension_stiffness(membrane)[0] == pytest.approx(1e4 / 0.7)


def test_yarn_force_times_yarns_per_width_is_the_line_tension():
    angle = math.radians(70)
    cloth = fabric(LinearTension(46e3, 48e3), cell=(2e-3, 3e-3), angle=angle)
    assert cloth.yarn_width == pytest.approx((3e-3 * math.sin(angle), 2e-3 * math.sin(angle)))
    line, energy = sample_tensions(cloth, np.array([[0.01, 0.02]]))
    assert line[0] * cloth.yarn_width == pytest.approx([460.0, 960.0])
    # A cell's energy is that of its two yarns: L1 ∫T1 dε1 + L2 ∫T2 dε2.
    yarns = 2e-3 * 460.0 * 0.01 / 2 + 3e-3 * 960.0 * 0.02 / 2
    assert energy[0] * cloth.cell_area == pytest.approx(yarns)


def test_membrane_functions_refuse_an_isotropic_membrane():
    with pytest.raises(InputError, match="isotropic"):
        membrane_functions(fabric(IsotropicMembrane(1e4)))


def test_isotropic_struct_holds_the_law():
    law = tension_struct(fabric(IsotropicMembrane(1e4, 0.25)))
    assert (law.stiffness, law.poisson) == (1e4, 0.25)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: CrimpInterchange(0.0, 1e-3, 0.1, 0.1, 1e4, 1e4), "spacing_warp"),
        (lambda: CrimpInterchange(1e-3, 1e-3, 0.1, 4.0, 1e4, 1e4), "crimp_weft = 4.0 .*fraction"),
        (
            lambda: TabulatedTension([1, 2, 3, 4], [0, 1, 2, 3], np.ones((4, 4)), np.ones((4, 4))),
            "strain_warp .*zero strain",
        ),
    ],
)
def test_bad_laws_are_refused(make, words):
    with pytest.raises(InputError, match=words):
        make()


def test_falling_couple_is_warned_about():
    falling = ShearPolynomial((0.37044e-3, -0.84105e-3))
    angle = math.sqrt(0.37044 / (3 * 0.84105))
    assert falling_angle(falling) == pytest.approx(angle, abs=2e-4)
    assert falling_angle(INTERLOCK) is None
    with pytest.warns(UserWarning, match=f"falls beyond {math.degrees(angle):.1f}°"):
        fabric(LinearTension(1e4, 1e4), falling)


@pytest.mark.parametrize(
    ("angles", "couples", "remedy"),
    [
        ((0.0, 0.2, 0.4), (0.01, 0.02, 0.05), "take that off all couples"),
        ((0.1, 0.2, 0.4), (0.01, 0.02, 0.05), "put 0° with no couple before it"),
    ],
)
def test_a_table_with_an_offset_is_refused_with_a_remedy_that_works(angles, couples, remedy):
    with pytest.raises(InputError, match=remedy):
        ShearTable(angles, couples)
    if angles[0] == 0.0:
        ShearTable(angles, [couple - couples[0] for couple in couples])
    else:
        ShearTable((0.0, *angles), (0.0, *couples))
