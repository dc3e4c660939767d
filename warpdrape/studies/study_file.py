"""Reading the study file: see `Study` for what it says."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from warpdrape.cadence import read_cadence
from warpdrape.commands.scene_library import SceneScript, find_script
from warpdrape.defects.limits import read_limits
from warpdrape.errors import InputError, nearest, said
from warpdrape.studies.cards import Card, read_card
from warpdrape.studies.design import Design, read_design
from warpdrape.studies.measures import read_measures
from warpdrape.studies.parameters import Varied, exact, read_parameter
from warpdrape.studies.study import MapOptions, RunOptions, Study

OPTIMISE = "optimise"
"""Table of what is to be best, which `warpdrape.optimisation` reads."""
KEYS = (
    *("scene", "name", "set", "run", "parameters", "design", "measures", "maps", "limits"),
    OPTIMISE,
)
RUN_KEYS = ("frames", "device", "threads", "checkpoint")
MAP_KEYS = ("locking_deg", "wrinkle")
_NAME = re.compile(r"\w[\w .-]*")
FABRIC = "fabric"
"""Parameter of a scene that takes a fabric's name or file."""


def read_study(path: str | os.PathLike[str]) -> Study:
    """Read a study file.

    Raises:
        InputError: it cannot be read, or says something that makes no sense; with the file's name.
    """
    file = Path(path)
    given = read_tables(file)
    with of_file(file):
        if OPTIMISE in given and "design" not in given:
            raise InputError(
                "it has no [design] but [optimise]: run it with warpdrape optimise, or give a "
                "design too"
            )
        return study_of(file, given)


def read_tables(file: Path) -> dict[str, Any]:
    """What a study file holds, as TOML has it; raise `InputError` where it cannot be read."""
    try:
        return tomllib.loads(file.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise InputError(f"study {file} cannot be read: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"study {file}: not valid TOML: {error}") from error


@contextmanager
def of_file(file: Path) -> Iterator[None]:
    """Put the study file's name before what is wrong in it."""
    try:
        yield
    except InputError as error:
        raise InputError(f"study {file}: {error}") from None


def study_of(file: Path, given: Mapping[str, Any], design: Design | None = None) -> Study:
    """Make a study of what its file holds.

    Args:
        file: the file, beside which others are looked for.
        given: what it holds.
        design: how its runs are chosen; None for what the file says.

    Raises:
        InputError: if something makes no sense.
    """
    check_keys("", given, KEYS)
    if not isinstance(given.get("scene"), str):
        raise InputError("scene is missing: give a bundled name or a script, scene = 'hemisphere'")
    script = find_script(_beside(file, given["scene"]))
    fixed = settings_of(file, "set", table_of(given, "set"), script)
    tables = {name: _with_files(file, name, t) for name, t in table_of(given, "parameters").items()}
    if design is None:
        design = read_design(given.get("design"), file.parent)
    design = replace(design, rows=tuple(_row_with_files(file, row) for row in design.rows))
    card = _card(script, fixed) if any("card" in _as_table(t) for t in tables.values()) else None
    parameters = _parameters(tables, design, script, card)
    for parameter in parameters:
        if parameter.own is not None and f"{parameter.name}=" in {_name(f) for f in fixed}:
            raise InputError(f"{parameter.name} is both in [set] and a parameter: leave one away")
    if card is not None and any(p.name == FABRIC for p in parameters):
        raise InputError("fabric varies, so that values of its card cannot: leave one away")
    limits = None
    if "limits" in given:
        limits = read_limits(file.parent / str(given["limits"]))
    name = given.get("name", file.stem)
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise InputError(f"name = {said(name)} must be of letters, digits, spaces, -, _ and dots")
    return Study(
        name=name,
        path=file,
        script=script,
        fixed=fixed,
        parameters=parameters,
        design=design,
        options=_options(table_of(given, "run")),
        measures=read_measures(given.get("measures")),
        maps=_maps(table_of(given, "maps")),
        limits=limits,
        card=card,
    )


def _parameters(
    tables: Mapping[str, Any], design: Design, script: SceneScript, card: Card | None
) -> tuple[Varied, ...]:
    listed = design.kind == "list"
    if listed:
        names = list(design.rows[0])
        for name in tables:
            if name not in names:
                raise InputError(f"parameter {name!r} is in no row of the list: leave it away")
        tables = {name: tables.get(name, {}) for name in names}
    if not tables:
        raise InputError("no parameters: give [parameters.NAME] with values or a range")
    found = tuple(
        read_parameter(name, table, script, card, spread=not listed)
        for name, table in tables.items()
    )
    for parameter in found:
        if design.kind == "indices" and not parameter.numeric:
            raise InputError(
                f"parameter {parameter.name!r} is no number: Sobol indices are of numbers; give "
                "another design"
            )
    return found


def settings_of(
    file: Path, where: str, table: Mapping[str, Any], script: SceneScript
) -> tuple[str, ...]:
    """Settings ``NAME=VALUE`` of a table; files beside the study file are found from anywhere.

    Raises:
        InputError: what the scene does not take.
    """
    settings = []
    for name, value in table.items():
        values = value if isinstance(value, list) else [value]
        if not all(isinstance(each, str | bool | int | float) for each in values):
            raise InputError(f"{where}: {name} = {said(value)} must be a number, a text or a list")
        if name == FABRIC and isinstance(value, str):
            value = _beside(file, value)
        settings.append(f"{name}={exact(value)}")
    script.read_settings(settings)
    return tuple(settings)


def _beside(file: Path, name: str) -> str:
    """A name, or a file beside the study file as a full path."""
    beside = file.parent / name
    is_file = name.endswith((".py", ".toml")) or "/" in name or os.sep in name
    return os.fspath(beside.resolve()) if is_file else name


def _with_files(file: Path, name: str, table: Any) -> Any:
    """A parameter's table, its values full paths where they are fabric files."""
    if name != FABRIC or not isinstance(_as_table(table).get("values"), list):
        return table
    return {**table, "values": [_row_with_files(file, {name: v})[name] for v in table["values"]]}


def _row_with_files(file: Path, row: Mapping[str, Any]) -> Mapping[str, Any]:
    """A row of a list, likewise."""
    fabric = row.get(FABRIC)
    return {**row, FABRIC: _beside(file, fabric)} if isinstance(fabric, str) else row


def _card(script: SceneScript, fixed: tuple[str, ...]) -> Card | None:
    parameter = script.parameters.get(FABRIC)
    if parameter is None or parameter.kind is not str:
        return None
    name = script.read_settings(fixed).get(FABRIC, parameter.default)
    return read_card(str(name))


def _options(table: Mapping[str, Any]) -> RunOptions:
    check_keys("run: ", table, RUN_KEYS)
    for name in ("frames", "threads"):
        value = table.get(name, 1)
        if isinstance(value, bool) or not isinstance(value, int) or value < 1:
            raise InputError(f"run: {name} = {said(value)} must be a whole number above zero")
    if not isinstance(table.get("device", ""), str):
        raise InputError(f"run: device = {said(table['device'])} must be 'cpu' or 'cuda:0'")
    options = RunOptions(**{**table, "checkpoint": str(table.get("checkpoint", "auto"))})
    read_cadence(options.checkpoint)
    return options


def _maps(table: Mapping[str, Any]) -> MapOptions:
    from warpdrape.commands.scene_parameters import Parameter

    check_keys("maps: ", table, MAP_KEYS)
    units = {"locking_deg": "deg", "wrinkle": "m"}
    found = {}
    for name, value in table.items():
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise InputError(f"maps: {name} = {said(value)} must be a number [{units[name]}]")
        number = Parameter(name, float, 1.0, False, f"[{units[name]}]").read(exact(value))
        if number < 0.0:
            raise InputError(f"maps: {name} = {value!r} must be zero or more")
        found[name] = number
    return MapOptions(**found)


def table_of(given: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """A table within another, empty where it is not given; raise `InputError` if it is none."""
    value = given.get(key, {})
    if not isinstance(value, Mapping):
        raise InputError(f"{key} = {said(value)} must be a table, [{key}]")
    return value


def _as_table(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, Mapping) else {}


def check_keys(where: str, given: Mapping[str, Any], known: tuple[str, ...]) -> None:
    """Raise `InputError` for a key that is not known, with the nearest that is."""
    for key in given:
        if key not in known:
            raise InputError(f"{where}key {key!r} is unknown{nearest(key, known)}")


def _name(setting: str) -> str:
    return setting[: setting.index("=") + 1]
