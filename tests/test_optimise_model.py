"""Optimisations: the space, what a model is told, where it says to look, fronts, fidelity."""

import math
from itertools import product

import numpy as np
import pytest
from optimise_checks import STUDY, write_formulas
from scipy.integrate import quad
from scipy.stats import norm

from warpdrape.errors import InputError
from warpdrape.optimisation import gaussian
from warpdrape.optimisation.aims import Aims, Constraint, Objective, Score
from warpdrape.optimisation.fidelity import agreement, corrected, promoted, shares_of
from warpdrape.optimisation.front import area_dominated, front_of, ranked
from warpdrape.optimisation.known import Known, as_numbers
from warpdrape.optimisation.methods import GP, METHODS, TPE
from warpdrape.optimisation.optimise_file import read_optimisation
from warpdrape.optimisation.space import features, place_of, random_places, row_at, spread_places

ALL_KINDS = """
scene = "formulas.py"
[parameters.x]
log_range = ["1 mm", "1 m"]
[parameters.y]
range = [-2, 2]
[parameters.n]
log_range = [2, 200]
[parameters.kind]
values = ["a", "b", "c"]
[parameters.cells]
values = [4, 8, 16]
[measures]
f = "f"
[optimise]
minimise = "f"
runs = 8
"""


MODELS = (GP, TPE)  # descents begin at their own places, of numbers only: test_optimise_gradient


def axes_of_all_kinds(tmp_path):
    return read_optimisation(write_formulas(tmp_path, ALL_KINDS)).axes


def test_values_of_an_axis_come_back_to_their_place(tmp_path):
    axes = axes_of_all_kinds(tmp_path)
    assert [axis.kind for axis in axes] == ["share", "share", "whole", "choice", "whole"]
    middle = row_at(axes, (0.5, 0.25, 20.0, 1.0, 2.0))
    assert middle == {"x": pytest.approx(0.001**0.5), "y": -1.0, "n": 20, "kind": "b", "cells": 16}
    for place in random_places(axes, 50, 3):
        row = row_at(axes, place)
        assert 0.001 <= row["x"] <= 1.0 and 2 <= row["n"] <= 200 and isinstance(row["n"], int)
        assert place_of(axes, row) == pytest.approx(place)
    for name, outside in (("x", 2.0), ("n", 1), ("kind", "d"), ("cells", 9), ("y", None)):
        assert place_of(axes, {**middle, name: outside}) is None


def test_random_places_go_all_over_by_logarithm_too(tmp_path):
    axes = axes_of_all_kinds(tmp_path)
    rows = [row_at(axes, p) for p in random_places(axes, 4000, 1)]
    assert np.mean([row["x"] < 0.1 for row in rows]) == pytest.approx(2 / 3, abs=0.03)
    assert np.mean([row["n"] < 20 for row in rows]) == pytest.approx(0.5, abs=0.03)
    for word in "abc":
        assert np.mean([row["kind"] == word for row in rows]) == pytest.approx(1 / 3, abs=0.03)
    assert {row["n"] for row in rows} >= {2, 200} and {row["cells"] for row in rows} == {4, 8, 16}


def test_places_of_more_begin_with_those_of_fewer(tmp_path):
    axes = axes_of_all_kinds(tmp_path)
    for places in (spread_places, random_places):
        assert places(axes, 11, 5)[:4] == places(axes, 4, 5)
        assert places(axes, 4, 5) != places(axes, 4, 6)
    halves = np.array(spread_places(axes, 16, 2))[:, 0] < 0.5
    assert halves.sum() == 8  # evenly, as a Sobol sequence is


def test_features_are_between_0_and_1_and_words_as_far_as_an_axis(tmp_path):
    axes = axes_of_all_kinds(tmp_path)
    ends = np.array([[0, 0, 2, 0, 0], [1, 1, 200, 2, 2], [0, 0, 20, 1, 1]])
    found = features(axes, ends)
    assert found.shape == (3, 7)
    np.testing.assert_allclose(found[:, 2], [0, 1, 0.5])  # by the logarithm
    np.testing.assert_allclose(found[:, 6], [0, 1, 0.5])
    for one, other in ((0, 1), (1, 2), (0, 2)):
        assert np.linalg.norm(found[one, 3:6] - found[other, 3:6]) == pytest.approx(1.0)


def score(*objectives, excess=(), why=""):
    return Score({}, tuple(objectives), tuple(excess), why)


def test_what_a_model_is_told():
    told = [score(1.0, excess=(-3.0, 1e-3)), score(5.0, excess=(4.0, -2e-3)), Score(why="failed")]
    told.append(score(2.0, excess=(2.0, 3e-3)))
    values, excess = as_numbers(told)
    assert values[:, 0].tolist() == [1.0, 5.0, 5.0, 2.0]  # failed as the worst
    np.testing.assert_allclose(excess[:, 0], [-1.0, 4 / 3, 4 / 3, 2 / 3])  # mean violation 3
    np.testing.assert_allclose(excess[:, 1], [0.5, -1.0, 1.5, 1.5])  # mean violation 0.002
    assert excess[:, 2].tolist() == [-1.0, -1.0, 1.0, -1.0]
    _, never = as_numbers([score(1.0, excess=(-4.0,)), score(2.0, excess=(-1.0,))])
    assert never[:, 0].tolist() == [-1.0, -0.25]
    _, bare = as_numbers([score(1.0, excess=(0.0,)), score(2.0, excess=(3e-4,))])
    assert bare[:, 0].tolist() == [-1.0, 1.0]  # no wrinkle is not on the edge of wrinkling
    _, edge = as_numbers([score(1.0, excess=(0.0,)), score(2.0, excess=(-2.0,))])
    assert edge[:, 0].tolist() == [0.0, -1.0]


@pytest.mark.parametrize("z", [-12.0, -6.0, -5.001, -4.999, -1.0, 0.0, 2.0, 8.0])
def test_expected_improvement_is_the_integral(z):
    def improvement(u):  # exp(z²/2) out of the integral, so that it does not vanish
        return u * math.exp(-0.5 * u * u + z * u) if z < 0 else u * norm.pdf(z - u)

    integral = quad(improvement, 0.0, 40.0, epsabs=0.0, epsrel=1e-10)[0]
    exact = math.log(integral)
    if z < 0:
        exact += -0.5 * z * z - 0.5 * math.log(2.0 * math.pi)
    assert gaussian.log_improvement(np.array([z]))[0] == pytest.approx(exact, abs=1e-7)


def known_of(axes, function, count=20, seed=0, noise=0.0, excess=None):
    random = np.random.default_rng(seed)
    return [
        Known(p, score(function(*p) + noise * random.standard_normal(), excess=excess(*p)))
        if excess
        else Known(p, score(function(*p) + noise * random.standard_normal()))
        for p in spread_places(axes, count, seed)
    ]


@pytest.fixture
def plane(tmp_path):
    return read_optimisation(write_formulas(tmp_path)).axes


def bowl(x, y):
    return (x - 0.3) ** 2 + (y - 0.6) ** 2


@pytest.mark.parametrize("method", MODELS)
def test_a_method_looks_near_the_best_and_repeats_itself_exactly(plane, method):
    known = known_of(plane, bowl)
    near = METHODS[method](plane, known, 4, 7)
    assert len(set(near)) == 4
    assert np.median([bowl(*p) for p in near]) < 0.3 * np.median([bowl(*k.place) for k in known])
    assert METHODS[method](plane, known, 4, 7) == near
    assert METHODS[method](plane, known, 4, 8) != near


@pytest.mark.parametrize("method", MODELS)
def test_a_method_keeps_limits_and_keeps_off_where_runs_fail(plane, method):
    asked = 5 if method == "gp" else 40  # each is dear; at random six in ten were right
    known = known_of(plane, lambda x, y: x, 24, excess=lambda x, y: (0.5 - x,))
    within = [x for x, _ in METHODS[method](plane, known, asked, 1)]
    assert np.mean(np.array(within) >= 0.45) >= 0.75
    assert min(within) < 0.65  # but as near to the limit as can be
    fails = Score(why="failed")
    failing = [Known(k.place, fails if k.place[0] < 0.4 else k.score) for k in known]
    there = [x for x, _ in METHODS[method](plane, failing, asked, 1)]
    assert np.mean(np.array(there) >= 0.38) >= 0.75, there


def test_a_batch_spreads_and_no_place_lies_beside_another(plane):
    known = known_of(plane, bowl, 6)
    found = np.array(gaussian.propose(plane, known, 5, 7))
    improving, doubted = found[::2], found[1::2]
    assert np.ptp(improving, axis=0).max() > 0.3  # the first is believed: others are elsewhere
    assert np.linalg.norm(doubted - improving[0], axis=1).min() > 0.05
    all_of = np.vstack([[k.place for k in known], found])
    gaps = np.linalg.norm(all_of[:, None] - all_of[None], axis=2) + np.eye(len(all_of))
    assert gaps[6:].min() > 0.1 * len(all_of) ** -0.5
    dense = known_of(plane, bowl, 20)  # where all would lie at the minimum
    all_of = np.vstack([[k.place for k in dense], gaussian.propose(plane, dense, 5, 7)])
    gaps = np.linalg.norm(all_of[:, None] - all_of[None], axis=2) + np.eye(len(all_of))
    assert gaps[20:].min() > 0.1 * len(all_of) ** -0.5
    assert gaps[20, [21, 23]].min() > 0.05  # every other one is no neighbour of the first


@pytest.mark.parametrize("method", MODELS)
def test_two_objectives_are_both_looked_for(plane, method):
    known = [
        Known(p, score(x**2 + (y - 0.5) ** 2, (x - 1.0) ** 2 + (y - 0.5) ** 2))
        for p in spread_places(plane, 30, 2)
        for x, y in [p]
    ]
    found = METHODS[method](plane, known, 5 if method == "gp" else 16, 3)
    assert np.median([abs(y - 0.5) for _, y in found]) < 0.15  # the front is y = 0.5
    assert np.ptp([x for x, _ in found]) > 0.3


def test_methods_know_words_and_whole_numbers(tmp_path):
    axes = axes_of_all_kinds(tmp_path)

    def cost(row):
        return abs(math.log(row["n"] / 20)) + (row["kind"] != "b") + 0.1 * row["y"] ** 2

    places = spread_places(axes, 40, 1)
    known = [Known(p, score(cost(row_at(axes, p)))) for p in places]
    for method in MODELS:
        rows = [row_at(axes, p) for p in METHODS[method](axes, known, 4, 2)]
        assert sum(row["kind"] == "b" for row in rows) >= 3
        assert np.median([abs(math.log(row["n"] / 20)) for row in rows]) < 1.0


def brute_front(points):
    return [
        k for k, p in enumerate(points) if not any(all(np.array(q) <= p) and q != p for q in points)
    ]


def test_fronts_against_brute_force():
    random = np.random.default_rng(4)
    for _ in range(20):
        points = [tuple(p) for p in random.integers(0, 6, (15, 2)).tolist()]
        front = front_of(points)
        assert {points[k] for k in front} == {points[k] for k in brute_front(points)}
        assert len({points[k] for k in front}) == len(front)


def test_area_against_counting():
    random = np.random.default_rng(2)
    for _ in range(5):
        points = random.random((6, 2)).tolist()
        corner = (0.9, 0.8)
        grid = [((i + 0.5) / 300, (j + 0.5) / 300) for i, j in product(range(300), repeat=2)]
        inside = sum(
            x < corner[0] and y < corner[1] and any(x >= p and y >= q for p, q in points)
            for x, y in grid
        )
        assert area_dominated(points, corner) == pytest.approx(inside / 300**2, abs=6e-3)
    assert area_dominated([(1.0, 0.0)], (0.9, 0.8)) == 0.0


def test_order_of_runs():
    scores = [
        score(3.0, excess=(-1.0, 0.0)),
        score(1.0, excess=(2.0, -1.0)),
        Score(why="failed"),
        score(2.0, excess=(-1.0, -1.0)),
        score(0.0, excess=(-1.0, 0.03)),
        score(9.0, excess=(1.0, -1.0)),
    ]
    assert ranked(scores) == [3, 0, 5, 1, 4, 2]
    assert ranked([]) == []
    two = [score(0.0, 9.0), score(1.0, 1.0), score(0.9, 1.2), score(9.0, 0.0), score(2.0, 2.0)]
    order = ranked(two)
    assert set(order[:2]) == {0, 3} and order[-1] == 4  # ends of the front first


def test_shares_of_a_budget_never_exceed_it():
    assert shares_of(31.0, 4, 0.0, 1.0).fine == 4 and shares_of(2.9, 4, 0.0, 1.0).fine == 2
    assert shares_of(0.9, 4, 0.0, 1.0).fine == 0
    first = shares_of(31.0, 4, 0.5, 0.1)
    assert (first.fine, first.coarse) == (4, 40)
    for left in np.linspace(0.0, 12.0, 49):
        for share, cost in ((0.5, 0.13), (0.2, 0.4), (0.9, 0.05)):
            found = shares_of(left, 4, share, cost)
            assert found.fine + cost * found.coarse <= left + 1e-6
            assert (found.fine >= 1) == (left >= 1.0)


def test_coarse_runs_are_corrected_and_the_best_are_promoted():
    aims = Aims((Objective("f"),), (Constraint("g", 1.0),))

    def both(f, g):
        return aims.score({"f": f, "g": g}, {})

    pairs = [(both(2.0, 0.0), both(5.0, 0.5)), (both(4.0, 0.0), both(6.0, 0.7))]
    found = corrected(both(1.0, 0.6), aims, pairs)
    assert found.objectives == pytest.approx((3.5,)) and not found.feasible
    assert found.excess == pytest.approx((0.2,))
    assert corrected(both(1.0, 0.6), aims, []) == both(1.0, 0.6)
    failed = Score(why="failed")
    assert corrected(failed, aims, pairs) is failed
    assert promoted([both(3, 0), failed, both(1, 0), both(0, 9), both(2, 0)], 3) == [2, 4, 0]
    assert promoted([failed, both(0, 9)], 3) == [1]
    more = [*pairs, (both(1.0, 0.0), both(7.0, 0.0)), (failed, both(0, 0))]
    assert agreement(more)[0] == pytest.approx(-0.5) and agreement(pairs) == []


BAD = {
    'minimise = "f"': ('minimise = "h"', "there is no measure 'h'; known: f, fit, g"),
    "runs = 24": ("runs = 1", "runs = 1 must be a whole number, 2 or more"),
    'f = "f"': ('e = "f"', "minimise: there is no measure 'f'"),
    "range = [0, 1]\n[parameters.y]": (
        "triangular = { low = 0, mode = 0, high = 1 }\n[parameters.y]",
        "parameter 'x': an optimisation looks within values, range or log_range",
    ),
    "[optimise]": ("[optimize]", "key 'optimize' is unknown; did you mean 'optimise'"),
}
MORE = {
    "batch = 0": "batch = 0 must be a whole number, 1 or more",
    'method = "ga"': "method = 'ga' must be one of gp, tpe",
    'maximise = "f"': "give one objective or two",
    'maximise = ["g", "g"]': "give one objective or two",
    "quasi_static = 1": "quasi_static = 1 must be true or false",
    "constraints = 3": "constraints = 3 must be a table",
    "constraints.g = 3": "must be { most = NUMBER }",
    "constraints.g.mots = 3": "'mots' is unknown; did you mean 'most'",
    "constraints.g.most = nan": "must be finite",
    'constraints.g.most = "locking"': "no locking_angle: give a number",
    "constraints.g = { most = 1, least = 2 }": "nothing is below most and above least",
    "constraints.h.most = 3": "there is no measure 'h'",
    "start.z = 3": "'z' is unknown",
    "start.x = true": "x = 'true' must be a number",
    "coarse.share = 0.5": "coarse: set is missing",
    "coarse = { set = { cells = 4 }, share = 1 }": "share = 1 must lie between 0 and 1",
    "coarse = { set = { x = 4 } }": "x is a parameter that is searched",
    "coarse = { set = { cell = 4 } }": "no parameter 'cell'; did you mean 'cells'",
    "repeats = 3": "must be a list of tables",
    "repeats = [{}]": "each must change something",
    "repeats = [{ cells = 3 }, { cells = 3 }]": "each else",
    "repeats = [{ y = 3 }]": "y is a parameter that is searched",
    "run = 3": "'run' is unknown; did you mean 'runs'",
}


@pytest.mark.parametrize("old", BAD)
def test_what_makes_no_sense_is_said(tmp_path, old):
    new, words = BAD[old]
    assert old in STUDY
    path = write_formulas(tmp_path, STUDY.replace(old, new))
    with pytest.raises(InputError) as error:
        read_optimisation(path)
    assert words in str(error.value) and str(path) in str(error.value)


@pytest.mark.parametrize("line", MORE)
def test_what_else_makes_no_sense_is_said(tmp_path, line):
    path = write_formulas(tmp_path, f"{STUDY}{line}\n")
    with pytest.raises(InputError) as error:
        read_optimisation(path)
    assert MORE[line] in str(error.value)


def test_what_a_file_says_is_read(tmp_path):
    text = STUDY.replace('minimise = "f"', 'maximise = "f"\nseed = 5\nstart = { x = "20 mm" }')
    task = read_optimisation(
        write_formulas(tmp_path, text + "[optimise.constraints]\ng = { least = 2, most = 3 }\n")
    )
    assert task.aims.objectives == (Objective("f", -1.0),)
    assert [c.words for c in task.aims.constraints] == ["g ≤ 3", "g ≥ 2"]
    assert [c.excess(3.5) for c in task.aims.constraints] == [0.5, -1.5]
    assert task.start == {"x": 0.02, "y": 0.9} and task.seed == 5
    assert task.repeats == (("cells=18",), ("cells=22",)) and task.coarse is None
    assert read_optimisation(tmp_path / "made_up.toml", seed=9).seed == 9


def test_limit_is_the_fabrics_own_locking_angle(tmp_path):
    from importlib import resources

    card = (resources.files("warpdrape.fabrics") / "synthetic_plain_crimp.toml").read_text("utf-8")
    card += '\n[locking_angle]\nvalue = 52.0\nunit = "deg"\nsource = "-"\nstatus = "assumed"\n'
    (tmp_path / "mine.toml").write_text(card, encoding="utf-8")
    path = tmp_path / "o.toml"
    path.write_text(
        'scene = "hemisphere"\n[set]\nfabric = "mine.toml"\n[parameters.holder_force]\n'
        'range = [50, 100]\n[measures]\ng = "plies.*.max_shear_deg"\n[optimise]\nminimise = "g"\n'
        'runs = 4\nconstraints.g.most = "locking"\n',
        encoding="utf-8",
    )
    assert read_optimisation(path).aims.constraints[0].limit == pytest.approx(52.0)
