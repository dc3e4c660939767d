"""Contact's stiffness alone, at one step: what a press's result owes to it."""

import importlib.util
import sys
from pathlib import Path

import pytest

from warpdrape.dynamics.model import build_model
from warpdrape.scenes import double_dome, hemisphere

BENCH = Path(__file__).parents[1] / "bench" / "contact_stiffness.py"


@pytest.fixture(scope="module")
def bench():
    spec = importlib.util.spec_from_file_location("contact_stiffness", BENCH)
    module = importlib.util.module_from_spec(spec)
    sys.modules["contact_stiffness"] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("scene", "given"),
    [
        (hemisphere, {"cells": 16, "duration": 0.04}),
        pytest.param(double_dome, {"cells": 20}, marks=pytest.mark.slow),
    ],
)
def test_contacts_four_times_as_soft_move_a_press_by_less_than_is_asked(bench, scene, given):
    """The aim between fast runs and small steps: 0.2° and 0.3 mm, on squares of the die's edge."""
    scenes = bench.of_one_step(scene.build(**given), (0.2, 0.05))
    models = {share: build_model(each, "cpu", 1) for share, each in scenes.items()}
    assert len({model.timing.time_step for model in models.values()}) == 1
    stiffness = {
        share: next(c.law.stiffness for c in model.contacts if c.name == "tool contact")
        for share, model in models.items()
    }
    assert stiffness[0.2] == pytest.approx(4.0 * stiffness[0.05])
    rows = {
        share: bench.figures(each.run(threads=1, frames=6).summary)
        for share, each in scenes.items()
    }
    assert rows[0.05]["depth"] > 1.5 * rows[0.2]["depth"]  # they are softer
    shear, drawn = bench.moved(rows, 0.05)
    assert 0.0 < shear < 0.2 and drawn < 0.3


def test_the_table_says_by_how_much_rows_lie_off_the_stiffest(bench, capsys):
    command = ["--cells", "6", "--duration", "0.002", "--shares", "0.1", "0.05"]
    assert bench.main(command) == 0
    said = capsys.readouterr().out.splitlines()
    assert [row.split(" | ")[0] for row in said[2:4]] == ["| 0.1", "| 0.05"]
    rows = {
        share: {"p95": p95, "draw_in": drawn}
        for share, p95, drawn in ((0.2, 40.0, 30.0), (0.1, 39.9, 30.2), (0.05, 40.5, 29.9))
    }
    assert bench.moved(rows, 0.1) == pytest.approx((0.1, 0.2))
    assert bench.moved(rows, 0.05) == pytest.approx((0.5, 0.2))
