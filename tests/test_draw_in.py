"""Draw-in of blanks that are moved by hand."""

import math

import numpy as np
import pytest

from warpdrape.blanks.ply import Ply
from warpdrape.results.draw_in import draw_in

SIDE = 0.2


def square(angle_deg=0.0, **options):
    options = {"cells": 8, "mesh": "grid"} | options
    angle = math.radians(angle_deg)
    return Ply.rectangle("ply", "carbon_interlock", SIDE, warp_angle=angle, z=0.01, **options)


def moved(ply, stretch_x=1.0, stretch_y=1.0, lift=0.0, shift=0.0):
    flat = ply.rest_points
    raised = flat[:, 2] + lift * (flat[:, 0] ** 2 + flat[:, 1] ** 2)
    return np.column_stack([flat[:, 0] * stretch_x + shift, flat[:, 1] * stretch_y, raised])


def test_each_direction_has_its_own_and_height_does_not_count():
    ply = square()
    drawn = draw_in(ply, moved(ply, stretch_x=0.9, stretch_y=0.8, lift=3.0))
    assert drawn["warp_plus"] == pytest.approx(0.1 * 0.5 * SIDE)
    assert drawn["warp"] == pytest.approx(0.1 * 0.5 * SIDE)
    assert drawn["weft_minus"] == pytest.approx(0.2 * 0.5 * SIDE)
    assert drawn["weft"] == pytest.approx(0.2 * 0.5 * SIDE)
    # The corner at (½, ½) side goes to (0.45, 0.4) side.
    corner = SIDE * (math.sqrt(0.5) - math.hypot(0.45, 0.4))
    assert [drawn[f"bias_{k}"] for k in (1, 2, 3, 4)] == pytest.approx([corner] * 4)
    assert drawn["bias"] == pytest.approx(corner)


def test_directions_turn_with_the_yarns():
    ply = square(angle_deg=45.0)
    drawn = draw_in(ply, moved(ply, stretch_x=0.9, stretch_y=0.8))
    corner = SIDE * (math.sqrt(0.5) - math.hypot(0.45, 0.4))
    assert drawn["warp"] == pytest.approx(corner) and drawn["weft"] == pytest.approx(corner)
    # Between yarns at ±45° lie the axes; from +45°, half-way to the weft is y.
    assert drawn["bias_1"] == pytest.approx(0.2 * 0.5 * SIDE)
    assert drawn["bias_2"] == pytest.approx(0.1 * 0.5 * SIDE)
    assert drawn["bias"] == pytest.approx(0.15 * 0.5 * SIDE)


def test_a_blank_that_slides_is_drawn_in_on_one_side_only():
    ply = square()
    drawn = draw_in(ply, moved(ply, shift=0.003))
    assert drawn["warp_minus"] == pytest.approx(0.003)
    assert drawn["warp_plus"] == pytest.approx(-0.003)
    assert drawn["warp"] == pytest.approx(0.0, abs=1e-15)


def test_between_vertices_the_edge_is_interpolated():
    ply = square(angle_deg=20.0, cells=3)
    drawn = draw_in(ply, moved(ply, stretch_x=0.9, stretch_y=0.9))
    # The warp leaves the square through its side x = ½ side.
    assert drawn["warp"] == pytest.approx(0.1 * 0.5 * SIDE / math.cos(math.radians(20.0)))


def test_a_hole_is_not_the_edge():
    outline = 0.5 * SIDE * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    ply = Ply.polygon("ply", "carbon_interlock", outline, holes=[0.3 * outline], edge=0.02, z=0.01)
    assert draw_in(ply, moved(ply, stretch_x=0.9))["warp"] == pytest.approx(0.1 * 0.5 * SIDE)
