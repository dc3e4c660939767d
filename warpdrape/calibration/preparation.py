"""From rows as recorded to a curve of loading: preload, slack, toe, compliance, empty machine."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from warpdrape.calibration.raw_table import Specimen
from warpdrape.calibration.tests_file import Test
from warpdrape.coupons.closed_forms import COLLAPSE, bias_angle, frame_angle
from warpdrape.errors import InputError

BINS = 80
"""Points to which a curve is averaged, evenly spaced in what it is measured against."""
TOE_BETWEEN = (0.1, 0.3)
"""Shares of the largest force between which the line of a toe runs [-]."""
FEWEST = 8
"""Points of a curve below which it tells no law."""
BEGINS = 0.5
"""Share of the largest travel beyond which the first one is not a test's start [-]."""


@dataclass(frozen=True)
class LoadingCurve:
    """One specimen's curve while it was loaded.

    Attributes:
        name: of the specimen.
        at: shear angle [rad] or strain [-], rising, shape [n].
        force: [N], shape [n].
        raw_at: the same of every row of the loading, shape [m].
        raw_force: [N], shape [m].
        failed_at: strain at which the force was largest and then fell by a fifth; None if not.
        steps: what was done to it, in words.
        weight: in a fit with other specimens [-].
    """

    name: str
    at: np.ndarray
    force: np.ndarray
    raw_at: np.ndarray
    raw_force: np.ndarray
    failed_at: float | None = None
    steps: tuple[str, ...] = ()
    weight: float = 1.0


def loading_curves(test: Test) -> list[LoadingCurve]:
    """Curves of all specimens of a test that is pulled.

    Raises:
        InputError: a specimen has too few rows left, or goes beyond what its test can.
    """
    return [loading_curve(test, specimen) for specimen in test.specimens]


def loading_curve(test: Test, specimen: Specimen) -> LoadingCurve:
    """The curve of one specimen: machine, preload, slack, toe, loading, in this order."""
    values, steps = test.values, list[str]()
    travel, force = _less_machine(test, specimen, steps)
    travel, force = _from_preload(specimen, values, travel, force, steps)
    if "slack" in values:
        travel = travel - values["slack"]
        steps.append(f"slack of {1e3 * values['slack']:.3g} mm taken off")
    if test.toe == "line":
        travel = _less_toe(specimen, travel, force, steps)
    if abs(travel[0]) > BEGINS * travel.max():
        raise InputError(
            f"{specimen.file}: the travel of {specimen.name} does not count from the start of its "
            "test: give preload, or slack"
        )
    at = _abscissa(test, specimen, travel)
    at, force, failed_at = _loading(test, at, force)
    if "until" in values:
        kept = at <= values["until"]
        at, force = at[kept], force[kept]
        steps.append("cut off as until says")
    if len(at) < FEWEST or at[-1] <= at[0]:
        raise InputError(
            f"{specimen.file}: {specimen.name} has {len(at)} rows of loading, fewer than {FEWEST}: "
            "check its columns, preload, slack and until"
        )
    binned = in_bins(at, force)
    return LoadingCurve(specimen.name, *binned, at, force, failed_at, tuple(steps), specimen.weight)


def upwards(travel: np.ndarray, force: np.ndarray) -> tuple[float, float]:
    """Signs that make a record's travel count upwards, from wherever it begins, and its pull.

    Args:
        travel: as recorded, shape [n].
        force: likewise, less its tare [N], shape [n].
    """
    way = travel - travel[0]
    farthest, largest = way[np.argmax(np.abs(way))], force[np.argmax(np.abs(force))]
    return -1.0 if farthest < 0.0 else 1.0, -1.0 if largest < 0.0 else 1.0


def in_bins(at: np.ndarray, values: np.ndarray, bins: int = BINS) -> tuple[np.ndarray, np.ndarray]:
    """Means of points in even bins, of where they are and of their values; none of empty ones.

    Args:
        at: rising, shape [n].
        values: shape [n].
        bins: how many.
    """
    edges = np.linspace(at[0], at[-1], bins + 1)
    which = np.clip(np.searchsorted(edges, at, side="right") - 1, 0, bins - 1)
    count = np.bincount(which, minlength=bins)
    full = count > 0
    means = [np.bincount(which, v, bins)[full] / count[full] for v in (at, values)]
    return means[0], means[1]


def _travel(columns: Mapping[str, np.ndarray]) -> np.ndarray:
    """Travel [m], strain [-] or angle [rad] as it was recorded."""
    role = next(role for role in ("travel", "strain", "angle") if role in columns)
    return np.array(columns[role], dtype=float)


def _less_machine(
    test: Test, specimen: Specimen, steps: list[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Travel and force of a pull, both upwards, less what is the machine's.

    Off go the tare, the empty machine's force, and what the machine itself gave way; the table of
    the empty machine counts as that of the specimen.
    """
    values: Mapping[str, Any] = test.values
    travel, force = _travel(specimen.columns), np.array(specimen.columns["force"], dtype=float)
    if "tare" in values:
        force = force - values["tare"]
        steps.append(f"tare of {values['tare']:.3g} N taken off")
    signs = upwards(travel, force)
    if signs != (1.0, 1.0):
        travel, force = signs[0] * travel, signs[1] * force
        steps.append("signs turned: pulling was negative")
    pulled = force  # the machine gives way to all of it
    if test.empty is not None:
        way, rubbing = _travel(test.empty.columns), signs[1] * test.empty.columns["force"]
        way = upwards(way, rubbing)[0] * way
        order = np.argsort(way)
        force = force - np.interp(travel, way[order], rubbing[order])
        steps.append(f"force of the empty machine ({test.empty.file}) taken off")
        if travel.max() > 1.01 * way.max():
            steps.append("its last force beyond where it ends")
    if "compliance" in values:
        if "travel" not in specimen.columns:
            raise InputError(
                f"tests.{test.name}: compliance corrects a travel, and the table has none: leave "
                "it out"
            )
        travel = travel - values["compliance"] * pulled
        steps.append(f"machine's compliance {1e3 * values['compliance']:.3g} mm/N taken off")
    return travel, force


def _from_preload(
    specimen: Specimen,
    values: Mapping[str, Any],
    travel: np.ndarray,
    force: np.ndarray,
    steps: list[str],
) -> tuple[np.ndarray, np.ndarray]:
    """Count the travel from where the force first reaches the preload; it stays in the force."""
    if "preload" not in values:
        return travel, force
    preload = values["preload"]
    above = force >= preload
    if not above.any():
        raise InputError(
            f"{specimen.file}: {specimen.name} never reaches the preload of {preload:.4g} N; its "
            f"largest force is {force.max():.4g} N: check the units"
        )
    first = int(np.argmax(above))
    zero = travel[first]
    if first > 0 and force[first] > force[first - 1]:
        share = (preload - force[first - 1]) / (force[first] - force[first - 1])
        zero = travel[first - 1] + share * (travel[first] - travel[first - 1])
    steps.append(f"travel counted from the preload of {preload:.3g} N")
    return travel[first:] - zero, force[first:]


def _less_toe(
    specimen: Specimen, travel: np.ndarray, force: np.ndarray, steps: list[str]
) -> np.ndarray:
    """Count the travel from where a line through the curve's early part meets no force."""
    top = int(np.argmax(force))
    low, high = (share * force[top] for share in TOE_BETWEEN)
    part = np.flatnonzero((force[: top + 1] >= low) & (force[: top + 1] <= high))
    if len(part) < 3:
        raise InputError(
            f"{specimen.file}: {specimen.name} has fewer than three rows between "
            f"{TOE_BETWEEN[0]:.0%} and {TOE_BETWEEN[1]:.0%} of its force: give slack, not toe"
        )
    slope, level = np.polyfit(travel[part], force[part], 1)
    if slope <= 0.0:
        raise InputError(f"{specimen.file}: {specimen.name} does not rise at its start: no toe")
    zero = -level / slope
    steps.append(f"toe of {zero:.4g} (as recorded, SI) taken off")
    return travel - zero


def _abscissa(test: Test, specimen: Specimen, travel: np.ndarray) -> np.ndarray:
    """Shear angle [rad] or strain [-] of a travel."""
    if "travel" not in specimen.columns:
        sheared = test.kind != "uniaxial_tension" and "until" not in test.values
        if sheared and travel.max() >= COLLAPSE:
            raise InputError(
                f"{specimen.file}: {specimen.name} reaches {math.degrees(travel.max()):.4g}°: "
                "shear angles stay below 90°; check their unit"
            )
        return travel
    values = test.values
    if test.kind == "uniaxial_tension":
        return travel / values["gauge"]
    length = values["side"] if test.kind == "picture_frame" else values["height"] - values["width"]
    most = length * (2.0 - math.sqrt(2.0) if test.kind == "picture_frame" else math.sqrt(2.0) - 1.0)
    if travel.max() >= most and "until" not in values:
        raise InputError(
            f"{specimen.file}: {specimen.name} travels {1e3 * travel.max():.4g} mm, and at "
            f"{1e3 * most:.4g} mm yarns lie on each other: check unit and set-up, or give until"
        )
    size = np.abs(travel)
    if test.kind == "picture_frame":
        return np.sign(travel) * frame_angle(values["side"], size)
    return np.sign(travel) * bias_angle(values["width"], values["height"], size)


def _loading(
    test: Test, at: np.ndarray, force: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float | None]:
    """Rows that go beyond all before them, from zero on; of tension up to the largest force."""
    failed = None
    if test.kind == "uniaxial_tension":
        top = int(np.argmax(force))
        if top < len(force) - 1 and force[top:].min() < 0.8 * force[top]:
            failed = float(at[top])
        at, force = at[: top + 1], force[: top + 1]
    before = np.concatenate([[-np.inf], np.maximum.accumulate(at)[:-1]])
    kept = (at > before) & (at >= 0.0)
    return at[kept], force[kept], failed
