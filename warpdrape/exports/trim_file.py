"""Trim curves from files: closed polylines in space, in the run's coordinates."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.blanks.dxf_curves import read_drawing
from warpdrape.errors import InputError, one_of
from warpdrape.optional import needed

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
"""Units of length that a file may be in → metres."""
FLAT = 1e-5
"""How far the chords of a curve in a DXF file may lie off it [m]."""
_COLUMN = re.compile(r"([xyz])_(m|cm|mm)")


def read_curves(path: Path) -> list[np.ndarray]:
    """Read closed curves.

    Args:
        path: ``.dxf``, ``.csv`` or ``.json``.

    Returns:
        loops [m], each shape [n, 3], the first point not repeated at the end.

    Raises:
        InputError: if there is no such file, or it holds something else.
    """
    readers = {".dxf": _read_dxf, ".csv": _read_csv, ".json": _read_json}
    if not path.is_file():
        raise InputError(
            f"trim = {path} does not exist: give a file, a side such as z<-20mm, or tool:NAME"
        )
    kind = one_of("kind of trim file", path.suffix.lower(), readers)
    try:
        loops = [np.asarray(loop, float) for loop in readers[kind](path)]
    except InputError:
        raise
    except (OSError, ValueError, TypeError, KeyError, OverflowError, RecursionError) as error:
        raise InputError(f"trim = {path} cannot be read: {error}") from error
    if not loops:
        raise InputError(f"trim = {path} holds no closed curve")
    return [_checked(loop, path, number) for number, loop in enumerate(loops, 1)]


def _checked(loop: np.ndarray, path: Path, number: int) -> np.ndarray:
    if loop.ndim != 2 or loop.shape[1] != 3 or not np.isfinite(loop).all():
        raise InputError(f"trim = {path}: curve {number} must be points of three finite numbers")
    different = np.any(loop != np.roll(loop, -1, axis=0), axis=1)
    loop = loop[different]  # neither repeated points nor the first one again at the end
    if len(loop) < 3:
        raise InputError(f"trim = {path}: curve {number} must have three points or more")
    return loop


def _read_csv(path: Path) -> Iterable[np.ndarray]:
    """Columns x, y and z with their unit, and ``loop`` where there are several."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        names, *rows = [[cell.strip() for cell in row] for row in csv.reader(file) if row]
    found = [_COLUMN.fullmatch(name) for name in names]
    columns = {match[1]: k for k, match in enumerate(found) if match}
    units = {match[2] for match in found if match}
    if set(columns) != set("xyz") or len(units) != 1:
        raise InputError(
            f"trim = {path} has columns {', '.join(names)}: give x_mm, y_mm and z_mm (or _m, _cm), "
            "and loop where there are several curves"
        )
    points = np.array([[float(row[columns[axis]]) for axis in "xyz"] for row in rows])
    points = points.reshape(-1, 3) * UNITS[units.pop()]
    if "loop" not in names:
        return [points]
    of = [row[names.index("loop")] for row in rows]
    return [points[[k for k, name in enumerate(of) if name == loop]] for loop in dict.fromkeys(of)]


def _read_json(path: Path) -> Iterable[np.ndarray]:
    """``{"unit": "mm", "loops": [[[x, y, z], …], …]}``."""
    data: Any = json.loads(path.read_text("utf-8"))
    if not isinstance(data, dict) or not isinstance(data.get("loops"), list):
        raise InputError(f'trim = {path} must be {{"unit": "mm", "loops": [[[x, y, z], …], …]}}')
    factor = UNITS[one_of("unit", data.get("unit"), UNITS)]
    return [np.array(loop, float) * factor for loop in data["loops"]]


def _read_dxf(path: Path) -> Iterable[np.ndarray]:
    """Closed curves, those of lines and arcs that meet too; millimetres where none is stated."""
    ezdxf = needed("ezdxf", "dxf")
    try:
        unit = None if ezdxf.readfile(path).units else "mm"
    except ezdxf.DXFError as error:
        raise InputError(f"trim = {path} cannot be read: {error}") from error
    loops = read_drawing("trim", path, flat=FLAT, unit=unit).loops
    if not loops:
        raise InputError(
            f"trim = {path} holds no closed polyline, spline, circle or ellipse: join its lines"
        )
    return loops
