"""Three plies at +45/0/+45 formed at once by a hemispherical punch (paper, Figure 5)."""

from dataclasses import replace
from typing import Any

from warpdrape import Ply, Result, Scene
from warpdrape.materials.fabric_library import with_bending
from warpdrape.scenes.press import ACCURACY, BRAKE, hemisphere_tools
from warpdrape.units import deg

ANGLES_DEG = (45.0, 0.0, 45.0)
"""Warp angles from the die up: the paper's ±45°, 0-90°, ±45° [deg]."""

PAPER_MAX_SHEAR_DEG = 46.0
"""Largest shear angle of the central ply in the paper [deg]."""


def build(
    *,
    angle_deg: float = 0.0,
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
    """Build the hemisphere on the reference press, with three square plies.

    Args:
        angle_deg: turns the yarns of all plies [deg].
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
        Ply.rectangle(
            f"ply_{k}",
            cloth,
            blank_size,
            cells=cells,
            mesh=mesh,
            warp_angle=(angle_deg + angle) * deg,
        )
        for k, angle in enumerate(ANGLES_DEG)
    ]
    scene = hemisphere_tools("three_ply_hemisphere", plies, parameters, friction, ply_friction)
    return replace(scene, report=report_central_ply)


def report_central_ply(result: Result) -> dict[str, Any]:
    """Put the central ply's largest shear angle beside the paper's."""
    ply = result.plies[len(result.plies) // 2]
    angles = {"max_shear_deg": ply.max_shear_deg, "paper_max_shear_deg": PAPER_MAX_SHEAR_DEG}
    return {"central_ply": {"name": ply.name, **angles}}


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
