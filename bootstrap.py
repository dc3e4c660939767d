"""Set up and run, or set up and test: one command on a fresh machine.

    python bootstrap.py run three_ply_hemisphere     installs into .venv and runs a scene
    python bootstrap.py test                         installs into .venv and runs the tests

Standard library only, and plain enough for an old Python to read and say what it lacks.
"""

import argparse
import hashlib
import os
import subprocess
import sys
from pathlib import Path

NEEDED = (3, 11)
ROOT = Path(__file__).resolve().parent
EXTRAS = {"run": "", "test": "[dev]"}
"""What each command installs beside the package itself."""
SEVERAL = ["-n", "logical", "--maxprocesses", "4", "--dist", "loadfile"]
"""Tests run in a process a core, up to four; `-n 0` after the command takes that back."""
STAMP = "warpdrape-installed.txt"
"""File in the environment that says what was installed, so that a second start is quick."""


class Unusable(Exception):
    """Something about this machine has to change first."""


def main(argv=None):
    """Do what the command line says and return the exit status: that of the run or the tests."""
    arguments = parse(argv)
    try:
        check_python()
        python = make_environment(arguments.venv)
        status = install(python, arguments.venv, EXTRAS[arguments.command])
    except Unusable as reason:
        print(f"bootstrap: error: {reason}", file=sys.stderr)
        return 2
    if status != 0:
        print(
            "bootstrap: error: installing failed, for the reason above; a first start needs a "
            "network connection to the Python package index",
            file=sys.stderr,
        )
        return status
    if arguments.command == "run":
        return call([python, "-m", "warpdrape", "run", *arguments.rest])
    return call([python, "-m", "pytest", *SEVERAL, *arguments.rest], cwd=ROOT)


def parse(argv=None):
    """Read the command line."""
    parser = argparse.ArgumentParser(
        prog="bootstrap.py",
        description="Install warpdrape into a virtual environment, then run a scene or the tests.",
        epilog="Example: python bootstrap.py run three_ply_hemisphere --out runs/first",
    )
    parser.add_argument(
        "--venv",
        metavar="DIR",
        type=Path,
        default=ROOT / ".venv",
        help="the virtual environment; .venv beside this file if not given",
    )
    parser.add_argument("command", choices=sorted(EXTRAS), help="what to do")
    parser.add_argument(
        "rest",
        metavar="...",
        nargs=argparse.REMAINDER,
        help="passed on to warpdrape run, or to pytest",
    )
    arguments = parser.parse_args(argv)
    arguments.venv = arguments.venv.absolute()
    return arguments


def check_python(version=sys.version_info):
    """Raise `Unusable` where this Python is too old, or cannot make environments."""
    if tuple(version[:2]) < NEEDED:
        raise Unusable(
            "warpdrape needs Python {}.{} or newer, and this is {}.{}: install one and start this "
            "file with it, as in python{}.{} bootstrap.py".format(*NEEDED, *version[:2], *NEEDED)
        )
    try:
        import ensurepip  # noqa: F401
        import venv  # noqa: F401
    except ImportError:
        raise Unusable(
            "this Python lacks the modules venv and ensurepip: on Debian or Ubuntu, "
            "sudo apt install python3-venv"
        ) from None


def make_environment(folder):
    """Return the Python of the virtual environment, which is made, or mended, if need be."""
    import venv

    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if not has_pip(python):
        print(f"bootstrap: making {folder}", flush=True)
        try:
            venv.create(folder, with_pip=True)
        except (OSError, subprocess.CalledProcessError) as error:
            raise Unusable(
                f"cannot make the virtual environment {folder} ({error}): remove that folder, or "
                "give another with --venv DIR"
            ) from error
    return str(python)


def has_pip(python):
    """Whether an environment's Python starts and has pip; an interrupted one has not."""
    try:
        return (
            subprocess.run(
                [str(python), "-c", "import pip"], stderr=subprocess.DEVNULL, check=False
            ).returncode
            == 0
        )
    except OSError:
        return False


def install(python, folder, extras):
    """Install the project, in place, unless that has been done; return pip's exit status."""
    project = hashlib.sha256((ROOT / "pyproject.toml").read_bytes()).hexdigest()
    stamp = folder / STAMP
    enough = {f"{ROOT} {project} {have}".strip() for have in (extras, "[dev]")}
    if stamp.is_file() and stamp.read_text(encoding="utf-8") in enough:
        return 0
    print("bootstrap: installing warpdrape and what it needs (once; 1 GB on disk)", flush=True)
    pip = [python, "-m", "pip", "install", "--disable-pip-version-check", "--quiet"]
    status = call([*pip, "--editable", f"{ROOT}{extras}"])
    if status == 0:
        stamp.write_text(f"{ROOT} {project} {extras}".strip(), encoding="utf-8")
    return status


def call(command, cwd=None):
    """Run a command to its end and return its exit status; Ctrl-C is the command's to handle."""
    process = subprocess.Popen(command, cwd=cwd)
    while True:
        try:
            status = process.wait()
        except KeyboardInterrupt:
            continue  # it went to the command too, which closes its files and ends
        return status if status >= 0 else 128 - status


if __name__ == "__main__":
    sys.exit(main())
