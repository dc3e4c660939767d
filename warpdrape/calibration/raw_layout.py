"""The header of a laboratory's table: which column is what, in which unit, for which specimen."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NoReturn

from warpdrape.calibration.columns import Heading, fit_of, heading, plain
from warpdrape.calibration.lab_units import known_units, lab_factor, quantities_of
from warpdrape.calibration.raw_text import RawText
from warpdrape.errors import InputError, nearest


@dataclass(frozen=True)
class Wanted:
    """What is looked for in a table, and what the user says about it.

    Attributes:
        ways: each a set of columns, as name → quantity; the first that is there is taken.
        also: columns that are read where they are there.
        columns: name → header's text or number of a column from 1, where the user says it.
        units: name → unit, where the user says it.
        delimiter: what separates columns; "" to find out.
        decimal: "." or ","; "" to find out.
    """

    ways: tuple[Mapping[str, str], ...]
    also: Mapping[str, str]
    columns: Mapping[str, str | int]
    units: Mapping[str, str]
    delimiter: str = ""
    decimal: str = ""


@dataclass(frozen=True)
class Layout:
    """Columns of a table: for each group (a specimen) the index of every role; their factors."""

    groups: tuple[dict[str, int], ...]
    units: dict[str, tuple[float, str]]
    specimen: int | None
    heads: dict[str, str]
    width: int
    first_row: int


def find_layout(text: RawText, at: int, wanted: Wanted, known: Layout | None) -> Layout | None:
    """The header at or after a row, or None; by the user's numbers of columns where given.

    With a header ``known`` already, the next one is looked for up to the next row of data only.
    """
    if wanted.columns and all(isinstance(c, int) for c in wanted.columns.values()):
        return _by_number(text, at, wanted)
    for row in range(at, len(text.rows)):
        numbers = [text.number(cell) is not None for cell in text.rows[row] if cell]
        if all(numbers) and known is not None:
            return None
        if all(numbers):
            continue
        below = _units_row(text, row + 1)
        heads = [
            heading(cell, below[i] if i < len(below) else "")
            for i, cell in enumerate(text.rows[row])
        ]
        groups = _assign(text, row, heads, wanted)
        if groups is not None:
            return _with_units(text, row, heads, groups, wanted, row + 1 + bool(below))
    return None


def _by_number(text: RawText, at: int, wanted: Wanted) -> Layout | None:
    for way in wanted.ways:
        if set(way) <= set(wanted.columns):
            roles = {**way, **{r: q for r, q in wanted.also.items() if r in wanted.columns}}
            break
    else:
        missing = ", ".join(r for r in wanted.ways[0] if r not in wanted.columns)
        raise InputError(f"{text.name}: columns says no number of {missing}")
    group = {role: int(wanted.columns[role]) - 1 for role in roles}
    for row in range(at, len(text.rows)):
        cells = text.rows[row]
        if all(0 <= i < len(cells) and text.number(cells[i]) is not None for i in group.values()):
            break
    else:
        return None
    if at > 0:
        return None
    above = text.rows[row - 1] if row else []
    heads = [heading(above[i] if i < len(above) else "") for i in range(len(text.rows[row]))]
    return _with_units(text, row, heads, [group], wanted, row)


def _units_row(text: RawText, row: int) -> list[str]:
    """Cells of a line of units below a header, none where the line is something else."""
    if row >= len(text.rows):
        return []
    cells = [cell.strip() for cell in text.rows[row]]
    given = [cell for cell in cells if cell]
    units = [c for c in given if quantities_of(c.strip('[]()<>" ')) or c in ("-", "[-]", "(-)")]
    return cells if given and len(units) == len(given) else []


def _assign(
    text: RawText, row: int, heads: list[Heading], wanted: Wanted
) -> list[dict[str, int]] | None:
    """Column of every role for each specimen side by side; None where this is no header."""
    for way in wanted.ways:
        columns = {role: _candidates(role, heads, q, wanted) for role, q in way.items()}
        columns = _apart(columns, heads)
        if all(columns.values()):
            groups = _groups(text, row, columns, heads)
            for role, quantity in wanted.also.items():
                extra = _candidates(role, heads, quantity, wanted)
                if len(extra) == 1 and extra[0] not in groups[0].values():
                    groups = [{**group, role: extra[0]} for group in groups]
            return groups
    return None


def _candidates(role: str, heads: list[Heading], quantity: str, wanted: Wanted) -> list[int]:
    said = wanted.columns.get(role)
    if isinstance(said, int):
        return [said - 1] if 0 < said <= len(heads) else []
    if said is not None:
        return [i for i, h in enumerate(heads) if plain(said) in (plain(h.name), plain(h.text))]
    if role in wanted.units:
        heads = [Heading(h.name, "", h.text) for h in heads]
    fits = [fit_of(role, head, quantity) for head in heads]
    best = max(fits, default=0)
    return [i for i, fit in enumerate(fits) if fit == best and best > 0]


def _apart(columns: dict[str, list[int]], heads: list[Heading]) -> dict[str, list[int]]:
    """No column for two roles: the one for which it is the only candidate has it."""
    for role, own in columns.items():
        if len(own) == 1:
            for other, theirs in columns.items():
                if other != role and len(theirs) > 1:
                    columns[other] = [i for i in theirs if i not in own]
    return columns


def _groups(
    text: RawText, row: int, columns: dict[str, list[int]], heads: list[Heading]
) -> list[dict[str, int]]:
    """Tables side by side as one group each; columns of one table alone may be shared."""
    count = max(map(len, columns.values()))
    for role, where in columns.items():
        bare = {re.sub(r"[\d\s#_.-]+", "", plain(heads[i].name)) for i in where}
        if len(where) > 1 and (len(bare) > 1 or len(where) != count):
            raise InputError(
                f"{text.name}, line {text.lines[row]}: {role} may be "
                f"{', '.join(repr(heads[i].text) for i in where)}: say which, "
                f'columns = {{ {role} = "{heads[where[0]].text}" }}'
            )
    return [{role: w[min(g, len(w) - 1)] for role, w in columns.items()} for g in range(count)]


def _with_units(
    text: RawText,
    row: int,
    heads: list[Heading],
    groups: list[dict[str, int]],
    wanted: Wanted,
    first_row: int,
) -> Layout:
    units, shown = {}, {}
    quantities = {r: q for way in wanted.ways for r, q in way.items()} | dict(wanted.also)
    for role, column in groups[0].items():
        quantity = quantities[role]
        unit = wanted.units.get(role, heads[column].unit)
        if not unit and quantity != "ratio":
            raise InputError(
                f"{text.name}, line {text.lines[max(row, 0)]}: the column of {role} "
                f"({heads[column].text!r}) has no unit: write it in the header, or say "
                f'units = {{ {role} = "{known_units(quantity).split(",")[0]}" }} of the test'
            )
        factor = lab_factor(quantity, unit or "-")
        if factor is None:
            raise InputError(
                f"{text.name}: {role} is in {unit!r}, which is no unit of {quantity}; known: "
                f"{known_units(quantity)}"
            )
        units[role] = factor, unit or "-"
        shown[role] = (
            f"{role} from {heads[column].text or f'column {column + 1}'!r} in {unit or '-'}"
        )
    said = [i for i, h in enumerate(heads) if fit_of("specimen", Heading(h.name, "", ""), "count")]
    taken = {i for group in groups for i in group.values()}
    said = [i for i in said if i not in taken]
    specimen = said[0] if said and len(groups) == 1 else None
    width = max(1 + max(taken), sum(bool(head.text) for head in heads))
    return Layout(tuple(groups), units, specimen, shown, width, first_row)


def refuse(text: RawText, wanted: Wanted) -> NoReturn:
    """Say what was looked for, and what the file has."""
    roles = " or ".join(", ".join(way) for way in wanted.ways)
    header = next(
        (r for r in text.rows if sum(text.number(c) is None for c in r if c) >= 2), text.rows[0]
    )
    cells = [c for c in header if c]
    for role, said in wanted.columns.items():
        if isinstance(said, str):
            raise InputError(
                f"{text.name} has no column {said!r} for {role}{nearest(said, cells or ['none'])}"
            )
    raise InputError(
        f"{text.name}: no header that names {roles}; its first one reads "
        f"{', '.join(map(repr, cells[:8]))}: say which column is which, "
        f'columns = {{ {next(iter(wanted.ways[0]))} = "NAME" }} or its number'
    )
