"""Bending against the elastica, plates and beams in closed form, on meshes of every kind."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import trimesh
from scipy import sparse
from scipy.sparse.linalg import eigsh, spsolve

from warpdrape import Bending, Clamp, Numerics, Path, Ply, Scene
from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.meshing import mesh_outline
from warpdrape.blanks.outlines import Rectangle
from warpdrape.coupons.closed_forms import heavy_cantilever
from warpdrape.forces.curvature import CurvatureOperator, curvature_operator
from warpdrape.results.result import FormedPly
from warpdrape.verification.case import CaseResult, absolute, relative
from warpdrape.verification.strip import yarn_fabric

STIFFNESS = 1e-4
"""Bending stiffness of the strips [N·m]."""
LENGTH = 0.1
"""Of a strip [m]."""
STRETCH = 2e4
"""Line stiffness of its yarns [N/m]: as if √(12 B/EA) = 0.24 mm thick, so that they do not show."""
MESHES = ("diagonal", "crossed", "random", "turned 15°", "turned 22.5°")


def bending(quick: bool) -> Iterator[CaseResult]:
    """All cases of bending."""
    yield from plates(quick)
    yield from beams(quick)
    yield from cantilevers(quick)
    yield from fold()


IN_PLANE = (("diagonal", None), ("crossed", 0.06), ("random", 0.04))
"""Meshes of strips bent in their plane, and the errors known of those that miss the limit."""


def mesh_of(kind: str, width: float, height: float, edge: float) -> FlatMesh:
    """A rectangle centred at the origin, meshed one way with edges of about one length [m]."""
    outline = Rectangle(width, height)
    name, _, angle = kind.rstrip("°").partition(" ")
    if angle:
        turn = math.radians(float(angle))
        return mesh_outline(outline, edge=edge, pattern="aligned", warp_angle=turn)
    pattern = "aligned" if name == "crossed" else name
    return mesh_outline(outline, edge=edge, pattern=pattern)


def _operator(
    mesh: FlatMesh, held: np.ndarray | None = None, angle: float = 0.0
) -> CurvatureOperator:
    c, s = math.cos(angle), math.sin(angle)
    directions = np.array([c, s]), np.array([-s, c])
    return curvature_operator(
        np.asarray(mesh.vertices), np.asarray(mesh.triangles), directions, held
    )


def plates(quick: bool) -> Iterator[CaseResult]:
    """Frequencies of a square plate, D = 1, ρ = 1, of side 1: supported, clamped and free.

    Clamped and free (ν = 0.3): Leissa, Vibration of Plates, NASA SP-160, 1969.
    """
    exact = sorted(math.pi**2 * (m * m + n * n) for m in range(1, 4) for n in range(1, 4))[:4]
    moduli = Bending.isotropic(1.0).moduli
    for kind in MESHES[1:3] if quick else MESHES:
        mesh = mesh_of(kind, 1.0, 1.0, 1.0 / 24)
        mass = np.asarray(mesh.vertex_areas)
        border = np.abs(np.asarray(mesh.vertices)).max(axis=1) > 0.5 - 1e-9
        inner = np.flatnonzero(~border)
        matrix, _, _ = _operator(mesh).stiffness(moduli)
        found = _frequencies(matrix[inner][:, inner], mass[inner], 4)
        worst = found[np.argmax(np.abs(found / exact - 1.0))]
        reference = exact[int(np.argmin(np.abs(np.array(exact) / worst - 1.0)))]
        yield relative(
            f"supported plate, {kind}, h = L/24: worst of four frequencies", worst, reference, 0.02
        )
        solid, _, _ = _operator(mesh).stiffness(Bending.isotropic(1.0, 0.3).moduli)
        free = _frequencies(solid, mass, 4, shift=1.0)
        yield absolute(
            f"free plate, {kind}: third over fourth frequency", free[2] / free[3], 0, 1e-3
        )
        yield relative(f"free plate, {kind}, ν = 0.3: fourth frequency", free[3], 13.47, 0.02)
        held = np.where(border, 0, -1)
        clamped, _, _ = _operator(mesh, held).stiffness(moduli)
        first = _frequencies(clamped[inner][:, inner], mass[inner], 1)[0]
        yield relative(f"clamped plate, {kind}: first frequency", first, 35.985, 0.02)


def _frequencies(
    matrix: sparse.csr_matrix, mass: np.ndarray, count: int, shift: float = 0.0
) -> np.ndarray:
    """Lowest frequencies ω [rad/s]; with a shift [1/s²] where the matrix is singular."""
    root = sparse.diags(1.0 / np.sqrt(mass))
    scaled = (root @ matrix @ root + shift * sparse.identity(len(mass))).tocsc()
    values = eigsh(scaled, count, sigma=0.0, which="LM", return_eigenvectors=False) - shift
    return np.sqrt(np.maximum(np.sort(values), 0.0))


def beams(quick: bool) -> Iterator[CaseResult]:
    """Strips in small deflections: buckling, yarns at an angle, and a layer of sheared yarns."""
    for kind in MESHES[1:3] if quick else MESHES:
        mesh = mesh_of(kind, LENGTH, 0.25 * LENGTH, LENGTH / 24)
        yield relative(
            f"buckling load of a pinned strip, {kind}",
            _buckling(mesh),
            STIFFNESS * (math.pi / LENGTH) ** 2,
            0.02,
            unit="N/m",
        )
    uneven = Bending(warp=STIFFNESS, weft=0.3 * STIFFNESS)
    for angle in (0.0, 30.0, 45.0, 90.0):
        coarse, fine = (
            mesh_of(kind, LENGTH, 0.2 * LENGTH, edge)
            for kind, edge in (("random", LENGTH / 32), ("crossed", LENGTH / 160))
        )
        found, exact = (_tip(mesh, uneven, math.radians(angle)) for mesh in (coarse, fine))
        yield relative(f"tip of a strip, yarns at {angle:g}° to it", found, exact, 0.01, unit="m")
    for kind in MESHES[1:3] if quick else MESHES:
        measured, exact = _sheared_layer(kind)
        yield relative(
            f"yarns bent in the plane, {kind}: shear at the middle of a layer",
            measured,
            exact,
            0.01,
        )


def _buckling(mesh: FlatMesh) -> float:
    """Compression [N/m] at which a strip on two hinges buckles."""
    points, triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    moduli = Bending(warp=STIFFNESS, weft=STIFFNESS).moduli
    matrix, _, _ = _operator(mesh).stiffness(moduli)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    slope = np.column_stack([(b - c)[:, 1], (c - a)[:, 1], (a - b)[:, 1]])
    areas = np.asarray(mesh.areas)
    rows = np.repeat(np.arange(len(triangles)), 3)
    gradient = sparse.csr_matrix(
        ((slope / (2.0 * areas[:, None])).ravel(), (rows, triangles.ravel())),
        shape=(len(triangles), len(points)),
    )
    softening = gradient.T @ sparse.diags(areas) @ gradient  # of compression along x
    free = np.flatnonzero(np.abs(points[:, 0]) < 0.5 * LENGTH - 1e-9)
    inner = matrix[free][:, free].tocsc(), softening[free][:, free].tocsc()
    # softening is singular (motions along y alone): solve for its inverse
    found = eigsh(inner[1], 1, inner[0], which="LM", return_eigenvectors=False)
    return 1.0 / float(found[0])


def _tip(mesh: FlatMesh, bending: Bending, angle: float) -> float:
    """Tip's deflection [m] of a strip clamped at one end under 1 N/m² across it."""
    points = np.asarray(mesh.vertices)
    root = points[:, 0] < -0.5 * LENGTH + 1e-9
    operator = _operator(mesh, np.where(root, 0, -1), angle)
    matrix, _, _ = operator.stiffness(bending.moduli)
    free = np.flatnonzero(~root)
    deflection = spsolve(matrix[free][:, free].tocsc(), np.asarray(mesh.vertex_areas)[free])
    return float(deflection[points[free, 0] > 0.5 * LENGTH - 1e-9].mean())


def _sheared_layer(kind: str) -> tuple[float, float]:
    """Shear at the middle of a layer whose two clamps move past each other, over their way.

    Yarns across the layer bend within the ply where they leave the clamps: C u'' = B_g u'''', so
    that u' = γ0 (1 − cosh(y/ℓ)/cosh(H/2ℓ)), ℓ = √(B_g/C): the transition zone of a bias test.
    """
    height, width, share = 0.05, 0.1, 0.15
    length = share * height
    mesh = mesh_of(kind, width, height, height / 24)
    points, triangles = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    top, bottom = (side * points[:, 1] > 0.5 * height - 1e-9 for side in (1.0, -1.0))
    held = np.where(top | bottom, 0, -1)
    operator = _operator(mesh, held)
    matrix, _, _ = operator.stiffness(np.diag([0.0, length**2, 0.0]))  # over C
    a, b, c = (points[triangles[:, k]] for k in range(3))
    areas = np.asarray(mesh.areas)
    slope = np.column_stack([(c - b)[:, 0], (a - c)[:, 0], (b - a)[:, 0]]) / (2.0 * areas[:, None])
    rows = np.repeat(np.arange(len(triangles)), 3)
    gradient = sparse.csr_matrix(
        (slope.ravel(), (rows, triangles.ravel())), shape=(len(triangles), len(points))
    )
    whole = (matrix + gradient.T @ sparse.diags(areas) @ gradient).tocsc()
    u = np.where(top, height, 0.0)
    free = np.flatnonzero(~(top | bottom))
    u[free] = spsolve(whole[free][:, free], -(whole[free] @ u))
    middle = np.abs(points[triangles].mean(axis=1)[:, 1]) < 0.1 * height
    half = 0.5 / share
    at = points[triangles].mean(axis=1)[middle, 1] / length
    first = 1.0 / (1.0 - math.tanh(half) / half)
    exact = first * (1.0 - np.cosh(at) / math.cosh(half))
    weight = areas[middle] / areas[middle].sum()
    return float((gradient @ u)[middle] @ weight), float(exact @ weight)


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
    for load in loads:
        for kind in kinds:
            yield from _beside_elastica(kind, load, cells, limit)
    for kind, known in IN_PLANE[:1] if quick else IN_PLANE:
        yield from _beside_elastica(kind, 8.0, cells, limit, in_plane=True, known=known)
    if not quick:
        coarse = next(iter(_beside_elastica("crossed", 8.0, 16, limit))).error
        fine = next(iter(_beside_elastica("crossed", 8.0, 32, limit))).error
        rate = math.log2(coarse / fine)
        yield absolute(
            "cantilever, crossed: rate of the drop, at least 1.5", min(rate, 1.5), 1.5, 0
        )


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
            motion=Path(times=times, positions=path(times)),
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
