"""The one call that writes a run, or several, as a report."""

from __future__ import annotations

import base64
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.errors import InputError, RunFailed
from warpdrape.report.curves import curves
from warpdrape.report.markup import Html, element, joined
from warpdrape.report.packing import Blocks
from warpdrape.report.page import licences, page
from warpdrape.report.record import FILES, differing, digests, record_of, record_section
from warpdrape.report.rest_match import match_plies
from warpdrape.report.run_data import PlyFrames, RunFrames, pack_run, read_frames
from warpdrape.report.words import result_section, side_by_side, verdict_words
from warpdrape.results.quantities import QUANTITIES
from warpdrape.results.read_run import RunReader
from warpdrape.results.run_folder import COUPON_PLOT, REPORT, SCENE, write_whole
from warpdrape.results.run_record import versions

COMPARISON = "comparison.html"
"""File in the current folder that takes a report on several runs."""
MOST_RUNS = 6
"""Runs of one report: more are too small to be seen beside each other."""
COLOURS = 256
"""Colours of a scale."""
PNG = b"\x89PNG\r\n\x1a\n"
"""How a picture of that kind begins."""
_SCALES = {"plain": "viridis", "difference": "RdBu_r"}
_MOVES = 1e-5
"""Way from which on a tool counts as moving [m]."""


@dataclass(frozen=True, eq=False)
class _Run:
    """What a report says of a run.

    Attributes:
        name: how the report calls it.
        reader: the run folder.
        frames: shown in it.
        record: what its ``run.json`` holds.
    """

    name: str
    reader: RunReader
    frames: RunFrames
    record: dict[str, Any] | None

    @property
    def folder(self) -> Path:
        """The run folder."""
        return self.reader.folder


def write_report(
    runs: Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str] | None = None,
    *,
    frames: int | None = None,
) -> Path:
    """Write runs as one HTML file that needs no network; return the file.

    Args:
        runs: their folders; with several ones differences are from the first.
        out: the file; if None ``report.html`` in the folder of a single run, and
            ``comparison.html`` in the current folder for several.
        frames: of each run in the 3-D view, at most; if None, as many as keep the file small.

    Raises:
        InputError: if a folder is none, unfinished or damaged, there are too many, or the file
            cannot be written.
    """
    if isinstance(runs, str | os.PathLike):
        runs = [runs]
    if not 1 <= len(runs) <= MOST_RUNS:
        raise InputError(f"{len(runs)} runs: a report takes 1 to {MOST_RUNS}; leave some out")
    folders = [Path(run) for run in runs]
    path = _place(folders, out)
    names = _names(folders)
    read = [_read(f, n, frames, 1.0 / len(runs)) for f, n in zip(folders, names, strict=True)]
    text = _text(read)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, lambda partial: partial.write_text(text, "utf-8", newline="\n"))
    except (OSError, RunFailed) as error:
        raise InputError(f"out = {path} cannot be written ({error}): give another place") from error
    return path


def _place(folders: Sequence[Path], out: str | os.PathLike[str] | None) -> Path:
    if out is None:
        return folders[0] / REPORT if len(folders) == 1 else Path(COMPARISON)
    path = Path(out)
    if path.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"out = {path} must end in .html")
    if path.is_dir():
        raise InputError(f"out = {path} is a folder: give the name of a file")
    return path


def _names(folders: Sequence[Path]) -> list[str]:
    """Short names of folders that tell them apart: their last parts, as many as that takes."""
    parts = [folder.resolve().parts for folder in folders]
    for count in range(1, max(map(len, parts)) + 1):
        names = ["/".join(each[-count:]) for each in parts]
        if len(set(names)) == len(names):
            return names
    raise InputError(f"run folder {folders[0]} is given twice: give each once")


def _read(folder: Path, name: str, frames: int | None, share: float) -> _Run:
    reader = RunReader(folder)
    return _Run(name, reader, read_frames(reader, frames, share), record_of(folder))


def _text(runs: Sequence[_Run]) -> str:
    blocks = Blocks()
    told = []
    for run in runs:
        entry = {"name": run.name, **pack_run(run.frames, blocks), **_over_time(run)}
        entry["plots"] = curves(run.reader.history, run.frames)
        if run is not runs[0]:
            entry["matches"] = match_plies(run.frames.plies, runs[0].frames.plies, blocks)
        told.append(entry)
    sections = [_results(runs), _made(runs, blocks)]
    sections.append(("about", "About this file", _about(runs)))
    data = {"runs": told, "fields": _fields(runs), "colours": _colours()}
    return page(_title(runs), _lines(runs), sections, data, blocks.texts)


def _title(runs: Sequence[_Run]) -> str:
    if len(runs) > 1:
        return " and ".join([", ".join(run.name for run in runs[:-1]), runs[-1].name])
    record = runs[0].record
    scene = record.get("scene") if record else None
    return f"{scene}: {runs[0].name}" if scene and scene != runs[0].name else runs[0].name


def _lines(runs: Sequence[_Run]) -> list[Html]:
    """How each run ended, and how many warnings it has; what a reader must know first."""
    lines = []
    for run in runs:
        summary, several = run.reader.summary, len(runs) > 1
        words = f"{run.name}: {verdict_words(summary)}" if several else verdict_words(summary)
        count = len(summary["warnings"])
        if count:
            words += f". {count} warning{'s' if count > 1 else ''}, below"
        kind = "verdict" if summary["status"] == "completed" else "verdict failed"
        lines.append(element("p", words, class_=kind))
    return lines


def _over_time(run: _Run) -> dict[str, Any]:
    """Times of the frames [s], and the ways of tools that move [mm]."""
    history, frames = run.reader.history, run.frames.frames
    ways = {
        tool.name: history[f"{tool.name}_displacement_m"]
        for tool in run.frames.tools
        if f"{tool.name}_displacement_m" in history
    }
    travel = {name: (1e3 * w[frames]).tolist() for name, w in ways.items() if np.ptp(w) > _MOVES}
    return {"times": history["time_s"][frames].tolist(), "travel": travel}


def _fields(runs: Sequence[_Run]) -> list[dict[str, Any]]:
    """Fields that some ply has, with one scale for all runs."""
    plies: list[PlyFrames] = [ply for run in runs for ply in run.frames.plies]
    found = []
    for name, quantity in QUANTITIES.items():
        values = [ply.values[name].ravel() for ply in plies if name in ply.values]
        if not values:
            continue
        every = np.concatenate(values)
        scale = quantity.scale(every if quantity.signed else np.abs(every))
        entry = {"name": name, "title": quantity.title, "unit": quantity.unit, "scale": scale}
        found.append({**entry, "signed": quantity.signed})
    return found


def _colours() -> dict[str, list[str]]:
    from matplotlib import colormaps

    return {
        name: [bytes(c[:3]).hex() for c in colormaps[of](np.linspace(0, 1, COLOURS), bytes=True)]
        for name, of in _SCALES.items()
    }


def _results(runs: Sequence[_Run]) -> tuple[str, str, Html]:
    if len(runs) == 1:
        return "result", "Result", _result(runs[0])
    names = [run.name for run in runs]
    whole = side_by_side(names, [run.reader.summary for run in runs])
    each = [_folded(run.name, _result(run)) for run in runs]
    return "result", "Results", joined([whole, *each])


def _result(run: _Run) -> Html:
    """The result of a run in words; of a coupon test its curve too."""
    words, path = result_section(run.reader.summary), run.folder / COUPON_PLOT
    picture = path.read_bytes() if path.is_file() else b""
    if not picture.startswith(PNG):
        return words
    source = f"data:image/png;base64,{base64.b64encode(picture).decode('ascii')}"
    image = Html(f'<img src="{source}" alt="curve of the coupon beside its closed form">')
    return joined([words, element("h3", "The coupon's curve"), element("p", image)])


def _made(runs: Sequence[_Run], blocks: Blocks) -> tuple[str, str, Html]:
    parts = [
        joined([record_section(run.record), digests(run.folder), _savers(run, blocks)])
        for run in runs
    ]
    if len(runs) > 1:
        parts = [_folded(run.name, part) for run, part in zip(runs, parts, strict=True)]
        title = element("h3", "What differs")
        parts.insert(0, differing([run.name for run in runs], [run.record for run in runs]))
        parts.insert(0, title)
    return "made", "How it was made", joined(parts)


def _folded(title: str, content: Html) -> Html:
    return element("details", element("summary", title), content)


def _savers(run: _Run, blocks: Blocks) -> Html:
    """Buttons that give the files of the run folder back that the page holds."""
    buttons = []
    for name in FILES:
        path = run.folder / name
        if name != SCENE and path.is_file():
            number = blocks.text(path.read_bytes())
            words = f"Save {name}"
            buttons.append(
                element("button", words, type="button", data_block=number, data_file=name)
            )
    return element("p", "This page holds the tables and records of the folder: ", *buttons)


def _about(runs: Sequence[_Run]) -> Html:
    lines = [_frames_words(run, several=len(runs) > 1) for run in runs]
    lines.append(
        "Fields are kept in 16 bits each: off by at most 1/131,068 of the way from the least to "
        "the largest value of that field in the run."
    )
    if any(run.frames.tools for run in runs):
        lines.append(
            "Distances from tools are those of the middle of a ply's thickness from the nearest "
            "facet of any tool as the run folder has it."
        )
    lines.append(
        "Yarns are drawn where they lie on the flat blank and move with it; colours of what is "
        "given in triangles are flat, those of what is given at vertices are blended."
    )
    if len(runs) > 1:
        lines.append(
            f"Differences are from {runs[0].name}, at the same point of the flat blank and the "
            "same share of the simulated time (the nearest frame). Where meshes differ, values at "
            "vertices are interpolated linearly in the triangle of the other blank that they lie "
            "in, and values in triangles are those of the triangle there; what lies beside the "
            "other blank is grey. Plies belong together by name, or by their place in the stack "
            "where no names agree."
        )
    made = ", ".join(f"{name} {version}" for name, version in versions().items())
    lines.append(f"Made on {time.strftime('%Y-%m-%d %H:%M %z')} with {made}.")
    return joined([element("ul", *(element("li", line) for line in lines)), licences()])


def _frames_words(run: _Run, *, several: bool) -> str:
    shown, of = len(run.frames.frames), run.frames.of
    who = f"{run.name}: " if several else ""
    every = f"all {of} frames" if shown == of else f"{shown} of {of} frames, evenly spaced"
    return (
        f"{who}{every}; places of plies to {1e6 * run.frames.resolution:.2g} µm (16 bits along "
        f"each side of their box); yarns every {_spacing(run)} on the blank."
    )


def _spacing(run: _Run) -> str:
    from warpdrape.results.yarn_lines import round_spacing

    return f"{1e3 * round_spacing(run.frames.plies[0].rest):g} mm"
