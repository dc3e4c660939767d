"""Shear read off a formed ply in several ways, against maps whose shear is known."""

import sys

import numpy as np
import pytest
from test_bench import loaded

from warpdrape.blanks.pairing import pair_triangles

meshes = loaded("meshes")  # which readings.py imports, as a neighbour
readings = loaded("readings")

ANGLE = np.radians(25.0)


def sheared(at):
    """A cubic map with bands of shear: its vertices [m], and ∂x/∂X, ∂x/∂Y there."""
    x, y = at.T / meshes.SIZE
    zero, one = np.zeros(len(x)), np.ones(len(x))
    points = np.stack([x, y + 0.8 * x**3 - 0.2 * x, 0.5 * x * y**2], axis=1) * meshes.SIZE
    along = np.stack([one, 2.4 * x**2 - 0.2, 0.5 * y**2], axis=1)
    across = np.stack([zero, one, x * y], axis=1)
    return points, np.stack([along, across], axis=1)


def straight(at):
    """A map without curvature, sheared by 0.3 along x."""
    return np.column_stack([at[:, 0] + 0.3 * at[:, 1], at[:, 1], np.full(len(at), 0.02)])


def test_shear_has_the_sign_and_the_size_that_results_have(tmp_path):
    parameters = {"angle_deg": 30.0, "duration": 0.004}
    with np.load(meshes.kept("grid", 6, parameters, tmp_path)) as kept:
        formed = dict(kept)
    mesh = readings.FlatMesh(formed["rest_points"][:, :2], formed["triangles"])
    expected = np.degrees(formed["shear_angle"])
    assert np.abs(expected).max() > 1.0
    found = readings.by_triangle(mesh, formed["points"], np.radians(30.0))
    assert found == pytest.approx(expected, abs=1e-4)  # kept in single precision


@pytest.mark.parametrize("kind", ["grid", "random, seed 1", "lattice turned by 30°"])
def test_the_smooth_reading_is_exact_on_cubics_and_triangles_are_not(kind):
    mesh = meshes.mesh(kind, 12)
    points, _ = sheared(mesh.vertices)
    _, slopes = sheared(mesh.vertices[mesh.triangles].mean(axis=1))
    expected = readings.shear_of(slopes, ANGLE)
    assert np.ptp(expected) > 10.0
    assert readings.smoothly(mesh, points, ANGLE) == pytest.approx(expected, abs=1e-8)
    assert np.abs(readings.by_triangle(mesh, points, ANGLE) - expected).max() > 0.3


def test_a_patch_reads_the_mean_of_its_triangles():
    mesh = meshes.mesh("random, seed 0", 8)
    points, _ = sheared(mesh.vertices)
    one, mean = (read(mesh, points, ANGLE) for read in (readings.by_triangle, readings.by_pair))
    pairing = pair_triangles(mesh)
    for start, end in zip(pairing.offsets[:-1], pairing.offsets[1:], strict=True):
        patch = pairing.triangles[start:end]
        expected = np.average(one[patch], weights=mesh.areas[patch])
        assert mean[patch] == pytest.approx(expected, abs=1e-9)
    assert np.abs(one - mean).max() > 0.1


def test_the_common_deformation_is_the_one_that_all_plies_share():
    mesh = meshes.mesh("random, seed 2", 12)
    smooth = readings.nearest_smooth(mesh.vertices, sheared(mesh.vertices)[0])
    places = np.random.default_rng(0).uniform(-0.15, 0.15, (50, 2))
    assert smooth(places) == pytest.approx(sheared(places)[0], abs=1e-9)


def test_a_straight_deformation_reads_the_same_on_all_meshes():
    plies = {}
    for kind in ("grid", "diagonal", "random, seed 0"):
        mesh = meshes.mesh(kind, 8)
        plies[kind] = mesh, straight(mesh.vertices)
    rows = readings.table(plies, 0.0).splitlines()
    angle = np.degrees(np.arctan(0.3))  # its only shear, largest and percentiles alike
    cell = f"{angle:.1f}, {angle:.1f}, {angle:.2f}°"
    assert [row.count(cell) for row in rows[2:5]] == [6, 6, 6]
    assert rows[5].count("0.0, 0.0, 0.00°") == 6


def test_the_table_is_made_from_plies_that_are_kept(tmp_path, capsys, monkeypatch):
    words = "readings.py --angle 30 --cells 4 --meshes grid diagonal --set duration=0.004"
    monkeypatch.setattr(sys, "argv", [*words.split(), "--runs", str(tmp_path)])
    assert readings.main() == 0
    first = capsys.readouterr().out
    assert "4 cells" in first and "| own, triangles |" in first and "| range |" in first
    monkeypatch.setattr(meshes, "run_here", None)  # what is there is not done again
    row = meshes.done("grid", 4, {"angle_deg": 30.0, "duration": 0.004}, tmp_path)
    assert "| grid | {largest:.1f}, {p99:.1f}, {p95:.2f}° |".format_map(row) in first
    assert readings.main() == 0
    assert capsys.readouterr().out == first
