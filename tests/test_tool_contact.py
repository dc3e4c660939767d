"""Contact with tools: the search against exact surfaces and brute force, and the forces."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from contact_oracle import nearest_on_triangles
from interaction_checks import of_kind
from law_checks import fabric

from warpdrape.blanks.ply import Ply
from warpdrape.contact.tool_contact import ToolContact
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.stepping import Stepper, search_contacts
from warpdrape.materials.laws import LinearTension
from warpdrape.numerics import Numerics
from warpdrape.scene import Scene
from warpdrape.scenes import hemisphere
from warpdrape.setup import Clamp
from warpdrape.tools import profile
from warpdrape.tools.motion import Stroke
from warpdrape.tools.tool import Tool

CLOTH = fabric(LinearTension(400.0, 420.0))
HALF = 0.5 * CLOTH.thickness
RADIUS = 0.075
CENTER = np.array([0.0, 0.0, -RADIUS])
IN = Stroke(travel=(2.5e-3, 0.0, 0.0), duration=4e-3)
"""Of a ply that is led under a plate."""


def searcher(tools, device="cpu", cells=10, **numerics):
    """Model and state of a ply whose vertices serve as the points that search."""
    ply = Ply.rectangle("points", CLOTH, 0.1, cells=cells, mesh="diagonal", z=10.0)
    numerics = Numerics(**numerics)
    scene = Scene(name="search", plies=[ply], tools=tools, duration=1e-3, numerics=numerics)
    model = build_model(scene, device, 1)
    return model, initial_state(model)


def search_of(model):
    """How far contact with tools looks."""
    (contact,) = (contact for contact in model.contacts if isinstance(contact, ToolContact))
    return contact.search


def memory_of(model, state):
    return of_kind(model, state, ToolContact)[1]


def found(model, state):
    """What the last search kept of the one tool: whether near, and the plane's normal and level."""
    planes = memory_of(model, state).planes.numpy()
    near = (planes["normal"] != 0.0).any(axis=1)
    np.testing.assert_array_equal(near, memory_of(model, state).touching.numpy() == 1)
    return near, planes["normal"], planes["level"]


def near_sphere(count, rng, low, high, polar=0.8 * np.pi):
    """Points round a sphere whose pole is the origin, and their distance from it [m]."""
    angle, turn = np.arccos(rng.uniform(np.cos(0.7 * polar), 1, count)), rng.uniform(0, 7, count)
    out = np.stack([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)], 1)
    distance = rng.uniform(low, high, count)
    return (RADIUS + distance)[:, None] * out + CENTER, distance, out


def test_gap_to_a_sphere_converges_with_the_facets(device):
    rng = np.random.default_rng(1)
    gaps = []
    for facet in (7e-3, 3.5e-3, 1.75e-3):
        model, state = searcher([Tool.sphere(radius=RADIUS, facet=facet)], device, cells=30)
        x, distance, out = near_sphere(len(model.masses.mass), rng, -5e-5, 4e-4)
        state.plies.x.assign(x)
        search_contacts(model, state)
        near, normal, level = found(model, state)
        assert near.all()
        gap = (normal * x).sum(axis=1) - level + HALF
        gaps.append(np.abs(gap - distance).max())
        # A point off the surface is projected square to the facet, so its normal is that of a place
        # aside by distance · facet/2R: first order, but small. Which of two facets as near is found
        # differs between processors.
        tilt = np.linalg.norm(normal - out, axis=1)
        assert tilt.max() < 1.5 * 4e-4 * facet / (2.0 * RADIUS**2)
        flat = 0.125 * facet**2 / RADIUS  # how far a facet lies inside the sphere
        assert gaps[-1] < 0.05 * flat
    rates = np.log2(np.array(gaps[:-1]) / gaps[1:])
    assert (rates > 2.7).all(), rates
    assert gaps[-1] < 1e-7  # m, at facets of 1.75 mm on a radius of 75 mm


def distances(points, corners):
    """Distance of points from the nearest of all facets, by brute force, shape [n]."""
    best = np.full(len(points), np.inf)
    for a, b, c in corners:
        nearest = trimesh.triangles.closest_point(
            np.broadcast_to([a, b, c], (len(points), 3, 3)), points
        )
        best = np.minimum(best, np.linalg.norm(points - nearest, axis=1))
    return best


def imported(shape):
    mesh = {
        "ball": trimesh.creation.icosphere(subdivisions=2, radius=0.02),
        "box": trimesh.creation.box((0.03, 0.02, 0.04)),
    }[shape]
    mesh.apply_transform(trimesh.transformations.rotation_matrix(0.7, (1.0, 2.0, 0.5)))
    return Tool.from_mesh(shape, mesh)


@pytest.mark.parametrize("shape", ["ball", "box"])
def test_nearest_facet_is_that_of_brute_force(shape, device):
    tool = imported(shape)
    model, state = searcher([tool], device, cells=20)
    rng = np.random.default_rng(2)
    count = len(model.masses.mass)
    surface, facet = trimesh.sample.sample_surface(tool.surface.mesh, count, seed=3)
    outward = tool.surface.mesh.face_normals[facet]
    # Not deeper inside than a search expects to find a vertex that it did not hold before.
    x = surface + rng.uniform(-1.5e-4, 6e-4, count)[:, None] * outward
    # Half of them anyhow round edges and corners, so that all parts of facets come nearest.
    sharp = tool.vertices[rng.integers(len(tool.vertices), size=count)]
    ends = np.sort(tool.surface.mesh.edges, axis=1)[rng.integers(len(tool.triangles), size=count)]
    share = rng.uniform(0, 1, (count, 1))
    on_edge = share * tool.vertices[ends[:, 0]] + (1 - share) * tool.vertices[ends[:, 1]]
    round_it = rng.uniform(-8e-5, 8e-5, (count, 3))
    x[::4], x[1::4] = (sharp + round_it)[::4], (on_edge + round_it)[1::4]
    shift = np.array([0.1, -0.2, 0.3])
    state.tools.shift.assign(shift[None])
    state.plies.x.assign(x + shift)
    search_contacts(model, state)
    near, normal, _ = found(model, state)
    exact = distances(x, tool.surface.mesh.triangles)
    reach = HALF + search_of(model).reach
    # The query sees positions in single precision: 3e-9 m at 0.05 m from the origin.
    assert near[exact < reach - 1e-8].all()
    assert not near[exact > reach + 1e-8].any()
    assert 0.2 < near.mean() < 0.98
    apart = memory_of(model, state).queries.numpy()["distance"]
    np.testing.assert_allclose(apart[near], exact[near], atol=1e-8)
    np.testing.assert_allclose(np.linalg.norm(normal[near], axis=1), 1.0, atol=1e-12)


def test_points_not_asked_anew_are_never_missed(device):
    # They wander in from beyond the search radius, half a slide between two searches.
    model, state = searcher([Tool.sphere(radius=RADIUS)], device, cells=20)
    slide, edge = model.scene.numerics.search_slide, search_of(model).radius
    rng = np.random.default_rng(4)
    x, _, out = near_sphere(len(model.masses.mass), rng, edge - 1e-3, edge + 1e-3)
    drift = -rng.uniform(0.5, 1.0, len(x))[:, None] * out
    asked = 0
    for _ in range(120):
        x = x + 0.5 * slide * (drift + rng.uniform(-0.1, 0.1, x.shape))
        before = memory_of(model, state).queries.numpy()["at"].copy()
        state.plies.x.assign(x)
        search_contacts(model, state)
        asked += (memory_of(model, state).queries.numpy()["at"] != before).any(axis=1).sum()
        distance = np.linalg.norm(x - CENTER, axis=1) - RADIUS
        touching = np.abs(distance) < HALF + slide
        assert found(model, state)[0][touching].all()
    assert touching.mean() > 0.1
    assert asked < 0.7 * 120 * len(x)


def test_points_faster_than_any_tool_are_met_before_they_enter(device):
    # A sheet that snaps: from beyond the near zone, up to some twenty slides between two searches,
    # straight in or with a speed that grows by a third.
    model, state = searcher([Tool.sphere(radius=RADIUS)], device, cells=20)
    interval = model.timing.search_every * model.timing.time_step
    slide = model.scene.numerics.search_slide
    rng = np.random.default_rng(6)
    x, distance, out = near_sphere(len(model.masses.mass), rng, HALF + 1e-3, HALF + 3e-3)
    speed = rng.uniform(1.0, 20.0, len(x)) * slide / interval
    growth = 1.33
    met = np.zeros(len(x), bool)
    for _ in range(60):
        state.plies.x.assign(x)
        state.plies.v.assign(-speed[:, None] * out)
        search_contacts(model, state)
        near = found(model, state)[0]
        speed = np.where(met, speed, np.minimum(growth * speed, 20.0 * slide / interval))
        distance = distance - np.where(met, 0.0, speed * interval)
        enters = ~met & (distance < HALF)
        assert near[enters].all()
        met |= enters
        x = CENTER + (RADIUS + distance)[:, None] * out
    assert met.all()


def test_a_fast_search_leaves_planes_as_a_plain_one_finds_them(device):
    # Vertices slide, lift off and come back; every search of the two must tell nearly the same.
    tool = Tool.sphere(radius=RADIUS)
    (fast, kept), (plain, fresh) = (
        searcher([tool], device, cells=20, contact=contact) for contact in ("fast", "exact")
    )
    slide = fast.scene.numerics.search_slide
    rng = np.random.default_rng(5)
    x, _, out = near_sphere(len(fast.masses.mass), rng, HALF - 1e-5, HALF + 4e-4)
    way = rng.uniform(-0.7, 0.7, x.shape)
    way -= (way * out).sum(axis=1)[:, None] * out
    asked, touched = 0, 0
    for step in range(100):
        x = x + 0.3 * slide * (way - 0.5 * np.sin(0.1 * step) * out)
        before = memory_of(fast, kept).queries.numpy()["at"].copy()
        for model, state in ((fast, kept), (plain, fresh)):
            state.plies.x.assign(x)
            search_contacts(model, state)
        asked += (memory_of(fast, kept).queries.numpy()["at"] != before).any(axis=1).sum()
        (near, normal, level), (true_near, true_normal, true_level) = (
            found(fast, kept),
            found(plain, fresh),
        )
        gap, true_gap = (
            (n * x).sum(axis=1) - h for n, h in ((normal, level), (true_normal, true_level))
        )
        touching = true_near & (true_gap < slide)
        assert near[touching].all()
        # A plane serves half a slide and what is moved in one go, a slide in all: the sphere falls
        # off from it by slide²/2R, 1.1e-8 m.
        fall = 0.5 * slide**2 / RADIUS
        np.testing.assert_allclose(gap[touching], true_gap[touching], atol=fall)
        touched += (true_gap[touching] < 0.0).sum()
    assert touched > 0.05 * 100 * len(x) and asked < 0.6 * 100 * len(x)


RING = {"outer_radius": 0.12, "facet": 5e-3}
TOOLS = {
    "die": Tool.die(hole_radius=0.078, edge_radius=0.01, depth=0.03, **RING),
    "holder": Tool.blank_holder(hole_radius=0.088, **RING),
    "punch": Tool.punch(radius=RADIUS, facet=5e-3),
}


@pytest.mark.parametrize("name", TOOLS)
def test_a_facet_that_serves_on_is_the_nearest_still(name, device):
    """Vertices slide over bowls, domes and saddles: no facet is nearer than the one kept."""
    tool = TOOLS[name]
    model, state = searcher([tool], device, cells=12)
    slide, rng = model.scene.numerics.search_slide, np.random.default_rng(6)
    corners = tool.vertices[tool.triangles]
    weights = rng.dirichlet([1.0] * 3, len(model.masses.mass))
    start = corners[rng.integers(0, len(corners), len(weights))]
    out = np.cross(start[:, 1] - start[:, 0], start[:, 2] - start[:, 0])
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    x = (weights[:, :, None] * start).sum(axis=1)
    x += (HALF + rng.uniform(-1e-5, 1.5e-4, len(x)))[:, None] * out
    way = rng.uniform(-1.0, 1.0, x.shape)
    served = 0
    for _ in range(12):
        x = x + 0.7 * slide * way
        before = memory_of(model, state).queries.numpy().copy()
        state.plies.x.assign(x)
        search_contacts(model, state)
        after = memory_of(model, state).queries.numpy()
        looked, asked = ((before[f] != after[f]).any(axis=1) for f in ("at", "asked"))
        on = np.flatnonzero(looked & ~asked)
        nearest, *_ = nearest_on_triangles(x[on], corners, k=300)
        apart = np.linalg.norm(x[on] - nearest, axis=1)
        np.testing.assert_allclose(after["distance"][on], apart, atol=1e-9)
        served += len(on)
    assert served > 2 * len(x)


@pytest.mark.parametrize("facet", [3e-3, 7.8e-3])
def test_facets_that_lie_deep_inside_the_surface_hide_no_contact(facet, device):
    # Straight down on the facets' middles, from where a query just finds nothing.
    model, state = searcher([Tool.sphere(radius=RADIUS, facet=facet)], device, cells=20)
    slide = model.scene.numerics.search_slide
    middles = model.scene.tools[0].surface.mesh.triangles_center - CENTER
    height = np.linalg.norm(middles, axis=1)
    lowest = np.argsort(height)[: len(model.masses.mass)]
    out = middles[lowest] / height[lowest][:, None]
    start = height[lowest] - RADIUS + search_of(model).radius + 1e-6
    for step in range(60):
        distance = start - step * slide
        state.plies.x.assign((RADIUS + distance)[:, None] * out + CENTER)
        search_contacts(model, state)
        touching = np.abs(distance) < HALF + slide
        assert found(model, state)[0][touching].all()
    assert touching.all()


@pytest.mark.parametrize("share", [0.02, 0.1])
def test_a_pressed_vertex_feels_penalty_off_half_the_thickness(share, device):
    tool = Tool.plate(width=1.0, height=1.0)
    ply = Ply.rectangle("ply", CLOTH, 0.01, cells=2, z=1.0)
    numerics = Numerics(contact_share=share, contact_damping=0.0, search_slide=1e-9)
    scene = Scene(
        name="press",
        plies=[ply],
        tools=[tool],
        duration=1e-4,
        numerics=numerics,
        gravity=(0.0, 0.0, 0.0),
    )
    model = build_model(scene, device, 1)
    assert model.timing.search_every == 1
    for depth in (1e-6, 2e-6, -1e-9):
        state = initial_state(model)
        x = ply.rest_points * (1.0, 1.0, 0.0) + (0.0, 0.0, HALF - depth)  # flat: no membrane force
        stepper = Stepper(model, state)
        state.plies.x.assign(x)
        stepper.begin_frame(1)
        stepper.block()
        force = model.masses.mass * state.plies.v.numpy()[:, 2] / model.timing.time_step
        expected = share * model.masses.mass / model.timing.time_step**2 * max(depth, 0.0)
        np.testing.assert_allclose(force, expected, rtol=1e-8, atol=1e-20)
        np.testing.assert_allclose(state.plies.v.numpy()[:, :2], 0.0, atol=1e-6 * abs(depth) / 1e-6)
        pushed = state.tools.impulse.numpy()[0]
        np.testing.assert_allclose(pushed, (0.0, 0.0, -expected.sum()), rtol=1e-8, atol=1e-15)


def test_friction_of_a_slipping_vertex_opposes_slip_and_obeys_coulomb(device):
    tool = Tool.plate(width=1.0, height=1.0, friction=0.25)
    ply = Ply.rectangle("ply", CLOTH, 0.01, cells=2, z=1.0)
    numerics = Numerics(contact_damping=0.0, search_slide=1e-9)
    scene = Scene(
        name="rub",
        plies=[ply],
        tools=[tool],
        duration=1e-4,
        numerics=numerics,
        gravity=(0.0, 0.0, 0.0),
    )
    model = build_model(scene, device, 1)
    state = initial_state(model)
    state.plies.x.assign(ply.rest_points * (1.0, 1.0, 0.0) + (0.0, 0.0, HALF - 1e-7))
    velocity = np.array([3.0, -4.0, 0.0])
    state.plies.v.assign(np.broadcast_to(velocity, (len(ply.rest_points), 3)))
    stepper = Stepper(model, state)
    stepper.begin_frame(1)
    stepper.block()
    force = model.masses.mass[:, None] * (state.plies.v.numpy() - velocity) / model.timing.time_step
    normal = (
        model.scene.numerics.contact_share * model.masses.mass / model.timing.time_step**2 * 1e-7
    )
    expected = normal[:, None] * (-0.25 * 0.6, 0.25 * 0.8, 1.0)
    np.testing.assert_allclose(force, expected, rtol=1e-6)
    lost = state.plies.lost.numpy()
    slid = 5.0 * model.timing.time_step
    work = 0.25 * normal * slid
    # The spring was slack before: half of its force acted over the step's mean.
    assert (lost[:, 0] > 0.45 * work).all() and (lost[:, 0] < 1.01 * work).all()


def test_a_plate_has_a_back_and_a_rounded_border(device):
    """Vertices come from behind a plate, and go round its border from below to its face."""
    size, apart = 0.2, HALF + 2e-5
    model, state = searcher([Tool.plate(width=size, height=size, facet=0.02)], device, cells=4)
    count = len(model.masses.mass)
    along = np.linspace(-0.07, 0.07, count)
    flat = np.stack([along, 0.3 * along, np.zeros(count)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    for height in (-1e-3, -apart, -0.9 * HALF):  # comes near, touches, presses
        x = flat + height * up
        state.plies.x.assign(x)
        search_contacts(model, state)
    near, normal, level = found(model, state)
    assert near.all()
    np.testing.assert_allclose(normal, np.tile((0.0, 0.0, -1.0), (count, 1)), atol=1e-12)
    np.testing.assert_allclose((normal * x).sum(axis=1) - level, -0.1 * HALF)

    state = initial_state(model)
    for angle in np.radians(np.arange(-85.0, 86.0, 1.0)):  # about the border, from below to above
        out = np.array([np.cos(angle), 0.0, np.sin(angle)])
        border = np.stack([np.full(count, 0.5 * size), along, np.zeros(count)], axis=1)
        x = border + apart * out
        state.plies.x.assign(x)
        search_contacts(model, state)
        near, normal, level = found(model, state)
        assert near.all()
        gap = (normal * x).sum(axis=1) - level
        # Within 8° of its face the border counts as the face: 1 % of the distance less.
        np.testing.assert_allclose(gap, apart - HALF, atol=0.011 * apart)


@pytest.mark.parametrize("beside", [0.05, 0.2])
def test_a_ply_that_comes_from_aside_meets_a_border_without_a_jump(beside):
    """Led under a plate that it overlaps, a ply is pushed back by as much as leads it.

    A plate that went on flat beyond its border would push at once as deep as the ply overlaps.
    """
    ply = Ply.rectangle("ply", CLOTH, 0.01, cells=2)
    led = Clamp(name="all", ply="ply", where=lambda p: p[:, 0] < 1.0, motion=IN)
    plate = Tool.plate("plate", width=0.04, height=0.04, facing="down")
    scene = Scene(
        name="aside",
        plies=[ply],
        clamps=[led],
        tools=[plate.moved((0.0262, 0.0, HALF * (1.0 - beside)))],
        duration=4e-3,
        friction=0.0,
        gravity=(0.0, 0.0, 0.0),
        self_contact=False,
        numerics=Numerics(search_slide=2e-5),
    )
    history = scene.run(frames=40).history
    pressed = history["contact_j"].max()
    assert pressed > 5e-6
    assert history["unbalanced_j"].max() < 1e-3 * pressed  # nothing from nowhere
    # Planes that serve for a way of the size of the edge lose some: half as much in half the way.
    assert history["unbalanced_j"].min() > -0.3 * pressed


def test_a_sharp_ridge_is_round_to_the_ply(device):
    """Round the edge of a box the gap is the distance from the box, whichever facet is asked."""
    box = Tool.from_mesh("box", trimesh.creation.box(extents=(0.2, 0.2, 0.05)))
    model, state = searcher([box], device, cells=4)
    count = len(model.masses.mass)
    along = np.linspace(-0.09, 0.09, count)
    apart = HALF + np.linspace(-5e-5, 1e-5, count)
    for angle in np.radians(np.arange(0.0, 91.0, 5.0)):
        out = np.array([np.cos(angle), 0.0, np.sin(angle)])
        edge = np.stack([np.full(count, 0.1), along, np.full(count, 0.025)], axis=1)
        x = edge + apart[:, None] * out
        state.plies.x.assign(x)
        search_contacts(model, state)
        near, normal, level = found(model, state)
        assert near.all()
        np.testing.assert_allclose((normal * x).sum(axis=1) - level, apart - HALF, atol=1e-9)
        np.testing.assert_allclose(normal, np.tile(out, (count, 1)), atol=1e-5)


def gap_and_push(model, state, x):
    """Gaps of points to the one tool, and the ways in which it would push them."""
    state.plies.x.assign(x)
    search_contacts(model, state)
    near, normal, level = found(model, state)
    assert near.all()
    return (normal * x).sum(axis=1) - level, normal.copy()


def faceted(side):
    """A ball of coarse facets to be met from outside, or inside; or a cup, from behind, outside."""
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=0.02)
    if side == "behind":
        mesh = mesh.slice_plane((0.0, 0.0, -5e-3), (0.0, 0.0, 1.0))
    ball = Tool.from_mesh("ball", mesh)
    return ball if side == "outside" else ball.flipped()


@pytest.mark.parametrize("side", ["outside", "inside", "behind"])
def test_a_faceted_tool_pushes_along_the_slope_of_its_distance(side, device):
    """Else sliding over its facets makes energy: pushed along means of normals, 10 % of a press."""
    ball, out = faceted(side), 1.0 if side == "outside" else -1.0
    model, state = searcher([ball], device, cells=20, contact="exact")
    count, mesh, h = len(model.masses.mass), ball.surface.mesh, 5e-7
    rng = np.random.default_rng(4)
    high = ball.vertices[ball.vertices[:, 2] > 0.0]  # off the sheet's rim
    surface, facet = trimesh.sample.sample_surface(mesh, 4 * count, seed=5)
    surface, facet = (each[surface[:, 2] > 0.0][:count] for each in (surface, facet))
    outward = mesh.face_normals[facet]
    corner = rng.integers(len(high), size=count)[::3]  # each third by one
    surface[::3], outward[::3] = high[corner], out * high[corner] / 0.02
    if side == "behind":
        outward = -outward
        gap_and_push(
            model, state, np.asarray(surface + 1.4 * HALF * outward)
        )  # it comes from there
    x = np.asarray(surface + rng.uniform(0.5, 1.1, (count, 1)) * HALF * outward)
    x[::3] += rng.uniform(-5e-6, 5e-6, (count, 3))[::3]
    gap, push = gap_and_push(model, state, x)
    np.testing.assert_allclose(gap, distances(x, mesh.triangles) - HALF, atol=2e-9)
    slope, smooth = np.zeros_like(x), np.ones(count, dtype=bool)
    for k, step in enumerate(h * np.eye(3)):
        (more, one), (less, other) = (gap_and_push(model, state, x + s) for s in (step, -step))
        slope[:, k] = (more - less) / (2.0 * h)
        for beside in (one, other):  # in a hollow edge it has none
            smooth &= np.linalg.norm(push - beside, axis=1) < 0.01
    assert smooth.mean() > 0.9
    # a query in single precision may take the facet beside a hollow edge: 2e-9 m in the slope
    np.testing.assert_allclose(push[smooth], slope[smooth], atol=2e-9 / h + 2e-3)


def test_what_slides_past_a_border_books_what_its_spring_held(device):
    model, state = searcher([Tool.plate(width=0.2, height=0.2, facet=0.02)], device, cells=4)
    count = len(model.masses.mass)
    x = np.zeros((count, 3))
    x[:, 1], x[:, 2] = np.linspace(-0.07, 0.07, count), 0.9 * HALF
    x[:, 0] = 0.0999
    gap, _ = gap_and_push(model, state, x)
    assert (gap < 0.0).all()
    memory = memory_of(model, state)
    held = memory.holds.numpy().copy()
    held["stored"], held["spring"] = np.arange(1.0, count + 1.0), 1e-6
    memory.holds.assign(held)
    state.plies.x.assign(x + np.array([2e-3, 0.0, 0.0]))
    search_contacts(model, state)
    np.testing.assert_array_equal(state.plies.lost.numpy()[:, 0], held["stored"])
    left = memory_of(model, state).holds.numpy()
    assert not left["stored"].any() and not left["spring"].any()


def test_a_press_with_coarse_facets_makes_no_energy(monkeypatch):
    """Facets that turn by 17° from one to the next, without the true surface's normals."""
    monkeypatch.setattr(profile, "FACET_ANGLE", np.radians(17.0))
    scene = hemisphere.build(cells=12, duration=0.02, facet=22e-3)
    tools = [
        replace(tool, surface=Tool.from_mesh(tool.name, tool.surface.mesh).surface)
        for tool in scene.tools
    ]
    result = replace(scene, tools=tools).run(frames=4)
    assert result.completed and result.summary["energy_error"] < 5e-3


def test_a_sharp_box_below_a_ply_touches_nothing():
    """1 mm below it, with an edge between two rows of vertices: free fall until then."""
    ply = Ply.rectangle("ply", CLOTH, 0.1, cells=5, z=1e-3 + HALF)
    solid = trimesh.creation.box(extents=(0.12, 0.12, 0.05))
    box = Tool.from_mesh("box", solid).moved((-0.055, 0.0, -0.025))
    result = Scene(name="box", plies=[ply], tools=[box], duration=0.01).run(frames=2)
    assert result.completed and np.abs(result.history["box_force_n"]).max() == 0.0
    assert result.plies[0].points[:, 2] == pytest.approx(ply.z - 0.5 * 9.81 * 1e-4, abs=1e-6)
