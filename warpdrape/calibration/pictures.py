"""One picture per test: raw curves, the card's own over them, and the coupon's."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import cast

import numpy as np

from warpdrape.calibration.bands import LEVEL
from warpdrape.calibration.coupons import CouponRun
from warpdrape.calibration.fits import SHEAR, Fits
from warpdrape.calibration.friction_picture import draw_friction
from warpdrape.calibration.normalisation import normalised_force
from warpdrape.calibration.polynomial import powers
from warpdrape.calibration.predictions import Prediction
from warpdrape.calibration.report import coupon_of
from warpdrape.calibration.shear import ShearFit
from warpdrape.calibration.tests_file import Plan, Test
from warpdrape.results.figures import Figure
from warpdrape.results.run_folder import write_whole

RAW, CARD, COUPON = "0.65", "C3", "C0"
_UNITS = {
    "[rad]": (180.0 / math.pi, "[°]"),
    "[m]": (1e3, "[mm]"),
    "[Pa]": (1e-3, "[kPa]"),
    "[N·m]": (1e3, "[N·mm]"),
    "strain [-]": (100.0, "strain [%]"),
}


def draw_tests(
    plan: Plan, fits: Fits, found: Sequence[Prediction], coupons: Sequence[CouponRun], folder: Path
) -> list[Path]:
    """Draw every test that the card can be laid over; tests of one interface together.

    Args:
        plan: the tests.
        fits: for bands, and curves of other tests.
        found: predictions of all specimens.
        coupons: runs beside them.
        folder: that takes a file NAME.png for each test.
    """
    paths = []
    for test in plan.tests:
        own = [each for each in found if each.test == test.name]
        if not own or "against" in test.values:
            continue
        groups = list(dict.fromkeys((each.over, each.what) for each in own))
        second = test.kind in SHEAR
        columns = len(groups) + second
        figure = Figure(figsize=(6.2 * columns, 4.4), dpi=130, layout="constrained")
        axes = np.atleast_1d(figure.subplots(1, columns))
        for at, group in zip(axes, groups, strict=False):
            members = [each for each in own if (each.over, each.what) == group]
            _draw(at, members, coupon_of(members[0], coupons), readings=_readings(test))
        if second:
            _normalised(axes[-1], test, fits)
        figure.suptitle(f"{test.name}: {test.about.words}")
        path = folder / f"{test.name}.png"
        write_whole(path, figure.savefig)
        paths.append(path)
    for face, fit in fits.friction.items():
        paths.append(folder / f"friction_{face}.png")
        write_whole(paths[-1], draw_friction(face, fit).savefig)
    return paths


def _readings(test: Test) -> bool:
    """Whether its values are single readings, no curves."""
    return test.kind == "cantilever"


def _label(text: str) -> tuple[float, str]:
    """Factor and label in units that people read."""
    for unit, (factor, shown) in _UNITS.items():
        if text.endswith(unit):
            return factor, text.removesuffix(unit) + shown
    return 1.0, text


def _draw(axes, own: Sequence[Prediction], coupon: CouponRun | None, readings: bool) -> None:
    """Specimens and card; beyond the card's data a line of its own kind."""
    across, over = _label(own[0].over)
    up, what = _label(own[0].what)
    for number, each in enumerate(own):
        label = "specimens" if number == 0 else None
        style = "o" if readings else "-"
        axes.plot(across * each.at, up * each.measured, style, color=RAW, lw=0.9, ms=4, label=label)
    loop = own[0].over.startswith("curvature")
    for number, each in enumerate(own[:1] if loop else own):
        _card_line(axes, each, across, up, readings, labelled=number == 0)
    if coupon is not None:
        if len(coupon.at) == 1:
            axes.axhline(up * coupon.values[0], color=COUPON, ls="--", label="coupon, simulated")
        else:
            calm = coupon.at >= (coupon.calm_from if coupon.calm_from is not None else np.inf)
            every = calm & (np.arange(len(calm)) % 2 == 0)
            axes.plot(
                across * coupon.at[every],
                up * coupon.values[every],
                "+",
                color=COUPON,
                ms=7,
                label="coupon, simulated",
            )
    if own[0].over.startswith("pressure"):
        axes.set_xscale("log")
    if readings:
        axes.set_ylim(bottom=0.0)
        if own[0].over == "strip":
            axes.set_xticks(own[0].at)
    axes.set(xlabel=over, ylabel=what)
    axes.grid(alpha=0.3)
    axes.legend(frameon=False, fontsize="small")


def _card_line(
    axes, each: Prediction, across: float, up: float, readings: bool, labelled: bool
) -> None:
    at, said = across * each.at, up * each.predicted
    if readings:
        axes.plot(at, said, "x", color=CARD, ms=7, label="card" if labelled else None)
        return
    loop = each.over.startswith("curvature")
    inside = np.ones(len(at), dtype=bool) if loop else each.at <= each.end * (1.0 + 1e-9)
    axes.plot(at[inside], said[inside], color=CARD, lw=1.6, label="card" if labelled else None)
    if not inside.all():
        beyond = np.flatnonzero(~inside)
        label = "card, extrapolated"
        known = axes.get_legend_handles_labels()[1]
        axes.plot(
            at[beyond],
            said[beyond],
            ":",
            color=CARD,
            lw=1.4,
            label=None if label in known else label,
        )


def _normalised(axes, test: Test, fits: Fits) -> None:
    """Normalised shear force: each specimen by the published steps, each kind's fit and band."""
    for number, specimen in enumerate(s for s in fits.shear_apart[test.kind].specimens):
        if specimen.test != test.name:
            continue
        axes.plot(
            np.degrees(specimen.angle),
            1e-3 * normalised_force(specimen.angle, specimen.couple),
            color=RAW,
            lw=0.8,
            label="specimens, normalised" if number == 0 else None,
        )
    for number, (kind, fit) in enumerate(fits.shear_apart.items()):
        angle = np.linspace(0.0, fit.basis.end, 200)
        color = f"C{(2, 4, 5)[number]}"
        low, high = (np.interp(angle, fit.angles, v) for v in (fit.band.low, fit.band.high))
        label = kind.replace("_", " ")
        if fit.band.told:
            label += f", {LEVEL:.0%} band"
            wide = [1e-3 * normalised_force(angle, v) for v in (low, high)]
            axes.fill_between(np.degrees(angle), *wide, color=color, alpha=0.3, lw=0)
        force = 1e-3 * normalised_force(angle, fit.couple(angle))
        axes.plot(np.degrees(angle), force, color=color, lw=1.4, label=label)
    whole = cast(ShearFit, fits.shear)  # as there is a test of it
    if len(fits.shear_apart) > 1 or fits.polynomial is not None:
        angle = np.linspace(0.0, whole.basis.end, 200)
        couple = whole.couple(angle)
        if fits.polynomial is not None:
            couple = powers(angle) @ fits.polynomial[0].value
        force = 1e-3 * normalised_force(angle, couple)
        axes.plot(np.degrees(angle), force, "--", color=CARD, lw=1.4, label="card")
    if whole.locking is not None:
        at = math.degrees(whole.locking.value[0])
        axes.axvline(at, color="0.4", lw=0.8, ls=":", label=f"locking {at:.1f}°")
    axes.set(xlabel="shear angle [°]", ylabel="normalised shear force [N/mm]", ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend(frameon=False, fontsize="small")
