"""What a run computes with: `Model`, fixed arrays, and `State`, what a restart needs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import warp as wp

from warpdrape.errors import InputError
from warpdrape.kernels.contact import ContactLaw
from warpdrape.kernels.facets import PlyFacets
from warpdrape.kernels.motion import FloatingTools, Medium
from warpdrape.kernels.ply_contact import PlyContact, PlyFaces, PlyMemory
from warpdrape.kernels.tool_contact import (
    ToolHold,
    ToolPlane,
    ToolQuery,
    ToolSearch,
    ToolSurfaces,
)
from warpdrape.membrane import Membrane, build_membrane
from warpdrape.motion import Float
from warpdrape.ply_facets import build_facets, facet_hollows, open_edge_bits
from warpdrape.scene import Scene
from warpdrape.time_step import LumpedMass, choose_step, lump_masses
from warpdrape.tool import Tool

SEARCH_BEYOND = 2e-3
"""How far past the near zone a tool query looks [m]; what it finds farther off need not be asked
again until the vertex has come closer."""
PLANE_SERVES = 0.5
"""Way of a vertex along a tool for which its plane serves, in units of `search_slide` [-]."""
FACET_SERVES = 4.0
"""… and for which the nearest facet may, as long as none beside it can have become nearer [-]."""
ASK_EVERY = 16
"""Contact searches from one in which every vertex asks for the nearest facet of another ply to the
next such one; between, it walks from the facet that it remembers."""
SLOWEST_TOOL = 0.1
"""Speed [m/s] that contact searches allow for at least, as plies may move faster than tools."""
SLOWEST = 1.0
"""Speed [m/s] that contact searches allow for when no tool moves."""
RUNAWAY = 100.0
"""Vertex speed over the tools' that counts as blown up [-], but not below 500 m/s."""


@dataclass(frozen=True, eq=False)
class PlyPair:
    """Vertices of one ply that may meet the triangles of another.

    Attributes:
        searching: index of the ply whose vertices are looked at.
        searched: index of the ply whose triangles are.
        first_slot: where these contacts begin.
        faces: the searched ply for the kernels.
    """

    searching: int
    searched: int
    first_slot: int
    faces: PlyFaces


@dataclass(frozen=True, eq=False)
class Timing:
    """Steps of a run.

    Attributes:
        time_step: Δt [s].
        stable_step: largest stable step [s].
        search_every: steps between two contact searches.
        frames: frames after the first.
        steps_per_frame: a multiple of ``search_every``.
    """

    time_step: float
    stable_step: float
    search_every: int
    frames: int
    steps_per_frame: int

    @property
    def steps(self) -> int:
        """Steps in all."""
        return self.frames * self.steps_per_frame


@dataclass(frozen=True, eq=False)
class Model:
    """Everything that stays as it is during a run.

    Attributes:
        scene: what is computed.
        device: Warp device.
        timing: steps.
        membranes: the plies' triangles.
        masses: vertex masses on the host.
        mass: vertex masses [kg], shape [vertex].
        added_mass: share of them that mass scaling added [kg], shape [vertex].
        offset: half the ply thickness [m], shape [vertex].
        rest: positions at the start [m], shape [vertex].
        clamp: clamp that holds a vertex, −1 if free, shape [vertex].
        facets: the plies' triangles, as contact between plies sees them.
        query_meshes: per ply, moved along for contact searches.
        tool_meshes: per tool, in its own frame.
        surfaces: the tools' facets.
        floating: which tools float.
        ply_pairs: directed pairs of plies that may touch.
        contact: the contact law.
        search: how far tool searches look.
        medium: gravity and damping.
    """

    scene: Scene
    device: str
    timing: Timing
    membranes: tuple[Membrane, ...]
    masses: LumpedMass
    mass: wp.array
    added_mass: wp.array
    offset: wp.array
    rest: wp.array
    clamp: wp.array
    facets: PlyFacets
    query_meshes: tuple[wp.Mesh, ...]
    tool_meshes: tuple[wp.Mesh, ...]
    surfaces: ToolSurfaces
    floating: FloatingTools
    ply_pairs: tuple[PlyPair, ...]
    contact: ContactLaw
    search: ToolSearch
    medium: Medium


@dataclass(frozen=True, eq=False)
class State:
    """Everything that a run changes; see the kernels for shapes and units."""

    x: wp.array
    v: wp.array
    f: wp.array
    step: wp.array
    runaway: wp.array
    normals: wp.array
    hollows: wp.array
    lost: wp.array
    tool_shift: wp.array
    tool_velocity: wp.array
    reaction: wp.array
    impulse: wp.array
    tool_work: wp.array
    tool_damped: wp.array
    tool_planes: wp.array
    tool_queries: wp.array
    tool_touching: wp.array
    tool_holds: wp.array
    tool_deepest: wp.array
    ply_memory: wp.array
    ply_contacts: wp.array
    ply_springs: wp.array
    ply_dashpots: wp.array
    ply_stored: wp.array
    ply_slip: wp.array
    ply_deepest: wp.array
    ply_jump: wp.array
    clamp_work: wp.array
    clamp_force: wp.array
    tool_path: wp.array
    tool_force: wp.array
    clamp_matrix: wp.array
    clamp_shift: wp.array


def build_model(scene: Scene, device: str, frames: int) -> Model:
    """Turn a scene into arrays on a device.

    Args:
        scene: what to compute.
        device: Warp device.
        frames: frames after the first.

    Raises:
        InputError: if the scene asks for a step above the stable one.
    """
    masses = lump_masses(scene)
    timing = _timing(scene, choose_step(scene, masses.stable_step), masses.stable_step, frames)
    rest = np.concatenate([ply.rest_points for ply in scene.plies])
    vertices = np.cumsum([0, *(len(ply.mesh.vertices) for ply in scene.plies)])
    triangles = np.cumsum([0, *(len(ply.mesh.triangles) for ply in scene.plies)])
    membranes = tuple(
        build_membrane(ply, scene.numerics, int(v), int(t), device)
        for ply, v, t in zip(scene.plies, vertices, triangles, strict=False)
    )
    half = [np.full(len(p.mesh.vertices), 0.5 * p.fabric.thickness) for p in scene.plies]
    query_meshes = tuple(
        wp.Mesh(
            wp.array(ply.rest_points, dtype=wp.vec3f, device=device),
            wp.array(np.ravel(ply.mesh.triangles), dtype=wp.int32, device=device),
        )
        for ply in scene.plies
    )
    tool_meshes, surfaces = _tool_surfaces(scene, device)
    return Model(
        scene=scene,
        device=device,
        timing=timing,
        membranes=membranes,
        masses=masses,
        mass=wp.array(masses.mass, dtype=wp.float64, device=device),
        added_mass=wp.array(masses.added, dtype=wp.float64, device=device),
        offset=wp.array(np.concatenate(half), dtype=wp.float64, device=device),
        rest=wp.array(rest, dtype=wp.vec3d, device=device),
        clamp=wp.array(_clamp_index(scene, vertices), dtype=wp.int32, device=device),
        facets=build_facets([ply.mesh.triangles for ply in scene.plies], vertices, device),
        query_meshes=query_meshes,
        tool_meshes=tool_meshes,
        surfaces=surfaces,
        floating=_floating(scene, device),
        ply_pairs=_ply_pairs(scene, query_meshes, vertices, triangles),
        contact=_contact_law(scene, timing),
        search=_tool_search(scene),
        medium=_medium(scene, timing),
    )


def _peak_speed(scene: Scene) -> float:
    moving = [thing.motion.peak_speed for thing in (*scene.tools, *scene.clamps)]
    return max([*moving, SLOWEST_TOOL]) if any(moving) else SLOWEST


def _timing(scene: Scene, step: float, stable: float, frames: int) -> Timing:
    per_search = math.floor(scene.numerics.search_slide / (_peak_speed(scene) * step))
    every = 1 if scene.numerics.contact == "exact" else min(max(per_search, 1), 256)
    per_frame = every * math.ceil(scene.duration / (frames * every * step))
    return Timing(scene.duration / (frames * per_frame), stable, every, frames, per_frame)


def _clamp_index(scene: Scene, first: np.ndarray) -> np.ndarray:
    index = np.full(first[-1], -1)
    names = [ply.name for ply in scene.plies]
    for number, clamp in enumerate(scene.clamps):
        at = names.index(clamp.ply)
        index[first[at] + clamp.vertices(scene.plies[at].rest_points)] = number
    return index


def _tool_surfaces(scene: Scene, device: str) -> tuple[tuple[wp.Mesh, ...], ToolSurfaces]:
    meshes = tuple(
        wp.Mesh(
            wp.array(tool.vertices, dtype=wp.vec3f, device=device),
            wp.array(np.ravel(tool.triangles), dtype=wp.int32, device=device),
        )
        for tool in scene.tools
    )
    facets = [len(tool.triangles) for tool in scene.tools]
    corners = [tool.vertices[tool.triangles] for tool in scene.tools]
    normals = [tool.surface.normals for tool in scene.tools]
    friction = [scene.friction if t.friction is None else t.friction for t in scene.tools]
    empty = [np.zeros((0, 3, 3))]
    surfaces = ToolSurfaces()
    surfaces.meshes = wp.array([mesh.id for mesh in meshes], dtype=wp.uint64, device=device)
    first = np.cumsum([0, *facets])[:-1]
    surfaces.first_facet = wp.array(first, dtype=wp.int32, device=device)
    surfaces.corners = wp.array(np.concatenate(corners or empty), dtype=wp.vec3d, device=device)
    surfaces.normals = wp.array(np.concatenate(normals or empty), dtype=wp.vec3d, device=device)
    open_edges = [open_edge_bits(tool.triangles) for tool in scene.tools] or [np.zeros(0)]
    surfaces.open_edges = wp.array(np.concatenate(open_edges), dtype=wp.int32, device=device)
    sag = [largest_sag(tool) for tool in scene.tools]
    surfaces.sag = wp.array(sag, dtype=wp.float64, device=device)
    hollow = [facet_hollows(tool.vertices, tool.triangles) for tool in scene.tools]
    hollow = np.concatenate(hollow or [np.zeros(0)])
    surfaces.hollow = wp.array(hollow, dtype=wp.float64, device=device)
    exact = [tool.surface.exact for tool in scene.tools]
    surfaces.exact = wp.array(exact, dtype=wp.int32, device=device)
    surfaces.friction = wp.array(friction, dtype=wp.float64, device=device)
    return meshes, surfaces


def largest_sag(tool: Tool) -> float:
    """Bound on the height of a tool's curved surface over its facets [m].

    Over a facet it is Σ w_i w_j c_ij, with c = ½ (x_i − x_j)·(n_i − n_j) along each edge, and the
    products of the weights add up to a third at most.
    """
    if not tool.surface.exact:
        return 0.0
    corners, normals = tool.vertices[tool.triangles], tool.surface.normals
    turned = np.roll(corners, 1, axis=1) - corners, np.roll(normals, 1, axis=1) - normals
    return float(np.abs((turned[0] * turned[1]).sum(axis=2)).max() / 6.0)


def _floating(scene: Scene, device: str) -> FloatingTools:
    floats = [isinstance(tool.motion, Float) for tool in scene.tools]
    motions = [tool.motion if f else None for tool, f in zip(scene.tools, floats, strict=True)]
    floating = FloatingTools()
    floating.floats = wp.array(floats, dtype=wp.int32, device=device)
    axes = [m.axis if m else (0.0, 0.0, 1.0) for m in motions]
    floating.axis = wp.array(np.reshape(axes, (-1, 3)), dtype=wp.vec3d, device=device)
    floating.mass = wp.array(
        [m.mass if m else 1.0 for m in motions], dtype=wp.float64, device=device
    )
    damping = [m.damping if m else 0.0 for m in motions]
    floating.damping = wp.array(damping, dtype=wp.float64, device=device)
    return floating


def _ply_pairs(scene, query_meshes, vertices, triangles) -> tuple[PlyPair, ...]:
    pairs, slot = [], 0
    for searching, ply in enumerate(scene.plies):
        for searched, other in enumerate(scene.plies):
            if searching == searched:
                continue
            faces = PlyFaces()
            faces.mesh = query_meshes[searched].id
            faces.first_triangle = int(triangles[searched])
            faces.side = 1.0 if searching > searched else -1.0
            faces.thickness = 0.5 * (ply.fabric.thickness + other.fabric.thickness)
            pairs.append(PlyPair(searching, searched, slot, faces))
            slot += len(ply.mesh.vertices)
    return tuple(pairs)


def _contact_law(scene: Scene, timing: Timing) -> ContactLaw:
    law = ContactLaw()
    share = scene.numerics.contact_share
    law.stiffness = share / timing.time_step**2
    law.lag = 2.0 * scene.numerics.contact_damping * timing.time_step / math.sqrt(share)
    law.time_step = timing.time_step
    return law


def _tool_search(scene: Scene) -> ToolSearch:
    thickest = max(ply.fabric.thickness for ply in scene.plies)
    search = ToolSearch()
    search.reach = near_reach(scene)
    search.radius = 0.5 * thickest + search.reach + SEARCH_BEYOND
    search.keep = PLANE_SERVES * scene.numerics.search_slide
    search.trust = FACET_SERVES * scene.numerics.search_slide
    search.plain = int(scene.numerics.contact == "exact")
    return search


def near_reach(scene: Scene) -> float:
    """Distance [m] within which a vertex counts as near: four slides, for those that go faster."""
    return 4.0 * scene.numerics.search_slide


def _medium(scene: Scene, timing: Timing) -> Medium:
    medium = Medium()
    medium.gravity = wp.vec3d(*np.asarray(scene.gravity, dtype=float))
    medium.rate = scene.numerics.damping
    medium.time_step = timing.time_step
    medium.speed_limit = max(RUNAWAY * _peak_speed(scene), 500.0)
    return medium


def initial_state(model: Model) -> State:
    """Plies flat and at rest, tools where they start."""
    scene, device = model.scene, model.device
    n, tools, clamps = model.mass.shape[0], len(scene.tools), len(scene.clamps)
    slots = sum(len(scene.plies[pair.searching].mesh.vertices) for pair in model.ply_pairs)
    table = model.timing.steps_per_frame + 1

    def zeros(shape, dtype) -> wp.array:
        return wp.zeros(shape, dtype=dtype, device=device)

    real, vec = wp.float64, wp.vec3d
    return State(
        x=wp.clone(model.rest),
        v=zeros(n, vec),
        f=zeros(n, vec),
        step=zeros(1, wp.int32),
        runaway=wp.full(1, -1, dtype=wp.int32, device=device),
        normals=zeros(n, vec),
        hollows=zeros(n, wp.vec2d),
        lost=zeros(n, vec),
        tool_shift=zeros(tools, vec),
        tool_velocity=zeros(tools, vec),
        reaction=zeros(tools, vec),
        impulse=zeros(tools, vec),
        tool_work=zeros(tools, real),
        tool_damped=zeros(tools, real),
        tool_planes=zeros(tools * n, ToolPlane),
        tool_queries=_nothing_asked(tools * n, device),
        tool_touching=zeros(n, wp.int32),
        tool_holds=zeros(tools * n, ToolHold),
        tool_deepest=zeros(tools, real),
        ply_memory=zeros(slots, PlyMemory),
        ply_contacts=zeros(slots, PlyContact),
        ply_springs=zeros(slots, vec),
        ply_dashpots=zeros(slots, real),
        ply_stored=zeros(slots, real),
        ply_slip=zeros(slots, real),
        ply_deepest=zeros(len(model.ply_pairs), real),
        ply_jump=zeros(len(model.ply_pairs), real),
        clamp_work=zeros(n, real),
        clamp_force=zeros(clamps, vec),
        tool_path=zeros((tools, table), vec),
        tool_force=zeros((tools, table), real),
        clamp_matrix=zeros(clamps * table, wp.mat33d),
        clamp_shift=zeros(clamps * table, vec),
    )


def _nothing_asked(slots: int, device: str) -> wp.array:
    """Queries that leave no vertex a way to move before it is asked, shape [slot]."""
    queries = np.zeros(slots, dtype=ToolQuery.numpy_dtype())
    queries["distance"] = math.inf
    queries["facet"] = -1
    return wp.array(queries, dtype=ToolQuery, device=device)


def check_device(device: str) -> str:
    """Return a device that exists.

    Raises:
        InputError: if it does not, naming those that do.
    """
    known = [d.alias for d in wp.get_devices()]
    if device not in known:
        raise InputError(f"no device {device!r} here; there is: {', '.join(known)}")
    return device
