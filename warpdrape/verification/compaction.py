"""Compaction: plates that close on plies bear what the law says at that thickness."""

from __future__ import annotations

from dataclasses import replace

from warpdrape import Compaction, Ply, Scene, Stroke, Tool, lay_up
from warpdrape.verification.case import CaseResult, relative
from warpdrape.verification.strip import yarn_fabric

SIDE = 0.04
START = 1e-5
"""Room over the plies at the start [m]."""


def closed(count: int, thickness: float) -> tuple[float, float]:
    """Force [N] of plates that close on plies to a thickness of each [m], and the law's."""
    fabric = yarn_fabric(1e5, 0.6)
    law = Compaction.power_law(
        areal_density=fabric.areal_density,
        fibre_density=1760.0,
        thickness=fabric.thickness,
        coefficient=0.62 * fabric.areal_density / (1760.0 * fabric.thickness),
        exponent=0.08,
        largest_pressure=2e5,
    )
    fabric = replace(fabric, compaction=law)
    meshes = ("grid", "random", "diagonal")[:count]
    plies = lay_up(
        [
            Ply.rectangle(f"ply_{n}", fabric, SIDE, cells=8 - n, mesh=mesh)
            for n, mesh in enumerate(meshes)
        ]
    )
    way = count * (law.thickness - thickness) + START
    down = Stroke(travel=(0.0, 0.0, -way), duration=0.018, ramp=0.5)
    top = Tool.plate("top", width=0.1, height=0.1, facing="down", motion=down)
    scene = Scene(
        name="plates",
        plies=plies,
        tools=[
            Tool.plate("bottom", width=0.1, height=0.1),
            top.moved((0.0, 0.0, count * law.thickness + START)),
        ],
        duration=0.02,
        gravity=(0.0, 0.0, 0.0),
    )
    force = float(scene.run(frames=10).history["top_force_n"][-1])
    return force, float(law.pressure(thickness)) * SIDE**2


def compaction(quick: bool) -> list[CaseResult]:
    """All cases of this file."""
    thickness = yarn_fabric(1e5, 0.6).thickness
    return [
        relative(
            "plates closed on a ply to 0.7 of it: force", *closed(1, 0.7 * thickness), 1e-3, "N"
        ),
        relative("… on three plies, other meshes: force", *closed(3, 0.7 * thickness), 0.06, "N"),
    ]
