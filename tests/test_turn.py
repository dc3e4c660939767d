"""Tools that turn: the record, where the tool is, what contact and the tool's work make of it."""

import dataclasses
import json
import math

import numpy as np
import pytest
from interaction_checks import of_kind
from law_checks import fabric
from pxr import Usd, UsdGeom
from scipy.spatial.transform import Rotation
from tool_search_checks import found, searcher

from warpdrape import Clamp, Float, Numerics, Ply, Pressure, Scene, Stroke, Tool, Turn, read_run
from warpdrape.contact.closing import closing_tools
from warpdrape.contact.tool_contact import ToolContact
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.partition import split
from warpdrape.dynamics.stepping import Stepper, search_contacts
from warpdrape.errors import InputError
from warpdrape.materials.laws import LinearTension, ShearPolynomial
from warpdrape.results.summary_text import tool_rows
from warpdrape.timing import peak_speed
from warpdrape.tools.pose import rotation
from warpdrape.verification.strip import yarn_fabric

CLOTH = fabric(LinearTension(400.0, 420.0), ShearPolynomial((2e-4,)))
SHEET = yarn_fabric(1e5, 0.5)
HALF = 0.5 * SHEET.thickness
AXIS, POINT = np.array([1.0, 2.0, 0.5]), np.array([0.01, -0.02, 0.03])


def turn(angle=1.0, **given):
    options = {"axis": AXIS, "point": POINT, "duration": 0.01} | given
    if isinstance(angle, list):
        options["duration"] = None
    return Turn(angle=angle, **options)


def turned(points, angle, axis=AXIS, point=POINT):
    """Points turned about an axis, by another library."""
    rotated = Rotation.from_rotvec(angle * np.asarray(axis) / np.linalg.norm(axis))
    return rotated.apply(np.asarray(points) - point) + point


# --- the record


def test_angle_goes_as_a_stroke_or_through_pairs():
    one = turn(2.0, start=0.01)
    assert one.at(np.array([0.0, 0.015, 0.03])) == pytest.approx([0.0, 1.0, 2.0])
    assert one.peak_rate == pytest.approx(2.0 / (0.01 * 0.7)) and one.end == 0.02
    held = turn([(0.0, 0.0), (0.01, 1.5), (0.02, 1.5), (0.03, 0.0)])
    time = np.linspace(0.0, 0.03, 3001)
    angle = held.at(time)
    np.testing.assert_allclose(angle[[0, 1000, 1500, 2000, 3000]], [0, 1.5, 1.5, 1.5, 0])
    rate = np.gradient(angle, time)
    assert np.abs(rate[[0, 1000, 1500, 2000, 3000]]).max() < 2e-3 * np.abs(rate).max()
    assert np.abs(rate).max() == pytest.approx(held.peak_rate, rel=1e-3)


def test_pose_is_that_of_another_library_and_goes_along_with_the_stroke():
    stroke = Stroke(travel=(0.0, 0.01, -0.02), duration=0.01)
    tool = Tool.sphere(radius=0.05, motion=stroke, turn=turn(2.5))
    expected = turned(tool.vertices, 2.5) + stroke.travel
    np.testing.assert_allclose(tool.pose(1.0).place(tool.vertices), expected, atol=1e-15)
    np.testing.assert_allclose(tool.pose(1.0).into(expected), tool.vertices, atol=1e-15)


def test_the_axis_goes_with_a_tool_that_is_put_elsewhere():
    tool = Tool.sphere(radius=0.05, turn=turn(1.0))
    moved = tool.moved((0.1, 0.0, 0.2)).turned((0.0, 1.0, 0.0), 0.7)
    about = Rotation.from_rotvec((0.0, 0.7, 0.0))
    expected = about.apply(tool.pose(1.0).place(tool.vertices) + np.array((0.1, 0.0, 0.2)))
    np.testing.assert_allclose(moved.pose(1.0).place(moved.vertices), expected, atol=1e-14)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"axis": (0, 0, 0)}, "turn axis must not be the zero vector"),
        ({"axis": (0, 1)}, r"turn axis = \(0, 1\) must be three finite numbers"),
        ({"angle": math.nan}, "turn angle"),
        ({"duration": None}, "a turn by one angle needs duration"),
        ({"duration": -1.0}, "turn duration"),
        ({"ramp": 0.8}, "turn ramp = 0.8"),
        ({"angle": [(0.0, 0.0), (0.0, 1.0)]}, "turn angle: its times must rise"),
        ({"point": (0.0, 0.0, math.inf)}, "turn point"),
    ],
)
def test_turns_that_mean_nothing_are_refused(given, words):
    with pytest.raises(InputError, match=words) as refused:
        turn(**given)
    assert "\n" not in str(refused.value)


def test_pairs_and_a_duration_are_refused_and_so_is_what_is_no_turn():
    with pytest.raises(InputError, match="say the same twice: leave out duration"):
        Turn(axis=AXIS, angle=[(0.0, 0.0), (1.0, 1.0)], duration=1.0)
    with pytest.raises(InputError, match=r"tool 'sphere': turn = 3.0 is not a warpdrape.Turn"):
        Tool.sphere(radius=0.05, turn=3.0)


# --- what is planned from it


def test_searches_allow_for_the_speed_at_the_rim():
    scene = resting(turn=Turn(axis=(0, 0, 1), angle=4.0, duration=0.01))
    rate, rim = 4.0 / (0.01 * 0.7), math.hypot(0.05, 0.05)
    assert peak_speed(scene) == pytest.approx(rate * rim, rel=1e-6)


def test_a_flap_that_turns_down_onto_the_table_is_named():
    (closed,) = closing_tools(flap(angle=math.pi))
    assert set(closed.tools) == {"flap", "table"} and abs(closed.gap) < 1e-7
    assert closed.time == pytest.approx(0.03) and closed.place[0] < 0.0
    assert closing_tools(flap(angle=0.5 * math.pi)) == []


def test_a_tool_that_starts_turned_into_a_ply_is_refused():
    scene = resting(turn=Turn(axis=(0, 1, 0), angle=[(0.0, 0.4), (0.01, 0.5)]))
    with pytest.raises(InputError, match="tool 'plate' starts inside ply 'ply'"):
        scene.run(frames=1, quiet=True)


# --- contact


def test_contact_sees_a_turned_tool_as_it_sees_one_that_stands_so(device):
    ball = Tool.sphere(radius=0.03, facet=4e-3)
    turning = dataclasses.replace(ball, turn=turn([(0.0, 1.3), (1.0, 1.3)]))
    standing, count = ball.turned(AXIS, 1.3), 121
    shift = turned([[0.0, 0.0, 0.0]], 1.3)[0]
    rng = np.random.default_rng(3)
    corners = standing.vertices[standing.triangles[rng.integers(len(ball.triangles), size=count)]]
    at = np.einsum("ij,ijk->ik", rng.dirichlet(np.ones(3), count), corners)
    at += rng.uniform(-3e-4, 3e-4, (count, 3))
    kept = []
    for tool in (turning, standing.moved(shift)):
        model, state = searcher([tool], device)
        pose = tool.pose(0.0)
        state.tools.shift.assign(pose.shift[None])
        state.tools.turned.assign(pose.turned[None])
        state.plies.x.assign(at + shift)
        search_contacts(model, state)
        near, normal, level = found(model, state)
        level = level + pose.direct(normal) @ pose.shift
        kept.append((near, pose.direct(normal), level))
    (near, normal, level), (near_2, normal_2, level_2) = kept
    assert 0.1 < near.mean() < 0.9
    # Queries round to single precision, in another frame: points within 1e-8 m of the reach, and
    # of the border between two facets, may go either way.
    assert (near == near_2).mean() > 0.97
    both = near & near_2
    off = np.abs(normal - normal_2).max(axis=1) + np.abs(level - level_2)
    assert (off[both] < 1e-7).mean() > 0.9 and np.median(off[both]) < 1e-12


def test_a_stuck_points_spring_turns_with_the_tool(device):
    """The same contact a quarter turn on: all its force has turned with it."""
    forces = []
    for angle in (0.0, 0.5 * math.pi):
        scene = resting(turn=Turn(axis=(0, 0, 1), angle=[(0.0, angle), (1.0, angle)]))
        model, state = build_model(scene, device, 1), None
        state = initial_state(model)
        state.tools.turned.assign(scene.tools[0].pose(0.0).turned[None])
        x = turned(model.rest.numpy() - (0.0, 0.0, 1e-6), angle, (0, 0, 1), (0, 0, 0))
        state.plies.x.assign(x)
        search_contacts(model, state)
        _, memory = of_kind(model, state, ToolContact)
        holds = memory.holds.numpy()
        holds["spring"], holds["stored"] = (1e-7, 0.0, 0.0), 1e-9
        memory.holds.assign(holds)
        (whole,) = split(model, state, 1)
        for launch in whole.launches.push:
            launch(device)
        forces.append(state.plies.f.numpy())
    assert np.abs(forces[0][:, 0]).min() > 0.01 * np.abs(forces[0]).max() > 0.0
    expected = turned(forces[0], 0.5 * math.pi, (0, 0, 1), (0, 0, 0))
    np.testing.assert_allclose(forces[1], expected, atol=1e-9 * np.abs(forces[0]).max())


def resting(turn=None, **given):
    """A ply on a plate, under a pressure that holds it there however the plate turns."""
    ply = Ply.rectangle("ply", SHEET, 0.04, cells=4, mesh="grid", z=HALF)
    given = {
        "friction": 0.5,
        "duration": 0.03,
        "pressures": [Pressure(name="air", ply="ply", pressure=2e4, ramp=3e-3)],
        "tools": [Tool.plate(width=0.1, height=0.1, turn=turn)],
    } | given
    return Scene(name="resting", plies=[ply], gravity=(0.0, 0.0, 0.0), **given)


@pytest.mark.parametrize(
    ("axis", "angle", "point"),
    [((0, 0, 1), 2.0, (0.01, 0, 0)), ((0, 1, 0), 3.0, (0.03, 0, -0.01)), (AXIS, -1.0, POINT)],
)
def test_a_ply_that_sticks_goes_round_with_the_tool(axis, angle, point):
    turn = Turn(axis=axis, angle=angle, point=point, duration=0.02, start=0.005)
    result = resting(turn).run(frames=6, quiet=True)
    ply, history = result.plies[0], result.history
    expected = turned(ply.rest_points, angle, axis, point)
    # Contact gives way under the pressure, everywhere alike, and friction's springs by what it
    # takes to stop the ply; nothing slips. The ply went 20 to 100 mm.
    normal = turned([(0.0, 0.0, 1.0)], angle, axis, (0, 0, 0))[0]
    depth = (expected - ply.points) @ normal
    assert np.ptp(depth) < 1e-7 and 0.0 < depth.mean() < 0.1 * SHEET.thickness
    assert np.abs(expected - ply.points - depth[:, None] * normal).max() < 1e-6
    assert history["friction_j"][-1] < 1e-9
    assert abs(history["unbalanced_j"]).max() < 1e-4 * np.abs(history["external_work_j"]).max()
    assert history["plate_angle_deg"][-1] == pytest.approx(math.degrees(angle))
    # At rest the pressure's moment about the axis is what the tool holds against.
    force = -2e4 * 0.04**2 * normal
    unit = np.asarray(axis) / np.linalg.norm(axis)
    moment = np.cross(expected.mean(axis=0) - point, force) @ unit
    assert history["plate_torque_nm"][-1] == pytest.approx(-moment, abs=1e-3 * 2e4 * 0.04**3)
    np.testing.assert_allclose(
        result.tools[0].vertices, turned(resting().tools[0].vertices, angle, axis, point)
    )


def test_a_turn_by_nothing_changes_no_bit():
    still = Stroke(travel=(0.0, 0.001, 0.0), duration=0.01)
    plain, turning = (
        resting(duration=0.01, tools=[Tool.plate(width=0.1, height=0.1, motion=still, turn=turn)])
        for turn in (None, turn(0.0))
    )
    one, other = (scene.run(frames=3, quiet=True) for scene in (plain, turning))
    assert np.abs(one.plies[0].points - one.plies[0].rest_points).max() > 5e-4
    np.testing.assert_array_equal(one.plies[0].points, other.plies[0].points)
    for name, column in one.history.items():
        np.testing.assert_array_equal(column, other.history[name], err_msg=name)


def flap(angle=0.5 * math.pi, **given):
    """A ply held on a table; what hangs over it lies on a flap that folds it up."""
    length = 0.04
    ply = Ply.rectangle("ply", SHEET, 2 * length, 0.02, edge=5e-3, mesh="grid", z=HALF)
    wide = {"width": length + 0.01, "height": 0.04}
    up = Turn(axis=(0, -1, 0), angle=angle, duration=0.03)
    tools = [
        Tool.plate("table", **wide).moved((-0.5 * length - 0.005, 0, 0)),
        dataclasses.replace(
            Tool.plate("flap", **wide).moved((0.5 * length + 0.005, 0, 0)), turn=up
        ),
    ]
    options = {
        "duration": 0.045,
        "friction": 0.2,
        "clamps": [Clamp(name="held", ply="ply", where=lambda p: p[:, 0] < -0.6 * length)],
        "pressures": [Pressure(name="air", ply="ply", pressure=500.0)],
        "numerics": Numerics(damping=100.0),
    } | given
    return Scene(name="fold", plies=[ply], tools=tools, gravity=(0.0, 0.0, 0.0), **options)


@pytest.fixture(scope="module")
def folded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fold") / "run"
    return flap().run(folder, frames=8, quiet=True), folder


def test_a_flap_folds_a_ply_by_a_right_angle(folded):
    result, _ = folded
    ply, history = result.plies[0], result.history
    assert result.completed and result.summary["energy_error"] < 0.01
    leg = ply.points[ply.rest_points[:, 0] > 0.012]
    tilt = math.degrees(math.atan(np.polyfit(leg[:, 2], leg[:, 0], 1)[0]))
    assert abs(tilt) < 0.05
    np.testing.assert_allclose(leg[:, 0], -HALF, atol=5e-6)  # on the flap's face
    # At rest the flap bears the pressure on the leg, p w z²/2 about the hinge, and something of
    # what the fold itself bears, a triangle wide.
    tip = leg[:, 2].max()
    torque = 0.5 * 500.0 * 0.02 * tip**2
    assert torque < history["flap_torque_nm"][-1] < 1.15 * torque
    assert history["flap_angle_deg"][-1] == 90.0
    entry = result.summary["tools"][1]
    assert entry["angle_deg"] == 90.0 and "angle_deg" not in result.summary["tools"][0]
    assert entry["max_torque_nm"] == pytest.approx(np.abs(history["flap_torque_nm"]).max())
    assert "0.00 mm, 90.0°" in str(tool_rows(result.summary["tools"]))


def test_the_animation_turns_the_tool_between_frames_too(folded):
    result, folder = folded
    angle = result.history["flap_angle_deg"]
    stage = Usd.Stage.Open(str(folder / "scene.usdc"))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/tools/flap"))
    points = np.array(mesh.GetPointsAttr().Get())
    for code in (0.0, 3.0, 3.5, 8.0):
        matrix = np.array(mesh.ComputeLocalToWorldTransform(Usd.TimeCode(code)))
        mean = np.radians(np.interp(code, np.arange(len(angle)), angle))
        expected = turned(points, mean, (0, -1, 0), (0, 0, 0))
        np.testing.assert_allclose(points @ matrix[:3, :3] + matrix[3, :3], expected, atol=1e-7)
    read = read_run(folder, frame=4)
    expected = turned(flap().tools[1].vertices, math.radians(angle[4]), (0, -1, 0), (0, 0, 0))
    np.testing.assert_allclose(read.tools[1].vertices, expected, atol=1e-7)
    record = json.loads((folder / "run.json").read_text("utf-8"))
    assert record["tools"][1]["turn"]["angle"] == pytest.approx(0.5 * math.pi)


def test_a_roller_is_pressed_on_and_driven(device):
    """It floats under its force, and drags the ply with μ N: torque μ N times its radius."""
    sheet = Ply.rectangle("ply", SHEET, 0.06, 0.02, cells=12, mesh="grid", z=HALF)
    spun = Turn(axis=(0, 1, 0), angle=-3.0, duration=0.04, start=0.004, ramp=0.1)
    roller = Tool.drum(
        "roller",
        radius=0.02,
        length=0.03,
        facet=2e-3,
        turn=spun,
        motion=Float(force=20.0, damping=80.0),
    ).moved((0.0, 0.0, SHEET.thickness + 0.02))
    table = Tool.plate("table", width=0.1, height=0.05, friction=0.0)
    held = Clamp(name="held", ply="ply", where=lambda p: p[:, 0] < -0.0299, follow=(-1, 0, 0))
    scene = Scene(
        name="nip",
        plies=[sheet],
        tools=[table, dataclasses.replace(roller, friction=0.25)],
        clamps=[held],
        duration=0.03,
        gravity=(0.0, 0.0, 0.0),
        numerics=Numerics(damping=200.0),
    )
    result = scene.run(frames=15, device=device, quiet=True)
    history, going = result.history, slice(8, 16)
    assert result.completed and result.summary["energy_error"] < 0.01
    assert history["roller_force_n"][going].mean() == pytest.approx(20.0, rel=0.1)  # it swings
    assert np.abs(history["roller_displacement_m"]).max() < 2e-3
    drag = 0.25 * history["roller_force_n"][going].mean()
    pull, torque = history["held_force_n"][going], history["roller_torque_nm"][going]
    # −y turns the roller's underside to +x, away from the clamp. The torque's arm ends in the
    # ply's middle surface; the line of contact is dragged aside by up to 0.1 mm, where the normal
    # force has a part along x, 0.005 of it, beside 0.25 of it of friction.
    assert torque.mean() == pytest.approx(-drag * (0.02 + HALF), rel=0.01)
    assert pull.mean() == pytest.approx(drag, rel=0.03)


def test_an_extension_must_go_on_from_the_angle_that_the_run_has_come_to(tmp_path):
    def scene(angle, duration):
        return resting(turn=Turn(axis=(0, 0, 1), angle=angle), duration=duration)

    scene([(0.0, 0.0), (0.01, 0.3)], 0.01).run(tmp_path / "run", frames=2, quiet=True)
    jump = scene([(0.0, 0.1), (0.01, 0.4)], 0.02)
    with pytest.raises(InputError, match="turn of tool 'plate' would jump"):
        jump.run(resume=tmp_path / "run", extend=True, quiet=True)
    on = scene([(0.0, 0.0), (0.01, 0.3), (0.012, 0.3), (0.02, 0.5)], 0.02)
    assert on.run(resume=tmp_path / "run", extend=True, quiet=True).completed


def test_threads_and_eager_steps_give_the_same_bits():
    def after(threads, graph):
        scene = flap(numerics=Numerics(graph=graph), angle=2000.0)
        model = build_model(scene, "cpu", 1)
        state = initial_state(model)
        stepper = Stepper(model, state, threads)
        stepper.begin_frame(1)
        for _ in range(60):
            stepper.block()
        stepper.close()
        tools = state.tools
        arrays = (state.plies.x, state.plies.lost, tools.twist, tools.work, tools.turned)
        return [array.numpy() for array in arrays]

    captured, eager = after(1, True), after(1, False)
    assert np.abs(captured[2]).max() > 0.0
    assert np.abs(captured[4][1] - rotation((0, -1, 0), 0.0)).max() > 1e-3
    for one, other in zip(captured, eager, strict=True):
        np.testing.assert_array_equal(one, other)
    for one, other in zip(captured, after(2, True), strict=True):
        scale = np.abs(one).max()
        np.testing.assert_allclose(one, other, atol=1e-9 * scale)
