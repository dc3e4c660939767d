"""The search for tools near vertices: against exact surfaces, brute force and a plain search."""

import numpy as np
import pytest
import trimesh
from contact_oracle import nearest_on_triangles
from tool_search_checks import HALF, distances, found, memory_of, search_of, searcher

from warpdrape.dynamics.stepping import search_contacts
from warpdrape.tools.tool import Tool

RADIUS = 0.075
CENTER = np.array([0.0, 0.0, -RADIUS])


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
