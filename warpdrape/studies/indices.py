"""Sobol indices: which share of a measure's variance is due to which parameter (SALib).

Of a design "indices": first-order and total, by Saltelli's scheme. Of any other random design of
enough runs: first-order ones alone, by RBD-FAST, which takes runs as they come.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from warpdrape.optional import needed
from warpdrape.studies.design import Design, cube
from warpdrape.studies.table import Table

LEAST_RUNS = 200
"""Runs below which RBD-FAST is not asked: its 95 % interval of small indices was ±0.6 at 64."""
SEED = 1
"""Of the resampling by which confidence is judged: the same runs give the same."""


@dataclass(frozen=True)
class Index:
    """The share of a measure's variance that is due to a parameter.

    Attributes:
        measure: its name.
        parameter: its name.
        first: by itself [-].
        first_95: half width of its 95 % confidence interval [-].
        total: with all its interactions [-]; NaN where not known.
        total_95: likewise [-].
        method: "Saltelli" or "RBD-FAST".
        runs: that went into it.
    """

    measure: str
    parameter: str
    first: float
    first_95: float
    total: float
    total_95: float
    method: str
    runs: int


def indices(table: Table, design: Design) -> tuple[list[Index], str]:
    """Indices of every measure and parameter, and a remark on what was left out.

    Args:
        table: of the study.
        design: how its runs were chosen.
    """
    if design.kind == "indices":
        return _saltelli(table, design)
    if design.kind in ("latin", "sobol") and len(table.parameters) > 0:
        return _rbd_fast(table, design)
    return [], "Sobol indices need a random design: kind = 'indices', 'latin' or 'sobol'."


def _saltelli(table: Table, design: Design) -> tuple[list[Index], str]:
    count = len(table.parameters)
    block = design.block_of(count)
    analyze = needed("SALib.analyze.sobol", "studies").analyze
    found, lost = [], 0
    for measure in table.measures:
        blocks = table.numbers(measure).reshape(-1, block)
        whole = np.isfinite(blocks).all(axis=1)
        lost = max(lost, int((~whole).sum()))
        values = blocks[whole].ravel()
        if whole.sum() < 2 or np.ptp(values) == 0.0:
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            got = analyze(
                cube(count, table.parameters),
                values,
                calc_second_order=design.second_order,
                seed=SEED,
            )
        found += [
            Index(
                measure,
                name,
                first=float(got["S1"][k]),
                first_95=float(got["S1_conf"][k]),
                total=float(got["ST"][k]),
                total_95=float(got["ST_conf"][k]),
                method="Saltelli",
                runs=len(values),
            )
            for k, name in enumerate(table.parameters)
        ]
    words = f"{lost} of {design.runs} samples are left out, as runs of them failed." if lost else ""
    return found, words


def _rbd_fast(table: Table, design: Design) -> tuple[list[Index], str]:
    shares = design.shares(len(table.parameters))
    analyze = needed("SALib.analyze.rbd_fast", "studies").analyze
    found = []
    for measure in table.measures:
        values = table.numbers(measure)
        there = np.isfinite(values)
        if there.sum() < LEAST_RUNS:
            return (
                [],
                f"Sobol indices need {LEAST_RUNS} runs that completed, or a design 'indices'.",
            )
        if np.ptp(values[there]) == 0.0:
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            got = analyze(
                cube(len(table.parameters), table.parameters),
                shares[there],
                values[there],
                seed=SEED,
            )
        found += [
            Index(
                measure,
                name,
                float(got["S1"][k]),
                float(got["S1_conf"][k]),
                np.nan,
                np.nan,
                "RBD-FAST",
                int(there.sum()),
            )
            for k, name in enumerate(table.parameters)
        ]
    return found, ""
