"""The study file of an optimisation: what `[optimise]` says, beside scene, parameters, measures."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from warpdrape.commands.scene_library import SceneScript
from warpdrape.errors import InputError, finite, said
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.optimisation.aims import Aims, read_aims
from warpdrape.optimisation.descent import GRADIENT, refuse_gradient
from warpdrape.optimisation.methods import GP, METHODS
from warpdrape.optimisation.space import Axis, axes_of
from warpdrape.studies.design import Design, Row
from warpdrape.studies.measures import FIT
from warpdrape.studies.parameters import Varied
from warpdrape.studies.study import Study
from warpdrape.studies.study_file import (
    FABRIC,
    OPTIMISE,
    check_keys,
    of_file,
    read_tables,
    settings_of,
    study_of,
    table_of,
)
from warpdrape.studies.study_file import (
    KEYS as STUDY_KEYS,
)

KEYS = (
    *("minimise", "maximise", "constraints", "quasi_static", "runs", "batch", "seed", "method"),
    *("start", "coarse", "repeats", "finalists"),
)
COARSE_KEYS = ("set", "share")
BATCH, FINALISTS, SHARE = 4, 3, 0.5
"""Where nothing is asked: runs at a time, best ones that are repeated, cost of coarse runs."""
CELLS = "cells"
"""Parameter of scenes by which, where nothing is asked, repeats differ: two more and two less, so
that a vertex stays under the pole where there was one."""
SEARCHED = Design("search")
"""Runs that are chosen one batch after the other."""


@dataclass(frozen=True)
class Coarse:
    """Cheaper runs that come first.

    Attributes:
        settings: of theirs, ``NAME=VALUE``.
        share: of the budget that they take [-].
    """

    settings: tuple[str, ...]
    share: float


@dataclass(frozen=True, eq=False)
class Task:
    """An optimisation as its file has it.

    Attributes:
        study: scene, parameters, measures, and how each run is computed.
        aims: what is to be best, and what must hold.
        axes: where settings may lie.
        start: settings with which it is compared.
        runs: budget, in runs at full fineness.
        batch: runs at a time.
        seed: of what is random.
        method: by which places are chosen.
        coarse: cheaper runs; None without.
        repeats: settings of the repeats of the best, each ``NAME=VALUE``.
        finalists: how many of the best are repeated.
        given: the table as it stands.
    """

    study: Study
    aims: Aims
    axes: tuple[Axis, ...]
    start: Row
    runs: int
    batch: int
    seed: int
    method: str
    coarse: Coarse | None
    repeats: tuple[tuple[str, ...], ...]
    finalists: int
    given: Mapping[str, Any]


def read_optimisation(path: str | os.PathLike[str], seed: int | None = None) -> Task:
    """Read the study file of an optimisation.

    Args:
        path: the file.
        seed: in place of the file's.

    Raises:
        InputError: it cannot be read, or says something that makes no sense; with the file's name.
    """
    file = Path(path)
    tables = read_tables(file)
    with of_file(file):
        check_keys("", tables, STUDY_KEYS)
        if OPTIMISE not in tables:
            raise InputError("no [optimise]: say what is to be best, as minimise = 'NAME'")
        given = dict(table_of(tables, OPTIMISE))
        if seed is not None:
            given["seed"] = seed
        study = study_of(file, {k: v for k, v in tables.items() if k != "design"}, SEARCHED)
        return _task(study, given)


def _task(study: Study, given: Mapping[str, Any]) -> Task:
    check_keys("optimise: ", given, KEYS)
    known = [*(measure.name for measure in study.measures), FIT]
    if "runs" not in given:
        raise InputError("optimise: runs is missing: say how many, such as runs = 40")
    method = given.get("method", GP)
    if method not in METHODS:
        raise InputError(f"optimise: method = {said(method)} must be one of {', '.join(METHODS)}")
    varied = [p.name for p in study.parameters]
    coarse = None if "coarse" not in given else _coarse(study, table_of(given, "coarse"), varied)
    runs = _whole(given, "runs", 0, 2)
    if coarse is not None and runs < 4:
        raise InputError(f"optimise: runs = {runs} leaves nothing for coarse ones: give 4 or more")
    aims, axes = read_aims(given, known, _locking_deg(study)), axes_of(study.parameters)
    if method == GRADIENT:
        refuse_gradient(axes, aims, coarse=coarse is not None)
    return Task(
        study=study,
        aims=aims,
        axes=axes,
        start=_start(study, table_of(given, "start")),
        runs=runs,
        batch=_whole(given, "batch", BATCH, 1),
        seed=_whole(given, "seed", 1, 0),
        method=method,
        coarse=coarse,
        repeats=_repeats(study, given, varied),
        finalists=_whole(given, "finalists", FINALISTS, 1),
        given=given,
    )


def _whole(given: Mapping[str, Any], name: str, default: int, least: int) -> int:
    value = given.get(name, default)
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise InputError(
            f"optimise: {name} = {said(value)} must be a whole number, {least} or more"
        )
    return value


def _locking_deg(study: Study) -> float | None:
    """Locking angle of the fabric that all runs have [deg]; None where it is not known."""
    parameter = study.script.parameters.get(FABRIC)
    if parameter is None or any(p.name == FABRIC for p in study.parameters):
        return None
    name = study.script.read_settings(study.fixed).get(FABRIC, parameter.default)
    try:
        angle = load_fabric(str(name)).locking_angle
    except InputError:
        return None
    return None if angle is None else math.degrees(angle)


def _start(study: Study, table: Mapping[str, Any]) -> Row:
    """Settings with which the best are compared: the scene's own where none are given."""
    names = [p.name for p in study.parameters]
    check_keys("optimise: start: ", table, tuple(names))
    return {
        p.name: p.read(table[p.name]) if p.name in table else _own(study, p)
        for p in study.parameters
    }


def _own(study: Study, varied: Varied) -> Any:
    """A parameter's own value: the scene's default, or what the card says."""
    if varied.own is not None:
        return varied.own.default
    if varied.relative or study.card is None:
        return 1.0
    return float(study.card.table(varied.key)["value"])


def _coarse(study: Study, table: Mapping[str, Any], varied: list[str]) -> Coarse:
    check_keys("optimise: coarse: ", table, COARSE_KEYS)
    settings = _settings(study, "optimise: coarse: set", table_of(table, "set"), varied)
    if not settings:
        raise InputError(
            "optimise: coarse: set is missing: say what makes runs cheaper, as "
            'set = { cells = 8, accuracy = "draft" }'
        )
    share = finite("optimise: coarse: share", table.get("share", SHARE))
    if not 0.0 < share < 1.0:
        raise InputError(f"optimise: coarse: share = {share:g} must lie between 0 and 1")
    return Coarse(settings, share)


def _repeats(
    study: Study, given: Mapping[str, Any], varied: list[str]
) -> tuple[tuple[str, ...], ...]:
    tables = given.get("repeats")
    if tables is None:
        return _by_cells(study, varied)
    if not isinstance(tables, list) or not all(isinstance(each, Mapping) for each in tables):
        raise InputError(
            f"optimise: repeats = {said(tables)} must be a list of tables, as "
            "[{ cells = 19 }, { cells = 21 }]"
        )
    found = tuple(_settings(study, "optimise: repeats", each, varied) for each in tables)
    if not all(found) or len(set(found)) < len(found):
        raise InputError(
            f"optimise: repeats = {said(tables)}: each must change something, and each else"
        )
    return found


def _by_cells(study: Study, varied: list[str]) -> tuple[tuple[str, ...], ...]:
    parameter = study.script.parameters.get(CELLS)
    if parameter is None or parameter.kind is not int or parameter.several or CELLS in varied:
        return ()
    cells = study.script.read_settings(study.fixed).get(CELLS, parameter.default)
    return tuple((f"{CELLS}={cells + more}",) for more in (-2, 2) if cells + more > 0)


def _settings(
    study: Study, where: str, table: Mapping[str, Any], varied: list[str]
) -> tuple[str, ...]:
    script: SceneScript = study.script
    for name in table:
        if name in varied:
            raise InputError(f"{where}: {name} is a parameter that is searched: leave it away here")
        if name == FABRIC and study.card is not None:
            raise InputError(f"{where}: fabric cannot change where values of its card are searched")
    return settings_of(study.path, where, table, script)
