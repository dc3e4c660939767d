"""Error against time of ways to compute a scene: ``python bench/accuracy [--cases … --ways …]``.

Every case is computed in the ways asked for, each run in a process of its own and on one thread,
and as the reference. Errors are differences to that. Each way runs several times with friction
changed by 10⁻⁹ of itself: the scatter of these says below which size an error is none. Time is
processor time of the steps. Runs are kept in ``--runs`` and not done again; the table is printed,
written to ``--out``, and drawn to ``--plot``. ``--kept`` makes them from what is kept alone.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from errors import Row, markdown, row_of
from one_run import done, place_of, run_here
from picture import draw
from ways import CASES, WAYS, changes_of, is_drape, reference_of

AS_IT_IS = "as it is"
"""The way of a drape that has none: neither a stroke nor an accuracy."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Compute what is missing, and print the table."""
    chosen = parser().parse_args(arguments)
    if chosen.alone:
        case, _, changes, number = json.loads(chosen.alone)
        print(json.dumps(run_here(case, changes, number)))
        return 0
    rows = [row for case in chosen.cases for row in rows_of(case, chosen)]
    print(markdown(rows))
    text = json.dumps([asdict(row) for row in rows], indent=2)
    chosen.out.write_text(text + "\n", encoding="utf-8")
    if chosen.plot:
        draw(rows, chosen.plot)
    return 0


def parser() -> argparse.ArgumentParser:
    """What may be asked for."""
    asked = argparse.ArgumentParser(
        prog="python bench/accuracy", description=(__doc__ or "").partition("\n")[0]
    )
    asked.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES))
    asked.add_argument("--ways", nargs="+", choices=WAYS, default=list(WAYS))
    asked.add_argument("--noise", type=int, default=2, help="runs of each way")
    asked.add_argument("--references", type=int, help="runs of the reference, if not as many")
    asked.add_argument("--runs", type=Path, default=Path("accuracy_runs"), help="folder of runs")
    asked.add_argument("--kept", action="store_true", help="compute nothing more")
    asked.add_argument("--out", type=Path, default=Path("accuracy.json"), help="for the figures")
    asked.add_argument("--plot", type=Path, help="picture of errors over time")
    asked.add_argument("--alone", help=argparse.SUPPRESS)
    return asked


def rows_of(case: str, chosen: argparse.Namespace) -> list[Row]:
    """Rows of a case, each printed when it is known."""
    exact = runs_of(case, reference_of(case), chosen.references or chosen.noise, chosen)
    if not exact:
        return []
    full = float(np.median([run["seconds"] for run in exact]))
    rows: list[Row] = []
    seen: list[Mapping[str, Any]] = []
    for way in chosen.ways:
        changes = changes_of(case, way)
        if is_drape(case):
            if changes in seen:
                continue
            seen.append(changes)
            way = way if changes else AS_IT_IS
        if found := runs_of(case, changes, chosen.noise, chosen):
            rows.append(row_of(case, way, found, exact, full))
            print(markdown(rows[-1:]).splitlines()[-1], flush=True)
    return rows


def runs_of(
    case: str, changes: Mapping[str, Any], count: int, chosen: argparse.Namespace
) -> list[dict[str, Any]]:
    """Figures of a way's runs: of all of them, or of those that are kept."""
    numbers = [
        n
        for n in range(count)
        if not chosen.kept or place_of(case, changes, n, chosen.runs)[1].exists()
    ]
    return [done(case, changes, n, chosen.runs) for n in numbers]
