"""Cusick's drape test: a round specimen hangs in folds over the disc that holds it (ISO 9073-9)."""

import math
from dataclasses import replace

import numpy as np
from scipy.signal import find_peaks

from warpdrape import Bending, Clamp, InputError, Numerics, Ply, Scene
from warpdrape.errors import length
from warpdrape.materials.bending import from_flexural_length
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.results.result import FormedPly, Result
from warpdrape.scenes.circular_table import sheet
from warpdrape.units import mm

CLOTH = "light_cloth"
"""Name of the default: the made-up cloth of the table, of 200 g/m²."""
STIFF = {"name": CLOTH, "compressive_factor": 1.0}
"""Its yarns resist compression as they do tension: the edge folds, it does not shorten by 2 %."""
RIM = 720
"""Angles at which the specimen's edge is looked at."""
PROMINENCE = 0.03
"""Height of a fold in the plan of the edge over the overhang from which on it counts [-]."""


def build(
    *,
    bending_length: float = 20 * mm,
    fabric: str = CLOTH,
    specimen_radius: float = 150 * mm,
    disc_radius: float = 90 * mm,
    edge: float = 7 * mm,
    mesh: str = "random",
    duration: float = 1.5,
    damping: float = 8.0,
) -> Scene:
    """Build the test; 300 mm on 180 mm are the standard's.

    Args:
        bending_length: of the cloth in all directions, Peirce's flexural length [m]; 0 for the
            fabric's own bending.
        fabric: "light_cloth", or name or file of a fabric.
        specimen_radius: [m].
        disc_radius: of the discs that hold the specimen between them [m].
        edge: of the mesh [m].
        mesh: "random", "aligned", "grid" or "diagonal".
        duration: simulated time [s].
        damping: mass-proportional rate [1/s].
    """
    parameters = dict(locals())
    cloth = load_fabric(fabric) if fabric != CLOTH else replace(sheet("fabric"), **STIFF)
    if bending_length:
        stiffness = from_flexural_length(
            length("bending_length", bending_length), cloth.areal_density
        )
        cloth = replace(cloth, bending=Bending.isotropic(stiffness))
    if length("disc_radius", disc_radius) >= length("specimen_radius", specimen_radius):
        raise InputError(
            f"disc_radius = {disc_radius:.4g} m must be below the specimen_radius, "
            f"{specimen_radius:.4g} m: the rest hangs over"
        )
    ply = Ply.disc("specimen", cloth, specimen_radius, edge=edge, mesh=mesh)
    inner = disc_radius + 0.5 * edge  # so that the last vertices held lie at its edge in the mean
    held = Clamp(name="discs", ply="specimen", where=lambda p: np.hypot(p[:, 0], p[:, 1]) < inner)
    return Scene(
        name="cusick_drape",
        plies=[ply],
        clamps=[held],
        duration=duration,
        numerics=Numerics(damping=damping),
        parameters=parameters,
        report=lambda result: {"drape": read_drape(result, disc_radius, specimen_radius)},
    )


def read_drape(result: Result, disc_radius: float, specimen_radius: float) -> dict[str, float]:
    """The shadow of the specimen: drape coefficient and folds.

    Returns:
        ``drape_coefficient``: the shadow's area without the disc's over the flat specimen's without
        it [-]; ``folds``: their number; ``strongest_wave``: of the edge in plan, in waves round it,
        a number of folds that knows no threshold; ``edge_drop_m``: how far the edge hangs down in
        the mean.
    """
    radius, drop = shadow(result.plies[0], disc_radius)
    disc, flat = math.pi * disc_radius**2, math.pi * specimen_radius**2
    area = math.pi * float(np.mean(np.maximum(radius, disc_radius) ** 2))
    return {
        "drape_coefficient": (area - disc) / (flat - disc),
        "folds": count_folds(radius, specimen_radius - disc_radius),
        "strongest_wave": strongest_wave(radius),
        "edge_drop_m": drop,
    }


def shadow(ply: FormedPly, disc_radius: float) -> tuple[np.ndarray, float]:
    """Radius of the specimen's edge in plan at angles all round [m], and its mean drop [m]."""
    flat = ply.rest_points
    far = np.hypot(flat[:, 0], flat[:, 1])
    rim = np.flatnonzero(far > far.max() * (1.0 - 1e-3))
    rim = rim[np.argsort(np.arctan2(flat[rim, 1], flat[rim, 0]))]
    at = np.arctan2(flat[rim, 1], flat[rim, 0])
    angles = np.linspace(-math.pi, math.pi, RIM, endpoint=False)
    radius = np.hypot(ply.points[rim, 0], ply.points[rim, 1])
    drop = float((flat[rim, 2] - ply.points[rim, 2]).mean())
    return np.interp(angles, at, radius, period=2.0 * math.pi), drop


def count_folds(radius: np.ndarray, overhang: float) -> int:
    """Folds that stand out in a periodic outline.

    Args:
        radius: of the edge in plan at equal angles all round [m].
        overhang: of the flat specimen [m].
    """
    start = int(np.argmin(radius))
    once = np.append(np.roll(radius, -start), radius[start])
    peaks, _ = find_peaks(once, prominence=PROMINENCE * overhang)
    return len(peaks)


def strongest_wave(radius: np.ndarray) -> int:
    """Waves round a periodic outline of its strongest harmonic, from two on: one is a shift.

    Of an outline without folds it means nothing.

    Args:
        radius: of the edge in plan at equal angles all round [m].
    """
    return 2 + int(np.argmax(np.abs(np.fft.rfft(radius))[2:]))


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
