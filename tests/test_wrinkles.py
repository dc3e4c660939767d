"""Wrinkles on made-up surfaces with known answers: waves, ridges, folds, cones, bends, noise."""

import math

import numpy as np
import pytest

from warpdrape.blanks.ply import Ply
from warpdrape.defects.gaps import ToolGaps
from warpdrape.defects.smoothing import Smoothing
from warpdrape.defects.thresholds import DefectThresholds
from warpdrape.defects.waves import find_waves
from warpdrape.defects.wrinkles import WrinkleSearch
from warpdrape.tools.pose import shifted
from warpdrape.tools.tool import Tool

SIDE, THICKNESS = 0.3, 6e-4
MESHES = [("grid", 40), ("grid", 50), ("grid", 60), ("random", 60)]
WAVE, AMPLITUDE = 0.04, 1e-3


def search(mesh="grid", cells=40, side=SIDE, thickness=THICKNESS, **thresholds):
    ply = Ply.rectangle("ply", "carbon_interlock", side, cells=cells, mesh=mesh)
    return WrinkleSearch(ply.mesh, thickness, DefectThresholds(**thresholds))


def flat(found):
    return np.asarray(found.mesh.vertices)


def lifted(found, heights):
    return np.column_stack([flat(found), heights])


def waves(points, wavelength, angle_deg, phase=0.3):
    across = [math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))]
    return np.sin(2.0 * np.pi / wavelength * (points @ across) + phase)


@pytest.mark.parametrize(("mesh", "cells"), MESHES)
@pytest.mark.parametrize("angle", [0.0, 22.0, 45.0])
def test_a_sheet_of_waves_has_their_amplitude_and_length(mesh, cells, angle):
    """Within 2 % up to 0.4 of the longest wavelength; any away from the edge within 3 %."""
    found = search(mesh, cells, longest_wrinkle=2.5 * WAVE / SIDE)
    heights = AMPLITUDE * waves(flat(found), WAVE, angle) + 0.1 * flat(found)[:, 0]
    seen = found.look(lifted(found, heights))
    way = np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    tilt = math.hypot(1.0, 0.1 * way[0])
    amplitudes = np.array([w.amplitude for w in seen.wrinkles]) * math.hypot(1.0, 0.1) / AMPLITUDE
    lengths = np.array([w.wavelength for w in seen.wrinkles]) / (WAVE * tilt)
    assert np.median(amplitudes) == pytest.approx(1.0, rel=0.02)
    assert np.median(lengths) == pytest.approx(1.0, rel=0.02)
    inner = [np.abs(flat(found)[w.vertex]).max() < SIDE / 2 - 0.75 * WAVE for w in seen.wrinkles]
    assert sum(inner) >= 3  # the others end at the ply's edge
    assert amplitudes[inner] == pytest.approx(1.0, rel=0.03)
    assert lengths[inner] == pytest.approx(1.0, rel=0.03)
    for wrinkle in seen.wrinkles:
        assert abs(np.dot(wrinkle.axis, way)) < 0.06
        assert wrinkle.resolved and not wrinkle.closed
    across = SIDE * way.sum()
    assert abs(len(seen.wrinkles) - across / WAVE) <= 2.0
    assert seen.area_share[0] > 0.85


def test_excess_length_is_that_of_the_sine(rel=0.05):
    """∫√(1 + f'²) over a wave, less the wave, for each inner wrinkle."""
    found = search(cells=60)
    seen = found.look(lifted(found, 2e-3 * waves(flat(found), 0.03, 0.0)))
    x = np.linspace(0.0, 0.03, 2001)
    slope = 2e-3 * 2.0 * np.pi / 0.03 * np.cos(2.0 * np.pi / 0.03 * x)
    expected = float(np.trapezoid(np.sqrt(1.0 + slope**2), x)) - 0.03
    inner = [w for w in seen.wrinkles if abs(flat(found)[w.vertex, 0]) < 0.1]
    assert len(inner) >= 5
    for wrinkle in inner:
        assert wrinkle.excess == pytest.approx(expected, rel=rel)


@pytest.mark.parametrize("cells", [40, 50, 60])
def test_a_ridge_is_one_wrinkle_of_half_its_height(cells):
    """A ridge of 3 mm, 24 mm wide at half height; its own troughs are those of the filter."""
    found = search(cells=cells)
    x, y = flat(found).T
    height = 3e-3 * np.exp(-0.5 * (x / 5e-3) ** 2) * (np.abs(y) < 0.06)
    seen = found.look(lifted(found, -height))
    assert len(seen.wrinkles) == 1
    (ridge,) = seen.wrinkles
    assert 0.85 * 1.5e-3 < ridge.amplitude < 1.05 * 1.5e-3 / 0.75
    assert ridge.length == pytest.approx(0.12, rel=0.2)
    assert abs(flat(found)[ridge.vertex, 0]) < 5e-3
    assert seen.amplitude.max() == pytest.approx(ridge.amplitude, rel=1e-6)


def bent(points, radius, turn):
    """A sheet bent along y over a cylinder, from x = 0 on, in its own length."""
    x, y = points.T
    angle = np.clip(x / radius, 0.0, turn)
    beyond = np.maximum(x - radius * turn, 0.0)
    forward = np.minimum(x, 0.0) + radius * np.sin(angle) + beyond * math.cos(turn)
    down = radius * (1.0 - np.cos(angle)) + beyond * math.sin(turn)
    return np.column_stack([forward, y, -down])


def cone(points, slope=0.5):
    return np.column_stack([points, -slope * np.hypot(*points.T)])


def noise(points, size):
    return np.column_stack([points, np.random.default_rng(1).normal(0.0, size, len(points))])


def fold(points, deep):
    """A sheet laid on itself along y: forward, back by ``deep``, and forward again."""
    x, y = points.T
    height = np.clip((x + 0.5 * deep) / deep, 0.0, 2.0) * 1e-3
    back = np.where(x < 0.5 * deep, x, deep - x)
    return np.column_stack([np.where(x > 1.5 * deep, x - 2.0 * deep, back), y, height])


@pytest.mark.parametrize("cells", [30, 45, 60])
@pytest.mark.parametrize(
    "shape",
    [
        lambda p: bent(p, 0.01, 0.5 * math.pi),
        lambda p: bent(p, 0.03, 1.0),
        lambda p: bent(p, 0.002, 1.0),
        cone,
        lambda p: noise(p, 0.1 * THICKNESS),
        lambda p: np.column_stack([p, 0.2 * p[:, 0] * p[:, 1] / SIDE]),
        lambda p: np.column_stack([p, 0.3 * p[:, 0] - 0.1 * p[:, 1]]),
    ],
    ids=["fillet", "round", "edge", "cone", "noise", "saddle", "tilted"],
)
def test_shapes_without_a_wave_have_none(shape, cells):
    found = search(cells=cells)
    assert found.look(shape(flat(found))).wrinkles == ()


@pytest.mark.parametrize("cells", [40, 60])
def test_a_fold_that_lies_on_the_ply_is_one(cells):
    found = search(cells=cells)
    seen = found.look(fold(flat(found), 0.02))
    assert [w.closed for w in seen.wrinkles] == [True]
    assert abs(flat(found)[seen.wrinkles[0].vertex, 0] - 0.02) < 0.02


def test_a_loop_whose_sides_face_each_other_is_closed():
    """Ω of an Euler curve's kind: sides upright and leaning over."""
    found = search(cells=60)
    x, y = flat(found).T
    turn = 1.75 * np.exp(-0.5 * ((x + 7e-3) / 4e-3) ** 2) - 1.75 * np.exp(
        -0.5 * ((x - 7e-3) / 4e-3) ** 2
    )
    s = np.linspace(-0.5 * SIDE, 0.5 * SIDE, 6001)
    lean = np.interp(s, np.sort(np.unique(x)), turn[np.unique(x, return_index=True)[1]])
    along = np.concatenate([[0.0], np.cumsum(0.5 * (np.cos(lean[1:]) + np.cos(lean[:-1])))])
    up = np.concatenate([[0.0], np.cumsum(0.5 * (np.sin(lean[1:]) + np.sin(lean[:-1])))])
    step = s[1] - s[0]
    points = np.column_stack([np.interp(x, s, step * along), y, np.interp(x, s, step * up)])
    seen = found.look(points)
    assert len(seen.wrinkles) == 1 and seen.wrinkles[0].closed


def test_the_size_of_the_part_does_not_matter():
    """Everything eight times as large, which floats hold exactly: so are the wrinkles."""
    one, other = search(cells=40), search(cells=40, side=8 * SIDE, thickness=8 * THICKNESS)
    shape = AMPLITUDE * waves(flat(one), 0.03, 30.0)
    small, large = one.look(lifted(one, shape)), other.look(lifted(other, 8.0 * shape))
    assert len(small.wrinkles) == len(large.wrinkles) > 5
    for a, b in zip(small.wrinkles, large.wrinkles, strict=True):
        assert b.amplitude == pytest.approx(8 * a.amplitude, rel=1e-9)
        assert b.wavelength == pytest.approx(8 * a.wavelength, rel=1e-9)


def test_a_wave_too_short_for_the_mesh_is_said_to_be():
    found = search(cells=30)
    seen = found.look(lifted(found, AMPLITUDE * waves(flat(found), 0.025, 45.0)))
    assert seen.wrinkles and seen.those(resolved=True) == ()
    assert seen.area_share[0] == 0.0 < seen.area_share[1]


def laid_on(die, points, lift=0.0):
    """A ply that follows the die's ring from its flat round the fillet down its wall."""
    hole, edge = die
    radius, angle = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
    inward = hole + edge - radius  # way past the flat's end
    turn = np.clip(inward / edge, 0.0, 0.5 * math.pi)
    wall = np.maximum(inward - 0.5 * math.pi * edge, 0.0)
    off = 0.5 * THICKNESS + lift
    r = np.maximum(radius, hole + edge) - (edge + off) * np.sin(turn)
    z = -edge + (edge + off) * np.cos(turn) - wall
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), z])


def ring(cells, hole, edge):
    outline = [(0.5 * SIDE * x, 0.5 * SIDE * y) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    across = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    inner = (hole - 0.012) * np.column_stack([np.cos(across), np.sin(across)])
    ply = Ply.polygon("ply", "carbon_interlock", outline, holes=[inner], edge=SIDE / cells)
    return WrinkleSearch(ply.mesh, THICKNESS, DefectThresholds())


@pytest.mark.parametrize("cells", [40, 60])
def test_a_fillet_that_a_ply_lies_on_is_no_wrinkle_but_waves_on_it_are(cells):
    hole, edge = 0.06, 0.01
    die = Tool.die(hole_radius=hole, edge_radius=edge, outer_radius=0.3)
    gaps, found = ToolGaps([die]), ring(cells, hole, edge)
    points = laid_on((hole, edge), flat(found))
    assert found.look(points, lambda: gaps.ways(points, [shifted()])).wrinkles == ()
    angle = np.arctan2(*flat(found).T[::-1])
    wavy = laid_on((hole, edge), flat(found), lift=1e-3 * (1.0 + np.cos(18 * angle)))
    seen = found.look(wavy, lambda: gaps.ways(wavy, [shifted()]))
    assert 15 <= len(seen.wrinkles) <= 21  # eighteen round the ring
    assert np.median([w.amplitude for w in seen.wrinkles]) == pytest.approx(1e-3, rel=0.15)


def test_distances_from_tools_are_those_from_their_true_surface():
    punch = Tool.punch(radius=0.075).moved((0.0, 0.0, 0.01))
    way = np.random.default_rng(2).normal(size=(200, 3))
    way[:, 2] = -np.abs(way[:, 2])
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    center = np.array([0.01, 0.0, 0.085])
    points = center + (0.075 + 3e-4) * way
    found = ToolGaps([punch]).ways(points, [shifted((0.01, 0.0, 0.0))])[0]
    assert np.linalg.norm(found, axis=1) == pytest.approx(3e-4, abs=2e-5)
    assert (found * way).sum(axis=1) == pytest.approx(3e-4, abs=2e-5)


def test_the_filter_has_its_transfer_and_leaves_planes_alone():
    smoothing = Smoothing(search(cells=60).mesh, 0.08)
    points = np.asarray(smoothing.mesh.vertices)
    plane = 3.0 * points[:, 0] - 2.0 * points[:, 1] + 0.5
    assert smoothing.smooth(plane) == pytest.approx(plane, abs=1e-9)
    middle = (np.abs(points) < 0.05).all(axis=1)
    for wavelength in (0.04, 0.06):
        wave = waves(points, wavelength, 22.0)
        left = (wave - smoothing.smooth(wave))[middle]
        share = left @ wave[middle] / (wave[middle] @ wave[middle])
        expected = 1.0 / (1.0 + (wavelength / 0.08) ** 4)
        assert share == pytest.approx(expected, rel=0.02)
        assert smoothing.gain(np.array([2.0 * np.pi / wavelength])) == pytest.approx(expected)
    with np.errstate(all="raise"):  # what a flat ply's noise may ask for
        assert (smoothing.gain(np.array([1e12, 1e90, np.inf])) == 1.0).all()


def test_waves_are_as_high_and_long_whichever_way_they_run():
    """A slope at a vertex is a mean over its triangles, which takes (kh)²/6 of it, a tenth."""
    smoothing = Smoothing(search(cells=60).mesh, 0.08)
    points = np.asarray(smoothing.mesh.vertices)
    middle = (np.abs(points) < 0.05).all(axis=1)
    none = np.zeros((len(points), 1, 3))
    for angle in (0.0, 40.0, 90.0):
        wave = waves(points, 0.04, angle)
        found = find_waves(smoothing, wave[:, None], none).of(0)
        number = found.wave_number[middle]
        assert number.mean() == pytest.approx(2.0 * np.pi / 0.04, rel=0.02)
        height = np.hypot(wave, found.slope / found.wave_number)[middle]
        assert height == pytest.approx(1.0, abs=0.11)


def test_fields_at_once_have_the_waves_that_each_has_alone():
    """Each vertex can be given those of its own field."""
    smoothing = Smoothing(search(cells=20).mesh, 0.08)
    points = np.asarray(smoothing.mesh.vertices)
    fields = np.column_stack([waves(points, 0.04, 20.0), 1e-3 * waves(points, 0.06, 70.0)])
    curvature = smoothing.curvatures(fields)
    both = find_waves(smoothing, fields, curvature)
    own, other = (find_waves(smoothing, fields[:, [k]], curvature[:, [k]]).of(0) for k in range(2))
    assert not np.allclose(own.wave_number, other.wave_number, rtol=0.1)
    mine = np.arange(len(points)) % 2
    picked, joined = both.of(mine), both.beside(both).of(2 + mine)
    for name, alone in vars(own).items():
        expected = np.where(mine == 0, alone.T, getattr(other, name).T).T
        size = np.abs(alone).max()
        assert getattr(picked, name) == pytest.approx(expected, rel=1e-9, abs=1e-12 * size)
        assert (getattr(joined, name) == getattr(picked, name)).all()
