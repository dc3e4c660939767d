"""Tools finer than a ply's mesh are felt by its triangles, wherever they meet them."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from contact_oracle import nearest_on_triangles
from interaction_checks import of_kind

from warpdrape import Ply, Scene, Stroke, Tool
from warpdrape.contact.features import GRAIN, _first_of_each, feature_points, has_features
from warpdrape.contact.law import near_reach
from warpdrape.contact.tool_features import FeatureContact
from warpdrape.dynamics import stepping
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.partition import shares
from warpdrape.interaction import bodies_of
from warpdrape.numerics import Numerics
from warpdrape.scenes import hemisphere

HALF = 0.3e-3
MIDDLE, VERTEX, EDGE = (0.01, 0.02), (0.0, 0.0), (0.015, 0.0)


def cone(angle):
    """A cone of so many degrees between axis and side, its tip down."""
    mesh = trimesh.creation.cone(0.05 * np.tan(np.radians(angle)), 0.05)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(np.pi, (1.0, 0.0, 0.0)))
    return mesh


TOOLS = {
    "pin": trimesh.creation.cylinder(1e-3, 0.05),
    "ball": trimesh.creation.icosphere(3, 4e-3),
    "blade": trimesh.creation.box((2e-3, 0.12, 0.1)),
    "cone": cone(31.0),
    "box": trimesh.creation.box((0.08, 0.08, 0.06)),
}


def pressed(mesh, at=MIDDLE, cells=10, travel=0.02, duration=0.04, **options):
    """A tool that is pressed into a sheet on a ring; the sheet's squares are 30 mm wide."""
    sheet = Ply.rectangle("sheet", "carbon_interlock", 0.3, cells=cells, mesh="grid")
    motion = Stroke(travel=(0.0, 0.0, -travel), duration=duration)
    low = mesh.vertices[:, 2].min()
    tool = Tool.from_mesh("pin", mesh, motion=motion).moved((*at, HALF + 1e-4 - low))
    ring = Tool.die(hole_radius=0.09, edge_radius=0.01, outer_radius=0.25).moved((0, 0, -HALF))
    return Scene(name="p", plies=[sheet], tools=[tool, ring], duration=duration, **options)


def contact_of(model, state):
    return of_kind(model, state, FeatureContact)


@pytest.mark.parametrize("kind", TOOLS)
@pytest.mark.parametrize("at", [MIDDLE, VERTEX, EDGE])
def test_every_tool_is_felt_wherever_it_meets_the_mesh(kind, at):
    result = pressed(TOOLS[kind], at).run(frames=8, quiet=True)
    assert result.completed, result.summary["message"]
    assert result.plies[0].points[:, 2].min() < -0.019  # pushed down all the way
    assert result.summary["tools"][0]["max_force_n"] > 0.3
    assert result.summary["max_penetration_m"] < 0.02 * 2 * HALF
    assert result.summary["energy_error"] < 2e-3


def test_force_of_a_pin_on_a_triangle_comes_near_that_on_finer_meshes():
    coarse, fine = (
        pressed(TOOLS["pin"], cells=cells).run(frames=20, quiet=True).history["pin_force_n"][10:]
        for cells in (10, 20)
    )
    assert coarse.mean() == pytest.approx(fine.mean(), rel=0.3)


@pytest.mark.parametrize(
    "tool",
    [
        Tool.punch(radius=0.075),
        Tool.die(hole_radius=0.08, edge_radius=0.01, outer_radius=0.2),
        Tool.blank_holder(hole_radius=0.08, outer_radius=0.2),
        Tool.table(radius=0.1),
        Tool.plate(width=0.2, height=0.2),
        Tool.from_mesh("ball", trimesh.creation.icosphere(4, 0.05)),
    ],
)
def test_tools_that_vertices_feel_have_no_features(tool):
    assert len(feature_points(tool, 0.015, 0.01)) == 0


def test_of_points_that_are_one_the_first_is_kept():
    rows = np.random.default_rng(3).integers(-2, 3, (300, 3)).astype(float)
    seen = {}
    for k, row in enumerate(map(tuple, rows)):
        seen.setdefault(row, k)
    assert 50 < len(seen) < 200
    assert _first_of_each(rows).tolist() == sorted(seen.values())
    assert len(_first_of_each(rows[:0])) == 0
    fine = 0.03
    points = feature_points(Tool.from_mesh("box", TOOLS["box"]), 0.04, fine)
    grains = {tuple(grain) for grain in np.round(points / (GRAIN * fine)).astype(int)}
    assert len(grains) == len(points) > 20


def test_features_are_where_a_tool_turns_round():
    box = feature_points(Tool.from_mesh("t", TOOLS["box"]), 0.03, 0.03)
    sides = np.abs(box) > np.array([0.04, 0.04, 0.03]) - 1e-9
    assert (sides.sum(axis=1) >= 2).all()  # on its edges
    assert len(box) > 8
    tip = feature_points(Tool.from_mesh("t", cone(31.0)), 0.03, 0.03)
    assert np.abs(tip - (0.0, 0.0, -0.05)).max(axis=1).min() < 1e-12
    blunt = feature_points(Tool.from_mesh("t", cone(60.0)), 0.03, 0.03)
    assert np.abs(blunt - (0.0, 0.0, -0.05)).max(axis=1).min() > 0.01
    drum = Tool.drum(radius=0.01, length=0.1)
    assert len(feature_points(drum, 0.03, 0.03)) > 0
    assert len(feature_points(drum, 0.004, 0.004)) == 0
    assert not has_features(hemisphere.build(cells=28))


def test_a_hole_is_no_feature_but_the_edge_round_it():
    ring = trimesh.creation.annulus(5e-3, 0.05, 0.03)
    points = feature_points(Tool.from_mesh("t", ring), 0.03, 0.03)
    np.testing.assert_allclose(np.abs(points[:, 2]), 0.015)  # nothing half-way down its wall


@pytest.mark.parametrize("kind", ["ball", "box"])
def test_gaps_are_those_of_brute_force(kind, device):
    scene = pressed(TOOLS[kind], at=(0.013, 0.007), numerics=Numerics(contact="exact"))
    model = build_model(scene, device, 1)
    state = initial_state(model)
    rng = np.random.default_rng(5)
    x = state.plies.x.numpy()
    x += rng.uniform(-1.5e-3, 1.5e-3, x.shape)
    state.plies.x.assign(x)
    stepping.search_contacts(model, state)
    contact, memory = contact_of(model, state)
    points = contact.features.points.numpy()
    corners = contact.surfaces.facets.corners.numpy()
    nearest, _, inside = nearest_on_triangles(points, x[corners], k=len(corners))
    distance = np.linalg.norm(points - nearest, axis=1)
    near = memory.contacts.numpy()["near"] == 1
    above = points[:, 2] > nearest[:, 2]
    known = np.abs(distance - HALF - near_reach(scene)) > 1e-6
    np.testing.assert_array_equal(near[known], (distance - HALF < near_reach(scene))[known])
    assert near.any()
    assert not near.all()
    gap = np.where(near, memory.seen.numpy()["gap"], 0.0)
    np.testing.assert_allclose(gap[near], distance[near] - HALF, rtol=0, atol=1e-9)
    side = memory.seen.numpy()["side"]
    certain = near & inside
    np.testing.assert_array_equal(side[certain], np.where(above, 1.0, -1.0)[certain])


def pushed(device, depth):
    """Contact and its memory where a pin alone presses a flat sheet so deep, and the state."""
    scene = pressed(TOOLS["pin"], numerics=Numerics(contact="exact"))
    model = build_model(scene, device, 1)
    state = initial_state(model)
    contact, memory = contact_of(model, state)
    shift = np.zeros((2, 3))
    shift[0, 2] = -0.9e-4
    state.tools.shift.assign(shift)
    stepping.search_contacts(model, state)  # before it touches
    shift[0, 2] = -1e-4 - depth
    state.tools.shift.assign(shift)
    (share,) = shares(model, 1)
    for launch in contact.launches(share, bodies_of(state), memory).scatter:
        launch(device)
    return contact, memory, state


def test_force_and_moment_on_the_sheet_are_those_on_the_tool(device):
    contact, memory, state = pushed(device, 1e-5)
    f, x = state.plies.f.numpy(), state.plies.x.numpy()
    reaction = state.tools.reaction.numpy().reshape(-1, 2, 3).sum(axis=0)
    assert reaction[0, 2] > 0.0
    np.testing.assert_allclose(f.sum(axis=0), -reaction[0], atol=1e-12 * reaction[0, 2])
    points = contact.features.points.numpy()
    low = np.flatnonzero(memory.stored.numpy() > 0.0)
    assert len(low) > 4
    each = np.zeros((len(low), 3))
    each[:, 2] = -contact.law.stiffness * memory.contacts.numpy()["mass"][low] * 1e-5
    about = np.cross(points[low], each).sum(axis=0)
    np.testing.assert_allclose(np.cross(x, f).sum(axis=0), about, atol=1e-6 * reaction[0, 2])


def test_however_many_points_press_they_are_no_stiffer_than_their_triangles(device):
    """u·K u Δt² ≤ s_c Σ m u² for the triangle's own third of its vertices' masses."""
    contact, memory, _ = pushed(device, 1e-5)
    kept = memory.contacts.numpy()
    low = np.flatnonzero(memory.stored.numpy() > 0.0)
    law, third = contact.law, contact.features.third.numpy()
    facet = memory.seen.numpy()["seen"][low] - 1
    stiffness = law.stiffness * kept["mass"][low]
    rng = np.random.default_rng(2)
    for u in rng.normal(size=(20, len(contact.surfaces.normals))):
        corners = np.stack([kept[name][low] for name in "abc"], axis=1)
        along = (kept["weights"][low] * u[corners]).sum(axis=1)
        taken = (stiffness * along**2).sum()
        triangles = contact.surfaces.facets.corners.numpy()[np.unique(facet)]
        most = (third[np.unique(facet)][:, None] * u[triangles] ** 2).sum()
        assert taken <= law.stiffness * most * (1.0 + 1e-9)


def test_work_of_sliding_is_lost_to_friction():
    scene = pressed(TOOLS["ball"], friction=0.4, travel=0.015)
    across = Stroke(travel=(0.02, 0.0, -0.015), duration=0.04)
    moving = replace(scene.tools[0], motion=across)
    scene = replace(scene, tools=(moving, scene.tools[1]))
    result = scene.run(frames=10, quiet=True)
    free = replace(scene, friction=0.0).run(frames=10, quiet=True)
    assert result.completed
    assert result.history["friction_j"][-1] > 10.0 * free.history["friction_j"][-1]
    assert result.summary["energy_error"] < 2e-3


def test_parts_of_threads_add_up_to_the_whole():
    scene = pressed(TOOLS["blade"], duration=0.01, travel=5e-3)
    shapes = []
    for count in (1, 3):
        model = build_model(scene, "cpu", 1)
        state = initial_state(model)
        parts = stepping.split(model, state, count)
        stepper = stepping.Stepper(model, state, 1)
        stepper.begin_frame(1)
        job = stepping._Job(parts, parts, None)
        for block in range(40):
            job.run(block % 16 == 0)
        _, memory = contact_of(model, state)
        shapes.append((state.plies.x.numpy(), memory.lost.numpy().sum()))
    assert shapes[0][1] > 0.0
    np.testing.assert_allclose(shapes[0][0], shapes[1][0], atol=1e-10)


def test_a_blade_longer_than_the_hole_is_said_to_squeeze_the_ply():
    blade = trimesh.creation.box((2e-3, 0.22, 0.1))  # over a hole of 0.2 m with its rounding
    result = pressed(blade, at=EDGE).run(frames=20, quiet=True)
    message = result.summary["message"]
    assert "tools 'pin' and 'die' squeeze ply 'sheet'" in message, message
