"""Tension locking: bias extension on meshes that follow the yarns and on meshes that do not.

Run as ``python -m warpdrape.verification.locking``; the table is in docs/verification.md.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from warpdrape.commands.scene_library import find_script
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.results.usd_reader import find_scene, read_scene

WIDTH, HEIGHT = 0.1, 0.2
MESHES = (
    ("aligned", 0.0),
    ("diagonal", 0.0),
    ("random", 0.0),
    ("grid", 15.0),
    ("grid", 22.5),
    ("grid", 30.0),
    ("grid", 45.0),
)
"""Pattern and turn [deg]. "crossed" and "grid" at 0° are "aligned" here: its diagonals follow the
yarns."""
ANGLES = (20.0, 40.0)
FRAMES = 80
CORE = 0.01
"""Distance from the middle zone's corners, along the strip or across it [m]."""


@dataclass(frozen=True)
class LockingRow:
    """One run.

    Attributes:
        mesh: pattern.
        turn_deg: of the pattern against the strip [deg].
        edge: mesh size [m].
        averaging: "pairs" or "plain".
        compressive_factor: of the yarns [-].
        angle_deg: shear angle of inextensible yarns [deg].
        force_ratio: clamp force over the closed form [-].
        shear_mean_deg: mean shear angle in the middle zone, one edge inside its corners [deg].
        shear_scatter_deg: its standard deviation [deg].
        shear_rms_deg: root mean square of its error in a zone that no mesh changes, ``CORE``
            inside the middle zone's corners [deg].
        kinetic_ratio: mean kinetic over internal energy while loaded [-].
        wall_s: time the run took [s].
    """

    mesh: str
    turn_deg: float
    edge: float
    averaging: str
    compressive_factor: float
    angle_deg: float
    force_ratio: float
    shear_mean_deg: float
    shear_scatter_deg: float
    shear_rms_deg: float
    kinetic_ratio: float
    wall_s: float


def measure_locking(
    mesh: str,
    turn_deg: float,
    *,
    edge: float = 0.005,
    averaging: str = "pairs",
    compressive_factor: float = 1.0,
    duration: float = 0.06,
    angles: Sequence[float] = ANGLES,
) -> list[LockingRow]:
    """Pull one strip to the last of ``angles``; a row for each.

    The closed form is of yarns that bend freely at the borders of its zones (with 2 N·mm in the
    plane the force of the aligned mesh is 6 % higher), and that do not shorten either: forces run
    along the borders of its zones, compressive ones too, and yarns that give way there (a low
    ``compressive_factor``) take up part of the travel.
    """
    fabric = replace(
        load_fabric("carbon_interlock"), compressive_factor=compressive_factor, bending=None
    )
    scene = find_script("bias_extension").build(
        fabric=fabric,
        width=WIDTH,
        height=HEIGHT,
        edge=edge,
        mesh=mesh,
        mesh_angle_deg=turn_deg,
        shear_angle_deg=max(angles),
        averaging=averaging,
        duration=duration,
    )
    with tempfile.TemporaryDirectory() as folder:
        result = scene.run(folder, frames=FRAMES)
        if not result.completed:
            raise RuntimeError(result.summary["message"])
        table = np.genfromtxt(Path(folder) / "coupon.csv", delimiter=",", names=True)
        zones = [_middle_zone(folder, frame, (edge, CORE)) for frame in range(FRAMES + 1)]
    reached = table["shear_angle_deg"]
    ratio = table["force_n"][1:] / table["closed_form_force_n"][1:]
    rows = []
    for angle in angles:
        columns = zip(*zones, strict=True)
        mean, scatter, core, spread = (np.interp(angle, reached, column) for column in columns)
        rows.append(
            LockingRow(
                mesh,
                turn_deg,
                edge,
                averaging,
                compressive_factor,
                angle,
                float(np.interp(angle, reached[1:], ratio)),
                float(mean),
                float(scatter),
                float(np.hypot(core - angle, spread)),
                result.summary["kinetic_ratio_loaded"],
                result.summary["wall_s"],
            )
        )
    return rows


def _middle_zone(folder: str, frame: int, insets: Sequence[float]) -> list[float]:
    """Mean and standard deviation of the shear angle [deg], each inset [m] inside the zone."""
    ply = read_scene(find_scene(folder), None, frame).plies[0]
    centre = np.abs(ply.rest[ply.triangles].mean(axis=1)).sum(axis=1)
    inside = [ply.values[centre < 0.5 * (HEIGHT - WIDTH) - inset] for inset in insets]
    return [float(value) for shear in inside for value in (shear.mean(), shear.std())]


def main() -> None:
    """Measure, and append rows to a JSON-lines file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--edge", type=float, default=0.005, help="mesh size [m]")
    parser.add_argument("--averaging", default="pairs", choices=("pairs", "plain"))
    parser.add_argument("--compressive-factor", type=float, default=1.0)
    parser.add_argument("--duration", type=float, default=0.06, help="of the pull [s]")
    parser.add_argument("--meshes", default="", help="such as aligned:0,grid:15; all if empty")
    parser.add_argument("--out", type=Path, default=Path("locking.jsonl"))
    options = parser.parse_args()
    chosen = [m.split(":") for m in options.meshes.split(",") if m] or MESHES
    for mesh, turn in chosen:
        rows = measure_locking(
            mesh,
            float(turn),
            edge=options.edge,
            averaging=options.averaging,
            compressive_factor=options.compressive_factor,
            duration=options.duration,
        )
        for row in rows:
            print(json.dumps(asdict(row)), flush=True)
            with options.out.open("a", encoding="utf-8") as lines:
                lines.write(json.dumps(asdict(row)) + "\n")


if __name__ == "__main__":
    main()
