"""The report of an optimisation: the answer in words, tables, pictures, one HTML page of it all."""

from __future__ import annotations

import html
import math
from pathlib import Path
from typing import Any

from warpdrape.optimisation.answer import Candidate, candidates_of, gain_of, noise_of
from warpdrape.optimisation.book import BASELINE, COARSE, REPEAT, SEARCH, START
from warpdrape.optimisation.cost import coarse_cost, pairs_of, spent
from warpdrape.optimisation.fidelity import agreement
from warpdrape.optimisation.pictures import draw_convergence, draw_field, draw_front, has_front
from warpdrape.optimisation.runner import Runner
from warpdrape.optimisation.table import gather
from warpdrape.optimisation.words import answer_text, settings_text, value_text
from warpdrape.results.progress import in_words
from warpdrape.studies.folder import write_json
from warpdrape.studies.page import list_of, picture, write_page
from warpdrape.studies.table import write_table

REPORT, ANSWER = "report.html", "answer.json"
SHOWN = 20
"""Runs that do not count that the page lists, at most; the table has all."""


def write_report(runner: Runner) -> list[Path]:
    """Write table, answer, pictures and page of what has ended of an optimisation.

    Raises:
        RunFailed: when the disk refuses.
    """
    folder, task = runner.book.folder.path, runner.book.task
    files = write_table(gather(runner), folder)
    write_json(folder / ANSWER, answer_of(runner))
    page = [f"<h1>Optimisation {html.escape(task.study.name)}</h1>"]
    page += [f"<p>{html.escape(line)}</p>" for line in answer_text(runner).splitlines()[1:]]
    page.append(_settings_table(runner))
    page.append(_command(runner))
    counted = any(runner.score(t).counts for t in _ended(runner, START, SEARCH, BASELINE))
    if counted:
        page.append("<h2>Against random settings of equal cost</h2>")
        drawn = draw_convergence(runner)
        page.append(picture(folder / "convergence.png", drawn, "best so far over cost"))
        files.append(folder / "convergence.png")
    if has_front(runner):
        page.append("<h2>Front of both objectives</h2>")
        page.append(picture(folder / "front.png", draw_front(runner), "Pareto front"))
        files.append(folder / "front.png")
    if counted:
        page.append("<h2>Where it looked</h2><p>Hollow: outside its limits.</p>")
        page.append(picture(folder / "field.png", draw_field(runner), "objectives, parameters"))
        files.append(folder / "field.png")
    page += [_how(runner), _not_counted(runner)]
    write_page(folder / REPORT, f"Optimisation {task.study.name}", page)
    return [folder / REPORT, *files]


def answer_of(runner: Runner) -> dict[str, Any]:
    """The answer for machines: settings and values of the finalists, gains, noise, cost."""
    task = runner.book.task
    found = {kind: candidates_of(runner, kind) for kind in (SEARCH, BASELINE, START)}
    everyone = [c for group in found.values() for c in group]
    objectives = range(len(task.aims.objectives))
    noise = [noise_of(everyone, k) for k in objectives]
    data: dict[str, Any] = {
        "objectives": [o.words for o in task.aims.objectives],
        "constraints": [c.words for c in task.aims.constraints],
        "noise": [_or_none(each.deviation) for each in noise],
        "cost_in_runs": spent(runner) if runner.outcomes else 0.0,
    }
    for kind, group in found.items():
        data[kind] = [_entry(candidate) for candidate in group]
    if len(objectives) == 1 and found[SEARCH]:
        for kind in (START, BASELINE):
            if found[kind]:
                gain = gain_of(found[SEARCH][0], found[kind][0], 0, noise[0])
                numbers = (gain.single, gain.repeated, gain.error)
                keys = ("single", "repeated", "error")
                data[f"gain_on_{kind}"] = dict(zip(keys, map(_or_none, numbers), strict=True))
    return data


def _entry(candidate: Candidate) -> dict[str, Any]:
    return {
        "run": candidate.trial.number,
        "settings": dict(candidate.trial.row),
        "values": dict(candidate.score.values),
        "repeats": [dict(s.values) if s.counts else s.why for s in candidate.repeats],
        "keeps_limits": candidate.holds,
    }


def _settings_table(runner: Runner) -> str:
    task = runner.book.task
    shown = [(START, 1), (BASELINE, 1), (SEARCH, task.finalists)]
    found = [(kind, c) for kind, most in shown for c in candidates_of(runner, kind)[:most]]
    if not found:
        return ""
    names = ["", *(f"{_KINDS[kind]}, run {c.trial.number}" for kind, c in found)]
    rows = [
        [p.name, *(value_text(p, c.trial.row[p.name]) for _, c in found)]
        for p in task.study.parameters
    ]
    for measure in task.study.measures:
        values = [c.score.values.get(measure.name) for _, c in found]
        rows.append([measure.name, *("" if v is None else f"{v:.5g}" for v in values)])
    for k, objective in enumerate(task.aims.objectives):
        if any(c.repeats for _, c in found):
            means = [f"{objective.sign * c.mean(k):.5g}" if c.repeats else "" for _, c in found]
            rows.append([f"{objective.measure}, mean of repeats", *means])
    for constraint in task.aims.constraints:
        kept = [constraint.excess(c.score.value(constraint.measure)) <= 0.0 for _, c in found]
        rows.append([constraint.words, *("kept" if each else "not kept" for each in kept)])
    return list_of(names, rows)


_KINDS = {START: "start", BASELINE: "best at random", SEARCH: "search"}


def _command(runner: Runner) -> str:
    """How the best is run again."""
    found = candidates_of(runner, SEARCH)
    study = runner.book.task.study
    if not found:
        return ""
    settings = runner.book.settings(found[0].trial)
    words = " ".join(f"--set {_quoted(setting)}" for setting in settings)
    card = f" --set fabric={runner.book.folder.card(found[0].trial.number)}" if study.card else ""
    scene = study.script.name if study.script.bundled else study.script.path
    return f"<p>Again: <code>warpdrape run {html.escape(f'{scene} {words}{card}')}</code></p>"


def _quoted(setting: str) -> str:
    return f"'{setting}'" if any(c in setting for c in " /()") else setting


def _how(runner: Runner) -> str:
    task, book = runner.book.task, runner.book
    ended = _ended(runner, SEARCH)
    words = [
        f"Method {task.method}, seed {task.seed}, batches of {task.batch}. "
        f"{len(ended)} runs of the search and {len(_ended(runner, BASELINE))} at random at full "
        f"fineness, both begun with the start; cost {spent(runner):.4g} of {task.runs}, counted in "
        "runs, failed ones among them.",
        _processor(runner),
    ]
    if (
        task.coarse is not None
        and len(pairs_of(runner))
        and runner.score(book.of_kind(START)[0]).counts
    ):
        pairs = [(runner.score(a), runner.score(b)) for a, b in pairs_of(runner)]
        found = [f"{r:.2f}" for r in agreement(pairs) if not math.isnan(r)]
        words.append(
            f"{len(_ended(runner, COARSE))} coarse runs, each {100.0 * coarse_cost(runner):.0f} % "
            "of a full one by triangles and steps. They only choose what is run at full fineness."
            + (
                f" Rank correlation of coarse and full values, {len(pairs)} pairs: "
                if found
                else ""
            )
            + (", ".join(found) + "; where it is not high they were no guide." if found else "")
        )
    if task.repeats:
        words.append(
            f"The best were run again with {'; '.join(' '.join(r) for r in task.repeats)} "
            f"({len(_ended(runner, REPEAT))} runs, not counted above): gains by repeats leave out "
            "the run by which settings were chosen, which is lucky on the average."
        )
    return "<h2>How</h2>" + "".join(f"<p>{html.escape(line)}</p>" for line in words if line)


def _processor(runner: Runner) -> str:
    parts = []
    for kinds, name in (
        ((COARSE, SEARCH), "search"),
        ((BASELINE,), "random"),
        ((REPEAT,), "repeats"),
    ):
        times = [runner.outcomes[t.number].get("cpu_s", 0.0) for t in _ended(runner, *kinds)]
        parts.append(f"{name} {in_words(sum(times))}")
    return "Processor time: " + ", ".join(parts) + "."


def _not_counted(runner: Runner) -> str:
    bad = [t for t in _ended(runner, *_ALL) if not runner.score(t).counts]
    if not bad:
        return ""
    task = runner.book.task
    rows = [
        [str(t.number), t.kind, settings_text(task, t.row), runner.score(t).why]
        for t in bad[:SHOWN]
    ]
    page = "<h2>Runs that do not count</h2>"
    page += "<p>They are taken for the worst that was seen, and outside their limits.</p>"
    page += list_of(["run", "kind", "settings", "why"], rows)
    return page + (f"<p>and {len(bad) - SHOWN} more</p>" if len(bad) > SHOWN else "")


_ALL = (START, COARSE, SEARCH, BASELINE, REPEAT)


def _ended(runner: Runner, *kinds: str) -> list[Any]:
    return [t for t in runner.book.of_kind(*kinds) if t.number in runner.outcomes]


def _or_none(value: float) -> float | None:
    return None if math.isnan(value) else value
