"""A prepreg's triangle over a step: forces from a potential, invariance, the bound on the step."""

import math
from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from element_checks import SHAPES, deformed, patch_ply, rotations, whole
from law_checks import fabric
from matrix_checks import LAWS, SHIFTS
from scipy.integrate import quad
from scipy.optimize import brentq

from warpdrape import Matrix, Numerics
from warpdrape.forces.matrix import (
    SERIES,
    MatrixMemory,
    frequencies,
    series_stiffness,
    shift_struct,
    viscosity_struct,
)
from warpdrape.kernels.contact.heat import approached
from warpdrape.kernels.forces.matrix import MatrixLaw, add_matrix_forces, shear_matrix
from warpdrape.laws import LinearTension, Newtonian
from warpdrape.materials.law_data import tension_stiffness


@wp.kernel(enable_backward=False)
def ask_step(
    law: MatrixLaw,
    known: MatrixMemory,
    angle: wp.float64,
    time: wp.float64,
    after: wp.array(dtype=MatrixMemory),
):
    area = wp.float64(1e-5)
    after[0] = shear_matrix(law, known, angle, law.temperature, time, area)


def advanced(law, angle, couple, now, time, device):
    """Memory of one triangle after a step."""
    known = MatrixMemory()
    known.angle, known.couple = angle, couple
    after = wp.zeros(1, dtype=MatrixMemory, device=device)
    wp.launch(ask_step, 1, inputs=[law, known, now, time], outputs=[after], device=device)
    return after.numpy()[0]


TIME = 3e-3
STIFFNESS = 4e3
RISE = (0.7, 1.3)
WARMTH = 505.0


def kernel_law(viscosity, cools=0):
    law = MatrixLaw()
    law.viscosity = viscosity_struct(viscosity)
    law.shift = shift_struct(SHIFTS["arrhenius"])
    law.thickness = 5e-4
    law.rise = wp.vec2d(*RISE)
    law.stiffness = STIFFNESS
    law.temperature = WARMTH
    law.cools = cools
    return law


def stepped(ply, law, x, known, device, warmth=None):
    """Forces [N], and memory after a step, of triangles that remember (angle, couple)."""
    from warpdrape.blanks.triangles import flat_gradients

    gradients, areas = flat_gradients(ply)
    triangles = np.asarray(ply.mesh.triangles, dtype=np.int32)
    memory = np.zeros(len(triangles), dtype=MatrixMemory.numpy_dtype())
    memory["angle"], memory["couple"] = known
    kept = wp.array(memory, dtype=MatrixMemory, device=device)
    f = wp.zeros(len(x), dtype=wp.vec3d, device=device)
    real = wp.float64
    inputs = [
        0,
        wp.array(triangles, dtype=wp.int32, device=device),
        wp.array(gradients, dtype=wp.vec4d, device=device),
        wp.array(areas, dtype=real, device=device),
        law,
        ply.fabric.yarn_angle,
        wp.array(x, dtype=wp.vec3d, device=device),
        wp.array(np.zeros(len(x)) if warmth is None else warmth, dtype=real, device=device),
        1,
        wp.array([np.nan, TIME], dtype=real, device=device),
    ]
    wp.launch(add_matrix_forces, len(triangles), inputs=inputs, outputs=[kept, f], device=device)
    return f.numpy(), kept.numpy()


def shear_angles(ply, x):
    from warpdrape.blanks.triangles import flat_gradients

    gradients, _ = flat_gradients(ply)
    a, b, c = (x[np.asarray(ply.mesh.triangles)[:, k]] for k in range(3))
    d = gradients[:, :, None]
    k1, k2 = d[:, 0] * (b - a) + d[:, 1] * (c - a), d[:, 2] * (b - a) + d[:, 3] * (c - a)
    cosine = (k1 * k2).sum(1) / np.linalg.norm(k1, axis=1) / np.linalg.norm(k2, axis=1)
    return ply.fabric.yarn_angle - np.arccos(cosine)


def potential(viscosity, angle, known, rise_at):
    """min over r of ½ (C0 + G Δγ − G r Δt)²/G + Δt D(r), D = ∫ h φ σ(a r) dr, per area [J/m²]."""
    factor = SHIFTS["arrhenius"].factor(WARMTH)
    scale = 5e-4 * (1.0 + RISE[0] * rise_at**2 + RISE[1] * rise_at**4)
    trial = known[1] + STIFFNESS * (angle - known[0])

    def couple(r):
        return scale * float(viscosity.stress(factor * r))

    def miss(r):
        return couple(r) + STIFFNESS * r * TIME - abs(trial)

    top = abs(trial) / (STIFFNESS * TIME)
    r = brentq(miss, 0.0, top, xtol=1e-14 * top, rtol=1e-14) if trial else 0.0
    flowing, _ = quad(couple, 0.0, r, epsabs=0.0, epsrel=1e-11)
    return 0.5 * couple(r) ** 2 / STIFFNESS + TIME * flowing


@pytest.mark.parametrize("name", LAWS)
def test_force_is_minus_the_gradient_of_the_potential_of_a_step(name, device):
    rng = np.random.default_rng(8)
    cloth = fabric(LinearTension(46e3, 48e3), angle=math.radians(75.0))
    ply = patch_ply(cloth, "triangle", 6, rng)
    x = deformed(ply, "triangle", rng, shear_deg=50.0)
    now, count = shear_angles(ply, x), len(ply.mesh.triangles)
    known = now - rng.uniform(-0.02, 0.02, count), rng.uniform(-40.0, 40.0, count)
    force, _ = stepped(ply, kernel_law(LAWS[name]), x, known, device)
    from warpdrape.blanks.triangles import flat_gradients

    _, areas = flat_gradients(ply)

    def energy(moved):
        angle = shear_angles(ply, moved)
        each = [
            potential(LAWS[name], angle[t], (known[0][t], known[1][t]), now[t])
            for t in range(count)
        ]
        return float(areas @ each)

    assert np.abs(force).max() > 1e-3
    step = 1e-7
    for i in np.ndindex(*x.shape):
        ends = []
        for sign in (1.0, -1.0):
            moved = x.copy()
            moved[i] += sign * step
            ends.append(energy(moved))
        slope = -(ends[0] - ends[1]) / (2.0 * step)
        assert force[i] == pytest.approx(slope, abs=1e-6 * np.abs(force).max())


@pytest.mark.parametrize("name", LAWS)
def test_couple_is_the_slope_of_the_dissipation_at_the_rate(name, device):
    """C = dD/dγ̇_v with D = ∫ h φ σ(a r) dr: by central differences of the integral."""
    law, factor = LAWS[name], SHIFTS["arrhenius"].factor(WARMTH)
    angle, scale = 0.5, 5e-4 * (1.0 + RISE[0] * 0.25 + RISE[1] * 0.0625)
    ply = patch_ply(fabric(LinearTension(46e3, 48e3)), "triangle", 1, np.random.default_rng(1))
    x = deformed(ply, "triangle", np.random.default_rng(1), (0, 0), shear_deg=0.0, noise=0.0)
    flat = np.column_stack([np.asarray(ply.mesh.vertices), np.zeros(3)])
    t1, t2 = (np.append(t, 0.0) for t in ply.yarn_directions)
    turned = np.sin(angle) * t1 + np.cos(angle) * t2
    x = np.outer(flat @ t1, t1) + np.outer(flat @ t2, turned)
    known = (np.array([angle - 0.01]), np.array([15.0]))
    _, memory = stepped(ply, kernel_law(law), x, known, device)
    rate = memory["rate"][0] / factor  # of the viscous part, in the process

    def dissipation(r):
        return quad(lambda s: scale * float(law.stress(factor * s)), 0.0, r, epsrel=1e-12)[0]

    step = 1e-4 * rate
    slope = (dissipation(rate + step) - dissipation(rate - step)) / (2.0 * step)
    assert rate > 1e-4
    assert memory["couple"][0] == pytest.approx(slope, rel=1e-6)
    flowed = rate * TIME
    assert STIFFNESS * (0.01 - flowed) == pytest.approx(memory["couple"][0] - 15.0, rel=1e-9)
    from warpdrape.blanks.triangles import flat_gradients

    mean = 0.5 * (15.0 + memory["couple"][0])
    assert memory["lost"][0] == pytest.approx(flat_gradients(ply)[1][0] * mean * flowed, rel=1e-9)


@pytest.mark.parametrize("shape", SHAPES)
def test_rigid_motion_changes_nothing_and_forces_balance(shape, device):
    rng = np.random.default_rng(5)
    ply = patch_ply(fabric(LinearTension(46e3, 48e3)), shape, 20, rng)
    x = deformed(ply, shape, rng)
    angle = shear_angles(ply, x)
    law = kernel_law(LAWS["power"])
    still, memory = stepped(ply, law, x, (angle, np.zeros(len(angle))), device)
    assert np.abs(still).max() < 1e-9 and np.abs(memory["couple"]).max() < 1e-6
    known = (angle - 0.01, np.full(len(angle), 5.0))
    force, memory = stepped(ply, law, x, known, device)
    largest = np.abs(force).max()
    assert largest > 1e-3
    n = len(SHAPES[shape][0])
    own = force.reshape(-1, n, 3)
    at = x.reshape(-1, n, 3)
    assert np.abs(own.sum(axis=1)).max() < 1e-12 * largest
    assert np.abs(np.cross(at, own).sum(axis=1)).max() < 1e-12 * largest
    turn = rotations(rng, 1)[0]
    turned, again = stepped(ply, law, x @ turn.T + [0.1, 0.2, -0.3], known, device)
    np.testing.assert_allclose(turned, force @ turn.T, atol=1e-6 * largest)
    np.testing.assert_allclose(again["couple"], memory["couple"], rtol=1e-6)


def test_a_triangle_has_the_mean_temperature_of_its_corners(device):
    rng = np.random.default_rng(6)
    ply = patch_ply(fabric(LinearTension(46e3, 48e3)), "triangle", 4, rng)
    x = deformed(ply, "triangle", rng)
    known = (shear_angles(ply, x) - 0.01, np.full(4, 5.0))
    uniform, _ = stepped(ply, kernel_law(LAWS["power"]), x, known, device)
    warmth = np.tile([WARMTH - 20.0, WARMTH + 15.0, WARMTH + 5.0], 4)
    own, _ = stepped(ply, kernel_law(LAWS["power"], cools=1), x, known, device, warmth)
    assert np.abs(uniform).max() > 1e-3
    np.testing.assert_allclose(own, uniform, rtol=1e-9, atol=1e-9)
    hotter, _ = stepped(ply, kernel_law(LAWS["power"], cools=1), x, known, device, warmth + 30.0)
    assert np.abs(hotter - uniform).max() > 0.005 * np.abs(uniform).max()


def roots(share, q):
    """Largest size of the roots of a vertex on a spring in series with a dashpot, a step each.

    C ← q (C + G Δt v), v ← v − Δt C/m: with s = Δt² G/m the matrix is [[q, q s], [−q, 1 − q s]].
    """
    return max(np.abs(np.linalg.eigvals([[q, q * share], [-q, 1.0 - q * share]])))


def test_a_step_is_as_stiff_as_the_spring_in_series_at_most():
    shares = np.linspace(0.0, 1.0, 401)
    assert max(roots(3.999, q) for q in shares[:-1]) <= 1.0 + 1e-9
    assert max(roots(4.2, q) for q in shares) > 1.1


@pytest.mark.parametrize("viscosity", [1e-3, 1e2, 1e5, 1e9])
def test_the_kernels_step_is_what_the_bound_takes_it_for(viscosity, device):
    """Its couple is q (C + G Δγ) with q = h φ a η/(h φ a η + G Δt)."""
    law = kernel_law(Newtonian(viscosity))
    after = advanced(law, 0.1, 3.0, 0.12, TIME, device)
    drag = 5e-4 * (1 + RISE[0] * 0.12**2 + RISE[1] * 0.12**4)
    drag *= SHIFTS["arrhenius"].factor(WARMTH) * viscosity
    q = drag / (drag + STIFFNESS * TIME)
    assert after["couple"] == pytest.approx(q * (3.0 + STIFFNESS * 0.02), rel=1e-9)


@pytest.mark.parametrize("name", LAWS)
def test_nothing_flows_in_no_time(name, device):
    after = advanced(kernel_law(LAWS[name]), 0.1, 3e4, 0.12, 0.0, device)
    assert after["couple"] == pytest.approx(3e4 + STIFFNESS * 0.02, rel=1e-12)
    assert after["lost"] == 0.0 and after["rate"] == 0.0


def test_the_bound_is_above_the_largest_eigenvalue_of_any_patch():
    """ω² of a triangle alone on its lumped mass, with G for its shear, at any shear."""
    rng = np.random.default_rng(2)
    cloth = replace(fabric(LinearTension(46e3, 48e3)), matrix=Matrix(viscosity=LAWS["power"]))
    ply = patch_ply(cloth, "triangle", 30, rng)
    x = deformed(ply, "triangle", rng, strains=(0.0, 0.0), noise=0.0)
    scene = type("Scene", (), {"plies": [ply], "numerics": Numerics()})()
    bound = frequencies(scene, 0)
    stiffness = series_stiffness(cloth, Numerics())
    assert stiffness == SERIES * max(tension_stiffness(cloth))
    slopes = np.zeros((30, 3, 3))
    step = 1e-6 * 5e-3
    for corner in range(3):
        for axis in range(3):
            ends = []
            for sign in (1.0, -1.0):
                moved = x.copy()
                moved[corner::3, axis] += sign * step
                ends.append(shear_angles(ply, moved))
            slopes[:, corner, axis] = (ends[0] - ends[1]) / (2.0 * step)
    exact = 3.0 / cloth.areal_density * stiffness * (slopes**2).sum(axis=(1, 2))
    assert (exact <= bound * (1.0 + 1e-6)).all()
    assert exact.max() > 0.5 * bound.max()


def test_a_card_without_a_matrix_costs_no_step():
    cloth = fabric(LinearTension(46e3, 48e3))
    ply = patch_ply(cloth, "triangle", 3, np.random.default_rng(2))
    scene = type("Scene", (), {"plies": [ply], "numerics": Numerics()})()
    np.testing.assert_array_equal(frequencies(scene, 0), 0.0)
    assert whole(ply).triangle_count == 3
    own = replace(cloth, matrix=Matrix(viscosity=LAWS["cross"], modulus=2e6))
    assert series_stiffness(own, Numerics()) == 2e6 * cloth.thickness


def test_heat_goes_the_way_of_its_closed_form():
    now, goal, rate = 520.0, 400.0, 0.8
    one = float(approached(*(wp.float64(v) for v in (now, goal, rate, 2.5))))
    assert one == pytest.approx(goal + (now - goal) * math.exp(-2.0))
    assert float(approached(*(wp.float64(v) for v in (now, goal, rate, 1e9)))) == goal
