"""A stack of any number of plies, by its lay-up, formed at once by a hemispherical punch."""

from warpdrape import Ply, Scene
from warpdrape.materials.fabric_library import with_bending
from warpdrape.scenes.press import (
    ACCURACY,
    BRAKE,
    DIE_RADIUS,
    PUNCH_RADIUS,
    ROOM,
    hemisphere_tools,
    read_layup,
)
from warpdrape.units import deg

LAYUP = "0/45/0/45/45/0/45/0"
"""Eight plies, symmetric; a woven ply at 45° has yarns at -45° too."""


def build(
    *,
    layup: str = LAYUP,
    cells: int = 20,
    blank_size: float = 0.3,
    travel: float = 0.075,
    duration: float | None = None,
    brake: float = BRAKE,
    kinetic_limit: float = 0.0,
    holder_force: float = 100.0,
    friction: float = 0.2,
    ply_friction: float = 0.3,
    fabric: str = "carbon_interlock",
    bending: str = "fabric",
    mesh: str = "grid",
    facet: float = 5e-3,
    contact_share: float = 0.04,
    contact: str = "fast",
    minimum_time_step: float = 0.0,
    mass_scaling: str = "plain",
    accuracy: str = ACCURACY,
    fast: bool = False,
    approach: str = "semi_discrete",
) -> Scene:
    """Build the hemisphere on the reference press, with any number of square plies.

    Args:
        layup: warp angles from the die up, one for each ply [deg].
        cells: squares of four triangles along a side.
        blank_size: side of the blanks [m].
        travel: punch travel [m].
        duration: of the stroke; none for that of the accuracy: 40, 80 or 160 ms [s].
        brake: share of the stroke in which the punch slows down, below 1 [-].
        kinetic_limit: kinetic over internal energy above which tools go slower, 0 for none [-].
        holder_force: on the blank holder [N].
        friction: Coulomb coefficient of tools on plies [-].
        ply_friction: Coulomb coefficient between plies [-].
        fabric: name or file of a fabric.
        bending: "fabric" for its own, "none", or a stiffness in all directions [N·m].
        mesh: "grid" as in the paper, "aligned" to the yarns, "diagonal" or "random".
        facet: size of the tools' facets [m].
        contact_share: penalty stiffness over m/Δt² [-].
        contact: "fast", or "exact" to search for every vertex at every step.
        minimum_time_step: mass is added until the stable step reaches it, 0 adds none [s].
        mass_scaling: "plain" on vertices, or "selective" against the stretching of triangles.
        accuracy: "draft", "standard" or "reference": the summary says what it costs.
        fast: another name for the standard accuracy.
        approach: "semi_discrete"; stress as a state, "green_naghdi" or "fibre_frame"; "yarns",
            chains of bars, or "sliding_yarns"; or a net, "fishnet", on the closed tools.
    """
    parameters = dict(locals())
    cloth = with_bending(fabric, bending)
    plies = [
        Ply.rectangle(f"ply_{k}", cloth, blank_size, cells=cells, mesh=mesh, warp_angle=angle * deg)
        for k, angle in enumerate(read_layup(layup))
    ]
    die_radius = max(DIE_RADIUS, PUNCH_RADIUS + ROOM * len(plies) * cloth.thickness)
    return hemisphere_tools(
        "stacked_hemisphere", plies, parameters, friction, ply_friction, die_radius
    )


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
