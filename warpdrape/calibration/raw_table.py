"""A laboratory's table as specimens: arrays in SI, by what the columns are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from warpdrape.calibration.raw_layout import Layout, Wanted, find_layout, refuse
from warpdrape.calibration.raw_text import RawText, read_text
from warpdrape.errors import InputError


@dataclass(frozen=True)
class Specimen:
    """What was measured on one specimen.

    Attributes:
        name: of the specimen, or of its file.
        file: from which it was read.
        columns: what it is → values in SI, shape [row].
        understood: how the file was read, in words.
        units: what it is → factor to SI, and the unit as the file has it.
        weight: in a fit with other specimens [-].
    """

    name: str
    file: str
    columns: Mapping[str, np.ndarray]
    understood: tuple[str, ...] = ()
    units: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    weight: float = 1.0


def read_table(path: Path, wanted: Wanted) -> list[Specimen]:
    """Read all specimens of a file.

    A column that says the specimen, tables side by side and tables below each other are all taken
    apart.

    Raises:
        InputError: a column is not found, found twice or has no unit, or rows hold no numbers.
    """
    text = read_text(path, wanted.delimiter, wanted.decimal)
    found: list[Specimen] = []
    at = 0
    layout: Layout | None = None
    while at < len(text.rows):
        begun = find_layout(text, at, wanted, layout)
        if begun is not None:
            layout, at = begun, begun.first_row
        if layout is None:
            refuse(text, wanted)
        rows, at, skipped = _block(text, at, layout)
        if rows:
            found += _specimens(text, layout, rows, skipped, len(found))
        elif begun is None:
            break
    if not found:
        raise InputError(f"{text.name} has a header and no row of numbers below it")
    return found


def _block(text: RawText, at: int, layout: Layout) -> tuple[list[int], int, int]:
    """Rows of numbers from a row on, where they end, and how many lines among them had none."""
    rows, skipped, needed = [], 0, [i for group in layout.groups for i in group.values()]
    while at < len(text.rows):
        cells = text.rows[at]
        numbers = [i < len(cells) and text.number(cells[i]) is not None for i in needed]
        per = len(needed) // len(layout.groups)
        if any(all(numbers[g * per : (g + 1) * per]) for g in range(len(layout.groups))):
            if sum(map(bool, cells)) > layout.width and text.delimiter == ",":
                raise InputError(
                    f"{text.name}, line {text.lines[at]}: {sum(map(bool, cells))} cells under "
                    f"{layout.width} headers: commas both separate and mark decimals, it seems; "
                    "export it with semicolons"
                )
            rows.append(at)
        elif any(text.number(cell) is not None for cell in cells):
            skipped += 1
        elif rows:
            break
        at += 1
    return rows, at, skipped


def _specimens(
    text: RawText, layout: Layout, rows: list[int], skipped: int, before: int
) -> list[Specimen]:
    stem = Path(text.name).stem
    words = (
        f"{text.encoding}, columns by {_delimiter_word(text.delimiter)}, decimal {text.decimal!r}",
        *layout.heads.values(),
        *((f"{skipped} rows without all numbers left out",) if skipped else ()),
    )
    parts: list[tuple[str, dict[str, int], list[int]]] = []
    if layout.specimen is not None:
        labels = [
            text.rows[r][layout.specimen] if layout.specimen < len(text.rows[r]) else ""
            for r in rows
        ]
        for label in dict.fromkeys(labels):
            own = [r for r, each in zip(rows, labels, strict=True) if each == label]
            parts.append((f"{stem} {label}".strip(), layout.groups[0], own))
    else:
        for number, group in enumerate(layout.groups, start=1):
            many = len(layout.groups) > 1 or before > 0
            parts.append((f"{stem} {before + number}" if many else stem, group, rows))
    found = []
    for name, group, own in parts:
        values = [
            [
                text.number(text.rows[r][i]) if i < len(text.rows[r]) else None
                for i in group.values()
            ]
            for r in own
        ]
        whole = np.array([v for v in values if None not in v], dtype=float)
        if not len(whole):
            continue
        columns = {r: layout.units[r][0] * whole[:, k] for k, r in enumerate(group)}
        found.append(Specimen(name, text.name, columns, words, layout.units))
    return found


def _delimiter_word(delimiter: str) -> str:
    return {"\t": "tab", " ": "spaces", "\n": "lines"}.get(delimiter, repr(delimiter))
