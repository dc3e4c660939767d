"""What an estimate of a run's numerical error is made from: measures of a summary, and a blank."""

from warpdrape.blanks.ply import Ply
from warpdrape.units import deg

MEASURES = {
    "status": "completed",
    "tools": [{}],
    "quasi_static": True,
    "softening_strain": 0.0,
    "kinetic_ratio_loaded": 0.0,
    "max_penetration_m": 0.0,
}


def blank(angle_deg=0.0):
    return Ply.rectangle(
        "ply", "carbon_interlock", 0.3, 0.2, cells=4, warp_angle=angle_deg * deg, mesh="grid"
    )
