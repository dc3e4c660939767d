"""Many small patches of triangles in one ply, deformed at random, and what kernels make of them."""

import numpy as np
import warp as wp

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.ply import Ply
from warpdrape.forces.membrane import build_membrane
from warpdrape.interaction import Span
from warpdrape.numerics import Numerics

SIZE = 5e-3
"""Triangle size [m], that of a forming mesh."""
SHAPES = {
    # Corners in units of the size, and triangles: one, a pair, a strip of three.
    "triangle": ([(0, 0), (1, 0), (0.4, 0.9)], [[0, 1, 2]]),
    "pair": ([(0, 0), (1, 0), (0.5, 0.9), (0.4, -0.8)], [[0, 1, 2], [0, 3, 1]]),
    "three": (
        [(0, 0), (1, 0), (0.5, 0.9), (1.5, 0.9), (1.0, 1.8)],
        [[0, 1, 2], [1, 3, 2], [2, 3, 4]],
    ),
}


def rotations(rng, count, plane=False):
    """Random rotations, shape [count, 2, 2] or [count, 3, 3]."""
    if plane:
        angle = rng.uniform(0, 2 * np.pi, count)
        c, s = np.cos(angle), np.sin(angle)
        return np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)
    q = rng.normal(size=(count, 4))
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def patch_ply(cloth, shape, count, rng, warp_angle=0.3):
    """A ply of ``count`` separate random patches; one in four has an edge along a yarn family."""
    corners, rows = (np.array(part) for part in SHAPES[shape])
    n = len(corners)
    points = SIZE * (corners + rng.uniform(-0.15, 0.15, (count, n, 2)))
    points = np.einsum("pij,pnj->pni", rotations(rng, count, plane=True), points)
    directions = warp_angle + np.array([0.0, cloth.yarn_angle])
    for family, direction in enumerate(directions):
        along = np.arange(family, count, 8)
        edge = points[along, 1] - points[along, 0]
        turn = direction - np.arctan2(edge[:, 1], edge[:, 0])
        c, s = np.cos(turn), np.sin(turn)
        matrix = np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)
        points[along] = np.einsum("pij,pnj->pni", matrix, points[along])
    columns = int(np.ceil(np.sqrt(count)))
    place = np.arange(count)
    points += 4 * SIZE * np.stack([place % columns, place // columns], -1)[:, None]
    triangles = (rows + n * place[:, None, None]).reshape(-1, 3)
    mesh = FlatMesh(points.reshape(-1, 2), triangles)
    return Ply(name="patches", fabric=cloth, mesh=mesh, warp_angle=warp_angle)


def deformed(ply, shape, rng, strains=(-0.01, 0.02), shear_deg=60.0, noise=0.003):
    """Positions of the patches stretched, sheared, turned in space and jolted, shape [n, 3]."""
    n = len(SHAPES[shape][0])
    flat = np.asarray(ply.mesh.vertices).reshape(-1, n, 2)
    flat = flat - flat.mean(axis=1, keepdims=True)  # near the origin positions round least
    count = len(flat)
    stretch = 1 + rng.uniform(*strains, (count, 2))
    angle = ply.fabric.yarn_angle - np.radians(rng.uniform(-shear_deg, shear_deg, count))
    angle = np.clip(angle, 0.3, np.pi - 0.3)
    frame = np.zeros((count, 3, 2))
    frame[:, 0, 0] = stretch[:, 0]
    frame[:, 0, 1] = stretch[:, 1] * np.cos(angle)
    frame[:, 1, 1] = stretch[:, 1] * np.sin(angle)
    yarns = np.stack(ply.yarn_directions, axis=-1)
    gradient = rotations(rng, count) @ frame @ np.linalg.inv(yarns)
    x = np.einsum("pij,pnj->pni", gradient, flat)
    x += noise * SIZE * rng.uniform(-1, 1, x.shape)
    return x.reshape(-1, 3)


def whole(ply):
    """Where a ply is in a model of its own."""
    return Span(0, len(ply.mesh.vertices), 0, len(ply.mesh.triangles))


def membrane_of(ply, device="cpu", **numerics):
    return build_membrane(ply, Numerics(**numerics), whole(ply), 1e-6, device)


def forces(membrane, x, device="cpu"):
    """Forces [N] at positions [m], shape [n, 3]."""
    f = wp.zeros(len(x), dtype=wp.vec3d, device=device)
    membrane.add_forces(wp.array(x, dtype=wp.vec3d, device=device), f)
    return f.numpy()


def measured(membrane, x, device="cpu"):
    """Strain, line tension and energy of every triangle; the outputs hold NaN before."""
    n = membrane.span.triangle_count
    outputs = [
        wp.full(n, value, dtype=kind, device=device)
        for value, kind in (
            (wp.vec2d(np.nan, np.nan), wp.vec2d),
            (wp.vec2d(np.nan, np.nan), wp.vec2d),
            (wp.vec3d(np.nan, np.nan, np.nan), wp.vec3d),
        )
    ]
    kernel, count, inputs = membrane.measurement
    at = wp.array(x, dtype=wp.vec3d, device=device)
    wp.launch(kernel, count, inputs=[*inputs, at], outputs=outputs, device=device)
    return tuple(output.numpy() for output in outputs)


def energy_gradient(membrane, x, shape, device="cpu", step=2e-6 * SIZE):
    """∂W/∂x [N] of separate patches by fourth-order central differences, shape [n, 3]."""
    n, n_triangles = len(SHAPES[shape][0]), len(SHAPES[shape][1])
    count = len(x) // n

    def energy(at):
        return measured(membrane, at, device)[2].reshape(count, n_triangles, 3).sum(axis=(1, 2))

    gradient = np.zeros((count, n, 3))
    for corner in range(n):
        for axis in range(3):
            move = np.zeros((n, 3))
            move[corner, axis] = step
            move = np.tile(move, (count, 1))
            near = energy(x + move) - energy(x - move)
            far = energy(x + 2 * move) - energy(x - 2 * move)
            gradient[:, corner, axis] = (8 * near - far) / (12 * step)
    return gradient.reshape(-1, 3)
