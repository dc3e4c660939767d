"""Runs of an optimisation done by Dask's workers, and what each is worth."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from warpdrape.errors import InputError
from warpdrape.optimisation.aims import Score
from warpdrape.optimisation.book import Book, Trial
from warpdrape.studies.measures import FIT, fit_of, measure_run
from warpdrape.studies.one_run import COMPLETED, Job
from warpdrape.studies.running import job_of

Do = Callable[[Sequence[Job]], Any]
"""Does runs, and gives how each ended as they end."""


class Runner:
    """Does what is missing of runs, and knows what each is worth.

    Args:
        book: of the optimisation.
        do: does runs.
    """

    def __init__(self, book: Book, do: Do) -> None:
        self.book, self._do = book, do
        self.outcomes: dict[int, Mapping[str, Any]] = dict(
            book.folder.ended(trial.number for trial in book.trials)
        )
        self._scores: dict[int, Score] = {}
        self._work: dict[int, float] = {}

    def do(self, trials: Sequence[Trial]) -> None:
        """Do those runs that have not ended yet."""
        book = self.book
        jobs = [
            job_of(book.task.study, book.folder, t.number, book.settings(t), t.row, maps=False)
            for t in trials
            if t.number not in self.outcomes
        ]
        if not jobs:
            return
        for outcome in self._do(jobs):
            self.outcomes[outcome["run"]] = outcome

    def score(self, trial: Trial) -> Score:
        """What a run that has ended is worth."""
        if trial.number not in self._scores:
            self._scores[trial.number] = self._score(trial)
        return self._scores[trial.number]

    def work(self, trial: Trial) -> float:
        """What a run that has ended took: triangles times steps, or its processor time [s]."""
        self.score(trial)
        return self._work.get(trial.number, float(self.outcomes[trial.number].get("cpu_s", 0.0)))

    def _score(self, trial: Trial) -> Score:
        outcome = self.outcomes[trial.number]
        if outcome["status"] != COMPLETED:
            return Score(why=f"{outcome['status']}: {outcome['message']}")
        task = self.book.task
        try:
            values, complaints, summary, history = measure_run(
                self.book.folder.run(trial.number), task.study.measures
            )
        except InputError as error:  # what was a whole folder has been changed since
            return Score(why=f"damaged: {error}")
        if FIT in task.aims.measures or task.study.limits is not None:
            values[FIT] = float(fit_of(summary, history, task.study.limits))
        work = float(summary.get("triangles") or 0) * float(summary.get("steps") or 0)
        if work > 0.0:
            self._work[trial.number] = work
        score = task.aims.score(values, summary)
        if not score.counts and complaints:
            return Score(values, why="; ".join(complaints))
        return score
