"""What the tests of prepregs share: a frame that shears, a ply on a cold plate, a coarse press."""

from dataclasses import replace

from warpdrape import Ply, Tool, lay_up
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.scene import Scene
from warpdrape.scenes import picture_frame, prepreg_hemisphere
from warpdrape.units import celsius

CARD = "synthetic_prepreg"


def frame(process=5.0, degrees=260.0, **options):
    given = {"edge": 0.05, "duration": 0.05, "damping": 5.0, "shear_angle_deg": 45.0}
    return picture_frame.build(
        fabric=options.pop("fabric", CARD),
        process_duration=process,
        temperature=celsius(degrees) if degrees else 0.0,
        **(given | options),
    )


def on_a_plate(**settings):
    """A ply that lies on a plate which warms one half of it less, and does not move."""
    cloth = replace(load_fabric(CARD), bending=None)
    plies = lay_up([Ply.rectangle("ply", cloth, 0.04, cells=4, mesh="grid")])
    plate = Tool.plate("plate", width=0.02, height=0.1, temperature=400.0)
    return Scene(
        name="plate",
        plies=plies,
        tools=[replace(plate, **settings).moved((-0.0151, 0.0, 0.0))],
        duration=4e-3,
        process_duration=1.0,
        gravity=(0.0, 0.0, -50.0),
    )


def coarse(**options):
    given = {"cells": 8, "duration": 0.02, "fast": True, "bending": "none", "facet": 0.01}
    return prepreg_hemisphere.build(**(given | options))
