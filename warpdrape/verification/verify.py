"""``warpdrape verify``: every case with a known answer, as a table, with figures."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path

from warpdrape.errors import InputError
from warpdrape.verification.case import FAILED, OK, SHORT, CaseResult

TABLE = "verification.md"
RECORD = "verification.json"
FIGURE = "verification.png"
HEADINGS = ("case", "measured", "exact", "error", "limit", "")


def verify(
    quick: bool, out: str | os.PathLike, show: Callable[[CaseResult], None] | None = None
) -> list[CaseResult]:
    """Run the cases and write table, record and figures to a folder.

    Args:
        quick: coarse meshes and fewer of them, in less than a minute.
        out: the folder; made if it is not there.
        show: called with every result as it comes.

    Returns:
        All results; ``verdict`` says of each how it went.
    """
    folder = Path(out)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"out = {folder} cannot be made ({error.strerror}): give another folder"
        ) from error
    results = []
    for group in _groups(quick, folder):
        for result in group:
            results.append(result)
            if show is not None:
                show(result)
    (folder / TABLE).write_text(markdown(results), encoding="utf-8")
    derived = ("error", "passed", "verdict")
    record = [asdict(r) | {name: getattr(r, name) for name in derived} for r in results]
    (folder / RECORD).write_text(json.dumps(record, indent=1, ensure_ascii=False) + "\n", "utf-8")
    _draw(results, folder / FIGURE)
    return results


def main(quick: bool, out: str | os.PathLike) -> int:
    """Verify, print the table as it grows, and return the exit status: 1 if a case failed.

    A case that is known to miss its limit, and is no worse than known, is shown and counted as
    SHORT; it does not fail the command, which would then never tell a regression.
    """
    started = time.perf_counter()
    print(_line(HEADINGS))
    results = verify(quick, out, lambda result: print(_line(_cells(result)), flush=True))
    took = time.perf_counter() - started
    print(f"\n{_count(results)}; {took:.0f} s; table and figures in {out}")
    return 1 if any(result.verdict == FAILED for result in results) else 0


def _count(results: Sequence[CaseResult]) -> str:
    """Say in words how many checks went how."""
    number = {word: sum(r.verdict == word for r in results) for word in (OK, SHORT, FAILED)}
    parts = [f"{len(results)} checks: {number[OK]} within their limits"]
    if number[SHORT]:
        parts.append(f"{number[SHORT]} SHORT of theirs, as known (see docs/verification.md)")
    if number[FAILED]:
        parts.append(f"{number[FAILED]} FAILED")
    return ", ".join(parts)


def _groups(quick: bool, folder: Path) -> Iterator[Iterable[CaseResult]]:
    """The cases, a group at a time; the cheap ones first."""
    from warpdrape.verification import (
        bending,
        bulge,
        compaction,
        coupons,
        drape,
        flange,
        friction,
        hypoelastic,
        invariance,
        mechanics,
        nets,
        prepreg,
        rubber,
        sphere_net,
        unit_cell,
        wrinkling,
        yarns,
    )

    yield mechanics.mechanics(quick)
    yield bending.bending(quick)
    yield friction.friction(quick)
    yield compaction.compaction(quick)
    yield unit_cell.unit_cell(quick)
    yield nets.nets(quick)
    yield bulge.bulge(quick)
    yield rubber.rubber_sheets(quick)
    yield wrinkling.stretched_sheets(quick)
    yield flange.flange(quick)
    yield drape.drape(quick)
    yield invariance.invariance(quick)
    yield hypoelastic.hypoelastic(quick)
    yield yarns.yarns(quick)
    yield coupons.biaxial_tension(quick, folder)
    yield coupons.picture_frame(quick, folder)
    yield prepreg.prepreg(quick, folder)
    yield coupons.bias_extension(quick)
    if not quick:
        yield coupons.convergence()
    yield sphere_net.sphere_net(quick)


def markdown(results: Sequence[CaseResult]) -> str:
    """The table of the documentation."""
    rows = [HEADINGS, ("---",) * len(HEADINGS), *(_cells(result) for result in results)]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows) + "\n"


def _cells(result: CaseResult) -> tuple[str, ...]:
    unit = "" if result.unit == "-" else f" {result.unit}"
    suffix = "" if result.relative else unit

    def off(value: float) -> str:
        return f"{100.0 * value:.3g} %" if result.relative else f"{value:.3g}{suffix}"

    return (
        result.case,
        f"{result.measured:.6g}{unit}",
        f"{result.exact:.6g}{unit}",
        off(result.error),
        off(result.limit),
        result.verdict,
    )


def _line(cells: Sequence[str]) -> str:
    widths = (72, 16, 16, 11, 9, 6)
    first, *others = (f"{c:{w}}" for c, w in zip(cells, widths, strict=True))
    return f"{first} {' '.join(others)}".rstrip()


def _used(result: CaseResult) -> float:
    """Error over limit, within what a logarithmic scale shows; a limit may be zero."""
    if result.limit == 0.0:
        return 1e-9 if result.error == 0.0 else 10.0
    return max(result.error / result.limit, 1e-9)


def _draw(results: Sequence[CaseResult], path: Path) -> None:
    """Draw every error over its limit, on one logarithmic scale."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 1.0 + 0.22 * len(results)), dpi=120, layout="constrained")
    axes = figure.add_subplot()
    used = [_used(result) for result in results]
    colors = [{OK: "C0", SHORT: "C1", FAILED: "C3"}[result.verdict] for result in results]
    axes.barh(range(len(results)), used, left=1e-9, color=colors, height=0.6)
    axes.set_yticks(range(len(results)), [result.case for result in results], fontsize=7)
    axes.axvline(1.0, color="k", lw=1)
    axes.set_xscale("log")
    axes.margins(y=0.01)
    axes.invert_yaxis()
    axes.set_xlabel("error over limit")
    figure.savefig(path)
