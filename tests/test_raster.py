import numpy as np
import pytest

from warpdrape.defects.wrinkle_field import vertex_normals
from warpdrape.results import raster
from warpdrape.results.raster import Camera, find_visible


def brute_force(screen, triangles, size):
    """Test every triangle at every pixel centre."""
    width, height = size
    owner = np.full((height, width), -1)
    for row in range(height):
        for column in range(width):
            best = np.inf
            for t, (a, b, c) in enumerate(screen[triangles]):
                edges = np.stack([b - a, c - a], axis=1)
                if abs(np.linalg.det(edges[:2])) < 1e-9:
                    continue
                s, r = np.linalg.solve(edges[:2], [column + 0.5 - a[0], row + 0.5 - a[1]])
                depth = a[2] + edges[2] @ [s, r]
                if s >= 0 and r >= 0 and s + r <= 1 and depth < best:
                    best, owner[row, column] = depth, t
    return owner


@pytest.mark.parametrize("portion", [7, 500_000])
def test_visible_triangles_are_those_of_brute_force(monkeypatch, portion):
    monkeypatch.setattr(raster, "_PORTION", portion)
    rng = np.random.default_rng(1)
    size = (23, 17)
    screen = rng.uniform([-4, -4, 0], [27, 21, 1], (24, 3))  # some outside the image
    triangles = rng.permutation(24).reshape(8, 3)
    triangles = np.concatenate([triangles, [[0, 0, 1]]])  # and one without an area
    seen = find_visible(screen, triangles, size)
    owner = np.full(size[0] * size[1], -1)
    owner[seen.pixel] = seen.triangle
    expected = brute_force(screen, triangles, size)
    assert len(np.unique(expected)) > 5
    np.testing.assert_array_equal(owner.reshape(17, 23), expected)
    here = seen.blend(screen[triangles[seen.triangle]])
    centres = np.stack([seen.pixel % 23 + 0.5, seen.pixel // 23 + 0.5, seen.depth], axis=1)
    np.testing.assert_allclose(here, centres, atol=1e-9)


def test_nothing_in_view():
    seen = find_visible(np.full((3, 3), -9.0), np.array([[0, 1, 2]]), (4, 4))
    assert len(seen.pixel) == 0
    assert len(find_visible(np.zeros((0, 3)), np.zeros((0, 3), int), (4, 4)).pixel) == 0


@pytest.mark.parametrize("upside_down", [False, True])
def test_camera_holds_all_points_and_sees_the_near_side(upside_down):
    points = np.random.default_rng(2).uniform(-0.2, 0.3, (50, 3))
    camera = Camera.around(points, 32.0, -62.0, 640, upside_down=upside_down)
    column, row, _ = camera.project(points).T
    assert camera.size[0] == 640
    assert column.min() == pytest.approx(0.0, abs=1e-9)
    assert column.max() == pytest.approx(640.0)
    assert row.min() == pytest.approx(0.0, abs=1e-9)
    assert row.max() <= camera.size[1] < row.max() + 1.0
    assert np.linalg.det(camera.axes) == pytest.approx(1.0)  # no mirror image
    toward = camera.target + 0.1 * camera.axes[2]
    assert camera.project(np.stack([toward, camera.target]))[:, 2].argmin() == 0
    up = camera.project(camera.target + np.array([[0, 0, 0.1], [0, 0, -0.1]]))
    assert (up[0, 1] < up[1, 1]) != upside_down


def test_normals_of_a_sphere_point_outwards():
    import trimesh

    sphere = trimesh.creation.icosphere(subdivisions=3)
    normals = vertex_normals(np.array(sphere.vertices), np.array(sphere.faces))
    assert np.einsum("ij,ij->i", normals, sphere.vertices).min() > 0.999
