"""The table of an optimisation: a row a run, with what it was for and what it is worth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from warpdrape.optimisation.book import Trial
from warpdrape.optimisation.runner import Runner
from warpdrape.studies.parameters import exact
from warpdrape.studies.table import PENDING, Table


def gather(runner: Runner) -> Table:
    """Make the table of all runs that were asked for."""
    task = runner.book.task
    names = [measure.name for measure in task.study.measures]
    names += [name for name in task.aims.measures if name not in names]
    rows = [_row(runner, trial, names) for trial in runner.book.trials]
    parameters = [parameter.name for parameter in task.study.parameters]
    columns: dict[str, list[Any]] = {key: [row[key] for row in rows] for key in rows[0]}
    return Table(columns, parameters, names)


def _row(runner: Runner, trial: Trial, names: list[str]) -> dict[str, Any]:
    row: dict[str, Any] = {"run": trial.number, "kind": trial.kind, "batch": trial.batch}
    row |= {"of": trial.of, "settings": " ".join(trial.settings)}
    row |= {name: exact(v) if isinstance(v, tuple) else v for name, v in trial.row.items()}
    outcome: Mapping[str, Any] = {"status": PENDING, "message": ""}
    values: Mapping[str, float | None] = {}
    feasible, why = None, ""
    if trial.number in runner.outcomes:
        outcome = runner.outcomes[trial.number]
        score = runner.score(trial)
        values, feasible, why = score.values, int(score.feasible), score.why
    row |= {name: values.get(name) for name in names}
    row |= {"feasible": feasible, "why_not": why}
    return row | {key: outcome.get(key) for key in ("status", "message", "wall_s", "cpu_s", "host")}
