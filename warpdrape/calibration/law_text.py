"""Laws that were fitted, in words, with their bands."""

from __future__ import annotations

import math

import numpy as np

from warpdrape.calibration.bands import LEVEL
from warpdrape.calibration.fits import Fits
from warpdrape.calibration.locking import DEFINITION
from warpdrape.calibration.shear import ShearFit

FAR_OFF = 0.03
"""Distance of a polynomial from the free curve that calls for a table [-]."""
NOTED = 0.1
"""Offset of one specimen, over the mean couple, from which on it is worth a word [-]."""


def law_lines(fits: Fits) -> list[str]:
    """Every law that was fitted, in words, with its band."""
    lines = [] if fits.shear is None else _shear_lines(fits, fits.shear)
    for part in (_tension_lines, _bending_lines, _friction_lines, _compaction_lines):
        lines += part(fits)
    return lines


def _tension_lines(fits: Fits) -> list[str]:
    lines: list[str] = []
    for family, fit in fits.linear.items():
        lines.append(
            f"{family} yarns: {fit.stiffness.words('kN', 1e-3)}, from a strain of "
            f"{fit.start.words('%', 100.0)}"
        )
    for family, band in fits.failure.items():
        lines.append(f"{family} yarns fail at a strain of {band.words('%', 100.0)}")
    if fits.crimp is not None:
        names = ("crimp of warp", "crimp of weft", "warp yarns", "weft yarns")
        for k, name in enumerate(names):
            factor, unit = (100.0, "%") if k < 2 else (1e-3, "kN")
            value, low, high = (
                factor * getattr(fits.crimp, n)[k] for n in ("value", "low", "high")
            )
            ends = f" ({LEVEL:.0%} band {low:.4g} to {high:.4g})" if fits.crimp.told else ""
            lines.append(f"{name}: {value:.4g} {unit}{ends}")
    if fits.table is not None:
        beyond = int(fits.table.beyond.sum())
        lines.append(
            f"tension table: {fits.table.beyond.size} points, {beyond} of them extrapolated"
        )
    return lines


def _bending_lines(fits: Fits) -> list[str]:
    lines: list[str] = []
    for family, fit in fits.cantilevers.items():
        lines.append(f"bending of {family}, cantilever: B = {fit.stiffness.words('N·mm', 1e3)}")
    for family, loop in fits.loops.items():
        if loop.stiffness is not None:
            lines.append(f"bending of {family}, Kawabata: B = {loop.stiffness.words('N·mm', 1e3)}")
        if loop.width is not None:
            lines.append(f"  2HB = {loop.width.words('mN', 1e3)} at 1 1/cm")
        lines.append(
            f"  friction of the fit {loop.friction.words('mN', 1e3)}, built up over "
            f"{loop.over:.3g} 1/m"
        )
        if family in fits.cantilevers and loop.stiffness is not None:
            ratio = loop.stiffness.value[0] / fits.cantilevers[family].stiffness.value[0]
            lines.append(f"  Kawabata's B over the cantilever's: {ratio:.3g}")
    return lines


def _friction_lines(fits: Fits) -> list[str]:
    lines: list[str] = []
    for face, fit in fits.friction.items():
        at = ", ".join(f"{n} {_at(n, v)}" for n, v in fit.reference.items())
        lines.append(f"friction against {face}: {fit.coefficient.words()} at {at}")
        for name, band in fit.bands.items():
            shown = ", ".join(
                f"{value:.3g} at {_at(name, level)}"
                for level, value in zip(fit.levels[name], band.value, strict=True)
            )
            lines.append(f"  by {name}: {shown}")
        if fit.apart is not None:
            lines.append(f"  factors multiply within {100 * fit.apart:.2g} % of every condition")
        elif len(fit.bands) > 1:
            lines.append(
                "  no test changes two conditions at once: that factors multiply is assumed"
            )
        if fit.static is not None:
            lines.append(f"  static over kinetic: {fit.static:.3g}")
    return lines


def _compaction_lines(fits: Fits) -> list[str]:
    lines: list[str] = []
    if fits.compaction is not None:
        fit, shown = fits.compaction, []
        for k in (0, -1):
            shown.append(
                f"{1e3 * fit.thickness.value[k]:.4g} mm at {fit.pressures[k] / 1e3:.3g} kPa"
            )
        lines.append("thickness of a ply: " + ", ".join(shown))
        if fit.coefficient is not None and fit.exponent is not None:
            lines.append(
                f"  V_f = a p^b: a = {fit.coefficient.words()}, b = {fit.exponent.words()}"
            )
    return lines


def _at(name: str, value: float) -> str:
    shown = {"pressure": (1e-3, "kPa"), "speed": (1e3, "mm/s"), "yarns": (1.0, "°")}
    factor, unit = shown[name]
    return f"{factor * value:.3g} {unit}"


def _shear_lines(fits: Fits, fit: ShearFit) -> list[str]:
    end = math.degrees(fit.basis.end)
    kinds = " and ".join(dict.fromkeys(s.kind.replace("_", " ") for s in fit.specimens))
    lines = [f"shear from {kinds}, to {end:.3g}°: beyond it the card's law is extrapolated"]
    for angle in (10, 20, 30, 40, 50, 60):
        if angle <= end + 1e-9:
            at = math.radians(angle)
            value, low, high = (
                np.interp(at, fit.angles, v) / math.cos(at)
                for v in (fit.band.value, fit.band.low, fit.band.high)
            )
            band = f" ({LEVEL:.0%} band {low:.4g} to {high:.4g})" if fit.band.told else ""
            lines.append(f"  normalised shear force at {angle}°: {value:.4g} N/m{band}")
    if not fit.band.told:
        lines.append("  one specimen: no confidence band")
    offset = fit.offset
    shown = offset.low[0] > 0.0 if offset.told else offset.value[0] > NOTED * fit.band.value.mean()
    if shown:
        kept = (
            'kept as a first rise; shear_offset = "remove" takes it off'
            if fit.kept
            else "taken off all couples"
        )
        lines.append(
            f"  the tests show a couple at 0°, {offset.words('N/m')}, friction of the machine or "
            f"the fabric: {kept}; empty = FILE takes off what the empty machine shows"
        )
    if fit.locking is None:
        lines.append("  no locking within the data")
    else:
        lines.append(f"  locking angle {fit.locking.words('°', 180.0 / math.pi)}: {DEFINITION}")
    lines += [f"  {each.words()}" for each in fits.disagreements]
    if fits.polynomial is not None:
        off = fits.polynomial[1]
        remedy = '; shear = "table" follows the tests' if off > FAR_OFF else ""
        lines.append(
            f"  polynomial: off the free curve by {100 * off:.2g} % of the largest couple at "
            f"most{remedy}"
        )
    return lines
