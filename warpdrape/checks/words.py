"""What a scene will do, in words."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import shapely

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import longest_sides
from warpdrape.checks.first_contact import Touch, first_touches
from warpdrape.checks.roundings import smallest_rounding
from warpdrape.contact.closing import narrowest_gaps
from warpdrape.setup import Setup
from warpdrape.tools.floating import Float
from warpdrape.tools.mould_face import borders, plan
from warpdrape.tools.tool import Tool
from warpdrape.units import celsius
from warpdrape.wording import brief, size

ROUGH = 0.05
"""How far a radius is told from a side of triangles: facets give it within some per cent [-]."""
BEYOND = 1e-4
"""How far a ply may go beyond a holder before it is worth a word [m]."""
FEW = 1e-3
"""Length of sharp edges that is worth a word [m]."""


def geometry_words(scene: Setup) -> str:
    """Tools, plies, what holds them, gaps and first contacts, a section each."""
    parts = [
        ("Tools", [_tool(scene, tool) for tool in scene.tools] or ["none"]),
        ("Plies, from the bottom up", [_ply(ply) for ply in scene.plies]),
        ("Held, pulled and pressed", [brief(each) for each in _acting(scene)]),
        ("First contacts with the flat plies", [_touch(t) for t in first_touches(scene)]),
        ("Room between tools", list(_gaps(scene))),
    ]
    texts = [
        "\n".join([f"{title}:", *(f"  {row}" for row in rows)]) for title, rows in parts if rows
    ]
    return "\n\n".join(texts)


def side_of(ply: Ply) -> float:
    """Longest side of a ply's triangles, of the middle one of them [m]."""
    return float(np.median(longest_sides(ply.rest_points, ply.mesh.triangles)))


def cautions(scene: Setup) -> list[str]:
    """What is worth a second thought, though a run would not refuse it."""
    return [*_too_round(scene), *_too_small(scene)]


def _acting(scene: Setup) -> list[object]:
    return [*scene.clamps, *scene.pressures, *scene.springs]


def _box(scene: Setup) -> tuple[np.ndarray, np.ndarray]:
    points = np.concatenate([ply.rest_points[:, :2] for ply in scene.plies])
    return points.min(axis=0), points.max(axis=0)


def _tool(scene: Setup, tool: Tool) -> str:
    rounding = smallest_rounding(tool, *_box(scene))
    shape = f"{size(tool.vertices)}, {len(tool.triangles):,} facets"
    source = f" from {tool.surface.source}" if tool.surface.source else ""
    if math.isfinite(rounding.radius):
        shape += f", smallest radius {1e3 * rounding.radius:.3g} mm at {_at(rounding.place)}"
    if rounding.sharp > FEW:
        shape += f", sharp edges of {1e3 * rounding.sharp:.0f} mm in all"
    turns = "" if tool.turn is None else f"; {brief(tool.turn)}"
    speed = ""
    if not isinstance(tool.motion, Float) and tool.peak_speed > 0.0:
        speed = f", at up to {tool.peak_speed:.2g} m/s"
    warmth = _degrees(tool.temperature)
    return f"{tool.name}{source}: {shape}; {_motion(tool)}{speed}{turns}{warmth}"


def _degrees(kelvin: float | None) -> str:
    return "" if kelvin is None else f"; at {kelvin - celsius(0.0):.4g} °C"


def _motion(tool: Tool) -> str:
    if isinstance(tool.motion, Float):
        force = brief(tool.motion).removeprefix("Float: ")
        return f"floats, {force}"
    return "stands still" if tool.motion.peak_speed == 0.0 else brief(tool.motion)


def _ply(ply: Ply) -> str:
    fabric, warp = ply.fabric, math.degrees(ply.warp_angle)
    weft = warp + math.degrees(fabric.yarn_angle)
    return (
        f"{ply.name}: {size(ply.mesh.vertices)}, {fabric.name}, {1e3 * fabric.thickness:.3g} mm, "
        f"{1e3 * fabric.areal_density:.4g} g/m²; warp at {warp:.4g}° from x, weft at {weft:.4g}°; "
        f"{len(ply.mesh.triangles):,} triangles with sides of {1e3 * side_of(ply):.3g} mm; its "
        f"middle at z {1e3 * ply.z:.4g} mm{_degrees(ply.warmth)}"
    )


def _touch(touch: Touch) -> str:
    if touch.place is None:
        if math.isfinite(touch.gap):
            return f"{touch.tool}: none while the plies lie flat, {1e3 * touch.gap:.3g} mm off them"
        return f"{touch.tool}: none while the plies lie flat, beside them"
    where = f"{touch.ply} at {_at(touch.place)}"
    if touch.time == 0.0:
        return f"{touch.tool}: in touch with {where} from the start"
    way = f" after {1e3 * touch.way:.3g} mm of its way" if touch.way > 0.0 else ""
    return f"{touch.tool}: touches {where} at {1e3 * touch.time:.3g} ms{way}"


def _gaps(scene: Setup) -> Iterator[str]:
    for closing in narrowest_gaps(scene):
        one, other = closing.tools
        if closing.lacks:
            yield f"{closing}"
            continue
        share = closing.gap / closing.thickness
        yield (
            f"{one} and {other}: {1e3 * closing.gap:.3g} mm at the least, at "
            f"{1e3 * closing.time:.4g} ms, {_at(closing.place)}; plies that lie there are "
            f"{1e3 * closing.thickness:.3g} mm thick: {share:.2f} times that"
        )


def _too_round(scene: Setup) -> Iterator[str]:
    """Tools that bend a ply more sharply than its triangles can follow."""
    side = max(side_of(ply) for ply in scene.plies)
    found = {}
    for tool in scene.tools:
        if isinstance(tool.motion, Float):  # its rounding is there to let plies slide out
            continue
        rounding = smallest_rounding(tool, *_box(scene))
        if rounding.radius < (1.0 - ROUGH) * side:
            found[tool.name] = rounding
    if found:
        named = ", ".join(
            f"{1e3 * each.radius:.3g} mm of {name!r} at {_at(each.place)}"
            for name, each in found.items()
        )
        least = min(each.radius for each in found.values())
        yield (
            f"triangles with sides of {1e3 * side:.3g} mm span radii as chords: {named}; to see "
            f"what happens there give the plies sides of {1e3 * least:.2g} mm or less"
        )


def _too_small(scene: Setup) -> Iterator[str]:
    """Plies that go beyond a floating ring that presses them: a blank holder of one piece."""
    for tool in scene.tools:
        rings = borders(np.asarray(tool.triangles)) if isinstance(tool.motion, Float) else []
        if len(rings) < 2:
            continue
        outer = plan(tool.surface.mesh, np.ones(len(tool.triangles), dtype=bool))
        for ply in scene.plies:
            beyond = float(shapely.distance(shapely.points(ply.rest_points[:, :2]), outer).max())
            if beyond > BEYOND:
                yield (
                    f"ply {ply.name!r} goes {1e3 * beyond:.3g} mm beyond tool {tool.name!r}, whose "
                    "force it does not feel there"
                )


def _at(place: np.ndarray) -> str:
    return "(" + ", ".join(f"{v:.4g}" for v in np.round(1e3 * np.asarray(place), 2) + 0.0) + ") mm"
