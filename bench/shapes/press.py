"""Tables of pressed shapes: what each gives by default, and holder force on the tetrahedron."""

from __future__ import annotations

from typing import Any

import numpy as np
from pages import markdown
from runs import Run, Runs

from warpdrape import Result
from warpdrape.results.tool_distance import ToolDistances

SHAPES = ("square_box", "tetrahedron", "prism", "double_dome")
FORCES = (20, 50, 100, 500, 2000)
LAYUPS = (("0/0", 0.3), ("0/90", 0.3), ("0/45", 0.0), ("0/45", 0.1), ("0/45", 0.3), ("0/45", 0.6))
STACK: dict[str, Any] = {"holder_force": 50, "bending": 0.001, "cells": 24}
DRAGGED = (
    ("0/0", 0.0),
    ("0/0", 0.6),
    ("0/45", 0.0),
    ("0/45", 0.2),
    ("0/45", 0.4),
    ("0/45", 0.6),
)
"""Lay-ups and frictions of two plies that stay flat."""
FINE: dict[str, Any] = {"bending": 0.003, "cells": 30}
FINE_CASES = (
    (35, "0/0", 0.3),
    (35, "0/45", 0.6),
    (50, "0/45", 0.6),
)


HEADINGS = (
    "travel",
    "largest shear",
    "95 % below",
    "draw-in along warp, weft, at the corners",
    "punch",
    "energy error",
    "penetration",
)


def result_cells(run: Run) -> list[str]:
    """What a run of one ply gives, under `HEADINGS`."""
    ply, drawn = run.summary["plies"][0], run.summary["plies"][0]["draw_in_m"]
    punch = next(tool for tool in run.summary["tools"] if tool["name"] == "punch")
    return [
        f"{1e3 * run.scene.parameters['travel']:.0f} mm",
        f"{ply['max_shear_deg']:.1f}°",
        f"{ply['p95_shear_deg']:.1f}°",
        ", ".join(f"{1e3 * drawn[at]:.1f}" for at in ("warp", "weft", "bias")) + " mm",
        f"{punch['force_n']:.0f} N",
        f"{100 * run.summary['energy_error']:.2f} %",
        f"{1e3 * run.summary['max_penetration_m']:.3f} mm",
    ]


def shapes(runs: Runs) -> str:
    """Every pressed shape with its defaults."""
    rows = [[f"`{name}`", *result_cells(runs.run(name))] for name in SHAPES]
    return markdown(("scene", *HEADINGS), rows)


def double_dome_fabrics(runs: Runs) -> str:
    """The double dome of two fabrics."""
    carbon = runs.run("double_dome")
    glass = runs.run("double_dome", fabric="glass_pp_plain")
    rows = [
        ["`carbon_interlock`", *result_cells(carbon)],
        ["`glass_pp_plain`", *result_cells(glass)],
    ]
    return markdown(("fabric", *HEADINGS), rows)


WRINKLES = ("wrinkles", "largest amplitude", "area", "excess length", "too short for the mesh")


def wrinkle_cells(run: Run, ply: int = 0) -> list[str]:
    """What is said of a ply's wrinkles, under `WRINKLES`."""
    found = run.summary["plies"][ply]["defects"]["wrinkles"]
    short = found["too_short_for_the_mesh"]
    waves = f"{short['number']}"
    if short["number"]:
        waves += f", {1e3 * short['max_amplitude_m']:.1f} mm"
    return [
        f"{found['number']}",
        f"{1e3 * found['max_amplitude_m']:.1f} mm" if found["number"] else "–",
        f"{100 * found['area_share']:.2g} %",
        f"{1e3 * found['excess_length_m']:.2g} mm",
        waves,
    ]


def off_the_tools(result: Result, thickness: float) -> tuple[float, float]:
    """Room between the first ply and the nearest tools [m³], and how far off it is at most [m].

    No threshold says what counts: of each triangle its area times how far its face is off, in the
    mean over its corners.

    Args:
        result: of a run.
        thickness: of the ply, in whose middle its vertices lie [m].
    """
    ply, tools = result.plies[0], [(tool.vertices, tool.triangles) for tool in result.tools]
    ways = ToolDistances(tools).of(ply.points, [vertices for vertices, _ in tools])
    off = np.maximum(ways - 0.5 * thickness, 0.0)
    a, b, c = (ply.points[ply.triangles[:, k]] for k in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return float(areas @ off[ply.triangles].mean(axis=1)), float(off.max())


def tetrahedron_force(runs: Runs) -> str:
    """Room under the tetrahedron's ply, wrinkles and yarn strain over the holder's force."""
    rows = []
    for force in FORCES:
        run = runs.run("tetrahedron", cells=40, holder_force=force)
        ply = run.summary["plies"][0]
        strain = max(ply["max_strain_warp"], ply["max_strain_weft"])
        softened = run.scene.numerics.yarn_softening
        punch = next(tool for tool in run.summary["tools"] if tool["name"] == "punch")
        room, most = off_the_tools(run.result, run.scene.plies[0].fabric.thickness)
        rows.append(
            [
                f"{force} N",
                f"{1e6 * room:.0f} cm³, {1e3 * most:.1f} mm",
                *wrinkle_cells(run),
                f"{100 * strain / softened:.2g} %",
                f"{punch['force_n']:.0f} N",
            ]
        )
    heads = ("holder", "off the tools", *WRINKLES, "largest yarn strain", "punch")
    return markdown(heads, rows)


def _stack_cells(run: Run) -> list[str]:
    """Waves of two plies, largest amplitude, lift of the holder, energy error."""
    found = [ply["defects"]["wrinkles"] for ply in run.summary["plies"]]
    every = [each["number"] + each["too_short_for_the_mesh"]["number"] for each in found]
    largest = max(
        max(each["max_amplitude_m"], each["too_short_for_the_mesh"]["max_amplitude_m"])
        for each in found
    )
    lifted = float(np.max(-run.result.history["holder_displacement_m"]))
    short = [each["too_short_for_the_mesh"]["number"] for each in found]
    return [
        ", ".join(
            f"{number}" + (f" ({few} too short)" if few else "")
            for number, few in zip(every, short, strict=True)
        ),
        f"{1e3 * largest:.1f} mm" if largest else "–",
        f"{1e3 * lifted:.1f} mm" if lifted > 5e-5 else "–",
        f"{100 * run.summary['energy_error']:.2f} %",
    ]


OF_A_STACK = ("waves on lower and upper ply", "largest amplitude", "holder up", "energy error")


def two_plies(runs: Runs) -> str:
    """Two plies by orientation and friction between them."""
    rows = []
    for layup, friction in LAYUPS:
        run = runs.run("stacked_hemisphere", layup=layup, ply_friction=friction, **STACK)
        rows.append([layup, f"{friction:g}", *_stack_cells(run)])
    return markdown(("lay-up", "friction", *OF_A_STACK), rows)


def two_plies_drag(runs: Runs) -> str:
    """What friction between two plies does where they stay flat: the press by default."""
    rows = []
    for layup, friction in DRAGGED:
        run = runs.run("stacked_hemisphere", layup=layup, ply_friction=friction, cells=24)
        plies, history = run.summary["plies"], run.result.history
        slip = max(each["max_net_slip_m"] for each in run.summary["interfaces"])
        rows.append(
            [
                layup,
                f"{friction:g}",
                f"{1e3 * slip:.0f} mm",
                f"{history['punch_force_n'][-1]:.0f} N",
                f"{history['friction_j'][-1]:.2f} J",
                ", ".join(f"{ply['max_shear_deg']:.1f}°" for ply in plies),
                ", ".join(f"{1e3 * ply['draw_in_m']['bias']:.1f} mm" for ply in plies),
                _stack_cells(run)[0],
            ]
        )
    headings = (
        "lay-up",
        "friction",
        "largest slide between them",
        "punch at the end",
        "lost to friction",
        "largest shear of lower and upper ply",
        "draw-in between the yarns",
        "waves",
    )
    return markdown(headings, rows)


def two_plies_fine(runs: Runs) -> str:
    """Two stiffer plies, whose waves a finer mesh carries, at two forces."""
    rows = []
    for force, layup, friction in FINE_CASES:
        settings = {"layup": layup, "ply_friction": friction, "holder_force": force, **FINE}
        run = runs.run("stacked_hemisphere", **settings)
        rows.append([f"{force} N", layup, f"{friction:g}", *_stack_cells(run)])
    return markdown(("holder", "lay-up", "friction", *OF_A_STACK), rows)


def double_dome_part(runs: Runs) -> str:
    """The part between the tools of the double dome, were it filled."""
    rows = []
    for clearance in (2, 1):
        run = runs.run("double_dome", **({} if clearance == 2 else {"clearance": "1mm"}))
        ply = run.summary["plies"][0]
        for cavity in ply["defects"]["cavities"]:
            if cavity["under_force"]:
                continue
            thick, volume = cavity["thickness_m"], cavity["fibre_volume_fraction"]
            rows.append(
                [
                    f"{clearance} mm",
                    f"{100 * cavity['area_share']:.0f} %",
                    f"{1e3 * thick['min']:.3f} to {1e3 * thick['max']:.3f} mm",
                    f"{100 * volume['min']:.1f} to {100 * volume['max']:.1f} %",
                    f"{100 * volume['mean']:.1f} %",
                ]
            )
    headings = ("`clearance`", "between the tools", "thickness", "fibre volume", "… in the mean")
    return markdown(headings, rows)
