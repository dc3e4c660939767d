"""Tables of the shapes' dimensions, from the scenes' own parameters and their words."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from pages import markdown
from runs import Runs

from warpdrape.commands.scene_library import find_script
from warpdrape.scenes.press import DIE_RADIUS, PUNCH_RADIUS

SHAPES: dict[str, tuple[str, ...]] = {
    "hemisphere": ("die_edge", "blank_size", "travel", "holder_force"),
    "tetrahedron": ("slope_deg", "point_radius", "edge_radius", "clearance"),
    "double_dome": ("dome_radius", "dome_distance", "waist", "edge_radius", "clearance"),
    "square_box": ("side", "corner_radius", "bottom_radius", "edge_radius", "clearance"),
    "prism": (
        "ridge_length",
        "slope_deg",
        "end_slope_deg",
        "ridge_radius",
        "edge_radius",
        "clearance",
    ),
}
"""The parameters that make each shape."""
PRESS = ("blank_length", "blank_width", "travel")
"""What each of the pressed shapes has besides."""
UNITS = {"[m]": (1e3, " mm"), "[deg]": (1.0, "°"), "[N]": (1.0, " N")}


def dimensions(name: str, _: Runs) -> str:
    """The dimensions of a shape, with their defaults."""
    rows = []
    if name == "hemisphere":
        rows += [
            ["", f"{1e3 * PUNCH_RADIUS:g} mm", "radius of the punch"],
            ["", f"{1e3 * DIE_RADIUS:g} mm", "radius of the die's hole"],
        ]
    script = find_script(name)
    parameters = script.parameters
    for each in (*SHAPES[name], *(PRESS if name != "hemisphere" else ())):
        words = parameters[each].description.rstrip(".")
        unit = next(unit for unit in UNITS if words.endswith(unit))
        factor, suffix = UNITS[unit]
        default = parameters[each].default
        if default is None:  # the scene's own, for its stack
            default = script.build().parameters[each]
        rows.append(
            [f"`{each}`", f"{factor * default:g}{suffix}", words.removesuffix(unit).strip()]
        )
    return markdown(("parameter", "default", "meaning"), rows)


def tables() -> dict[str, tuple[str, Callable[[Runs], str]]]:
    """A table of dimensions for each shape's page."""
    return {
        f"{name}_dimensions": (f"benchmarks/{name}.md", partial(dimensions, name))
        for name in SHAPES
    }
