"""Pairings cover every triangle once, leave few over and make no chains of flat pairs."""

import numpy as np
import pytest
import rustworkx

from warpdrape.blanks import pairing
from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.meshing import mesh_outline
from warpdrape.blanks.outlines import Disc, Rectangle
from warpdrape.blanks.pairing import pair_triangles, quad_shape


def dual_links(mesh):
    links = mesh.edges.triangles
    return links[links[:, 1] >= 0]


def largest_matching(links, n_nodes):
    """Number of unmatched nodes that the library's whole-graph matching leaves."""
    graph = rustworkx.PyGraph()
    graph.add_nodes_from(range(n_nodes))
    graph.extend_from_edge_list([tuple(link) for link in np.asarray(links).tolist()])
    return n_nodes - 2 * len(rustworkx.max_weight_matching(graph, max_cardinality=True))


def check_patches(mesh, pairs):
    """Every triangle once, patches connected, pairs first; returns how many are not in pairs."""
    assert np.array_equal(np.sort(pairs.triangles), np.arange(len(mesh.triangles)))
    assert pairs.offsets[0] == 0 and pairs.offsets[-1] == len(mesh.triangles)
    assert (pairs.sizes[: pairs.n_pairs] == 2).all() and (pairs.sizes[pairs.n_pairs :] != 2).all()
    patch = pairs.patch_of()
    links = dual_links(mesh)
    inside = links[patch[links[:, 0]] == patch[links[:, 1]]]
    linked = np.bincount(patch[inside[:, 0]], minlength=len(pairs.sizes))
    assert (linked >= pairs.sizes - 1).all()
    sharing = {tuple(sorted(link)) for link in links.tolist()}
    assert all(tuple(sorted(pair)) in sharing for pair in pairs.pairs.tolist())
    return int((pairs.sizes[pairs.n_pairs :] - 2).clip(min=0).sum() + (pairs.sizes == 1).sum())


def ragged(mesh, rng, share):
    """The mesh without a random share of its triangles: corners, ears, islands."""
    rows = mesh.triangles[rng.random(len(mesh.triangles)) > share]
    used, rows = np.unique(rows, return_inverse=True)
    return FlatMesh(mesh.vertices[used], rows.reshape(-1, 3))


def test_four_triangles_of_a_square_make_two_pairs():
    pairs = pair_triangles(mesh_outline(Rectangle(1.0, 1.0), cells=1))
    assert pairs.sizes.tolist() == [2, 2]


def test_strip_of_three_is_one_patch_and_one_alone_is_its_own():
    vertices = [(0, 0), (1, 0), (0, 1), (1, 1), (2, 1), (5, 0), (6, 0), (5, 1)]
    triangles = [[0, 1, 2], [1, 3, 2], [1, 4, 3], [5, 6, 7]]
    pairs = pair_triangles(FlatMesh.from_arrays(vertices, triangles))
    assert sorted(pairs.sizes.tolist()) == [1, 3]
    assert pairs.patch_of()[0] == pairs.patch_of()[1] == pairs.patch_of()[2]
    assert pairs.n_pairs == 0 and len(pairs.pairs) == 0


def test_two_leftovers_of_a_star_join_one_patch():
    vertices = [(0, 0), (2, 0), (1, 2), (1, -1), (3, 2), (-1, 2)]
    triangles = [[0, 1, 2], [0, 3, 1], [1, 4, 2], [2, 5, 0]]
    assert pair_triangles(FlatMesh.from_arrays(vertices, triangles)).sizes.tolist() == [4]


@pytest.mark.parametrize("pattern", ["grid", "diagonal", "random"])
@pytest.mark.parametrize("size", [7, 20, 41])
def test_regular_meshes_leave_hardly_a_triangle_over(pattern, size):
    mesh = mesh_outline(Rectangle(1.0, 1.0), cells=size, pattern=pattern)
    left = check_patches(mesh, pair_triangles(mesh))
    if pattern == "random":  # rather over than ill-paired, away from the border
        assert 0 < left < 0.04 * len(mesh.triangles) + 4
    elif pattern == "diagonal" or size == 20:
        assert left == len(mesh.triangles) % 2
    else:  # one a side where the side's count is odd; a few where blocks met
        assert left <= max(4, 0.003 * len(mesh.triangles))


def test_a_turned_disc_of_many_blocks_leaves_over_no_more_than_its_rim_needs():
    mesh = mesh_outline(Disc(1.0), cells=80, warp_angle=0.4)
    assert len(mesh.triangles) > 50 * pairing.BLOCK
    left = check_patches(mesh, pair_triangles(mesh))
    assert 0 < left < len(mesh.boundary_edges)


def test_triangles_left_over_join_a_pair_and_draw_no_chain_of_flat_pairs():
    mesh = mesh_outline(Rectangle(0.1, 0.2), edge=0.005, warp_angle=0.4)
    pairs = pair_triangles(mesh)
    left = check_patches(mesh, pairs)
    assert 0 < left < len(mesh.boundary_edges)
    patch, links = pairs.patch_of(), dual_links(mesh)
    in_pair = (patch[links[:, 0]] == patch[links[:, 1]]) & (patch[links[:, 0]] < pairs.n_pairs)
    flat = links[in_pair & (quad_shape(mesh) < 0.1)]
    on_border = np.isin(mesh.triangles, mesh.boundary_edges).any(axis=1)
    assert len(flat) < 0.01 * pairs.n_pairs
    assert largest_matching(links, len(mesh.triangles)) < left  # it could pair more, at a price
    assert on_border[flat].any(axis=1).sum() >= len(flat) - 8


@pytest.mark.parametrize("whole", [0, 10_000])
@pytest.mark.parametrize("share", [0.02, 0.1, 0.3])
def test_ragged_meshes_leave_no_two_neighbours_over(share, whole, monkeypatch):
    monkeypatch.setattr(pairing, "WHOLE", whole)
    monkeypatch.setattr(pairing, "BLOCK", 64)
    rng = np.random.default_rng(round(100 * share))
    unpaired = 0
    for seed in range(3):
        full = mesh_outline(Rectangle(1.0, 1.0), cells=18, pattern="random", seed=seed)
        mesh = ragged(full, rng, share)
        pairs = pair_triangles(mesh)
        left = check_patches(mesh, pairs)
        links = dual_links(mesh)
        assert left >= largest_matching(links, len(mesh.triangles))
        alone = pairs.sizes[pairs.patch_of()] == 1
        assert not alone[links].any()  # only what has no neighbour stays alone
        unpaired += left
    assert unpaired > 0  # else the case above tests nothing


def test_blocks_come_near_the_best_shape(monkeypatch):
    mesh = mesh_outline(Rectangle(1.0, 1.0), cells=24, pattern="random", seed=2)
    links, shape = dual_links(mesh), quad_shape(mesh)

    def mean_shape():
        patch = pair_triangles(mesh).patch_of()
        return shape[patch[links[:, 0]] == patch[links[:, 1]]].mean()

    best = mean_shape()
    monkeypatch.setattr(pairing, "WHOLE", 0)
    near = mean_shape()
    assert 0.55 < best < 0.75  # no mesh of near-equilateral triangles can do better than 2/3
    assert best - 0.02 < near <= best + 1e-3


def test_quad_shape_knows_squares_and_flat_angles():
    mesh = mesh_outline(Rectangle(2.0, 1.0), cells=2)
    ends = mesh.edges.vertices[mesh.edges.triangles[:, 1] >= 0]
    middle = np.isclose(mesh.vertices[ends][..., 0], 0.0).all(axis=1)  # between the two squares
    assert quad_shape(mesh)[middle] == pytest.approx(1.0)
    assert quad_shape(mesh)[~middle] == pytest.approx(0.0, abs=1e-12)
