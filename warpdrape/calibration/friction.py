"""Friction from sleds: coefficients by pressure, speed and angle between yarns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from warpdrape.calibration.bands import Band, bootstrap
from warpdrape.calibration.preparation import upwards
from warpdrape.calibration.raw_table import Specimen
from warpdrape.calibration.tests_file import Test
from warpdrape.errors import InputError
from warpdrape.materials.friction import Friction

SAME = 0.03
"""Conditions that differ by less, as a share, are one and the same [-]."""
STEADY_FROM = 0.5
"""Share of a sled's travel after which it slides steadily, where the test says none [-]."""


@dataclass(frozen=True)
class Reading:
    """One specimen slid once.

    Attributes:
        test: name of its test.
        name: of the specimen.
        pressure: [Pa].
        speed: [m/s].
        yarns: angle between the plies' warp yarns [deg]; None where the test does not say.
        kinetic: coefficient while it slides [-].
        static: largest coefficient before [-]; None from a table of readings.
        weight: in a fit with other specimens [-].
    """

    test: str
    name: str
    pressure: float
    speed: float
    yarns: float | None
    kinetic: float
    static: float | None = None
    weight: float = 1.0


def readings(test: Test) -> list[Reading]:
    """Coefficients of a test's specimens.

    Raises:
        InputError: a record has no sliding in it, or a coefficient that is none.
    """
    angle = test.values.get("yarns")
    yarns = None if angle is None else float(np.degrees(angle))
    found = []
    for specimen in test.specimens:
        columns = specimen.columns
        if test.kind == "friction_table":
            rows = zip(columns["pressure"], columns["speed"], columns["friction"], strict=True)
            for number, (pressure, speed, value) in enumerate(rows, start=1):
                name = f"{specimen.name} {number}"
                found.append(
                    Reading(
                        test.name, name, pressure, speed, yarns, float(value), None, specimen.weight
                    )
                )
            continue
        found.append(_sled(test, specimen, yarns))
    for reading in found:
        if not 0.0 < reading.kinetic < 5.0:
            raise InputError(
                f"tests.{test.name}: {reading.name} has a friction coefficient of "
                f"{reading.kinetic:.4g}: check normal force, pressure, area and units"
            )
    return found


def _sled(test: Test, specimen: Specimen, yarns: float | None) -> Reading:
    """What one specimen's record shows while it slides steadily, and before."""
    normal, pressure = _pressed(test)
    columns = specimen.columns
    travel, force = columns["travel"], columns["force"] - test.values.get("tare", 0.0)
    signs = upwards(travel, force)
    travel, force = signs[0] * travel, signs[1] * force
    way = float(travel.max() - travel[0])
    start = test.values.get("steady_from", travel[0] + STEADY_FROM * way)
    steady = travel >= start
    if steady.sum() < 3:
        raise InputError(
            f"{specimen.file}: {specimen.name} has fewer than three rows after "
            f"{1e3 * start:.4g} mm, where it should slide steadily: check steady_from"
        )
    kinetic = float(force[steady].mean()) / normal
    static = float(force[~steady].max(initial=force[steady][0])) / normal
    speed, weight = test.values["speed"], specimen.weight
    return Reading(test.name, specimen.name, pressure, speed, yarns, kinetic, static, weight)


def _pressed(test: Test) -> tuple[float, float]:
    """Normal force [N] and pressure [Pa] of a sled."""
    values = test.values
    if "normal" not in values:
        return values["pressure"] * values["area"], values["pressure"]
    if "pressure" in values:
        return values["normal"], values["pressure"]
    return values["normal"], values["normal"] / values["area"]


@dataclass(frozen=True, eq=False)
class FrictionFit:
    """Coefficients of one interface.

    Attributes:
        levels: what it depends on ("pressure" [Pa], "speed" [m/s], "yarns" [deg]) → its levels.
        bands: the same → coefficient at each level, the others at their reference.
        reference: the same → the level at which the others were read.
        coefficient: at all references [-].
        apart: largest error of the product of factors over what a condition shows [-]; None where
            conditions are too few to tell.
        static: mean static over kinetic coefficient [-]; None where not recorded.
        readings: what it was fitted to.
    """

    levels: dict[str, np.ndarray]
    bands: dict[str, Band]
    reference: dict[str, float]
    coefficient: Band
    apart: float | None
    static: float | None
    readings: tuple[Reading, ...]

    def law(self, source: str) -> Friction:
        """As a scene takes it."""
        tables = {"pressure": "by_pressure", "speed": "by_speed", "yarns": "by_angle"}
        found: dict[str, Any] = {
            tables[name]: list(zip(self.levels[name].tolist(), band.value.tolist(), strict=True))
            for name, band in self.bands.items()
        }
        return Friction(coefficient=float(self.coefficient.value[0]), source=source, **found)


def fit_friction(found: Sequence[Reading], draws: int = 400) -> FrictionFit:
    """Factors by pressure, speed and angle that multiply: least squares of ln μ.

    Raises:
        InputError: the conditions do not tell their effects apart.
    """
    found = sorted(found, key=lambda r: (r.test, r.pressure, r.speed))
    design = _design(found)
    rows, levels = design.rows, design.levels
    logs = np.log([r.kinetic for r in found])
    conditions = [(r.test, *cell) for r, cell in zip(found, design.cells, strict=True)]
    groups = [conditions.count(c) for c in dict.fromkeys(conditions)]

    def solve(counts: np.ndarray) -> np.ndarray:
        root = np.sqrt(counts)[:, None]
        fitted = np.linalg.lstsq(root * rows, root[:, 0] * logs, rcond=None)[0]
        return np.exp(np.concatenate([fitted[:1], fitted[0] + fitted[1:]]))

    weights = np.array([r.weight for r in found])
    band = bootstrap(groups, solve, weights=weights, draws=draws, pool=False)
    bands = {}
    for name, at in levels.items():
        if len(at) > 1:
            bands[name] = band.part([design.names.get((name, k), 0) for k in range(len(at))])
    first = np.log(band.value[0])
    fitted = rows @ np.concatenate([[first], np.log(band.value[1:]) - first])
    off = []
    for cell in set(design.cells):
        same = [i for i, each in enumerate(design.cells) if each == cell]
        off.append(abs(np.expm1(fitted[same[0]] - float(np.mean(logs[same])))))
    statics = [r.static / r.kinetic for r in found if r.static is not None]
    return FrictionFit(
        levels,
        bands,
        design.reference,
        band.part([0]),
        float(max(off)) if len(off) > rows.shape[1] else None,
        float(np.mean(statics)) if statics else None,
        tuple(found),
    )


@dataclass(frozen=True, eq=False)
class _Design:
    """Which conditions readings have: levels, the reference of each, and rows for ln μ.

    Attributes:
        rows: a one, and a one for every level but the reference, shape [reading, unknown].
        names: (what, level's index) → its column.
        cells: indices of the levels of each reading.
    """

    rows: np.ndarray
    names: dict[tuple[str, int], int]
    levels: dict[str, np.ndarray]
    reference: dict[str, float]
    cells: list[tuple[int, ...]]


def _design(found: Sequence[Reading]) -> _Design:
    """Levels of all conditions; the one with the most readings is the reference."""
    columns, names, levels, which = [np.ones(len(found))], {}, {}, {}
    reference: dict[str, float] = {}
    for name in ("pressure", "speed", "yarns"):
        values = [getattr(r, name) for r in found]
        if any(v is None for v in values):
            continue
        levels[name], which[name] = _levels(np.array(values, dtype=float))
        middle = int(np.argmax(np.bincount(which[name])))
        reference[name] = float(levels[name][middle])
        for level in range(len(levels[name])):
            if level != middle:
                names[name, level] = len(columns)
                columns.append((which[name] == level).astype(float))
    rows = np.column_stack(columns)
    if np.linalg.matrix_rank(rows) < rows.shape[1]:
        raise InputError(
            "friction: pressure, speed and angle change together, so that their effects cannot be "
            "told apart: add tests that change one alone, against the same other conditions"
        )
    cells = [tuple(int(which[n][i]) for n in levels) for i in range(len(found))]
    return _Design(rows, names, levels, reference, cells)


def _levels(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distinct levels, rising, and which one each value has."""
    order = np.argsort(values)
    which = np.zeros(len(values), dtype=int)
    starts = [values[order[0]]]
    for k in order:
        if values[k] > starts[-1] * (1.0 + SAME) + 1e-12:
            starts.append(values[k])
        which[k] = len(starts) - 1
    return np.array([values[which == n].mean() for n in range(len(starts))]), which
