"""The text of a new scene script: short, commented, and built of public names only."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

LINE = 100
"""Longest line of a script."""
CLOSING = 2.0
"""Time in which a press closes on a prepreg, where nothing is said [s]."""


@dataclass(frozen=True)
class Draft:
    """What a script is written from; paths as the script gives them, from its own folder.

    Attributes:
        name: of the scene.
        mould: path of the mould's file; "" for a stand-in.
        units: of the file, where it states none; else "".
        unit: of the file in words.
        up: the file's direction that is up.
        kind: "female" or "male".
        has_rim: whether a holder can be had.
        blank: path of a drawing; "" for a rectangle.
        blank_unit: of the drawing, and whether it states it.
        states_unit: whether the drawing does.
        layer: of the drawing; "" for all.
        centred: whether the drawing is moved onto the mould.
        sizes: of a rectangle, along x and y [m].
        angles: of the warp [deg].
        fabric: name or path.
        own_fabric: whether that is a path.
        thickness: of a ply [m].
        edge: of the mesh [m].
        duration: of the stroke [s].
        force: of the holder [N]; 0 for none.
        wet: whether the fabric has a viscous matrix, which asks for the press's time.
    """

    name: str
    mould: str
    units: str
    unit: str
    up: str
    kind: str
    has_rim: bool
    blank: str
    blank_unit: str
    states_unit: bool
    layer: str
    centred: bool
    sizes: tuple[float, float]
    angles: Sequence[float]
    fabric: str
    own_fabric: bool
    thickness: float
    edge: float
    duration: float
    force: float
    wet: bool


def script_text(draft: Draft) -> str:
    """The script."""
    upper = "punch" if draft.kind == "female" else "die"
    parts = [_head(draft), _signature(draft), _mould(draft), _plies(draft), _upper(draft, upper)]
    return "".join([*parts, _scene(draft, upper)])


def _head(draft: Draft) -> str:
    count = len(draft.angles)
    plies = "a ply" if count == 1 else f"{count} plies"
    over = "into" if draft.kind == "female" else "over"
    mould = draft.mould or "a stand-in mould"
    first = ["from dataclasses import replace"]
    if draft.mould or draft.blank or draft.own_fabric:
        first.append("from pathlib import Path")
    names = [
        "Limits",
        "Mould",
        "Numerics",
        "Ply",
        "Scene",
        "Stroke",
        *([] if draft.mould else ["Tool"]),
    ]
    lines = [
        f'"""{draft.name}: {plies} pressed {over} {mould}.',
        "",
        "Written by warpdrape new; yours to change.",
        "",
        f"    warpdrape check {draft.name}.py       what will be run, in words and as a picture",
        f"    warpdrape run {draft.name}.py         the result goes to runs/{draft.name}",
        f"    warpdrape judge runs/{draft.name}     against the limits at the end of this file",
        '"""',
        "",
        *first,
        "",
        f"from warpdrape import {', '.join(names)}, lay_up, stack_top",
    ]
    if not draft.mould:
        lines.append("from warpdrape.tools.shaped import double_dome_cavity")
    lines += ["from warpdrape.units import deg, mm, ms", ""]
    if draft.mould or draft.blank or draft.own_fabric:
        lines += ["HERE = Path(__file__).parent", '"""Files are looked for beside this one."""', ""]
    return "\n".join([*lines, ""])


def _signature(draft: Draft) -> str:
    angles = ", ".join(f"{angle:g}" for angle in draft.angles)
    angles += "," if len(draft.angles) == 1 else ""
    fabric = f'str(HERE / "{draft.fabric}")' if draft.own_fabric else f'"{draft.fabric}"'
    holder = ""
    told = ""
    if draft.has_rim:
        holder = f"    holder_force: float = {draft.force:g},\n"
        told = "        holder_force: on the blank holder, 0 for none [N].\n"
    closing, closes = "", ""
    if draft.wet:
        closing = f"    closing_time: float = {CLOSING:g},\n"
        closes = (
            "        closing_time: that the press takes for the stroke; the matrix knows it [s].\n"
        )
    return f'''
def build(
    *,
    angles: tuple[float, ...] = ({angles}),
    fabric: str = {fabric},
    edge: float = {1e3 * draft.edge:g} * mm,
    room: float = 1.5,
{holder}{closing}    duration: float = {1e3 * draft.duration:g} * ms,
    friction: float = 0.2,
    ply_friction: float = 0.3,
    fast: bool = False,
    approach: str = "semi_discrete",
) -> Scene:
    """Build the press.

    Args:
        angles: of each ply's warp from x, from the bottom up [deg].
        fabric: name of the library (warpdrape fabrics), or a .toml file.
        edge: size of the plies' mesh; half of it shows finer wrinkles in eight times the time [m].
        room: between the closed tools, over the plies' thickness together [-].
{told}{closes}        duration: of the stroke; longer if the run is not quasi-static [s].
        friction: of tools on plies [-].
        ply_friction: between plies [-].
        fast: a quarter of the time, by softer yarns; the summary says what they cost.
        approach: "semi_discrete", or "fishnet" for a net without forces, in seconds.
    """
'''


def _mould(draft: Draft) -> str:
    if not draft.mould:
        return f"""\
    # A stand-in, until yours is here:
    #     mould = Mould.from_file(HERE / "part.step", tolerance={_tolerance(draft)} * mm)
    # with HERE = Path(__file__).parent; files that state no unit, such as STL, need units="mm".
    cavity = double_dome_cavity(
        50 * mm,
        120 * mm,
        40 * mm,
        depth=60 * mm,
        edge_radius=10 * mm,
        outer_radius=200 * mm,
        facet=4 * mm,
    )
    mould = Mould.of(Tool(name="mould", surface=cavity))
"""
    options = [f'HERE / "{draft.mould}"']
    if draft.units:
        options.append(f'units="{draft.units}"')
        words = f"Its numbers are in {draft.unit}, as was said."
    else:
        options.append(f"tolerance={_tolerance(draft)} * mm")
        words = (
            f"The file states its unit, {draft.unit}. Facets lie within a tenth of a ply's "
            "thickness of its surfaces."
        )
    if draft.up != "z":
        options.append(f'up="{draft.up}"')
        words += f" Its direction {draft.up} is turned up."
    options.append(f'kind="{draft.kind}"')
    where = "The mould. It stays where its file has it, and so does the result. "
    told = _comment(where + words).lstrip("\n")
    return f"{told}    mould = {_call('Mould.from_file', options)}\n"


def _plies(draft: Draft) -> str:
    loop = "for k, angle in enumerate(angles)"
    if draft.blank:
        options = [
            'f"ply_{k}"',
            "fabric",
            f'HERE / "{draft.blank}"',
            "edge=edge",
            "warp_angle=angle * deg",
        ]
        if not draft.states_unit:
            options.append(f'unit="{draft.blank_unit}"')
        if draft.layer:
            options.append(f'layer="{draft.layer}"')
        said = "states its unit" if draft.states_unit else "is, as was said, in"
        words = f"The blanks, from the bottom up. The drawing {said} {draft.blank_unit}"
        if draft.centred:
            options.append("centre=mould.middle")
            words += "; its middle is laid over the mould's"
        words += ". Gaps up to 0.1 mm are welded (weld=)."
        call = _call("Ply.from_dxf", options, indent=8)
    else:
        x, y = (f"{1e3 * size:g} * mm" for size in draft.sizes)
        words = "The blanks, from the bottom up. Ply.from_dxf reads a drawing in place of corners."
        options = ['f"ply_{k}"', "fabric", "corners", "edge=edge", "warp_angle=angle * deg"]
        corners = (
            f"    (x, y), a, b = mould.middle, 0.5 * {x}, 0.5 * {y}\n"
            "    corners = [(x - a, y - b), (x + a, y - b), (x + a, y + b), (x - a, y + b)]\n"
        )
        call = _call("Ply.polygon", options, indent=8)
        return (
            f"{_comment(words)}{corners}    plies = [\n        {call}\n        {loop}\n    ]\n"
            "    plies = lay_up(plies, z=mould.level)\n"
            "    thickness = stack_top(plies) - mould.level\n"
        )
    return (
        f"{_comment(words)}    plies = [\n        {call}\n        {loop}\n    ]\n"
        "    plies = lay_up(plies, z=mould.level)\n"
        "    thickness = stack_top(plies) - mould.level\n"
    )


def _upper(draft: Draft, upper: str) -> str:
    early = (0.3, 0.3) if len(draft.angles) == 1 else (0.15, 0.85)
    words = (
        f"The {upper} is the mould's face moved off it by the room for the plies. It starts just "
        "above them, and ends closed."
    )
    brake = f"ramp={early[0]}, brake={early[1]}"
    text = (
        f"{_comment(words)}"
        f'    {upper} = mould.counterpart("{upper}", gap=room * thickness)\n'
        f"    travel = stack_top(plies) - {upper}.vertices[:, 2].min()\n"
        f"    down = Stroke(travel=(0.0, 0.0, -travel), duration=duration, {brake})\n"
        f"    {upper} = replace({upper}.moved((0.0, 0.0, travel)), motion=down)\n"
        f"    tools = [mould.tool, {upper}]\n"
    )
    if not draft.has_rim:
        return text + _comment("The mould has no flat rim, on which a blank holder could press.")
    side = "down onto the mould's rim" if draft.kind == "female" else f"up against the {upper}"
    return text + (
        f"    if holder_force > 0.0:  # it presses the plies {side}\n"
        "        tools.append(mould.holder(thickness=thickness, force=holder_force))\n"
    )


def _scene(draft: Draft, upper: str) -> str:
    process = ""
    if draft.wet:
        process = (
            "        # The matrix's clock; docs/prepreg.md says more, of temperatures too.\n"
            "        process_duration=1.2 * closing_time,\n"
        )
    return f'''
    return Scene(
        name="{draft.name}",
        plies=plies,
        tools=tools,
        duration=1.2 * duration,  # the {upper} stands still at the end, and the plies come to rest
{process}        friction=friction,
        ply_friction=ply_friction,
        gravity=(0.0, 0.0, -9.81),
        numerics=Numerics.for_accuracy("standard") if fast else Numerics(),
        # What the part may have of each defect; see docs/defects.md. None is not judged.
        limits=Limits(
            wrinkle_amplitude=0.5 * mm,
            bridge_gap=1.0 * mm,
            shear_deg=50.0,
            past_locking_area=0.0,
            failed_yarn_area=0.0,
        ),
        approach=approach,
    )


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
'''


def _tolerance(draft: Draft) -> str:
    return f"{1e2 * draft.thickness:.2g}"


def _comment(words: str) -> str:
    lines = textwrap.wrap(words, LINE - 6)
    return "\n" + "".join(f"    # {line}\n" for line in lines)


def _call(function: str, options: Sequence[str], indent: int = 4) -> str:
    """A call on one line, or an argument a line where that is too long."""
    whole = f"{function}({', '.join(options)})"
    if len(whole) + indent + 8 <= LINE:
        return whole
    inner = " " * (indent + 4)
    rows = "".join(f"{inner}{option},\n" for option in options)
    return f"{function}(\n{rows}{' ' * indent})"
