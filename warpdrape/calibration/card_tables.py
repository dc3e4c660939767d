"""Fits as the tables of a card: values, and sources that say from which files and how sure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from warpdrape.calibration.bands import LEVEL, Band
from warpdrape.calibration.biaxial_table import TableFit
from warpdrape.calibration.card_file import quantity
from warpdrape.calibration.compaction import CompactionFit
from warpdrape.calibration.fits import SHEAR, Fits
from warpdrape.calibration.kinds import FAMILIES
from warpdrape.calibration.locking import DEFINITION
from warpdrape.calibration.shear import ShearFit
from warpdrape.calibration.tests_file import Plan, Test

Tables = dict[str, Any]


def source_of(tests: Sequence[Test]) -> str:
    """Where a value comes from: kinds of test, specimens and files."""
    parts = []
    for test in tests:
        count = len(test.specimens)
        words = f"{test.about.words}, {count} specimen{'s' if count != 1 else ''}"
        note = f"; {test.note}" if test.note else ""
        parts.append(f"{words} ({_files(test.files)}{note})")
    return "; ".join(parts)


def _files(names: Sequence[str]) -> str:
    if len(names) <= 3:
        return ", ".join(names)
    return f"{names[0]} to {names[-1]}, {len(names)} files"


def band_words(band: Band, where: Sequence[str] = ()) -> str:
    """How wide a band is, as a share of its value where that is largest."""
    if not band.told:
        return "one specimen of a test: no confidence band"
    share = 0.5 * (band.high - band.low) / np.maximum(np.abs(band.value), 1e-300)
    of = " at " + " and ".join(where) if where else ""
    shown = " and ".join(f"{100 * s:.2g} %" for s in np.atleast_1d(share)[-max(1, len(where)) :])
    return f"{LEVEL:.0%} band over {band.specimens} or more specimens a test: ±{shown}{of}"


def card_tables(plan: Plan, fits: Fits) -> Tables:
    """Tables that the tests give a card; they replace its own."""
    tables: Tables = {}
    if fits.shear is not None:
        tables |= _shear(plan, fits, fits.shear)
    tables |= _tension(plan, fits)
    if fits.loops or fits.cantilevers:
        tables["bending"] = _bending(plan, fits)
    if fits.compaction is not None:
        tables |= _compaction(plan, fits, fits.compaction)
    return tables


def _shear(plan: Plan, fits: Fits, fit: ShearFit) -> Tables:
    kinds = {s.kind for s in fit.specimens}
    tests = [t for t in plan.of(*SHEAR) if t.kind in kinds]
    source = source_of(tests)
    area = fits.draft.cell_area
    end = math.degrees(fit.basis.end)
    half = len(fit.angles) // 2
    middle = fit.band.part([half, -1])
    where = (f"{math.degrees(fit.angles[half]):.3g}°", f"{end:.3g}°")
    doubt = f"{band_words(middle, where)}; data end at {end:.3g}°, beyond it is extrapolated"
    if not fit.kept:
        doubt += f"; an offset of {fit.offset.value[0]:.3g} N/m at 0° was taken off"
    found: Tables = {}
    if fits.polynomial is not None:
        band, off = fits.polynomial
        doubt += f"; the polynomial is off a free curve by {100 * off:.2g} % of the largest couple"
        coefficients = quantity(1e3 * area * band.value, "N·mm", source, doubt)
        found["shear"] = {"law": "polynomial", "coefficients": coefficients}
    else:
        couples = 1e3 * area * np.maximum.accumulate(np.maximum(fit.band.value, 0.0))
        couples[0] = 0.0
        found["shear"] = {
            "law": "table",
            "angles": quantity(np.degrees(fit.angles), "deg", source),
            "couples": quantity(couples, "N·mm", source, doubt),
        }
    if fit.locking is not None:
        degrees = np.degrees(fit.locking.value[0])
        found["locking_angle"] = quantity(
            degrees, "deg", source, f"{DEFINITION}; {fit.locking.words('°', 180.0 / math.pi)}"
        )
    return found


def _tension(plan: Plan, fits: Fits) -> Tables:
    found: Tables = {}
    for family, band in fits.failure.items():
        own = [t for t in plan.of("uniaxial_tension") if t.values["family"] == family]
        found[f"failure_strain_{family}"] = quantity(
            100 * band.value[0],
            "%",
            source_of(own),
            f"strain at the largest force, crimp and slack in it; {band_words(band)}",
        )
    if fits.linear:
        found["tension"] = _linear(plan, fits)
    elif fits.crimp is not None:
        found["tension"] = _crimp(plan, fits.crimp)
    elif fits.table is not None:
        found["tension"] = _tension_table(plan, fits.table)
    return found


def _linear(plan: Plan, fits: Fits) -> Tables:
    law: Tables = {"law": "linear"}
    for family, fit in fits.linear.items():
        own = [t for t in plan.of("uniaxial_tension") if t.values["family"] == family]
        doubt = (
            f"{band_words(fit.stiffness)}; of the upper half of the force: the strips' line "
            f"starts at a strain of {100 * fit.start.value[0]:.2g} % (crimp, slack), which the "
            f"law leaves out; data end at {100 * fit.end:.3g} %"
        )
        law[family] = quantity(fit.stiffness.value[0], "N", source_of(own), doubt)
    return law


def _crimp(plan: Plan, band: Band) -> Tables:
    source = source_of(plan.of("uniaxial_tension", "biaxial_tension"))
    law: Tables = {"law": "crimp"}
    for k, name in enumerate(("crimp_warp", "crimp_weft", "stiffness_warp", "stiffness_weft")):
        factor, unit = (100.0, "%") if k < 2 else (1.0, "N")
        doubt = band_words(band.part([k]))
        law[name] = quantity(factor * band.value[k], unit, source, doubt)
    return law


def _tension_table(plan: Plan, fit: TableFit) -> Tables:
    source = source_of(plan.of("biaxial_tension"))
    beyond, total = int(fit.beyond.sum()), fit.beyond.size
    doubt = "data near every point of the table"
    if beyond:
        doubt = f"{beyond} of {total} points of the table have no data near them: extrapolated"
    law: Tables = {"law": "table"}
    for family, axis in zip(FAMILIES, fit.strains, strict=True):
        law[f"strain_{family}"] = quantity(100 * axis, "%", source)
    for number, family in enumerate(FAMILIES):
        law[f"tension_{family}"] = quantity(fit.table(number), "N", source, doubt)
    return law


def _bending(plan: Plan, fits: Fits) -> Tables:
    if plan.laws["bending"] == "curve":
        return _bending_curve(plan, fits)
    law: Tables = {"law": "linear"}
    for family in FAMILIES:
        if family in fits.cantilevers:
            band = fits.cantilevers[family].stiffness
            tests = [t for t in plan.of("cantilever") if t.values["family"] == family]
            doubt = band_words(band)
        else:
            loop = fits.loops[family]
            tests = [t for t in plan.of("bending_loop") if t.values["family"] == family]
            band, doubt = loop_stiffness(loop)
        law[family] = quantity(1e3 * band.value[0], "N·mm", source_of(tests), doubt)
    return law


def loop_stiffness(loop: Any) -> tuple[Band, str]:
    """B of a loop, by Kawabata where it reaches so far; else its last moment over curvature."""
    if loop.stiffness is not None:
        return loop.stiffness, f"slope between 0.5 and 1.5 1/cm; {band_words(loop.stiffness)}"
    end = loop.curvatures[-1]
    moments = loop.moments
    value, low, high = (v[-1:] / end for v in (moments.value, moments.low, moments.high))
    band = Band(value, low, high, moments.specimens, moments.told)
    return band, f"moment over curvature at {end:.3g} 1/m, without friction; {band_words(band)}"


def _bending_curve(plan: Plan, fits: Fits) -> Tables:
    loops = fits.loops
    tests = plan.of("bending_loop")
    source = source_of(tests)
    end = min(loops[f].curvatures[-1] for f in FAMILIES)
    curvatures = np.linspace(0.0, end, len(loops["warp"].curvatures))
    law: Tables = {"law": "curve", "curvatures": quantity(curvatures, "1/m", source)}
    over = float(np.mean([loops[f].over for f in FAMILIES]))
    for family in FAMILIES:
        loop = loops[family]
        moments = np.maximum.accumulate(loop.basis.rows(curvatures) @ loop.coefficients)
        own = source_of([t for t in tests if t.values["family"] == family])
        last = loop.moments.part([-1])
        doubt = f"{band_words(last, (f'{loop.curvatures[-1]:.3g} 1/m',))}; extrapolated beyond"
        moments[0] = 0.0
        law[f"moments_{family}"] = quantity(1e3 * moments, "mN", own, doubt)
        law[f"friction_{family}"] = quantity(
            1e3 * loop.friction.value[0], "mN", own, band_words(loop.friction)
        )
    each = ", ".join(f"{family} {loops[family].over:.3g}" for family in FAMILIES)
    law["friction_curvature"] = quantity(
        over, "1/m", source, f"mean of both families' fits: {each} 1/m; no band"
    )
    return law


def _compaction(plan: Plan, fits: Fits, fit: CompactionFit) -> Tables:
    source = source_of(plan.of("compaction"))
    thicknesses, pressures = fit.table
    both = fit.thickness.part([0, -1])
    where = (f"{fit.pressures[0] / 1e3:.3g} kPa", f"{fit.pressures[-1] / 1e3:.3g} kPa")
    doubt = f"{band_words(both, where)}; extrapolated beyond"
    found: Tables = {
        "thickness": quantity(
            1e3 * thicknesses[0],
            "mm",
            source,
            f"under {where[0]}, where contact is taken to begin; {band_words(fit.thickness)}",
        )
    }
    power = plan.laws["compaction"] == "power"
    if power and fit.coefficient is not None and fit.exponent is not None:
        density: Mapping[str, Any] = plan.fabric["fibre_density"]
        found["compaction"] = {
            "law": "power",
            "coefficient": quantity(fit.coefficient.value[0], "-", source, doubt),
            "exponent": quantity(fit.exponent.value[0], "-", source, band_words(fit.exponent)),
            "fibre_density": dict(density),
            "largest_pressure": quantity(fit.pressures[-1] / 1e3, "kPa", source),
        }
    else:
        found["compaction"] = {
            "law": "table",
            "thicknesses": quantity(1e3 * thicknesses, "mm", source, doubt),
            "pressures": quantity(
                pressures / 1e3, "kPa", source, f"less the {where[0]} at which contact begins"
            ),
        }
    return found
