"""What the tests of studies share: a study of tiny runs, made-up tables, a quick cluster."""

import signal
from pathlib import Path

from warpdrape.studies.one_run import COMPLETED
from warpdrape.studies.table import Table

TINY = """
scene = "hemisphere"
[set]
cells = 4
facet = "10mm"
accuracy = "reference"
[run]
frames = 3
[design]
kind = "list"
rows = [
  { duration = "2ms", holder_force = "50 N", travel = "20mm" },
  { duration = "2ms", holder_force = "0.2 kN", travel = "20mm" },
  { duration = "0.01ms", holder_force = 100, travel = "20mm" },
  { duration = "2ms", holder_force = 100, travel = 10 },
  { duration = "2ms", holder_force = 100, travel = "30mm" },
]
"""
"""Two runs, one that fails, one that its scene refuses, and one more."""
SETTINGS = (
    "cells=4",
    "facet=10mm",
    "accuracy=reference",
    "duration=0.002",
    "holder_force=200.0",
    "travel=0.02",
)
"""Of its second run."""


def hears_ctrl_c() -> None:
    """For ``preexec_fn``: a process that is begun by one in the background hears none by itself."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def write_study(folder: Path, text: str = TINY, name: str = "tiny") -> Path:
    """A study file; its path."""
    path = folder / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    return path


def made_up(parameters: dict, measures: dict, status=None) -> Table:
    """A table of runs that nobody ran."""
    count = len(next(iter(parameters.values())))
    columns = {"run": list(range(count)), **parameters, **measures}
    columns["status"] = status or [COMPLETED] * count
    columns["message"] = [""] * count
    return Table(columns, list(parameters), list(measures))
