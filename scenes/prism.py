"""A prism: a ridge with two sloping sides and two steep ends, pressed through an open die."""

from warpdrape import Scene
from warpdrape.scenes.pressed_shape import Press, pressed, shape_scene
from warpdrape.tools.plan import rounded_polygon
from warpdrape.tools.pointed import prism
from warpdrape.tools.shaped import opening
from warpdrape.units import deg, mm


@pressed(travel=50 * mm)
def build(
    *,
    ridge_length: float = 100 * mm,
    slope_deg: float = 50.0,
    end_slope_deg: float = 75.0,
    ridge_radius: float = 15 * mm,
    edge_radius: float = 10 * mm,
    clearance: float = 3 * mm,
    press: Press,
) -> Scene:
    """Build the prism, its ridge along x; its dimensions are this project's own.

    Args:
        ridge_length: of the ridge's straight part [m].
        slope_deg: of the long sides against the horizontal [deg].
        end_slope_deg: of the ends against the horizontal [deg].
        ridge_radius: of the rounding of the punch's ridge, edges and corners [m].
        edge_radius: of the rounding at the die's opening [m].
        clearance: between punch and die at the end of the stroke, as the section shows it; 1.5
            thicknesses of the stack where it is less [m].
        press: what every pressed shape takes; given as parameters of their own.
    """
    shape = {k: v for k, v in locals().items() if k != "press"}
    height = press.travel + edge_radius + press.thickness + ridge_radius
    punch = prism(ridge_length, slope_deg * deg, end_slope_deg * deg, ridge_radius, height)
    plan = rounded_polygon(*punch.section(press.travel, press.room(clearance)))
    outer = press.outer_radius(plan, edge_radius)
    return shape_scene(
        "prism",
        press,
        shape,
        punch=punch.surface(press.facet),
        die=opening(plan, edge_radius, outer, press.travel, press.facet),
        plan=plan,
        edge_radius=edge_radius,
    )


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
