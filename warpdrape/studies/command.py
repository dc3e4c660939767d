"""The command ``warpdrape study``: what it prints, and how it ends."""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warpdrape.commands.values import OUT, whole
from warpdrape.errors import InputError, RunFailed
from warpdrape.results.progress import in_words
from warpdrape.studies.design import Row
from warpdrape.studies.effects import effects
from warpdrape.studies.ending import ends_as_interrupted
from warpdrape.studies.folder import StudyFolder
from warpdrape.studies.one_run import COMPLETED
from warpdrape.studies.parameters import exact
from warpdrape.studies.study import Study
from warpdrape.studies.study_file import read_study
from warpdrape.studies.table import Table

if TYPE_CHECKING:
    from warpdrape.studies.running import Cost

SHORT_S = 10.0
"""Times below this are shown with tenths of a second [s]."""
SHOWN = 3
"""Runs at each end of a plan that are shown."""


def study(arguments: argparse.Namespace) -> str:
    """Run a study, or what is left of it; return why it did not come to its end, or "".

    Raises:
        InputError: if the study or an option is unusable.
    """
    workers = None
    if arguments.workers is not None:
        workers = whole("--workers", arguments.workers, least=1)
        if arguments.scheduler is not None:
            raise InputError("give --workers for this machine or --scheduler ADDRESS, not both")
    asked = read_study(arguments.study)
    if arguments.plan:
        print(plan_text(asked, asked.rows()))
        return ""
    folder = StudyFolder(arguments.out or Path(OUT, asked.name))
    folder.take()
    try:
        with ends_as_interrupted():
            return _run(asked, folder, arguments, workers)
    finally:
        folder.release()


def _run(
    asked: Study, folder: StudyFolder, arguments: argparse.Namespace, workers: int | None
) -> str:
    from warpdrape.studies.report import write_report
    from warpdrape.studies.running import run_study

    rows = folder.plan(asked)
    cut_off = ""
    try:
        _, outcomes, cost = run_study(
            asked,
            folder,
            rows=rows,
            scheduler=arguments.scheduler,
            workers=workers,
            retry=arguments.retry_failed,
            quiet=arguments.quiet,
        )
    except (KeyboardInterrupt, RunFailed) as reason:
        outcomes, cost = folder.ended(range(len(rows))), None
        cut_off = (
            f"{str(reason) or 'interrupted'}: {len(outcomes)} of {len(rows)} runs have ended; "
        )
        cut_off += "start it again and it goes on"
    before = time.process_time()
    table, files = write_report(asked, folder, rows, outcomes)
    print(study_text(asked, table, files))
    if cost is not None and cost.runs_s > 0.0:
        print(cost_text(cost, time.process_time() - before))
    if not cut_off and not table.completed.any():
        return "no run completed; table.csv says why of each"
    return cut_off


def cost_text(cost: Cost, report_s: float) -> str:
    """What a study took beyond its runs: to start workers, to keep them at it, for its report.

    Args:
        cost: of its runs and workers.
        report_s: processor time of table and report [s].
    """
    parts = ((cost.start_s, "to start"), (cost.order_s, "for order"), (report_s, "for the report"))
    start, order, report = (
        f"{_short(seconds)} ({100.0 * seconds / cost.runs_s:.1f} %) {what}"
        for seconds, what in parts
    )
    return f"processor time: {in_words(cost.runs_s)} in runs, {start}, {order} and {report}"


def _short(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds < SHORT_S else in_words(seconds)


def plan_text(asked: Study, rows: Sequence[Row]) -> str:
    """What a study would run: how many runs, and the first and last of them."""
    numbers: Sequence[int] = range(len(rows))
    if len(rows) > 2 * SHOWN:
        numbers = [*range(SHOWN), *range(len(rows) - SHOWN, len(rows))]
    lines = [f"{asked.name}: {len(rows)} runs of {asked.script.name}, design {asked.design.kind}"]
    if asked.fixed:
        lines.append(f"all with {', '.join(asked.fixed)}")
    for number in numbers:
        if number == len(rows) - SHOWN and len(rows) > 2 * SHOWN:
            lines.append("  …")
        lines.append(f"  run {number}: {_values(asked, rows[number])}")
    return "\n".join(lines)


def _values(asked: Study, row: Mapping[str, Any]) -> str:
    words = []
    for parameter in asked.parameters:
        value = row[parameter.name]
        shown = f"{value:.5g}" if isinstance(value, float) else exact(value)
        unit = "" if parameter.unit in ("", "-") else f" {parameter.unit}"
        words.append(f"{parameter.name} {shown}{unit}")
    return ", ".join(words)


def study_text(asked: Study, table: Table, files: Sequence[Path]) -> str:
    """What came out, for a terminal: counts, measures, and what each depends on most."""
    statuses = table.columns["status"]
    counts = {status: statuses.count(status) for status in dict.fromkeys(statuses)}
    words = ", ".join(f"{count} {status}" for status, count in counts.items())
    lines = [f"{asked.name}: {len(statuses)} runs: {words}", *_measures(table)]
    lines += [f"note: {words}" for words in table.complaints]
    bad = [k for k, status in enumerate(statuses) if status != COMPLETED and status in _BAD]
    if bad:
        lines.append(f"not completed: run {_few(bad)}; table.csv says why")
    lines.append(f"report in {files[0]}, table in {files[1]}")
    return "\n".join(lines)


_BAD = ("failed", "refused", "lost", "damaged")


def _measures(table: Table) -> list[str]:
    if table.completed.sum() < 2 or not table.measures:
        return []
    found = effects(table)
    rows: list[tuple[str, ...]] = [("measure", "mean", "sd", "from", "to", "goes most with")]
    for name in table.measures:
        values = table.numbers(name)
        values = values[np.isfinite(values)]
        if len(values) < 2:
            continue
        most = max((e for e in found if e.measure == name), key=lambda e: e.span)
        ends = f"means from {most.means.min():.4g} to {most.means.max():.4g}"
        words = f"{most.parameter}: {ends}" if most.span > 0.0 else ""
        numbers = (values.mean(), values.std(ddof=1), values.min(), values.max())
        rows.append((name, *(f"{v:.4g}" for v in numbers), words))
    widths = [max(len(row[k]) for row in rows) for k in range(5)]
    return [
        "  " + "  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:5], widths[1:]), row[5]])
        for row in rows
    ]


def _few(numbers: Sequence[int]) -> str:
    shown = ", ".join(map(str, numbers[:10]))
    return f"{shown} and {len(numbers) - 10} more" if len(numbers) > 10 else shown
