"""The report of a study: tables of effects and indices, pictures, maps, one HTML page of it all."""

from __future__ import annotations

import csv
import html
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.errors import InputError
from warpdrape.results.run_folder import write_whole
from warpdrape.studies.design import Row
from warpdrape.studies.effects import Effect, effects
from warpdrape.studies.fields import PlyFields, read_fields
from warpdrape.studies.folder import StudyFolder
from warpdrape.studies.indices import Index, indices
from warpdrape.studies.map_files import draw_map, write_map
from warpdrape.studies.maps import map_runs
from warpdrape.studies.one_run import COMPLETED
from warpdrape.studies.page import list_of, picture, write_page
from warpdrape.studies.pictures import draw_effects, draw_indices, draw_pairs, varies
from warpdrape.studies.study import Study
from warpdrape.studies.table import PENDING, Table, gather, write_table

REPORT = "report.html"
SHOWN = 20
"""Runs that did not complete that the page lists, at most; the table has all."""


def write_report(
    study: Study,
    folder: StudyFolder,
    rows: Sequence[Row],
    outcomes: Mapping[int, Mapping[str, Any]],
) -> tuple[Table, list[Path]]:
    """Write table and report of what has ended of a study; return both.

    Raises:
        RunFailed: when the disk refuses.
    """
    table = gather(study, folder, rows, outcomes)
    files = write_table(table, folder.path)
    page = [f"<h1>Study {html.escape(study.name)}</h1>", _overview(study, table)]
    remarks = list(table.complaints)
    if table.completed.sum() > 1:
        for part in (_effects_part, _indices_part, _pairs_part):
            page += part(study, table, folder.path, files, remarks)
        page += _maps_part(study, folder, table, files, remarks)
    page += [f"<p>Note: {html.escape(words)}</p>" for words in remarks]
    out = folder.path / REPORT
    write_page(out, f"Study {study.name}", page)
    return table, [out, *files]


def _overview(study: Study, table: Table) -> str:
    statuses = table.columns["status"]
    counts = {status: statuses.count(status) for status in dict.fromkeys(statuses)}
    words = ", ".join(f"{count} {status}" for status, count in counts.items())
    page = f"<p>Scene {html.escape(study.script.name)}, design {study.design.kind}, "
    page += f"{len(statuses)} runs: {words}.</p>"
    page += list_of(
        ["measure", "runs", "mean", "standard deviation", "least", "largest"],
        [_spread(name, table.numbers(name)) for name in table.measures],
    )
    bad = [k for k, status in enumerate(statuses) if status not in (COMPLETED, PENDING)]
    if bad:
        page += "<h2>Runs that did not complete</h2>"
        cells = [[str(k), statuses[k], str(table.columns["message"][k])] for k in bad[:SHOWN]]
        page += list_of(["run", "status", "why"], cells)
        page += f"<p>and {len(bad) - SHOWN} more</p>" if len(bad) > SHOWN else ""
    return page


def _spread(name: str, values: np.ndarray) -> list[str]:
    values = values[np.isfinite(values)]
    if not len(values):
        return [name, "0", "", "", "", ""]
    sd = f"{values.std(ddof=1):.4g}" if len(values) > 1 else ""
    ends = [f"{values.min():.4g}", f"{values.max():.4g}"]
    return [name, str(len(values)), f"{values.mean():.4g}", sd, *ends]


def _effects_part(
    study: Study, table: Table, folder: Path, files: list[Path], remarks: list[str]
) -> list[str]:
    found = effects(table)
    still = [name for name in table.measures if not varies(table, name)]
    if still:
        remarks.append(f"the same in all runs, or nowhere: {', '.join(still)}")
    if len(still) == len(table.measures):
        return []
    _write_rows(
        folder / "effects.csv",
        ["measure", "parameter", "level", "mean", "error", "runs", "rank_correlation"],
        _effect_rows(found),
    )
    figure = draw_effects(table, found)
    drawn = picture(folder / "effects.png", figure, "effects of the parameters")
    files += [folder / "effects.csv", folder / "effects.png"]
    return [
        "<h2>Main effects</h2><p>A dot is a run; the line is the mean over the runs near that "
        "value of the parameter, with its standard error.</p>",
        drawn,
    ]


def _effect_rows(found: Sequence[Effect]) -> Iterator[list[str]]:
    for e in found:
        levels = e.words or [repr(float(level)) for level in e.levels]
        for level, mean, error, runs in zip(levels, e.means, e.errors, e.counts, strict=True):
            yield [
                e.measure,
                e.parameter,
                level,
                _cell(mean),
                _cell(error),
                str(runs),
                _cell(e.rank),
            ]


def _indices_part(
    study: Study, table: Table, folder: Path, files: list[Path], remarks: list[str]
) -> list[str]:
    found, remark = indices(table, study.design)
    if remark:
        remarks.append(remark)
    if not found:
        return []
    names = ["measure", "parameter", "first", "first_95", "total", "total_95", "method", "runs"]
    _write_rows(folder / "indices.csv", names, map(_index_row, found))
    drawn = picture(folder / "indices.png", draw_indices(found), "Sobol indices")
    files += [folder / "indices.csv", folder / "indices.png"]
    how = f"{found[0].method}, {found[0].runs} runs; bars with 95 % intervals, below zero is noise"
    return [f"<h2>Sobol indices</h2><p>Shares of variance; {how}.</p>", drawn]


def _index_row(i: Index) -> list[str]:
    numbers = (i.first, i.first_95, i.total, i.total_95)
    return [i.measure, i.parameter, *map(_cell, numbers), i.method, str(i.runs)]


def _pairs_part(
    study: Study, table: Table, folder: Path, files: list[Path], remarks: list[str]
) -> list[str]:
    figure, left = draw_pairs(table)
    if left:
        remarks.append(f"pairs without room for {', '.join(left)}; they are in table.csv")
    drawn = picture(folder / "pairs.png", figure, "pairs of columns")
    files.append(folder / "pairs.png")
    return ["<h2>Pairs</h2>", drawn]


def _maps_part(
    study: Study, folder: StudyFolder, table: Table, files: list[Path], remarks: list[str]
) -> list[str]:
    done = [int(k) for k in np.flatnonzero(table.completed) if folder.fields(int(k)).exists()]
    if not done:
        return []
    try:
        maps = map_runs(_Fields(folder, done), study.maps)
    except InputError as error:
        remarks.append(f"no maps: {error}")
        return []
    page = ["<h2>Maps on the flat blank</h2>"]
    for ply in maps:
        name = f"map_{_file_name(ply.name)}"
        write_map(ply, folder.path / f"{name}.csv")
        drawn = draw_map(ply, len(done))
        page.append(picture(folder.path / f"{name}.png", drawn, f"maps of {ply.name}"))
        files += [folder.path / f"{name}.png", folder.path / f"{name}.csv"]
        if not ply.judged.any():
            remarks.append(
                f"{ply.name}: no locking angle in the fabric's card; give [maps] locking_deg"
            )
    return page


class _Fields:
    """The plies of every run, read anew each time that one goes through them."""

    def __init__(self, folder: StudyFolder, numbers: Sequence[int]) -> None:
        self._folder, self._numbers = folder, numbers

    def __iter__(self) -> Iterator[list[PlyFields]]:
        for number in self._numbers:
            yield read_fields(self._folder.fields(number))


def _write_rows(out: Path, names: Sequence[str], rows: Any) -> None:
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerows([names, *rows])
    write: Callable[[Path], Any] = lambda p: p.write_text(text.getvalue(), "utf-8", newline="\n")  # noqa: E731
    write_whole(out, write)


def _cell(value: float) -> str:
    return "" if value != value else f"{value:.9g}"


def _file_name(name: str) -> str:
    """A ply's name as part of a file's."""
    return "".join(c if c.isalnum() or c in "-_" else "_" for c in name)
