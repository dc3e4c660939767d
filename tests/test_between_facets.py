"""A vertex that rests in the hollow between two facets of another ply: both hold it."""

import numpy as np
import pytest
import warp as wp
from interaction_checks import of_kind

from warpdrape import Ply, Scene, lay_up
from warpdrape.contact.ply_contact import PlyContact
from warpdrape.contact.ply_facets import build_facets
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.partition import shares
from warpdrape.dynamics.stepping import search_contacts
from warpdrape.interaction import bodies_of
from warpdrape.kernels.contact.facets import PlyFacets, nearest_on_facet
from warpdrape.kernels.contact.hollow import Hollow, hollow_at, plane_over

THICKNESS = 6e-4
DEPTH = 3e-5
"""To which the force that presses would press one contact [m]."""


class Valley:
    """A ply bent along a diagonal like an open book, and the tip of another one in its hollow."""

    def __init__(self, device, slope, friction):
        """Sides rise by the slope; nothing but contact acts on the tip, which has a mass."""
        names = {"low": 0.06, "high": 0.02}
        plies = [Ply.rectangle(n, "carbon_interlock", size, cells=1) for n, size in names.items()]
        scene = Scene(name="v", plies=lay_up(plies), duration=1e-2, ply_friction=friction)
        self.model = build_model(scene, device, frames=1)
        self.state = initial_state(self.model)
        self.x, self.v = self.state.plies.x.numpy().copy(), np.zeros(3)
        low, high = self.model.spans
        across = np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0)
        flat = self.x[low.vertices]
        flat[:, 2] = slope * np.abs(flat @ across)
        cone = self.x[high.vertices]
        out = np.hypot(*cone[:, :2].T)
        cone[:, 2] = np.where(out > 0.0, 8e-3, 0.0)
        cone[:, :2] += 7e-3
        (self.tip,) = np.flatnonzero(out == 0.0) + high.first_vertex
        self.across = across
        self.contact, self.memory = of_kind(self.model, self.state, PlyContact)
        self.slot = self.contact.looks[1].first_slot + self.tip - high.first_vertex
        (share,) = shares(self.model, 1)
        self.launches = self.contact.launches(share, bodies_of(self.state), self.memory).scatter
        self.mass = self.model.mass.numpy()[self.tip]
        self.place(self.x[self.tip] + (0.0, 0.0, THICKNESS))
        self.search()
        room = self.contact.surfaces.hollows.numpy()[low.vertices, 0]
        np.testing.assert_allclose(room, room[0])  # in all of the valley, so that heights are known
        self.touching = THICKNESS * np.hypot(1.0, slope) - room[0] * np.hypot(1.0, slope)
        self.place([*self.x[self.tip, :2], self.touching])
        self.search()
        self.stiffness = (
            self.contact.law.stiffness * self.memory.contacts.numpy()["mass"][self.slot]
        )

    def place(self, point):
        self.x[self.tip] = point
        self.state.plies.x.assign(self.x)

    def search(self):
        search_contacts(self.model, self.state)

    def force(self):
        """Of the contact on the tip, after a step at the velocity of now [N]."""
        moving = np.zeros_like(self.x)
        moving[self.tip] = self.v
        self.state.plies.v.assign(moving)
        self.state.plies.f.zero_()
        for launch in self.launches:
            launch(self.model.device)
        return self.state.plies.f.numpy()[self.tip]

    def energy(self):
        """In springs, and what friction and damping took [J]."""
        taken = self.state.plies.lost.numpy()[:, :2].sum()
        return self.memory.stored.numpy()[self.slot] + taken

    def pressed(self, force, searches):
        """Let the tip go under a force [N]: heights [m], and energies less the force's work [J]."""
        timing = self.model.timing
        dt, heights, energies, before = timing.time_step, [], [], self.force()
        for step in range(searches * timing.search_every):
            if step % timing.search_every == 0:
                self.search()
            half = self.v + 0.5 * dt / self.mass * (before + force)
            heights.append(self.x[self.tip, 2])
            motion = 0.5 * self.mass * half @ half
            energies.append(motion + self.energy() - force @ self.x[self.tip])
            self.v = self.v + dt / self.mass * (before + force)
            self.place(self.x[self.tip] + dt * self.v)
            before = self.force()
        return np.array(heights), np.array(energies)


@pytest.mark.parametrize("slope", [0.03, 0.05])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_a_tip_in_a_valley_stays_where_its_spring_holds_it(slope, friction, device):
    valley = Valley(device, slope, friction)
    valley.v = 0.02 * valley.across
    force = np.array([0.0, 0.0, -valley.stiffness * DEPTH])
    heights, energies = valley.pressed(force, searches=60)
    # Half on one side, half on the other; their forces lean by the slope, a thousandth less.
    deep = valley.touching - heights[len(heights) // 2 :]
    np.testing.assert_allclose(deep, DEPTH, rtol=0.05)
    assert valley.memory.jump.numpy().max() < 1e-9  # nothing is allowed for
    # From where it comes to rest on: first it falls by a depth, and what that sets free is damped.
    assert np.ptp(energies[len(heights) // 4 :]) < 0.02 * valley.stiffness * DEPTH**2


@wp.kernel(enable_backward=False)
def find_hollow(
    facets: PlyFacets,
    side: wp.float64,
    way: wp.float64,
    x: wp.array(dtype=wp.vec3d),
    hollows: wp.array(dtype=wp.vec2d),
    points: wp.array(dtype=wp.vec3d),
    found: wp.array(dtype=Hollow),
):
    """Planes of facet 0 and the one across its edge; one thread a point."""
    i = wp.tid()
    nearest = nearest_on_facet(facets, 0, x, points[i])
    own = plane_over(facets, 0, side, wp.float64(6e-4), x, hollows, points[i])
    found[i] = hollow_at(facets, nearest, own, side, way, wp.float64(6e-4), x, hollows, points[i])


SQUARE = 0.02 * np.array([(0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)])


def between(bend, room, point, side=1.0, way=4e-4):
    """Planes of two facets that share the edge along y, bent upwards at it by an angle [rad].

    Args:
        bend: below zero downwards.
        room: at the four vertices, on both sides [m].
        point: the point, or more of them [m].
        side: of the sheet on which it is.
        way: that it may go [m].
    """
    x = SQUARE.copy()
    x[:, 2] = np.abs(x[:, 0]) * np.tan(0.5 * bend)
    facets = build_facets([np.array([(0, 1, 2), (0, 2, 3)])], np.array([0, 4]), "cpu")
    points = wp.array(np.atleast_2d(point), dtype=wp.vec3d, device="cpu")
    found = wp.zeros(len(points), dtype=Hollow, device="cpu")
    rooms = wp.array(np.repeat(np.array(room)[:, None], 2, axis=1), dtype=wp.vec2d, device="cpu")
    at = wp.array(x, dtype=wp.vec3d, device="cpu")
    wp.launch(find_hollow, len(points), [facets, side, way, at, rooms, points, found], device="cpu")
    return found.numpy(), x


def is_found(planes):
    corners = planes["other"]["corners"]
    return corners[:, 0] != corners[:, 1]


NEAR = (1e-5, 2e-3, 5e-4)


@pytest.mark.parametrize(
    ("bend", "room", "side", "expected"),
    [
        (0.2, (0.0, 0.0, 0.0, 0.0), 1.0, True),  # a valley
        (-0.2, (0.0, 0.0, 0.0, 0.0), 1.0, False),  # a crest
        (-0.2, (0.0, 0.0, 0.0, 0.0), -1.0, True),  # which is a valley from below
        (0.0, (0.0, 0.0, 0.0, 0.0), 1.0, False),  # flat
        (0.0, (5e-4, 0.0, 5e-4, 0.0), 1.0, True),  # flat, but room bends the gap
        (0.0, (0.0, 5e-4, 0.0, 5e-4), 1.0, False),  # the other way
        (-0.02, (5e-4, 0.0, 5e-4, 0.0), 1.0, True),  # a crest flatter than room bends it
        (-0.1, (5e-4, 0.0, 5e-4, 0.0), 1.0, False),  # and a steeper one
    ],
)
def test_hollow_is_where_the_gap_grows_less_beyond_an_edge(bend, room, side, expected):
    point = np.array(NEAR) * (1.0, 1.0, side)
    planes, _ = between(bend, room, point, side)
    assert is_found(planes)[0] == expected


def test_a_plane_that_cannot_become_the_nearer_one_is_left_out():
    far = (1.5e-3, 0.0, 1e-3)  # by 1.5 mm · 2 sin 0.1 behind
    assert not is_found(between(0.2, np.zeros(4), far, way=1e-3)[0])[0]
    assert is_found(between(0.2, np.zeros(4), far, way=2e-3)[0])[0]


def test_a_point_that_is_pressed_through_a_valley_is_left_alone():
    assert not is_found(between(0.2, np.zeros(4), (1e-4, 0.0, -2e-4))[0])[0]


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("upwards", [0.1, 0.0])  # in a flat ply the point is beside one facet
def test_planes_are_those_of_both_facets_with_their_room(upwards, side):
    room = np.array((5e-4, 1e-4, 3e-4, 2e-4))
    bend = upwards * side
    step = 1e-6
    points = np.array(
        [
            np.array(NEAR) * (1.0, 1.0, side) + d
            for d in step * np.vstack([np.zeros(3), np.eye(3), -np.eye(3)])
        ]
    )
    planes, x = between(bend, room, points, side)
    assert is_found(planes).all()
    for name, triangle in (("own", (0, 1, 2)), ("other", (0, 2, 3))):
        a, b, c = x[list(triangle)]
        n = side * np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
        weights = np.linalg.lstsq(np.stack([b - a, c - a], axis=1), (points - a).T, rcond=None)[0]
        rooms = room[list(triangle)]
        there = rooms[0] + weights.T @ (rooms[1:] - rooms[0])
        expected = (points - a) @ n - THICKNESS + there
        plane = planes[name]
        np.testing.assert_allclose(plane["gap"], expected, atol=1e-12)
        # Between searches the plane tells the same gap by the place and its normal.
        corners = x[plane["corners"][0]]
        place = plane["weights"][0] @ corners
        kept = (points - place) @ plane["normal"][0] - THICKNESS - plane["rise"][0]
        slope = (expected[1:4] - expected[4:]) / (2.0 * step)
        np.testing.assert_allclose(kept[0], expected[0], atol=1e-12)
        np.testing.assert_allclose(plane["normal"][0], slope / np.linalg.norm(slope), atol=1e-8)
        assert plane["weights"].min() >= 0.0  # the force is borne by the facet itself
