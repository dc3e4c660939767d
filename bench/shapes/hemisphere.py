"""Tables of the hemisphere: shear along the bias diagonal and draw-in outline of two fabrics."""

from __future__ import annotations

import numpy as np
from pages import markdown
from runs import Run, Runs

from warpdrape.coupons.closed_forms import bias_diagonal_of_net, net_shear_on_sphere
from warpdrape.scenes.press import PUNCH_RADIUS

FABRICS = ("carbon_interlock", "glass_pp_plain")
CELLS = 30
FROM_POLE = np.arange(0, 160, 20) * 1e-3
"""Ways from the pole along the diagonal of the blank [m]."""
NEAR = 7.5e-3
"""Radius round a place whose triangles are averaged [m]."""
ON_THE_BALL = 0.105
"""Way from the pole up to which the ply lies on the punch [m]."""
ALONG = (0.0, 0.25, 0.5, 0.75, 0.9)
"""Places on a half side of the blank, from its middle to its corner, over the half side."""


def runs_of(runs: Runs) -> list[Run]:
    """A run of each fabric."""
    return [runs.run("hemisphere", cells=CELLS, fabric=fabric) for fabric in FABRICS]


def hemisphere_diagonal(runs: Runs) -> str:
    """Shear angle along the four bias diagonals, in the mean, and an inextensible net's."""
    rows = []
    for fabric, run in zip(FABRICS, runs_of(runs), strict=True):
        (ply,) = run.result.plies
        middles = ply.rest_points[ply.triangles].mean(axis=1)[:, :2]
        shear = np.abs(ply.shear_angle_deg)
        found = []
        for way in FROM_POLE:
            at = np.minimum(way / np.sqrt(2.0), np.abs(middles).max() - 0.5 * NEAR)
            near = np.linalg.norm(np.abs(middles) - at, axis=1) < NEAR
            found.append(f"{shear[near].mean():.1f}°")
        rows.append([f"`{fabric}`", *found])
    half = 0.5 * runs_of(runs)[0].scene.plies[0].fabric.thickness
    radius = PUNCH_RADIUS + half
    exact = np.degrees(net_shear_on_sphere((FROM_POLE / np.sqrt(2.0) / radius) ** 2))
    on_ball = FROM_POLE <= ON_THE_BALL
    net = [f"{angle:.1f}°" if on else "–" for angle, on in zip(exact, on_ball, strict=True)]
    rows.append(["inextensible net", *net])
    polar = np.degrees(bias_diagonal_of_net(FROM_POLE[on_ball] / np.sqrt(2.0) / radius))
    reached = [f"{angle:.0f}°" for angle in polar] + ["–"] * int((~on_ball).sum())
    rows.append(["… polar angle there", *reached])
    headings = ["way from the pole on the blank", *(f"{1e3 * way:.0f} mm" for way in FROM_POLE)]
    return markdown(headings, rows)


def hemisphere_outline(runs: Runs) -> str:
    """Draw-in along the blank's sides, mean of the eight half sides, and punch force."""
    rows = []
    for fabric, run in zip(FABRICS, runs_of(runs), strict=True):
        entry = run.summary["plies"][0]
        edge = entry["defects"]["draw_in"]
        x, y, drawn = (np.abs(np.array(edge[name])) for name in ("x_m", "y_m", "draw_in_m"))
        half = max(x.max(), y.max())
        places, group = np.unique(np.round(np.minimum(x, y) / half, 6), return_inverse=True)
        mean = np.bincount(group, drawn) / np.bincount(group)
        found = [f"{1e3 * np.interp(place, places, mean):.1f} mm" for place in ALONG]
        punch = next(tool for tool in run.summary["tools"] if tool["name"] == "punch")
        wrinkles = entry["defects"]["wrinkles"]
        rows.append(
            [
                f"`{fabric}`",
                *found,
                f"{entry['max_shear_deg']:.1f}°",
                f"{entry['p95_shear_deg']:.1f}°",
                f"{wrinkles['number']}, {wrinkles['too_short_for_the_mesh']['number']}",
                f"{punch['force_n']:.0f} N",
            ]
        )
    at = ["middle of a side", *(f"{place:g}" for place in ALONG[1:])]
    headings = ["draw-in at", *at, "largest shear", "95 % below", "wrinkles, short waves"]
    return markdown([*headings, "punch"], rows)
