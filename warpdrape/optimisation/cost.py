"""What the search costs, in runs at full fineness, so that a baseline may cost the same."""

from __future__ import annotations

from collections.abc import Iterator

from warpdrape.optimisation.book import (
    BASELINE,
    COARSE,
    COARSE_START,
    SEARCH,
    START,
    Trial,
)
from warpdrape.optimisation.runner import Runner


def coarse_cost(runner: Runner) -> float:
    """Cost of a coarse run in fine ones: by triangles and steps of the start, done both ways."""
    book = runner.book
    return runner.work(book.of_kind(COARSE_START)[0]) / runner.work(book.of_kind(START)[0])


def spent(runner: Runner, batch: int | None = None) -> float:
    """What the search has cost, the start with it; runs that failed count as all others.

    Args:
        runner: of the optimisation.
        batch: up to which one; None for all.
    """
    last = None
    for trial, cost in cost_after(runner, SEARCH):
        if batch is None or trial.batch <= batch:
            last = cost
    return last or 0.0


def cost_after(runner: Runner, kind: str) -> Iterator[tuple[Trial, float]]:
    """Runs of the search, coarse ones too, or of the baseline; and the cost of all so far.

    Both begin with the start.

    Args:
        runner: of the optimisation.
        kind: `SEARCH` or `BASELINE`.
    """
    book = runner.book
    total = 0.0
    if kind == BASELINE:
        for trial in book.of_kind(START, BASELINE):
            total += 1.0
            yield trial, total
        return
    part = coarse_cost(runner) if book.of_kind(COARSE_START) else 0.0
    for trial in book.of_kind(COARSE_START, START, COARSE, SEARCH):
        total += part if trial.kind in (COARSE_START, COARSE) else 1.0
        yield trial, total


def pairs_of(runner: Runner) -> list[tuple[Trial, Trial]]:
    """Coarse runs that have ended, and the fine ones with their settings."""
    book = runner.book
    coarse = {trial.number: trial for trial in book.of_kind(COARSE_START, COARSE)}
    return [
        (coarse[t.of], t)
        for t in book.of_kind(START, SEARCH)
        if t.of in coarse and t.number in runner.outcomes and t.of in runner.outcomes
    ]
