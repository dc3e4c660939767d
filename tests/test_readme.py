"""The README's example runs, and prints what the README says."""

import re
import shlex
from pathlib import Path

import pytest

from warpdrape.verification.sphere_net import WORST

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
(EXAMPLE,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
SMALLER = {
    '"cells": 12': '"cells": 6',
    "-60 * mm": "-20 * mm",
    "=40 * ms": "=10 * ms",
    "=44 * ms": "=11 * ms",
}


def printed_angle(code: str, capsys) -> tuple[float, dict]:
    names = {}
    exec(compile(code, "README.md", "exec"), names)
    (angle,) = re.findall(r"largest shear angle: (\d+\.\d)°\n", capsys.readouterr().out)
    return float(angle), names


def test_example_runs(capsys):
    code = EXAMPLE
    for written, smaller in SMALLER.items():
        assert code.count(written) == 1
        code = code.replace(written, smaller)
    angle, names = printed_angle(code, capsys)
    result = names["result"]
    assert result.completed
    assert [ply.name for ply in result.plies] == ["lower", "upper"]
    assert 0.5 < angle < 20.0  # the tools have moved by a quarter of the way


def test_example_is_short():
    statements = [line for line in EXAMPLE.splitlines() if line and "import" not in line]
    assert len(statements) <= 11


def test_files_that_commands_read_are_in_a_fresh_clone():
    """What they read that no command before them has made."""
    made, read = set(), []
    for line in "".join(re.findall(r"```sh\n(.*?)```", README, re.DOTALL)).splitlines():
        program, *words = shlex.split(line, comments=True) or ["nothing"]
        if program != "warpdrape":
            continue
        if "--out" in words:
            made.add(words[words.index("--out") + 1])
        if words[0] in ("new", "run"):
            made.add(f"{words[1]}.py" if words[0] == "new" else f"runs/{words[1]}")
        paths = [word for word in words if "/" in word or word.endswith((".toml", ".py"))]
        read += [path for path in paths if path not in made]
    assert len(read) >= 5
    assert [path for path in read if not (ROOT / path).is_file()] == []


def test_the_limit_of_the_net_on_a_sphere_is_that_of_its_case():
    (row,) = re.findall(r"^\| inextensible net on a sphere.*\|$", README, re.MULTILINE)
    assert row.endswith(f"| {WORST:g}° |")


@pytest.mark.slow
def test_example_prints_what_the_readme_says(capsys):
    (stated,) = re.findall(r"It prints (\d+\.\d)°", README)
    angle, names = printed_angle(EXAMPLE, capsys)
    assert angle == pytest.approx(float(stated), abs=0.5)  # rounding differs between machines
    assert names["result"].summary["warnings"] == []
