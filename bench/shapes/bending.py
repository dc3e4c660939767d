"""Tables of bending: wavelengths of flange and of drape over bending stiffness, with exponents."""

from __future__ import annotations

import numpy as np
from pages import markdown
from runs import Run, Runs

from warpdrape.scenes.cusick_drape import CLOTH, shadow, strongest_wave
from warpdrape.verification.drape import DISC, SPECIMEN, folds_expected

STIFFNESSES = (3e-4, 1e-3, 3e-3, 1e-2)
"""Of the ply on the hemisphere [N·m]: waves that mesh and flange have room for."""
CELLS, FORCE = 48, 10
LENGTHS_MM = (10.0, 20.0, 30.0, 46.5)
"""Bending lengths of the drape test [mm]: two decades of B = w c³."""


def exponent(stiffness: np.ndarray, wavelength: np.ndarray) -> str:
    """Of λ ∝ Bᵖ by least squares, with its standard error."""
    x, y = np.log(stiffness), np.log(wavelength)
    (slope, _), left, *_ = np.polyfit(x, y, 1, full=True)
    error = np.nan
    if len(x) > 2:
        error = float(np.sqrt(left[0] / (len(x) - 2) / ((x - x.mean()) ** 2).sum()))
    return f"{slope:.2f} ± {error:.2f}"


def _waves(run: Run) -> tuple[np.ndarray, np.ndarray, int]:
    """Wavelengths [m] and lengths of a run's resolved wrinkles, and the number of short ones."""
    found = run.summary["plies"][0]["defects"]["wrinkles"]
    resolved = [each for each in found["list"] if each["resolved"]]
    waves, lengths = (
        np.array([each[name] for each in resolved]) for name in ("wavelength_m", "length_m")
    )
    return waves, lengths, found["too_short_for_the_mesh"]["number"]


def bending_hemisphere(runs: Runs) -> str:
    """Radial wrinkles on the hemisphere's flange under a light holder."""
    rows, kept = [], []
    for stiffness in STIFFNESSES:
        run = runs.run("hemisphere", cells=CELLS, holder_force=FORCE, bending=stiffness)
        waves, lengths, short = _waves(run)
        found = run.summary["plies"][0]["defects"]["wrinkles"]
        cells = ["–", "–"]
        if len(waves):
            mean = float(np.average(waves, weights=lengths))
            kept.append((stiffness, mean))
            cells = [f"{1e3 * mean:.1f} mm", f"{1e3 * waves.min():.0f}–{1e3 * waves.max():.0f} mm"]
        rows.append(
            [
                f"{1e3 * stiffness:g} N·mm",
                f"{found['number']}",
                *cells,
                f"{1e3 * found['max_amplitude_m']:.1f} mm",
                f"{100 * found['area_share']:.2g} %",
                f"{short}",
            ]
        )
    headings = ("B", "wrinkles", "mean wavelength", "all", "largest amplitude", "area", "too short")
    said = f"\n\nλ ∝ B^p of the means: p = {exponent(*np.array(kept).T)}." if len(kept) > 2 else ""
    return markdown(headings, rows) + said


def bending_drape(runs: Runs) -> str:
    """Folds of Cusick's test beside the closed form."""
    rows, kept = [], []
    middle = np.pi * (SPECIMEN + DISC)
    for length in LENGTHS_MM:
        run = runs.run("cusick_drape", bending_length=f"{length:g}mm", fabric=CLOTH)
        drape, fabric = run.summary["drape"], run.scene.plies[0].fabric
        bending = fabric.bending.warp
        waves = strongest_wave(shadow(run.result.plies[0], DISC)[0])
        kept.append((bending, middle / waves))
        rows.append(
            [
                f"{length:g} mm",
                f"{bending:.2g} N·m",
                f"{drape['drape_coefficient']:.3f}",
                f"{drape['folds']}",
                f"{waves}",
                f"{folds_expected(1e-3 * length):.1f}",
            ]
        )
    headings = (
        "bending length",
        "B",
        "drape coefficient",
        "folds",
        "strongest harmonic",
        "by the closed form",
    )
    stiff, waves = np.array(kept).T
    said = f"λ ∝ B^p, λ = π (R + r) over the strongest harmonic: p = {exponent(stiff, waves)}"
    said += f"; without the softest {exponent(stiff[1:], waves[1:])}."
    return f"{markdown(headings, rows)}\n\n{said}"
