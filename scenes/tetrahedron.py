"""A tetrahedron pressed through an open triangular die under a floating blank holder."""

from warpdrape import Scene
from warpdrape.scenes.pressed_shape import Press, pressed, shape_scene
from warpdrape.tools.plan import rounded_polygon
from warpdrape.tools.pointed import tetrahedron
from warpdrape.tools.shaped import opening
from warpdrape.units import deg, mm


@pressed(travel=70 * mm)
def build(
    *,
    slope_deg: float = 60.0,
    point_radius: float = 15 * mm,
    edge_radius: float = 10 * mm,
    clearance: float = 3 * mm,
    press: Press,
) -> Scene:
    """Build the tetrahedron, one of its edges along +x; its dimensions are this project's own.

    Args:
        slope_deg: of its faces against the horizontal; 70.53 is a regular tetrahedron [deg].
        point_radius: of the rounding of the punch's edges and its point [m].
        edge_radius: of the rounding at the die's opening [m].
        clearance: between punch and die at the end of the stroke, as the section shows it; 1.5
            thicknesses of the stack where it is less [m].
        press: what every pressed shape takes; given as parameters of their own.
    """
    shape = {k: v for k, v in locals().items() if k != "press"}
    height = press.travel + edge_radius + press.thickness + point_radius
    punch = tetrahedron(slope_deg * deg, point_radius, height)
    plan = rounded_polygon(*punch.section(press.travel, press.room(clearance)))
    outer = press.outer_radius(plan, edge_radius)
    return shape_scene(
        "tetrahedron",
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
