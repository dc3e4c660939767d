"""A square box with round corners, pressed through an open die under a floating blank holder."""

from warpdrape import Scene
from warpdrape.scenes.pressed_shape import Press, pressed, shape_scene
from warpdrape.tools.plan import rounded_rectangle
from warpdrape.tools.shaped import box_punch, opening
from warpdrape.units import mm


@pressed(travel=40 * mm)
def build(
    *,
    side: float = 150 * mm,
    corner_radius: float = 30 * mm,
    bottom_radius: float = 15 * mm,
    edge_radius: float = 10 * mm,
    clearance: float = 3 * mm,
    press: Press,
) -> Scene:
    """Build the box; its dimensions are this project's own.

    Args:
        side: of the punch [m].
        corner_radius: of the punch's upright edges [m].
        bottom_radius: of the rounding between its bottom and its walls [m].
        edge_radius: of the rounding at the die's opening [m].
        clearance: between punch and die; 1.5 thicknesses of the stack where it is less [m].
        press: what every pressed shape takes; given as parameters of their own.
    """
    shape = {k: v for k, v in locals().items() if k != "press"}
    gap = press.room(clearance)
    plan = rounded_rectangle(side + 2.0 * gap, side + 2.0 * gap, corner_radius + gap)
    deep = press.travel + edge_radius
    punch = box_punch(
        rounded_rectangle(side, side, corner_radius),
        bottom_radius,
        deep + bottom_radius + press.thickness,
        press.facet,
    )
    outer = press.outer_radius(plan, edge_radius)
    return shape_scene(
        "square_box",
        press,
        shape,
        punch=punch,
        die=opening(plan, edge_radius, outer, deep, press.facet),
        plan=plan,
        edge_radius=edge_radius,
    )


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
