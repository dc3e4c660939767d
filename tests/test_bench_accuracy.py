"""The benchmark of accuracies: its errors, its scatter, and the runs that it keeps."""

import json
import sys
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numerical_error_checks import MEASURES, blank

from warpdrape.results import numerical_error as cost
from warpdrape.results.numerical_error import numerical_error

PARTS = ("ways", "one_run", "errors", "picture", "table")


@pytest.fixture(scope="module")
def bench():
    """The benchmark's modules, for this file only."""
    folder, before = Path(__file__).parents[1] / "bench" / "accuracy", set(sys.modules)
    sys.path.insert(0, str(folder))
    try:
        yield SimpleNamespace(**{name: import_module(name) for name in PARTS})
    finally:
        sys.path.remove(str(folder))
        for name in set(sys.modules) - before:
            if str(getattr(sys.modules[name], "__file__", "")).startswith(str(folder)):
                del sys.modules[name]


def made_up(p95=40.0, drawn=10.0, force=100.0, seconds=2.0):
    """Figures of a run whose punch meets a force that rises with its way."""
    way = np.minimum(np.arange(61) / 50.0, 1.0) * 0.075
    return {
        "seconds": seconds,
        "steps": 100,
        "p95": [p95, 30.0],
        "largest": [p95 + 5.0, 35.0],
        "draw_in": [drawn, 8.0],
        "wrinkle": 0.0,
        "penetration": 0.01,
        "kinetic": 0.01,
        "strain": 0.0,
        "said": [0.4, 0.5],
        "way": way.tolist(),
        "force": (force * way / 0.075).tolist(),
    }


def test_it_takes_errors_of_means_and_scatter_of_runs(bench):
    exact = [made_up(40.0), made_up(40.2)]
    runs = [made_up(40.5, 10.4, 110.0, 1.0), made_up(40.1, 10.6, 110.0, 3.0)]
    row = bench.errors.row_of("hemisphere_0", "some", runs, exact, 4.0)
    assert row.p95_deg == pytest.approx(0.2) and row.largest_deg == pytest.approx(0.2)
    assert row.draw_in_mm == pytest.approx(0.5)
    assert (row.scatter_deg, row.scatter_mm) == pytest.approx((0.4, 0.2))
    assert (row.seconds, row.ratio) == pytest.approx((2.0, 0.5))
    assert row.end_force == pytest.approx(0.1)
    middles = (np.arange(20) + 0.5) / 20.0
    over = np.sqrt(np.mean((0.1 * middles) ** 2)) / middles[-1]
    assert row.force == pytest.approx(over, rel=1e-3)
    lines = bench.errors.markdown([row]).splitlines()
    assert len({line.count("|") for line in lines}) == 1 and "0.20°" in lines[-1]


def test_it_sets_what_runs_say_beside_what_was_measured(bench):
    """The smallest that one of them says: each is to hold. A drape says nothing."""
    runs = [made_up() | {"said": [0.3, 0.6]}, made_up() | {"said": [0.4, 0.2]}]
    row = bench.errors.row_of("hemisphere_0", "some", runs, [made_up()], 4.0)
    assert (row.said_deg, row.said_mm) == (0.3, 0.2)
    assert row.scatter_deg == row.scatter_mm == 0.0
    assert "| 0.00° | 0.30° | 0.00° | 0.00 mm | 0.20 mm | 0.00 mm |" in bench.errors.markdown([row])
    silent = [made_up() | {"said": None}]
    row = bench.errors.row_of("circular_table", "some", silent, [made_up()], 4.0)
    assert (row.said_deg, row.said_mm) == (None, None) == (row.scatter_deg, row.scatter_mm)
    assert "| 0.00° | – | – | 0.00 mm | – | – |" in bench.errors.markdown([row])
    entry = numerical_error(MEASURES | {"max_penetration_m": 1e-4}, [blank()])
    said_deg, said_mm = bench.one_run.said_of(entry)
    assert said_deg == pytest.approx(cost.CONTACT_SHEAR * 1e-4)
    assert said_mm == pytest.approx(cost.CONTACT_DRAW_IN * 0.1)
    assert bench.one_run.said_of({"not_known": "nothing is pressed"}) is None


def test_it_compares_forces_at_the_same_place(bench):
    """A punch that goes half as fast meets the same force on its way."""
    quick, slow = made_up(), made_up()
    way = np.minimum(np.arange(61) / 30.0, 1.0) * 0.075
    slow |= {"way": way.tolist(), "force": (100.0 * way / 0.075).tolist()}
    end, over = bench.errors.force_errors([slow], [quick])
    assert end == pytest.approx(0.0, abs=1e-9) and over < 1e-6


def test_it_runs_a_case_and_keeps_it(bench, tmp_path, monkeypatch):
    monkeypatch.setitem(bench.ways.CASES, "small", ("hemisphere", {"cells": 4, "duration": 0.004}))
    found = bench.one_run.run_here("small", {"yarn_softening": 16.0, "travel": 0.01}, 1)
    assert found["seconds"] > 0.0 and found["steps"] > 100 and found["strain"] > 0.0
    assert len(found["force"]) == bench.one_run.FRAMES + 1 and len(found["p95"]) == 1
    assert "said" in found
    again = bench.one_run.run_here("small", {"yarn_softening": 16.0, "travel": 0.01}, 2)
    assert again["force"] != found["force"]  # another rounding
    np.testing.assert_allclose(again["p95"], found["p95"], atol=0.01)


def test_it_does_no_run_twice_and_takes_errors_against_the_reference(
    bench, tmp_path, monkeypatch, capsys
):
    """Runs are made up: those that are not exact are off by half a degree and half as long."""
    asked = []

    def run(command, **_):
        case, _, changes, number = json.loads(command[-1])
        asked.append((case, number))
        exact = changes == bench.ways.reference_of(case)
        found = made_up(40.0, seconds=4.0) if exact else made_up(40.5, seconds=2.0)
        return SimpleNamespace(returncode=0, stdout=f"noise\n{json.dumps(found)}\n", stderr="")

    monkeypatch.setattr(bench.one_run.subprocess, "run", run)
    main, out = bench.table.main, tmp_path / "rows.json"
    ask = ["--cases", "hemisphere_0", "circular_table", "--ways", "standard", "draft"]
    ask += ["--runs", str(tmp_path / "runs"), "--out", str(out), "--references", "1"]
    assert main([*ask, "--plot", str(tmp_path / "errors.png")]) == 0
    assert (tmp_path / "errors.png").read_bytes().startswith(b"\x89PNG")
    rows = json.loads(out.read_text("utf-8"))
    # A drape has no accuracy: its second way would be the first again.
    assert [(row["case"], row["way"], row["runs"]) for row in rows] == [
        ("hemisphere_0", "standard", 2),
        ("hemisphere_0", "draft", 2),
        ("circular_table", "as it is", 2),
    ]
    assert [row["ratio"] for row in rows] == [0.5] * 3
    assert [row["p95_deg"] for row in rows] == pytest.approx([0.5] * 3)
    assert sorted(asked) == sorted(
        [("hemisphere_0", n) for n in (0, 0, 1, 0, 1)] + [("circular_table", n) for n in (0, 0, 1)]
    )
    table = capsys.readouterr().out
    assert table.count("| hemisphere_0 | draft |") == 2  # as it is known, and in the table
    assert main(ask) == 0 and len(asked) == 8
    # More runs of more ways, but none that is not kept: the same rows.
    cases = ["--cases", "hemisphere_0", "circular_table", "double_dome", "--noise", "5", "--kept"]
    assert main([*cases, *ask[ask.index("--runs") :]]) == 0 and len(asked) == 8
    kept = {(row["case"], row["way"]): row for row in json.loads(out.read_text("utf-8"))}
    assert all(kept[row["case"], row["way"]] == row for row in rows)
    assert kept["hemisphere_0", "reference"]["p95_deg"] == 0.0
    assert {case for case, _ in kept} == {"hemisphere_0", "circular_table"}
    # Nothing presses a drape: a way that differs by its stroke is the same, and comes once.
    ways = ["--ways", "softening 64", "softening 64, 40 ms"]
    assert main(["--cases", "circular_table", *ways, *ask[ask.index("--runs") :]]) == 0
    assert [row["way"] for row in json.loads(out.read_text("utf-8"))] == ["softening 64"]


def test_a_way_that_fails_is_told(bench, tmp_path, monkeypatch):
    failed = SimpleNamespace(returncode=1, stdout="", stderr="Traceback\nhemisphere_0: blew up\n")
    monkeypatch.setattr(bench.one_run.subprocess, "run", lambda *_, **__: failed)
    with pytest.raises(SystemExit, match="hemisphere_0: blew up"):
        bench.one_run.done("hemisphere_0", {}, 0, tmp_path)
    assert not list(tmp_path.iterdir())
