"""Optimisations from start to end: budget, order, going on, repeats, what is told."""

import csv
import json
import math

import numpy as np
import pytest
from optimise_checks import STUDY, bowl, made_up_tool, optimised, write_formulas

from warpdrape.defects.limits import Limits, limits_entry
from warpdrape.errors import InputError
from warpdrape.optimisation.aims import Score
from warpdrape.optimisation.answer import (
    Candidate,
    Noise,
    candidates_of,
    gain_of,
    history_of,
    noise_of,
)
from warpdrape.optimisation.book import (
    BASELINE,
    COARSE,
    COARSE_START,
    REPEAT,
    SEARCH,
    START,
    Trial,
)
from warpdrape.optimisation.cost import coarse_cost, spent
from warpdrape.optimisation.report import write_report
from warpdrape.optimisation.words import answer_text

TPE = STUDY + 'method = "tpe"\nrepeats = []\n'
"""Quick to be asked."""


def number_of(runner, kind):
    return len(runner.book.of_kind(kind))


def test_search_and_baseline_cost_the_same_and_the_search_is_better(tmp_path):
    runner, hands = optimised(
        write_formulas(tmp_path, STUDY + "repeats = []\n"), tmp_path / "o", bowl
    )
    assert number_of(runner, SEARCH) == number_of(runner, BASELINE) == 23
    assert spent(runner) == 24.0 and number_of(runner, START) == 1
    assert hands.sizes == [1, 8, 8, 8, 8, 8, 6]  # the start, then batches of four and four
    (cost, best), (other, random) = history_of(runner, SEARCH)[-1], history_of(runner, BASELINE)[-1]
    assert cost == other == 24.0 and best - 1.0 < 0.1 * (random - 1.0)
    assert history_of(runner, SEARCH)[0] == (1.0, bowl({"x": 0.9, "y": 0.9})["f"])
    values = [value for _, value in history_of(runner, SEARCH)]
    assert values == sorted(values, reverse=True)


def test_the_same_seed_gives_the_same_runs(tmp_path):
    path = write_formulas(tmp_path, TPE)
    rows = [
        [t.row for t in optimised(path, tmp_path / name, bowl, seed=seed)[0].book.trials]
        for name, seed in (("a", 1), ("b", 1), ("c", 2))
    ]
    assert rows[0] == rows[1] and rows[0][1:] != rows[2][1:]


@pytest.mark.parametrize("after", [0, 1, 3, 12, 30, 44])
def test_cut_off_and_started_again_it_comes_to_the_same(tmp_path, after):
    path = write_formulas(tmp_path, TPE)
    whole, _ = optimised(path, tmp_path / "whole", bowl)
    _, first = optimised(path, tmp_path / "cut", bowl, stop_after=after)
    assert len(first.done) == after
    again, second = optimised(path, tmp_path / "cut", bowl)
    assert sorted(first.done + second.done) == list(range(len(whole.book.trials)))
    assert again.book.trials == whole.book.trials
    third = optimised(path, tmp_path / "cut", bowl)[1]
    assert third.done == []


def test_a_budget_may_grow_and_nothing_else_may_change(tmp_path):
    path = write_formulas(tmp_path, TPE)
    before, _ = optimised(path, tmp_path / "o", bowl)
    more = write_formulas(tmp_path, TPE.replace("runs = 24", "runs = 30"))
    after, hands = optimised(more, tmp_path / "o", bowl)
    assert after.book.trials[: len(before.book.trials)] == before.book.trials
    assert spent(after) == 30.0 and len(hands.done) == 12
    for old, new, words in (
        ("range = [0, 1]\n[measures]", "range = [0, 2]\n[measures]", r"another \[parameters\]"),
        ('f = "f"', 'f = "g"', r"another \[measures\]"),
        ("runs = 24", "runs = 24\nbatch = 5", r"another \[optimise\]"),
    ):
        other = write_formulas(tmp_path, TPE.replace(old, new))
        with pytest.raises(InputError, match=words):
            optimised(other, tmp_path / "o", bowl)
    (tmp_path / "else").mkdir()
    (tmp_path / "else" / "thesis.doc").touch()
    with pytest.raises(InputError, match="holds other files"):
        optimised(path, tmp_path / "else", bowl)
    (tmp_path / "o" / "plan.json").write_text('{"rows": []}', encoding="utf-8")
    with pytest.raises(InputError, match="no optimisation, or is damaged"):
        optimised(path, tmp_path / "o", bowl)


def test_runs_that_fail_are_kept_away_from_and_told_of(tmp_path):
    def formula(values):
        found = bowl(values)
        return None if found["g"] < 0.5 else found

    runner, _ = optimised(write_formulas(tmp_path, TPE), tmp_path / "o", formula)
    assert spent(runner) == 24.0
    best = candidates_of(runner, SEARCH)[0]
    assert 0.5 <= best.trial.row["x"] < 0.65
    failed = [t for t in runner.book.of_kind(SEARCH) if not runner.score(t).counts]
    assert failed and all(runner.score(t).why == "failed: as told" for t in failed)
    files = write_report(runner)
    assert "failed: as told" in files[0].read_text("utf-8")
    with (tmp_path / "o" / "table.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert rows[failed[0].number]["why_not"] == "failed: as told"
    assert rows[failed[0].number]["feasible"] == "0"
    assert [int(row["run"]) for row in rows] == list(range(len(runner.book.trials)))


def test_all_runs_failing_ends_in_words(tmp_path):
    runner, _ = optimised(write_formulas(tmp_path, TPE), tmp_path / "o", lambda _: None)
    assert spent(runner) == 24.0
    assert "no run of the search counts" in answer_text(runner)
    assert write_report(runner)[0].exists()


def test_constraints_that_nothing_keeps_end_in_words(tmp_path):
    text = TPE + "[optimise.constraints]\ng = { least = 2 }\n"
    runner, _ = optimised(write_formulas(tmp_path, text), tmp_path / "o", bowl)
    words = answer_text(runner)
    assert "no settings keep all limits" in words and "where g ≥ 2 is wanted" in words
    highest = max(t.row["x"] for t in runner.book.of_kind(SEARCH))
    assert f"x {highest:.4g}" in words and highest > 0.95  # the nearest, and it was looked for
    assert write_report(runner)[0].exists()


def test_the_answer_keeps_its_limits(tmp_path):
    text = TPE + "[optimise.constraints]\ng = { least = 0.5 }\n"
    runner, _ = optimised(write_formulas(tmp_path, text), tmp_path / "o", bowl)
    for kind in (SEARCH, BASELINE):
        best = candidates_of(runner, kind)[0]
        assert best.trial.row["x"] >= 0.5
        feasible = [runner.score(t) for t in runner.book.of_kind(kind)]
        assert best.score.objectives[0] == min(s.objectives[0] for s in feasible if s.feasible)


def test_the_verdict_by_the_scenes_own_limits_is_a_constraint(tmp_path):
    def formula(values):
        covered = [made_up_tool(float(values["x"]))]
        limits = limits_entry(Limits(coverage={"punch": 0.5}))
        return {**bowl(values), "tools": covered, "limits": limits}

    text = TPE + "[optimise.constraints]\nfit = { least = 1 }\n"
    runner, _ = optimised(write_formulas(tmp_path, text), tmp_path / "o", formula)
    best = candidates_of(runner, SEARCH)[0]
    assert best.score.values["fit"] == 1.0 and 0.5 <= best.trial.row["x"] < 0.7
    scores = [runner.score(t) for t in runner.book.of_kind(SEARCH, BASELINE)]
    assert all(s.feasible == (s.values["g"] >= 0.5) for s in scores)
    assert not all(s.feasible for s in scores)


def test_what_is_not_quasi_static_does_not_count_unless_asked(tmp_path):
    def formula(values):
        return {**bowl(values), "quasi_static": float(values["y"]) < 0.4}

    runner, _ = optimised(write_formulas(tmp_path, TPE), tmp_path / "o", formula)
    assert candidates_of(runner, SEARCH)[0].trial.row["y"] < 0.4
    fast = next(t for t in runner.book.of_kind(SEARCH) if t.row["y"] > 0.4)
    assert "not quasi-static" in runner.score(fast).why
    text = TPE + "quasi_static = false\n"
    other, _ = optimised(write_formulas(tmp_path, text), tmp_path / "p", formula)
    assert abs(candidates_of(other, SEARCH)[0].trial.row["y"] - 0.6) < 0.2


def test_a_measure_that_is_not_there_stops_it_at_once(tmp_path):
    path = write_formulas(tmp_path, TPE.replace('f = "f"', 'f = "F_max"'))
    with pytest.raises(InputError, match="start from: measure f: the summary has no 'F_max'"):
        optimised(path, tmp_path / "o", bowl)


def test_every_combination_of_few_values_is_tried_once(tmp_path):
    text = TPE.replace("[measures]", "[parameters.kind]\nvalues = ['a', 'b']\n[measures]")
    for name in "xy":
        text = text.replace(
            f"[parameters.{name}]\nrange = [0, 1]", f"[parameters.{name}]\nvalues = [0.9, 0.1]"
        )
    runner, _ = optimised(write_formulas(tmp_path, text), tmp_path / "o", bowl)
    places = [t.place for t in runner.book.of_kind(START, SEARCH)]
    assert len(places) == len(set(places)) == 8


COARSE_TEXT = TPE + "coarse = { set = { cells = 8 }, share = 0.5 }\nbatch = 3\n"


def by_cells(values):
    found, cells = bowl(values), int(values["cells"]) if "cells" in values else 20
    return {"f": found["f"] + (5.0 if cells == 8 else 0.0), "g": found["g"]}


def test_coarse_runs_come_first_and_only_fine_ones_answer(tmp_path):
    runner, _ = optimised(write_formulas(tmp_path, COARSE_TEXT), tmp_path / "o", by_cells)
    book = runner.book
    part = (8 / 20) ** 2  # triangles; steps are alike
    assert coarse_cost(runner) == pytest.approx(part)
    assert number_of(runner, COARSE_START) == 1
    cost = number_of(runner, SEARCH) + 1 + part * (number_of(runner, COARSE) + 1)
    assert spent(runner) == pytest.approx(cost) and 23.0 < cost <= 24.0
    assert number_of(runner, BASELINE) == 22  # whole ones, and the start
    coarse = part * number_of(runner, COARSE)
    assert coarse / (cost - 1.0 - part) == pytest.approx(0.5, abs=0.05)
    numbers = {t.number for t in book.of_kind(COARSE)}
    promoted = [t.of for t in book.of_kind(SEARCH)]
    assert len(set(promoted)) == len(promoted) and set(promoted) <= numbers
    assert all(book.trials[t.of].row == t.row for t in book.of_kind(SEARCH))
    assert "cells=8" in book.settings(book.of_kind(COARSE)[0])
    assert "cells=8" not in book.settings(book.of_kind(SEARCH)[0])
    first = [t for t in book.of_kind(COARSE) if t.batch == 1]
    best = sorted(first, key=lambda t: runner.score(t).objectives[0])[:3]
    assert {t.number for t in best} == {t.of for t in book.of_kind(SEARCH) if t.batch == 1}
    best = candidates_of(runner, SEARCH)[0]
    assert best.trial.kind == SEARCH and best.score.objectives[0] < 1.02
    page = write_report(runner)[0].read_text("utf-8")
    assert "16 % of a full one" in page and "Rank correlation" in page


def test_coarse_runs_cut_off_and_started_again_come_to_the_same(tmp_path):
    path = write_formulas(tmp_path, COARSE_TEXT)
    whole, _ = optimised(path, tmp_path / "whole", by_cells)
    for after in (1, 20):
        optimised(path, tmp_path / f"cut{after}", by_cells, stop_after=after)
        again, _ = optimised(path, tmp_path / f"cut{after}", by_cells)
        assert again.book.trials == whole.book.trials


def test_coarse_runs_of_no_use_are_refused(tmp_path):
    dear = write_formulas(tmp_path, TPE + "coarse = { set = { cells = 40 } }\n")
    with pytest.raises(InputError, match="costs less than the coarse one"):
        optimised(dear, tmp_path / "a", by_cells)
    path = write_formulas(tmp_path, COARSE_TEXT)
    with pytest.raises(
        InputError, match=r"\[optimise.coarse\], does not count \(failed: as told\)"
    ):
        optimised(path, tmp_path / "b", lambda v: None if "cells" in v else bowl(v))


def test_repeats_choose_the_best_and_say_what_is_noise(tmp_path):
    def formula(values):
        found = bowl(values)
        cells = int(values.get("cells", 20))
        if cells != 20:  # what looked best by luck, close to the minimum, is not in the repeats
            lucky = found["f"] < 1.002
            found["f"] += 0.1 * (cells == 22) + (1.0 if lucky else 0.0)
        return found

    text = TPE.replace("repeats = []\n", "").replace("runs = 24", "runs = 32")
    runner, _ = optimised(write_formulas(tmp_path, text), tmp_path / "o", formula)
    assert number_of(runner, REPEAT) == 2 * 7
    found = candidates_of(runner, SEARCH)
    means = [c.mean(0) for c in found]
    assert means == sorted(means) and len(found[0].repeats) == 2
    settings = {t.settings for t in runner.book.of_kind(REPEAT)}
    assert settings == {("cells=18",), ("cells=22",)}
    assert {t.of for t in runner.book.of_kind(REPEAT)} >= {0}  # the start too
    answer_file = json.loads((write_report(runner)[0].parent / "answer.json").read_text("utf-8"))
    assert answer_file["gain_on_start"]["repeated"] == pytest.approx(
        1.0 - found[0].mean(0) / candidates_of(runner, START)[0].mean(0)
    )


def candidate(value, *repeats):
    trial = Trial(0, SEARCH, 1, {}, None)
    return Candidate(trial, Score({}, (value,)), tuple(Score({}, (r,)) for r in repeats))


def test_noise_is_what_neither_settings_nor_repeats_explain():
    random = np.random.default_rng(0)
    runs, meshes = 40, 5
    table = random.normal(0, 3, (runs, 1)) + random.normal(0, 2, (1, meshes))
    table = table + random.normal(0, 0.5, (runs, meshes))
    group = [candidate(0.0, *row) for row in table]
    found = noise_of(group, 0)
    assert found.deviation == pytest.approx(0.5, rel=0.1) and found.freedom == 39 * 4
    exact = [candidate(0.0, 1.0, 2.0, 4.0), candidate(0.0, 3.0, 4.0, 6.0)]
    assert noise_of(exact, 0).deviation == pytest.approx(0.0, abs=1e-12)
    cross = [candidate(0.0, 1.0, 0.0), candidate(0.0, 0.0, 1.0)]
    assert noise_of(cross, 0) == Noise(pytest.approx(1.0), 1)  # residuals ±1/2
    assert not noise_of([candidate(0.0, 1.0)], 0).known and not noise_of([], 0).known


def test_gain_is_told_with_its_doubt():
    better, start, noise = candidate(30.0, 33.0, 35.0), candidate(40.0, 42.0, 43.0), Noise(1.7, 9)
    gain = gain_of(better, start, 0, noise)
    assert gain.single == pytest.approx(0.25)
    assert gain.repeated == pytest.approx(8.5 / 42.5)
    assert gain.error == pytest.approx(1.7 / 42.5) and gain.certain is True
    assert gain_of(candidate(30.0, 41.0, 42.0), start, 0, noise).certain is False
    twice = Noise(8.5 / 2.5, 1)  # 2.5 standard errors: sure of many runs, and not of two
    assert gain_of(better, start, 0, twice).certain is False
    assert gain_of(better, start, 0, Noise(8.5 / 2.5, 60)).certain is True
    bare = gain_of(candidate(3.0), candidate(4.0), 0, Noise())
    assert bare.single == 0.25 and math.isnan(bare.repeated) and bare.certain is None
    larger = gain_of(candidate(-5.0), candidate(-4.0), 0, Noise())  # of what is to be large
    assert larger.single == pytest.approx(0.25)
    assert math.isnan(gain_of(candidate(-1.0), candidate(0.0), 0, Noise()).single)


def test_limits_that_break_in_a_repeat_put_a_run_behind(tmp_path):
    def formula(values):
        found = bowl(values)
        wide = int(values.get("cells", 20)) != 20
        return {**found, "g": 2.0 if wide and found["f"] == 1.0 else 0.5}

    text = TPE.replace("repeats = []", "").replace("range = [0, 1]", "values = [0.3, 0.6, 0.9]")
    text += "[optimise.constraints]\ng = { most = 1 }\n"
    runner, _ = optimised(write_formulas(tmp_path, text), tmp_path / "o", formula)
    found = candidates_of(runner, SEARCH)
    assert found[-1].score.objectives == (1.0,) and not found[-1].holds  # the best but for that
    assert [c.holds for c in found] == [True, True, False]
    assert "in all repeats" in answer_text(runner)


TWO = TPE.replace('minimise = "f"', 'minimise = "f"\nmaximise = "g"')


def test_two_objectives_give_a_front(tmp_path):
    def formula(values):
        x, y = float(values["x"]), float(values["y"])
        return {"f": 1.0 + x**2 + y**2, "g": x - y**2}

    runner, _ = optimised(write_formulas(tmp_path, TWO), tmp_path / "o", formula)
    front = candidates_of(runner, SEARCH)
    assert 2 <= len(front) <= 3
    f, g = ([c.score.values[k] for c in front] for k in "fg")
    assert f == sorted(f) and g == sorted(g)
    (_, ours), (_, random) = history_of(runner, SEARCH)[-1], history_of(runner, BASELINE)[-1]
    assert ours > random > 0.0
    files = write_report(runner)
    assert {"front.png", "convergence.png", "field.png"} <= {file.name for file in files}
    words = answer_text(runner)
    assert "on the front, by f and g" in words and "area under the front" in words


def test_the_report_says_what_was_gained(tmp_path):
    runner, _ = optimised(write_formulas(tmp_path, STUDY), tmp_path / "o", bowl)
    files = write_report(runner)
    page = files[0].read_text("utf-8")
    best = candidates_of(runner, SEARCH)[0]
    for words in (
        f"best settings, run {best.trial.number}",
        "the start, run 0",
        "the best at random",
        "gain: ",
        "Method gp, seed 1, batches of 4",
        "cost 24 of 24",
        f"--set x={best.trial.row['x']!r}",
        "Processor time: search",
    ):
        assert words in page, words
    assert page.count("data:image/png") == 2 and "http" not in page
