"""Plies that nothing holds: over edges, on balls and drums, folded, with and without bending."""

import math

import numpy as np
import pytest
import trimesh

import warpdrape as wd
from warpdrape.materials.fabric_library import with_bending

KINDS = ("plate", "box", "table", "drop", "fold", "drum")


def loose(number, folder, cells=None, duration=0.25):
    """One of many: all that is random follows from its number."""
    rng = np.random.default_rng(number)
    over, turn = rng.uniform(0.05, 0.16), rng.uniform(0.0, 0.5 * math.pi)
    kind, mesh = KINDS[number % 6], ("diagonal", "grid", "random", "aligned")[number % 4]
    cloth = with_bending("carbon_interlock", ("none", "fabric", "0.0003")[number % 3])
    cells, back = cells or int(rng.integers(10, 15)), -0.05 - over
    clamps, low = [], 0.001
    if kind == "plate":
        tool = wd.Tool.plate(width=0.4, height=0.4).moved((back, 0.0, 0.0))
    elif kind == "box":
        solid = trimesh.creation.box(extents=(0.4, 0.4, 0.05)).subdivide().subdivide()
        solid.export(folder / "box.stl")
        tool = wd.Tool.from_mesh("box", folder / "box.stl").moved((back, 0.0, -0.026))
    elif kind == "table":
        tool = wd.Tool.table(radius=0.15 - 0.7 * over, edge_radius=0.005, depth=0.3)
    elif kind == "drum":
        tool = wd.Tool.drum(radius=0.06, length=0.5).moved((0.0, 0.0, -0.06))
    elif kind == "drop":
        tool, low = wd.Tool.sphere(radius=0.08).moved((0.0, 0.0, -0.03)), 0.02
    else:
        tool = wd.Tool.plate(width=0.8, height=0.8)
        over_itself = wd.Stroke(travel=(0.12, 0.0, 0.1), duration=0.8 * duration)
        clamps = [
            wd.Clamp(name="end", ply="p", where=lambda p: p[:, 0] < -0.149, motion=over_itself)
        ]
    plies = wd.lay_up(
        [wd.Ply.rectangle("p", cloth, 0.3, cells=cells, mesh=mesh, warp_angle=turn)], z=low
    )
    return wd.Scene(name=kind, plies=plies, tools=[tool], clamps=clamps, duration=duration)


def check(scene):
    result = scene.run(frames=20, threads=1)
    assert result.completed, result.summary["message"]
    assert result.summary["energy_error"] < 0.01
    assert np.isfinite(result.plies[0].points).all()


@pytest.mark.parametrize("number", [0, 2, 3, 4])
def test_a_loose_ply_keeps_its_energy(number, tmp_path):
    check(loose(number, tmp_path, cells=8, duration=0.12))


@pytest.mark.slow
@pytest.mark.parametrize("number", range(20))
def test_loose_plies_of_every_kind_keep_their_energy(number, tmp_path):
    check(loose(number, tmp_path))
