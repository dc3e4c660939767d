"""The table of a study: a row a run, with its parameters, its measures, and how it ended."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.errors import InputError
from warpdrape.optional import needed
from warpdrape.results.run_folder import write_whole
from warpdrape.studies.design import Row
from warpdrape.studies.folder import StudyFolder
from warpdrape.studies.measures import FIT, fit_of, measure_run
from warpdrape.studies.one_run import COMPLETED
from warpdrape.studies.parameters import exact
from warpdrape.studies.study import Study

TABLE = "table.csv"
PARQUET = "table.parquet"
PENDING = "not yet run"


@dataclass(frozen=True, eq=False)
class Table:
    """Runs of a study that have ended, and those that have not.

    Attributes:
        columns: name → a value a run; None where it has none.
        parameters: names of the columns that are parameters.
        measures: names of those that are measures.
        complaints: what could not be measured, in words, each once.
    """

    columns: Mapping[str, list[Any]]
    parameters: Sequence[str]
    measures: Sequence[str]
    complaints: Sequence[str] = field(default=())

    @property
    def completed(self) -> np.ndarray:
        """Which runs did, shape [run]."""
        return np.array([status == COMPLETED for status in self.columns["status"]], dtype=bool)

    def numbers(self, name: str) -> np.ndarray:
        """A column of numbers; NaN where a run has none or did not complete, shape [run]."""
        values = [np.nan if v is None else float(v) for v in self.columns[name]]
        return np.where(self.completed, np.array(values, dtype=float), np.nan)


def gather(
    study: Study,
    folder: StudyFolder,
    rows: Sequence[Row],
    outcomes: Mapping[int, Mapping[str, Any]],
) -> Table:
    """Make the table of a study's runs from their folders.

    Args:
        study: the study.
        folder: its folder.
        rows: parameters of every run.
        outcomes: how runs ended, of those that have.
    """
    names = [measure.name for measure in study.measures]
    measured: list[dict[str, Any]] = []
    complaints: dict[str, None] = {}
    for number in range(len(rows)):
        outcome = outcomes.get(number, {"status": PENDING, "message": ""})
        found: dict[str, Any] = {}
        if outcome["status"] == COMPLETED:
            try:
                found, missing = _of_run(study, folder.run(number))
                complaints |= dict.fromkeys(missing)
            except InputError as error:  # what was a whole folder has been changed since
                outcome = {**outcome, "status": "damaged", "message": str(error)}
        measured.append({**_how(outcome), **found})
    if not any(measure.asked for measure in study.measures):
        names = [name for name in names if any(m.get(name) is not None for m in measured)]
    if study.limits is not None or any(FIT in m for m in measured):
        names.append(FIT)
    parameters = [parameter.name for parameter in study.parameters]
    columns: dict[str, list[Any]] = {"run": list(range(len(rows)))}
    columns |= {name: [_cell(row[name]) for row in rows] for name in parameters}
    columns |= {name: [m.get(name) for m in measured] for name in (*names, *_HOW)}
    return Table(columns, parameters, names, tuple(complaints))


_HOW = ("status", "message", "warnings", "wall_s", "cpu_s", "host")


def _how(outcome: Mapping[str, Any]) -> dict[str, Any]:
    return {name: outcome.get(name) for name in _HOW if name != "warnings"}


def _of_run(study: Study, folder: Path) -> tuple[dict[str, Any], list[str]]:
    """Measures of a run, and complaints."""
    found, complaints, summary, history = measure_run(folder, study.measures)
    row: dict[str, Any] = {**found, "warnings": len(summary["warnings"])}
    if study.limits is not None or summary.get("limits") is not None:
        row[FIT] = fit_of(summary, history, study.limits)
    return row, complaints


def _cell(value: Any) -> Any:
    """A parameter as a cell: numbers and words; lists as --set takes them."""
    return exact(value) if isinstance(value, tuple | list) else value


def write_table(table: Table, folder: Path) -> list[Path]:
    """Write the table as CSV, and as Parquet where pyarrow is installed; return the files.

    Raises:
        RunFailed: when the disk refuses.
    """
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    cells = [["" if v is None else exact(v) for v in column] for column in table.columns.values()]
    rows.writerows([table.columns, *zip(*cells, strict=True)])
    files = [folder / TABLE]
    write_whole(files[0], lambda p: p.write_text(text.getvalue(), "utf-8", newline="\n"))
    if find_spec("pyarrow") is not None:
        files.append(folder / PARQUET)
        write_whole(files[1], lambda p: _write_parquet(p, table))
    return files


def _write_parquet(out: Path, table: Table) -> None:
    pyarrow = needed("pyarrow", "tables")
    parquet = needed("pyarrow.parquet", "tables")
    arrays = {}
    for name, values in table.columns.items():
        kinds = {type(v) for v in values if v is not None}
        if kinds == {int, float}:
            values = [None if v is None else float(v) for v in values]
        elif len(kinds) > 1:  # words beside numbers
            values = [None if v is None else exact(v) for v in values]
        arrays[name] = pyarrow.array(values)
    parquet.write_table(pyarrow.table(arrays), out)
