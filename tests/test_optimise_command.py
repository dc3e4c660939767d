"""The command ``warpdrape optimise`` on runs of a tiny press: what it prints, and going on."""

import json
import subprocess
import sys
import time

import pytest

from warpdrape.cli import main

TINY = """
scene = "hemisphere"
[set]
cells = 4
facet = "10mm"
duration = "2ms"
travel = "20mm"
[run]
frames = 3
[parameters.holder_force]
log_range = ["20 N", "2 kN"]
[parameters.friction]
range = [0.1, 0.3]
[measures]
force = "history.punch_force_n.max"
[optimise]
minimise = "force"
quasi_static = false
runs = 4
batch = 3
repeats = [{ cells = 5 }]
finalists = 1
"""


def test_command_from_start_to_end(tmp_path, capsys):
    path = tmp_path / "tiny.toml"
    path.write_text(TINY, encoding="utf-8")
    out = str(tmp_path / "o")
    command = ["optimise", str(path), "--out", out, "--workers", "1"]
    assert main([*command, "--plan"]) == 0
    plan = capsys.readouterr().out
    assert "least force of hemisphere" in plan and "20 to 2000 N by its logarithm" in plan
    assert "start: holder_force 100 N, friction 0.2" in plan and not (tmp_path / "o").exists()
    assert main(command) == 0
    shown = capsys.readouterr()
    assert "10 completed" in shown.out and "best settings, run" in shown.out
    assert "4 of 4 runs; best" in shown.err
    for name in ("report.html", "table.csv", "answer.json", "convergence.png", "field.png"):
        assert (tmp_path / "o" / name).is_file()
    data = json.loads((tmp_path / "o" / "answer.json").read_text("utf-8"))
    best = data["search"][0]
    run = json.loads(
        (tmp_path / "o" / "runs" / f"{best['run']:05d}" / "run.json").read_text("utf-8")
    )
    assert run["parameters"]["holder_force"] == best["settings"]["holder_force"]
    again = json.loads((tmp_path / "o" / "runs" / "00007" / "run.json").read_text("utf-8"))
    assert again["parameters"]["cells"] == 5  # a repeat of the start
    assert main([*command, "--quiet"]) == 0  # nothing is left to be done
    assert main([*command, "--seed", "2"]) == 2
    assert "another [optimise]" in capsys.readouterr().err
    assert main(["study", str(path)]) == 2
    assert "run it with warpdrape optimise" in capsys.readouterr().err


def test_command_refuses_what_makes_no_sense(tmp_path, capsys):
    path = tmp_path / "tiny.toml"
    path.write_text(TINY, encoding="utf-8")
    for options, words in (
        (["--workers", "0"], "--workers 0 must be 1 or more"),
        (["--seed", "x"], "--seed x must be a whole number"),
        (["--workers", "1", "--scheduler", "tcp://a:1"], "not both"),
    ):
        assert main(["optimise", str(path), *options]) == 2
        assert words in capsys.readouterr().err
    path.write_text(TINY.partition("[optimise]")[0], encoding="utf-8")
    assert main(["optimise", str(path)]) == 2
    assert "no [optimise]: say what is to be best" in capsys.readouterr().err


def test_what_a_method_needs_is_said(tmp_path, monkeypatch, capsys):

    path = tmp_path / "tiny.toml"
    path.write_text(TINY + 'method = "tpe"\n', encoding="utf-8")
    monkeypatch.setitem(sys.modules, "optuna", None)
    assert main(["optimise", str(path), "--out", str(tmp_path / "o")]) == 2
    assert "pip install 'warpdrape[optimise]'" in capsys.readouterr().err


@pytest.mark.slow
def test_an_optimisation_that_is_killed_goes_on(tmp_path):
    path = tmp_path / "tiny.toml"
    path.write_text(TINY, encoding="utf-8")
    command = ["optimise", str(path), "--workers", "1", "--quiet"]
    argv = [sys.executable, "-m", "warpdrape", *command, "--out", str(tmp_path / "cut")]
    process = subprocess.Popen(argv, cwd=tmp_path, stderr=subprocess.DEVNULL)
    outcomes = tmp_path / "cut" / "outcomes"
    until = time.monotonic() + 300.0
    while len(list(outcomes.glob("*.json"))) < 3 and time.monotonic() < until:
        time.sleep(0.02)
    process.kill()
    process.wait()
    assert 3 <= len(list(outcomes.glob("*.json"))) < 10
    for name in ("cut", "whole"):
        assert main([*command, "--out", str(tmp_path / name)]) == 0
    plans = [json.loads((tmp_path / n / "plan.json").read_text("utf-8")) for n in ("cut", "whole")]
    assert plans[0]["trials"] == plans[1]["trials"]
    answers = [(tmp_path / n / "answer.json").read_text("utf-8") for n in ("cut", "whole")]
    assert answers[0] == answers[1]
