"""The parts of a new scene script between its signature and its scene: mould, plies, upper tool."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from warpdrape.commands.scene_draft import Draft

LINE = 100
"""Longest line of a script."""


def mould_part(draft: Draft) -> str:
    """Lines that make the mould."""
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


def plies_part(draft: Draft) -> str:
    """Lines that lay up the plies."""
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


def upper_part(draft: Draft, upper: str) -> str:
    """Lines that make the tool which closes on the mould, and the holder."""
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
