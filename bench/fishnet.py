"""How near `wd.best_fishnet` comes to all starts and directions: ``python bench/fishnet.py``.

Four surfaces, both objectives; beside it a grid of starts in many directions on the same net. Cost
is what is minimised: shear [rad] or its share past 20°, and four times what stays uncovered.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable

import numpy as np
import trimesh

import warpdrape as wd
from warpdrape.fishnet.drape import SHEAR_LIMIT, as_surface, begin_at, counts_of
from warpdrape.fishnet.search import cost_of
from warpdrape.fishnet.solver import lay_out
from warpdrape.fishnet.surface import NetSurface
from warpdrape.verification import nets
from warpdrape.verification.net_oracle import saddle

HALF, CELLS, SPACING, LOCKING = 0.2, 24, 0.02, math.radians(20.0)
Height = Callable[[np.ndarray, np.ndarray], np.ndarray]


def hill(x0: float, y0: float, height: float, width: float) -> Height:
    """A bell of a height [m] and width [m]."""
    return lambda x, y: height * np.exp(-((x - x0) ** 2 + (y - y0) ** 2) / width**2)


def ridge(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A ridge that is turned against the border."""
    return 0.08 * np.exp(-((y - 0.3 * x) ** 2) / 0.06**2) * np.exp(-(x**2) / 0.12**2)


SURFACES: dict[str, Height] = {
    "bump": hill(0.06, 0.03, 0.07, 0.08),
    "two": lambda x, y: hill(0.09, 0.02, 0.06, 0.06)(x, y) + hill(-0.08, -0.06, 0.05, 0.07)(x, y),
    "ridge": ridge,
    "saddle": lambda x, y: 2.0 * x * y + 0.8 * (x - 0.05) ** 2,
}


def surface_of(height: Height) -> NetSurface:
    """A square of 0.4 m seen from above."""
    mesh = nets.graph_mesh(saddle(0.0), -HALF, HALF, 2.0 * HALF / CELLS)
    x, y, _ = mesh.vertices.T
    raised = np.column_stack([x, y, height(x, y)])
    return as_surface(trimesh.Trimesh(raised, mesh.faces, process=False))


def of_grid(mould: NetSurface, objective: str, starts: int, turns: int) -> float:
    """Least cost over starts on a lattice, each in all directions."""
    line = np.linspace(-HALF, HALF, starts + 2)[1:-1]
    least = math.inf
    for x in line:
        for y in line:
            at = mould.top_at(np.array([x, y]))
            for angle in np.arange(turns) * 0.5 * math.pi / turns:
                along = np.array([math.cos(angle), math.sin(angle), 0.0])
                begin = begin_at(mould, at, along, 0.5 * math.pi)
                counts = counts_of(mould, begin, SPACING, None)
                net = lay_out(mould, begin, SPACING, counts, limit=SHEAR_LIMIT)
                least = min(least, cost_of(net, objective, LOCKING, None))
    return least


def main() -> int:
    """Compare on the chosen surfaces."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("surfaces", nargs="*", help=f"of: {', '.join(SURFACES)}; all if none")
    parser.add_argument("--starts", type=int, default=15, help="of the grid along a side")
    parser.add_argument("--turns", type=int, default=18, help="directions over a right angle")
    chosen = parser.parse_args()
    print(f"{'surface':10}{'objective':14}{'search':>9}{'s':>7}{'grid':>9}{'s':>7}{'gain':>9}")
    for name in chosen.surfaces or SURFACES:
        mould = surface_of(SURFACES[name])
        for objective in ("largest", "past_locking"):
            begun = time.process_time()
            net = wd.best_fishnet(mould, SPACING, objective=objective, locking=LOCKING)
            found, done = cost_of(net, objective, LOCKING, None), time.process_time()
            grid = of_grid(mould, objective, chosen.starts, chosen.turns)
            times = (done - begun, time.process_time() - done)
            row = f"{name:10}{objective:14}{found:9.3f}{times[0]:7.1f}{grid:9.3f}{times[1]:7.1f}"
            print(f"{row}{grid - found:9.3f}", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
