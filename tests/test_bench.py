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


def test_the_start_is_timed_to_the_first_block(tmp_path):
    spec = importlib.util.spec_from_file_location("startup", BENCH / "startup.py")
    startup = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(startup)
    folder = tmp_path / "run"
    subprocess.run([sys.executable, "-c", startup.FIRST_STEP, str(folder)], check=True)
    assert (folder / "run.json").exists() and not (folder / "summary.json").exists()
