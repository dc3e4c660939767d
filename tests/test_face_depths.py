"""How deep plies lie in tools between their vertices, against chords of circles and brute force."""

import numpy as np
import pytest
import trimesh

from warpdrape import Ply, Scene, Stroke, Tool
from warpdrape.contact.face_depths import FaceDepths
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.scenes import hemisphere
from warpdrape.tools.pose import rotation

RADIUS, HALF, EDGE = 0.08, 0.3e-3, 0.02
CENTRE = np.array([0.0, 0.0, RADIUS])
BLOCK = trimesh.creation.box((0.04, 0.04, 0.02))


def looked_at(tool, place, device, edge=EDGE):
    """Deepest at vertices and between, of a grid whose vertices a function places [m]."""
    ply = Ply.rectangle("ply", "carbon_interlock", 0.12, edge=edge, mesh="grid", z=1.0)
    scene = Scene(name="laid", plies=[ply], tools=[tool], duration=1e-3)
    model = build_model(scene, device, frames=1)
    state = initial_state(model)
    state.plies.x.assign(place(ply.rest_points))
    return FaceDepths(scene, model.spans, device).deepest(state)[0]


def over_a_ball(points):
    """Points of a sheet laid over a ball whose pole is at 0, half a thickness off."""
    aim = np.c_[points[:, :2], np.full(len(points), RADIUS)]
    return (RADIUS + HALF) * aim / np.linalg.norm(aim, axis=1)[:, None] - CENTRE


def cut_by_chords(points, triangles):
    """Depth of middles of sides and of centres in the ball, whose true surface is known [m]."""
    corners = points[triangles]
    middles = 0.5 * (corners + np.roll(corners, 1, axis=1)).reshape(-1, 3)
    places = np.vstack([middles, corners.mean(axis=1)])
    return (RADIUS + HALF - np.linalg.norm(places + CENTRE, axis=1)).max()


@pytest.mark.parametrize("edge", [0.02, 0.01])
def test_chords_over_a_ball_cut_in_by_their_sag(device, edge):
    ball = Tool.sphere(radius=RADIUS, facet=4e-3)
    at_vertices, between = looked_at(ball, over_a_ball, device, edge)
    ply = Ply.rectangle("ply", "carbon_interlock", 0.12, edge=edge, mesh="grid")
    expected = cut_by_chords(over_a_ball(ply.rest_points), ply.mesh.triangles)
    assert at_vertices < 1e-6  # the tool's surface is curved over its facets, to second order
    assert between == pytest.approx(expected, abs=2e-6)
    # Sides of the flat grid of four triangles a square, a little longer on the ball's pole.
    assert between == pytest.approx(edge**2 / (8.0 * RADIUS), rel=0.1)


def test_what_lies_flat_on_either_side_of_a_sheet_is_not_in_it(device):
    plate = Tool.plate(width=0.2, height=0.2, facet=0.02)
    for side in (1.0, -1.0):

        def flat(points, side=side):
            return np.c_[points[:, :2], np.full(len(points), side * HALF)]

        assert looked_at(plate, flat, device).max() < 1e-9


def test_a_vertex_that_is_pushed_in_is_seen(device):
    def pushed(points):
        placed = over_a_ball(points)
        top = np.argmax(placed[:, 2])
        placed[top, 2] -= 0.1e-3
        return placed

    at_vertices, _ = looked_at(Tool.sphere(radius=RADIUS, facet=4e-3), pushed, device)
    assert at_vertices == pytest.approx(0.1e-3, abs=1e-6)


def test_a_moved_tool_is_looked_at_where_it_is_at_every_frame():
    """A ball on a held sheet: the depth at the end counts, and no later retreat takes it away."""
    up = Stroke(travel=(0.0, 0.0, 5e-3), duration=2e-3)
    sheet = Ply.rectangle("sheet", "carbon_interlock", 0.12, edge=EDGE, mesh="grid")
    ball = Tool.sphere(radius=RADIUS, facet=8e-3, motion=up).moved((0, 0, -HALF - 1e-4))
    ring = Tool.die(hole_radius=0.05, edge_radius=0.01, outer_radius=0.1).moved((0, 0, -HALF))
    scene = Scene(name="ball", plies=[sheet], tools=[ball, ring], duration=2e-3)
    result = scene.run(frames=3)
    deepest = result.summary["tools"][0]
    assert 0.02e-3 < deepest["max_face_penetration_m"] < EDGE**2 / (8.0 * RADIUS) + 1e-4
    assert deepest["max_penetration_m"] < 0.05e-3


def wandering(rng, points, frames):
    """Positions of a sheet that goes and bends at random over whatever is there, frame by frame."""
    phase, heading = rng.uniform(0, 6, 3), rng.uniform(-1, 1, 3) * [0.01, 0.01, 0.004]
    for t in np.linspace(0.0, 1.0, frames):
        bend = 4e-3 * np.sin(40.0 * points[:, 0] + phase[0] + 3.0 * t)
        bend += 2e-3 * np.sin(70.0 * points[:, 1] + phase[1] - 5.0 * t)
        yield points + t * heading + np.c_[np.zeros((len(points), 2)), bend - 2e-3 * t]


@pytest.mark.parametrize(("seed", "frames"), [(0, 25), (1, 25), (2, 25), (3, 25), (4, 6), (5, 4)])
def test_what_is_not_asked_again_could_not_have_been_the_deepest(device, seed, frames):
    """Places that are left out change nothing: tools that turn, sheets that go through them."""
    rng = np.random.default_rng(seed)
    tools = [
        Tool.sphere(radius=RADIUS, facet=8e-3).moved((0.0, 0.0, -HALF)),
        Tool.die(hole_radius=0.03, edge_radius=0.01, outer_radius=0.08, facet=6e-3),
        Tool.from_mesh("block", BLOCK).moved((0.02, 0.01, -0.01)),
    ]
    ply = Ply.rectangle("ply", "carbon_interlock", 0.12, edge=0.01, mesh="grid", z=1.0)
    scene = Scene(name="laid", plies=[ply], tools=tools, duration=1e-3)
    model = build_model(scene, device, frames=1)
    state = initial_state(model)
    watched, known, most = FaceDepths(scene, model.spans, device), (), np.zeros((3, 2))
    asked = []
    for frame, points in enumerate(wandering(rng, ply.rest_points * [1, 1, 0], frames)):
        state.plies.x.assign(points)
        turned = [rotation((0, 0, 1), a * 0.02 * frame) for a in (0.0, 1.0, -1.0)]
        state.tools.turned.assign(np.array(turned))
        before = watched.seen.numpy().copy()
        known = watched.deepest(state, known)
        fresh = FaceDepths(scene, model.spans, device)
        most = np.maximum(most, fresh.deepest(state))
        np.testing.assert_array_equal(known, most)
        near = (fresh.seen.numpy()["turns"] > 0).sum()
        asked.append((watched.seen.numpy() != before).sum() / near)
    assert most[:, 1].min() > 1e-3  # each tool is cut into
    if frames == 25:
        assert np.mean(asked[5:]) < 0.5, f"{asked}"  # most places are known by then


@pytest.mark.slow
def test_finer_plies_cut_less_off_the_punch():
    found = []
    for cells in (10, 20):
        result = hemisphere.build(cells=cells, travel=0.04, duration=0.03).run(frames=4)
        found.append(result.summary["tools"][0]["max_face_penetration_m"])
    assert found[1] < 0.4 * found[0]  # by h²: a quarter
