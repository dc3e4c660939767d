"""Triangles for a blank's outline: the paper's pattern, in any frame, or a random mesh."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.outlines import Outline, Points, Rectangle
from warpdrape.blanks.trimming import fill, gaps, trim
from warpdrape.errors import InputError, finite, length, one_of, said

PATTERNS = ("aligned", "crossed", "diagonal", "grid", "random")
MOST_TRIANGLES = 2e7
"""Triangles beyond which a mesh size is a slip of the pen, and memory runs out."""
CLEARANCE = 0.55
"""Least distance of an inner vertex from the outline, over the edge length: low enough to leave
most of the pattern, high enough that the triangles of the rim are well shaped."""
FIT = 1e-6
"""How far a rectangle's cells may be from square, relative, to count as turned by 45°."""
RELAXATION_STEPS = 6
"""Moves of every random vertex to the mean of its triangles; more would make it regular."""
JITTER = 0.35
"""Half width of the random shift of a vertex, over the distance of its neighbours."""
KEPT = 4
"""Meshes of a kind that are kept for who asks for the same again."""


def mesh_outline(
    outline: Outline,
    *,
    edge: float | None = None,
    cells: int | None = None,
    pattern: str = "aligned",
    warp_angle: float = 0.0,
    seed: int = 0,
) -> FlatMesh:
    """Mesh an outline with triangles of one size; asked again for the same, it is the same mesh.

    So what is found on the mesh of one ply of a stack need not be found again for the others.

    Patterns:

    - ``aligned``: squares of four triangles along the yarns, trimmed to the outline. On a
      rectangle the same as ``grid`` where that follows the yarns: at multiples of 90°, and of
      45° if its cells are square (then the diagonals follow them).
    - ``grid``, also called ``crossed``: squares of four triangles along the outline's own axes
      (the paper's pattern), exact on a rectangle, else trimmed.
    - ``diagonal``: the same with squares of two triangles.
    - ``random``: a Delaunay mesh of relaxed random points with sides of about ``edge``.

    Args:
        outline: the shape.
        edge: side of the squares [m]; give this or ``cells``.
        cells: number of squares along the outline's width.
        pattern: one of the above.
        warp_angle: direction of the warp yarns from the x axis [rad]; for ``aligned`` only.
        seed: of the ``random`` pattern.

    Raises:
        InputError: the size is missing, double, not positive or larger than the outline.
    """
    one_of("mesh pattern", pattern, PATTERNS)
    edge = _edge_length(outline, edge, cells)
    count = 4.0 * outline.area / edge**2
    if count > MOST_TRIANGLES:
        raise InputError(
            f"an edge of {edge:.4g} m makes {count:.2g} triangles, more than "
            f"{MOST_TRIANGLES:.0e}: take fewer cells, or a longer edge"
        )
    angle = finite("warp_angle", warp_angle, unit="rad") if pattern == "aligned" else 0.0
    if pattern == "random":
        if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
            raise InputError(f"seed = {said(seed)} must be a whole number, 0 or more")
        return _random_mesh(outline, edge, seed)
    return _regular_mesh(outline, edge, float(angle), crossed=pattern != "diagonal")


@lru_cache(maxsize=KEPT)
def _regular_mesh(outline: Outline, edge: float, angle: float, *, crossed: bool) -> FlatMesh:
    """Squares turned by an angle [rad], of four triangles each or of two."""
    if isinstance(outline, Rectangle):
        x, y = _rectangle_lines(outline, edge)
        eighths = angle / (math.pi / 4.0)
        square = math.isclose(x[1] - x[0], y[1] - y[0], rel_tol=FIT)
        turns = round(eighths)
        if abs(eighths - turns) < FIT and (turns % 2 == 0 or square):
            return FlatMesh.from_arrays(*squares(x, y, crossed=crossed))
    return trim(outline, edge, *_lattice(outline, edge, angle, crossed), CLEARANCE)


def squares(
    x: NDArray[np.float64], y: NDArray[np.float64], *, crossed: bool
) -> tuple[Points, NDArray[np.int64]]:
    """Divide the squares between the lines x = … and y = … into four triangles each, or two."""
    corners = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    index = np.arange(len(corners)).reshape(len(y), len(x))
    a, b = index[:-1, :-1].ravel(), index[:-1, 1:].ravel()
    d, c = index[1:, :-1].ravel(), index[1:, 1:].ravel()
    if not crossed:
        return corners, np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)
    centres = 0.5 * (corners[a] + corners[c])
    m = len(corners) + np.arange(len(centres))
    rows = np.stack([a, b, m, b, c, m, c, d, m, d, a, m], axis=1).reshape(-1, 3)
    return np.concatenate([corners, centres]), rows


def _edge_length(outline: Outline, edge: float | None, cells: int | None) -> float:
    """Return the edge length [m] from whichever of the two is given."""
    x0, y0, x1, y1 = outline.bounds
    width, height = x1 - x0, y1 - y0
    if (edge is None) == (cells is None):
        raise InputError("a mesh needs either edge [m] or cells (squares along the width)")
    if edge is not None:
        size = length("edge", edge)
        if size > min(width, height) * (1.0 + FIT):
            raise InputError(
                f"edge = {size:.4g} m is longer than the outline ({width:.4g} × {height:.4g} m): "
                "give a shorter edge"
            )
        return size
    whole = isinstance(cells, int | np.integer) and not isinstance(cells, bool | np.timedelta64)
    if cells is None or not whole or cells < 1:
        raise InputError(f"cells = {said(cells)} must be a whole number of squares, 1 or more")
    if cells > MOST_TRIANGLES:
        raise InputError(f"cells = {said(cells)} are more than {MOST_TRIANGLES:.0e}: take fewer")
    if width / cells > 2.0 * height:
        raise InputError(
            f"cells = {cells} makes squares of {width / cells:.4g} m, longer than the outline's "
            f"height {height:.4g} m: give at least {math.ceil(width / height)}"
        )
    return width / float(cells)


def _rectangle_lines(
    outline: Rectangle, edge: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lines that divide a rectangle into nearly square cells."""
    columns = max(1, round(outline.width / edge))
    rows = max(1, round(outline.height / (outline.width / columns)))
    x0, y0, x1, y1 = outline.bounds
    return np.linspace(x0, x1, columns + 1), np.linspace(y0, y1, rows + 1)


def _lattice(
    outline: Outline, edge: float, angle: float, crossed: bool
) -> tuple[Points, NDArray[np.int64]]:
    """A lattice turned by ``angle`` [rad] about the outline's middle that covers it all."""
    x0, y0, x1, y1 = outline.bounds
    cos, sin = math.cos(angle), math.sin(angle)
    turn = np.array([[cos, sin], [-sin, cos]])
    lines = [
        edge * np.arange(-count, count + 1)
        for count in np.ceil(0.5 / edge * np.abs(turn) @ (x1 - x0, y1 - y0)).astype(int) + 1
    ]
    points, rows = squares(*lines, crossed=crossed)
    return points @ turn + (0.5 * (x0 + x1), 0.5 * (y0 + y1)), rows


@lru_cache(maxsize=KEPT)
def _random_mesh(outline: Outline, edge: float, seed: int) -> FlatMesh:
    """Delaunay mesh of random points, relaxed to good shape; the same for the same seed."""
    rng = np.random.default_rng(seed)
    x0, y0, x1, y1 = outline.bounds
    pitch = math.sqrt(math.sqrt(0.75)) * edge  # as many points as equilateral triangles have
    columns, rows = math.ceil((x1 - x0) / pitch), math.ceil((y1 - y0) / pitch)
    x, y = np.meshgrid(x0 + pitch * np.arange(columns + 1), y0 + pitch * np.arange(rows + 1))
    points = np.column_stack([x.ravel(), y.ravel()])
    points += rng.uniform(-JITTER * pitch, JITTER * pitch, points.shape)
    points = points[gaps(outline, edge, points) > CLEARANCE * edge]
    loops = outline.loops(edge)
    for _ in range(RELAXATION_STEPS):
        fixed, triangles = fill(loops, points)
        points = _relaxed(fixed, triangles)[len(fixed) - len(points) :]
    return FlatMesh.from_arrays(*fill(loops, points))


def _relaxed(points: Points, triangles: NDArray[np.int64]) -> Points:
    """Move every vertex to the mean centroid of its triangles, weighted by area."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    area = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    moment = area[:, None] * (a + b + c) / 3.0
    corners, size = triangles.ravel(), len(points)
    total = np.bincount(corners, np.repeat(area, 3), size)
    sums = [np.bincount(corners, np.repeat(moment[:, k], 3), size) for k in (0, 1)]
    return np.stack(sums, axis=1) / total[:, None]
