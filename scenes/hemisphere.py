"""One ply formed by a hemispherical punch through a die, under a floating blank holder."""

from warpdrape import Ply, Scene
from warpdrape.materials.fabric_library import with_bending
from warpdrape.scenes.press import ACCURACY, BRAKE, DIE_EDGE, hemisphere_tools
from warpdrape.units import deg


def build(
    *,
    angle_deg: float = 0.0,
    cells: int = 20,
    blank_size: float = 0.3,
    travel: float = 0.075,
    die_edge: float = DIE_EDGE,
    duration: float | None = None,
    brake: float = BRAKE,
    kinetic_limit: float = 0.0,
    holder_force: float = 100.0,
    friction: float = 0.2,
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
    """Build the hemisphere on the reference press, with one square ply.

    Args:
        angle_deg: from the blank's side to the warp [deg].
        cells: squares of four triangles along a side.
        blank_size: side of the blank [m].
        travel: punch travel [m].
        die_edge: radius of the die's rounded edge [m].
        duration: of the stroke; none for that of the accuracy: 40, 80 or 160 ms [s].
        brake: share of the stroke in which the punch slows down, below 1 [-].
        kinetic_limit: kinetic over internal energy above which tools go slower, 0 for none [-].
        holder_force: on the blank holder [N].
        friction: Coulomb coefficient of tools on the ply [-].
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
    ply = Ply.rectangle(
        "ply_0", cloth, blank_size, cells=cells, mesh=mesh, warp_angle=angle_deg * deg
    )
    return hemisphere_tools("hemisphere", [ply], parameters, friction, die_edge=die_edge)


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
