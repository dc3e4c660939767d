"""Tables of docs/approaches.md: the press by each approach, and yarns as their bars get shorter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pages import markdown
from runs import Run, Runs

from warpdrape.blanks.places import locate
from warpdrape.forces.ply_net import net_of
from warpdrape.results.result import FormedPly

ACCURATE = {"accuracy": "reference", "duration": 0.08, "brake": 0.3}
"""Of all runs here: yarns as stiff as the card's, and a punch that slows down for long."""
CONTINUA = ("semi_discrete", "fibre_frame", "green_naghdi")
SQUARES = (10, 14, 20, 28)
"""Along a side, of the meshes of which yarns follow the edges; the last is the element's finest."""


def press(runs: Runs, approach: str, **settings: str | float) -> Run:
    """The hemisphere by an approach."""
    return runs.run("hemisphere", **ACCURATE, **settings, approach=approach)


def _shears(run: Run) -> str:
    ply = run.summary["plies"][0]
    return f"{ply['max_shear_deg']:.2f}°, {ply['p95_shear_deg']:.2f}°"


def _draw_in(run: Run) -> str:
    drawn = run.summary["plies"][0]["draw_in_m"]
    along = 0.5 * (drawn["warp"] + drawn["weft"])
    return f"{1e3 * along:.1f}, {1e3 * drawn['bias']:.1f} mm"


def _strain(run: Run) -> str:
    ply = run.summary["plies"][0]
    return f"{100 * max(ply['max_strain_warp'], ply['max_strain_weft']):.2g} %"


def _punch(run: Run) -> str:
    return f"{run.result.history['punch_force_n'][-1]:.1f} N"


def _work(run: Run) -> str:
    history = run.result.history
    return f"{history['internal_j'][-1]:.3f} ({history['yarn_j'][-1]:.3f}) J"


def off_the_other(ply: FormedPly, other: FormedPly) -> tuple[float, float, float]:
    """Of two plies of one mesh: largest and 95 % difference of shear [deg], way of a vertex [m]."""
    shear = np.abs(ply.shear_angle_deg - other.shear_angle_deg)
    way = np.linalg.norm(ply.points - other.points, axis=1)
    return float(shear.max()), float(np.percentile(shear, 95.0)), float(way.max())


def continua(runs: Runs, angle_deg: float = 0.0) -> str:
    """The element, and stress as a state in either frame."""
    settings = {"angle_deg": angle_deg} if angle_deg else {}
    found = [press(runs, approach, **settings) for approach in CONTINUA]
    element = found[0].result.plies[0]
    off = ["–"]
    for run in found[1:]:
        most, nearly, way = off_the_other(run.result.plies[0], element)
        off.append(f"{most:.2g}°, {nearly:.2g}°, {1e3 * way:.2g} mm")
    rows = [
        ["largest shear, 95 % of the area below", *map(_shears, found)],
        ["draw-in along yarns, between them", *map(_draw_in, found)],
        ["largest yarn strain", *map(_strain, found)],
        ["punch force at the end", *map(_punch, found)],
        ["`internal_j` (of it `yarn_j`)", *map(_work, found)],
        ["energy error", *(f"{100 * run.summary['energy_error']:.2f} %" for run in found)],
        ["steps", *(f"{run.summary['steps']:,}" for run in found)],
        ["off the element: largest, 95 % of the triangles, a vertex", *off],
    ]
    return markdown(("", *(f"`{approach}`" for approach in CONTINUA)), rows)


def continua_45(runs: Runs) -> str:
    """The same with yarns at 45° to the blank's sides."""
    return continua(runs, 45.0)


def yarns_hemisphere(runs: Runs) -> str:
    """Yarns as bars beside the element, on two kinds of mesh."""
    rows = []
    for mesh in ("grid", "diagonal"):
        settings = {} if mesh == "grid" else {"mesh": mesh}
        both = [press(runs, approach, **settings) for approach in ("yarns", "semi_discrete")]
        means = [f", {run.summary['plies'][0]['mean_abs_shear_deg']:.1f}°" for run in both]
        shears = [f"{_shears(run)}{mean}" for run, mean in zip(both, means, strict=True)]
        rows += [
            [f"`mesh={mesh}`, 20 squares: largest shear, 95 %, mean", *shears],
            ["draw-in along yarns, between them", *map(_draw_in, both)],
            ["punch force at the end", *map(_punch, both)],
            ["energy error", *(f"{100 * run.summary['energy_error']:.2f} %" for run in both)],
        ]
    return markdown(("", "`yarns`", "`semi_discrete`"), rows)


def at_flat(ply: FormedPly, flat: np.ndarray) -> np.ndarray:
    """Where flat points of a ply come to lie, straight between its vertices [m], shape [n, 3].

    Args:
        ply: formed.
        flat: on its blank [m], shape [n, 2].
    """
    found = locate(flat, ply.rest_points[:, :2], ply.triangles)
    corners = ply.points[ply.triangles[found.triangles]]
    return (found.weights[..., None] * corners).sum(axis=1)


def apart(ply: FormedPly, places: np.ndarray, fine: FormedPly) -> float:
    """Root mean square distance of vertices from where another run's ply has them [m]."""
    there = at_flat(fine, ply.rest_points[places, :2])
    return float(np.sqrt(((ply.points[places] - there) ** 2).sum(axis=1).mean()))


def crossovers(run: Run) -> np.ndarray:
    """Numbers of the vertices where yarns cross."""
    (ply,) = run.scene.plies
    return np.setdiff1d(np.arange(len(ply.mesh.vertices)), net_of(ply).carried)


def rate(squares: Sequence[int], off: Sequence[float]) -> float:
    """At what power of a square's side a distance falls, by least squares."""
    return -float(np.polyfit(np.log(squares), np.log(off), 1)[0])


def yarns_per_bar(runs: Runs) -> str:
    """Crossovers of ever shorter bars beside the element's finest ply."""
    finest = press(runs, "semi_discrete", cells=SQUARES[-1]).result.plies[0]
    rows, off = [], []
    for squares in SQUARES:
        run = press(runs, "yarns", cells=squares)
        ply, places = run.result.plies[0], crossovers(run)
        off.append(apart(ply, places, finest))
        own = "–"
        if squares != SQUARES[-1]:
            element = press(runs, "semi_discrete", cells=squares).result.plies[0]
            own = f"{1e3 * apart(element, places, finest):.2g} mm"
        (per_bar,) = run.summary["yarns_per_bar"].values()
        rows.append([f"{squares}", f"{max(per_bar):.0f}", f"{1e3 * off[-1]:.2g} mm", own])
    headings = ("squares", "yarns per bar", "off the element", "the element's own")
    said = f"a rate of {rate(SQUARES, off):.1f} in the side of a square"
    return f"{markdown(headings, rows)}\n\n{said}."
