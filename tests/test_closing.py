"""Tools that will close to less than the plies' thickness are named before a run."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from warpdrape import Compaction, Float, Ply, Scene, Stroke, Tool, lay_up
from warpdrape.contact import closing
from warpdrape.contact.closing import closing_tools
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.scenes import circular_table, hemisphere, stacked_hemisphere, three_ply_hemisphere

THICKNESS = 6e-4


def plates(left, *, count=1, width=0.06, aside=0.0, fabric="carbon_interlock", motion=None):
    """A plate that closes on another until so much is left between them [m]."""
    plies = lay_up([Ply.rectangle(f"ply_{n}", fabric, 0.1, cells=3) for n in range(count)])
    start = count * THICKNESS + 5e-3
    motion = motion or Stroke(travel=(0.0, 0.0, left - start), duration=0.01)
    top = Tool.plate("top", width=width, height=width, facing="down", motion=motion)
    bottom = Tool.plate("bottom", width=0.3, height=0.3)
    tools = [bottom, top.moved((aside, 0.0, start))]
    return Scene(name="plates", plies=plies, tools=tools, duration=0.02)


@pytest.mark.parametrize("count", [1, 3])
def test_less_room_than_the_plies_need_is_named_with_place_and_time(count):
    (found,) = closing_tools(plates(0.5 * count * THICKNESS, count=count))
    assert set(found.tools) == {"top", "bottom"}
    assert found.gap == pytest.approx(0.5 * count * THICKNESS, rel=1e-3)
    assert found.thickness == pytest.approx(count * THICKNESS)
    assert found.time == pytest.approx(0.01, abs=1e-3)
    assert np.abs(found.place[:2]).max() <= 0.03
    assert f"leave {0.3 * count:.3g} mm between them" in str(found)
    assert str(found).endswith(f"plies that lie there are {0.6 * count:.3g} mm thick")


def test_tools_that_pass_into_each_other_leave_no_room():
    (found,) = closing_tools(plates(-2e-4))
    assert found.gap < 0.0
    assert "leave no room between them" in str(found)


@pytest.mark.parametrize(
    "given",
    [
        {"left": THICKNESS},
        {"left": 2e-4, "aside": 0.1},  # beside the ply
        {"left": 2e-4, "motion": Float(force=10.0)},  # gives way
    ],
)
def test_enough_room_is_not_named(given):
    assert closing_tools(plates(**given)) == []


def test_a_ply_that_can_be_compacted_needs_its_least_thickness_only():
    law = Compaction(thicknesses=(6e-4, 5e-4, 4e-4), pressures=(0.0, 1e4, 1e5))
    fabric = replace(load_fabric("carbon_interlock"), compaction=law)
    assert closing_tools(plates(4.5e-4, fabric=fabric)) == []
    assert len(closing_tools(plates(3.5e-4, fabric=fabric))) == 1


@pytest.mark.parametrize("scene", [hemisphere, three_ply_hemisphere, stacked_hemisphere])
def test_the_presses_have_room(scene):
    assert closing_tools(scene.build(cells=4)) == []


def test_a_scene_with_one_tool_has_nothing_to_close():
    assert closing_tools(circular_table.build(cells=20)) == []


def test_it_is_said_before_the_first_step(capfd):
    plates(0.5 * THICKNESS).run(frames=1, quiet=False)
    said = capfd.readouterr().err
    assert said.startswith("warning: tools ")
    assert said.index("between them at 10 ms") < said.index(" steps of ")


@pytest.mark.parametrize("deep", [7e-3, 15e-3, 20e-3, 28e-3])
def test_tools_that_pass_each_other_fast_are_seen(deep):
    start = THICKNESS + 5e-3
    stroke = Stroke(travel=(0.0, 0.0, -start - deep), duration=0.02)
    (found,) = closing_tools(plates(0.0, motion=stroke))
    assert found.gap < 0.0 and "leave no room" in str(found)


def test_slivers_of_a_large_tool_cost_no_more(monkeypatch):
    spread = []
    old = closing._spread
    monkeypatch.setattr(closing, "_spread", lambda *a: spread.append(old(*a)) or spread[-1])
    bar = trimesh.creation.cylinder(0.02, 0.5, sections=360)
    bar.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (0.0, 1.0, 0.0)))
    scene = plates(2e-4)
    tool = Tool.from_mesh("bar", bar, motion=Stroke(travel=(0, 0, -0.05), duration=0.01))
    tools = [scene.tools[0], tool.moved((0.0, 0.0, 0.075))]
    assert len(closing_tools(replace(scene, tools=tools))) <= 1
    assert max(len(points) for points, _ in spread) < 30_000
