"""Gradients at vertices do not hang on how these are numbered, and are exact on what is linear."""

import numpy as np
import pytest

from warpdrape import Ply
from warpdrape.forces.vertex_gradients import vertex_gradients


@pytest.mark.parametrize("pattern", ["grid", "diagonal"])
@pytest.mark.parametrize("width", [0.06, 0.01])
def test_vertices_may_be_numbered_in_any_order(pattern, width):
    """Others that are as far off as each other are taken together; a strip one square wide too."""
    mesh = Ply.rectangle("p", "carbon_interlock", 0.06, width, edge=0.01, mesh=pattern).mesh
    points, triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    plain = vertex_gradients(points, triangles)
    for seed in range(3):
        order = np.random.default_rng(seed).permutation(len(points))
        place = np.argsort(order)
        for one, other in zip(
            plain, vertex_gradients(points[order], place[triangles]), strict=True
        ):
            largest = np.abs(one).max()
            difference = np.abs(one[order][:, order] - other).max()
            assert largest > 10.0 and difference < 1e-9 * largest


@pytest.mark.parametrize("pattern", ["grid", "diagonal"])
@pytest.mark.parametrize("width", [0.06, 0.01])
def test_linear_functions_have_their_gradients_on_strips_too(pattern, width):
    mesh = Ply.rectangle("p", "carbon_interlock", 0.06, width, edge=0.01, mesh=pattern).mesh
    points = np.asarray(mesh.vertices)
    found = [
        g @ (3.0 * points[:, 0] - 2.0 * points[:, 1])
        for g in vertex_gradients(points, np.asarray(mesh.triangles))
    ]
    np.testing.assert_allclose(found[0], 3.0, atol=1e-11)
    np.testing.assert_allclose(found[1], -2.0, atol=1e-11)


@pytest.mark.parametrize("pattern", ["grid", "diagonal"])
@pytest.mark.parametrize("width", [0.06, 0.01])
def test_parabolas_along_the_ply_have_theirs_on_strips_too(pattern, width):
    """A strip one square wide shows x² and x y, though not y²."""
    mesh = Ply.rectangle("p", "carbon_interlock", 0.06, width, edge=0.01, mesh=pattern).mesh
    x, y = np.asarray(mesh.vertices).T
    along, across = vertex_gradients(np.asarray(mesh.vertices), np.asarray(mesh.triangles))
    np.testing.assert_allclose(along @ x**2, 2.0 * x, atol=1e-11)
    np.testing.assert_allclose(across @ x**2, 0.0, atol=1e-11)
    np.testing.assert_allclose(along @ (x * y), y, atol=1e-11)
    np.testing.assert_allclose(across @ (x * y), x, atol=1e-11)
