"""Closed curves of a DXF drawing: polylines, circles, ellipses, splines, and loose lines and arcs.

Ends that lie within a tolerance of each other are welded, as drawings have gaps.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from warpdrape.errors import InputError, nearest
from warpdrape.mesh_file import UNITS
from warpdrape.optional import needed

KINDS = ("LINE", "ARC", "LWPOLYLINE", "POLYLINE", "SPLINE", "CIRCLE", "ELLIPSE")
"""Entities that are read, in blocks too; texts, dimensions and hatches are not."""
ARCS = 16
"""Bézier curves that stand for an arc: four are 0.03 % of the radius off it."""
WELD = 1e-4
"""Gap between two ends that is closed [m]."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """What a drawing holds.

    Attributes:
        loops: closed curves [m], each shape [n, 3], the first point not repeated.
        unit: that the file states or that was given.
        states_unit: whether the file states it.
        welded: the largest gap that was closed [m].
        loose: what is wrong with a curve that is part of no closed one; "" if none is loose.
    """

    loops: list[np.ndarray]
    unit: str
    states_unit: bool
    welded: float
    loose: str


def read_drawing(
    who: str,
    path: Path,
    *,
    flat: float,
    unit: str | None = None,
    layer: str | None = None,
    weld: float = WELD,
) -> Drawing:
    """Read the closed curves of a drawing.

    Args:
        who: for errors, such as "blank".
        path: the ``.dxf``.
        flat: how far chords may lie off curves [m].
        unit: of a drawing that states none, one of `UNITS`.
        layer: the one that is read; None reads all.
        weld: gap between two ends that is closed [m].

    Raises:
        InputError: if it cannot be read, or states no unit and none is given.
    """
    ezdxf = needed("ezdxf", "dxf")
    try:
        drawing = ezdxf.readfile(path)
    except (OSError, ezdxf.DXFError, UnicodeDecodeError, ValueError) as error:
        raise InputError(f"{who} = {path} cannot be read: {error}") from error
    factor, name = _unit(who, path, drawing, unit)
    entities = _on_layer(who, path, list(_entities(drawing.modelspace())), layer)
    make = needed("ezdxf.path", "dxf").make_path
    closed: list[np.ndarray] = []
    loose: list[np.ndarray] = []
    for entity in entities:
        curve = make(entity, segments=ARCS)
        if len(curve) == 0:
            continue
        points = np.array([tuple(p) for p in curve.flattening(flat / factor)], float) * factor
        (closed if curve.is_closed else loose).append(points)
    chains, gap, fault = _chained(_once(loose, weld), weld)
    found = [_open(loop) for loop in (*closed, *chains)]
    return Drawing(found, name, drawing.units != 0, gap, fault)


def _on_layer(who: str, path: Path, entities: list[Any], layer: str | None) -> list[Any]:
    if layer is None:
        return entities
    layers = sorted({entity.dxf.layer for entity in entities})
    if layer not in layers:
        known = nearest(layer, layers)
        raise InputError(f"{who} = {path} has no curve on layer {layer!r}{known}")
    return [entity for entity in entities if entity.dxf.layer == layer]


def layers_of(path: Path) -> list[str]:
    """Layers of a drawing on which there are curves."""
    drawing = needed("ezdxf", "dxf").readfile(path)
    return sorted({entity.dxf.layer for entity in _entities(drawing.modelspace())})


def states_unit(path: Path) -> bool:
    """Whether a drawing states its unit; False too for what is no drawing."""
    ezdxf = needed("ezdxf", "dxf")
    try:
        return bool(ezdxf.readfile(path).units)
    except (OSError, ezdxf.DXFError, UnicodeDecodeError, ValueError):
        return False


def _entities(space: Any) -> Iterator[Any]:
    for entity in space:
        if entity.dxftype() == "INSERT":
            yield from _entities(entity.virtual_entities())
        elif entity.dxftype() in KINDS:
            yield entity


def _unit(who: str, path: Path, drawing: Any, given: str | None) -> tuple[float, str]:
    """Metres per unit of a drawing, and the unit's name."""
    units = needed("ezdxf", "dxf").units
    if given is not None and given not in UNITS:
        raise InputError(f"{who}: unknown unit {given!r}{nearest(given, UNITS)}")
    if drawing.units == 0:
        if given is None:
            raise InputError(
                f"{who} = {path} states no unit ($INSUNITS is 0): give one of {', '.join(UNITS)}"
            )
        return UNITS[given], given
    factor = float(units.conversion_factor(drawing.units, units.M))
    name = next((n for n, f in UNITS.items() if np.isclose(f, factor, rtol=1e-6)), "")
    name = name or units.unit_name(drawing.units)
    if given is not None and not np.isclose(UNITS[given], factor, rtol=1e-6):
        raise InputError(
            f"{who} = {path} states that it is in {name}, not in {given}: leave the unit out, or "
            "mend $INSUNITS in the drawing"
        )
    return factor, name


def _open(loop: np.ndarray) -> np.ndarray:
    """A loop without repeated points, nor the first one again at the end."""
    return loop[np.any(loop != np.roll(loop, -1, axis=0), axis=1)]


def _chained(curves: list[np.ndarray], weld: float) -> tuple[list[np.ndarray], float, str]:
    """Loose curves as closed loops, the largest gap that was closed [m], and what stays loose."""
    if not curves:
        return [], 0.0, ""
    ends = np.array([end for curve in curves for end in (curve[0], curve[-1])])
    pairs = cKDTree(ends).query_pairs(weld, output_type="ndarray").reshape(-1, 2)
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(ends), len(ends)))
    place = connected_components(graph, directed=False)[1]
    count = np.bincount(place)
    own = np.arange(0, len(ends), 2)
    hops = np.concatenate([pairs, np.stack([own, own + 1], axis=1)])
    graph = coo_array((np.ones(len(hops)), hops.T), shape=(len(ends), len(ends)))
    chain = connected_components(graph, directed=False)[1]
    bad = np.isin(chain, np.unique(chain[count[place] != 2]))
    fault = _loose_end(ends, place, count, weld) if bad.any() else ""
    pairs = pairs[~bad[pairs[:, 0]]]
    partner = np.full(len(ends), -1)
    partner[pairs[:, 0]], partner[pairs[:, 1]] = pairs[:, 1], pairs[:, 0]
    gaps = np.linalg.norm(ends[pairs[:, 0]] - ends[pairs[:, 1]], axis=1)
    loops, left = [], {k for k in range(len(curves)) if not bad[2 * k]}
    while left:
        start = end = 2 * min(left)
        parts = []
        while True:
            curve = curves[end // 2]
            left.discard(end // 2)
            parts.append((curve if end % 2 == 0 else curve[::-1])[:-1])  # the next one has its end
            end = int(partner[end ^ 1])
            if end == start:
                break
        loops.append(np.concatenate(parts))
    return loops, float(gaps.max(initial=0.0)), fault


def _once(curves: list[np.ndarray], weld: float) -> list[np.ndarray]:
    """Each curve once, where a drawing has some twice; without those that are mere dots."""
    kept: dict[tuple[int, ...], np.ndarray] = {}
    for curve in curves:
        steps = np.linalg.norm(np.diff(curve, axis=0), axis=1)
        if steps.sum() <= weld:
            continue
        ends = sorted(map(tuple, np.round(curve[[0, -1]] / weld).astype(int).tolist()))
        middle = np.round(np.average(0.5 * (curve[1:] + curve[:-1]), axis=0, weights=steps) / weld)
        kept.setdefault((*ends[0], *ends[1], *middle.astype(int).tolist()), curve)
    return list(kept.values())


def _loose_end(ends: np.ndarray, place: np.ndarray, count: np.ndarray, weld: float) -> str:
    """Say where an end meets none, or more than two meet."""
    bad = int(np.flatnonzero(count != 2)[0])
    x, y = 1e3 * ends[place == bad][0, :2]
    if count[bad] > 2:
        return (
            f"{count[bad]} curves meet at ({x:.4g}, {y:.4g}) mm: leave one outline, or put it on a "
            "layer of its own and name that"
        )
    others = ends[place != bad]
    far = np.linalg.norm(others - ends[place == bad][0], axis=1).min(initial=np.inf)
    return (
        f"a curve ends at ({x:.4g}, {y:.4g}) mm, and the next end is {1e3 * far:.3g} mm away, more "
        f"than the {1e3 * weld:.3g} mm that are welded: close the outline, weld more, or name the "
        "outline's layer"
    )
