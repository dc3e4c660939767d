"""Runs of strips that bend, against the elastica and the law, on meshes of every kind."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
import trimesh
from scipy.interpolate import PchipInterpolator

from warpdrape import Bending, BendingCurve, Clamp, Numerics, Path, Ply, Scene
from warpdrape.coupons.closed_forms import heavy_cantilever
from warpdrape.dynamics.energy import measure
from warpdrape.dynamics.model import Model, build_model, initial_state
from warpdrape.dynamics.partition import split
from warpdrape.forces.bending_curve import BendingCurves
from warpdrape.results.result import FormedPly
from warpdrape.verification.case import CaseResult, absolute, relative
from warpdrape.verification.plates import LENGTH, MESHES, STIFFNESS, beams, mesh_of, plates
from warpdrape.verification.strip import yarn_fabric

STRETCH = 2e4
"""Line stiffness of its yarns [N/m]: as if √(12 B/EA) = 0.24 mm thick, so that they do not show."""
IN_PLANE = (("diagonal", None), ("crossed", 0.06), ("random", 0.04))
"""Meshes of strips bent in their plane, and the errors known of those that miss the limit."""


def bending(quick: bool) -> Iterator[CaseResult]:
    """All cases of bending."""
    yield from plates(quick)
    yield from beams(quick)
    yield from cantilevers(quick)
    yield from fold()
    yield from curves()


def cantilever_scene(kind: str, load: float, cells: int, *, in_plane: bool = False) -> Scene:
    """A strip clamped at one end under its weight, w L³/B = load; settles by damping.

    In its plane a strip whose yarns slide past each other freely is a sheaf of elasticas.

    Args:
        kind: of mesh.
        load: w L³/B [-].
        cells: edges along the strip.
        in_plane: weight along the strip's plane, across it, in place of normal to it.
    """
    weight = load * STIFFNESS / LENGTH**3
    density = weight / 9.81
    cloth = replace(
        yarn_fabric(STRETCH, density, 0.0 if in_plane else None),
        bending=Bending(warp=STIFFNESS, weft=STIFFNESS),
    )
    mesh = mesh_of(kind, LENGTH, 0.125 * LENGTH, LENGTH / cells)
    lowest = 3.516 * math.sqrt(STIFFNESS / density) / LENGTH**2
    clamp = Clamp(name="root", ply="strip", where=lambda p: p[:, 0] < -0.5 * LENGTH + 1e-9)
    return Scene(
        name="cantilever",
        plies=[Ply(name="strip", fabric=cloth, mesh=mesh)],
        clamps=[clamp],
        duration=10.0 / lowest,
        gravity=(0.0, -9.81, 0.0) if in_plane else (0.0, 0.0, -9.81),
        numerics=Numerics(damping=2.0 * lowest),
    )


def tip(scene: Scene) -> tuple[float, float]:
    """Drop and reach of a cantilever's tip over its length, once it has come to rest."""
    formed = scene.run(frames=4, threads=1).plies[0]
    end = formed.rest_points[:, 0] > 0.5 * LENGTH - 1e-9
    moved = (formed.points - formed.rest_points)[end].mean(axis=0)
    down = np.asarray(scene.gravity) / np.linalg.norm(scene.gravity)
    return float(moved @ down) / LENGTH, 1.0 + float(moved[0]) / LENGTH


def cantilevers(quick: bool) -> Iterator[CaseResult]:
    """Heavy cantilevers against the elastica, out of the strip's plane and in it.

    In the plane only meshes whose edges follow both yarns are within the limit: on others a row of
    inextensible weft yarns cannot be a parabola between vertices, see docs/verification.md.
    """
    loads, kinds = ((8.0,), MESHES[2:3]) if quick else ((1.0, 8.0, 20.0), MESHES)
    cells, limit = (16, 0.02) if quick else (32, 0.01)
    fine: dict[str, float] = {}
    for load in loads:
        for kind in kinds:
            drop, reach = _beside_elastica(kind, load, cells, limit)
            if load == 8.0:
                fine[kind] = drop.error
            yield from (drop, reach)
    for kind, known in IN_PLANE[:1] if quick else IN_PLANE:
        yield from _beside_elastica(kind, 8.0, cells, limit, in_plane=True, known=known)
    if not quick:
        yield from _rates(fine, 8.0, cells // 2)


def _rates(fine: Mapping[str, float], load: float, cells: int) -> Iterator[CaseResult]:
    """At what rate the error of the drop has fallen from a mesh half as fine, by kind of mesh."""
    for kind, error in fine.items():
        coarse = next(_beside_elastica(kind, load, cells, 1.0)).error
        rate = math.log2(coarse / error)
        name = f"cantilever, w L³/B = {load:g}, {kind}: rate of the drop, at least 1.5"
        yield absolute(name, min(rate, 1.5), 1.5, 0)


def _beside_elastica(
    kind: str,
    load: float,
    cells: int,
    limit: float,
    *,
    in_plane: bool = False,
    known: float | None = None,
) -> Iterator[CaseResult]:
    found = tip(cantilever_scene(kind, load, cells, in_plane=in_plane))
    way = "in its plane, " if in_plane else ""
    for name, value, true in zip(("drop", "reach"), found, heavy_cantilever(load), strict=True):
        case = f"cantilever, {way}w L³/B = {load:g}, {kind}, h = L/{cells}: {name}/L"
        yield relative(case, value, true, limit, known=known)


FREE_EDGES = 9
"""Edges of the mesh round the fold: its radius is 9/π = 2.9 of them."""


def fold() -> Iterator[CaseResult]:
    """A strip folded back on itself between two clamps, one of which turns over: no triangle flips.

    The clamp goes round half a circle and turns by 180°, so that the strip stays about as long.
    """
    cells, duration = 25, 0.2
    edge = LENGTH / cells
    cloth = replace(yarn_fabric(STRETCH, 0.2), bending=Bending(warp=STIFFNESS, weft=STIFFNESS))
    mesh = mesh_of("crossed", LENGTH, 4 * edge, edge)
    free = FREE_EDGES * edge

    def turning(times: np.ndarray) -> np.ndarray:
        angle = math.pi * _smooth(times / duration)
        c, s, o, i = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
        return np.moveaxis(np.array([[c, o, -s], [o, i, o], [s, o, c]]), 2, 0)

    def path(times: np.ndarray) -> np.ndarray:
        """Way of the clamp's edge, less what its turning does: the arc of the free length."""
        angle = math.pi * _smooth(times / duration)
        safe = np.maximum(angle, 1e-9)
        x, z = free * np.sinc(angle / math.pi), free * (1.0 - np.cos(angle)) / safe
        turned = 0.5 * free * np.cos(angle), 0.5 * free * np.sin(angle)  # by the matrix
        return np.column_stack([x - 0.5 * free - turned[0], np.zeros_like(x), z - turned[1]])

    times = np.linspace(0.0, duration, 401)
    held = [
        Clamp(name="base", ply="strip", where=lambda p: p[:, 0] < -0.5 * free + 1e-9),
        Clamp(
            name="turning",
            ply="strip",
            where=lambda p: p[:, 0] > 0.5 * free - 1e-9,
            matrix=turning,
            motion=Path(times=times.tolist(), positions=path(times).tolist()),
        ),
    ]
    scene = Scene(
        name="fold",
        plies=[Ply(name="strip", fabric=cloth, mesh=mesh)],
        clamps=held,
        duration=duration,
        gravity=(0.0, 0.0, 0.0),
        numerics=Numerics(damping=50.0),
    )
    result = scene.run(frames=40, threads=1)
    stored, formed = result.history["bending_j"], result.plies[0]
    fallen = float(np.maximum(-np.diff(stored), 0.0).sum() / stored.max())
    yield absolute(
        "strip folded to a radius of 2.9 h: bending energy lost on the way", fallen, 0, 0.01
    )
    exact = 0.5 * STIFFNESS * math.pi**2 / free * 4 * edge  # ½ B κ² over length and width
    yield relative("… its energy over that of a half circle", stored[-1], exact, 0.05, unit="J")
    yield absolute("… largest angle between neighbouring triangles", _sharpest(formed), 0, 0.5)
    yield absolute("… energy error", result.summary["energy_error"], 0, 0.01)


def _smooth(share: np.ndarray) -> np.ndarray:
    share = np.clip(share, 0.0, 1.0)
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)


def _sharpest(ply: FormedPly) -> float:
    """Largest angle between the normals of triangles that share an edge [rad]."""
    surface = trimesh.Trimesh(ply.points, ply.triangles, process=False)
    return float(surface.face_adjacency_angles.max())


CURVE = BendingCurve(
    curvatures=(0.0, 2.294, 2.929, 4.466, 6.582, 10.757, 17.665),
    moments_warp=(0.0, 0.2735, 0.2969, 0.3165, 0.3321, 0.3516, 0.3751),
    moments_weft=(0.0, 0.2735, 0.2969, 0.3165, 0.3321, 0.3516, 0.3751),
    friction=(0.05, 0.05),
    friction_curvature=1.0,
)
"""Points of a binder-stabilised fabric's curve (Broberg et al.); the friction is made up."""
LARGEST = 8.0
"""Curvature of the loop [1/m]."""


def curves() -> Iterator[CaseResult]:
    """A ply bent to and fro on cylinders: its moment, and the loop of the friction."""
    side, angle = 0.1, np.linspace(0.0, 4.5 * math.pi, 1801)
    cloth = replace(yarn_fabric(STRETCH, 0.3), bending=CURVE)
    ply = Ply(name="ply", fabric=cloth, mesh=mesh_of("random", side, side, side / 12))
    scene = Scene(name="loop", plies=[ply], duration=1e-3, gravity=(0.0, 0.0, 0.0))
    model = build_model(scene, "cpu", 1)
    state = initial_state(model)
    (whole,) = split(model, state, 1)
    flat, lost, stored = ply.rest_points, [], []
    for curvature in LARGEST * np.sin(angle):
        turn = curvature * flat[:, 0]
        radius = 1.0 / curvature if curvature else 1e12
        x = np.column_stack(
            [radius * np.sin(turn), flat[:, 1], 2.0 * radius * np.sin(turn / 2) ** 2]
        )
        state.plies.x.assign(x if curvature else flat)
        for launch in whole.launches.scatter:
            launch(model.device)
        shown = measure(model, state)[model.forces.index(_curve_of(model))]
        lost.append(shown.lost["fibre_friction"] / side**2)
        stored.append(shown.stored["bending_curves"] / side**2)
    way = np.linspace(0.0, 2.0 * LARGEST, 100_001)
    moment = CURVE.friction[0] * (1.0 - 2.0 * np.exp(-way / CURVE.friction_curvature))
    exact = 2.0 * float(np.trapezoid(moment, way))
    yield relative(
        "loop of M(κ) with fibre friction: its area", lost[1800] - lost[1000], exact, 0.01, "N/m"
    )
    at, moments = np.array(CURVE.curvatures), np.array(CURVE.moments_warp)
    spring = 0.5 * CURVE.friction[0] ** 2 / CURVE.onset[0]
    energy = PchipInterpolator(at, moments).antiderivative()(LARGEST) + spring
    yield relative(
        "energy stored at the end of it, by the curve", stored[-1], float(energy), 0.01, "N/m"
    )


def _curve_of(model: Model) -> BendingCurves:
    (found,) = (force for force in model.forces if isinstance(force, BendingCurves))
    return found
