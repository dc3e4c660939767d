"""What the tests of optimisations share: runs whose results are formulas, done in no time."""

import csv
import json
from collections.abc import Callable
from pathlib import Path

from warpdrape.optimisation.book import Book
from warpdrape.optimisation.optimise_file import read_optimisation
from warpdrape.optimisation.runner import Runner
from warpdrape.optimisation.search import search
from warpdrape.studies.folder import StudyFolder, write_json
from warpdrape.studies.one_run import COMPLETED, FAILED, ended

SCENE = '''
"""A scene of formulas: nobody builds it."""
from warpdrape import Scene
def build(
    *,
    x: float = 0.9,
    y: float = 0.9,
    z: float = 0.5,
    w: float = 0.5,
    n: int = 3,
    kind: str = "a",
    cells: int = 20,
) -> Scene:
    """Build nothing.

    Args:
        x: one [m].
        y: other [m].
        z: third [-].
        w: fourth [-].
        n: number [-].
        kind: a word.
        cells: of the mesh.
    """
    raise AssertionError
'''
STUDY = """
scene = "formulas.py"
[parameters.x]
range = [0, 1]
[parameters.y]
range = [0, 1]
[measures]
f = "f"
g = "g"
[optimise]
minimise = "f"
runs = 24
"""


def write_formulas(folder: Path, text: str = STUDY, name: str = "made_up") -> Path:
    """A study file of a scene of formulas; its path."""
    (folder / "formulas.py").write_text(SCENE, encoding="utf-8")
    path = folder / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    return path


def bowl(values: dict) -> dict:
    """Measures with their least f at x = 0.3, y = 0.6."""
    x, y = float(values["x"]), float(values["y"])
    return {"f": 1.0 + (x - 0.3) ** 2 + (y - 0.6) ** 2, "g": x}


def made_up_summary(cells: int) -> dict:
    """Of a run that nobody ran: all that a summary has to have."""
    zero = ("energy_error", "kinetic_ratio", "max_penetration_m", "mass_kg", "added_mass_kg")
    zero += ("added_mass_kinetic_ratio", "mass_scaling_order", "softening_strain")
    return {
        **{"status": "completed", "message": "completed", "approach": "semi_discrete"},
        **{key: [] for key in ("warnings", "plies", "tools", "interfaces", "reported")},
        **{"quasi_static": True, "loaded": True, "yarn_softening": 1.0},
        **{"steps": 10, "triangles": 4 * cells**2, "wall_s": 1.0, "simulated_s": 1.0},
        **dict.fromkeys(zero, 0.0),
        "numerical_error": {"not_known": "nobody ran it"},
    }


def made_up_tool(coverage: float) -> dict:
    """The punch of a run that nobody ran, with the share of it that plies cover."""
    none = dict.fromkeys(("force_n", "max_force_n", "max_penetration_m"))
    return {"name": "punch", "displacement_m": 0.0, "coverage": coverage, **none}


class MadeUp:
    """Does runs by a formula from settings to measures; None for a run that fails."""

    def __init__(self, folder: StudyFolder, formula: Callable[[dict], dict | None]) -> None:
        self.folder, self.formula = folder, formula
        self.done: list[int] = []
        self.sizes: list[int] = []
        self.stop_after: int | None = None

    def __call__(self, jobs):
        self.sizes.append(len(jobs))
        for job in jobs:
            if self.stop_after is not None and len(self.done) >= self.stop_after:
                raise KeyboardInterrupt
            self.done.append(job.number)
            values = dict(s.split("=") for s in job.settings)
            found = self.formula(values)
            status = FAILED if found is None else COMPLETED
            if found is not None:
                run = self.folder.run(job.number)
                run.mkdir(parents=True, exist_ok=True)
                summary = made_up_summary(int(values.get("cells", 20))) | found
                (run / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
                with (run / "history.csv").open("w", newline="") as file:
                    csv.writer(file).writerows([["time_s"], [0.0]])
            outcome = ended(job, status, "as told" if found is None else "completed", cpu_s=1.0)
            outcome |= {"worker_cpu_s": 1.0, "wall_s": 1.0}
            write_json(self.folder.outcome(job.number), outcome)
            yield outcome


def optimised(path: Path, out: Path, formula, *, seed=None, stop_after=None):
    """Do an optimisation of formulas; the runner, and who did the runs."""
    folder = StudyFolder(out)
    folder.take()
    try:
        book = Book(read_optimisation(path, seed), folder)
        hands = MadeUp(folder, formula)
        hands.stop_after = stop_after
        runner = Runner(book, hands)
        try:
            search(runner, lambda _: None)
        except KeyboardInterrupt:
            if stop_after is None:
                raise
        return runner, hands
    finally:
        folder.release()
