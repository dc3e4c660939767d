"""The search: batch after batch of runs, random ones of equal cost beside them, then repeats.

It is a function of the task and of how runs end. Started again, it asks for the runs that are
written down, finds most of them done, and comes to where it was.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from warpdrape.errors import InputError
from warpdrape.optimisation.answer import finalists_of, nearest_of
from warpdrape.optimisation.book import (
    BASELINE,
    COARSE,
    COARSE_START,
    REPEAT,
    SEARCH,
    START,
    Asked,
    Trial,
)
from warpdrape.optimisation.cost import coarse_cost, pairs_of, spent
from warpdrape.optimisation.descent import GRADIENT, NoSlope
from warpdrape.optimisation.fidelity import Shares, corrected, promoted, shares_of
from warpdrape.optimisation.known import Known
from warpdrape.optimisation.methods import METHODS
from warpdrape.optimisation.runner import Runner
from warpdrape.optimisation.space import Place, place_of, random_places, row_at, spread_places

Say = Callable[[str], None]
_FIRST, _MODEL, _RANDOM, _ELSE = range(4)
"""Of what a random number is: first places, the sampler, the baseline, places in place of known."""


def search(runner: Runner, say: Say) -> None:
    """Do all runs of an optimisation that are missing.

    Args:
        runner: does runs, and has the book.
        say: takes a line after each batch.

    Raises:
        InputError: where the settings to compare with, or their coarse run, show that the
            optimisation cannot be done so.
    """
    _begin(runner)
    batch, share, cost = 1, 0.0, 1.0
    task = runner.book.task
    if task.coarse is not None:
        share, cost = task.coarse.share, coarse_cost(runner)
    while True:
        shares = shares_of(task.runs - spent(runner, batch - 1), task.batch, share, cost)
        if shares.fine < 1:
            break
        if not _one_batch(runner, batch, shares):
            say("Nothing is left to be tried: the search ends before its budget does.")
            break
        say(_so_far(runner, batch))
        batch += 1
    _repeat(runner)


def _begin(runner: Runner) -> None:
    book, task = runner.book, runner.book.task
    place = place_of(task.axes, task.start)
    before: list[Trial] = []
    if task.coarse is not None:
        asked = Asked(task.start, place, None, task.coarse.settings)
        before = book.asked(COARSE_START, 0, lambda: [asked])
    of = before[0].number if before else None
    start = book.asked(START, 0, lambda: [Asked(task.start, place, of)])
    runner.do([*before, *start])
    for trial, words in (*((t, "[optimise.coarse]") for t in before), (start[0], "")):
        score = runner.score(trial)
        if score.why.startswith(("measure", "it has no")):
            raise InputError(f"run {trial.number}, with the settings to start from: {score.why}")
        if words and not score.counts:
            raise InputError(
                f"run {trial.number}, with the settings to start from and {words}, does not "
                f"count ({score.why}): what coarse runs cost and tell is not known; change {words}"
            )
    if before and not (runner.score(start[0]).counts and coarse_cost(runner) < 1.0):
        why = runner.score(start[0]).why or "it costs less than the coarse one"
        raise InputError(
            f"run {start[0].number}, with the settings to start from: {why}: coarse runs are of no "
            "use beside it; give other [optimise.start], or leave [optimise.coarse] away"
        )


def _one_batch(runner: Runner, batch: int, shares: Shares) -> bool:
    """Ask for a batch and do it; False where nothing is left to be tried."""
    book, task = runner.book, runner.book.task
    if task.coarse is None:
        fine = book.asked(SEARCH, batch, lambda: _asked(runner, SEARCH, batch, shares.fine))
    else:
        coarse = book.asked(COARSE, batch, lambda: _asked(runner, COARSE, batch, shares.coarse))
        runner.do(coarse)
        fine = book.asked(SEARCH, batch, lambda: _promoted(runner, shares.fine))
    so_far = sum(trial.batch < batch for trial in book.of_kind(BASELINE))
    wanted = max(int(spent(runner, batch) + 1e-9) - 1 - so_far, 0)
    places = random_places(task.axes, so_far + wanted, _seed(task.seed, 0, _RANDOM))[so_far:]
    asked = [Asked(row_at(task.axes, place), place) for place in places]
    runner.do([*fine, *book.asked(BASELINE, batch, lambda: asked)])
    return bool(fine)


def _asked(runner: Runner, kind: str, batch: int, count: int) -> list[Asked]:
    task = runner.book.task
    settings = task.coarse.settings if kind == COARSE and task.coarse is not None else ()
    places = _places(runner, kind, batch, count)
    return [Asked(row_at(task.axes, place), place, None, settings) for place in places]


def _places(runner: Runner, kind: str, batch: int, count: int) -> list[Place]:
    """Places for a batch: evenly spread ones at first, then those that the sampler gives."""
    task, axes = runner.book.task, runner.book.task.axes
    tried = {trial.place for trial in runner.book.of_kind(START, kind) if trial.place is not None}
    so_far = len(runner.book.of_kind(kind))
    first = 0 if task.method == GRADIENT else 2 * (len(axes) + 1)  # it goes on from one place
    spread = spread_places(axes, first, _seed(task.seed, 0, _FIRST))[so_far : so_far + count]
    wanted = count - len(spread)
    known = _known(runner, kind)
    if wanted and any(each.score.counts for each in known):
        seed = _seed(task.seed, batch, _MODEL)
        try:
            spread += METHODS[task.method](axes, known, wanted, seed)
        except NoSlope as error:
            raise InputError(error.words(axes, task.aims)) from error
    elif wanted:
        spread += random_places(axes, wanted, _seed(task.seed, batch, _MODEL))
    return _new_ones(spread, tried, random_places(axes, 200, _seed(task.seed, batch, _ELSE)))


def _new_ones(places: Sequence[Place], tried: set[Place], others: Sequence[Place]) -> list[Place]:
    """Places that were not tried, others for those that were; fewer where there are none left."""
    found: list[Place] = []
    instead = iter(others)
    for wanted in places:
        place: Place | None = wanted
        while place is not None and (place in tried or place in found):
            place = next(instead, None)
        if place is not None:
            found.append(place)
    return found


def _known(runner: Runner, kind: str) -> list[Known]:
    """What the sampler is told: fine runs, and coarse ones where there is no fine one."""
    trials = [t for t in runner.book.of_kind(START, SEARCH) if t.number in runner.outcomes]
    known = [Known(t.place, runner.score(t)) for t in trials if t.place is not None]
    if kind == COARSE:
        pairs = [(runner.score(a), runner.score(b)) for a, b in pairs_of(runner)]
        done = {t.of for t in trials}
        known += [
            Known(t.place, corrected(runner.score(t), runner.book.task.aims, pairs))
            for t in runner.book.of_kind(COARSE)
            if t.number in runner.outcomes and t.number not in done and t.place is not None
        ]
    return known


def _promoted(runner: Runner, count: int) -> list[Asked]:
    book = runner.book
    done = {trial.of for trial in book.of_kind(SEARCH)}
    left = [t for t in book.of_kind(COARSE) if t.number not in done]
    best = promoted([runner.score(t) for t in left], count)
    return [Asked(left[k].row, left[k].place, left[k].number) for k in best]


def _repeat(runner: Runner) -> None:
    """Do the best of the search and of the baseline, and the start, again with each repeat."""
    book, task = runner.book, runner.book.task
    best = [t for kind in (START, SEARCH, BASELINE) for t in finalists_of(runner, kind)]
    again: list[Trial] = []
    for trial in best:
        asked = [Asked(trial.row, trial.place, trial.number, settings) for settings in task.repeats]
        again += book.asked(REPEAT, trial.number, partial(list, asked))
    runner.do(again)


def _so_far(runner: Runner, batch: int) -> str:
    task = runner.book.task
    words = [f"{spent(runner, batch):.3g} of {task.runs} runs"]
    for kind, name in ((SEARCH, "best"), (BASELINE, "best at random"), (START, "start")):
        trial = nearest_of(runner, kind)
        if trial is None:
            continue
        score = runner.score(trial)
        values = ", ".join(f"{score.values[o.measure]:.5g}" for o in task.aims.objectives)
        words.append(f"{name} {values}" + ("" if score.feasible else " (outside its limits)"))
    return "; ".join(words)


def _seed(seed: int, batch: int, what: int) -> int:
    return int(np.random.SeedSequence([seed, batch, what]).generate_state(1)[0])
