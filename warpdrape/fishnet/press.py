"""The surface between closed tools on which a ply comes to lie, bridging where they leave it free.

Tools above the plies bound it from above, those below from below, each moved towards the ply along
its normals by half of what lies between. Between them the ply spans like a taut membrane: of all
height fields within the bounds that with the least ∫|∇z|² (the obstacle problem), on a square grid
by successive over-relaxation with projection (Cryer 1971).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import trimesh
import warp as wp

from warpdrape.errors import InputError
from warpdrape.fishnet.surface import NetSurface
from warpdrape.kernels.fishnet.heights import compute_heights
from warpdrape.tools.pose import Pose
from warpdrape.tools.tool import Tool

FINEST_GRID = 401
"""Grid lines along a side at most."""
SETTLED = 1e-7
"""Change in a sweep over the grid's size at which the membrane has settled [-]."""
MOST_SWEEPS = 20_000
BEYOND = 5
"""Cells of the grid beyond the plies on every side: three spacings of the net, whose outermost
crossovers lie beyond the blank, the more the more its yarns turn."""
STEEP = 0.02
"""Vertical part of a facet's normal below which it is a wall, and bounds nothing [-]."""


def pressed_surface(
    tools: Sequence[Tool],
    poses: Sequence[Pose],
    thickness: float,
    height: float,
    box: np.ndarray,
    grid: float,
) -> NetSurface:
    """The surface on which the middle of a stack lies between closed tools.

    Args:
        tools: at the start.
        poses: where they are now.
        thickness: of the stack [m].
        height: of its middle at the start [m].
        box: lowest and highest x and y of the plies [m], shape [2, 2].
        grid: distance of the surface's points aimed at [m].

    Raises:
        InputError: if no tool presses the plies from above onto one below.
    """
    above, below = split_tools(tools, height)
    if not above or not below:
        raise InputError(
            "the fishnet needs tools above and below the plies, or one tool as a mould: drape over "
            "a surface of your own with warpdrape.drape_fishnet"
        )
    x, y = _lines(box, grid)
    at = np.stack(np.meshgrid(x, y, indexing="ij"), -1)
    lower = _bound(tools, below, poses, 0.5 * thickness, at, up=True)
    upper = _bound(tools, above, poses, 0.5 * thickness, at, up=False)
    if not np.isfinite(lower).any() or not np.isfinite(upper).any():
        raise InputError("no tool lies above or below the plies: look at where the tools stand")
    squeezed = lower > upper
    lower[squeezed] = upper[squeezed] = 0.5 * (lower[squeezed] + upper[squeezed])
    heights = taut(np.clip(np.full(lower.shape, height), lower, upper), lower, upper)
    points = np.concatenate([at, heights[..., None]], axis=-1).reshape(-1, 3)
    return NetSurface.of_mesh(trimesh.Trimesh(points, _squares(len(x), len(y)), process=False))


def mould_surface(tool: Tool, pose: Pose, thickness: float) -> NetSurface:
    """The surface on which the middle of a stack lies on one tool, from its own facets.

    Args:
        tool: at the start.
        pose: where it is now.
        thickness: of the stack [m].
    """
    mesh = tool.surface.mesh
    normals = np.zeros((len(mesh.vertices), 3))
    for corner in range(3):
        np.add.at(normals, mesh.faces[:, corner], tool.surface.normals[:, corner])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    moved = pose.place(mesh.vertices) + 0.5 * thickness * pose.direct(normals)
    return NetSurface.of_mesh(trimesh.Trimesh(moved, mesh.faces, process=False))


def split_tools(tools: Sequence[Tool], height: float) -> tuple[list[int], list[int]]:
    """Numbers of the tools above and below a height [m] at the start."""
    middles = [0.5 * (tool.vertices[:, 2].min() + tool.vertices[:, 2].max()) for tool in tools]
    above = [k for k, middle in enumerate(middles) if middle > height]
    return above, [k for k in range(len(tools)) if k not in above]


def taut(heights: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """A membrane between two bounds on a square grid, free at its borders.

    Args:
        heights: to begin with [m], shape [x, y].
        lower: bound [m]; −∞ where there is none.
        upper: bound [m]; ∞ where there is none.
    """
    z = np.pad(heights, 1, mode="edge")
    own = np.indices(heights.shape).sum(axis=0) % 2
    relax = 2.0 / (1.0 + math.sin(math.pi / max(heights.shape)))
    size = max(float(np.ptp(heights)), 1e-6)
    for _ in range(MOST_SWEEPS):
        change = 0.0
        for color in (0, 1):
            z[0], z[-1], z[:, 0], z[:, -1] = z[1], z[-2], z[:, 1], z[:, -2]
            mean = 0.25 * (z[:-2, 1:-1] + z[2:, 1:-1] + z[1:-1, :-2] + z[1:-1, 2:])
            now = z[1:-1, 1:-1]
            new = np.clip(now + relax * (mean - now), lower, upper)
            new = np.where(own == color, new, now)
            change = max(change, float(np.abs(new - now).max()))
            z[1:-1, 1:-1] = new
        if change < SETTLED * size:
            break
    return z[1:-1, 1:-1]


def _lines(box: np.ndarray, grid: float) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates of the grid's lines, some cells beyond the box on every side [m]."""
    wide = np.ptp(box, axis=0)
    grid = max(grid, float(wide.max()) / (FINEST_GRID - 2 * BEYOND - 1))
    found = []
    for axis in (0, 1):
        count = max(2, math.ceil(wide[axis] / grid)) + 2 * BEYOND
        middle = box[:, axis].mean()
        found.append(middle + grid * (np.arange(count + 1) - 0.5 * count))
    return found[0], found[1]


def _bound(
    tools: Sequence[Tool],
    chosen: Sequence[int],
    poses: Sequence[Pose],
    offset: float,
    at: np.ndarray,
    *,
    up: bool,
) -> np.ndarray:
    """Height at which tools bound the ply's middle from below (``up``) or above [m], shape [x, y].

    Args:
        tools: at the start.
        chosen: numbers of those that count.
        poses: where they are now.
        offset: from the tools along their normals [m].
        at: x and y [m], shape [x, y, 2].
        up: whether facets that face up count, else those that face down.
    """
    sign = 1.0 if up else -1.0
    corners = []
    for k in chosen:
        surface = tools[k].surface
        moved = poses[k].place(tools[k].vertices)[tools[k].triangles]
        moved = moved + offset * poses[k].direct(surface.normals)
        facing = sign * np.cross(moved[:, 1] - moved[:, 0], moved[:, 2] - moved[:, 0])
        steep = facing[:, 2] <= STEEP * np.linalg.norm(facing, axis=1)
        corners.append(moved[~steep])
    soup = np.concatenate(corners)
    bound = np.full(at.shape[:2], -sign * math.inf)
    if not len(soup):
        return bound
    far = 2.0 * float(np.abs(soup).max() + np.abs(at).max())
    mesh = wp.Mesh(
        wp.array(soup.reshape(-1, 3), dtype=wp.vec3f, device="cpu"),
        wp.array(np.arange(3 * len(soup)), dtype=wp.int32, device="cpu"),
    )
    asked: wp.array = wp.array(at.reshape(-1, 2), dtype=wp.vec2d, device="cpu")
    corner_array: wp.array = wp.array(soup, dtype=wp.vec3d, device="cpu")
    heights = wp.empty(asked.shape, dtype=wp.float64, device="cpu")
    given = [mesh.id, corner_array, asked, far, sign]
    wp.launch(compute_heights, len(asked), given, outputs=[heights], device="cpu")
    found = heights.numpy().reshape(bound.shape)
    return np.where(np.abs(found) < far, found, bound)


def _squares(m: int, n: int) -> np.ndarray:
    """Triangles of a grid of m × n points, the diagonals taking turns, shape [2 cells, 3]."""
    number = np.arange(m * n).reshape(m, n)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    odd = (np.indices(a.shape).sum(axis=0) % 2 == 1)[..., None]
    one = np.where(odd, np.stack([a, b, c], -1), np.stack([a, b, d], -1))
    two = np.where(odd, np.stack([a, c, d], -1), np.stack([b, c, d], -1))
    return np.concatenate([one.reshape(-1, 3), two.reshape(-1, 3)])
