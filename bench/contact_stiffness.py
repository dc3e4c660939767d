"""What soft contacts cost: ``python bench/contact_stiffness.py [--scene hemisphere] [--cells 20]``.

Contacts take a share of the vertices' mass over the step's square, so that a run's step and their
stiffness change together. Here the step is one for all rows, the stable one of the stiffest, and
only the share differs: what moves over the rows is owed to contact's stiffness alone. Prints the
largest and the 95th percentile of shear, draw-in, the punch's force, depth and energy error; and
the most that the percentile and the draw-in moved by from the stiffest row.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from warpdrape import Scene
from warpdrape.dynamics.model import build_model
from warpdrape.scenes import double_dome, hemisphere, square_box, three_ply_hemisphere

SCENES = {
    "hemisphere": hemisphere,
    "three_ply_hemisphere": three_ply_hemisphere,
    "double_dome": double_dome,
    "square_box": square_box,
}
SHARES = (0.2, 0.1, 0.05, 0.025, 0.0125)
"""Shares of the rows, the stiffest first; 0.1 is that of the standard accuracy."""


def of_one_step(scene: Scene, shares: Sequence[float]) -> dict[float, Scene]:
    """The scene with each share, at the step that the largest of them allows.

    Args:
        scene: as built.
        shares: penalty stiffness over m/Δt² [-].
    """
    stiffest = replace(scene, numerics=replace(scene.numerics, contact_share=max(shares)))
    step = build_model(stiffest, "cpu", 1).timing.time_step
    return {
        share: replace(scene, numerics=replace(scene.numerics, contact_share=share, time_step=step))
        for share in shares
    }


def figures(summary: Mapping[str, Any]) -> dict[str, float]:
    """Numbers of a row: [deg], [mm], [N], [-]; of several plies the largest."""
    if summary["status"] != "completed":
        raise SystemExit(summary["message"])
    plies = summary["plies"]
    drawn = [ply["draw_in_m"] for ply in plies]
    punch = next(tool for tool in summary["tools"] if tool["name"] == "punch")
    return {
        "largest": max(ply["max_shear_deg"] for ply in plies),
        "p95": max(ply["p95_shear_deg"] for ply in plies),
        "draw_in": max(500.0 * (each["warp"] + each["weft"]) for each in drawn),
        "punch": punch["force_n"],
        "depth": 1e3 * summary["max_penetration_m"],
        "energy": summary["energy_error"],
    }


def line(share: float, row: Mapping[str, float]) -> str:
    """A row of the table."""
    cells = [f"{share:g}", f"{row['largest']:.2f}°", f"{row['p95']:.2f}°"]
    cells += [f"{row['draw_in']:.2f} mm", f"{row['punch']:.1f} N", f"{row['depth']:.3f} mm"]
    return f"| {' | '.join(cells)} | {row['energy']:.2%} |"


def moved(rows: Mapping[float, Mapping[str, float]], least: float) -> tuple[float, float]:
    """How far percentile [deg] and draw-in [mm] lie off the stiffest row at most.

    Args:
        rows: by share.
        least: smallest share that counts.
    """
    stiffest = rows[max(rows)]
    counted = [row for share, row in rows.items() if share >= least]
    off = {
        name: max(abs(row[name] - stiffest[name]) for row in counted) for name in ("p95", "draw_in")
    }
    return off["p95"], off["draw_in"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, and print the table."""
    parser = argparse.ArgumentParser(
        prog="contact_stiffness.py", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--scene", choices=SCENES, default="hemisphere")
    parser.add_argument("--cells", type=int, default=20)
    parser.add_argument("--duration", type=float, help="of the stroke [s]; the scene's own")
    parser.add_argument("--shares", nargs="+", type=float, default=list(SHARES))
    chosen = parser.parse_args(arguments)
    given = {} if chosen.duration is None else {"duration": chosen.duration}
    scene = SCENES[chosen.scene].build(cells=chosen.cells, **given)
    print("| share | largest shear | 95 % below | draw-in | punch | depth | energy error |")
    print("|" + "---|" * 7)
    rows = {}
    for share, row in of_one_step(scene, chosen.shares).items():
        rows[share] = figures(row.run(threads=1, frames=12).summary)
        print(line(share, rows[share]), flush=True)
    for least in (min(share for share in rows if share >= 0.25 * max(rows)), min(rows)):
        shear, drawn = moved(rows, least)
        print(f"down to {least:g}: 95th percentile by {shear:.2f}°, draw-in by {drawn:.2f} mm")
    return 0


if __name__ == "__main__":
    sys.exit(main())
