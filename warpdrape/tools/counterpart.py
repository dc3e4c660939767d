"""The tool that closes on a mould: the mould's face moved off it by a gap, facing back.

Each vertex goes the shortest way d that takes it off every facet round it by the gap g,
n_i·d = g in least squares, so that smooth faces move along their normals and sharp edges keep
their corner. What a rounding of the mould narrower than the gap would turn inside out is left out.
"""

from __future__ import annotations

import numpy as np
import trimesh
import warp as wp

from warpdrape.errors import InputError
from warpdrape.kernels.fishnet.nearest import compute_nearest
from warpdrape.tools.profile import Surface
from warpdrape.tools.tool_mesh import creased_normals

ONE_WAY = 0.01
"""Share of the largest below which a principal part of the normals round a vertex is rounding, or
a rounding's facets: two faces count as meeting in an edge from 11° on [-]."""
FARTHEST = 3.0
"""Way of a vertex over the gap at most, as at the tip of a needle [-]."""
NEAR = 0.9
"""Distance from the mould over the gap below which a facet is left out [-]."""


def counterpart(who: str, face: Surface, chosen: np.ndarray, gap: float) -> Surface:
    """Make the counterpart of a face.

    Args:
        who: for errors.
        face: the mould's whole face, to which it keeps its distance.
        chosen: facets of it that have a counterpart, shape [facet].
        gap: between the two [m].

    Raises:
        InputError: if nothing is left of it.
    """
    mesh = face.mesh
    faces, normals = np.asarray(mesh.faces)[chosen], face.normals[chosen]
    moved = mesh.vertices + _ways(mesh, face.normals, gap)
    corners = moved[faces]
    before = np.asarray(mesh.triangles)[chosen]
    turned = np.einsum("fi,fi->f", _cross(corners), _cross(before)) <= 0.0
    near = _distances(mesh, np.concatenate([corners, corners.mean(axis=1)[:, None]], axis=1))
    good = ~turned & (near.min(axis=1) >= NEAR * gap)
    if not good.any():
        raise InputError(
            f"{who}: a gap of {1e3 * gap:.3g} mm leaves nothing of the mould's counterpart: every "
            "rounding of it is narrower; give a smaller gap, or look at the mould's unit"
        )
    made = trimesh.Trimesh(moved, faces[good][:, ::-1], process=False)
    made.remove_unreferenced_vertices()
    if face.exact:
        return Surface(made, -normals[good][:, ::-1], exact=True)
    return Surface(made, creased_normals(made), exact=False)


def _cross(corners: np.ndarray) -> np.ndarray:
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def _ways(mesh: trimesh.Trimesh, normals: np.ndarray, gap: float) -> np.ndarray:
    """Way of each vertex [m], shape [vertex, 3]."""
    weight = np.asarray(mesh.face_angles).reshape(-1)
    along, vertex = normals.reshape(-1, 3), np.asarray(mesh.faces).reshape(-1)
    count = len(mesh.vertices)
    pull, matrix = np.zeros((count, 3)), np.zeros((count, 3, 3))
    np.add.at(pull, vertex, weight[:, None] * along)
    np.add.at(matrix, vertex, weight[:, None, None] * along[:, :, None] * along[:, None, :])
    size, axes = np.linalg.eigh(matrix)
    kept = size > ONE_WAY * size[:, -1:]
    along_axes = np.einsum("vij,vi->vj", axes, gap * pull)
    share = np.where(kept, along_axes / np.where(kept, size, 1.0), 0.0)
    way = np.einsum("vij,vj->vi", axes, share)
    length = np.linalg.norm(way, axis=1, keepdims=True)
    return way * np.minimum(1.0, FARTHEST * gap / np.maximum(length, 1e-300))


def _distances(mesh: trimesh.Trimesh, points: np.ndarray) -> np.ndarray:
    """Distance of points [..., 3] from a mesh [m], shape [...]."""
    query = wp.Mesh(
        wp.array(mesh.vertices, dtype=wp.vec3f, device="cpu"),
        wp.array(np.ravel(mesh.faces), dtype=wp.int32, device="cpu"),
    )
    asked = np.ascontiguousarray(points.reshape(-1, 3))
    facets = wp.empty(len(asked), dtype=wp.int32, device="cpu")
    nearest = wp.empty(len(asked), dtype=wp.vec3d, device="cpu")
    far = 4.0 * float(np.abs(asked).max() + np.abs(mesh.vertices).max())
    given = [query.id, wp.array(np.asarray(mesh.triangles), dtype=wp.vec3d, device="cpu")]
    given += [wp.array(asked, dtype=wp.vec3d, device="cpu"), far]
    wp.launch(compute_nearest, len(asked), given, outputs=[facets, nearest], device="cpu")
    return np.linalg.norm(nearest.numpy() - asked, axis=1).reshape(points.shape[:-1])
