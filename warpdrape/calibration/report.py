"""What a calibration says: the tests as understood, and residuals."""

from __future__ import annotations

import csv
import io
import textwrap
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from warpdrape.calibration.coupons import CouponRun
from warpdrape.calibration.predictions import Prediction
from warpdrape.calibration.tests_file import Plan, Test
from warpdrape.results.run_folder import as_json, write_whole

WIDTH = 96


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
        f"{key} {value}"
        for key, value in test.given.items()
        if key not in ("kind", "files", "weight")
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
        weight = f", weight {specimen.weight:g}" if specimen.weight != 1.0 else ""
        lines.append(_wrap("    ", f"{specimen.name}: {rows} rows, {ranges}{weight}"))
    return lines


def _range(values: np.ndarray, factor: float, unit: str) -> str:
    return f"{values.min() / factor:.4g} to {values.max() / factor:.4g} {unit}".removesuffix(" -")


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
        row: dict[str, str | float | int] = {
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
    shown: list[tuple[str, ...]] = [head]
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
