"""Designs: which values the parameters of each run have.

Latin hypercubes and Sobol sequences are scipy's (`scipy.stats.qmc`), the sample of Sobol indices is
SALib's (Saltelli's scheme on a scrambled Sobol sequence).
"""

from __future__ import annotations

import csv
import itertools
import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import qmc

from warpdrape.errors import InputError, nearest, said
from warpdrape.optional import needed
from warpdrape.studies.parameters import Varied

KEYS = {
    "grid": ("steps",),
    "list": ("rows", "file"),
    "latin": ("runs", "seed"),
    "sobol": ("runs", "seed"),
    "indices": ("samples", "seed", "second_order"),
}
"""Kind of design → what more may be said of it."""
STEPS = 3
"""Values of each range on a grid, where nothing is asked."""
MOST = 1_000_000
"""Runs of a study at most: more is a slip of the pen."""

Row = dict[str, Any]
"""A run's parameters by name."""


@dataclass(frozen=True)
class Design:
    """How runs are chosen.

    Attributes:
        kind: one of `KEYS`.
        rows: of a list, as written.
        steps: values of each range on a grid.
        runs: of a Latin hypercube or Sobol sequence; for indices the samples of Saltelli's scheme.
        seed: of what is random.
        second_order: whether indices of pairs of parameters are wanted, at twice the runs.
    """

    kind: str
    rows: tuple[Mapping[str, Any], ...] = ()
    steps: int = STEPS
    runs: int = 0
    seed: int = 1
    second_order: bool = False

    @property
    def block(self) -> int:
        """Runs to a sample of Saltelli's scheme over the number of parameters; see `block_of`."""
        return 2 if self.second_order else 1

    def block_of(self, parameters: int) -> int:
        """Runs to a sample of Saltelli's scheme."""
        return self.block * parameters + 2

    def make(self, parameters: Sequence[Varied]) -> list[Row]:
        """The runs, each with a value for every parameter.

        Raises:
            InputError: if there are too many, or a row of a list is wrong.
        """
        if self.kind == "list":
            return [_row(number, row, parameters) for number, row in enumerate(self.rows)]
        if self.kind == "grid":
            axes = [parameter.steps(self.steps) for parameter in parameters]
            _check_count(math.prod(map(len, axes)))
            names = [parameter.name for parameter in parameters]
            return [dict(zip(names, row, strict=True)) for row in itertools.product(*axes)]
        return [
            {p.name: p.at(float(u)) for p, u in zip(parameters, shares, strict=True)}
            for shares in self.shares(len(parameters))
        ]

    def shares(self, count: int) -> np.ndarray:
        """Points of the unit cube, shape [run, parameter].

        Args:
            count: of parameters.
        """
        random = np.random.default_rng(self.seed)
        if self.kind == "latin":
            return qmc.LatinHypercube(count, seed=random).random(self.runs)
        if self.kind == "sobol":
            with warnings.catch_warnings():  # said where the study is read
                warnings.simplefilter("ignore", UserWarning)
                return qmc.Sobol(count, seed=random).random(self.runs)
        sample = needed("SALib.sample.sobol", "studies").sample
        problem = cube(count)
        return sample(problem, self.runs, calc_second_order=self.second_order, seed=self.seed)


def cube(count: int, names: Sequence[str] = ()) -> dict[str, Any]:
    """The unit cube of so many parameters, as SALib wants it."""
    names = list(names) or [str(k) for k in range(count)]
    return {"num_vars": count, "names": names, "bounds": [[0.0, 1.0]] * count}


def read_design(given: Any, folder: Path) -> Design:
    """Read the design of a study.

    Args:
        given: its table.
        folder: of the study file, in which a list's file is looked for.

    Raises:
        InputError: an unknown kind, or numbers that make no sense.
    """
    if not isinstance(given, Mapping) or "kind" not in given:
        raise InputError(f"[design] needs kind, one of {', '.join(KEYS)}")
    kind = given["kind"]
    if kind not in KEYS:
        raise InputError(f"design: kind = {said(kind)} is unknown{nearest(kind, KEYS)}")
    for key in given:
        if key not in ("kind", *KEYS[kind]):
            raise InputError(f"design {kind}: {key!r} is unknown{nearest(key, KEYS[kind])}")
    if kind == "list":
        return Design(kind, rows=_rows(given, folder))
    if kind == "grid":
        return Design(kind, steps=_whole("steps", given.get("steps", STEPS), 2))
    count = "samples" if kind == "indices" else "runs"
    if count not in given:
        raise InputError(f"design {kind} needs {count}, how many")
    runs, seed = _whole(count, given[count], 2), _whole("seed", given.get("seed", 1), 0)
    _check_count(runs)
    if kind != "latin" and runs & (runs - 1):
        raise InputError(
            f"design {kind}: {count} = {runs} must be a power of two, for which a Sobol sequence "
            f"fills its space evenly: {2 ** (runs.bit_length() - 1)} or {2 ** runs.bit_length()}"
        )
    second = given.get("second_order", False)
    if not isinstance(second, bool):
        raise InputError(f"design: second_order = {said(second)} must be true or false")
    return Design(kind, runs=runs, seed=seed, second_order=second)


def _rows(given: Mapping[str, Any], folder: Path) -> tuple[Mapping[str, Any], ...]:
    if ("rows" in given) == ("file" in given):
        raise InputError("design list needs rows = [{name = value, ...}, ...] or file = FILE.csv")
    if "rows" in given:
        rows = given["rows"]
        if not isinstance(rows, list) or not rows or not all(isinstance(r, Mapping) for r in rows):
            raise InputError("design list: rows must be a list of tables, [{name = value, ...}]")
        return tuple(rows)
    path = folder / str(given["file"])
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = [dict(row) for row in csv.DictReader(file)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"design list: {path} cannot be read ({error})") from error
    if not rows or any(None in row or None in row.values() for row in rows):
        raise InputError(
            f"design list: {path} must have a line of names, and as many values in each line below"
        )
    return tuple(rows)


def _row(number: int, given: Mapping[str, Any], parameters: Sequence[Varied]) -> Row:
    names = [parameter.name for parameter in parameters]
    if set(given) != set(names):
        odd = sorted(set(given) ^ set(names))
        raise InputError(
            f"design list: row {number + 1} and the first one differ in {', '.join(odd)}: give "
            "every row the same names"
        )
    try:
        return {parameter.name: parameter.read(given[parameter.name]) for parameter in parameters}
    except InputError as error:
        raise InputError(f"design list, row {number + 1}: {error}") from None


def _check_count(count: int) -> None:
    if count > MOST:
        raise InputError(f"the design has {count} runs, {MOST} at most: take fewer steps or values")


def _whole(name: str, value: Any, least: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise InputError(f"design: {name} = {said(value)} must be a whole number, {least} or more")
    return value
