"""What holds the mode that a pair's mean strain does not feel: how stiff, where, in what."""

import numpy as np
import pytest
from element_checks import forces, measured, membrane_of
from law_checks import fabric
from test_membrane import INTERLOCK, STIFF, blank, shaken, yarn_strains

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.pairing import pair_triangles
from warpdrape.blanks.ply import Ply
from warpdrape.errors import InputError
from warpdrape.forces.membrane_stiffness import (
    patch_stabilisers,
    sheet_stiffness,
    stabiliser_stiffness,
)
from warpdrape.materials.law_data import initial_shear_stiffness, tension_stiffness
from warpdrape.materials.laws import LinearTension, NoShear, ShearPolynomial
from warpdrape.numerics import Numerics
from warpdrape.results.run_record import run_record
from warpdrape.scene import Scene


def test_homogeneous_strain_leaves_the_stabiliser_at_rest(device):
    ply = blank()
    flat = ply.rest_points
    x = flat @ np.array([[1.01, 0.2, 0.0], [0.1, 0.99, 0.3], [0.0, 0.0, 1.0]])
    stiff, loose = (membrane_of(ply, device, stabiliser=k) for k in (1000.0, 0.0))
    np.testing.assert_allclose(measured(stiff, x, device)[2][:, 2], 0.0, atol=1e-24)
    f = forces(stiff, x, device)
    plain = forces(membrane_of(ply, device, averaging="plain"), x, device)
    assert np.abs(f).max() > 1.0
    np.testing.assert_allclose(f, forces(loose, x, device), atol=1e-10 * np.abs(f).max())
    np.testing.assert_allclose(f, plain, atol=1e-10 * np.abs(f).max())


def test_the_stabiliser_has_a_floor_where_shear_resists_nothing():
    tension = LinearTension(1e3, 3e3)  # N per yarn; at 1 mm spacing a thousand times as much per m
    free, stiff = (
        fabric(tension, law, cell=(1e-3, 1e-3)) for law in (NoShear(), ShearPolynomial((1e-4,)))
    )
    floor = Numerics().stabiliser_floor * 3e6
    assert floor > 0.0
    assert stabiliser_stiffness(free, Numerics()) == pytest.approx(floor)
    assert stabiliser_stiffness(stiff, Numerics()) == pytest.approx(1e-4 / 1e-6)
    assert stabiliser_stiffness(stiff, Numerics(stabiliser=0.0)) == pytest.approx(floor)


def test_a_stabiliser_that_is_not_given_grows_with_the_mesh():
    cloth = fabric(STIFF, INTERLOCK)
    shear, yarns = initial_shear_stiffness(cloth), max(tension_stiffness(cloth))
    assert 20.0 * shear < 1e-3 * yarns  # what follows is of the mesh, not of the cap
    patches = np.array([0, 160, 800, 3200, 10**7])
    grown = np.array([1.0, 1.0, 5.0, 20.0]) * shear
    found = stabiliser_stiffness(cloth, Numerics(), patches)
    np.testing.assert_allclose(found, [*grown, 1e-3 * yarns], rtol=1e-12)
    given = stabiliser_stiffness(cloth, Numerics(stabiliser=2.0), patches)
    np.testing.assert_allclose(given, 2.0 * shear, rtol=1e-12)
    with pytest.raises(InputError, match="stabiliser = -1"):
        Numerics(stabiliser=-1.0)


def test_the_mesh_s_stabiliser_is_in_the_forces_and_in_the_step(device):
    """As if it had been given: the energy of strains that differ in a pair, and the bound on ω²."""
    plies = [Ply.rectangle("ply", fabric(STIFF, INTERLOCK), 0.1, cells=20) for _ in "ab"]
    own = [Numerics(), Numerics(stabiliser=5.0)]  # 1,600 triangles
    x = plies[0].rest_points + 1e-4 * np.random.default_rng(1).standard_normal((841, 3))
    stored = [
        measured(membrane_of(ply, device, stabiliser=n.stabiliser), x, device)[2].sum(axis=0)
        for ply, n in zip(plies, own, strict=True)
    ]
    assert stored[0][2] == pytest.approx(stored[1][2], rel=1e-12) and stored[0][2] > 0.0
    first, second = (sheet_stiffness(p, n) for p, n in zip(plies, own, strict=True))
    np.testing.assert_allclose(first[0], second[0], rtol=1e-12)
    assert first[0][0] > sheet_stiffness(plies[0], Numerics(stabiliser=1.0))[0][0]


def of_squares(x, y):
    """A ply of squares or rectangles of two triangles, whose lines stand at x and at y [m]."""
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    at = np.arange(len(points)).reshape(len(y), len(x))
    corners = [c.ravel() for c in (at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1])]
    rows = np.concatenate([np.stack([corners[k] for k in t], 1) for t in ((0, 1, 2), (0, 2, 3))])
    return Ply(name="ply", fabric=fabric(STIFF, INTERLOCK), mesh=FlatMesh(points, rows))


def acting(ply):
    """By default of a ply's patches: κ C'(0) [N/m], and their centres [m]."""
    pairing = pair_triangles(ply.mesh)
    found = patch_stabilisers(ply, Numerics(), pairing.offsets, pairing.triangles)
    centres = ply.mesh.vertices[ply.mesh.triangles].mean(axis=1)[pairing.triangles]
    return found, np.add.reduceat(centres, pairing.offsets[:-1]) / pairing.sizes[:, None]


def test_where_a_mesh_is_finer_the_stabiliser_is_stiffer_and_nowhere_else():
    line, finer = np.linspace(0.0, 0.4, 41), np.linspace(0.2, 0.4, 41)[1:]
    ply = of_squares(np.concatenate([line[:21], finer]), line)
    found, centres = acting(ply)
    even, _ = acting(of_squares(line, line))
    shear = initial_shear_stiffness(ply.fabric)
    np.testing.assert_allclose(even, 10.0 * shear, rtol=1e-9)  # 1,600 squares
    there = np.where(centres[:, 0] < 0.2, 10.0, 20.0) * shear
    np.testing.assert_allclose(found, there, rtol=1e-9)
    (warp, _), _ = sheet_stiffness(ply, Numerics())
    (given, _), _ = sheet_stiffness(ply, Numerics(stabiliser=20.0))
    assert warp == pytest.approx(given, rel=1e-12)


def test_the_stabiliser_goes_by_a_ply_s_width_not_by_its_length():
    """Of one mesh: a square; a strip as wide, ten times as long; a square ten times as large."""
    line = np.linspace(0.0, 0.2, 21)
    square, _ = acting(of_squares(line, line))
    strip, _ = acting(of_squares(line, np.linspace(0.0, 2.0, 201)))
    larger, _ = acting(of_squares(10.0 * line, 10.0 * line))
    assert strip.max() / square.max() == pytest.approx((20.0 / 11.0) ** 2)  # (2 · length/half)²
    np.testing.assert_allclose(larger, square, rtol=1e-9)


def test_each_patch_s_stabiliser_is_in_its_forces(device):
    """By what forces and energies of a random mesh, with patches of three, have above κ = 1."""
    ply = Ply.rectangle("ply", fabric(STIFF, INTERLOCK), 0.1, cells=16, mesh="random")
    found, _ = acting(ply)
    pairing = pair_triangles(ply.mesh)
    assert np.ptp(found) > 0.5 * found.mean() and (pairing.sizes == 3).any()
    pair = 2.0 * np.bincount(pairing.patch_of(), ply.mesh.areas) / pairing.sizes
    shear = initial_shear_stiffness(ply.fabric)
    np.testing.assert_allclose(found, shear * np.maximum(0.1**2 / pair / 160.0, 1.0), rtol=1e-9)
    by_default, loose = (membrane_of(ply, device, stabiliser=k) for k in (None, 1.0))
    rng = np.random.default_rng(3)
    x = shaken(ply, rng)
    more = forces(by_default, x, device) - forces(loose, x, device)

    def energy(at):
        return sum(
            sign * measured(of, at, device)[2][:, 2] for of, sign in ((by_default, 1), (loose, -1))
        )

    own = yarn_strains(ply, x) - measured(loose, x, device)[0]
    excess = found[pairing.patch_of()] - shear
    expected = 0.5 * excess * ply.mesh.areas * (own**2).sum(axis=1)
    np.testing.assert_allclose(energy(x), expected, rtol=1e-8, atol=1e-10 * expected.max())
    for _ in range(3):
        way = rng.standard_normal(x.shape)
        slope = (energy(x + 1e-8 * way) - energy(x - 1e-8 * way)).sum() / 2e-8
        assert -(more * way).sum() == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize(
    "approach, numerics, least, most",
    [
        ("semi_discrete", {}, 10.0, 20.0),
        ("fibre_frame", {}, 10.0, 20.0),
        ("semi_discrete", {"stabiliser": 3.0}, 3.0, 3.0),
        ("semi_discrete", {"averaging": "plain"}, None, None),
        ("yarns", {}, None, None),
    ],
)
def test_the_record_has_the_stabiliser_that_acts(approach, numerics, least, most):
    line, finer = np.linspace(0.0, 0.4, 41), np.linspace(0.2, 0.4, 41)[1:]
    ply = of_squares(np.concatenate([line[:21], finer]), line)
    scene = Scene(
        name="s", plies=[ply], duration=1.0, numerics=Numerics(**numerics), approach=approach
    )
    found = run_record(scene, None, 1, 1)["plies"][0]["stabiliser_n_m"]
    if least is None:
        assert found is None
    else:
        shear = initial_shear_stiffness(ply.fabric)
        assert found == pytest.approx([least * shear, most * shear])
