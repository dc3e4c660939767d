"""Stress as a state: objective, the card's in the yarns' frame, the closed forms in R's."""

import math

import numpy as np
import pytest
import warp as wp
from element_checks import SIZE, forces, membrane_of, rotations, whole
from law_checks import PLAIN, SPACING, crimp_table, fabric
from test_membrane import CURVE, INTERLOCK, STIFF, blank, shaken

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import flat_gradients, highest_frequency_squared
from warpdrape.forces import fibre_frame, green_naghdi
from warpdrape.forces.hypoelastic import build_stressed
from warpdrape.kernels.forces.objective_rates import fibre_rows, polar_rows
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.law_curves import sample_couples, sample_tensions
from warpdrape.materials.law_data import initial_shear_stiffness, tension_stiffness
from warpdrape.materials.laws import IsotropicMembrane, LinearTension
from warpdrape.numerics import Numerics
from warpdrape.scene import Scene
from warpdrape.verification.hypoelastic import dienes_stress
from warpdrape.verification.led_sheet import ROWS, LedSheet, loop, pair_of, trellis

CELL = (1.35e-3, 1.33e-3)
BOTH_WAYS = fabric(STIFF, INTERLOCK, factor=1.0)
"""As stiff in compression as in tension: one orthotropic C."""
MODULI = np.array([STIFF.warp, STIFF.weft]) / BOTH_WAYS.yarn_width
SHEET = Fabric(
    name="sheet",
    areal_density=0.1,
    thickness=1e-4,
    tension=IsotropicMembrane(stiffness=2e4, poisson=0.3),
)


def stretch_of(gradient):
    """U of F = R U by its eigenvectors."""
    values, vectors = np.linalg.eigh(gradient.T @ gradient)
    return vectors * np.sqrt(values) @ vectors.T


def seen_by_r(gradients, rest_angle=0.5 * math.pi):
    """(e1, e2, γ) that the frame of R has seen on a fine path: D = sym(dU U⁻¹), [3]."""
    flat = np.array([[1.0, math.cos(rest_angle)], [0.0, math.sin(rest_angle)]])
    seen, before = np.zeros((2, 2)), np.eye(2)
    for gradient in gradients:
        now = stretch_of(gradient)
        rate = (now - before) @ np.linalg.inv(0.5 * (now + before))
        seen, before = seen + 0.5 * (rate + rate.T), now
    along = np.einsum("ia,ij,ja->a", flat, seen, flat)
    across = 2.0 * flat[:, 0] @ seen @ flat[:, 1] - math.cos(rest_angle) * along.sum()
    return np.r_[along, across / math.sin(rest_angle)]


def wandering(steps, rng, size=0.3):
    """A smooth path of gradients of space from the flat ply, turning as it goes."""
    s = np.linspace(0.0, 1.0, steps + 1)[1:, None, None]
    a, b = size * rng.standard_normal((2, 2, 2))
    flat = np.eye(2) + np.sin(1.5 * s) * a + s**2 * b
    c, n = np.cos(2.0 * s), np.sin(2.0 * s)
    turn = np.concatenate(
        [
            np.concatenate([c, 0 * s], 2),
            np.concatenate([0 * s, c**0], 2),
            np.concatenate([n, 0 * s], 2),
        ],
        1,
    )  # about y, out of the plane
    return flat, turn @ flat


@pytest.mark.parametrize("approach", ROWS)
@pytest.mark.parametrize("steps", [8, 720])
def test_two_turns_in_space_leave_the_stress(approach, steps, device):
    cloth = fabric(STIFF, INTERLOCK, angle=math.radians(75))
    led = LedSheet(pair_of(cloth, 0.3), approach, device)
    ply = led.ply
    x = ply.rest_points @ np.array([[1.01, 0.2, 0.0], [0.1, 0.99, 0.3], [0.0, 0.0, 1.0]])
    for share in np.linspace(0.0, 1.0, 21)[1:]:
        f = led.to(ply.rest_points + share * (x - ply.rest_points))
    before = led.shown()
    axis = np.array([0.48, 0.6, 0.64])
    cross = np.cross(np.eye(3), -axis)
    for angle in 4.0 * math.pi * np.arange(1, steps + 1) / steps:
        turn = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
        g = led.to(x @ turn.T)
        # Rounding of the strains, 1e-16 a step, times 3e7 N/m, of tensions of 3e5 N/m.
        np.testing.assert_allclose(g @ turn, f, atol=1e-11 * np.abs(f).max())
    after = led.shown()
    np.testing.assert_allclose(after.tension, before.tension, rtol=1e-11)
    assert after.couple == pytest.approx(before.couple, rel=1e-8)
    np.testing.assert_allclose(after.frame_tension, before.frame_tension, rtol=1e-11)
    assert np.abs(before.tension).min() > 1e3 and abs(before.couple) > 1.0


def test_simple_shear_of_an_isotropic_sheet_is_dienes_(device):
    """In the plane of a sheet that turns in space besides; to 1e-6, by the square of the step."""
    modulus = SHEET.tension.stiffness / (2.0 * (1.0 + SHEET.tension.poisson))
    largest, errors = 4.0, []
    for steps in (250, 500, 4000):
        led = LedSheet(pair_of(SHEET, 0.4), "green_naghdi", device)
        gradients = np.tile(np.eye(2), (steps, 1, 1))
        gradients[:, 0, 1] = largest * np.arange(1, steps + 1) / steps
        turn = rotations(np.random.default_rng(1), 1)[0][:, :2]
        f = [led.to(led.ply.rest_points[:, :2] @ (turn @ g).T) for g in gradients][-1] @ turn
        # σ of one triangle by its virial, Σ x_a ⊗ f_a = −A σ; the area does not change.
        x = led.ply.rest_points[:, :2] @ gradients[-1].T
        area = led.membrane.inputs[0].areas.numpy().sum()
        stress = -(x.T @ f) / area
        along, across = dienes_stress(largest, modulus)
        error = np.abs(stress - [[along, across], [across, -along]]).max()
        errors.append(error / modulus)
    assert abs(along) > modulus and across > modulus
    assert errors[-1] < 1e-6
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)
    kappa = np.linspace(0.0, largest, 200_001)  # the closed form itself, by quadrature in R's frame
    b = np.arctan(0.5 * kappa)
    seen = [np.trapezoid(v, kappa) for v in (modulus * np.cos(2 * b), modulus * np.sin(2 * b))]
    c, s = np.cos(2 * b[-1]), np.sin(2 * b[-1])
    assert c * seen[0] + s * seen[1] == pytest.approx(across, rel=1e-8)


LAWS = {
    "linear": (STIFF, CELL),
    "tabulated": (crimp_table(), (SPACING, SPACING)),
    "crimp": (PLAIN, (SPACING, SPACING)),
}


@pytest.mark.parametrize("degrees", [90.0, 70.0])
@pytest.mark.parametrize("law", LAWS)
def test_the_yarns_frame_keeps_to_the_card(law, degrees, device):
    """Sheared as in a picture frame to 60°, then both yarns stretched: 0.1 % in 60 + 20 steps."""
    tension, cell = LAWS[law]
    shear = CURVE if law == "tabulated" else INTERLOCK
    cloth = fabric(tension, shear, cell, angle=math.radians(degrees))
    led = LedSheet(pair_of(cloth), "fibre_frame", device)
    for angle in np.radians(np.arange(1.0, 61.0)):
        shown = led.along(trellis(np.array([angle]), rest_angle=cloth.yarn_angle))
        couple = float(sample_couples(cloth, np.array([angle]))[0][0])
        assert shown.couple == pytest.approx(couple, rel=1e-3)
    s = np.arange(1, 21) / 20
    path = trellis(angle, 1 + 0.009 * s, 1 + 0.004 * s, rest_angle=cloth.yarn_angle)
    shown = led.along(path)
    expected = sample_tensions(cloth, np.array([[0.009, 0.004]]))[0][0]
    np.testing.assert_allclose(shown.tension, expected, rtol=1e-3)
    assert shown.couple == pytest.approx(couple, rel=1e-3)


def many_stabilisers():
    """A ply whose patches are held more and less, by their sizes; its yarns are hardly stiffer."""
    cloth = fabric(LinearTension(1.5e3, 1.6e3), INTERLOCK, angle=math.radians(80))
    assert 1e-3 * max(tension_stiffness(cloth)) > 5.0 * initial_shear_stiffness(cloth)
    return Ply.rectangle("blank", cloth, 0.04, edge=2e-3, mesh="random", warp_angle=0.35)


def test_the_yarns_frame_is_the_semi_discrete_element(device):
    """On a random mesh, from flat to a shaken surface in 40 steps; viscosity none."""
    ply = many_stabilisers()
    led = LedSheet(ply, "fibre_frame", device)
    x = shaken(ply, np.random.default_rng(4), 0.05)
    for share in np.linspace(0.0, 1.0, 41)[1:]:
        f = led.to(ply.rest_points + share * (x - ply.rest_points))
    expected = forces(membrane_of(ply, device), x, device)
    # Increments of 1e-3: the middle's shape costs a tenth of their square.
    np.testing.assert_allclose(f, expected, atol=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize("module", [fibre_frame, green_naghdi])
def test_the_stabiliser_grows_with_the_mesh_as_the_element_s_does(module, device):
    """Else approaches would differ by it, on one mesh: in forces, and in the bound on ω²."""
    ply = Ply.rectangle("ply", fabric(STIFF, INTERLOCK), 0.1, cells=20)  # 1,600 triangles
    found = [
        module.build(
            Scene(name="s", plies=[ply], duration=0.01, numerics=n), [whole(ply)], 1e-6, device
        )
        .plies[0]
        .inputs[0]
        .stabiliser.numpy()
        for n in (Numerics(), Numerics(stabiliser=5.0), Numerics(stabiliser=1.0))
    ]
    np.testing.assert_allclose(found[0], found[1], rtol=1e-12)
    assert found[1].min() > found[2].max() == found[2].min() > 0.0
    own, given, less = (
        module.sheet_stiffness(ply, Numerics(stabiliser=k))[0] for k in (None, 5.0, 1.0)
    )
    assert own == pytest.approx(given, rel=1e-12) and own > less


def test_a_trellis_in_the_frame_of_r_is_its_closed_form(device):
    """Its axes see ½ ln cos γ along and twice artanh tan γ/2 across."""
    for degrees in (10.0, 30.0, 45.0, 60.0):
        angle = math.radians(degrees)
        led = LedSheet(pair_of(BOTH_WAYS), "green_naghdi", device)
        shown = led.along(trellis(angle * np.arange(1, 2001) / 2000))
        along, across = 0.5 * math.log(math.cos(angle)), 2.0 * math.atanh(math.tan(0.5 * angle))
        np.testing.assert_allclose(shown.frame_tension, MODULI * along, rtol=1e-5)
        couple = float(sample_couples(BOTH_WAYS, np.array([across]))[0][0])
        assert shown.frame_couple == pytest.approx(couple, rel=1e-5)
        # What resists the yarns' turning is the frame's power over dγ.
        apparent = couple / math.cos(angle) - 0.5 * math.tan(angle) * (MODULI * along).sum()
        assert shown.couple == pytest.approx(apparent, rel=1e-5)


@pytest.mark.parametrize("degrees", [0.0, 30.0, 60.0])
def test_a_yarn_stretched_after_shear_in_the_frame_of_r(degrees, device):
    """R's frame sees cos² ½γ/cos γ and −sin² ½γ/cos γ of it, and is in compression already."""
    angle, strain = math.radians(degrees), 1e-6
    cloth = fabric(LinearTension(46e3, 46e3), cell=(1.35e-3, 1.35e-3), factor=1.0)
    led = LedSheet(pair_of(cloth), "green_naghdi", device)
    before = led.along(trellis(angle * np.arange(1, 2001) / 2000)).tension[0]
    after = led.along(trellis(angle, 1.0 + strain)).tension[0]
    cosine = math.cos(angle)
    spread = (1.0 - 0.5 * math.sin(angle) ** 2) / cosine**2 - 0.5 * math.log(cosine)
    # The tensions are 0.3 E at most, known to 1e-16: 3e-11 of the difference, and ε itself.
    modulus = 46e3 / 1.35e-3
    assert (after - before) / (strain * modulus) == pytest.approx(spread, rel=1e-5)


@pytest.mark.parametrize("degrees", [90.0, 65.0])
def test_any_path_in_the_frame_of_r(degrees, device):
    cloth = fabric(STIFF, INTERLOCK, factor=1.0, angle=math.radians(degrees))
    flat, space = wandering(3000, np.random.default_rng(3), 0.15)
    shown = LedSheet(pair_of(cloth), "green_naghdi", device).along(space)
    expected = seen_by_r(flat, cloth.yarn_angle)
    moduli = np.array([STIFF.warp, STIFF.weft]) / cloth.yarn_width
    np.testing.assert_allclose(shown.frame_tension, moduli * expected[:2], rtol=1e-5)
    couple = float(sample_couples(cloth, expected[2:])[0][0])
    assert shown.frame_couple == pytest.approx(couple, rel=1e-5)
    assert np.abs(expected).min() > 0.01


def test_a_closed_loop_of_strain_leaves_stress_in_the_frame_of_r_alone(device):
    residual = {}
    for approach in ROWS:
        led = LedSheet(pair_of(BOTH_WAYS), approach, device)
        largest = np.abs([led.along([g]).couple for g in loop(400, 0.1, math.radians(40.0))]).max()
        shown = led.shown()
        residual[approach] = np.abs(shown.frame_tension / MODULI).max()
        if approach == "fibre_frame":  # the steps' error alone, odd in them and so undone
            assert residual[approach] < 1e-10 and abs(shown.couple) < 1e-8 * largest
    expected = seen_by_r(loop(2000, 0.1, math.radians(40.0))[:, :2])
    assert residual["green_naghdi"] == pytest.approx(np.abs(expected[:2]).max(), rel=1e-3)
    assert residual["green_naghdi"] > 1e-3


@pytest.mark.parametrize("viscosity", [0.0, 0.067])
@pytest.mark.parametrize("approach", ROWS)
def test_work_is_that_of_the_nodal_forces(approach, viscosity, device):
    """To rounding, in steps of any size: what the balance calls stored, and lost, is exact."""
    ply = many_stabilisers()
    led = LedSheet(ply, approach, device, yarn_viscosity=viscosity)
    rng = np.random.default_rng(5)
    for size in (0.01, 0.1, 0.05):
        led.to(shaken(ply, rng, size))
    shown = led.measured()
    found = float(shown["work"].sum() + shown["lost"].sum())
    assert led.done > 1e-6
    assert found == pytest.approx(led.done, rel=1e-12)
    assert (float(shown["lost"].sum()) != 0.0) == (viscosity > 0.0)
    # Yarns, shear, stabiliser: each far above what the comparison would miss.
    assert np.abs(shown["work"].sum(axis=0)).min() > 1e-5 * led.done


@pytest.mark.parametrize("approach", ROWS)
def test_measuring_ahead_is_what_the_next_step_will_hold(approach, device):
    """Positions are a step ahead of the last forces; what is shown belongs to them."""
    ply = blank()
    led = LedSheet(ply, approach, device)
    led.to(shaken(ply, np.random.default_rng(6)))
    x = shaken(ply, np.random.default_rng(7))
    ahead = led.measured(x)
    led.to(x)
    there = led.measured()
    for name, values in ahead.items():
        np.testing.assert_allclose(
            there[name], values, rtol=1e-12, atol=1e-12 * np.abs(values).max()
        )


@pytest.mark.parametrize("approach", ROWS)
def test_net_force_and_moment_vanish(approach, device):
    ply = blank()
    led = LedSheet(ply, approach, device)
    led.to(shaken(ply, np.random.default_rng(8), 0.02))
    x = shaken(ply, np.random.default_rng(9), 0.02)
    f = led.to(x)
    scale = np.abs(f).sum()
    assert scale > 10.0
    assert np.abs(f.sum(axis=0)).max() < 1e-14 * scale
    assert np.abs(np.cross(x, f).sum(axis=0)).max() < 1e-13 * scale * np.abs(x).max()


@pytest.mark.parametrize("module", [green_naghdi, fibre_frame])
@pytest.mark.parametrize("degrees", [-60.0, 0.0, 30.0, 60.0])
@pytest.mark.parametrize("angle", [90.0, 70.0])
def test_the_bound_on_the_frequency_holds(module, degrees, angle, device):
    """No mode of a sheared pair is above it: eigenvalues of differences of the forces."""
    approach = module.__name__.rpartition(".")[2]
    cloth = fabric(STIFF, INTERLOCK, factor=1.0, angle=math.radians(angle))
    ply = pair_of(cloth)
    scene = Scene(name="pair", plies=[ply], duration=1.0, approach=approach)
    bound = module.frequencies(scene, 0).max()
    led = LedSheet(ply, approach, device)
    led.along(trellis(math.radians(degrees) * np.arange(1, 101) / 100, rest_angle=cloth.yarn_angle))
    n = led.x.size
    step, rows, here = 1e-7 * SIZE, np.zeros((n, n)), led.x
    start = [wp.clone(a) for a in (led.memory.triangles, led.memory.patches)]
    for k in range(n):
        ends = []
        for sign in (1.0, -1.0):
            for kept, now in zip(start, (led.memory.triangles, led.memory.patches), strict=True):
                wp.copy(now, kept)
            move = np.zeros(n)
            move[k] = sign * step
            ends.append(led.to(here + move.reshape(here.shape)).ravel())
        rows[:, k] = -(ends[0] - ends[1]) / (2.0 * step)
    _, areas = flat_gradients(ply)
    mass = np.bincount(ply.mesh.triangles.ravel(), np.repeat(0.6 * areas / 3.0, 3))
    highest = np.abs(np.linalg.eigvals(rows / np.repeat(mass, 3)[:, None])).max()
    assert highest < bound
    if degrees == 60.0 and angle == 90.0 and module is green_naghdi:
        gradients, _ = flat_gradients(ply)
        flat = highest_frequency_squared(gradients, 0.6, tuple(MODULI), 0.0).max()
        assert highest > 1.5 * flat  # a bound for flat yarns would not do


def test_forces_leave_other_vertices_alone(device):
    ply = blank()
    led = LedSheet(ply, "green_naghdi", device)
    x = shaken(ply, np.random.default_rng(8))
    f = wp.full(len(x), wp.vec3d(1.0, 2.0, 3.0), dtype=wp.vec3d, device=device)
    at = wp.array(x, dtype=wp.vec3d, device=device)
    led.membrane.launch(0, led.membrane.patches, at, led.memory, f)(device)
    again = LedSheet(ply, "green_naghdi", device).to(x)
    np.testing.assert_allclose(f.numpy() - (1.0, 2.0, 3.0), again, atol=1e-10)


@pytest.mark.parametrize(("rows", "owed"), [(fibre_rows, 2e-3), (polar_rows, 1e-3)])
def test_softening_is_not_blamed_for_yarns_that_are_longer_without_a_tension(rows, owed):
    """Strain that tension owes, at most; the other approach's yarns have what the card says."""
    ply = pair_of(fabric(STIFF, INTERLOCK))
    scene = Scene(name="pair", plies=[ply], duration=1.0, numerics=Numerics(yarn_softening=36.0))
    span = whole(ply)
    membrane = build_stressed(scene, (span,), "cpu", rows)
    strain = np.full((span.triangle_count, 2), 2e-3 if rows is fibre_rows else 0.14)
    carried = owed * MODULI / 36.0
    fields = {"strain": strain, "line_tension": np.broadcast_to(carried, strain.shape)}
    history = {"internal_j": np.ones(2), "yarn_j": np.zeros(2)}
    found, warnings = membrane.entries(history, [fields])
    assert found["softening_strain"] == pytest.approx(owed * (1.0 - 1.0 / 36.0))
    assert not any("softened yarns" in words for words in warnings)
    assert any("did not turn with the yarns" in words for words in warnings) == (owed < 2e-3)
