"""The file of tests: which raw tables there are, of which kind, and how the tests were set up."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from glob import glob
from importlib import resources
from pathlib import Path
from typing import Any

from warpdrape.calibration.kinds import ANY, KINDS, Kind
from warpdrape.calibration.lab_units import si_value
from warpdrape.calibration.raw_layout import Wanted
from warpdrape.calibration.raw_table import Specimen, read_table
from warpdrape.errors import InputError, one_of, positive
from warpdrape.materials.fabric_file import Section, read_sections
from warpdrape.materials.fabric_library import fabric_names

LAWS = {
    "shear": ("table", "polynomial"),
    "shear_from": ("both", "picture_frame", "bias_extension", "shear_loop"),
    "shear_offset": ("keep", "remove"),
    "tension": ("linear", "crimp", "table"),
    "bending": ("linear", "curve"),
    "compaction": ("table", "power"),
}
"""Choices under ``[laws]``; the first is taken where none is made."""
TOES = ("keep", "line")


@dataclass(frozen=True)
class Test:
    """One test: specimens of one kind, tested alike.

    Attributes:
        name: its table's name in the file.
        kind: name of its kind.
        values: values of the set-up in SI, and choices as texts.
        specimens: what was measured.
        toe: what is done about a slack start: "keep" or "line".
        empty: travel and force of the empty machine, to be taken off; None without.
        note: what the user says about it.
        files: names of its raw files.
        given: its table as it stands in the file.
    """

    __test__ = False  # no test of pytest's

    name: str
    kind: str
    values: Mapping[str, Any]
    specimens: tuple[Specimen, ...]
    toe: str = "keep"
    empty: Specimen | None = None
    note: str = ""
    files: tuple[str, ...] = ()
    given: Mapping[str, Any] = field(default_factory=dict)

    @property
    def about(self) -> Kind:
        """Its kind."""
        return KINDS[self.kind]


@dataclass(frozen=True)
class Plan:
    """What a file of tests asks for.

    Attributes:
        file: what messages call it.
        fabric: the card that the tests complete, as tables of a fabric file.
        base: name or file of the card to begin with, "" for none.
        laws: choices of `LAWS`.
        tests: in the order of the file.
    """

    file: str
    fabric: Mapping[str, Any]
    base: str
    laws: Mapping[str, str]
    tests: tuple[Test, ...]

    def of(self, *kinds: str) -> list[Test]:
        """Tests of some kinds."""
        return [test for test in self.tests if test.kind in kinds]


def read_plan(path: str | os.PathLike[str]) -> Plan:
    """Read a file of tests and all its raw tables.

    Raises:
        InputError: it, or a raw table, cannot be read or has a fault.
    """
    file = read_sections(Path(path), os.fspath(path))
    file.check_keys(("base", "fabric", "laws", "tests"))
    folder = Path(path).parent
    laws = {name: choices[0] for name, choices in LAWS.items()}
    if "laws" in file.values:
        section = file.section("laws", tuple(LAWS))
        for name in section.values:
            laws[name] = _choice(section, name, LAWS[name])
    base = file.text("base")
    if not base and "fabric" not in file.values:
        file.fail(
            "",
            "give base (a fabric's name or file), or the table [fabric] of what the tests "
            "do not measure: name, areal_density, thickness, yarns_warp, yarns_weft",
        )
    fabric = {**_base(file, base, folder), **file.values.get("fabric", {})}
    if not isinstance(fabric.get("name"), str):
        file.fail("fabric", "'name' (a text) is missing")
    tests = file.section("tests")
    if not tests.values:
        tests.fail("", "holds no test: add [tests.NAME] with kind and files")
    read = tuple(_test(tests.section(name), name, folder) for name in tests.values)
    return Plan(file.file, fabric, base, laws, read)


def _base(file: Section, base: str, folder: Path) -> dict[str, Any]:
    """Tables of the card to begin with."""
    if not base:
        return {}
    if base in fabric_names():
        text = resources.files("warpdrape.fabrics").joinpath(f"{base}.toml").read_text("utf-8")
        return tomllib.loads(text)
    if not (base.endswith(".toml") or (folder / base).is_file()):
        file.fail("base", f"{base!r} is neither a fabric of the library nor a .toml file")
    return dict(read_sections(folder / base, base).values)


def _choice(section: Section, key: str, known: tuple[str, ...]) -> str:
    value = section.require(key, str, "one of " + ", ".join(known))
    try:
        return one_of(key, value, known)
    except InputError as error:
        section.fail(key, str(error))


def _test(section: Section, name: str, folder: Path) -> Test:
    kind_name = _choice(section, "kind", tuple(KINDS))
    kind = KINDS[kind_name]
    section.check_keys((*ANY, *kind.values, *kind.optional, *kind.choices))
    values: dict[str, Any] = {}
    for key, quantity in {**kind.values, **kind.optional}.items():
        if key in section.values:
            values[key] = _value(section, key, quantity)
        elif key in kind.values:
            section.fail("", f"{key!r} ({quantity}, such as of this {kind.words}) is missing")
    for key, choices in kind.choices.items():
        if key not in section.values:
            section.fail("", f"{key!r} ({' or '.join(choices)}) is missing")
        values[key] = _choice(section, key, choices)
    wanted = _wanted(section, kind)
    files = _files(section, folder)
    specimens = _weighed(section, [s for path in files for s in read_table(path, wanted)])
    empty = None
    if "empty" in section.values:
        if not kind.rising:
            section.fail("empty", f"is of no use to a {kind.words} test: leave it out")
        empty = read_table(
            folder / section.text("empty"),
            replace(
                wanted, ways=kind.columns[-1:] if "travel" in kind.columns[-1] else kind.columns[:1]
            ),
        )[0]
    toe = _choice(section, "toe", TOES) if "toe" in section.values else TOES[0]
    _check(section, kind_name, values, specimens)
    return Test(
        name,
        kind_name,
        values,
        specimens,
        toe,
        empty,
        section.text("note"),
        tuple(path.name for path in files),
        dict(section.values),
    )


def _weighed(section: Section, specimens: list[Specimen]) -> tuple[Specimen, ...]:
    """Specimens with their weights: one number for all of a test, or an array of one for each."""
    given = section.values.get("weight", 1.0)
    weights = given if isinstance(given, list) else [given] * len(specimens)
    if len(weights) != len(specimens):
        section.fail(
            "weight",
            f"has {len(weights)} numbers for {len(specimens)} specimens: give one for each, in the "
            "order in which --dry lists them, or one for all",
        )
    try:
        weighed = [positive("weight", weight) for weight in weights]
    except InputError as error:
        section.fail("weight", str(error))
    return tuple(replace(s, weight=w) for s, w in zip(specimens, weighed, strict=True))


def _value(section: Section, key: str, quantity: str) -> float:
    try:
        value = si_value(key, section.values[key], quantity)
        if key not in ("slack", "tare", "preload", "yarns", "compliance"):
            positive(key, value)
    except InputError as error:
        section.fail(key, str(error))
    return value


def _wanted(section: Section, kind: Kind) -> Wanted:
    known = tuple(dict.fromkeys(r for way in (*kind.columns, kind.also) for r in way))
    tables: dict[str, dict[str, Any]] = {}
    for key, types, what in (
        ("columns", (str, int), "a header's text or a column's number from 1"),
        ("units", (str,), "a unit in a text"),
    ):
        table = section.values.get(key, {})
        if not isinstance(table, dict):
            section.fail(key, f"must be a table, as {{ {known[0]} = … }}: {what}")
        for role, value in table.items():
            if role not in known:
                section.fail(key, f"{role!r} is no column of this test; known: {', '.join(known)}")
            if isinstance(value, bool) or not isinstance(value, types):
                section.fail(key, f"{role} = {value!r} must be {what}")
        tables[key] = table
    decimal = section.text("decimal")
    if decimal not in ("", ".", ","):
        section.fail("decimal", f'{decimal!r} must be "." or ","')
    delimiter = section.values.get("delimiter", "")
    if not isinstance(delimiter, str) or len(delimiter) > 1:
        section.fail("delimiter", f"{delimiter!r} must be one character")
    return Wanted(kind.columns, kind.also, tables["columns"], tables["units"], delimiter, decimal)


def _files(section: Section, folder: Path) -> list[Path]:
    given = section.require("files", list, 'an array of names, such as ["frame_*.csv"]')
    found: list[Path] = []
    for name in given:
        if not isinstance(name, str) or not name:
            section.fail("files", f"{name!r} must be the name of a file")
        matched = [folder / name]
        if any(ch in name for ch in "*?["):
            matched = sorted(map(Path, glob(os.fspath(folder / name))))
        if not matched:
            section.fail("files", f"{name!r} matches no file in {folder}")
        for path in matched:
            if not path.is_file():
                section.fail("files", f"{name!r} is not there, in {folder}")
            found.append(path)
    if not found:
        section.fail("files", "is empty: name the raw tables")
    return list(dict.fromkeys(found))


def _check(
    section: Section, kind: str, values: dict[str, Any], found: tuple[Specimen, ...]
) -> None:
    """Refuse set-ups for which a test's formula does not hold, and tables without its needs."""
    columns = found[0].columns
    if kind == "bias_extension" and values["height"] < 2.0 * values["width"]:
        section.fail(
            "height", "must be twice the width at least, or yarns reach from clamp to clamp"
        )
    if kind == "picture_frame" and values.get("sample", 0.0) > values["side"]:
        section.fail("sample", "is larger than the frame's side")
    if kind == "uniaxial_tension" and "travel" in columns and "gauge" not in values:
        section.fail("", "'gauge' is missing: the length over which the travel is measured")
    if kind == "compaction" and "pressure" not in columns and "area" not in values:
        section.fail("", "'area' is missing: the plates' area, by which the force is a pressure")
    if kind == "sled":
        by_area = "pressure" in values and "area" in values
        if ("normal" in values) + ("pressure" in values) == 0 or not (
            by_area or ("normal" in values and ("area" in values or "pressure" in values))
        ):
            section.fail("", "give two of 'normal' (force), 'pressure' and 'area'")
