"""The pair element: forces are the exact gradient of its energy, and those of the paper."""

import math

import numpy as np
import pytest
import warp as wp
from element_checks import (
    SHAPES,
    SIZE,
    deformed,
    energy_gradient,
    forces,
    measured,
    membrane_of,
    patch_ply,
    rotations,
)
from law_checks import PLAIN, SPACING, crimp_table, fabric

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.pairing import pair_triangles
from warpdrape.blanks.ply import Ply
from warpdrape.forces.membrane_stiffness import stabiliser_stiffness
from warpdrape.kernels.forces.membrane import PatchMemory, make_yarn_membrane
from warpdrape.kernels.forces.recovery import Recovery, RecoveryRates
from warpdrape.materials.law_curves import sample_tensions
from warpdrape.materials.law_data import membrane_functions
from warpdrape.materials.laws import LinearTension, NoShear, ShearPolynomial, ShearTable
from warpdrape.numerics import Numerics
from warpdrape.results.snapshot import yarn_state

STIFF = LinearTension(46e3, 48e3)
SOFT = LinearTension(1.0, 1.2)  # so that shear is not lost beside the yarns
INTERLOCK = ShearPolynomial((0.37044e-3, -0.84105e-3, 1.03113e-3))
CURVE = ShearTable(np.radians([0, 5, 20, 35, 50, 60]), [0, 0.3e-4, 1e-4, 1.2e-4, 2.9e-4, 7.2e-4])
ANGLES = [math.pi / 2, math.radians(62), math.radians(115)]
SQUARE_CELL = (SPACING, SPACING)
GAP = 3e-5
"""Distance from a kink [- or rad] that a central difference needs: its reach is 1e-5."""
TABLE_KNOTS = np.concatenate([np.linspace(0, 0.01, 11), np.linspace(0, 0.01, 9)])
CASES = {
    # name: tension law, shear law, cell, strains, kinks of the strain, kinks of the shear angle
    "linear": (STIFF, INTERLOCK, (1.35e-3, 1.33e-3), (-0.01, 0.02), [0.0], []),
    "tabulated": (crimp_table(), INTERLOCK, SQUARE_CELL, (-0.005, 0.013), TABLE_KNOTS, []),
    "crimp": (PLAIN, INTERLOCK, SQUARE_CELL, (0.002, 0.02), [0.0], []),
    "polynomial": (SOFT, INTERLOCK, (1.35e-3, 1.33e-3), (-0.01, 0.02), [0.0], []),
    "curve": (SOFT, CURVE, (1.35e-3, 1.33e-3), (-0.01, 0.02), [0.0], CURVE.angles),
    "no shear": (STIFF, NoShear(), (1.35e-3, 1.33e-3), (-0.01, 0.02), [0.0], []),
}


def cloth_of(case, angle=math.pi / 2):
    tension, shear, cell, *_ = CASES[case]
    if case == "crimp":
        cell = None
    return fabric(tension, shear, **({"cell": cell} if cell else {}), angle=angle)


def off_kinks(case, ply, x, membrane, shape, device):
    """Patches whose differences straddle no kink, as a mask."""
    *_, strain_kinks, shear_kinks = CASES[case]
    strain = measured(membrane, x, device)[0]
    near = np.abs(strain[:, :, None] - np.array(strain_kinks)).min(axis=(1, 2)) < GAP
    if len(shear_kinks):
        gradients = membrane.gradients.numpy()
        state = yarn_state(x, ply.mesh.triangles, gradients, ply.fabric.yarn_angle)
        angle = np.abs(state[2])
        near |= np.abs(angle[:, None] - shear_kinks).min(axis=1) < GAP
    return ~near.reshape(-1, len(SHAPES[shape][1])).any(axis=1)


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("case", CASES)
def test_force_is_minus_the_gradient_of_the_energy(case, shape, angle, device):
    rng = np.random.default_rng(1)
    cloth = cloth_of(case, angle)
    ply = patch_ply(cloth, shape, 250, rng)
    membrane = membrane_of(ply, device, stabiliser=20.0)
    x = deformed(ply, shape, rng, CASES[case][3])
    assert not np.isnan(np.concatenate([m.ravel() for m in measured(membrane, x, device)])).any()
    fine = off_kinks(case, ply, x, membrane, shape, device)
    assert fine.sum() >= 200
    n = len(SHAPES[shape][0])
    force = forces(membrane, x, device).reshape(-1, 3 * n)[fine]
    slope = energy_gradient(membrane, x, shape, device).reshape(-1, 3 * n)[fine]
    scale = np.abs(force).max(axis=1)
    softest = 0.1 if CASES[case][0] is SOFT else 10.0  # N/m
    assert np.median(scale) > softest * SIZE
    assert scale.min() > 1e-2 * softest * SIZE
    # Rounding alone makes 1e-9 at this step.
    assert (np.abs(force + slope).max(axis=1) / scale).max() < 3e-9


def paper_loads(ply, x):
    """Internal loads [N] as Hamila and Boisse 2008 print them, [12]–[28], triangle by triangle.

    Linear yarns, polynomial shear; L1 and L2 in [22] are the current yarn lengths.
    """
    cloth, flat = ply.fabric, np.asarray(ply.mesh.vertices)
    t1, t2 = ply.yarn_directions
    stiffness = cloth.tension.warp, cloth.tension.weft
    load = np.zeros_like(x)
    largest = 0.0
    for m1, m2, m3 in np.asarray(ply.mesh.triangles):
        e2, e3 = flat[m2] - flat[m1], flat[m3] - flat[m1]
        # A = M1 + a1 (M3 − M1), A M2 along the warp; B = M1 + a2 (M2 − M1), B M3 along the weft.
        a1 = np.linalg.det([e2, t1]) / np.linalg.det([e3, t1])
        a2 = np.linalg.det([e3, t2]) / np.linalg.det([e2, t2])
        largest = max(largest, abs(a1), abs(a2))
        flat1, flat2 = e2 - a1 * e3, e3 - a2 * e2  # along or against t1, t2
        rest = np.linalg.norm(flat1), np.linalg.norm(flat2)
        k1 = x[m2] - x[m1] - a1 * (x[m3] - x[m1])
        k2 = x[m3] - x[m1] - a2 * (x[m2] - x[m1])
        g = np.array([[k1 @ k1, k1 @ k2], [k1 @ k2, k2 @ k2]])
        inverse = np.linalg.inv(g)
        up1 = inverse[0, 0] * k1 + inverse[0, 1] * k2  # k^1, [14]
        up2 = inverse[1, 0] * k1 + inverse[1, 1] * k2
        n1, n2, u1, u2 = (np.linalg.norm(k) for k in (k1, k2, up1, up2))
        b1 = np.outer([a1 - 1, 1, -a1], k1)  # [20]
        b2 = np.outer([a2 - 1, -a2, 1], k2)  # [21]
        b3 = np.outer([a2 - 1, -a2, 1], k1)  # [26]
        b4 = np.outer([a1 - 1, 1, -a1], k2)  # [27]
        cells = 0.5 * abs(np.linalg.det([e2, e3])) / cloth.cell_area
        stretch = n1 / rest[0], n2 / rest[1]
        pulls = []
        for family, cell in enumerate((cloth.cell_warp, cloth.cell_weft)):
            strain = stretch[family] - 1
            factor = 1.0 if strain > 0 else cloth.compressive_factor
            pulls.append(factor * stiffness[family] * strain * cell * stretch[family])
        tensile = b1 * pulls[0] / n1**2 + b2 * pulls[1] / n2**2  # [22]
        mixed = up1 @ up2
        # [25] and [28]
        rotation = b1 * mixed / (n1 * u2) + b3 * u2 / n1 + b4 * u1 / n2 + b2 * mixed / (n2 * u1)
        angle = math.acos(flat1 @ flat2 / (rest[0] * rest[1])) - math.acos(k1 @ k2 / (n1 * n2))
        load[[m1, m2, m3]] += cells * (tensile + rotation * float(cloth.shear.couple(angle)))
    return load, largest


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("yarns", [STIFF, SOFT])
def test_loads_are_those_of_the_paper(yarns, angle, device):
    rng = np.random.default_rng(2)
    cloth = fabric(yarns, INTERLOCK, angle=angle)
    ply = patch_ply(cloth, "triangle", 200, rng)
    # Turned off the yarns: the paper's a1, a2 are infinite along an edge.
    points = np.asarray(ply.mesh.vertices).reshape(-1, 3, 2)
    points = np.einsum("pij,pnj->pni", rotations(rng, 200, plane=True), points).reshape(-1, 2)
    ply = Ply(
        name="turned", fabric=cloth, mesh=FlatMesh(points, ply.mesh.triangles), warp_angle=0.3
    )
    x = deformed(ply, "triangle", rng)
    expected, largest = paper_loads(ply, x)
    assert 10 < largest < 1e4  # some nearly along an edge
    found = forces(membrane_of(ply, device), x, device)
    scale = np.abs(expected).reshape(-1, 9).max(axis=1)
    assert np.median(scale) > 1e-3
    error = np.abs(found + expected).reshape(-1, 9).max(axis=1) / scale
    assert error.max() < 1e-14 * largest**2 + 1e-11  # its 1 + a1² terms cancel


def blank(pattern="random", cloth=None, warp_angle=0.35):
    cloth = cloth or fabric(STIFF, INTERLOCK)
    return Ply.rectangle("blank", cloth, 0.04, edge=SIZE, mesh=pattern, warp_angle=warp_angle)


def shaken(ply, rng, size=0.01):
    x = ply.rest_points + 0.1
    x[:, 2] += 2.0 * x[:, 0] ** 2 + x[:, 0] * x[:, 1]
    return x + size * SIZE * rng.uniform(-1, 1, x.shape)


@pytest.mark.parametrize("averaging", ["pairs", "plain"])
@pytest.mark.parametrize("angle", ANGLES)
def test_rigid_motion_gives_no_force(averaging, angle, device):
    ply = blank(cloth=fabric(STIFF, INTERLOCK, angle=angle))
    membrane = membrane_of(ply, device, averaging=averaging)
    for turn in rotations(np.random.default_rng(3), 5):
        x = ply.rest_points @ turn.T + (0.1, -0.2, 0.05)
        # Rounding of the positions is 3e-17 m, of a strain 3e-17/SIZE, times E h of a yarn family.
        rounding = 20 * 3e-17 * 48e3 / 1.33e-3 / math.sin(angle)
        assert np.abs(forces(membrane, x, device)).max() < rounding
        stretched = forces(membrane, x * (1 + 1e-9), device)
        assert np.abs(stretched).max() > rounding


@pytest.mark.parametrize("averaging", ["pairs", "plain"])
def test_net_force_and_moment_vanish(averaging, device):
    ply = blank()
    x = shaken(ply, np.random.default_rng(4))
    f = forces(membrane_of(ply, device, averaging=averaging), x, device)
    scale = np.abs(f).sum()
    assert scale > 100.0
    assert np.abs(f.sum(axis=0)).max() < 1e-14 * scale
    assert np.abs(np.cross(x, f).sum(axis=0)).max() < 1e-14 * scale * np.abs(x).max()


@pytest.mark.parametrize("averaging", ["pairs", "plain"])
def test_numbering_changes_nothing(averaging, device):
    rng = np.random.default_rng(5)
    ply = blank()
    x = shaken(ply, rng)
    flat, rows = np.asarray(ply.mesh.vertices), np.asarray(ply.mesh.triangles)
    order = rng.permutation(len(flat))  # new vertex k is the old order[k]
    new = np.argsort(order)
    turned = np.stack([np.roll(row, rng.integers(3)) for row in new[rows]])
    shuffle = rng.permutation(len(rows))
    other = Ply(
        name="other",
        fabric=ply.fabric,
        mesh=FlatMesh(flat[order], turned[shuffle]),
        warp_angle=0.35,
    )
    first, second = (membrane_of(p, device, averaging=averaging) for p in (ply, other))
    f, g = forces(first, x, device), forces(second, x[order], device)
    assert np.abs(f).max() > 1.0
    np.testing.assert_allclose(g, f[order], atol=1e-11 * np.abs(f).max())
    for before, after in zip(
        measured(first, x, device), measured(second, x[order], device), strict=True
    ):
        np.testing.assert_allclose(after, before[shuffle], atol=1e-11 * np.abs(before).max())


@pytest.mark.parametrize("pairs", [50, 51])
def test_pair_kernel_is_the_patch_kernel_for_two(pairs, device):
    rng = np.random.default_rng(6)
    cloth = fabric(STIFF, INTERLOCK, angle=ANGLES[1])
    ply = patch_ply(cloth, "pair", pairs, rng)
    x = deformed(ply, "pair", rng)
    membrane = membrane_of(ply, device, stabiliser=50.0)
    assert [load.count for load in membrane.loads] == [25] + [1] * (pairs % 2)
    add_patch_forces, _ = make_yarn_membrane(*membrane_functions(cloth))
    at = wp.array(x, dtype=wp.vec3d, device=device)
    f = wp.zeros(len(x), dtype=wp.vec3d, device=device)
    _, count, inputs = membrane.measurement
    memory = wp.empty(0, PatchMemory, device=device)
    inputs = [0, *inputs, wp.vec2d(), RecoveryRates(), at]
    recovered = wp.empty(0, Recovery, device=device)
    wp.launch(add_patch_forces, count, inputs=inputs, outputs=[memory, recovered, f], device=device)
    expected = f.numpy()
    assert np.abs(expected).max() > 1.0
    found = forces(membrane, x, device)
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())


def test_a_vertex_that_is_not_a_number_spoils_its_pair_alone(device):
    rng = np.random.default_rng(6)
    ply = patch_ply(fabric(STIFF, INTERLOCK), "pair", 4, rng)
    x = deformed(ply, "pair", rng)
    x[5, 1] = math.nan
    f = forces(membrane_of(ply, device), x, device).reshape(4, 4, 3)
    assert np.isnan(f[1]).any(axis=1).all() and np.isfinite(f[[0, 2, 3]]).all()


def test_plain_is_the_sum_of_single_triangles(device):
    ply = blank()
    x = shaken(ply, np.random.default_rng(7))
    rows = np.asarray(ply.mesh.triangles)
    apart = FlatMesh(
        np.asarray(ply.mesh.vertices)[rows.ravel()], np.arange(rows.size).reshape(-1, 3)
    )
    single = Ply(name="apart", fabric=ply.fabric, mesh=apart, warp_angle=0.35)
    expected = np.zeros_like(x)
    np.add.at(expected, rows.ravel(), forces(membrane_of(single, device), x[rows.ravel()], device))
    found = forces(membrane_of(ply, device, averaging="plain"), x, device)
    scale = np.abs(expected).max()
    assert scale > 1.0
    np.testing.assert_allclose(found, expected, atol=1e-12 * scale)
    assert np.abs(forces(membrane_of(ply, device), x, device) - found).max() > 1e-2 * scale


def test_forces_are_added_and_leave_other_vertices_alone(device):
    ply = blank()
    x = shaken(ply, np.random.default_rng(8))
    membrane = membrane_of(ply, device)
    f = wp.full(len(x), wp.vec3d(1.0, 2.0, 3.0), dtype=wp.vec3d, device=device)
    membrane.add_forces(wp.array(x, dtype=wp.vec3d, device=device), f)
    added = f.numpy() - (1.0, 2.0, 3.0)
    np.testing.assert_allclose(added, forces(membrane, x, device), atol=1e-10)


def yarn_strains(ply, x):
    """Of each triangle by itself, shape [triangle, 2]."""
    rows, flat = np.asarray(ply.mesh.triangles), np.asarray(ply.mesh.vertices)
    jacobian = np.stack([flat[rows[:, k]] - flat[rows[:, 0]] for k in (1, 2)], axis=-1)
    now = np.stack([x[rows[:, k]] - x[rows[:, 0]] for k in (1, 2)], axis=-1)
    yarns = now @ np.linalg.inv(jacobian) @ np.stack(ply.yarn_directions, axis=-1)
    return np.linalg.norm(yarns, axis=1) - 1


def test_measurement_shows_the_patch_mean_and_its_energy(device):
    ply = blank(cloth=fabric(STIFF, INTERLOCK, angle=ANGLES[2]))
    x = shaken(ply, np.random.default_rng(9))
    strain, tension, energy = measured(membrane_of(ply, device, stabiliser=7.0), x, device)
    own, area = yarn_strains(ply, x), ply.mesh.areas
    patch = pair_triangles(ply.mesh).patch_of()
    total = np.bincount(patch, area)
    mean = np.stack([np.bincount(patch, area * own[:, k]) / total for k in (0, 1)], 1)[patch]
    np.testing.assert_allclose(strain, mean, atol=1e-13)
    assert np.abs(own - mean).max() > 1e-3
    expected, density = sample_tensions(ply.fabric, mean)
    np.testing.assert_allclose(tension, expected, rtol=1e-9)
    np.testing.assert_allclose(energy[:, 0], area * density, rtol=1e-9)
    couple = stabiliser_stiffness(ply.fabric, Numerics(stabiliser=7.0))
    apart = 0.5 * couple * area * ((own - mean) ** 2).sum(axis=1)
    np.testing.assert_allclose(energy[:, 2], apart, rtol=1e-9)
