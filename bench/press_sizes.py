"""How stiff a stabiliser a larger press wants, and a larger blank: ``python bench/press_sizes.py``.

The hemisphere at 0° with the blank's side and the tools so many times as large, the holder's force
with them and its mass with their area, the stroke at the same speed; and on the press as it is a
blank that is larger by itself, under a ring as much larger. Prints what docs/results.md quotes:
95 % of shear, draw-in along the yarns and between them over the press's scale, and how far the
blank's edge goes to and fro over it, for several stabilisers.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace

import numpy as np
from meshes import SIZE, mesh, zigzag

from warpdrape import Ply, Scene, Tool
from warpdrape.blanks.triangles import area_percentile
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.scenes import hemisphere, press

FRICTION = 0.2
CASES = (
    ("press twice as large", 2.0, SIZE, 28, (1.0, 2.5, 10.0, 20.0, 40.0)),
    ("blank of 400 mm", 1.0, 0.4, 37, (1.0, 10.0, 17.5)),
)
"""Name, scale of the press, side of the blank before it is scaled [m], cells, stabilisers."""


def scene_of(scale: float, side: float, cells: int, kind: str, stabiliser: float) -> Scene:
    """A press and its blank.

    Args:
        scale: of everything.
        side: of the blank, before scaling [m].
        cells: squares of four triangles along it, or a mesh as dense.
        kind: of mesh.
        stabiliser: κ [-].
    """
    parameters = dict(hemisphere.build().parameters)
    parameters["duration"] = scale * press.DURATIONS[press.ACCURACY]
    for name in ("travel", "facet", "holder_force"):
        parameters[name] *= scale
    ring = {
        "outer_radius": scale * press.RING_RADIUS * max(1.0, side / SIZE),
        "facet": parameters["facet"],
    }
    edge, hole = scale * press.DIE_EDGE, scale * press.DIE_RADIUS
    tools = (
        Tool.punch(radius=scale * press.PUNCH_RADIUS, facet=parameters["facet"]),
        Tool.die(hole_radius=hole, edge_radius=edge, depth=scale * 0.06, **ring),
        Tool.blank_holder(hole_radius=hole + edge, **ring),
    )
    blank = mesh(kind, cells, scale * side)
    ply = Ply(name="ply_0", fabric=load_fabric(parameters["fabric"]), mesh=blank)
    scene = press.press_scene("press", [ply], tools, parameters, FRICTION)
    return replace(scene, numerics=replace(scene.numerics, stabiliser=stabiliser))


def figures(scene: Scene, scale: float) -> str:
    """A cell of the table, from a run."""
    result = scene.run(threads=1, frames=6)
    if result.summary["status"] != "completed":
        raise SystemExit(result.summary["message"])
    ply, flat = result.plies[0], scene.plies[0].mesh
    drawn = {n: 1e3 * d / scale for n, d in result.summary["plies"][0]["draw_in_m"].items()}
    p95 = area_percentile(np.abs(ply.shear_angle_deg), np.asarray(flat.areas), 0.95)
    side = float(np.ptp(flat.vertices[:, 0]))
    to_and_fro = zigzag(ply.rest_points, ply.points, side) / scale
    along = 0.5 * (drawn["warp"] + drawn["weft"])
    return f"{p95:.2f}°; {along:.1f}, {drawn['bias']:.1f} mm; zigzag {to_and_fro:.2f} mm"


def main() -> int:
    """Run, and print."""
    parser = argparse.ArgumentParser(prog="press_sizes.py", description=__doc__.splitlines()[0])
    parser.add_argument("--mesh", default="diagonal")
    chosen = parser.parse_args()
    for name, scale, side, cells, stabilisers in CASES:
        for stabiliser in stabilisers:
            scene = scene_of(scale, side, cells, chosen.mesh, stabiliser)
            print(f"{name}, stabiliser {stabiliser:g}: {figures(scene, scale)}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
