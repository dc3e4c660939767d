"""A double dome between matched tools: two domes with a saddle, punch into cavity, holder round it.

The shape is that of the international benchmark. Its drawing could not be read at a source, so the
defaults are this project's own and every dimension is a parameter: give the printed ones.
"""

from dataclasses import replace

from warpdrape import InputError, Scene
from warpdrape.scenes.pressed_shape import Press, pressed, shape_scene
from warpdrape.tools.plan import waist_radius, waisted
from warpdrape.tools.shaped import double_dome, double_dome_cavity
from warpdrape.units import mm

TRAVEL = 62 * mm
"""Of the punch, where none is given and the stack is not too thick for it [m]."""


@pressed(travel=None, blank_length=400 * mm, blank_width=270 * mm, cells=40)
def build(
    *,
    dome_radius: float = 50 * mm,
    dome_distance: float = 120 * mm,
    waist: float = 40 * mm,
    edge_radius: float = 10 * mm,
    clearance: float = 2 * mm,
    press: Press,
) -> Scene:
    """Build the double dome; its dimensions are this project's own.

    Args:
        dome_radius: of the punch's domes [m].
        dome_distance: between their centres, along x [m].
        waist: half the width, and the depth, of the punch's saddle in the middle [m].
        edge_radius: of the rounding at the die's opening [m].
        clearance: between punch and cavity at the end of the stroke; 1.5 thicknesses of the stack
            where it is less [m].
        press: what every pressed shape takes; given as parameters of their own.
    """
    shape = {k: v for k, v in locals().items() if k != "press"}
    waist_radius(dome_radius, dome_distance, waist)  # refuses what cannot be, in these words
    gap = press.room(clearance)
    least = dome_radius + edge_radius + press.thickness
    if press.travel is None:
        press = replace(press, travel=max(TRAVEL, least))
    elif press.travel < least * (1.0 - 1e-9):
        raise InputError(
            f"travel = {press.travel:.4g} m must be at least {least:.4g} m: the domes' radius, "
            "that of the die's edge, and the plies"
        )
    plan = waisted(dome_radius + gap, dome_distance, waist + gap)
    outer = press.outer_radius(plan, edge_radius)
    die = double_dome_cavity(
        dome_radius + gap,
        dome_distance,
        waist + gap,
        depth=press.travel + gap - press.thickness,
        edge_radius=edge_radius,
        outer_radius=outer,
        facet=press.facet,
    )
    height = press.travel + edge_radius + press.thickness
    return shape_scene(
        "double_dome",
        press,
        shape,
        punch=double_dome(dome_radius, dome_distance, waist, height, press.facet),
        die=die,
        plan=plan,
        edge_radius=edge_radius,
    )


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
