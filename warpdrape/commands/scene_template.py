"""The text of a new scene script: short, commented, and built of public names only."""

from __future__ import annotations

from warpdrape.commands.scene_draft import Draft
from warpdrape.commands.scene_parts import mould_part, plies_part, upper_part

CLOSING = 2.0
"""Time in which a press closes on a prepreg, where nothing is said [s]."""


def script_text(draft: Draft) -> str:
    """The script."""
    upper = "punch" if draft.kind == "female" else "die"
    parts = [_head(draft), _signature(draft), mould_part(draft), plies_part(draft)]
    return "".join([*parts, upper_part(draft, upper), _scene(draft, upper)])


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
    closing, closes, accuracy = "", "", "standard"
    if draft.wet:
        accuracy = "reference"  # shear would lag behind softer yarns
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
    accuracy: str = "{accuracy}",
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
        accuracy: "draft", "standard" or "reference", four times as long; softer yarns make the
            first two fast, and the summary says what they may have cost.
        approach: "semi_discrete", or "fishnet" for a net without forces, in seconds.
    """
'''


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
        numerics=Numerics.for_accuracy(accuracy),
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
