"""The search between plies: a walk over facets finds what brute force finds, and misses nothing."""

import numpy as np
import pytest
from contact_oracle import nearest_on_triangles
from interaction_checks import of_kind
from test_engine import small_press

from warpdrape import Ply, Scene, lay_up
from warpdrape.contact.adjacency import across_edges, border_bits
from warpdrape.contact.law import near_reach
from warpdrape.contact.ply_contact import PlyContact
from warpdrape.contact.ply_facets import build_facets
from warpdrape.contact.ply_surfaces import FADING, PUSH_OUT
from warpdrape.dynamics import stepping
from warpdrape.dynamics.energy import measure
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.numerics import Numerics
from warpdrape.scenes import three_ply_hemisphere
from warpdrape.state import copied
from warpdrape.timing import ASK_EVERY, peak_speed

THICKNESS = 6e-4


def of_look(model, look):
    """Slices of the searching ply's vertices, and of its slots."""
    searching = model.spans[look.searching]
    return searching.vertices, slice(look.first_slot, look.first_slot + searching.vertex_count)


def contact_of(model):
    (found,) = (contact for contact in model.contacts if isinstance(contact, PlyContact))
    return found


def memory_of(model, state):
    return of_kind(model, state, PlyContact)[1]


def gaps(model, state):
    """Gap [m] of every slot's contact, infinite where none is near."""
    x, contacts = state.plies.x.numpy(), memory_of(model, state).contacts.numpy()
    found = np.full(len(contacts), np.inf)
    for look in contact_of(model).looks:
        vertices, slots = of_look(model, look)
        kept = contacts[slots]
        at = np.stack([x[kept[name]] for name in "abc"], axis=1)
        nearest = (kept["weights"][:, :, None] * at).sum(axis=1)
        height = ((x[vertices] - nearest) * kept["normal"]).sum(axis=1)
        gap = height - kept["thickness"] - kept["rise"]
        found[slots] = np.where(kept["near"] == 1, gap, np.inf)
    return found


def nearest_facets(model, state):
    """Distance [m] of every slot's vertex from the ply that it saw last, by brute force."""
    x, memory = state.plies.x.numpy(), memory_of(model, state).seen.numpy()
    distances = np.full(len(memory), np.inf)
    facets = contact_of(model).surfaces.facets.corners.numpy()
    for look in contact_of(model).looks:
        vertices, slots = of_look(model, look)
        seen = memory["ply"][slots] - 1
        for ply in np.unique(seen[seen >= 0]):
            corners = x[facets[model.spans[ply].triangles]]
            points = x[vertices][seen == ply]
            nearest, _, _ = nearest_on_triangles(points, corners, k=len(corners))
            distances[slots][seen == ply] = np.linalg.norm(points - nearest, axis=1)
    return distances


def remembered(model, state):
    """Distance [m] of every slot's vertex from the facet that it remembers, infinite if none."""
    x, memory = state.plies.x.numpy(), memory_of(model, state).seen.numpy()
    distances = np.full(len(memory), np.inf)
    corners = contact_of(model).surfaces.facets.corners.numpy()
    for look in contact_of(model).looks:
        vertices, slots = of_look(model, look)
        seen = memory["seen"][slots]
        for k in np.flatnonzero(seen > 0):
            point, facet = x[vertices][[k]], x[corners[seen[[k]] - 1]]
            distances[slots.start + k] = np.linalg.norm(
                point - nearest_on_triangles(point, facet, k=1)[0]
            )
    return distances


def searched(model, state, *, asking):
    """Gaps and facets remembered after a search on a copy of the state."""
    copy = copied(state)
    stepping.search_contacts(model, copy, asking=asking)
    return gaps(model, copy), copy


def pressed(device):
    """Three plies on their way, four times where the next search would ask for every vertex."""
    scene = three_ply_hemisphere.build(cells=8, travel=0.03, duration=0.012)
    model = build_model(scene, device, frames=1)
    state = initial_state(model)
    stepper = stepping.Stepper(model, state)
    stepper.begin_frame(1)
    stops = 6 * ASK_EVERY
    for block in range(1, 4 * stops + 1):
        if block % stops == 0:
            yield model, state
        stepper.block()


def test_walks_find_what_asking_finds(device):
    compared = moved = 0
    for model, state in pressed(device):
        near = near_reach(model.scene)
        walked, after = searched(model, state, asking=False)
        asked, _ = searched(model, state, asking=True)
        either = np.minimum(walked, asked) < 0.9 * near
        np.testing.assert_allclose(walked[either], asked[either], atol=1e-7)
        compared += either.sum()
        before = memory_of(model, state).seen.numpy()["seen"]
        moved += (before != memory_of(model, after).seen.numpy()["seen"]).sum()
        nearest = nearest_facets(model, after)
        in_sight = nearest < THICKNESS + 0.9 * near
        waiting = memory_of(model, state).seen.numpy()["way"] > 2.0 * near
        assert not (in_sight & waiting & np.isfinite(asked)).any()
        # Queries round positions to single precision, and so may take a facet 1e-7 m farther off.
        np.testing.assert_allclose(remembered(model, after)[in_sight], nearest[in_sight], atol=1e-6)
    assert compared > 1000 and moved > 20


def test_whoever_is_far_is_looked_at_before_it_can_touch(device):
    """A ply that falls on another by the speed that is allowed for, always found in time."""
    low, high = (
        Ply.rectangle(name, "carbon_interlock", 0.05, cells=5, warp_angle=angle, z=z)
        for name, angle, z in (("low", 0.0, 0.0), ("high", 0.3, THICKNESS + 3.1e-3))
    )
    model = build_model(Scene(name="fall", plies=[low, high], duration=1e-3), device, frames=1)
    state = initial_state(model)
    reach = near_reach(model.scene)
    start, left_out = state.plies.x.numpy(), 0
    first = model.spans[1].first_vertex
    inner = np.abs(start[:, :2]).max(axis=1) < 0.02
    for search in range(64):
        gap = 3.1e-3 - 0.95 * reach * search
        if gap < -1e-4:
            break
        x = start.copy()
        x[first:, 2] = THICKNESS + gap
        state.plies.x.assign(x)
        stepping.search_contacts(model, state, asking=search % ASK_EVERY == 0)
        near = memory_of(model, state).contacts.numpy()["near"] == 1
        slots = np.r_[inner[:first], inner[first:]]
        assert near[slots].all() if gap <= 0.9 * reach else True
        assert not near[slots].any() if gap > reach else True
        left_out += (memory_of(model, state).seen.numpy()["way"] > 2.0 * reach).sum()
    assert gap < 0.0 and left_out > 100


def test_a_corner_at_the_border_is_the_border_for_every_facet_there(device):
    """Vertices off the border, nearest to one of its corners: each facet there gives one gap."""
    plies = lay_up([Ply.rectangle(n, "carbon_interlock", 0.06, cells=4) for n in ("low", "high")])
    model = build_model(Scene(name="off", plies=plies, duration=1e-3), device, frames=1)
    state = initial_state(model)
    x = state.plies.x.numpy()
    first = model.spans[1].first_vertex
    x[first:, 0] += 0.06 + 5e-4  # its left border lies beside the other's right one
    state.plies.x.assign(x)
    stepping.search_contacts(model, state, asking=True)
    found, memory = gaps(model, state), memory_of(model, state).seen.numpy()
    corners = contact_of(model).surfaces.facets.corners.numpy()
    checked = 0
    for slot in np.flatnonzero(np.isfinite(found[:first])):
        seen = corners[memory["seen"][slot] - 1]
        nearest = seen[np.argmin(np.linalg.norm(x[seen] - x[slot], axis=1))]
        for facet in np.flatnonzero((corners == nearest).any(axis=1)):
            other = memory.copy()
            other["seen"][slot] = facet + 1
            memory_of(model, state).seen.assign(other)
            stepping.search_contacts(model, state, asking=False)
            assert gaps(model, state)[slot] == pytest.approx(found[slot], abs=1e-12)
            checked += 1
    assert checked > 10


def farthest_apart(one, other):
    """Largest distance of a vertex between two results [m]."""
    pairs = zip(one.plies, other.plies, strict=True)
    return max(np.linalg.norm(a.points - b.points, axis=1).max() for a, b in pairs)


def test_walking_forms_as_asking_does(monkeypatch):
    walked = small_press().run(frames=2)
    exact = small_press(numerics=Numerics(contact="exact")).run(frames=2)
    monkeypatch.setattr(stepping, "ask_every", lambda numerics: 1)
    asked = small_press().run(frames=2)
    assert all(np.abs(ply.points - ply.rest_points).max() > 3e-3 for ply in walked.plies)
    # Loose plies under a ball wander: with steps 0.6 % shorter they end 0.14 mm from "asked", and
    # exact ones 0.08 mm from "exact".
    assert farthest_apart(walked, asked) < 5e-5
    assert farthest_apart(walked, exact) < 2e-4


@pytest.mark.slow
def test_three_plies_form_as_with_a_search_at_every_step():
    fast, exact = (
        three_ply_hemisphere.build(
            cells=8, travel=0.03, duration=0.04, accuracy="reference", contact=contact
        ).run(frames=10)
        for contact in ("fast", "exact")
    )
    assert exact.completed and fast.completed
    for one, other in zip(fast.summary["plies"], exact.summary["plies"], strict=True):
        assert one["p95_shear_deg"] == pytest.approx(other["p95_shear_deg"], abs=0.3)
    # Two fast runs whose steps differ by half a per cent end up to 0.18 mm apart (root mean square
    # over a ply), and 1.0 mm at one vertex, where the coarse stack folds this way or that.
    for one, other in zip(fast.plies, exact.plies, strict=True):
        apart = np.linalg.norm(one.points - other.points, axis=1)
        assert np.sqrt(np.mean(apart**2)) < 3e-4


def test_a_search_at_every_step_asks_at_every_step():
    model = build_model(small_press(numerics=Numerics(contact="exact")), "cpu", frames=1)
    stepper = stepping.Stepper(model, initial_state(model))
    stepper.begin_frame(1)
    for _ in range(3):
        stepper.block()
        assert stepper._asking
    assert model.timing.search_every == 1


def test_neighbours_fans_and_rings_are_those_of_brute_force(device):
    meshes = [
        Ply.rectangle("one", "carbon_interlock", 0.05, cells=4, mesh=mesh).mesh.triangles
        for mesh in ("random", "grid")
    ]
    sizes = [t.max() + 1 for t in meshes]
    facets = build_facets(meshes, np.cumsum([0, *sizes]), device)
    corners = facets.corners.numpy()
    edges = [
        {frozenset((t[(k + 1) % 3], t[(k + 2) % 3])): k for k in range(3)} for t in corners.tolist()
    ]
    for t, own in enumerate(edges):
        for edge, k in own.items():
            others = [u for u, theirs in enumerate(edges) if u != t and edge in theirs]
            assert [facets.beside.numpy()[t][k]] == (others or [-1])
    fan, ring = facets.first_of_fan.numpy(), facets.first_of_ring.numpy()
    for v in range(sum(sizes)):
        at = np.flatnonzero((corners == v).any(axis=1))
        assert sorted(facets.fans.numpy()[fan[v] : fan[v + 1]]) == at.tolist()
        round_it = sorted(set(corners[at].ravel().tolist()) - {v})
        assert sorted(facets.rings.numpy()[ring[v] : ring[v + 1]]) == round_it


def test_border_bits_name_edges_and_corners():
    # Two triangles on a square, 0-2 their common edge: all corners lie on the border.
    square = np.array([[0, 1, 2], [0, 2, 3]])
    assert border_bits(square, across_edges(square)).tolist() == [0b111101, 0b111011]
    # A hexagon's fan: the middle does not.
    fan = np.array([[0, 1 + k, 1 + (k + 1) % 6] for k in range(6)])
    assert border_bits(fan, across_edges(fan)).tolist() == [0b110001] * 6
    assert (across_edges(fan)[:, 0] == -1).all() and (across_edges(fan)[:, 1:] >= 0).all()


def two_laid_up(device):
    """Two small plies, with the first vertex of the upper one and its vertices off the border."""
    plies = lay_up(
        [Ply.rectangle(n, "carbon_interlock", 0.06, cells=c) for n, c in (("low", 3), ("up", 2))]
    )
    scene = Scene(name="deep", plies=plies, tools=[], duration=1e-2)
    model = build_model(scene, device, 1)
    inner = np.flatnonzero(np.abs(plies[1].mesh.vertices).max(axis=1) < 0.02)
    return scene, model, initial_state(model), model.spans[1].first_vertex, inner


@pytest.mark.parametrize("depth", [1e-5, 5.5e-4])
def test_what_a_jump_allowed_is_pushed_out_slowly_where_it_is_deep(depth, device):
    # The upper ply is put into the lower one from beside it between two searches, and held there.
    scene, model, state, upper, inner = two_laid_up(device)
    deep, beside = state.plies.x.numpy().copy(), state.plies.x.numpy().copy()
    deep[upper:, 2] -= depth
    beside[upper:, 0] += 0.2
    state.plies.x.assign(beside)
    stepping.search_contacts(model, state)
    assert not memory_of(model, state).contacts.numpy()["near"].any()
    state.plies.x.assign(deep)
    interval = model.timing.search_every * model.timing.time_step
    slowest = PUSH_OUT * peak_speed(scene) * interval
    share = np.exp(-interval / FADING)
    slots = contact_of(model).looks[1].first_slot + inner
    assert contact_of(model).looks[1].searching == 1
    memory, allowed = memory_of(model, state), np.full(len(inner), depth)
    for _ in range(3):  # nothing pays for pushing it out
        stepping.search_contacts(model, state)
        unpaid = memory.contacts.numpy()["allowance"][slots]
        np.testing.assert_allclose(unpaid, depth, rtol=1e-6, atol=1e-12)
    assert np.abs(state.plies.lost.numpy()).max() < 1e-12 * depth
    for _ in range(5):
        memory.spent.fill_(1.0)  # J, more than enough
        stepping.search_contacts(model, state)
        expected = np.maximum(share * allowed, allowed - slowest)
        allowed = memory.contacts.numpy()["allowance"][slots]
        np.testing.assert_allclose(allowed, expected, rtol=1e-6, atol=1e-12)
    assert (depth - allowed < 5.0 * max(slowest, depth * (1.0 - share)) * 1.001).all()
    assert (allowed < depth).all()
    # What the springs now hold was paid for by what had been lost.
    given = state.plies.lost.numpy()[upper + inner, 1]
    assert (given < 0.0).all()


def test_pushing_out_takes_no_more_than_is_paid(device):
    _, model, state, upper, inner = two_laid_up(device)
    deep = state.plies.x.numpy().copy()
    deep[upper:, 2] -= 1e-4
    state.plies.x.assign(deep)
    memory, contact = memory_of(model, state), contact_of(model)
    stepping.search_contacts(model, state)
    slots = contact.looks[1].first_slot + inner
    budget = 1e-12  # J, less than one search would take
    for _ in range(2):
        memory.spent.fill_(budget)
        stepping.search_contacts(model, state)
        np.testing.assert_allclose(memory.spent.numpy()[slots], 0.0, atol=1e-6 * budget)
        memory.stored.zero_()
    found = memory.contacts.numpy()[slots]
    held = 0.5 * contact.law.stiffness * found["mass"] * (1e-4 - found["allowance"]) ** 2
    assert (held > 0.0).all()
    np.testing.assert_allclose(held, 2.0 * budget, rtol=1e-4)


def laid_up(device, widths):
    """Plies of several widths on each other, and what their contact found at the first search."""
    blanks = [
        Ply.rectangle(f"p{n}", "carbon_interlock", width, cells=max(int(width / 0.01), 1))
        for n, width in enumerate(widths)
    ]
    model = build_model(Scene(name="s", plies=lay_up(blanks), duration=1e-3), device, frames=1)
    state = initial_state(model)
    stepping.search_contacts(model, state)
    return model, state, memory_of(model, state)


def test_vertices_meet_the_next_ply_that_covers_them(device):
    """A small ply between two wide ones: beside it these see each other, over it they do not."""
    model, _, memory = laid_up(device, (0.12, 0.036, 0.12))
    points = model.rest.numpy()
    for look in contact_of(model).looks:
        if look.searching == 1:
            continue
        vertices, slots = of_look(model, look)
        away = np.abs(points[vertices][:, :2]).max(axis=1)
        seen = memory.seen.numpy()["ply"][slots] - 1
        assert (seen[away < 0.017] == 1).all()
        assert (seen[away > 0.019] == 2 - look.searching).all()  # some see its border, 2 mm away


def test_memory_and_launches_grow_with_the_plies_not_their_pairs():
    sizes = []
    for count in (4, 8):
        model, state, memory = laid_up("cpu", (0.03,) * count)
        (whole,) = stepping.split(model, state, 1)
        launches = whole.launches
        assert len(contact_of(model).looks) == 2 * (count - 1)
        sizes.append((memory.contacts.size, len(launches.ask), len(launches.scatter)))
    for few, many in zip(*sizes, strict=True):
        assert many <= 2.5 * few


def test_a_ply_that_loses_the_one_between_lies_on_the_next(device):
    """The small ply is taken away: the wide one above it falls and comes to rest on the lowest."""
    model, state, memory = laid_up(device, (0.12, 0.04, 0.12))
    first = model.spans[2].first_vertex
    x = state.plies.x.numpy()
    x[model.spans[1].vertices, 0] += 1.0
    x[first:, 2] = x[0, 2] + THICKNESS + 1e-5
    state.plies.x.assign(x)
    stepping.search_contacts(model, state)
    (look,) = (look for look in contact_of(model).looks if look.searching == 2)
    _, slots = of_look(model, look)
    inner = np.abs(model.rest.numpy()[first:, :2]).max(axis=1) < 0.055
    assert (memory.seen.numpy()["ply"][slots][inner] == 1).all()
    gap = gaps(model, state)[slots][inner]
    np.testing.assert_allclose(gap, 1e-5, atol=1e-9)


def test_what_comes_closer_after_the_last_search_counts_too(device):
    _, model, state, upper, _inner = two_laid_up(device)
    stepping.search_contacts(model, state)
    x = state.plies.x.numpy().copy()
    x[upper:, 2] -= 5e-5
    state.plies.x.assign(x)
    for _ in range(2):  # measuring changes nothing
        measured = measure(model, state)
        (both,) = [m.entries["interfaces"] for m in measured if "interfaces" in m.entries]
        for entry in both:
            assert entry["max_penetration_m"] == pytest.approx(5e-5, rel=1e-9)
    assert memory_of(model, state).deepest.numpy().max() < 1e-12


@pytest.mark.parametrize(("height", "held"), [(-0.4, False), (0.6, True)])
def test_what_comes_in_sight_beside_a_border_is_not_at_once_deep(height, held, device):
    """Half a thickness beyond the border, so many thicknesses over the mid-surface."""
    _, model, state, upper, _ = two_laid_up(device)
    x, apart = state.plies.x.numpy().copy(), state.plies.x.numpy().copy()
    thickness = model.scene.plies[0].fabric.thickness
    width = float(np.ptp(x[:upper, 0]))
    apart[upper:, 0] += 2.0 * width
    state.plies.x.assign(apart)
    stepping.search_contacts(model, state)
    x[upper:, 0] += width + 0.5 * thickness
    x[upper:, 2] = x[:upper, 2].mean() + height * thickness
    state.plies.x.assign(x)
    stepping.search_contacts(model, state)
    look = contact_of(model).looks[1]
    beside = np.flatnonzero(np.isclose(x[upper:, 0], x[upper:, 0].min()))
    near = memory_of(model, state).contacts.numpy()["near"][look.first_slot + beside]
    assert (near == int(held)).all()
