"""The best start and direction of a net: against chance, grids, and the same blank turned."""

import math

import numpy as np
import pytest
import trimesh

import warpdrape as wd
from warpdrape.fishnet.drape import as_surface, read_outline
from warpdrape.fishnet.search import DIRECTIONS, _turns, cost_of
from warpdrape.units import deg
from warpdrape.verification import nets
from warpdrape.verification.net_oracle import saddle


def bump():
    mesh = nets.graph_mesh(saddle(0.0), -0.2, 0.2, 0.4 / 24)
    x, y, _ = mesh.vertices.T
    height = 0.07 * np.exp(-((x - 0.06) ** 2 + (y - 0.03) ** 2) / 0.08**2)
    return as_surface(trimesh.Trimesh(np.column_stack([x, y, height]), mesh.faces, process=False))


@pytest.mark.parametrize(
    "options",
    [
        {"objective": "past_locking", "locking": 20 * deg},
        pytest.param({"objective": "largest"}, marks=pytest.mark.slow),
    ],
)
def test_best_start_and_direction_beat_what_chance_finds(options):
    mould, spacing, random = bump(), 0.02, np.random.default_rng(3)
    best = wd.best_fishnet(mould, spacing, **options)
    locking = options.get("locking")
    cost = cost_of(best, options["objective"], locking, None)
    others = []
    for x, y in random.uniform(-0.18, 0.18, (25, 2)):
        angle = random.uniform(0.0, 0.5 * math.pi)
        warp = (math.cos(angle), math.sin(angle), 0.0)
        net = wd.drape_fishnet(mould, spacing, start=mould.top_at(np.array([x, y])), warp=warp)
        others.append(cost_of(net, options["objective"], locking, None))
    assert cost <= min(others)
    assert cost < 0.8 * np.median(others)


def grid_of(mould, spacing, options, count, turns):
    """Least cost of nets from every start of a lattice in every direction."""
    line = np.linspace(-0.2, 0.2, count + 2)[1:-1]
    angles = np.arange(turns) * 0.5 * math.pi / turns
    return min(
        cost_of(
            wd.drape_fishnet(
                mould,
                spacing,
                start=mould.top_at(np.array([x, y])),
                warp=(math.cos(angle), math.sin(angle), 0.0),
            ),
            options["objective"],
            options.get("locking"),
            None,
        )
        for x in line
        for y in line
        for angle in angles
    )


@pytest.mark.parametrize(
    ("options", "count", "turns"),
    [
        ({"objective": "largest"}, 9, 6),
        pytest.param({"objective": "largest"}, 15, 18, marks=pytest.mark.slow),
        pytest.param(
            {"objective": "past_locking", "locking": 20 * deg}, 15, 18, marks=pytest.mark.slow
        ),
    ],
)
def test_best_start_is_that_of_a_grid_of_all(options, count, turns):
    mould, spacing = bump(), 0.02
    cost = cost_of(
        wd.best_fishnet(mould, spacing, **options),
        options["objective"],
        options.get("locking"),
        None,
    )
    assert cost <= grid_of(mould, spacing, options, count, turns)


def test_directions_that_are_tried_are_all_that_differ():
    quarter = 0.5 * math.pi
    square = read_outline([(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)])
    wide = read_outline([(-0.2, -0.1), (0.2, -0.1), (0.2, 0.1), (-0.2, 0.1)])
    moved = read_outline([(-0.2, -0.1), (0.3, -0.1), (0.3, 0.1), (-0.2, 0.1)])
    for ring, yarn_angle, right_angles in (
        (None, quarter, 1),
        (None, 60 * deg, 2),
        (square, quarter, 1),
        (square, 60 * deg, 2),
        (wide, quarter, 2),
        (moved, quarter, 4),
    ):
        turns = _turns(ring, yarn_angle)
        assert turns[0] == 0.0 and len(turns) == right_angles * DIRECTIONS
        assert turns[-1] == pytest.approx(right_angles * quarter - turns[1])


@pytest.mark.slow
def test_a_long_blank_is_laid_along_a_ridge_either_way_round():
    """Turned by a right angle it is another blank: the best way is found in whichever it lies."""
    mesh = nets.graph_mesh(saddle(0.0), -0.2, 0.2, 0.4 / 24)
    x, y, _ = mesh.vertices.T
    mesh = trimesh.Trimesh(
        np.column_stack([x, y, 0.06 * np.exp(-(y**2) / 0.05**2 - x**2 / 0.1**2)]),
        mesh.faces,
        process=False,
    )
    half = np.array([(-0.13, -0.06), (0.13, -0.06), (0.13, 0.06), (-0.13, 0.06)])
    costs = [
        cost_of(wd.best_fishnet(mesh, 0.02, outline=ring), "largest", None, read_outline(ring))
        for ring in (half, half[:, ::-1] * (-1.0, 1.0))
    ]
    assert costs[0] == pytest.approx(costs[1], abs=0.05)
