"""The study folder: its plan, a folder for each run, and beside them how each one ended.

plan.json            what is run: every run's settings
runs/00007/          a run folder like any other
outcomes/00007.json  how the run ended, once it has
fields/00007.npz     what maps need of it
cards/00007.toml     its fabric, where values of that vary
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from warpdrape.errors import InputError
from warpdrape.results.folder_lock import FolderLock
from warpdrape.results.run_folder import as_json, write_whole
from warpdrape.results.run_record import versions
from warpdrape.results.run_tables import load_json
from warpdrape.studies.design import Row
from warpdrape.studies.study import Study

PLAN = "plan.json"
DIGITS = 5
"""Of the number of a run in names of files, at least."""


def write_json(path: Path, data: Mapping[str, Any]) -> None:
    """Write a JSON file in one move.

    Raises:
        RunFailed: when the disk refuses.
    """
    text = json.dumps(as_json(data, path.name), indent=1, ensure_ascii=False) + "\n"
    write_whole(path, lambda p: p.write_text(text, encoding="utf-8", newline="\n"))


class StudyFolder:
    """Where a study's files are.

    Args:
        path: the folder.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self._lock = FolderLock(self.path)

    def run(self, number: int) -> Path:
        """Folder of a run."""
        return self.path / "runs" / _name(number)

    def outcome(self, number: int) -> Path:
        """File that says how a run ended."""
        return self.path / "outcomes" / f"{_name(number)}.json"

    def fields(self, number: int) -> Path:
        """File with what maps need of a run."""
        return self.path / "fields" / f"{_name(number)}.npz"

    def card(self, number: int) -> Path:
        """File of a run's own fabric."""
        return self.path / "cards" / f"{_name(number)}.toml"

    def take(self) -> None:
        """Make the folder and keep other studies out, until `release`.

        Raises:
            InputError: when one runs there now, or nothing can be written.
        """
        try:
            for part in ("runs", "outcomes", "fields", "cards"):
                (self.path / part).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"out = {self.path} cannot be made ({error.strerror}): give a folder in which you "
                "may write"
            ) from error
        try:
            self._lock.take()
        except InputError as error:
            raise InputError(str(error).replace("another run", "another study")) from error

    def release(self) -> None:
        """Let other studies in."""
        self._lock.release()

    def plan(self, study: Study) -> list[Row]:
        """Return the runs of a study, and write down what is run.

        A folder that holds runs of the study already keeps them; a design may have grown, its first
        runs the same.

        Raises:
            InputError: if the folder is of another study.
        """
        declared = declared_of(study)
        path = self.path / PLAN
        before = load_json(path) if path.exists() else None
        if before is None:
            refuse_others(self.path)
            rows = study.rows()
        else:
            rows = self._rows_again(study, declared, before)
        data = {"study": study.name, "declared": declared, "rows": rows, "versions": versions()}
        data = as_json(data, PLAN)
        if data != before:
            write_json(path, data)
        return rows

    def _rows_again(self, study: Study, declared: Any, before: Any) -> list[Row]:
        try:
            was, old = before["declared"], before["rows"]
            parameters, design = was["parameters"], was["design"]
        except (KeyError, TypeError) as error:
            raise InputError(f"{self.path / PLAN} is damaged: give another folder") from error
        same = as_json(declared, PLAN)
        for key in ("scene", "digest", "fixed", "options", "card"):
            if was.get(key) != same[key]:
                raise InputError(
                    f"out = {self.path} holds runs of this study with another {_WORDS[key]}: give "
                    "another folder, or what it had"
                )
        if parameters == same["parameters"] and design == same["design"]:
            return [{p.name: _back(p, row[p.name]) for p in study.parameters} for row in old]
        rows = study.rows()
        if as_json(rows, PLAN)[: len(old)] != old:
            raise InputError(
                f"out = {self.path} holds runs with other parameters or another design: give "
                "another folder; a list or Sobol sequence may grow, its first rows the same"
            )
        return rows

    def ended(self, numbers: Iterable[int]) -> dict[int, dict[str, Any]]:
        """How runs ended, of those that have."""
        found = {}
        for number in numbers:
            path = self.outcome(number)
            if path.exists():
                found[number] = load_json(path)
        return found


def refuse_others(path: Path) -> None:
    """Raise `InputError` for a folder that holds other files than those of a study to be."""
    own = (".lock", "runs", "outcomes", "fields", "cards")
    if path.is_dir() and any(name not in own for name in os.listdir(path)):
        raise InputError(f"out = {path} holds other files and no study: give another folder")


_WORDS = {
    "scene": "scene",
    "digest": "text of the scene's script",
    "fixed": "[set]",
    "options": "[run]",
    "card": "fabric",
}


def declared_of(study: Study) -> dict[str, Any]:
    """All of a study that its runs depend on."""
    script = study.script
    return {
        "scene": script.name if script.bundled else os.fspath(script.path.resolve()),
        "digest": script.digest,
        "fixed": list(study.fixed),
        "options": asdict(study.options),
        "card": dict(study.card.tables) if study.card else None,
        "parameters": [
            {
                "name": p.name,
                "key": p.key,
                "relative": p.relative,
                "spread": asdict(p.spread) if p.spread else None,
            }
            for p in study.parameters
        ],
        "design": asdict(study.design),
    }


def _back(parameter: Any, value: Any) -> Any:
    """A value as JSON has it; lists are tuples again."""
    return tuple(value) if isinstance(value, list) else value


def _name(number: int) -> str:
    return f"{number:0{DIGITS}d}"
