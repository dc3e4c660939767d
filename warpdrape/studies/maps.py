"""Maps on the flat blank: at every place mean and scatter of shear, chances of wrinkle and locking.

Where the blanks of all runs have the same mesh, places are its triangles. Where outline or mesh
differ from run to run, places are squares of a lattice over all blanks, and a run counts at those
whose centre lies on its blank.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely

from warpdrape.studies.fields import PlyFields
from warpdrape.studies.study import MapOptions

MOST_SQUARES = 200
"""Squares of the lattice along its longer side, at most."""
QUANTITIES = {
    "mean_shear_deg": "mean shear angle, °",
    "sd_shear_deg": "standard deviation of the shear angle, °",
    "wrinkle_chance": "share of runs with a wrinkle",
    "locking_chance": "share of runs with shear past locking",
}
"""What maps show → in words."""


@dataclass(eq=False)
class PlyMap:
    """Sums over the runs of one ply.

    Attributes:
        name: of the ply.
        points: of the places' corners [m], shape [n, 2].
        places: corners of each, triangles or squares, shape [m, 3 or 4].
        runs: how many have a blank there, shape [m].
        mean: of the shear angle so far [deg], shape [m].
        squares: sum of squares about it [deg²], shape [m].
        wrinkled: runs with a wrinkle there, shape [m].
        locked: runs with shear past locking there, shape [m].
        judged: runs whose locking angle is known, shape [m].
    """

    name: str
    points: np.ndarray
    places: np.ndarray
    runs: np.ndarray = field(init=False)
    mean: np.ndarray = field(init=False)
    squares: np.ndarray = field(init=False)
    wrinkled: np.ndarray = field(init=False)
    locked: np.ndarray = field(init=False)
    judged: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        m = len(self.places)
        for name in ("runs", "mean", "squares", "wrinkled", "locked", "judged"):
            setattr(self, name, np.zeros(m))

    def add(self, ply: PlyFields, at: np.ndarray, options: MapOptions) -> None:
        """Add a run, by Welford's update of mean and sum of squares.

        Args:
            ply: of the run.
            at: its triangle at every place, -1 for none, shape [m].
            options: what counts.
        """
        there, triangle = at >= 0, at[at >= 0]
        shear = ply.shear_deg[triangle]
        self.runs[there] += 1
        off = shear - self.mean[there]
        self.mean[there] += off / self.runs[there]
        self.squares[there] += off * (shear - self.mean[there])
        self.wrinkled[there] += ply.wrinkle[triangle] > options.wrinkle
        locking = ply.locking_deg if options.locking_deg is None else options.locking_deg
        if np.isfinite(locking):
            self.judged[there] += 1
            self.locked[there] += np.abs(shear) > locking

    def values(self) -> dict[str, np.ndarray]:
        """What is shown, by name, shape [m]; NaN where no run is, or nothing is known."""
        with np.errstate(invalid="ignore", divide="ignore"):
            found = {
                "mean_shear_deg": np.where(self.runs > 0, self.mean, np.nan),
                "sd_shear_deg": np.sqrt(self.squares / np.where(self.runs > 1, self.runs - 1, 0)),
                "wrinkle_chance": self.wrinkled / self.runs,
                "locking_chance": self.locked / self.judged,
            }
        return {name: np.where(np.isfinite(v), v, np.nan) for name, v in found.items()}


def map_runs(runs: Iterable[Sequence[PlyFields]], options: MapOptions) -> list[PlyMap]:
    """Maps of every ply over the runs.

    Args:
        runs: the plies of each run; gone through twice, so that no more than one is in memory.
        options: what counts on them.
    """
    frames = _frames(runs)
    maps = {name: frame.empty(name) for name, frame in frames.items()}
    for plies in runs:
        for ply in plies:
            maps[ply.name].add(ply, frames[ply.name].triangle_at(ply), options)
    return list(maps.values())


@dataclass(eq=False)
class _Frame:
    """Places of a ply's map, as they are found by looking at all runs once."""

    rest: np.ndarray
    triangles: np.ndarray
    low: np.ndarray
    high: np.ndarray
    side: float
    one_mesh: bool = True

    def widen(self, ply: PlyFields) -> None:
        """Make room for another run."""
        same = self.rest.shape == ply.rest.shape and np.array_equal(self.triangles, ply.triangles)
        self.one_mesh &= bool(same and np.array_equal(self.rest, ply.rest))
        self.low = np.minimum(self.low, ply.rest.min(axis=0))
        self.high = np.maximum(self.high, ply.rest.max(axis=0))
        self.side = min(self.side, _side(ply))

    def empty(self, name: str) -> PlyMap:
        """The map without a run."""
        if self.one_mesh:
            return PlyMap(name, self.rest, self.triangles)
        nx, ny = self.counts()
        x = np.linspace(self.low[0], self.high[0], nx + 1)
        y = np.linspace(self.low[1], self.high[1], ny + 1)
        points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        i, j = (k.ravel() for k in np.meshgrid(range(nx), range(ny), indexing="ij"))
        first = i * (ny + 1) + j
        corners = np.stack([first, first + ny + 1, first + ny + 2, first + 1], axis=1)
        return PlyMap(name, points, corners)

    def counts(self) -> tuple[int, int]:
        """Squares of the lattice along x and y."""
        size = self.high - self.low
        side = max(self.side, float(size.max()) / MOST_SQUARES)
        nx, ny = np.maximum(np.round(size / side).astype(int), 1)
        return int(nx), int(ny)

    def triangle_at(self, ply: PlyFields) -> np.ndarray:
        """The triangle of a run at every place, -1 for none."""
        if self.one_mesh:
            return np.arange(len(self.triangles))
        nx, ny = self.counts()
        size = (self.high - self.low) / (nx, ny)
        x = self.low[0] + (np.arange(nx) + 0.5) * size[0]
        y = self.low[1] + (np.arange(ny) + 0.5) * size[1]
        centres = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        return triangles_at(centres, ply.rest, ply.triangles)


def triangles_at(points: np.ndarray, rest: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """The triangle in which each point lies, -1 for none, shape [p].

    Args:
        points: shape [p, 2].
        rest: vertices, shape [n, 2].
        triangles: of them, shape [m, 3].
    """
    tree = shapely.STRtree(shapely.polygons(rest[triangles]))
    point, triangle = tree.query(shapely.points(points), predicate="intersects")
    found = np.full(len(points), -1)
    found[point[::-1]] = triangle[::-1]  # the first of two that share an edge
    return found


def _frames(runs: Iterable[Sequence[PlyFields]]) -> dict[str, _Frame]:
    frames: dict[str, _Frame] = {}
    for plies in runs:
        for ply in plies:
            if ply.name not in frames:
                low, high = ply.rest.min(axis=0), ply.rest.max(axis=0)
                frames[ply.name] = _Frame(ply.rest, ply.triangles, low, high, _side(ply))
            frames[ply.name].widen(ply)
    return frames


def _side(ply: PlyFields) -> float:
    """Side of a square as large as a mean triangle [m]."""
    a, b, c = np.moveaxis(ply.rest[ply.triangles], 1, 0)
    one, other = b - a, c - a
    areas = 0.5 * np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    return float(np.sqrt(areas.mean()))
