"""Rubber sheets: force and energy, closed forms, the bound of the step, what becomes of them."""

import dataclasses
import json

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
from test_time_step import true_frequency_squared

from warpdrape import Fabric, Ply, Scene
from warpdrape.dynamics.time_step import lump_masses
from warpdrape.errors import InputError
from warpdrape.laws import IsotropicMembrane, MooneyRivlin
from warpdrape.materials.fabric_card import card
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.materials.rubber import LEAST_OF_FREE
from warpdrape.verification import rubber as cases

C10, C01, THICK = 2e5, 5e4, 1.5e-3


def sheet_of(c01=C01, **given):
    return Fabric.rubber("rubber", thickness=THICK, density=1100.0, c10=C10, c01=c01, **given)


def square(c01=C01, edge=SIZE):
    return Ply.rectangle("sheet", sheet_of(c01), 0.04, 0.03, edge=edge, mesh="random")


def stretched(ply, one, other):
    return ply.rest_points * (one, other, 1.0)


def nominal(one, other, c01=C01):
    """Nominal stresses [Pa]: σ_i/λ_i, Cauchy's σ_i = 2 (λ_i² − λ3²)(C10 + C01 λ_j²)."""
    third = 1.0 / (one * other)
    first = 2.0 * (one**2 - third**2) * (C10 + c01 * other**2) / one
    return first, 2.0 * (other**2 - third**2) * (C10 + c01 * one**2) / other


@pytest.mark.parametrize("c01", [0.0, C01])
def test_force_is_minus_the_gradient_of_the_energy(c01, device):
    rng = np.random.default_rng(1)
    cloth = sheet_of(c01)
    ply = patch_ply(cloth, "triangle", 200, rng)
    membrane = membrane_of(ply, device)
    x = deformed(ply, "triangle", rng, (-0.2, 1.5), shear_deg=40.0, noise=0.1)
    f = forces(membrane, x, device).reshape(-1, 9)
    scale = np.abs(f).max(axis=1)
    assert scale.min() > 1e-2 * C10 * THICK * SIZE
    slope = energy_gradient(membrane, x, "triangle", device).reshape(-1, 9)
    assert (np.abs(f + slope).max(axis=1) / scale).max() < 3e-9


def test_rigid_motion_gives_no_force_and_axes_do_not_matter(device):
    ply = square()
    membrane = membrane_of(ply, device)
    rng = np.random.default_rng(2)
    for turn in rotations(rng, 3):
        x = ply.rest_points @ turn.T + (0.1, -0.2, 0.05)
        assert np.abs(forces(membrane, x, device)).max() < 1e-12 * C10 * THICK
    x += 0.1 * SIZE * rng.uniform(-1, 1, x.shape)
    f = forces(membrane, x, device)
    turned = dataclasses.replace(ply, warp_angle=0.7)
    np.testing.assert_allclose(
        forces(membrane_of(turned, device), x, device), f, atol=1e-11 * np.abs(f).max()
    )
    assert np.abs(f).max() > 0.1 and np.abs(f.sum(axis=0)).max() < 1e-14 * np.abs(f).sum()


@pytest.mark.parametrize("c01", [0.0, C01])
@pytest.mark.parametrize("stretch", [0.9, 1.3, 2.0, 3.0])
def test_a_strip_pulled_one_way_bears_what_the_closed_form_says(stretch, c01, device):
    """Free sides, λ2 = λ^−½: P = 2 (λ − λ⁻²)(C10 + C01/λ)."""
    ply = square(c01)
    membrane = membrane_of(ply, device)
    x = stretched(ply, stretch, stretch**-0.5)
    f = forces(membrane, x, device)
    right = ply.rest_points[:, 0] > 0.0199
    ends = np.abs(ply.rest_points[:, 0]) > 0.0199
    pull = 2.0 * (stretch - stretch**-2) * (C10 + c01 / stretch) * THICK * 0.03
    assert f[right, 0].sum() == pytest.approx(-pull, rel=1e-11)
    assert np.abs(f[~ends]).max() < 1e-12 * abs(pull) and np.abs(f[:, 1]).max() < 1e-11 * abs(pull)
    strain, tension, _ = measured(membrane, x, device)
    np.testing.assert_allclose(strain[:, 0], stretch - 1.0, atol=1e-13)
    np.testing.assert_allclose(tension[:, 0] * 0.03, pull, rtol=1e-11)


@pytest.mark.parametrize("sides", [(1.5, 1.5), (2.5, 2.5), (2.0, 1.0), (1.2, 1.8)])
def test_a_sheet_pulled_both_ways_bears_what_the_closed_form_says(sides, device):
    ply = square()
    membrane = membrane_of(ply, device)
    f = forces(membrane, stretched(ply, *sides), device)
    for axis, width in ((0, 0.03), (1, 0.04)):
        half = 0.0199 if axis == 0 else 0.0149
        pull = nominal(*sides)[axis] * THICK * width
        edge = ply.rest_points[:, axis] > half
        assert f[edge, axis].sum() == pytest.approx(-pull, rel=1e-11)
    energy = measured(membrane, stretched(ply, *sides), device)[2].sum()
    one, other = sides
    volume = THICK * 0.04 * 0.03
    squares = one**2, other**2, (one * other) ** -2
    first = sum(squares) - 3.0
    second = sum(1.0 / s for s in squares) - 3.0
    assert energy == pytest.approx(volume * (C10 * first + C01 * second), rel=1e-12)


def test_small_strains_are_those_of_an_isotropic_sheet_with_poissons_ratio_a_half(device):
    rubber = square()
    young = 6.0 * (C10 + C01)
    with_half = dataclasses.replace(
        rubber.fabric, tension=IsotropicMembrane(young * THICK, 0.5 - 1e-9)
    )
    rng = np.random.default_rng(3)
    x = rubber.rest_points + 1e-6 * SIZE * rng.uniform(-1, 1, rubber.rest_points.shape)
    ours, theirs = (
        forces(membrane_of(dataclasses.replace(rubber, fabric=of), device), x, device)
        for of in (rubber.fabric, with_half)
    )
    np.testing.assert_allclose(ours, theirs, atol=2e-5 * np.abs(theirs).max())


@pytest.mark.parametrize("c01", [0.0, C01])
def test_stable_step_is_safe_up_to_the_largest_stretch_and_not_far_too_short(c01):
    ply = Ply.rectangle("ply", sheet_of(c01, bends=False), 0.02, cells=3, mesh="random")
    scene = Scene(name="step", plies=[ply], duration=1.0)
    masses = lump_masses(scene)
    bound = 4 / masses.stable_step**2
    membrane = membrane_of(ply)
    sides = [(1, 1), (1.5, 1.5), (3, 3), (3, 1), (3, 3**-0.5), (2, 0.5**0.5), (1, LEAST_OF_FREE)]
    sides += [(LEAST_OF_FREE, LEAST_OF_FREE)]
    true = [true_frequency_squared(membrane, masses.mass, stretched(ply, *both)) for both in sides]
    assert max(true) <= bound < 9.0 * max(true)  # three times in the step: meshes, and the range


@pytest.mark.parametrize("law", [MooneyRivlin(2e5), MooneyRivlin(2e5, 5e4), MooneyRivlin(1e5, 1e5)])
def test_stiffest_is_the_largest_eigenvalue_of_the_second_derivatives(law):
    """By differences of the energy in all six components of the sheet's gradient."""

    def energy(gradient):
        c = gradient.T @ gradient
        trace, area = np.trace(c), np.linalg.det(c)
        return law.c10 * (trace + 1 / area - 3) + law.c01 * (area + trace / area - 3)

    def largest(one, other):
        base, step = np.zeros((3, 2)), 1e-4
        base[0, 0], base[1, 1] = one, other
        hessian = np.zeros((6, 6))
        for i in range(6):
            for j in range(6):
                for a in (1, -1):
                    for b in (1, -1):
                        move = base.copy()
                        move.flat[i] += a * step
                        move.flat[j] += b * step
                        hessian[i, j] += a * b * energy(move) / (4 * step**2)
        return np.linalg.eigvalsh(hessian).max()

    last = law.largest_stretch
    corners = [(last, last), (last, 0.9 * last**-0.5), (0.9, 0.9), (1.0, 0.9), (last, 1.0)]
    found = max(largest(*corner) for corner in corners)
    assert law.stiffest == pytest.approx(found, rel=0.03)  # a grid of stretches, 2 % apart


def test_a_ball_converges_to_the_closed_form_at_second_order():
    for stretch, c01 in ((1.2, 0.0), (2.0, 2e4)):
        exact = cases.sphere(stretch, cases.C10, c01)
        errors = [cases.ball_pressure(stretch, cases.C10, c01, n) / exact - 1.0 for n in (2, 3, 4)]
        rates = np.log2(np.array(errors[:-1]) / errors[1:])
        np.testing.assert_allclose(rates, 2.0, atol=0.05)
        # Extrapolated, what is left is far below a thousandth.
        assert abs((4 * errors[2] - errors[1]) / 3) < 1e-4


def test_a_sheet_that_is_blown_up_becomes_thinner_and_says_where_it_leaves_its_data(tmp_path):
    scene = cases.pulled(2.0, both=True)
    soft = dataclasses.replace(
        scene.plies[0].fabric, tension=MooneyRivlin(cases.C10, cases.C01, 1.9)
    )
    scene = dataclasses.replace(scene, plies=[dataclasses.replace(scene.plies[0], fabric=soft)])
    result = scene.run(tmp_path / "run", frames=2, quiet=True)
    assert result.completed and result.summary["energy_error"] < 2e-3  # in a thousand steps
    np.testing.assert_allclose(result.plies[0].thickness, cases.THICKNESS / 4.0, rtol=2e-4)
    entry = result.summary["plies"][0]
    assert entry["thickness_m"]["mean"] == pytest.approx(cases.THICKNESS / 4.0)
    (said,) = [text for text in result.summary["warnings"] if "beyond the last" in text]
    assert "ply 'sheet': stretch comes to 2, beyond the last of its fabric's data, 1.9" in said
    record = json.loads((tmp_path / "run" / "run.json").read_text("utf-8"))
    assert record["fabrics"]["rubber"]["tension"]["c10"] == cases.C10
    within = cases.pulled(1.5, both=False).run(frames=2, quiet=True)
    assert not [text for text in within.summary["warnings"] if "beyond" in text]


def test_the_closed_form_of_the_bubble_is_that_of_a_shallow_one_at_small_pressures():
    """Another theory, linear in strain and for small slopes: Hencky's, with ν = ½."""
    from warpdrape.verification.bulge import hencky

    young, pressure = 6.0 * (cases.C10 + cases.C01), 20.0
    exact = 0.05 * hencky(pressure, 0.05, young * cases.THICKNESS, 0.5)
    assert cases.blown_height(pressure, 0.05) == pytest.approx(exact, rel=0.01)


def test_a_card_of_rubber_is_read_and_shown(tmp_path):
    told = 'status = "measured", source = "own test"'
    path = tmp_path / "bag.toml"
    path.write_text(
        f"""name = "bag"
areal_density = {{ value = 1650, unit = "g/m2", {told} }}
thickness = {{ value = 1.5, unit = "mm", {told} }}
[tension]
law = "rubber"
c10 = {{ value = 0.2, unit = "MPa", {told} }}
c01 = {{ value = 50, unit = "kPa", {told} }}
largest_stretch = {{ value = 2.5, unit = "-", {told} }}
[bending]
law = "solid"
""",
        encoding="utf-8",
    )
    fabric = load_fabric(path)
    assert fabric.tension == MooneyRivlin(2e5, 5e4, 2.5)
    made = sheet_of(largest_stretch=2.5)
    assert fabric.bending.warp == pytest.approx(made.bending.warp)
    assert made.bending.warp == pytest.approx(2.0 * (C10 + C01) * THICK**3 / 3.0)  # G h³/3
    assert made.areal_density == pytest.approx(1.65) and fabric.bends
    shown = card(fabric)
    assert "incompressible rubber (Mooney–Rivlin)" in shown and "200000 Pa" in shown


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"c10": 0.0}, "rubber c10 = 0"),
        ({"c01": -1.0}, "rubber c01 = -1 Pa is below zero"),
        ({"c10": 0.3}, "softer than any rubber: give Pa, 0.3 MPa as 0.3e6"),
        ({"density": 1.1}, "density = 1.1 kg/m³: give kg/m³, 1100 and not 1.1"),
        ({"thickness": 0.0}, "thickness = 0"),
        ({"thickness": 1.0}, "thickness = 1.0 m: give metres, not millimetres"),
        ({"largest_stretch": 1.0}, "rubber largest_stretch = 1 must lie above 1"),
    ],
)
def test_rubber_that_cannot_be_is_refused(given, words):
    options = {"thickness": 1e-3, "density": 1100.0, "c10": 2e5} | given
    with pytest.raises(InputError, match=words) as refused:
        Fabric.rubber("rubber", **options)
    assert "\n" not in str(refused.value)
