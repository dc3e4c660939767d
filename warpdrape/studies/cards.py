"""Fabric cards of a study's runs: that of the scene's fabric, with values of each run's own."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from warpdrape.errors import InputError, nearest
from warpdrape.materials.card_text import card_text
from warpdrape.materials.fabric_library import fabric_names, load_fabric
from warpdrape.materials.fabric_units import si_zero
from warpdrape.results.run_folder import write_whole


@dataclass(frozen=True)
class Card:
    """A fabric's card as its file has it.

    Attributes:
        named: name or file, as the study gives it.
        tables: all that it holds.
    """

    named: str
    tables: Mapping[str, Any]

    @property
    def keys(self) -> list[str]:
        """Dotted keys of all its values."""
        return sorted(_keys(self.tables, ""))

    def table(self, key: str) -> Mapping[str, Any]:
        """Value, unit and source of a dotted key; raise `InputError` if it has none such."""
        if key not in self.keys:
            raise InputError(f"card {self.named} has no value {key!r}{nearest(key, self.keys)}")
        return _inner(self.tables, key)

    def check(self, key: str, *, relative: bool) -> str:
        """The unit of a value; raise `InputError` where it cannot vary as asked."""
        table = self.table(key)
        if isinstance(table["value"], list) and not relative:
            raise InputError(
                f"{key} of card {self.named} is a list of {len(table['value'])} values: say "
                "relative = true, for one factor of all of them"
            )
        if relative and si_zero("temperature", str(table["unit"])):
            raise InputError(
                f"{key} of card {self.named} is in {table['unit']}, of which a factor means "
                "nothing: say how it varies as a range or normal of degrees, without relative"
            )
        return str(table["unit"])

    def with_values(self, values: Sequence[tuple[str, float, bool]], study: str) -> dict[str, Any]:
        """All of a card with values changed.

        Args:
            values: dotted key, number, and whether it is a factor of what is there.
            study: name of the study, for the source.
        """
        tables = copy.deepcopy(dict(self.tables))
        for key, number, relative in values:
            table = _inner(tables, key)
            before = table["value"]
            table["value"] = _times(before, number) if relative else number
            change = f"{number!r} times the card's" if relative else f"in place of {before!r}"
            table["source"] = f"study {study}: {change}; {table.get('source', '')}"
            table["status"] = "assumed"
        return tables


def read_card(name_or_path: str) -> Card:
    """Read a bundled fabric's card or a file; raise `InputError` where `load_fabric` does."""
    load_fabric(name_or_path)
    if name_or_path in fabric_names():
        text = (resources.files("warpdrape.fabrics") / f"{name_or_path}.toml").read_text("utf-8")
    else:
        text = Path(name_or_path).read_text(encoding="utf-8-sig")
    return Card(name_or_path, tomllib.loads(text))


def write_card(path: Path, tables: Mapping[str, Any]) -> None:
    """Write a card's file in one move."""
    text = card_text(tables)
    write_whole(path, lambda p: p.write_text(text, encoding="utf-8", newline="\n"))


def _keys(tables: Mapping[str, Any], at: str) -> list[str]:
    found = []
    for key, value in tables.items():
        if isinstance(value, Mapping):
            dotted = f"{at}.{key}".lstrip(".")
            found += [dotted] if "value" in value else _keys(value, dotted)
    return found


def _inner(tables: Mapping[str, Any], key: str) -> Any:
    for part in key.split("."):
        tables = tables[part]
    return tables


def _times(value: Any, factor: float) -> Any:
    if isinstance(value, list):
        return [_times(each, factor) for each in value]
    return value * factor
