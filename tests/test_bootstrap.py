"""The set-up script: what it understands, what it refuses, what it passes through."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture
def bootstrap():
    spec = importlib.util.spec_from_file_location("bootstrap", ROOT / "bootstrap.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_command_line(bootstrap, tmp_path, capsys):
    given = bootstrap.parse(["run", "hemisphere", "--set", "cells=6", "--quiet"])
    assert (given.command, given.venv) == ("run", ROOT / ".venv")
    assert given.rest == ["hemisphere", "--set", "cells=6", "--quiet"]
    given = bootstrap.parse(["--venv", str(tmp_path), "test", "-m", "slow"])
    assert (given.command, given.venv, given.rest) == ("test", tmp_path, ["-m", "slow"])
    with pytest.raises(SystemExit) as end:
        bootstrap.parse(["rum"])
    assert end.value.code == 2 and "rum" in capsys.readouterr().err


def test_old_python_is_refused_in_words(bootstrap):
    with pytest.raises(bootstrap.Unusable, match=r"needs Python 3\.11 or newer, and this is 3\.9"):
        bootstrap.check_python((3, 9, 18))
    bootstrap.check_python((3, 11, 0))


def test_the_python_that_the_project_names(bootstrap):
    needed = "{}.{}".format(*bootstrap.NEEDED)
    assert f'requires-python = ">={needed}"' in (ROOT / "pyproject.toml").read_text("utf-8")


def test_exit_status_passes_through(bootstrap):
    assert bootstrap.call([sys.executable, "-c", "raise SystemExit(3)"]) == 3


def test_commands_and_their_order(bootstrap, tmp_path, monkeypatch):
    called = []

    def call(command, cwd=None):
        called.append([str(word) for word in command[1:]])
        return 4 if "pip" not in command else 0

    monkeypatch.setattr(bootstrap, "make_environment", lambda folder: "python")
    monkeypatch.setattr(bootstrap, "call", call)
    where = ["--venv", str(tmp_path)]
    assert bootstrap.main([*where, "run", "hemisphere", "--quiet"]) == 4
    assert bootstrap.main([*where, "run", "hemisphere"]) == 4  # does not install again
    assert bootstrap.main([*where, "test"]) == 4  # needs the tools of development
    assert bootstrap.main([*where, "run", "hemisphere"]) == 4  # has all it needs
    short = [" ".join(words[1:2] + words[-1:]).replace(str(ROOT), "ROOT") for words in called]
    assert short == [
        "pip ROOT",
        "warpdrape --quiet",
        "warpdrape hemisphere",
        "pip ROOT[dev]",
        "pytest loadfile",  # on several cores
        "warpdrape hemisphere",
    ]


def test_failing_installation_is_said(bootstrap, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(bootstrap, "make_environment", lambda folder: "python")
    monkeypatch.setattr(bootstrap, "call", lambda command, cwd=None: 1)
    assert bootstrap.main(["--venv", str(tmp_path), "run", "hemisphere"]) == 1
    assert "installing failed" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_environment_is_made_once(bootstrap, tmp_path):
    folder = tmp_path / "a b"  # a space, as in many a user's name
    python = bootstrap.make_environment(folder)
    assert subprocess.run([python, "-c", "import pip"], check=False).returncode == 0
    made = os.stat(python).st_mtime_ns
    assert bootstrap.make_environment(folder) == python
    assert os.stat(python).st_mtime_ns == made


@pytest.mark.skipif(os.name == "nt", reason="Windows checks files out without the bit")
def test_ci_script_starts():
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK)
    assert b"\r" not in script.read_bytes()
    assert script.read_text("utf-8").startswith("#!/usr/bin/env bash\n")
