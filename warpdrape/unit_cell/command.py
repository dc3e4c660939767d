"""From a file of a unit cell to a fabric's card, start to end."""

from __future__ import annotations

import csv
import json
import math
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.calibration.card_file import card_place, fabric_of, write_card
from warpdrape.errors import InputError
from warpdrape.materials.card_text import card_text
from warpdrape.materials.fabric import Fabric
from warpdrape.results.run_folder import write_whole
from warpdrape.results.run_record import plain, versions
from warpdrape.unit_cell.card import areal_density, card_tables, thickness
from warpdrape.unit_cell.cell import FAMILIES
from warpdrape.unit_cell.cell_file import Plan, read_cell
from warpdrape.unit_cell.loading import ShearCurve, TensionTable, pull, shear
from warpdrape.unit_cell.model import Model, build_model
from warpdrape.unit_cell.pictures import draw_cell, draw_curves

RECORD, TENSION, SHEAR = "unit_cell.json", "tension.csv", "shear.csv"
CELL, CURVES = "cell.png", "curves.png"
SAY_EVERY = 5.0
"""Seconds between lines of progress."""


@dataclass(frozen=True, eq=False)
class Simulated:
    """What came out.

    Attributes:
        plan: the cell.
        model: it in splines.
        table: tensions.
        curve: shear.
        text: of the card.
        fabric: as the card is read back.
    """

    plan: Plan
    model: Model
    table: TensionTable
    curve: ShearCurve
    text: str
    fabric: Fabric


def simulate(plan: Plan, say: Callable[[str], None] = lambda _: None) -> Simulated:
    """Load a cell, and make a card of it.

    Args:
        plan: the cell; see `read_cell`.
        say: takes lines of progress.

    Raises:
        RunFailed: the cell finds no rest.
    """
    model = build_model(plan.cell, plan.elements)
    table = pull(model, plan.loads, _progress("pulled", say))
    curve = shear(model, plan.loads, _progress("sheared", say))
    text = card_text(
        card_tables(plan, table, curve, versions()),
        f"Made by warpdrape unit_cell from {Path(plan.file).name}.\n"
        "Status of a value: measured, simulated, second-hand, inferred, assumed.",
    )
    return Simulated(plan, model, table, curve, text, fabric_of(text, plan.file))


def _progress(done: str, say: Callable[[str], None]) -> Callable[[float], None]:
    """Turn shares into lines, a few seconds apart, with the time that is left."""
    begun = shown = time.monotonic()

    def tell(share: float) -> None:
        nonlocal shown
        now = time.monotonic()
        if now - shown < SAY_EVERY or share <= 0.0:
            return
        shown = now
        left = (now - begun) * (1.0 - share) / share
        say(f"{done} {100 * share:.0f} %, {left:.0f} s left")

    return tell


def run_unit_cell(
    weave: str | os.PathLike[str],
    out: str | os.PathLike[str] | None,
    settings: Sequence[str] = (),
    *,
    dry: bool = False,
    overwrite: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> str:
    """What the command does; returns what it prints.

    Args:
        weave: a file that ends in .toml, or plain, twill or satin.
        out: the card to write; may be left out of a dry run.
        settings: NAME=VALUE each.
        dry: say what was understood, and stop.
        overwrite: replace the card.
        say: takes lines of progress.

    Raises:
        InputError: the input cannot be used, or the card cannot be written.
        RunFailed: the cell finds no rest.
    """
    path = None if dry else card_place(out, overwrite)
    plan = read_cell(weave, settings)
    if path is None:
        return understood(plan)
    say(understood(plan))
    found = simulate(plan, say)
    return f"{outcome(found)}\n\n{_write(found, path)}"


def understood(plan: Plan) -> str:
    """What the file says, and what follows from it, in words."""
    cell = plan.cell
    rows = ["".join(" │"[not up] for up in row) for row in cell.weave.matrix()]
    lines = [f"{plan.name}: {cell.weave.name} weave, {cell.weave.repeat} yarns in a repeat"]
    lines += [f"  {row.replace(' ', '■').replace('│', '·')}" for row in rows]
    for k, family in enumerate(FAMILIES):
        lines.append(
            f"{family} yarns: {1e3 * cell.width[k]:.4g} × {1e3 * cell.height[k]:.4g} mm, "
            f"{1e3 * cell.spacing[k]:.4g} mm apart, crimp {100 * cell.crimps[k]:.3g} %, EA "
            f"{cell.stiffness[k]:.4g} N, {100 * plan.fibre_share[k]:.3g} % fibres"
        )
    lines.append(
        f"ply: {1e3 * areal_density(plan):.4g} g/m², {1e3 * thickness(plan):.3g} mm thick; "
        f"locking at {math.degrees(cell.locking):.3g}°, where neighbours have their width left"
    )
    if plan.assumed:
        lines.append(f"assumed, since not given: {', '.join(plan.assumed)}")
    return "\n".join(lines)


def outcome(found: Simulated) -> str:
    """What came out, in words."""
    table, curve = found.table, found.curve
    largest = table.tensions[:, -1, -1]
    both = [100 * axis[-1] for axis in table.strains]
    lines = [
        f"tension at {both[0]:.3g} and {both[1]:.3g} % strain: warp {largest[0]:.4g}, weft "
        f"{largest[1]:.4g} N per yarn"
    ]
    for degrees in (10, 20, 30, 40, 50, 60):
        if math.radians(degrees) <= curve.angles[-1]:
            couple = 1e3 * np.interp(math.radians(degrees), curve.angles, curve.couples)
            lines.append(f"shear couple at {degrees}°: {couple:.3g} N·mm per cell")
    lines.append(f"shear ends at {math.degrees(curve.angles[-1]):.3g}°: {curve.end}")
    if curve.locking is not None:
        lines.append(
            f"locking, where neighbours have their width left: {math.degrees(curve.locking):.3g}°"
        )
    return "\n".join(lines)


def _write(found: Simulated, path: Path) -> str:
    """Write everything; the card last, so that it is never there without the rest."""
    folder = path.with_name(f"{path.stem}_unit_cell")
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder} cannot be made ({error.strerror}): move it away") from error
    draw_cell(found.plan, found.model, found.curve, folder / CELL)
    draw_curves(found.plan, found.table, found.curve, folder / CURVES)
    _write_table(folder / TENSION, _tension_rows(found.table))
    _write_table(folder / SHEAR, _shear_rows(found.curve))
    text = json.dumps(record(found), indent=1, ensure_ascii=False) + "\n"
    write_whole(folder / RECORD, lambda p: p.write_text(text, encoding="utf-8", newline="\n"))
    write_card(path, found.text)
    names = ", ".join((CELL, CURVES, TENSION, SHEAR, RECORD))
    return f"Card in {path}: warpdrape fabrics {path}\nBeside it in {folder}: {names}"


def record(found: Simulated) -> dict[str, Any]:
    """Everything needed to do it again, and what came out."""
    plan = found.plan
    return {
        "given": plain(dict(plan.given)),
        "assumed": list(plan.assumed),
        "cell": plain(plan.cell),
        "loads": plain(plan.loads),
        "elements": plan.elements,
        "crimps": list(plan.cell.crimps),
        "amplitudes_m": list(plan.cell.amplitudes),
        "fibre_share": list(plan.fibre_share),
        "locking_deg": _degrees(found.curve.locking),
        "touching_deg": _degrees(found.curve.touching),
        "narrower_at_the_end": list(found.curve.narrower),
        "shear_end": found.curve.end,
        "largest_squeeze": found.table.squeeze,
        "versions": versions(),
    }


def _degrees(angle: float | None) -> float | None:
    return None if angle is None else math.degrees(angle)


def _tension_rows(table: TensionTable) -> list[list[float | str]]:
    rows: list[list[float | str]] = [
        ["strain_warp", "strain_weft", "tension_warp_n", "tension_weft_n"]
    ]
    for i, warp in enumerate(table.strains[0]):
        rows += [[warp, weft, *table.tensions[:, i, j]] for j, weft in enumerate(table.strains[1])]
    return rows


def _shear_rows(curve: ShearCurve) -> list[list[float | str]]:
    head = ["angle_deg", "couple_nm", "elastic_nm", "friction_nm", "strain_warp", "strain_weft"]
    columns = (np.degrees(curve.angles), curve.couples, curve.elastic, curve.friction)
    return [head, *(list(row) for row in np.column_stack([*columns, curve.strains]))]


def _write_table(path: Path, rows: list[list[float | str]]) -> None:
    def fill(partial: Path) -> None:
        with partial.open("w", newline="", encoding="utf-8") as file:
            shown = ([v if isinstance(v, str) else f"{v:.8g}" for v in row] for row in rows)
            csv.writer(file, lineterminator="\n").writerows(shown)

    write_whole(path, fill)
