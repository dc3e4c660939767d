"""A hot prepreg formed by a hemispherical punch: what the press's speed and cold tools do."""

from dataclasses import replace

from warpdrape import Air, Friction, InputError, Ply, Scene
from warpdrape.errors import positive
from warpdrape.materials.fabric_library import with_bending
from warpdrape.scenes.press import REFERENCE, STANDARD, hemisphere_tools
from warpdrape.units import celsius, deg

MELT = Friction(
    coefficient=0.12,
    by_hersey=((0.0, 0.2), (1e-5, 0.12), (1e-4, 0.15), (1e-3, 0.4), (1e-2, 1.0)),
    viscosity=300.0,
    source="chosen: a Stribeck curve's shape, mixed and then hydrodynamic; not measured",
)
"""A melt between ply and tools: μ over the Hersey number η v / p."""


def build(
    *,
    closing_time: float = 2.0,
    blank_celsius: float = 260.0,
    tool_celsius: float = 200.0,
    air_celsius: float = 0.0,
    angle_deg: float = 0.0,
    cells: int = 20,
    blank_size: float = 0.3,
    travel: float = 0.075,
    duration: float = 0.08,
    brake: float = 0.3,
    holder_force: float = 100.0,
    fabric: str = "synthetic_prepreg",
    bending: str = "fabric",
    mesh: str = "grid",
    facet: float = 5e-3,
    contact_share: float = 0.04,
    minimum_time_step: float = 0.0,
    fast: bool = False,
    approach: str = "semi_discrete",
) -> Scene:
    """Build the hemisphere on the reference press, with one square ply of prepreg.

    Args:
        closing_time: that the press takes for the stroke; the matrix and friction know this [s].
        blank_celsius: temperature of the ply as it is laid in [°C].
        tool_celsius: of punch, die and holder; 0 for tools that pass no heat [°C].
        air_celsius: of the air; 0 for air that takes none [°C].
        angle_deg: from the blank's side to the warp [deg].
        cells: squares of four triangles along a side.
        blank_size: side of the blank [m].
        travel: punch travel [m].
        duration: simulated time of the stroke, whatever the press takes [s].
        brake: share of the stroke in which the punch slows down, below 1 [-].
        holder_force: on the blank holder [N].
        fabric: name or file of a fabric with a matrix.
        bending: "fabric" for its own, "none", or a stiffness in all directions [N·m].
        mesh: "grid" as in the paper, "aligned" to the yarns, "diagonal" or "random".
        facet: size of the tools' facets [m].
        contact_share: penalty stiffness over m/Δt² [-].
        minimum_time_step: mass is added until the stable step reaches it, 0 adds none [s].
        fast: a quarter of the time, by softer yarns; the summary says what they cost.
        approach: "semi_discrete"; stress as a state, "green_naghdi" or "fibre_frame"; or a net,
            "fishnet", on the closed tools.
    """
    parameters = dict(locals())
    positive("closing_time", closing_time, unit="s")
    cloth = with_bending(fabric, bending)
    if cloth.matrix is None:
        raise InputError(
            f"fabric {cloth.name!r} has no matrix: give one of a prepreg, or take the scene "
            "'hemisphere' for a dry one"
        )
    ply = Ply.rectangle(
        "ply_0",
        cloth,
        blank_size,
        cells=cells,
        mesh=mesh,
        warp_angle=angle_deg * deg,
        temperature=celsius(blank_celsius) if cloth.matrix.shift is not None else None,
    )
    fixed = {"kinetic_limit": 0.0, "mass_scaling": "plain", "contact": "fast"}
    fixed["accuracy"] = STANDARD if fast else REFERENCE
    scene = hemisphere_tools(
        "prepreg_hemisphere", [ply], {**parameters, **fixed}, MELT, closing_time=closing_time
    )
    holds = cloth.matrix.heat is not None
    warmth = celsius(tool_celsius) if tool_celsius and holds else None
    return replace(
        scene,
        tools=[replace(tool, temperature=warmth) for tool in scene.tools],
        air=Air(temperature=celsius(air_celsius)) if air_celsius and holds else None,
        parameters=parameters,
    )


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
