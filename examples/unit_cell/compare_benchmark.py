"""Lay the example's unit cell over a published curve of such a weave.

Two bias-extension tests of the plain glass/PP weave of the benchmark of Cao et al. (2008), as
somebody else has read them off its figure, become couples per cell by power balance; beside them
stand the couples of the unit cell under several yarn tensions, which such a test does not control.
"""

import argparse
import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from warpdrape.coupons.closed_forms import bias_angle
from warpdrape.results.figures import Figure
from warpdrape.results.run_folder import write_whole
from warpdrape.unit_cell.cell_file import read_cell
from warpdrape.unit_cell.loading import shear
from warpdrape.unit_cell.model import build_model

HERE = Path(__file__).parent
TENSIONS = (1.0, 2.0, 4.0)
"""Of every yarn [N]."""
ANGLES = (5, 10, 20, 30, 40)
"""Shear angles of the table [deg]."""


def published() -> dict[tuple[float, float], tuple[np.ndarray, np.ndarray]]:
    """Shear angles [rad] and couples per area [N/m] of each size (width, height) [m].

    F (H/W − 1)(cos γ/2 − sin γ/2) = (2H − 3W) C(γ) + W C(γ/2), solved by iteration.
    """
    lines = (HERE / "published_bias.csv").read_text("utf-8").splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    found = {}
    for width, height in sorted({(row["width_mm"], row["height_mm"]) for row in rows}):
        own = [row for row in rows if (row["width_mm"], row["height_mm"]) == (width, height)]
        w, h = 1e-3 * float(width), 1e-3 * float(height)
        travel = 1e-3 * np.array([float(row["travel_mm"]) for row in own])
        force = np.array([float(row["force_n"]) for row in own])
        angle = bias_angle(w, h, travel)
        work = force * (h / w - 1.0) * (np.cos(angle / 2) - np.sin(angle / 2))
        couple = np.zeros_like(angle)
        for _ in range(60):
            half = np.interp(angle / 2, np.append(0.0, angle), np.append(0.0, couple))
            couple = (work - w * half) / (2.0 * h - 3.0 * w)
        found[w, h] = angle, couple
    return found


def simulated(tensions=TENSIONS, settings=("largest_angle=44 deg",)) -> dict:
    """The curve of the example's cell under each tension."""
    plan = read_cell(HERE / "glass_plain.toml", settings)
    model = build_model(plan.cell, plan.elements)
    return {
        tension: shear(model, replace(plan.loads, shear_tension=(tension, tension)))
        for tension in tensions
    }


def table(curves, area: float) -> list[list[float]]:
    """Couples [N·mm per cell] at `ANGLES`: of each published size, then of each tension."""
    at = np.radians(ANGLES)
    columns = [1e3 * area * np.interp(at, *pair) for pair in published().values()]
    columns += [1e3 * np.interp(at, c.angles, c.couples) for c in curves.values()]
    return np.array([ANGLES, *columns]).T.tolist()


def draw(curves, area: float, path: Path) -> None:
    """Published points, and the cell's curves."""
    figure = Figure(figsize=(6.4, 4.2), dpi=130, layout="constrained")
    axes = figure.subplots()
    for (size, (angle, couple)), mark in zip(published().items(), "os", strict=True):
        label = f"published, {1e3 * size[0]:.0f} × {1e3 * size[1]:.0f} mm"
        axes.plot(np.degrees(angle), 1e3 * area * couple, mark, color="0.45", ms=4, label=label)
    for (tension, curve), style in zip(curves.items(), (":", "-", "--"), strict=True):
        label = f"unit cell, {tension:g} N per yarn"
        axes.plot(np.degrees(curve.angles), 1e3 * curve.couples, style, color="C0", label=label)
    locking = math.degrees(next(iter(curves.values())).locking)
    axes.axvline(locking, color="C3", lw=0.9, label=f"locking, {locking:.0f}°")
    axes.set(xlabel="shear angle [°]", ylabel="couple C$_s$ [N·mm per cell]", xlim=(0, 46))
    axes.set_ylim(0.0, 1.0)
    axes.grid(alpha=0.3)
    axes.legend(frameon=False, fontsize="small")
    write_whole(path, figure.savefig)


def main() -> None:
    """Print the table, and draw the picture where asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", metavar="FILE", type=Path, help="a .png for the picture")
    out = parser.parse_args().out
    plan = read_cell(HERE / "glass_plain.toml")
    area = plan.cell.cell[0] * plan.cell.cell[1]
    curves = simulated()
    sizes = [f"{1e3 * w:.0f}×{1e3 * h:.0f}" for w, h in published()]
    print("angle", *sizes, *(f"{t:g} N" for t in TENSIONS), sep="\t")
    for row in table(curves, area):
        print(f"{row[0]:.0f}°", *(f"{value:.2f}" for value in row[1:]), sep="\t")
    if out is not None:
        draw(curves, area, out)
        print(f"picture in {out}")


if __name__ == "__main__":
    main()
