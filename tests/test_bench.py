"""The benchmarks run: a case against the C loop, and the start-up."""

import importlib.util
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

BENCH = Path(__file__).parents[1] / "bench"


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler for the yardstick")
def test_a_case_gives_a_ratio_and_shares(tmp_path):
    out = tmp_path / "bench.json"
    command = [sys.executable, str(BENCH), "hemisphere_1600", "--repeat", "1", "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    (row,) = json.loads(out.read_text(encoding="utf-8"))["rows"]
    assert row["triangles"] == 1600 and "hemisphere_1600" in done.stdout
    assert 0.01 < row["ratio"] < 10.0 and row["peak_mb"] > 10.0
    assert {"membrane", "tool contact", "integration"} <= set(row["phases"])
    assert 0.0 < row["output"] < 1.0


def loaded(name):
    """A module of the benchmark."""
    spec = importlib.util.spec_from_file_location(name, BENCH / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # for its dataclasses
    spec.loader.exec_module(module)
    return module


def test_the_start_is_timed_to_the_first_block(tmp_path):
    startup = loaded("startup")
    folder = tmp_path / "run"
    subprocess.run([sys.executable, "-c", startup.FIRST_STEP, str(folder)], check=True)
    assert (folder / "run.json").exists() and not (folder / "summary.json").exists()


def test_shares_that_do_not_scale_follow_from_the_times():
    """Work of 1.04 of which 0.02 is one part's, cut 10 % unevenly, and 0.03 of waiting."""
    scaling = loaded("scaling")
    together = (1.04 - 0.02) / 2 * 1.1 + 0.02 + 0.03
    times = [(2.0, 2.08, 2.0 * together)] * 3 + [(9.0, 1.0, 50.0)]  # one block that was disturbed
    shares = scaling.shares_of(times, 0.04, triangles=100, threads=2, uneven=0.1)
    assert shares.doubled == pytest.approx(0.04) and shares.alone == pytest.approx(0.02)
    assert shares.waiting == pytest.approx(0.03) and shares.time == pytest.approx(together)
    assert shares.serial == pytest.approx(2.0 * together - 1.0)  # f + (1 - f)/2 is the time
    assert shares.faster(2) == pytest.approx(1.0 / together)
    ideal = scaling.shares_of([(1.0, 1.0, 0.25)], 0.0, triangles=100, threads=4, uneven=0.0)
    assert ideal.serial == pytest.approx(0.0) and ideal.faster(16) == pytest.approx(16.0)
    assert ideal.waiting == pytest.approx(0.0)


def test_the_shares_of_a_scene_are_measured(capsys):
    assert loaded("scaling").main(["--cells", "6", "--blocks", "2"]) == 0
    head, row = capsys.readouterr().out.splitlines()
    assert "doubled" in head and row.split()[:2] == ["432", "2"]
    assert float(row.split()[2]) > 0.0
