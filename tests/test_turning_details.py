"""Turned tools elsewhere than at vertices: their points, gaps, squeezes, passages, threads."""

import dataclasses
import math

import numpy as np
import pytest
import trimesh
from test_passages import pressed as pressed_through
from test_threads import assert_same_bits, state_after
from test_tool_features import TOOLS, contact_of, pressed
from test_turn import AXIS, POINT, SHEET, flap, resting, turn, turned

from warpdrape import Ply, Scene, Stroke, Tool, Turn
from warpdrape.contact.passages import Passages
from warpdrape.defects.gaps import ToolGaps
from warpdrape.dynamics import stepping
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.partition import shares
from warpdrape.errors import InputError
from warpdrape.interaction import bodies_of


def test_a_pin_that_goes_round_drags_the_sheet_and_the_balance_holds():
    """Pressed in, then led round a circle on the sheet: friction all the way, no energy lost."""
    scene = pressed(TOOLS["pin"], travel=0.004, duration=0.01)
    pin, ring = scene.tools
    x, y = 0.01, 0.02
    round_it = Turn(axis=(0, 0, 1), angle=2.0, duration=0.02, start=0.01, point=(x - 0.02, y, 0))
    scene = dataclasses.replace(
        scene,
        tools=[dataclasses.replace(pin, turn=round_it), ring],
        duration=0.03,
        friction=0.3,
        gravity=(0.0, 0.0, 0.0),
    )
    result = scene.run(frames=36, quiet=True)
    history = result.history
    assert result.completed and result.summary["energy_error"] < 3e-3
    centre = result.tools[0].vertices.mean(axis=0)
    expected = (x - 0.02 + 0.02 * math.cos(2.0), y + 0.02 * math.sin(2.0))
    np.testing.assert_allclose(centre[:2], expected, atol=1e-9)
    # The work of the drive is the torque times the angle, summed over the frames.
    angle, torque = np.radians(history["pin_angle_deg"]), history["pin_torque_nm"]
    driven = (torque[1:] * np.diff(angle)).sum()
    before = history["external_work_j"][12]  # pressed in, not yet turned
    assert driven == pytest.approx(history["external_work_j"][-1] - before, rel=0.02)
    assert driven > 1e-4


def test_the_springs_of_a_tools_points_turn_with_it(device):
    scene = pressed(TOOLS["pin"])
    pin = dataclasses.replace(scene.tools[0], turn=Turn(axis=(0, 0, 1), angle=1.0, duration=1.0))
    model = build_model(dataclasses.replace(scene, tools=[pin, scene.tools[1]]), device, 1)
    state = initial_state(model)
    contact, memory = contact_of(model, state)
    shift, rate = np.zeros((2, 3)), 10.0
    shift[0, 2] = -0.9e-4
    state.tools.shift.assign(shift)
    stepping.search_contacts(model, state)
    shift[0, 2] = -1.1e-4
    state.tools.shift.assign(shift)
    state.tools.spin.assign(np.array([[0, 0, rate], [0, 0, 0]], float))
    x = state.plies.x.numpy()
    around = rate * np.cross((0.0, 0.0, 1.0), x)  # at the end of a chord of a step
    back = 0.5 * model.timing.time_step * rate * np.cross((0.0, 0.0, 1.0), around)
    state.plies.v.assign(around - back)
    springs = np.zeros((memory.springs.size, 3))
    springs[:, 0] = 1e-9
    memory.springs.assign(springs)
    (share,) = shares(model, 1)
    for launch in contact.launches(share, bodies_of(state), memory).scatter:
        launch(device)
    pressing = memory.stored.numpy() > 0.0
    assert pressing.any()
    found = memory.springs.numpy()[pressing]
    np.testing.assert_allclose(found[:, 0], 1e-9, rtol=5e-3)
    np.testing.assert_allclose(found[:, 1], 1e-9 * rate * model.timing.time_step, rtol=0.05)


def test_ways_from_a_turned_tool_are_those_from_one_that_stands_so():
    ball = Tool.sphere(radius=0.03, facet=3e-3)
    turning = dataclasses.replace(ball, turn=turn([(0.0, 1.3), (1.0, 1.3)]))
    pose = turning.pose(0.0)
    rng = np.random.default_rng(5)
    out = rng.normal(size=(200, 3))
    out /= np.linalg.norm(out, axis=1)[:, None]
    out = out[out @ pose.turned[:, 2] > 0.0]  # the sphere lacks its lower quarter
    height = rng.uniform(0.5e-3, 2e-3, (len(out), 1))
    centre = turned([(0.0, 0.0, -0.03)], 1.3)[0]
    ways = ToolGaps([turning]).ways(centre + (0.03 + height) * out, [pose])[0]
    # A facet is up to 1.5 mm from its middle to a corner: 0.05 rad, of 2 mm.
    np.testing.assert_allclose(ways, height * out, atol=1e-4)
    assert len(out) > 50
    under = turned([(0.01, 0.0, 0.02)], 1.3)
    normal = pose.direct(np.array([[0.0, 0.0, 1.0]]))
    assert ToolGaps([turning]).beneath(under, normal, [pose]).all()
    assert not ToolGaps([turning]).beneath(under, pose.direct(np.eye(3)[:1]), [pose]).any()


def test_plates_that_turn_together_squeeze_as_those_that_do_not():
    half = 0.5 * SHEET.thickness
    ply = Ply.rectangle("ply", SHEET, 0.04, cells=4, mesh="grid")
    over = Turn(axis=(0, 1, 0), angle=2.0, duration=0.01)
    away = np.array([math.sin(2.0), 0.0, math.cos(2.0)])  # where the upper plate comes to
    down = Stroke(travel=-1.2e-4 * away, duration=0.01, start=0.01)
    wide = {"width": 0.06, "height": 0.06}
    low = Tool.plate("low", **wide).moved((0, 0, -half))
    high = Tool.plate("high", facing="down", motion=down, **wide).moved((0, 0, half + 2e-5))
    plates = [dataclasses.replace(plate, turn=over) for plate in (low, high)]
    scene = Scene(
        name="turned over", plies=[ply], tools=plates, duration=0.025, gravity=(0.0, 0.0, 0.0)
    )
    result = scene.run(frames=5, quiet=True)
    assert result.completed
    (said,) = [text for text in result.summary["warnings"] if "squeeze" in text]
    assert "tools 'low' and 'high' squeeze ply 'ply'" in said
    assert "0.1 mm below its thickness" in said
    expected = turned(ply.rest_points, 2.0, (0, 1, 0), (0, 0, 0))
    # Between the plates the ply is carried round; they have come 0.1 mm nearer, off the axis.
    assert np.abs(result.plies[0].points - expected).max() < 2e-4
    assert result.summary["energy_error"] < 1e-3


def test_a_lid_that_shuts_too_far_squeezes():
    """What presses against what is told by normals as they are, not as the lid stood open."""
    half = 0.5 * SHEET.thickness
    ply = Ply.rectangle("ply", SHEET, 0.04, cells=4, mesh="grid")
    hinge = np.array([-0.03, 0.0, half - 1e-4])
    lid = Tool.plate("lid", width=0.06, height=0.06, facing="down").moved((0.03, 0.0, 0.0))
    lid = lid.turned((0.0, 1.0, 0.0), -1.2).moved(hinge)
    shut = Turn(axis=(0, 1, 0), angle=1.2, point=hinge, duration=0.02)
    table = Tool.plate("table", width=0.06, height=0.06).moved((0, 0, -half))
    tools = [table, dataclasses.replace(lid, turn=shut)]
    scene = Scene(name="lid", plies=[ply], tools=tools, duration=0.02, gravity=(0.0, 0.0, 0.0))
    result = scene.run(frames=4, quiet=True)
    (said,) = [text for text in result.summary["warnings"] if "squeeze" in text]
    assert "tools 'table' and 'lid' squeeze ply 'ply'" in said
    assert "0.1 mm below its thickness" in said


def test_a_ball_that_turns_through_a_sheet_is_found(device):
    ball = trimesh.creation.icosphere(3, 0.03)
    scene = pressed_through(ball, 0.06, edge=0.012, at=(0.06, 0.0))
    about = (0.2, 0.0, float(scene.tools[0].vertices[:, 2].mean()))
    down = Turn(axis=(0, 1, 0), angle=[(0.0, 0.0), (1.0, -0.1)], point=about)
    tools = [dataclasses.replace(scene.tools[0], turn=down, motion=Tool.sphere(radius=1.0).motion)]
    tools += scene.tools[1:]
    model = build_model(dataclasses.replace(scene, tools=tools), device, 4)
    state = initial_state(model)
    sought = Passages(model.scene, model.spans, device)
    assert sought.deepest(state) is None
    low = tools[0].vertices[:, 2].min()
    for angle, seen in ((0.036, False), (0.065, True)):
        pose = dataclasses.replace(
            tools[0], turn=dataclasses.replace(down, angle=[(0.0, -angle), (1.0, 0.0)])
        ).pose(0.0)
        state.tools.shift.assign(np.array([pose.shift, np.zeros(3)]))
        state.tools.turned.assign(np.array([pose.turned, np.eye(3)]))
        found = sought.deepest(state)
        assert (found is not None) == seen
    depth = 0.14 * math.sin(0.065) - low
    assert found.depth == pytest.approx(depth, abs=4e-4)


def test_parts_on_threads_add_up_the_moments_of_turning_tools():
    scene = resting(Turn(axis=(0, 0, 1), angle=2.0, duration=0.02), duration=0.01)
    together, _ = state_after(2, True, scene, blocks=60)
    alone, _ = state_after(2, False, scene, blocks=60)
    assert_same_bits(together, alone)
    whole, _ = state_after(1, False, scene, blocks=60)
    twist = whole["tools.twist"]
    assert np.abs(twist).max() > 0.0
    for name in ("tools.twist", "tools.work", "plies.x"):
        scale = np.abs(whole[name]).max()
        np.testing.assert_allclose(together[name], whole[name], atol=1e-8 * scale, err_msg=name)


def test_a_run_goes_on_only_with_the_turn_that_it_had(tmp_path):
    def scene(angle):
        return resting(Turn(axis=(0, 0, 1), angle=angle, duration=0.02), duration=0.01)

    scene(0.5).run(tmp_path / "run", frames=2, quiet=True)
    with pytest.raises(InputError, match="motion of tool 'plate', turning is another"):
        scene(0.6).run(resume=tmp_path / "run", quiet=True)


def test_a_record_of_a_turn_reads_well():
    assert repr(turn(math.pi)) == (
        "Turn: axis (0.4364, 0.8729, 0.2182), angle 180°, point (10, -20, 30) mm, duration 10 ms"
    )
    assert "Turn: axis" in repr(flap().tools[1])
    assert np.linalg.norm(turn().axis) == pytest.approx(1.0) and AXIS @ POINT != 0.0
