"""The command ``warpdrape optimise``: what it prints, and how it ends."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from warpdrape.commands.values import OUT, whole
from warpdrape.errors import InputError, RunFailed
from warpdrape.optimisation.book import Book
from warpdrape.optimisation.methods import check_method
from warpdrape.optimisation.optimise_file import Task, read_optimisation
from warpdrape.optimisation.runner import Runner
from warpdrape.studies.ending import ends_as_interrupted
from warpdrape.studies.folder import StudyFolder
from warpdrape.studies.one_run import COMPLETED, Job


def optimise(arguments: argparse.Namespace) -> str:
    """Do an optimisation, or what is left of it; return why it did not come to its end, or "".

    Raises:
        InputError: if the study or an option is unusable.
    """
    workers, seed = None, None
    if arguments.workers is not None:
        workers = whole("--workers", arguments.workers, least=1)
        if arguments.scheduler is not None:
            raise InputError("give --workers for this machine or --scheduler ADDRESS, not both")
    if arguments.seed is not None:
        seed = whole("--seed", arguments.seed, least=0)
    task = read_optimisation(arguments.study, seed)
    if arguments.plan:
        from warpdrape.optimisation.words import plan_text

        print(plan_text(task))
        return ""
    check_method(task.method)
    folder = StudyFolder(arguments.out or Path(OUT, task.study.name))
    folder.take()
    try:
        with ends_as_interrupted():
            return _run(task, folder, arguments, workers)
    finally:
        folder.release()


def _run(
    task: Task, folder: StudyFolder, arguments: argparse.Namespace, workers: int | None
) -> str:
    from warpdrape.optimisation.report import write_report
    from warpdrape.optimisation.search import search
    from warpdrape.optimisation.words import answer_text
    from warpdrape.studies.running import without_failed

    book = Book(task, folder)
    if arguments.retry_failed:
        without_failed(folder, folder.ended(trial.number for trial in book.trials))
    say = (lambda _: None) if arguments.quiet else _say
    cut_off = ""
    with ExitStack() as stack:
        hands = _Workers(stack, folder, arguments.scheduler, workers, say)
        runner = Runner(book, hands.do)
        if arguments.slopes:
            return _slopes(runner)
        try:
            search(runner, say)
        except (KeyboardInterrupt, RunFailed) as reason:
            cut_off = (
                f"{str(reason) or 'interrupted'}: {len(runner.outcomes)} runs have ended; start it "
                "again and it goes on"
            )
    if not any(outcome["status"] == COMPLETED for outcome in runner.outcomes.values()):
        return cut_off or f"no run completed; {folder.path / 'outcomes'} says why of each"
    files = write_report(runner)
    print(answer_text(runner))
    print(f"report in {files[0]}, table in {files[1]}")
    return cut_off


def _slopes(runner: Runner) -> str:
    from warpdrape.optimisation.slopes import find_slopes, slopes_text, write_slopes

    try:
        slopes = find_slopes(runner)
    except (KeyboardInterrupt, RunFailed) as reason:
        return f"{str(reason) or 'interrupted'}: start it again and it goes on"
    print(slopes_text(slopes))
    print(f"table in {write_slopes(runner.book.folder.path, slopes)}")
    return ""


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


class _Workers:
    """Dask's workers, started when the first run is to be done, kept for all that follow."""

    def __init__(
        self,
        stack: ExitStack,
        folder: StudyFolder,
        scheduler: str | None,
        count: int | None,
        say: Callable[[str], None],
    ) -> None:
        self._stack, self._folder, self._say = stack, folder, say
        self._scheduler, self._count = scheduler, count
        self._client: Any = None

    def do(self, jobs: Sequence[Job]) -> Iterator[dict[str, Any]]:
        """Do runs, and give how each ended."""
        from warpdrape.studies.cluster import connected
        from warpdrape.studies.running import as_they_end

        if self._client is None:
            workers = connected(self._scheduler, self._count, self._say)
            self._client = self._stack.enter_context(workers)
        for outcome in as_they_end(self._client, jobs, self._folder, self._say):
            if outcome["status"] != COMPLETED:
                self._say(f"run {outcome['run']} {outcome['status']}: {outcome['message']}")
            yield outcome
