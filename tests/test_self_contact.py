"""A ply's folds touch: found as by brute force, held apart, without energy from nowhere."""

import math
from dataclasses import replace

import numpy as np
import pytest
from contact_oracle import Facing
from interaction_checks import of_kind

from warpdrape import Float, InputError, Ply, Scene, Tool
from warpdrape.blanks.meshing import mesh_outline
from warpdrape.blanks.outlines import Polygon
from warpdrape.contact.law import step_share
from warpdrape.contact.self_contact import SelfContact
from warpdrape.dynamics import energy, stepping
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.interaction import bodies_of
from warpdrape.materials.fabric_library import with_bending
from warpdrape.numerics import Numerics

EDGE, WIDTH = 1.5e-3, 9e-3
THICKNESS = 6e-4


def strip(length, *, mesh="diagonal", edge=EDGE, stiffness=1e-5):
    cloth = with_bending("carbon_interlock", stiffness)
    return Ply.rectangle("strip", cloth, length, WIDTH, edge=edge, mesh=mesh)


def still_scene(ply, duration=1e-3, **options):
    given = {"gravity": (0.0, 0.0, 0.0), "numerics": Numerics(yarn_softening=36.0), **options}
    return Scene(name="strip", plies=[ply], duration=duration, **given)


def zigzag(points, apart, leg):
    """The strip in three legs one over the other, half circles between; bottom and top layer touch
    the one between them from below and above."""
    radius = 0.5 * apart
    arc = math.pi * radius
    s = points[:, 0] - points[:, 0].min()
    where = np.zeros((len(s), 2))
    ends = np.cumsum([leg, arc, leg, arc, 1.0])
    piece = np.searchsorted(ends, s, side="right")
    t = s - np.r_[0.0, ends][piece]
    for k, turn in ((1, 1.0), (3, -1.0)):
        at, angle = piece == k, t[piece == k] / radius
        x0 = leg if k == 1 else 0.0
        where[at] = np.stack(
            [x0 + turn * radius * np.sin(angle), (k // 2) * apart + radius * (1 - np.cos(angle))], 1
        )
    for k in (0, 2, 4):
        at = piece == k
        x = leg - t[at] if k == 2 else t[at]
        where[at] = np.stack([x, np.full(at.sum(), (k // 2) * apart)], 1)
    return np.stack([where[:, 0], points[:, 1], where[:, 1]], 1)


def hairpin(points, leg, edge=EDGE):
    """The strip folded over one row of squares that stands upright; sides keep their lengths."""
    s = np.round((points[:, 0] - points[:, 0].min()) / edge) * edge
    x = np.where(s <= leg, s, np.maximum(2.0 * leg + edge - s, -1.0))
    x = np.where((s > leg) & (s < leg + edge), leg, x)
    return np.stack([x, points[:, 1], np.clip(s - leg, 0.0, edge)], 1)


def spiral(points, gap, inner):
    """The strip rolled up: r = inner + gap θ/2π, so that upper sides lie on lower ones."""
    s = points[:, 0] - points[:, 0].min()
    theta = np.linspace(0.0, 40.0, 4001)
    r = inner + gap * theta / (2 * math.pi)
    way = np.r_[0.0, np.cumsum(0.5 * (r[1:] + r[:-1]) * np.diff(theta))]
    angle = np.interp(s, way, theta)
    radius = np.interp(angle, theta, r)
    return np.stack([radius * np.cos(angle), points[:, 1], radius * np.sin(angle)], 1)


def placed(ply, shape, device, **options):
    """A model and its state with the ply in a shape."""
    model = build_model(still_scene(ply, **options), device, frames=1)
    state = initial_state(model)
    state.plies.x.assign(shape)
    return model, state


def found(model, state):
    """Gap [m] of every vertex on its upper and lower side, infinite where nothing is near."""
    _, memory = of_kind(model, state, SelfContact)
    x, kept = state.plies.x.numpy(), memory.contacts.numpy()
    corners = np.stack([x[kept[name]] for name in "abc"], axis=1)
    nearest = (kept["weights"][:, :, None] * corners).sum(axis=1)
    height = ((np.tile(x, (2, 1)) - nearest) * kept["normal"]).sum(axis=1)
    return np.where(kept["near"] == 1, height - kept["thickness"] - kept["rise"], np.inf).reshape(
        2, -1
    )


def by_brute_force(model, x, thickness=THICKNESS):
    """The same by plain numpy: the nearest of the triangles whose place lies in another fold."""
    contact = next(c for c in model.contacts if isinstance(c, SelfContact))
    triangles, rest = model.scene.plies[0].mesh.triangles, model.rest.numpy()
    apart = contact.flat.apart.numpy()
    gaps = np.full((2, len(x)), np.inf)
    a, b, c = (x[triangles[:, k]] for k in range(3))
    facing = Facing(triangles, x)
    for i, point in enumerate(x):
        weights = nearest_weights(point, a, b, c)
        place = np.einsum("mk,mkj->mj", weights, x[triangles])
        flat = np.einsum("mk,mkj->mj", weights, rest[triangles])
        distance = np.linalg.norm(point - place, axis=1)
        distance[np.linalg.norm(flat - rest[i], axis=1) < apart[i]] = np.inf
        near = distance < 3.0 * thickness
        over = np.zeros(len(triangles), dtype=bool)
        for t in np.flatnonzero(near):
            over[t] = (point - place[t]) @ facing.at(t, weights[t]) >= 0.0
        for row, side in enumerate((over, ~over)):
            gaps[row, i] = np.where(near & side, distance, np.inf).min() - thickness
    return gaps


def nearest_weights(p, a, b, c):
    """Weights of the corners at the place of each triangle that is nearest to a point."""
    best, kept = np.full(len(a), np.inf), np.zeros((len(a), 3))
    normal = np.cross(b - a, c - a)
    square = (normal**2).sum(1)
    inner = np.stack(
        [(np.cross(q - p, r - p) * normal).sum(1) / square for q, r in ((b, c), (c, a), (a, b))], 1
    )
    inside = (inner > 0.0).all(axis=1)
    for (u, v), (iu, iv) in {(0, 1): (0, 1), (1, 2): (1, 2), (2, 0): (2, 0)}.items():
        corners = (a, b, c)
        start, end = corners[u], corners[v]
        t = np.clip(((p - start) * (end - start)).sum(1) / ((end - start) ** 2).sum(1), 0.0, 1.0)
        distance = np.linalg.norm(p - start - t[:, None] * (end - start), axis=1)
        nearer = distance < best
        best[nearer] = distance[nearer]
        kept[nearer] = 0.0
        kept[nearer, iu], kept[nearer, iv] = 1.0 - t[nearer], t[nearer]
    kept[inside] = inner[inside]
    return kept


@pytest.mark.parametrize("mesh", ["diagonal", "random"])
@pytest.mark.parametrize("shape", ["zigzag", "spiral"])
def test_folds_are_found_as_by_brute_force(device, mesh, shape):
    ply = strip(60e-3, mesh=mesh)
    folded = {
        "zigzag": lambda p: zigzag(p, 1.1 * THICKNESS, 18e-3),
        "spiral": lambda p: spiral(p, 1.1 * THICKNESS, 3e-3),
    }[shape](ply.rest_points)
    folded += np.random.default_rng(3).normal(scale=3e-5, size=folded.shape)
    model, state = placed(ply, folded, device)
    stepping.search_contacts(model, state, asking=True)
    seen, right = found(model, state), by_brute_force(model, folded)
    near = np.minimum(right, seen) < 1e-4
    off_border = np.abs(ply.rest_points[:, 1]) < 0.4 * WIDTH  # left alone beyond a border
    off_border &= np.abs(ply.rest_points[:, 0]) < 0.45 * 60e-3
    assert (near & off_border).sum(axis=1).min() > 30, "both sides are in contact"
    np.testing.assert_allclose(seen[near & off_border], right[near & off_border], atol=1e-9)


def test_a_layer_between_two_others_touches_both(device):
    ply = strip(60e-3)
    model, state = placed(ply, zigzag(ply.rest_points, 0.98 * THICKNESS, 18e-3), device)
    stepping.search_contacts(model, state, asking=True)
    gaps = found(model, state)
    s = ply.rest_points[:, 0] + 30e-3
    middle = (s > 24e-3) & (s < 34e-3)
    np.testing.assert_allclose(gaps[:, middle], -0.02 * THICKNESS, atol=1e-8)


def test_walks_go_on_from_what_was_found(device):
    ply = strip(60e-3, mesh="random")
    model, state = placed(ply, zigzag(ply.rest_points, 1.1 * THICKNESS, 18e-3), device)
    stepping.search_contacts(model, state, asking=True)
    x = state.plies.x.numpy()
    x[ply.rest_points[:, 0] > 6e-3] += (0.6e-3, 0.3e-3, -3e-5)  # the topmost layer slides
    state.plies.x.assign(x)
    stepping.search_contacts(model, state, asking=False)
    walked = found(model, state)
    stepping.search_contacts(model, state, asking=True)
    np.testing.assert_allclose(walked, found(model, state), atol=1e-9)


def test_a_flat_ply_however_sheared_and_fine_touches_nothing(device):
    for edge in (EDGE, 3e-4):
        ply = Ply.rectangle(
            "strip",
            with_bending("carbon_interlock", 1e-5),
            10e-3,
            10e-3,
            edge=edge,
            mesh="diagonal",
        )
        half = 0.5 * math.radians(90.0 - 70.0)
        yarns = np.array(
            [[math.cos(half), math.sin(half), 0.0], [math.sin(half), math.cos(half), 0]]
        )
        model, state = placed(ply, ply.rest_points[:, :2] @ yarns, device)
        stepping.search_contacts(model, state, asking=True)
        assert np.isinf(found(model, state)).all()


def marched(model, state, blocks, before=lambda: None):
    with_stepper = stepping.Stepper(model, state)
    with_stepper.begin_frame(1)
    for _ in range(blocks):
        before()
        with_stepper.block()


@pytest.mark.parametrize("up", [1.0, -1.0])
def test_a_vertex_that_was_pushed_through_comes_back_on_its_side(device, up):
    ply = strip(38e-3)
    folded = zigzag(ply.rest_points, 1.05 * THICKNESS, 18e-3) * (1.0, 1.0, up)
    model, state = placed(ply, folded, device)
    stepping.search_contacts(model, state, asking=True)
    top = ply.rest_points[:, 0] > 5e-3
    x = state.plies.x.numpy()
    x[top, 2] -= up * 1.3 * THICKNESS  # through the layer below
    state.plies.x.assign(x)
    for _ in range(3):
        stepping.search_contacts(model, state, asking=True)
    inner = top & (np.abs(ply.rest_points[:, 1]) < 0.3 * WIDTH) & (ply.rest_points[:, 0] < 17e-3)
    gaps = np.sort(found(model, state)[:, inner], axis=0)
    np.testing.assert_allclose(gaps[0], -1.25 * THICKNESS, atol=1e-6)
    assert np.isinf(gaps[1]).all(), "only on the side on which it was"


def middle_contact(ply, model, state):
    """A vertex of the middle of three layers that touches another one, and its slot."""
    _, memory = of_kind(model, state, SelfContact)
    near = memory.contacts.numpy()["near"].reshape(2, -1)
    s = ply.rest_points[:, 0] + 30e-3
    row, vertex = next(zip(*np.nonzero(near & (s > 24e-3) & (s < 34e-3)), strict=True))
    return memory, int(vertex), int(row * len(s) + vertex)


def test_a_place_that_both_walks_have_come_to_is_held_from_one_side(device):
    ply = strip(60e-3)
    model, state = placed(ply, zigzag(ply.rest_points, 0.98 * THICKNESS, 18e-3), device)
    stepping.search_contacts(model, state, asking=True)
    memory, vertex, slot = middle_contact(ply, model, state)
    count = len(ply.rest_points)
    other = vertex if slot >= count else vertex + count
    gap = found(model, state).ravel()[slot]
    for kept in (memory.contacts, memory.seen):
        values = kept.numpy()
        values[other] = values[slot]
        kept.assign(values)
    for asking in (False, True):
        stepping.search_contacts(model, state, asking=asking)
        near = memory.contacts.numpy()["near"]
        assert near[slot] == 1 and (asking or near[other] == 0)
        assert found(model, state).ravel()[slot] == pytest.approx(gap, abs=1e-9)


def test_a_walk_that_comes_to_where_a_vertex_lies_behind_lets_it_go(device):
    ply = strip(60e-3)
    model, state = placed(ply, zigzag(ply.rest_points, 0.98 * THICKNESS, 18e-3), device)
    stepping.search_contacts(model, state, asking=True)
    memory, vertex, slot = middle_contact(ply, model, state)
    kept = memory.contacts.numpy()
    x = state.plies.x.numpy()
    x[vertex] -= 1.3 * THICKNESS * kept["normal"][slot]  # a third of it behind the mid-surface
    state.plies.x.assign(x)
    stepping.search_contacts(model, state, asking=False)
    assert memory.contacts.numpy()["near"][slot] == 1, "its own plane says that it went through"
    allowed = memory.contacts.numpy()
    allowed["allowance"][slot] = 1.3 * THICKNESS
    memory.contacts.assign(allowed)
    stepping.search_contacts(model, state, asking=False)
    assert memory.contacts.numpy()["near"][slot] == 1, "so it does where that is allowed"
    kept["normal"][slot] *= -1.0
    memory.contacts.assign(kept)
    stepping.search_contacts(model, state, asking=False)
    assert memory.contacts.numpy()["near"][slot] == 0, "another plane had it in front"


def test_layers_that_meet_part_again_without_energy_from_nowhere(device):
    ply = strip(43.5e-3)
    model, state = placed(ply, hairpin(ply.rest_points, 21e-3), device, duration=8e-4)
    v = np.zeros_like(state.plies.x.numpy())
    upper = ply.rest_points[:, 0] > 0.5 * EDGE
    v[upper] = (0.2, 0.1, -2.0)
    state.plies.v.assign(v)
    start = energy.balance(model, state, energy.measure(model, state))
    momentum = model.mass.numpy() @ v
    marched(model, state, model.timing.steps // model.timing.search_every)
    end = energy.balance(model, state, energy.measure(model, state))
    assert end.friction > 0.0 and end.contact_damping > 0.0
    grown = end.unbalanced - start.unbalanced
    assert abs(grown) < 0.01 * start.kinetic
    np.testing.assert_allclose(
        model.mass.numpy() @ state.plies.v.numpy(), momentum, atol=1e-9 * np.abs(momentum).max()
    )


def pressed(device, *, self_contact):
    """A strip folded like a hairpin, pressed by a plate; its height at the end, and the force."""
    ply = strip(43.5e-3)
    folded = hairpin(ply.rest_points, 21e-3)
    low = Tool.plate("low", width=0.2, height=0.2).moved((0.0, 0.0, -0.5 * THICKNESS))
    top = Tool.plate(
        "top",
        width=0.2,
        height=0.2,
        facing="down",
        motion=Float(force=20.0, ramp=1e-3, mass=5e-3, damping=20.0),
    )
    top = top.moved((0.0, 0.0, EDGE + 0.5 * THICKNESS))
    model, state = placed(
        ply,
        folded,
        device,
        duration=8e-3,
        tools=[low, top],
        friction=0.0,
        self_contact=self_contact,
        numerics=Numerics(yarn_softening=36.0, damping=2000.0),
    )
    marched(model, state, model.timing.steps // model.timing.search_every)
    height = EDGE + THICKNESS + state.tools.shift.numpy()[1, 2]
    legs = np.abs(folded[:, 0] - 10e-3) < 6e-3
    return height, state.plies.x.numpy()[legs, 2].reshape(-1), model, state


def test_a_fold_pressed_shut_is_two_thicknesses_high(device):
    height, levels, model, state = pressed(device, self_contact=True)
    assert height == pytest.approx(2.0 * THICKNESS, rel=0.02)
    lower, upper = levels[levels < 0.5 * THICKNESS], levels[levels > 0.5 * THICKNESS]
    assert upper.mean() - lower.mean() == pytest.approx(THICKNESS, rel=0.02)
    contact, memory = of_kind(model, state, SelfContact)
    measured = contact.measure(bodies_of(state), memory)
    lower_face, upper_face = measured.pressing["contact_pressure"]
    assert 0.85 * 40.0 < upper_face.sum() < 1.01 * 40.0, (
        "both legs bear the plate; a little the fold"
    )
    assert lower_face.sum() < 0.05 * 20.0
    entry = measured.entries["self_contact"][0]
    assert entry["touching_vertices"] > 50
    assert entry["max_penetration_m"] < 0.05 * THICKNESS
    height, *_ = pressed(device, self_contact=False)
    assert height == pytest.approx(THICKNESS, rel=0.02), "the layers lie in each other"


def test_only_plies_that_bend_touch_themselves():
    bending, plain = (
        strip(10e-3),
        replace(strip(10e-3), fabric=with_bending("carbon_interlock", "none")),
    )
    for ply, options, expected in (
        (bending, {}, 1),
        (plain, {}, 0),
        (bending, {"self_contact": False}, 0),
    ):
        scene = still_scene(ply, **options)
        model = build_model(scene, "cpu", frames=1)
        assert sum(isinstance(c, SelfContact) for c in model.contacts) == expected
        assert (step_share(scene) > 0.0) == bool(expected)


def test_friction_of_a_fabric_with_itself_must_be_there():
    with pytest.raises(
        InputError, match=r"ply 'strip' may touch itself: add \('carbon_interlock', "
    ):
        still_scene(strip(10e-3), ply_friction={("carbon_interlock", "glass"): 0.3})
    still_scene(strip(10e-3), ply_friction={("glass", "glass"): 0.3}, self_contact=False)


def folded_patches(model, state):
    contact, _ = of_kind(model, state, SelfContact)
    return contact.patches.folded.numpy()


def test_vertices_ask_only_where_a_ply_has_folded(device):
    cloth = with_bending("carbon_interlock", 1e-5)
    ply = Ply.rectangle("strip", cloth, 0.2, edge=5e-3, mesh="random")
    dome = ply.rest_points.copy()
    dome[:, 2] += 0.04 * np.exp(-(dome[:, :2] ** 2).sum(axis=1) / 0.05**2)  # walls of 34°
    over = ply.rest_points.copy()
    right = over[:, 0] > 0.02
    over[right, 0] = 0.04 - over[right, 0]
    over[right, 2] += 1.1 * THICKNESS
    for shape, expected in ((ply.rest_points, 0), (dome, 0), (over, 1)):
        model, state = placed(ply, shape, device)
        stepping.search_contacts(model, state, asking=True)
        assert folded_patches(model, state).max() == expected
    touching = np.isfinite(found(model, state)).any(axis=0)
    inner = np.abs(ply.rest_points[:, 1]) < 0.09
    assert touching[
        inner & (over[:, 0] > -0.05) & (np.abs(ply.rest_points[:, 0] - 0.02) > 0.01)
    ].all()


def test_exact_contact_asks_everywhere(device):
    ply = strip(20e-3)
    numerics = Numerics(yarn_softening=36.0, contact="exact")
    model, state = placed(ply, ply.rest_points, device, numerics=numerics)
    stepping.search_contacts(model, state, asking=True)
    assert folded_patches(model, state).all()


def test_the_lips_of_a_notch_touch_without_a_bend(device):
    notch = [(0.01, 0.1), (0.0, 0.0), (-0.01, 0.1)]
    outline = Polygon([(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), *notch, (-0.1, 0.1)])
    ply = Ply(
        name="strip",
        fabric=with_bending("carbon_interlock", 1e-5),
        mesh=mesh_outline(outline, edge=5e-3, pattern="random"),
    )
    x = ply.rest_points.copy()
    right = (x[:, 0] > 0.0) & (x[:, 1] > 0.0)
    x[right, 0] -= 0.2 * x[right, 1]  # the right lip moves over the left one
    x[right, 2] += 1.05 * THICKNESS * np.minimum(x[right, 1] / 0.03, 1.0)
    model, state = placed(ply, x, device)
    stepping.search_contacts(model, state, asking=True)
    over = right & (ply.rest_points[:, 1] > 0.07) & (x[:, 0] < -0.006) & (x[:, 1] < 0.095)
    assert over.sum() > 3
    gaps = found(model, state)[:, over].min(axis=0)
    np.testing.assert_allclose(gaps, 0.05 * THICKNESS, atol=1e-6)
    assert folded_patches(model, state).sum() < 0.6 * len(folded_patches(model, state))


def test_parts_of_threads_add_up_to_the_whole(device):
    ply = strip(43.5e-3)
    shapes = []
    for count in (1, 3):
        model, state = placed(ply, hairpin(ply.rest_points, 21e-3), device, duration=8e-4)
        v = np.zeros_like(state.plies.x.numpy())
        v[ply.rest_points[:, 0] > 0.5 * EDGE] = (0.2, 0.1, -2.0)
        state.plies.v.assign(v)
        parts = stepping.split(model, state, count)
        stepping.Stepper(model, state, 1).begin_frame(1)
        job = stepping._Job(parts, parts, None)
        for block in range(model.timing.steps // model.timing.search_every):
            job.run(block % 16 == 0)
        assert max(contact_slip(model, part.state) for part in parts) > 0.0, "they met"
        shapes.append(state.plies.x.numpy())
    np.testing.assert_allclose(shapes[0], shapes[1], atol=1e-10)


def contact_slip(model, state):
    """Longest way slid [m]."""
    return float(of_kind(model, state, SelfContact)[1].slip.numpy().max())
