"""Tools that close to less than a ply's thickness are named, with place and by how much."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from warpdrape import Ply, Scene, Stroke, Tool
from warpdrape.contact.squeeze import _apart, _between_vertices
from warpdrape.contact.tool_surfaces import tool_surfaces
from warpdrape.dynamics.model import build_model
from warpdrape.tools.pose import Pose, rotation
from warpdrape.tools.profile import Line, extrude
from warpdrape.watch import Seen, Watch

SHEET = Ply.rectangle("sheet", "carbon_interlock", 0.1, cells=6, mesh="grid")
THICKNESS = SHEET.fabric.thickness


def closed(left):
    """The sheet between plates that close until so much is left between them [m]."""
    lower = Tool.plate("mould", width=0.3, height=0.3).moved((0, 0, -0.5 * THICKNESS))
    way = 1e-3 + THICKNESS - left
    upper = Tool.plate(
        "punch",
        width=0.06,
        height=0.06,
        facing="down",
        motion=Stroke(travel=(0.0, 0.0, -way), duration=0.02),
    ).moved((0, 0, 0.5 * THICKNESS + 1e-3))
    scene = Scene(name="closed", plies=[SHEET], tools=[lower, upper], duration=0.02)
    return scene.run(frames=4, quiet=True)


def complaints(result):
    return [text for text in result.summary["warnings"] if "squeeze" in text]


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_plates_that_leave_too_little_room_are_named(share):
    result = closed(share * THICKNESS)
    (said,) = complaints(result)
    assert said.startswith("tools 'mould' and 'punch' squeeze ply 'sheet', triangle ")
    below = float(re.search(r"\) (\S+) mm below its thickness of 0.6 mm at 20 ms", said)[1])
    assert below == pytest.approx(1e3 * (1.0 - share) * THICKNESS, rel=0.05)
    x, y = map(float, re.search(r"ms, \((\S+), (\S+)\) mm: ", said).groups())
    assert max(abs(x), abs(y)) <= 30.0 + 1e-6
    assert result.summary["tools"][1]["max_force_n"] > 100.0
    assert "leave the ply its thickness" in said


def test_plates_that_leave_the_ply_its_thickness_are_not():
    result = closed(THICKNESS)
    assert complaints(result) == []
    assert np.isfinite(result.plies[0].points).all()


FLANK = np.radians(22.5)


def wedge(facing, low):
    """A valley along y with flanks of 22.5°, its bottom at a height [m]; or the edge over it."""
    half = 0.014
    high = half * np.tan(FLANK)
    across = [Line((-half, high), (0.0, 0.0)), Line((0.0, 0.0), (half, high))]
    if facing == "down":
        across = [Line(piece.end, piece.start) for piece in reversed(across)]
    mesh = extrude(across, 0.04, 0.01).mesh
    return Tool.from_mesh("valley" if facing == "up" else "edge", mesh).moved((1e-3, 0.0, low))


def bent_into_a_valley(cells):
    """A strip pressed by an edge into a valley whose flanks leave it half more than it needs."""
    strip = Ply.rectangle("strip", "carbon_interlock", 0.024, 0.006, cells=cells, mesh="grid")
    bottom, start, apart = -6e-3, 0.4e-3, 1.5 * THICKNESS / np.cos(FLANK)
    down = Stroke(travel=(0.0, 0.0, bottom + apart - start), duration=6e-3)
    tools = [wedge("up", bottom), replace(wedge("down", start), motion=down)]
    scene = Scene(
        name="v", plies=[strip], tools=tools, duration=6e-3, friction=0.8, gravity=(0, 0, 0)
    )
    return scene.run(frames=10, quiet=True), apart


def test_a_triangle_over_a_hollow_is_told_from_too_little_room_and_finer_ones_fit():
    """The tools leave what the ply needs: its triangles, which are flat, do not go round the bend.

    A side whose ends lie on the two flanks cuts the corner off.
    """
    coarse, apart = bent_into_a_valley(4)
    (said,) = complaints(coarse)
    left = float(re.search(r"they leave (\S+) mm there, but the ply's flat", said)[1])
    assert 1e3 * apart * np.cos(FLANK) - 0.01 <= left <= 1.001e3 * apart
    assert "refine the ply" in said and "leave the ply its thickness" not in said
    fine = bent_into_a_valley(16)[0]
    assert complaints(fine) == []
    assert float(re.search(r"(\S+) mm below", said)[1]) == pytest.approx(0.319, abs=0.01)
    forces = [np.abs(each.history["edge_force_n"]).max() for each in (coarse, fine)]
    assert forces == pytest.approx([972.0, 5.0], rel=0.05)


def test_how_far_tools_that_have_turned_are_apart():
    """A point of one over a plate: along the plate's normal, none behind it or beyond reach."""
    plate = Tool.plate(width=0.2, height=0.2)
    scene = Scene(name="s", plies=[SHEET], tools=[plate], duration=1e-3)
    meshes = tool_surfaces(scene, "cpu")[0]
    one = Pose(rotation((0.0, 1.0, 0.0), 0.7), np.array([0.1, 0.0, 0.2]))
    ground = Pose(rotation((1.0, 0.0, 0.0), -1.2), np.array([0.0, 0.3, -0.1]))
    held = SimpleNamespace(poses=[one, ground], meshes=[None, *meshes])
    up = ground.direct(np.array([0.0, 0.0, 1.0]))
    foot = ground.place(np.array([[0.013, -0.02, 0.0]]))[0]
    for way, outward, found in ((1.0, -up, 2e-3), (1.0, up, 0.0), (8.0, -up, 0.0)):
        point = one.into((foot + 2e-3 * way * up)[None])[0]
        apart = _apart(held, (0, 1), point, outward, 10e-3)
        assert apart == pytest.approx(found, abs=1e-7)


def test_with_a_compaction_law_room_and_depth_are_what_tools_lack_of_the_thickness():
    held = SimpleNamespace(
        pressed=np.ones((2, 1), dtype=bool),
        normals=np.array([[[0.0, 0.0, 1.0]], [[0.0, 0.0, -1.0]]]),
        depth=np.array([[1.5e-4], [1.1e-4]]),
        thickness=np.array([6e-4]),
        rooms=np.array([2e-4]),
    )
    found = _between_vertices(held)
    assert found.tools == (0, 1) and found.depth == pytest.approx(0.6e-4)
    assert found.apart == pytest.approx(6e-4 - 2.6e-4)


def test_what_blows_up_after_a_squeeze_says_both():
    scene = Scene(name="s", plies=[SHEET], duration=1e-3)
    model = build_model(scene, "cpu", 1)
    alone = Watch(model).where_it_blew_up(3, 2e-3)
    assert alone.startswith("blew up at 2 ms in ply 'sheet'") and "before that" not in alone
    seen = Seen(squeezed="tools 'a' and 'b' squeeze ply 'sheet'")
    assert Watch(model, seen).where_it_blew_up(3, 2e-3) == f"{alone}; before that, {seen.squeezed}"
