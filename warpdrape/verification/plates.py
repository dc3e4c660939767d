"""Plates and beams by the matrices of bending alone: small deflections, meshes of every kind."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import eigsh, spsolve

from warpdrape import Bending
from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.meshing import mesh_outline
from warpdrape.blanks.outlines import Rectangle
from warpdrape.forces.curvature import CurvatureOperator, curvature_operator
from warpdrape.verification.case import CaseResult, absolute, relative

STIFFNESS = 1e-4
"""Bending stiffness of the strips [N·m]."""
LENGTH = 0.1
"""Of a strip [m]."""
MESHES = ("diagonal", "crossed", "random", "turned 15°", "turned 22.5°")


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
        worst = int(np.argmax(np.abs(found / exact - 1.0)))
        yield relative(
            f"supported plate, {kind}, h = L/24: worst of four frequencies",
            found[worst],
            exact[worst],
            0.02,
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
