"""How a run was made, from its record: scene, parameters, fabrics with sources, tools, versions."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from warpdrape.materials.bending import Bending, BendingCurve
from warpdrape.materials.compaction import Compaction
from warpdrape.materials.crossover import Crossover
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.laws import (
    CrimpInterchange,
    IsotropicMembrane,
    LinearTension,
    MooneyRivlin,
    NoShear,
    ShearPolynomial,
    ShearTable,
    TabulatedTension,
)
from warpdrape.materials.matrix import Heat, Matrix
from warpdrape.materials.viscosity import WLF, Arrhenius, Cross, Newtonian, PowerLaw
from warpdrape.report.markup import Html, element, joined, table
from warpdrape.results.run_folder import HISTORY, RUN, SCENE, SUMMARY
from warpdrape.results.run_tables import read_record
from warpdrape.wording import units

FILES = (SCENE, HISTORY, SUMMARY, RUN)
"""Files of a run folder whose digests a report states."""
DIGITS = 12
"""Significant digits of a number: what was given, without the noise of binary fractions."""
FEW = 8
"""Numbers of a list that are written out."""
_APART = ("scene", "parameters", "fabrics", "versions", "plies", "tools")
_TITLE = {
    "numerics": "Numerics",
    "defect_thresholds": "Thresholds of defects",
    "limits": "Limits of defects",
    "wanted": "Wanted directions",
    "clamps": "Clamps",
    "pressures": "Pressures",
    "springs": "Springs",
    "ply_friction": "Friction between plies",
    "friction": "Friction of tools",
    "call": "How it was called",
}
_KINDS = {
    kind.__name__: kind
    for kind in (
        Fabric,
        LinearTension,
        TabulatedTension,
        CrimpInterchange,
        IsotropicMembrane,
        MooneyRivlin,
        ShearPolynomial,
        ShearTable,
        NoShear,
        Bending,
        BendingCurve,
        Compaction,
        Crossover,
        Matrix,
        Heat,
        Newtonian,
        PowerLaw,
        Cross,
        Arrhenius,
        WLF,
    )
}
"""Records whose docstrings tell the units of what a fabric's card holds."""


def record_of(folder: Path) -> dict[str, Any] | None:
    """What ``run.json`` holds; None where there is none, as in folders of older versions.

    Raises:
        InputError: if it is damaged.
    """
    return read_record(folder) if (folder / RUN).is_file() else None


def record_section(record: Mapping[str, Any] | None) -> Html:
    """Everything that a run's record says."""
    if record is None:
        return element("p", f"The folder holds no {RUN}: how it was made is not known.")
    parts = [element("h3", "Scene"), _pairs(_plain_entries(record), "The scene")]
    parts += _mapping_part("Parameters", record.get("parameters"))
    parts += _rows_part("Plies", record.get("plies"))
    fabrics = record.get("fabrics")
    for name, fabric in fabrics.items() if isinstance(fabrics, Mapping) else ():
        parts += [element("h3", f"Fabric {name}"), _fabric(fabric)]
    parts += _rows_part("Tools", record.get("tools"))
    for name, value in record.items():
        if name not in _APART and value and not _plain(value):
            title = _TITLE.get(name, name.replace("_", " "))
            parts += [element("h3", title), _pairs(_flat(value), title)]
    parts += _mapping_part("Versions", record.get("versions"))
    return joined(parts)


def digests(folder: Path) -> Html:
    """SHA-256 of the files that the report was made from."""
    rows: list[tuple[str, str, str]] = [("file", "bytes", "SHA-256")]
    for name in FILES:
        path = folder / name
        if path.is_file():
            with path.open("rb") as file:
                digest = hashlib.file_digest(file, "sha256").hexdigest()
            rows.append((name, f"{path.stat().st_size:,}", digest))
    return joined([element("h3", "Files"), table(rows, "Files of the run folder", "digests")])


def differing(
    names: Sequence[str], records: Sequence[Mapping[str, Any] | None], titles: Sequence[str] = ()
) -> Html:
    """Every entry of the records that is not the same in all, a column a run.

    Args:
        names: of the runs.
        records: what their ``run.json`` hold.
        titles: entries that are left out.
    """
    flat = [dict(_flat(record)) if record is not None else {} for record in records]
    keys = list(dict.fromkeys(key for each in flat for key in each))
    rows = [
        (key, *(each.get(key, "-") for each in flat))
        for key in keys
        if len({each.get(key, "-") for each in flat}) > 1 and key not in titles
    ]
    if not rows:
        return element("p", "Nothing: their records are the same.")
    return table([("entry", *names), *rows], "What differs in how they were made")


def _plain_entries(record: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for name, value in record.items():
        if _plain(value):
            yield name, _said(value)


def _plain(value: Any) -> bool:
    """Whether an entry is said in one row: a value, or a few numbers."""
    return not isinstance(value, Mapping) and value != [] and not _records(value)


def _mapping_part(title: str, value: Any) -> list[Html]:
    if not isinstance(value, Mapping) or not value:
        return []
    return [element("h3", title), _pairs(_flat(value), title)]


def _rows_part(title: str, records: Any) -> list[Html]:
    """A table with a row a record; of nested ones their entries by dotted names."""
    if not isinstance(records, list) or not all(isinstance(r, Mapping) for r in records):
        return []
    flat = [dict(_flat(record)) for record in records]
    columns = list(dict.fromkeys(key for each in flat for key in each))
    if not columns:
        return []
    rows = [columns, *([each.get(key, "-") for key in columns] for each in flat)]
    return [element("h3", title), table(rows, title)]


def _fabric(fabric: Any) -> Html:
    """The card: every value with what its source gives, its status, source and doubt."""
    if not isinstance(fabric, Mapping):
        return element("p", "The record of this fabric is damaged.")
    sources = fabric.get("sources")
    sources = sources if isinstance(sources, Mapping) else {}
    values = {k: v for k, v in fabric.items() if k not in ("sources", "doubts", "description")}
    rows: list[tuple[str, ...]] = [("value", "in SI", "as given", "status", "source", "doubt")]
    for name, said in _flat(values, with_units=True):
        source = sources.get(name, sources.get(name.replace("matrix.viscosity.", "matrix.")))
        source = source if isinstance(source, Mapping) else {}
        told = (source.get(key) or "-" for key in ("given", "status", "text", "doubt"))
        rows.append((name, said, *map(str, told)))
    parts = [element("p", fabric["description"])] if fabric.get("description") else []
    parts.append(table(rows, f"Fabric {fabric.get('name', '')}", "card"))
    doubts = fabric.get("doubts")
    if isinstance(doubts, list) and doubts:
        parts += [element("h4", "Doubts"), element("ul", *(element("li", d) for d in doubts))]
    return joined(parts)


def _flat(value: Any, before: str = "", *, with_units: bool = False) -> Iterator[tuple[str, str]]:
    """Entries of nested records under dotted names, in words."""
    if isinstance(value, Mapping):
        kind = _KINDS.get(str(value.get("type")))
        of = units(kind) if with_units and kind else {}
        for name, inside in value.items():
            dotted = f"{before}.{name}" if before else str(name)
            if isinstance(inside, Mapping) or _records(inside):
                yield from _flat(inside, dotted, with_units=with_units)
            else:
                yield dotted, _said(inside, of.get(name, "").removeprefix("-"))
    elif _records(value):
        for number, inside in enumerate(value):
            name = inside.get("name", number) if isinstance(inside, Mapping) else number
            yield from _flat(
                inside, f"{before}.{name}" if before else str(name), with_units=with_units
            )
    else:
        yield before or "value", _said(value)


def _records(value: Any) -> bool:
    return isinstance(value, list) and any(isinstance(each, Mapping) for each in value)


def _said(value: Any, unit: str = "") -> str:
    """A value in words."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.{DIGITS}g} {unit}".strip()
    if isinstance(value, list) and len(value) > FEW:
        return f"{len(value)} values from {_said(value[0])} to {_said(value[-1], unit)}"
    if isinstance(value, list):
        return f"({', '.join(_said(each) for each in value)}) {unit}".strip() if value else "none"
    return str(value) if value != "" else "-"


def _pairs(entries: Any, caption: str) -> Html:
    return table([("entry", "value"), *entries], caption, "pairs")
