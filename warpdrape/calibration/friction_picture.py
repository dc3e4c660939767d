"""Friction of an interface as a picture: coefficients by each thing that they depend on."""

from __future__ import annotations

import numpy as np

from warpdrape.calibration.bands import LEVEL
from warpdrape.calibration.friction import FrictionFit
from warpdrape.results.figures import Figure

_ACROSS = {
    "pressure": (1e-3, "pressure [kPa]", "kPa"),
    "speed": (1e3, "speed [mm/s]", "mm/s"),
    "yarns": (1.0, "angle between warp yarns [°]", "°"),
}


def draw_friction(face: str, fit: FrictionFit) -> Figure:
    """One panel for each thing that changed: readings at the other references, law and band.

    Args:
        face: what the ply slid on.
        fit: its coefficients.
    """
    names = list(fit.bands) or ["pressure"]
    figure = Figure(figsize=(5.6 * len(names), 4.2), dpi=130, layout="constrained")
    for axes, name in zip(np.atleast_1d(figure.subplots(1, len(names))), names, strict=True):
        factor, label, _ = _ACROSS[name]
        own = [r for r in fit.readings if _at_reference(r, fit, name)]
        at = [factor * getattr(r, name) for r in own]
        axes.plot(at, [r.kinetic for r in own], "o", color="0.65", ms=4, label="specimens")
        level, band = np.array([fit.reference[name]]), fit.coefficient
        if name in fit.bands:
            level, band = fit.levels[name], fit.bands[name]
        low, high = band.value - band.low, band.high - band.value
        words = f"law, {LEVEL:.0%} band" if band.told else "law"
        axes.errorbar(
            factor * level, band.value, [low, high], fmt="-x", color="C3", capsize=3, label=words
        )
        if name == "speed" and len(level) > 1:
            axes.set_xscale("log")
        others = [
            f"{_ACROSS[n][0] * v:.3g} {_ACROSS[n][2]}"
            for n, v in fit.reference.items()
            if n != name
        ]
        axes.set_title(f"at {', '.join(others)}" if others else "", fontsize="medium")
        axes.set(xlabel=label, ylabel="friction coefficient [-]", ylim=(0.0, None))
        axes.grid(alpha=0.3)
        axes.legend(frameon=False, fontsize="small", loc="lower left")
    figure.suptitle(f"friction against {face}")
    return figure


def _at_reference(reading, fit: FrictionFit, but: str) -> bool:
    """Whether a reading was taken at the reference of everything else."""
    return all(
        np.isclose(getattr(reading, name), value, rtol=0.05, atol=1e-9)
        for name, value in fit.reference.items()
        if name != but
    )
