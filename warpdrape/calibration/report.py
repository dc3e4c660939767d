"""What a calibration says: the tests as understood, the laws with their bands, and residuals."""

from __future__ import annotations

import csv
import io
import math
import textwrap
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from warpdrape.calibration.bands import LEVEL
from warpdrape.calibration.coupons import CouponRun
from warpdrape.calibration.fits import Fits
from warpdrape.calibration.locking import DEFINITION
from warpdrape.calibration.predictions import Prediction
from warpdrape.calibration.tests_file import Plan, Test
from warpdrape.results.run_folder import as_json, write_whole

WIDTH = 96
FAR_OFF = 0.03
"""Distance of a polynomial from the free curve that calls for a table [-]."""
NOTED = 0.1
"""Offset of one specimen, over the mean couple, from which on it is worth a word [-]."""


def understood(plan: Plan) -> str:
    """What a file of tests and its raw tables were taken for; of ``--dry``."""
    lines = [f"{plan.file}: {len(plan.tests)} tests, for the card of {plan.fabric['name']!r}"]
    lines.append("laws: " + ", ".join(f"{k} {v}" for k, v in plan.laws.items()))
    for test in plan.tests:
        lines += ["", *_test_lines(test)]
    return "\n".join(lines)


def _test_lines(test: Test) -> list[str]:
    count = len(test.specimens)
    head = f"{test.name}: {test.about.words}, {count} specimen{'s' if count != 1 else ''}"
    values = ", ".join(
        f"{key} {value}" for key, value in test.given.items() if key not in ("kind", "files")
    )
    lines = [head + (f"; {values}" if values else "")]
    said = ""
    for specimen in test.specimens:
        rows = len(next(iter(specimen.columns.values())))
        ranges = ", ".join(
            f"{role} {_range(values, *specimen.units[role])}"
            for role, values in specimen.columns.items()
        )
        how = f"{specimen.file}: " + "; ".join(specimen.understood)
        if how.partition(": ")[2] != said:
            lines.append(_wrap("  ", how))
            said = how.partition(": ")[2]
        lines.append(_wrap("    ", f"{specimen.name}: {rows} rows, {ranges}"))
    return lines


def _range(values: np.ndarray, factor: float, unit: str) -> str:
    return f"{values.min() / factor:.4g} to {values.max() / factor:.4g} {unit}".removesuffix(" -")


def law_lines(fits: Fits) -> list[str]:
    """Every law that was fitted, in words, with its band."""
    lines: list[str] = []
    if fits.shear is not None:
        lines += _shear_lines(fits)
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
            band = f" ({LEVEL:.0%} band {low:.4g} to {high:.4g})" if fits.crimp.told else ""
            lines.append(f"{name}: {value:.4g} {unit}{band}")
    if fits.table is not None:
        beyond = int(fits.table.beyond.sum())
        lines.append(
            f"tension table: {fits.table.beyond.size} points, {beyond} of them extrapolated"
        )
    for family, fit in fits.cantilevers.items():
        lines.append(f"bending of {family}, cantilever: B = {fit.stiffness.words('N·mm', 1e3)}")
    for family, fit in fits.loops.items():
        if fit.stiffness is not None:
            lines.append(f"bending of {family}, Kawabata: B = {fit.stiffness.words('N·mm', 1e3)}")
        if fit.width is not None:
            lines.append(f"  2HB = {fit.width.words('mN', 1e3)} at 1 1/cm")
        lines.append(
            f"  friction of the fit {fit.friction.words('mN', 1e3)}, built up over "
            f"{fit.over:.3g} 1/m"
        )
        if family in fits.cantilevers and fit.stiffness is not None:
            ratio = fit.stiffness.value[0] / fits.cantilevers[family].stiffness.value[0]
            lines.append(f"  Kawabata's B over the cantilever's: {ratio:.3g}")
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
    if fits.compaction is not None:
        fit, shown = fits.compaction, []
        for k in (0, -1):
            shown.append(
                f"{1e3 * fit.thickness.value[k]:.4g} mm at {fit.pressures[k] / 1e3:.3g} kPa"
            )
        lines.append("thickness of a ply: " + ", ".join(shown))
        if fit.coefficient is not None:
            lines.append(
                f"  V_f = a p^b: a = {fit.coefficient.words()}, b = {fit.exponent.words()}"
            )
    return lines


def _at(name: str, value: float) -> str:
    shown = {"pressure": (1e-3, "kPa"), "speed": (1e3, "mm/s"), "yarns": (1.0, "°")}
    factor, unit = shown[name]
    return f"{factor * value:.3g} {unit}"


def _shear_lines(fits: Fits) -> list[str]:
    fit = fits.shear
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


def residual_rows(
    found: Sequence[Prediction], coupons: Sequence[CouponRun]
) -> list[dict[str, str | float | int]]:
    """A row for each specimen: mean, root mean square and largest error of card and coupon.

    Errors are shares of the specimen's largest value, within the card's data; the coupon's where
    inertia bears little of its force.
    """
    rows = []
    for each in found:
        errors = each.errors
        if not len(errors):
            continue
        row = {
            "test": each.test,
            "specimen": each.specimen,
            "value": each.what,
            "points": len(errors),
            "mean_error": float(errors.mean()),
            "rms_error": float(np.sqrt(np.mean(errors**2))),
            "largest_error": float(errors[np.argmax(np.abs(errors))]),
            "coupon_mean_error": "",
            "coupon_rms_error": "",
        }
        run = coupon_of(each, coupons)
        if run is not None:
            off = _coupon_errors(each, run)
            if len(off):
                row["coupon_mean_error"] = float(off.mean())
                row["coupon_rms_error"] = float(np.sqrt(np.mean(off**2)))
        rows.append(row)
    return rows


def coupon_of(each: Prediction, coupons: Sequence[CouponRun]) -> CouponRun | None:
    """The coupon's run that belongs beside a specimen; None without one."""
    family = each.over.partition(" strain")[0]
    for run in coupons:
        if run.test in (each.test, f"{each.test}, {family}") and not run.wrong:
            return run
    return None


def _coupon_errors(each: Prediction, run: CouponRun) -> np.ndarray:
    largest = float(np.abs(each.measured).max())
    if len(run.at) == 1:
        return (run.values[0] - each.measured) / largest
    if run.calm_from is None:
        return np.zeros(0)
    inside = (each.at >= max(run.calm_from, run.at[0])) & (each.at <= run.at[-1])
    said = np.interp(each.at[inside], run.at, run.values)
    return (said - each.measured[inside]) / largest


def residual_text(rows: Sequence[dict]) -> str:
    """The table of residuals for a terminal."""
    head = ("test", "specimen", "mean", "rms", "largest", "coupon mean", "rms")
    keys = ("mean_error", "rms_error", "largest_error", "coupon_mean_error", "coupon_rms_error")
    shown = [head]
    for row in rows:
        cells = ("-" if row[k] == "" else f"{100 * row[k]:.1f} %" for k in keys)
        shown.append((str(row["test"]), str(row["specimen"]), *cells))
    widths = [max(len(r[i]) for r in shown) for i in range(len(head))]
    return "\n".join(
        "  ".join(
            c.ljust(w) if i < 2 else c.rjust(w)
            for i, (c, w) in enumerate(zip(r, widths, strict=True))
        ).rstrip()
        for r in shown
    )


def write_residuals(path: Path, rows: Sequence[dict]) -> None:
    """The table of residuals as a file, in one move."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    if rows:
        writer.writerow(rows[0])
    writer.writerows([as_json(v, f"residuals: {k}") for k, v in row.items()] for row in rows)
    write_whole(path, lambda p: p.write_text(text.getvalue(), "utf-8", newline="\n"))


def _wrap(indent: str, text: str) -> str:
    return textwrap.fill(text, WIDTH, initial_indent=indent, subsequent_indent=indent + "  ")
