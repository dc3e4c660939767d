"""Fabric files: TOML tables in which every value has its unit, status and source.

Whatever is wrong with one is an `InputError` that names file, line and key.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from warpdrape.errors import InputError, nearest, one_of
from warpdrape.materials.fabric import STATUSES, Source
from warpdrape.materials.fabric_units import UNITS, si_factor, si_zero

QUANTITY_KEYS = ("value", "unit", "status", "source", "doubt")
MANY = 8
"""Numbers of a list beyond which a card shows its ends only."""
_HEADER = re.compile(r"^\s*\[\s*([^\[\]]+?)\s*\]\s*(#.*)?$")
_KEY = re.compile(r"^\s*([A-Za-z0-9_\-]+(?:\s*\.\s*[A-Za-z0-9_\-]+)*)\s*=")


def key_lines(text: str) -> dict[str, int]:
    """Line number of every dotted key and table header of a TOML text."""
    lines: dict[str, int] = {}
    table = ""
    in_text = False
    for number, line in enumerate(text.splitlines(), start=1):
        quotes = line.count('"""') + line.count("'''")
        if not in_text:
            if header := _HEADER.match(line):
                table = re.sub(r"\s", "", header[1])
                lines.setdefault(table, number)
            elif key := _KEY.match(line):
                name = re.sub(r"\s", "", key[1])
                lines.setdefault(f"{table}.{name}".lstrip("."), number)
        in_text ^= quotes % 2 == 1
    return lines


@dataclass(frozen=True)
class Section:
    """One table of a fabric file, with what is needed to say where it is.

    Attributes:
        file: name of the file, for messages.
        lines: dotted key → line number.
        path: dotted key of this table, "" for the whole file.
        values: the table.
    """

    file: str
    lines: dict[str, int]
    path: str
    values: dict[str, Any]

    def fail(self, key: str, message: str) -> NoReturn:
        """Raise `InputError` naming file, line and key."""
        dotted = f"{self.path}.{key}".strip(".")
        line = next((self.lines[k] for k in _itself_and_parents(dotted) if k in self.lines), 1)
        name = f"key {dotted!r}: " if dotted else ""
        raise InputError(f"{self.file}, line {line}: {name}{message}")

    def check_keys(self, known: tuple[str, ...]) -> None:
        """Refuse keys that are not known, with the nearest one that is."""
        for key in self.values:
            if key not in known:
                self.fail(key, f"unknown{nearest(key, known)}")

    def require(self, key: str, kind: type, what: str) -> Any:
        """Return a value that must be there and of one kind."""
        if key not in self.values:
            self.fail("", f"{key!r} ({what}) is missing")
        if not isinstance(self.values[key], kind):
            self.fail(key, f"{self.values[key]!r} must be {what}")
        return self.values[key]

    def text(self, key: str) -> str:
        """Return a text, "" where there is none."""
        if key not in self.values:
            return ""
        return " ".join(self.require(key, str, "a text").split())

    def section(self, key: str, known: tuple[str, ...] = ()) -> Section:
        """Return a table that must be there; with ``known``, check its keys."""
        values = self.require(key, dict, "a table")
        inner = Section(self.file, self.lines, f"{self.path}.{key}".strip("."), values)
        if known:
            inner.check_keys(known)
        return inner

    def quantity(self, key: str, kind: str) -> tuple[Any, Source]:
        """Return a quantity (number or array) in SI, and where it comes from."""
        table = self.section(key, QUANTITY_KEYS)
        unit = table.require("unit", str, "a text such as " + repr(next(iter(UNITS[kind]))))
        factor = si_factor(kind, unit)
        if factor is None:
            table.fail("unit", f"{unit!r} is no unit of {kind}; known: {', '.join(UNITS[kind])}")
        if "value" not in table.values:
            table.fail("", "'value' is missing")
        value = table.values["value"]
        try:
            numbers = np.asarray(value, dtype=float)
        except (TypeError, ValueError):
            table.fail("value", f"{value!r} must be a number or an array of numbers")
        if isinstance(value, bool | str) or not np.isfinite(numbers).all():
            table.fail("value", f"{value!r} must be finite numbers")
        status = table.require("status", str, "one of " + ", ".join(STATUSES))
        if status not in STATUSES:
            table.fail("status", f"{status!r} is unknown{nearest(status, STATUSES)}")
        if not table.require("source", str, "a text").strip():
            table.fail("source", "is empty: say where the value comes from")
        source = Source(status, table.text("source"), table.text("doubt"), _as_given(value, unit))
        converted = numbers * factor
        if zero := si_zero(kind, unit):
            converted = converted + zero
        return (float(converted) if converted.ndim == 0 else converted), source

    def number(self, key: str, kind: str) -> tuple[float, Source]:
        """Return a single quantity in SI, and where it comes from."""
        value, source = self.quantity(key, kind)
        if not isinstance(value, float):
            self.fail(f"{key}.value", "must be one number")
        return value, source

    def blame(self, error: InputError) -> NoReturn:
        """Raise a law's complaint again, at the key that it names."""
        words = str(error).replace(" ", "_")
        named = [k for k in self.values if isinstance(self.values[k], dict) and k in words]
        key = max(named, key=len, default="")
        self.fail(f"{key}.value" if key else "", str(error))


def read_law(
    file: Section,
    key: str,
    laws: Mapping[str, Mapping[str, str]],
    sources: dict[str, Source],
    others: Sequence[str] = (),
) -> tuple[Section, str, dict[str, Any]]:
    """Return the section of a law, the law's name and its values in SI.

    Args:
        file: what holds the section.
        key: its name there.
        laws: names of laws → names of values → their kinds.
        sources: by dotted names of values; added to.
        others: keys that the section may have besides.
    """
    section = file.section(key)
    law = section.require("law", str, "one of " + ", ".join(laws))
    try:
        one_of(f"{key} law", law, laws)
    except InputError as error:
        section.fail("law", str(error))
    section.check_keys(("law", *laws[law], *others))
    values = {}
    for name, kind in laws[law].items():
        values[name], sources[f"{section.path}.{name}"] = section.quantity(name, kind)
    return section, law, values


def _itself_and_parents(dotted: str) -> list[str]:
    parts = dotted.split(".")
    return [".".join(parts[:n]) for n in range(len(parts), 0, -1)]


def _as_given(value: Any, unit: str) -> str:
    shown = "" if unit == "-" else f" {unit}"
    if isinstance(value, list) and any(isinstance(row, list) for row in value):
        return f"table of {len(value)} rows{shown}"
    if isinstance(value, list) and len(value) > MANY:
        return f"{len(value)} numbers, {value[0]:g} to {value[-1]:g}{shown}"
    if isinstance(value, list):
        return "(" + ", ".join(f"{v:g}" for v in value) + ")" + shown
    return f"{value:g}{shown}"


def read_sections(path: Path, shown_as: str) -> Section:
    """Read a fabric file.

    Args:
        path: the file.
        shown_as: what messages call it.

    Raises:
        InputError: it cannot be read, or is no TOML.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"fabric file {shown_as} cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        line = path.read_bytes()[: error.start].count(b"\n") + 1
        raise InputError(f"{shown_as}, line {line}: not UTF-8: save the file as UTF-8") from error
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        words, _, place = str(error).rpartition(" (at line ")
        at = f", line {place.split(',')[0]}" if words else ""
        raise InputError(f"{shown_as}{at}: not valid TOML: {words or error}") from error
    return Section(shown_as, key_lines(text), "", values)
