"""What a run computes with: `Model`, fixed arrays, and `State`, what a restart needs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import warp as wp

from warpdrape.contact.ply_facets import build_facets
from warpdrape.contact.tool_arrays import floating_tools, tool_surfaces
from warpdrape.dynamics.selective_mass import SelectiveMass, build_selective_mass
from warpdrape.dynamics.time_step import LumpedMass, lump_masses
from warpdrape.dynamics.timing import Timing, peak_speed, plan_steps
from warpdrape.forces.membrane import Membrane, build_membrane
from warpdrape.kernels.contact.contact import ContactLaw
from warpdrape.kernels.contact.facets import PlyFacets
from warpdrape.kernels.contact.ply_contact import PlyContact, PlyFaces, PlyMemory
from warpdrape.kernels.contact.tool_contact import (
    ToolHold,
    ToolPlane,
    ToolQuery,
    ToolSearch,
    ToolSurfaces,
)
from warpdrape.kernels.dynamics.motion import FloatingTools, Medium
from warpdrape.setup import Setup

SEARCH_BEYOND = 2e-3
"""How far past the near zone a tool query looks [m]; what it finds farther off need not be asked
again until the vertex has come closer."""
PLANE_SERVES = 0.5
"""Way of a vertex along a tool for which its plane serves, in units of `search_slide` [-]."""
FACET_SERVES = 4.0
"""… and for which the nearest facet may, as long as none beside it can have become nearer [-]."""
LOOK_AHEAD = 2.0
"""Time for which a search follows free vertices at their speed, in intervals between searches [-]:
a sheet that snaps gains speed."""
ASK_EVERY = 16
"""Contact searches from one in which every vertex asks for the nearest facet of another ply to the
next such one; between, it walks from the facet that it remembers."""
SELECTIVE = ("w", "mean_w", "power_now", "power_old")
"""Arrays of the state that selective mass scaling needs."""
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
class Model:
    """Everything that stays as it is during a run.

    Attributes:
        scene: what is computed.
        device: Warp device.
        timing: steps.
        membranes: the plies' triangles.
        masses: vertex masses on the host.
        selective: selective mass scaling, None without.
        mass: vertex masses [kg], shape [vertex].
        added_mass: share of them that mass scaling added [kg], shape [vertex].
        offset: half the ply thickness [m], shape [vertex].
        rest: positions at the start [m], shape [vertex].
        clamp: clamp that holds a vertex, −1 if free, shape [vertex].
        facets: the plies' triangles, as contact between plies sees them; empty for a single ply.
        query_meshes: per ply, moved along for contact searches.
        tool_meshes: per tool, in its own frame.
        surfaces: the tools' facets.
        floating: which tools float.
        ply_pairs: directed pairs of plies that may touch.
        contact: the contact law.
        search: how far tool searches look.
        medium: gravity and damping.
    """

    scene: Setup
    device: str
    timing: Timing
    membranes: tuple[Membrane, ...]
    masses: LumpedMass
    selective: SelectiveMass | None
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
    w: wp.array
    mean_w: wp.array
    power_now: wp.array
    power_old: wp.array
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


def build_model(scene: Setup, device: str, frames: int) -> Model:
    """Turn a scene into arrays on a device.

    Args:
        scene: what to compute.
        device: Warp device.
        frames: frames after the first.

    Raises:
        InputError: if the scene asks for a step above the stable one.
    """
    masses = lump_masses(scene)
    timing = plan_steps(scene, masses.stable_step, frames)
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
    tool_meshes, surfaces = tool_surfaces(scene, device)
    return Model(
        scene=scene,
        device=device,
        timing=timing,
        membranes=membranes,
        masses=masses,
        selective=build_selective_mass(scene, masses.mass, masses.scaling, device),
        mass=wp.array(masses.mass, dtype=wp.float64, device=device),
        added_mass=wp.array(masses.added, dtype=wp.float64, device=device),
        offset=wp.array(np.concatenate(half), dtype=wp.float64, device=device),
        rest=wp.array(rest, dtype=wp.vec3d, device=device),
        clamp=wp.array(_clamp_index(scene, vertices), dtype=wp.int32, device=device),
        facets=_ply_facets(scene, vertices, device),
        query_meshes=query_meshes,
        tool_meshes=tool_meshes,
        surfaces=surfaces,
        floating=floating_tools(scene, device),
        ply_pairs=_ply_pairs(scene, query_meshes, vertices, triangles),
        contact=_contact_law(scene, timing),
        search=_tool_search(scene, timing),
        medium=_medium(scene, timing),
    )


def _clamp_index(scene: Setup, first: np.ndarray) -> np.ndarray:
    index = np.full(first[-1], -1)
    names = [ply.name for ply in scene.plies]
    for number, clamp in enumerate(scene.clamps):
        at = names.index(clamp.ply)
        index[first[at] + clamp.vertices(scene.plies[at].rest_points)] = number
    return index


def _ply_facets(scene: Setup, vertices: np.ndarray, device: str) -> PlyFacets:
    if len(scene.plies) == 1:
        return PlyFacets()
    return build_facets([ply.mesh.triangles for ply in scene.plies], vertices, device)


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


def _contact_law(scene: Setup, timing: Timing) -> ContactLaw:
    law = ContactLaw()
    share = scene.numerics.contact_share
    law.stiffness = share / timing.time_step**2
    law.lag = 2.0 * scene.numerics.contact_damping * timing.time_step / math.sqrt(share)
    law.time_step = timing.time_step
    return law


def _tool_search(scene: Setup, timing: Timing) -> ToolSearch:
    thickest = max(ply.fabric.thickness for ply in scene.plies)
    search = ToolSearch()
    search.reach = near_reach(scene)
    search.radius = 0.5 * thickest + search.reach + SEARCH_BEYOND
    search.keep = PLANE_SERVES * scene.numerics.search_slide
    search.trust = FACET_SERVES * scene.numerics.search_slide
    search.ahead = LOOK_AHEAD * timing.search_every * timing.time_step
    search.plain = int(scene.numerics.contact == "exact")
    return search


def near_reach(scene: Setup) -> float:
    """Distance [m] within which a vertex counts as near: four slides, for those that go faster."""
    return 4.0 * scene.numerics.search_slide


def _medium(scene: Setup, timing: Timing) -> Medium:
    medium = Medium()
    medium.gravity = wp.vec3d(*np.asarray(scene.gravity, dtype=float))
    medium.rate = scene.numerics.damping
    medium.time_step = timing.time_step
    medium.speed_limit = max(RUNAWAY * peak_speed(scene), 500.0)
    return medium


def initial_state(model: Model) -> State:
    """Plies flat and at rest, tools where they start."""
    scene, device = model.scene, model.device
    n, tools, clamps = model.mass.shape[0], len(scene.tools), len(scene.clamps)
    slots = sum(len(scene.plies[pair.searching].mesh.vertices) for pair in model.ply_pairs)
    table = model.timing.steps_ahead + 1

    def zeros(shape, dtype) -> wp.array:
        return wp.zeros(shape, dtype=dtype, device=device)

    real, vec = wp.float64, wp.vec3d
    return State(
        x=wp.clone(model.rest),
        v=zeros(n, vec),
        **{name: zeros(n if model.selective else 0, vec) for name in SELECTIVE},
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
