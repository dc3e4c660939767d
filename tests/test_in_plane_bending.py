"""Yarns bent in the plane of a strip whose yarns slide: why some meshes are too stiff there.

A linear triangle sees a parabola along the warp as weft strain of κ h/4. Where a patch's triangles
see it with opposite signs its mean is none; a patch that sees any forces a zigzag on the strip, and
along the weft it forces it on the whole row, as weft yarns do not stretch. With what triangles see
of their curvature taken off their strains, every mesh is exact.
"""

import math

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import spsolve

from warpdrape import Bending
from warpdrape.blanks.pairing import pair_triangles
from warpdrape.blanks.triangles import yarn_gradients
from warpdrape.forces.curvature import curvature_operator
from warpdrape.verification.plates import LENGTH, STIFFNESS, mesh_of

YARNS = 2e4
"""Line stiffness [N/m]."""
HOLD = 0.04
"""Stabiliser [N/m]: what it is in a run of such a strip, far too little to matter."""
DIRECTIONS = np.array([1.0, 0.0]), np.array([0.0, 1.0])


def strip(kind, cells, width=0.125):
    return mesh_of(kind, LENGTH, width * LENGTH, LENGTH / cells)


def strain_rows(mesh):
    """Warp and weft strain of each triangle from (u_x, u_y), each shape [triangle, 2 · vertex]."""
    points, triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    gradients, areas = yarn_gradients(points, triangles, *DIRECTIONS)
    rows = np.repeat(np.arange(len(triangles)), 3)
    found = []
    for family in (0, 1):
        b, c = gradients[:, 2 * family], gradients[:, 2 * family + 1]
        values = np.column_stack([-b - c, b, c]).ravel()
        columns = triangles.ravel() + family * len(points)
        shape = (len(triangles), 2 * len(points))
        found.append(sparse.csr_matrix((values, (rows, columns)), shape=shape))
    return found, areas


def operator_of(mesh):
    """Curvatures of a strip that is clamped at its left end."""
    points = np.asarray(mesh.vertices)
    root = points[:, 0] < -0.5 * LENGTH + 1e-9
    return curvature_operator(points, mesh.triangles, DIRECTIONS, np.where(root, 0, -1)), root


def freed_rows(mesh):
    """Strains at the triangles' centres: without what linear triangles see of a curvature there."""
    points, triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    families, areas = strain_rows(mesh)
    gradients, _ = yarn_gradients(points, triangles, *DIRECTIONS)
    x, y = np.moveaxis(points[triangles] - points[triangles].mean(axis=1)[:, None], 2, 0)
    rows, _ = operator_of(mesh)
    none = sparse.csr_matrix((len(triangles), len(points)))
    found = []
    for family in (0, 1):
        b, c = gradients[:, 2 * family], gradients[:, 2 * family + 1]
        slope = np.column_stack([-b - c, b, c])
        seen = sum(
            sparse.diags((slope * parabola).sum(axis=1)) @ rows.rows[k::3]
            for k, parabola in enumerate((0.5 * x**2, 0.5 * y**2, x * y))
        )
        columns = [seen, none] if family == 0 else [none, seen]
        found.append(sparse.csr_matrix(families[family] - sparse.hstack(columns)))
    return found, areas


def membrane(mesh, patch, counted, strains):
    """Stiffness of yarns whose strain is the mean of a patch's triangles, as far as counted."""
    families, areas = strains(mesh)
    members = np.arange(len(areas))
    whole = np.bincount(patch, areas)
    total = sparse.csr_matrix((2 * len(mesh.vertices),) * 2)
    for rows, weight in zip(families, counted, strict=True):
        share = areas * weight
        size = np.bincount(patch, share)
        mean = sparse.csr_matrix((share / np.where(size > 0.0, size, 1.0)[patch], (patch, members)))
        own = mean @ rows
        apart = rows - own[patch]
        total += YARNS * own.T @ sparse.diags(whole * (size > 0.0)) @ own
        total += HOLD * apart.T @ sparse.diags(areas) @ apart
    return total


def tip(mesh, patch, counted=None, strains=strain_rows):
    """Drop of a cantilever under a small even load in its plane, over w L⁴/8B."""
    points = np.asarray(mesh.vertices)
    counted = np.ones((2, len(mesh.triangles))) if counted is None else counted
    operator, root = operator_of(mesh)
    bending = operator.stiffness(Bending(warp=STIFFNESS, weft=STIFFNESS).moduli)[0]
    matrix = sparse.block_diag([bending, bending]) + membrane(mesh, patch, counted, strains)
    free = np.flatnonzero(~np.r_[root, root])
    load = np.r_[np.zeros(len(points)), np.asarray(mesh.vertex_areas)]
    moved = np.zeros(2 * len(points))
    moved[free] = spsolve(matrix.tocsr()[free][:, free].tocsc(), load[free])
    end = points[:, 0] > 0.5 * LENGTH - 1e-9
    return moved[len(points) :][end].mean() * 8.0 * STIFFNESS / LENGTH**4


def across_sides(mesh):
    """Patches over the sides of a crossed mesh's squares, and what counts of a border triangle.

    Of a family that ends at the border the triangle there says nothing: the tension of a yarn is
    none at its free end. The clamped side keeps its own.
    """
    ends, links, _ = mesh.edges
    at = np.asarray(mesh.vertices)[ends]
    upright, level = (np.isclose(at[:, 0, k], at[:, 1, k]) for k in (0, 1))
    patch = np.arange(len(mesh.triangles))
    inner = links[:, 1] >= 0
    a, b = links[inner & (upright | level)].T
    patch[b] = a
    counted = np.ones((2, len(patch)))
    counted[1, links[level & ~inner, 0]] = 0.0
    tip_side = upright & ~inner & (at[:, 0, 0] > 0.0)
    counted[0, links[tip_side, 0]] = 0.0
    return np.unique(patch, return_inverse=True)[1], counted


def test_edges_along_both_yarns_bend_in_the_plane_as_a_beam():
    errors = [
        tip(m, pair_triangles(m).patch_of()) - 1.0 for m in (strip("diagonal", c) for c in (16, 32))
    ]
    assert 0.0 < errors[1] < 0.002
    assert math.log2(errors[0] / errors[1]) > 1.8


def test_a_parabola_is_weft_strain_to_a_linear_triangle():
    mesh = strip("crossed", 16)
    points, triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    (_, weft), areas = strain_rows(mesh)
    curvature, edge = 3.0, LENGTH / 16
    seen = weft @ np.r_[np.zeros(len(points)), 0.5 * curvature * points[:, 0] ** 2]
    expected = 0.25 * curvature * edge
    assert np.abs(seen).max() == pytest.approx(expected)
    # of a square's four, two see it, one each way
    np.testing.assert_allclose(np.sort(np.abs(seen))[: len(triangles) // 2], 0.0, atol=1e-12)
    patch, counted = across_sides(mesh)
    mean = np.bincount(patch, areas * seen * counted[1])
    np.testing.assert_allclose(mean, 0.0, atol=1e-12 * expected)


def test_the_border_is_what_makes_crossed_squares_too_stiff():
    """Pairs that see no parabola, and yarns that end at the border without tension: exact."""
    errors, held = [], []
    for cells in (16, 32):
        mesh = strip("crossed", cells)
        patch, counted = across_sides(mesh)
        errors.append(tip(mesh, patch, counted) - 1.0)
        held.append(tip(mesh, patch) - 1.0)  # the border triangles' strains counted: all rows lock
    assert 0.0 < errors[1] < 0.001
    assert math.log2(errors[0] / errors[1]) > 1.8
    assert held[1] < -0.3


def test_too_stiff_strips_get_better_with_the_cells():
    """Yarns stretch a little: against EA κ² h²/16 the zigzag's bending falls behind."""
    wide = [strip("crossed", c, width=0.5) for c in (16, 32, 64)]
    errors = [1.0 - tip(m, pair_triangles(m).patch_of()) for m in wide]
    assert 0.0 < errors[2] < 0.5 * errors[1] < 0.5 * 0.5 * errors[0]


def test_freed_strains_are_those_of_a_bent_strip_at_its_centres():
    mesh = strip("random", 16)
    x, y = np.asarray(mesh.vertices).T
    along, across = x + 0.5 * LENGTH, y
    at = np.asarray(mesh.vertices)[mesh.triangles].mean(axis=1)
    bent = np.r_[-along * across, 0.5 * along**2]
    (linear, _), (freed, _) = strain_rows(mesh), freed_rows(mesh)
    assert np.abs(linear[1] @ bent).max() > 0.1 * LENGTH / 16
    np.testing.assert_allclose(freed[1] @ bent, 0.0, atol=1e-14)
    clear = at[:, 0] > -0.5 * LENGTH + 2 * LENGTH / 16  # a clamp holds u_x's slope, too
    np.testing.assert_allclose((freed[0] @ bent + at[:, 1])[clear], 0.0, atol=1e-14)


@pytest.mark.parametrize("kind", ["diagonal", "crossed", "random", "turned 15°", "turned 30°"])
def test_with_freed_strains_every_mesh_bends_as_a_beam(kind):
    """As paired, border and all: what a linear triangle feigns was the whole of the stiffness."""
    errors = [
        tip(m, pair_triangles(m).patch_of(), strains=freed_rows) - 1.0
        for m in (strip(kind, c) for c in (16, 32))
    ]
    assert abs(errors[1]) < 0.002
    assert abs(errors[1]) < 0.6 * abs(errors[0])
    as_it_is = tip(m := strip(kind, 32), pair_triangles(m).patch_of()) - 1.0
    assert kind == "diagonal" or as_it_is < -0.03
