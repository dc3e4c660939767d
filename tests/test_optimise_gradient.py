"""The method that goes by slopes: where it comes to, what it keeps, what it says it cannot."""

import math

import numpy as np
import pytest
from optimise_checks import STUDY, bowl, optimised, write_formulas

from warpdrape.errors import InputError
from warpdrape.optimisation.aims import Score
from warpdrape.optimisation.answer import candidates_of, history_of
from warpdrape.optimisation.book import BASELINE, SEARCH
from warpdrape.optimisation.descent import ENOUGH, _Broken, _Runs, _Wanted, propose
from warpdrape.optimisation.known import Known
from warpdrape.optimisation.optimise_file import read_optimisation
from warpdrape.optimisation.space import random_places

GRADIENT = STUDY + 'method = "gradient"\nrepeats = []\n'
LIMIT = GRADIENT + "[optimise.constraints]\ng = { least = 0.5 }\n"


def best_of(runner):
    found = candidates_of(runner, SEARCH)[0]
    return found.trial.row, runner.score(found.trial)


def test_it_comes_to_the_least_in_fewer_runs_than_random_settings(tmp_path):
    runner, hands = optimised(write_formulas(tmp_path, GRADIENT), tmp_path / "o", bowl)
    row, _ = best_of(runner)
    assert row["x"] == pytest.approx(0.3, abs=0.01) and row["y"] == pytest.approx(0.6, abs=0.01)
    gap, random = (history_of(runner, kind)[-1][1] - 1.0 for kind in (SEARCH, BASELINE))
    assert gap < ENOUGH * 1.2 < random  # 1.2: the steepest slope at the start
    assert hands.sizes[:3] == [1, 8, 8]  # four of slopes and four at random, at a time


def test_limits_are_kept_and_reached(tmp_path):
    runner, _ = optimised(write_formulas(tmp_path, LIMIT), tmp_path / "o", bowl)
    row, score = best_of(runner)
    assert score.feasible and row["x"] >= 0.5
    assert row["x"] == pytest.approx(0.5, abs=0.005) and row["y"] == pytest.approx(0.6, abs=0.02)


def test_a_curved_limit_is_kept_too(tmp_path):
    """Each step is along the limit's slope: it would end just outside."""
    text = GRADIENT.replace("runs = 24", "runs = 40").replace('minimise = "f"', 'minimise = "g"')
    text += "[optimise.constraints]\nf = { most = 1.04 }\n"
    runner, _ = optimised(write_formulas(tmp_path, text), tmp_path / "o", bowl)
    row, score = best_of(runner)
    assert score.feasible
    assert row["x"] == pytest.approx(0.1, abs=0.01) and row["y"] == pytest.approx(0.6, abs=0.05)


def test_what_is_largest_is_found_at_the_end_of_an_axis(tmp_path):
    text = GRADIENT.replace('minimise = "f"', 'maximise = "g"')
    runner, _ = optimised(write_formulas(tmp_path, text), tmp_path / "o", bowl)
    assert best_of(runner)[0]["x"] == 1.0


@pytest.mark.parametrize("after", [0, 3, 12, 30, 44])
def test_cut_off_and_started_again_it_comes_to_the_same(tmp_path, after):
    path = write_formulas(tmp_path, LIMIT)
    whole, _ = optimised(path, tmp_path / "whole", bowl)
    optimised(path, tmp_path / "cut", bowl, stop_after=after)
    again, _ = optimised(path, tmp_path / "cut", bowl)
    assert again.book.trials == whole.book.trials


def test_runs_that_fail_make_a_step_shorter(tmp_path):
    """The first step, by the steepest slope, is an axis long: it goes where runs fail."""

    def formula(values):
        return None if float(values["x"]) < 0.2 else bowl(values)

    runner, _ = optimised(write_formulas(tmp_path, GRADIENT), tmp_path / "o", formula)
    failed = [t for t in runner.book.of_kind(SEARCH) if not runner.score(t).counts]
    assert failed and history_of(runner, SEARCH)[-1][1] - 1.0 < 1e-3


def test_another_descent_begins_where_one_has_ended(tmp_path):
    """Two valleys; the start lies in the one that is less deep."""

    def formula(values):
        x = float(values["x"])
        return {"f": -math.exp(-(((x - 0.85) / 0.15) ** 2)) - 2.0 * math.exp(-((x / 0.25) ** 2))}

    text = GRADIENT.replace("[parameters.y]\nrange = [0, 1]\n", "").replace('g = "g"\n', "")
    runner, _ = optimised(
        write_formulas(tmp_path, text.replace("runs = 24", "runs = 60")), tmp_path / "o", formula
    )
    assert history_of(runner, SEARCH)[-1][1] < -1.99
    places = np.array([t.place[0] for t in runner.book.of_kind(SEARCH)])
    assert (abs(places - 0.85) < 0.01).any()  # where the first one came to


def test_a_descent_that_has_ended_is_not_begun_again_beside_its_runs(tmp_path):
    """What follows is a place at random, and nothing about runs that were there for slopes."""
    axes = read_optimisation(write_formulas(tmp_path, GRADIENT)).axes
    places, known = [(0.9, 0.9)], []
    while places != random_places(axes, 1, 7) and len(known) < 100:
        known += [Known(p, Score({}, (bowl({"x": p[0], "y": p[1]})["f"],))) for p in places]
        places = propose(axes, known, 4, 7)
    assert len(known) < 30
    assert min(each.score.objectives[0] for each in known) < 1.0 + 1.2 * ENOUGH


def test_slopes_are_second_order_to_the_ends_of_an_axis():
    """Of a quadratic they are exact; at the ends from one side alone."""
    asked = []

    def slopes(place, step):
        there = {}
        while True:
            try:
                return _Runs(there, set()).slopes(place, step)
            except _Wanted as wanted:
                asked.extend(wanted.places)
                for x, y in wanted.places:
                    value = 3.0 * x**2 - 2.0 * x + x * y + y**2
                    there[(x, y)] = Score({}, (value,), (x - 5.0 * y**2,))

    for x in (0.0, 0.01, 0.5, 0.99, 1.0):
        for y in (0.0, 0.4, 1.0):
            exact = [[6.0 * x - 2.0 + y, x + 2.0 * y], [1.0, -10.0 * y]]
            assert slopes((x, y), 0.025) == pytest.approx(np.array(exact), abs=1e-9)
    assert all(0.0 <= at <= 1.0 for place in asked for at in place)


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        (lambda x: round(12.0 * x) + 0.01 * x, "changes with x by"),
        (lambda x: x + 0.05 * math.sin(900.0 * x), "no slope to be trusted"),
        (lambda x: None if x > 0.9 else x, "does not count"),
    ],
)
def test_where_no_slope_is_to_be_trusted_it_says_so_and_ends(tmp_path, formula, words):
    def measures(values):
        value = formula(float(values["x"]))
        return None if value is None else {"f": value + float(values["y"]), "g": 0.0}

    with pytest.raises(InputError, match=words) as caught:
        optimised(write_formulas(tmp_path, GRADIENT), tmp_path / "o", measures)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("aim", "limits", "words", "sign"),
    [
        ('minimise = "f"', "f = { most = 9 }\nup = { least = 0.5 }", "up ≥ 0.5", 1.0),
        ('minimise = "f"', "up = { least = 0.5, most = 7 }", "up ≤ 7", 1.0),
        ('maximise = "down"', "f = { most = 9 }", "largest down", -1.0),
    ],
)
def test_it_names_what_has_no_slope_as_its_file_does(tmp_path, aim, limits, words, sign):
    """And by how much that measure goes, not what is made small for its sake."""

    def stairs(values):
        step = float(round(12.0 * float(values["x"])))
        return bowl(values) | {"up": step, "down": -step}

    text = GRADIENT.replace('g = "g"', 'up = "up"\ndown = "down"').replace('minimise = "f"', aim)
    text += f"[optimise.constraints]\n{limits}\n"
    with pytest.raises(InputError) as caught:
        optimised(write_formulas(tmp_path, text), tmp_path / "o", stairs)
    said = str(caught.value)
    assert f"the measure of '{words}' changes with x by" in said
    assert sign * float(said.split("changes with x by ")[1].split(" ")[0]) > 1.0


def test_a_slope_that_matters_little_need_not_be_known(tmp_path):
    def formula(values):
        x, y = float(values["x"]), float(values["y"])
        return {"f": (x - 0.3) ** 2 + 5e-4 * math.sin(40.0 * y), "g": x}

    runner, _ = optimised(write_formulas(tmp_path, GRADIENT), tmp_path / "o", formula)
    assert best_of(runner)[0]["x"] == pytest.approx(0.3, abs=0.02)


def test_a_run_beside_that_does_not_count_gives_no_slope():
    there = {(0.5,): Score({}, (1.0,)), (0.525,): Score(why="failed: as told")}
    there[(0.475,)] = Score({}, (1.0,))
    with pytest.raises(_Broken, match="as told"):
        _Runs(there, set()).slopes((0.5,), 0.025)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[parameters.y]\nrange = [0, 1]", '[parameters.kind]\nvalues = ["a", "b"]', "kind has"),
        ("[parameters.y]\nrange = [0, 1]", "[parameters.n]\nrange = [1, 9]", "n has"),
        ('minimise = "f"', 'minimise = ["f", "g"]', "one measure"),
        ("repeats = []", "coarse = { set = { cells = 10 } }\nrepeats = []", "coarse"),
    ],
)
def test_what_has_no_slopes_is_refused_and_the_other_method_takes_it(tmp_path, old, new, words):
    text = GRADIENT.replace(old, new)
    with pytest.raises(InputError, match=f"'gradient'.*{words}.*method = 'gp'"):
        read_optimisation(write_formulas(tmp_path, text))
    read_optimisation(write_formulas(tmp_path, text.replace('"gradient"', '"gp"')))
