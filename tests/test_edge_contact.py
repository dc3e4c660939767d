"""Edges that touch edges: found as by brute force, crossing folds held apart, energy kept."""

import dataclasses
import math

import numpy as np
import pytest
from interaction_checks import of_kind
from resume_checks import ELASTIC, STIFF

from warpdrape import Ply, Scene, lay_up
from warpdrape.contact.edge_contact import EdgeContact
from warpdrape.contact.law import step_share
from warpdrape.dynamics import energy, interactions, stepping
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.partition import shares
from warpdrape.interaction import bodies_of
from warpdrape.materials.bending import Bending
from warpdrape.numerics import Numerics
from warpdrape.state import all_arrays
from warpdrape.timing import ASK_EVERY

SIDE = 5e-3
LIMP = dataclasses.replace(ELASTIC, bending=Bending(warp=1e-7, weft=1e-7))


def crossed(device, gap, *, slant=math.pi / 4, material=LIMP, **options):
    """A roof below, its ridge along y, and a keel above it along x; they cross in mid-edge.

    Args:
        device: Warp device.
        gap: between the surfaces of the two ridges [m].
        slant: of their sides [rad].
        material: of both.
        options: of the scene.
    """
    plies = lay_up(
        [Ply.rectangle(n, material, 6 * SIDE, cells=6, mesh="diagonal") for n in ("low", "high")]
    )
    given = {"gravity": (0.0, 0.0, 0.0), "numerics": Numerics(yarn_softening=4.0), **options}
    model = build_model(Scene(name="roofs", plies=plies, duration=2e-3, **given), device, frames=1)
    state, upper = initial_state(model), model.spans[1].first_vertex
    rest = model.rest.numpy()
    x = np.zeros_like(rest)
    low, high = rest[:upper], rest[upper:]
    x[:upper, 0], x[:upper, 2] = math.cos(slant) * low[:, 0], -math.sin(slant) * np.abs(low[:, 0])
    x[:upper, 1] = low[:, 1] + 0.5 * SIDE
    x[upper:, 1], x[upper:, 2] = math.cos(slant) * high[:, 1], math.sin(slant) * np.abs(high[:, 1])
    x[upper:, 0] = high[:, 0] + 0.5 * SIDE
    x[upper:, 2] += material.thickness + gap
    state.plies.x.assign(x)
    return model, state


def found(model, state):
    """Gaps [m] of the edges that are near others, by the ends of both."""
    contact, memory = of_kind(model, state, EdgeContact)
    x, kept, seen = state.plies.x.numpy(), memory.contacts.numpy(), memory.seen.numpy()
    ends = contact.sheets.edges.ends.numpy()
    gaps = {}
    for e in np.flatnonzero(kept["near"]):
        one, share = kept[e], seen["share"][e]
        point = (1.0 - share) * x[ends[e, 0]] + share * x[ends[e, 1]]
        there = one["weights"][0] * x[one["a"]] + one["weights"][1] * x[one["b"]]
        gap = one["normal"] @ (point - there) - one["thickness"] - one["rise"]
        gaps[tuple(ends[e]), tuple(ends[seen["other"][e] - 1])] = gap
    return gaps


class Edge:
    """An edge of a mesh, for brute force: in which directions it is nearest."""

    def __init__(self, ends, facets, x, way):
        self.ends, self.place, self.along = ends, x[ends[0]], x[ends[1]] - x[ends[0]]
        normals = []
        for facet in facets:
            normal = np.cross(x[facet[1]] - x[facet[0]], x[facet[2]] - x[facet[0]])
            normals.append(normal / np.linalg.norm(normal))
        (beyond,) = set(facets[-1]) - set(ends)
        if len(facets) == 2:
            self.up = 1 if (x[beyond] - self.place) @ normals[0] < 0.0 else -1
            self.sharp = math.acos(min(normals[0] @ normals[1], 1.0)) > 0.5
            self.outer = [self.up * normal for normal in normals]
        else:  # a border: from beside the ply
            self.up, self.sharp = way, True
            aside = np.cross(self.along, normals[0])
            aside *= np.sign(aside @ (self.place - x[beyond])) / np.linalg.norm(aside)
            self.outer = [way * normals[0] - 0.25 * aside, aside]

    def bears(self, direction):
        """Whether a direction across the edge is one in which it is nearest."""
        weights = np.linalg.lstsq(np.stack(self.outer, axis=1), direction, rcond=None)[0]
        return (weights >= 0.0).all()


def ridges_of(triangles, x, way):
    """Edges of a mesh that bend by more than 29 degrees towards a side, and those of its border."""
    beside = {}
    for facet in triangles.tolist():
        for k in range(3):
            beside.setdefault(tuple(sorted((facet[k], facet[k - 2]))), []).append(facet)
    edges = [Edge(ends, facets, x, way) for ends, facets in beside.items()]
    return [edge for edge in edges if edge.sharp and edge.up == way]


def hollows_of(triangles, x):
    """Room above and below vertices [m]: the highest of the arcs over the edges there."""
    normals, rooms = np.zeros_like(x), np.zeros((len(x), 2))
    a, b, c = (x[triangles[:, k]] for k in range(3))
    for k in range(3):
        np.add.at(normals, triangles[:, k], np.cross(b - a, c - a))
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        for one, other in ((triangles[:, i], triangles[:, j]), (triangles[:, j], triangles[:, i])):
            along = x[one] - x[other]
            arc = 0.125 * (along * (normals[one] - normals[other])).sum(axis=1)
            highest = 0.175 * np.linalg.norm(along, axis=1)
            for face, sign in ((0, -1.0), (1, 1.0)):
                np.maximum.at(rooms[:, face], one, np.clip(sign * arc, 0.0, highest))
    return rooms


def crossing_gap(one, other, rooms, thickness):
    """Gap [m] of two ridges that stick out towards each other, infinite of others."""
    across = np.cross(one.along, other.along)
    system = np.stack([one.along, -other.along, across / np.linalg.norm(across)], axis=1)
    share, there, distance = np.linalg.solve(system, other.place - one.place)
    direction = system[:, 2] * np.sign(system[:, 2] @ sum(one.outer))
    distance *= direction @ system[:, 2]
    if not (0.0 < share < 1.0 and 0.0 < there < 1.0):
        return np.inf
    if not (one.bears(direction) and other.bears(-direction)):
        return np.inf
    for edge, s in ((one, share), (other, there)):
        room = rooms[list(edge.ends), 0 if edge.up > 0 else 1]
        distance += (1.0 - s) * room[0] + s * room[1]
    return distance - thickness if distance > 0.0 else np.inf


def by_brute_force(model, x, reach):
    """The least gap of each edge of two plies, on the next one, if it is near."""
    meshes = [
        np.asarray(ply.mesh.triangles) + span.first_vertex
        for ply, span in zip(model.scene.plies, model.spans, strict=True)
    ]
    rooms = hollows_of(np.concatenate(meshes), x)
    low, high = (ridges_of(*each) for each in zip(meshes, (x, x), (1, -1), strict=True))
    least = {}
    for one in low:
        for other in high:
            gap = crossing_gap(one, other, rooms, STIFF.thickness)
            for ends in (one.ends, other.ends):
                if gap < min(reach, least.get(ends, np.inf)):
                    least[ends] = gap
    return least


def test_ridges_are_found_as_by_brute_force(device):
    plies = lay_up(
        [
            Ply.rectangle(name, STIFF, 0.06, cells=10, mesh="random", warp_angle=angle)
            for name, angle in (("low", 0.0), ("high", 0.4))
        ]
    )
    model = build_model(
        Scene(name="s", plies=plies, duration=1e-2, self_contact=False), device, frames=1
    )
    upper = model.spans[1].first_vertex
    random, compared = np.random.default_rng(5), 0
    for apart in np.linspace(1.5e-3, 6e-3, 8):
        state = initial_state(model)
        bumps = (5e-4, 5e-4, 4e-3)
        x = model.rest.numpy() + random.uniform(-1.0, 1.0, (len(model.rest), 3)) * bumps
        x[upper:, 2] += apart
        state.plies.x.assign(x)
        stepping.search_contacts(model, state)
        right = by_brute_force(model, x, float(state.plies.paces.numpy()["reach"][0]))
        seen = {one: gap for (one, _), gap in found(model, state).items()}
        assert seen.keys() == right.keys()
        for ends, gap in right.items():
            assert seen[ends] == pytest.approx(gap, abs=1e-9)
        compared += len(right)
    assert compared > 30


def launched(model, state, stage):
    """Launch what edge contact alone does in a stage."""
    contact, memory = of_kind(model, state, EdgeContact)
    (share,) = shares(model, 1)
    for launch in getattr(contact.launches(share, bodies_of(state), memory), stage):
        launch(model.device)


@pytest.mark.parametrize("rooms", [0.0, 4e-5])
def test_the_gap_changes_as_the_force_pushes(device, rooms):
    """Weights and normal are the gradient of the gap, by central differences; hence F = −dW/dx.

    Room that changes along a ridge tilts the normal, which is of unit length all the same.
    """
    model, state = crossed(device, 5e-5)
    stepping.search_contacts(model, state)
    contact, memory = of_kind(model, state, EdgeContact)
    start, random = state.plies.x.numpy().copy(), np.random.default_rng(2)
    start += random.normal(scale=2e-5, size=start.shape)
    contact.hollows.assign(rooms * random.uniform(size=(len(start), 2)))
    state.plies.x.assign(start)
    launched(model, state, "ask")
    kept, seen = memory.contacts.numpy().copy(), memory.seen.numpy().copy()
    ends = contact.sheets.edges.ends.numpy()
    near = np.flatnonzero(kept["near"])
    assert len(near) == 2
    for e in near:
        one, share = kept[e], seen["share"][e]
        pair = tuple(ends[e]), tuple(ends[seen["other"][e] - 1])
        weights = np.r_[1.0 - share, share, -one["weights"][:2]]
        slopes = np.zeros((4, 3))
        for k, vertex in enumerate((*pair[0], *pair[1])):
            for axis in range(3):
                for step in (1e-7, -1e-7):
                    x = start.copy()
                    x[vertex, axis] += step
                    state.plies.x.assign(x)
                    launched(model, state, "ask")
                    slopes[k, axis] += found(model, state)[pair] / (2.0 * step)
        tilt = np.linalg.norm(slopes[0]) / weights[0]
        assert tilt == pytest.approx(1.0, abs=1e-5 if rooms == 0.0 else 3e-3)
        expected = tilt * weights[:, None] * one["normal"]
        # Room tilts by 0.008. What it adds as edges turn and move along is a share of that, of
        # thickness over length across the edges, and mostly in the distance.
        close = 1e-6 if rooms == 0.0 else 2e-4
        np.testing.assert_allclose(slopes[:, :2], expected[:, :2], atol=close)
        np.testing.assert_allclose(slopes[:, 2], expected[:, 2], atol=10.0 * close)


def test_two_ridges_press_with_what_their_masses_bear(device):
    """Each of the two slots bears share · m/Δt² times the depth, 1/m = Σ w² · 4/m_i.

    At each end two ridges bear two contacts. They cross at 0.65 of the lower, 0.4 of the upper one.
    """
    depth = 3e-5
    model, state = crossed(device, 1e-5, friction=0.0)
    x, upper = state.plies.x.numpy(), model.spans[1].first_vertex
    x[upper:, :2] += (0.1 * SIDE, 0.15 * SIDE)
    state.plies.x.assign(x)
    stepping.search_contacts(model, state)
    assert len(found(model, state)) == 2
    x[upper:, 2] -= depth + 1e-5
    state.plies.x.assign(x)
    state.plies.v.assign(np.broadcast_to((0.3, 0.2, 0.1), x.shape))  # together: nothing is lost
    state.plies.f.zero_()
    launched(model, state, "scatter")
    force = state.plies.f.numpy()
    pushed = np.flatnonzero(np.abs(force[:, 2]) > 0.0)
    weights = np.array([0.35, 0.65, 0.6, 0.4])
    inverse = (4.0 * weights**2 / model.mass.numpy()[pushed]).sum()
    numerics = model.scene.numerics
    expected = 2.0 * numerics.contact_share / model.timing.time_step**2 / inverse * depth
    np.testing.assert_allclose(
        force[pushed, 2], expected * weights * (-1.0, -1.0, 1.0, 1.0), rtol=1e-6
    )
    np.testing.assert_allclose(force[:, :2], 0.0, atol=1e-9 * expected)
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-12 * expected)
    moment = np.cross(state.plies.x.numpy(), force).sum(axis=0)
    np.testing.assert_allclose(moment, 0.0, atol=1e-9 * expected)
    contact, memory = of_kind(model, state, EdgeContact)
    measured = contact.measure(bodies_of(state), memory)
    below, above = measured.pressing["contact_pressure"]
    assert above[:upper].sum() == pytest.approx(expected) == below[upper:].sum()
    assert not below[:upper].any() and not above[upper:].any()
    assert measured.stored["contact"] == pytest.approx(0.5 * expected * depth)
    entries = {(e["edges_of"], e["on"]): e for e in measured.entries["edge_contact"]}
    assert entries.keys() == {("low", "high"), ("high", "low")}
    assert entries["low", "high"]["max_penetration_m"] == pytest.approx(depth)
    assert entries["low", "high"]["touching_edges"] == 1


def bound_on_stiffness(model, state):
    """Largest of what edge contacts take of the step, over one contact's share [-]."""
    contact, memory = of_kind(model, state, EdgeContact)
    kept, seen, ends = (
        a.numpy() for a in (memory.contacts, memory.seen, contact.sheets.edges.ends)
    )
    mass = model.mass.numpy()
    matrix = np.zeros((len(mass), len(mass)))
    for e in np.flatnonzero(kept["near"]):
        row, share = np.zeros(len(mass)), seen["share"][e]
        row[ends[e]] += (1.0 - share, share)
        row[[kept[e]["a"], kept[e]["b"]]] -= kept[e]["weights"][:2]
        matrix += kept[e]["mass"] * np.outer(row, row)
    root = 1.0 / np.sqrt(mass)
    return np.linalg.eigvalsh(root[:, None] * matrix * root).max(), int(kept["near"].sum())


def test_however_many_ridges_meet_they_take_one_contact_of_the_step(device):
    plies = lay_up([Ply.rectangle(n, STIFF, 0.06, cells=12, mesh="random") for n in ("a", "b")])
    model = build_model(Scene(name="s", plies=plies, duration=1e-2), device, frames=1)
    random = np.random.default_rng(7)
    for bumps in (1e-3, 2e-3, 3e-3):
        state = initial_state(model)
        x = model.rest.numpy() + random.normal(scale=bumps, size=(len(model.rest), 3)) * (
            0.3,
            0.3,
            1,
        )
        x[model.spans[1].first_vertex :, 2] += 1.2 * bumps
        state.plies.x.assign(x)
        stepping.search_contacts(model, state)
        most, near = bound_on_stiffness(model, state)
        assert near > 4 and 0.1 < most <= 1.0
    one = Scene(name="s", plies=plies[:1], duration=1e-2, self_contact=False)
    with_self = dataclasses.replace(one, self_contact=True)
    share = with_self.numerics.contact_share
    damping = 8.0 * with_self.numerics.contact_damping * math.sqrt(share)
    assert step_share(with_self) == pytest.approx(9.0 * share + damping)
    assert step_share(one) == 0.0


def thrown(device, monkeypatch=None, *, speed=0.5, material=LIMP, **options):
    """Roof and keel thrown at each other; the least distance of their ridges, model and state."""
    if monkeypatch is not None:
        others = [c for c in interactions.CONTACTS if c.__name__.split(".")[-1] != "edge_contact"]
        monkeypatch.setattr(interactions, "CONTACTS", tuple(others))
    model, state = crossed(device, 2e-4, material=material, **options)
    v, upper = np.zeros_like(state.plies.x.numpy()), model.spans[1].first_vertex
    v[:upper], v[upper:] = (0.0, 0.05, speed), (0.05, 0.0, -speed)
    state.plies.v.assign(v)
    start = energy.balance(model, state, energy.measure(model, state))
    stepper, least = stepping.Stepper(model, state), np.inf
    stepper.begin_frame(1)
    rest = model.rest.numpy()
    low, high = (
        np.flatnonzero((np.abs(rest[span.vertices, axis]) < 1e-9) & inner) + span.first_vertex
        for span, axis, inner in (
            (model.spans[0], 0, np.abs(rest[:upper, 1] + 0.5 * SIDE) < 0.6 * SIDE),
            (model.spans[1], 1, np.abs(rest[upper:, 0] + 0.5 * SIDE) < 0.6 * SIDE),
        )
    )
    for _ in range(model.timing.steps // model.timing.search_every):
        stepper.block()
        x = state.plies.x.numpy()
        least = min(least, x[high, 2].mean() - x[low, 2].mean())
    return least, start, model, state


def test_folds_that_cross_hold_each_other_apart(device, monkeypatch):
    """At 1 m/s; without edges they go 0.8 mm into each other, and on."""
    least, start, model, state = thrown(device, friction=0.0)
    assert least > 0.8 * STIFF.thickness
    v, mass = state.plies.v.numpy(), model.mass.numpy()
    upper = model.spans[1].first_vertex
    assert mass[upper:] @ v[upper:, 2] > -0.7 * 0.5 * mass[upper:].sum(), "slowed down"
    np.testing.assert_allclose(mass @ v[:, 2], 0.0, atol=1e-9 * mass.sum())
    end = energy.balance(model, state, energy.measure(model, state))
    assert end.contact_damping > 1e-3 * start.kinetic
    assert abs(end.unbalanced - start.unbalanced) < 5e-3 * start.kinetic
    least, *_ = thrown(device, monkeypatch, friction=0.0)
    assert least < -STIFF.thickness, "vertices alone let them through"


def test_friction_of_edges_takes_what_it_says(device):
    _, start, model, state = thrown(device, ply_friction=0.4)
    end = energy.balance(model, state, energy.measure(model, state))
    assert end.friction > 1e-3 * start.kinetic
    assert abs(end.unbalanced - start.unbalanced) < 5e-3 * start.kinetic
    _, memory = of_kind(model, state, EdgeContact)
    assert memory.slip.numpy().max() > 1e-5


def test_parts_of_threads_add_up_to_the_whole(device):
    shapes = []
    for count in (1, 3):
        model, state = crossed(device, 1e-4)
        v, upper = np.zeros_like(state.plies.x.numpy()), model.spans[1].first_vertex
        v[upper:, 2] = -1.0
        state.plies.v.assign(v)
        parts = stepping.split(model, state, count)
        stepping.Stepper(model, state, 1).begin_frame(1)
        job = stepping._Job(parts, parts, None)
        for block in range(6):
            job.run(block % ASK_EVERY == 0)
        touched = [of_kind(model, part.state, EdgeContact)[1].stored.numpy() for part in parts]
        assert max(stored.max() for stored in touched) > 0.0, "they met"
        shapes.append(state.plies.x.numpy())
    np.testing.assert_allclose(shapes[0], shapes[1], atol=1e-12)


def test_what_edges_remember_is_kept_to_the_bit(device):
    """A state read from another's bytes goes on as that one does."""
    ends = []
    for cut in (False, True):
        model, state = crossed(device, 1e-4)
        v, upper = np.zeros_like(state.plies.x.numpy()), model.spans[1].first_vertex
        v[upper:, 2] = -1.0
        state.plies.v.assign(v)
        stepper = stepping.Stepper(model, state)
        stepper.begin_frame(1)
        for _ in range(ASK_EVERY):
            stepper.block()
        if cut:
            _, memory = of_kind(model, state, EdgeContact)
            assert memory.stored.numpy().max() > 0.0, "cut while they touch"
            kept = [array.numpy() for _, array, _ in all_arrays(state)]
            model, state = crossed(device, 1e-4)
            for (_, array, _), values in zip(all_arrays(state), kept, strict=True):
                array.assign(values)
            stepper = stepping.Stepper(model, state, blocks=ASK_EVERY)
        for _ in range(3):
            stepper.block()
        ends.append([array.numpy() for _, array, _ in all_arrays(state)])
    for one, other in zip(*ends, strict=True):
        assert one.tobytes() == other.tobytes()


def test_smooth_plies_have_no_ridges_that_meet(device):
    """A dome and a saddle, 0.6 mm apart, of coarse triangles: borders meet, and nothing else."""
    plies = lay_up([Ply.rectangle(n, STIFF, 0.12, cells=8, mesh="random") for n in ("a", "b")])
    model = build_model(Scene(name="s", plies=plies, duration=1e-2), device, frames=1)
    x0, y0, _ = model.rest.numpy().T
    for shape in (x0**2 + y0**2, x0**2 - y0**2, 2.0 * x0 * y0):
        state = initial_state(model)
        x = model.rest.numpy().copy()
        x[:, 2] -= shape / (2.0 * 0.06)
        state.plies.x.assign(x)
        stepping.search_contacts(model, state)
        on_border = np.isclose(np.abs(model.rest.numpy()[:, :2]), 0.06).any(axis=1)
        for pair in found(model, state):
            assert on_border[np.array(pair)].all()


def folded_over(ply):
    """A strip whose ends lie over each other, a roof below and a keel across it above."""
    s, w = ply.rest_points[:, 0], ply.rest_points[:, 1]
    x = np.stack([s, w, np.zeros_like(s)], axis=1)
    below, above = s < -12e-3, s > 12e-3
    x[below] = np.stack(
        [s[below] + 23.25e-3, math.cos(0.6) * w[below], -math.sin(0.6) * np.abs(w[below])], axis=1
    )
    t = 22.5e-3 - s[above]
    x[above] = np.stack(
        [
            math.cos(0.6) * t,
            w[above] + 0.75e-3,
            math.sin(0.6) * np.abs(t) + STIFF.thickness + 5e-5,
        ],
        axis=1,
    )
    between = ~(below | above)
    x[between] = np.stack([0.03 * np.cos(s[between] / 8e-3), w[between], 0.05 + s[between]], axis=1)
    return x


def test_folds_of_one_ply_that_cross_are_found(device):
    ply = Ply.rectangle("strip", STIFF, 60e-3, 12e-3, edge=1.5e-3, mesh="diagonal")
    model = build_model(Scene(name="s", plies=[ply], duration=1e-3), device, frames=1)
    state = initial_state(model)
    state.plies.x.assign(folded_over(ply))
    stepping.search_contacts(model, state)
    gaps = found(model, state)
    rest = model.rest.numpy()
    apart = [
        np.linalg.norm(rest[list(a)][:, None] - rest[list(b)][None], axis=2).min() for a, b in gaps
    ]
    assert min(apart) > 4.0 * STIFF.thickness
    crossing = [
        gap
        for (one, other), gap in gaps.items()
        if (np.abs(rest[list(one), 1]) < 1e-9).all() and (rest[list(one), 0] < -12e-3).all()
    ]
    assert crossing == pytest.approx([5e-5], abs=1e-9)
    without = Scene(name="s", plies=[ply], duration=1e-3, self_contact=False)
    assert not any(isinstance(c, EdgeContact) for c in build_model(without, device, 1).contacts)


def test_what_is_near_along_the_sheet_is_no_other_fold(device):
    ply = Ply.rectangle("crumpled", STIFF, 0.06, cells=12, mesh="random")
    model = build_model(Scene(name="s", plies=[ply], duration=1e-3), device, frames=1)
    contact, random, met = model.contacts[2], np.random.default_rng(3), 0
    apart, rest = contact.sheets.flat.apart.numpy(), model.rest.numpy()
    for _ in range(3):
        state = initial_state(model)
        state.plies.x.assign(rest + random.normal(scale=4e-3, size=rest.shape))
        stepping.search_contacts(model, state)
        for one, other in found(model, state):
            between = np.linalg.norm(rest[list(one)][:, None] - rest[list(other)][None], axis=2)
            assert between.min() >= max(apart[one[0]], apart[other[0]])
            met += 1
    assert met > 5


def test_ridges_that_begin_in_each_other_are_not_thrown_apart(device):
    depth = 1e-4
    model, state = crossed(device, -depth)
    stepping.search_contacts(model, state)
    state.plies.f.zero_()
    launched(model, state, "scatter")
    assert np.abs(state.plies.f.numpy()).max() < 1e-9, "of some newtons"
    contact, memory = of_kind(model, state, EdgeContact)
    upward, downward = memory.jump.numpy()[[1, 2]]
    assert upward == pytest.approx(depth, rel=1e-6) == downward
    assert memory.deepest.numpy().max() < 1e-9 * depth
    for entry in contact.measure(bodies_of(state), memory).entries["edge_contact"]:
        assert entry["max_penetration_m"] < 1e-9 * depth
        assert entry["max_gap_jump_m"] == pytest.approx(depth, rel=1e-6)
