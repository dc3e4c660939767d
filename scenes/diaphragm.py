"""Plies drawn over a dome by vacuum, under a rubber diaphragm or between two.

Mould, frame and rubber are made up for this demonstration: a cap of 60 mm radius, 35 mm high, in a
round box of 150 mm radius, and a soft rubber of 0.33 MPa shear modulus, no product's.
"""

import math
from collections.abc import Callable

import numpy as np

from warpdrape import Clamp, Fabric, Numerics, Ply, Pressure, Scene, Tool, lay_up
from warpdrape.errors import InputError, positive
from warpdrape.materials.fabric_library import with_bending
from warpdrape.scenes.press import read_layup
from warpdrape.tools.profile import Arc, Line, revolve
from warpdrape.units import deg, mm

DOME_RADIUS, DOME_HEIGHT, FILLET = 60 * mm, 35 * mm, 15 * mm
FRAME_RADIUS = 150 * mm
"""Where the diaphragms are held, at the height of the dome's pole."""
WALL_GAP, WALL_FILLET = 2 * mm, 10 * mm
"""From the frame to the box's wall, and the rounding between wall and base."""
RUBBER = {"thickness": 1.5 * mm, "density": 1150.0, "c10": 0.15e6, "c01": 0.015e6}
CLAMPING = 0.1
"""Share of the duration in which the air between two diaphragms is drawn off."""
HOLD = 0.2
"""Share of the duration for which the full vacuum stands at the end."""
CONTACT = {"contact_share": 0.1, "search_slide": 0.05 * mm}
"""Stiffer than the default against the vacuum at the plies' edges, and sought for faster plies."""
LAYUP_EDGE = 2 * mm
"""Least distance of the plies' corners from the frame."""


def mould(facet: float) -> Tool:
    """The dome on its base, and the box's wall; the pole is the origin."""
    up = DOME_RADIUS - DOME_HEIGHT + FILLET
    out = math.sqrt((DOME_RADIUS + FILLET) ** 2 - up**2)
    foot = math.atan2(up, out)
    wall = FRAME_RADIUS + WALL_GAP
    corner = (wall - WALL_FILLET, WALL_FILLET - DOME_HEIGHT)
    pieces = [
        Arc((0.0, -DOME_RADIUS), DOME_RADIUS, 0.5 * math.pi, foot),
        Arc((out, FILLET - DOME_HEIGHT), FILLET, foot + math.pi, 1.5 * math.pi),
        Line((out, -DOME_HEIGHT), (corner[0], -DOME_HEIGHT)),
        Arc(corner, WALL_FILLET, 1.5 * math.pi, 2.0 * math.pi),
        Line((wall, corner[1]), (wall, 0.0)),
    ]
    return Tool(name="mould", surface=revolve(pieces, facet))


def build(
    *,
    layup: str = "0/90",
    diaphragms: int = 1,
    blank_size: float = 0.18,
    edge: float = 8e-3,
    vacuum: float = 60e3,
    duration: float = 0.2,
    damping: float = 100.0,
    friction: float = 0.3,
    ply_friction: float = 0.3,
    fabric: str = "carbon_interlock",
    bending: str = "fabric",
    facet: float = 4e-3,
    yarn_softening: float = 16.0,
) -> Scene:
    """Build plies over a dome, under one diaphragm or between two.

    Args:
        layup: warp angles from the mould up, one for each ply [deg].
        diaphragms: 1 above the plies, or 2, one of them below.
        blank_size: side of the square plies [m].
        edge: triangle size of plies and diaphragms [m].
        vacuum: under the diaphragm at the end [Pa].
        duration: in which the vacuum rises [s]; a fifth more at the end.
        damping: mass-proportional damping rate [1/s].
        friction: Coulomb coefficient of plies and rubber on the mould [-].
        ply_friction: of plies and rubber on each other [-].
        fabric: name or file of a fabric.
        bending: "fabric" for its own, "none", or a stiffness in all directions [N·m].
        facet: size of the mould's facets [m].
        yarn_softening: divides the yarns' tensions, for a larger step [-].
    """
    parameters = dict(locals())
    positive("vacuum", vacuum, unit="Pa")
    if diaphragms not in (1, 2):
        raise InputError(f"diaphragms = {diaphragms} must be 1 or 2")
    if math.sqrt(0.5) * blank_size > FRAME_RADIUS - LAYUP_EDGE:
        raise InputError(
            f"blank_size = {blank_size:g} m reaches the frame: give "
            f"{2**0.5 * (FRAME_RADIUS - LAYUP_EDGE):.3g} m or less"
        )
    cloth, rubber = with_bending(fabric, bending), Fabric.rubber("rubber", **RUBBER)
    plies = [
        Ply.rectangle(f"ply_{n}", cloth, blank_size, edge=edge, warp_angle=angle * deg)
        for n, angle in enumerate(read_layup(layup))
    ]
    # Where both hang down from the frame the upper one is inside by its thickness.
    radii = {"lower": FRAME_RADIUS, "upper": FRAME_RADIUS - rubber.thickness}
    if diaphragms == 1:
        radii = {"upper": FRAME_RADIUS}
    bags = [Ply.disc(name, rubber, radius, edge=edge) for name, radius in radii.items()]
    stack = lay_up([*bags[:-1], *plies, bags[-1]])
    return Scene(
        name="diaphragm",
        plies=stack,
        tools=[mould(facet)],
        clamps=[
            Clamp(name=f"frame_{name}", ply=name, where=_rim(radius), slope="free")
            for name, radius in radii.items()
        ],
        pressures=_vacuum(vacuum, duration, both=diaphragms == 2),
        duration=(1.0 + HOLD) * duration,
        friction=friction,
        ply_friction=ply_friction,
        numerics=Numerics(damping=damping, yarn_softening=yarn_softening, **CONTACT),
        parameters=parameters,
    )


def _rim(radius: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda points: np.hypot(points[:, 0], points[:, 1]) > radius * (1.0 - 1e-3)


def _vacuum(vacuum: float, duration: float, *, both: bool) -> list[Pressure]:
    """The atmosphere on the upper diaphragm; and on the lower one until it is drawn off there.

    Two diaphragms are first sucked onto the plies between them; then the air below goes too. It
    goes as the square of time: the plies have gone most of their way at a small part of it.
    """
    rise = np.linspace(0.0, 1.0, 11)
    drawn = list(zip(duration * rise, vacuum * rise**2, strict=True))
    if not both:
        return [Pressure(name="atmosphere", ply="upper", pressure=drawn)]
    # Alike on both while the air between them goes: what is left over would throw them.
    begin = CLAMPING * duration
    between = list(zip(begin * rise, vacuum * rise**2 * (3.0 - 2.0 * rise), strict=True))
    below = [(begin + (1.0 - CLAMPING) * t, vacuum - p) for t, p in drawn[1:]]
    return [
        Pressure(name="atmosphere", ply="upper", pressure=between),
        Pressure(name="below", ply="lower", pressure=[*between, *below], side="lower"),
    ]


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
