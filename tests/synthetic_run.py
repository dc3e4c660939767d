"""A run folder without a simulation: square blanks bent into a saddle, and a tool that moves."""

from pathlib import Path

import numpy as np

from warpdrape.results.run_folder import HISTORY, RunFolder
from warpdrape.results.tables import HistoryWriter
from warpdrape.results.usd import PlyFrame, PlyShape, ToolShape, UsdWriter

FRAMES = 4
STROKE_S = 0.08
ANGLES_DEG = (45.0, 0.0, 45.0)


def blank(cells: int = 6, size: float = 0.3) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) and triangles of a square blank, one diagonal per square."""
    axis = np.linspace(-size / 2, size / 2, cells + 1)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    i, j = (k.ravel() for k in np.meshgrid(range(cells), range(cells), indexing="ij"))
    a, b, c, d = ((i + p) * (cells + 1) + j + q for p, q in ((0, 0), (1, 0), (1, 1), (0, 1)))
    return points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def saddle(rest: np.ndarray, amount: float) -> np.ndarray:
    """Bend and shear the blank; ``amount`` 0 leaves it flat."""
    x, y, z = rest.T
    return np.stack([x + 0.3 * amount * y, y + 0.1 * amount * x, z + 4 * amount * x * y], axis=1)


def frame_of(
    rest: np.ndarray, triangles: np.ndarray, points: np.ndarray, angle_deg: float
) -> PlyFrame:
    """Return what a run would write: yarn directions are the images of those on the blank."""
    a, b, c = triangles.T
    flat = np.stack([rest[b] - rest[a], rest[c] - rest[a]], 2)[:, :2]
    gradient = np.stack([points[b] - points[a], points[c] - points[a]], 2) @ np.linalg.inv(flat)
    t = np.radians(angle_deg)
    yarns = [gradient @ [np.cos(t), np.sin(t)], gradient @ [-np.sin(t), np.cos(t)]]
    stretch = [np.linalg.norm(k, axis=1) for k in yarns]
    warp, weft = (k / s[:, None] for k, s in zip(yarns, stretch, strict=True))
    shear = np.degrees(np.arcsin((warp * weft).sum(1)))
    strain = [s - 1.0 for s in stretch]
    return PlyFrame(points, warp, weft, shear, *strain, *(3e5 * e for e in strain))


def shapes() -> tuple[list[PlyShape], list[ToolShape]]:
    """Return three plies and a tool, a tetrahedron with a name that USD must change."""
    points, triangles = blank()
    corners = 0.05 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    plies = [PlyShape(f"ply_{i}", points, triangles) for i in range(len(ANGLES_DEG))]
    return plies, [ToolShape("punch no. 1", corners, faces)]


def writer_in(folder: Path) -> UsdWriter:
    """A writer of their animation into a folder."""
    return UsdWriter(folder / "scene.usdc", *shapes())


def frames_at(part: float) -> list[PlyFrame]:
    """Return the frame of each ply when ``part`` of the stroke is done."""
    rest, triangles = blank()
    gap = np.array([0.0, 0.0, 1e-3])
    lifted = [saddle(rest, part) + i * gap for i in range(len(ANGLES_DEG))]
    return [frame_of(rest, triangles, p, a) for p, a in zip(lifted, ANGLES_DEG, strict=True)]


def write_run(path: Path) -> RunFolder:
    """Write a whole run folder, in the order in which a run does."""
    folder = RunFolder(path)
    folder.begin()
    folder.write_json("run.json", {"scene": "saddle"})
    rows = HistoryWriter(folder.path / HISTORY)
    with UsdWriter(folder.scene_path, *shapes()) as scene, rows as history:
        for k in range(FRAMES):
            part = k / (FRAMES - 1)
            scene.write(k, STROKE_S * part, frames_at(part), [[0.0, 0.0, -0.01 * k]])
            history.append({"time_s": STROKE_S * part, "internal_j": np.float64(part)})
    folder.write_json("summary.json", {"status": "completed"})
    return folder
