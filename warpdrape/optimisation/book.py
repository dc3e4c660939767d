"""The book of an optimisation: every run that was asked for, written down before it begins."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from warpdrape.errors import InputError
from warpdrape.optimisation.optimise_file import Task
from warpdrape.optimisation.space import Place
from warpdrape.results.run_folder import as_json
from warpdrape.results.run_record import versions
from warpdrape.results.run_tables import load_json
from warpdrape.studies.design import Row
from warpdrape.studies.folder import PLAN, StudyFolder, declared_of, refuse_others, write_json

START, COARSE_START, COARSE = "start", "coarse start", "coarse"
SEARCH, BASELINE, REPEAT = "search", "random", "repeat"
"""Kinds of runs: the settings to compare with, likewise coarse; coarse ones of the search; the
search's at full fineness; random ones of equal cost; repeats of the best."""

MAY_CHANGE = ("runs", "finalists")
"""Of an optimisation that goes on: it may have a larger budget."""


@dataclass(frozen=True)
class Trial:
    """A run of an optimisation.

    Attributes:
        number: of the run.
        kind: as above.
        batch: in which it was asked for.
        row: values of the parameters.
        place: their coordinates; None outside the space, where the start may lie.
        of: number of the run whose settings it has; None where they are its own.
        settings: of a coarse run or a repeat, in place of the study's.
    """

    number: int
    kind: str
    batch: int
    row: Row
    place: Place | None
    of: int | None = None
    settings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Asked:
    """What is asked of a run: see `Trial`."""

    row: Row
    place: Place | None
    of: int | None = None
    settings: tuple[str, ...] = ()


class Book:
    """Runs that were asked for, and where their results are.

    Args:
        task: the optimisation.
        folder: of its study, which is taken.

    Raises:
        InputError: if the folder is of something else.
    """

    def __init__(self, task: Task, folder: StudyFolder) -> None:
        self.task, self.folder = task, folder
        self.trials: list[Trial] = []
        self._declared = as_json(_declared(task), PLAN)
        self._versions = versions()
        path = folder.path / PLAN
        if path.exists():
            self._read(load_json(path))
        else:
            refuse_others(folder.path)
        self._write()

    def asked(self, kind: str, batch: int, make: Callable[[], Sequence[Asked]]) -> list[Trial]:
        """Runs of a kind and batch: those that are written down, or else new ones.

        Args:
            kind: of the runs.
            batch: of them.
            make: says what is asked of each.
        """
        found = [t for t in self.trials if t.kind == kind and t.batch == batch]
        if found:
            return found
        first = len(self.trials)
        found = [
            Trial(first + k, kind, batch, a.row, a.place, a.of, a.settings)
            for k, a in enumerate(make())
        ]
        self.trials += found
        if found:
            self._write()
        return found

    def of_kind(self, *kinds: str) -> list[Trial]:
        """Runs of some kinds, in their order."""
        return [trial for trial in self.trials if trial.kind in kinds]

    def settings(self, trial: Trial) -> list[str]:
        """Settings of a run; where one is given twice the last counts."""
        study = self.task.study
        return [*study.fixed, *trial.settings, *study.settings(trial.row)[len(study.fixed) :]]

    def _read(self, before: Any) -> None:
        try:
            was, trials = before["declared"], before["trials"]
            self.trials = [_trial(number, entry) for number, entry in enumerate(trials)]
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(
                f"out = {self.folder.path} holds a study that is no optimisation, or is damaged: "
                "give another folder"
            ) from error
        changed = [key for key, value in self._declared.items() if was.get(key) != value]
        if changed:
            words = ", ".join(f"[{key}]" if key != "digest" else "scene script" for key in changed)
            raise InputError(
                f"out = {self.folder.path} holds an optimisation with another {words}: give "
                "another folder, or what it had"
            )

    def _write(self) -> None:
        trials = [{k: v for k, v in asdict(t).items() if k != "number"} for t in self.trials]
        data = {
            "study": self.task.study.name,
            "declared": self._declared,
            "trials": trials,
            "versions": self._versions,
        }
        write_json(self.folder.path / PLAN, data)


def _trial(number: int, entry: Mapping[str, Any]) -> Trial:
    row = {name: tuple(v) if isinstance(v, list) else v for name, v in entry["row"].items()}
    place = None if entry["place"] is None else tuple(map(float, entry["place"]))
    settings = tuple(entry["settings"])
    return Trial(number, entry["kind"], entry["batch"], row, place, entry["of"], settings)


def _declared(task: Task) -> dict[str, Any]:
    """All that runs, and where the search looks next, depend on."""
    study = task.study
    return {
        **declared_of(study),
        "measures": {measure.name: measure.path for measure in study.measures},
        "limits": None if study.limits is None else asdict(study.limits),
        "optimise": {k: v for k, v in task.given.items() if k not in MAY_CHANGE},
    }
