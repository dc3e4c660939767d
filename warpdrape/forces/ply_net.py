"""A ply's net of yarns as forces take it: kept for each ply, refused where it is none, its ties."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.yarn_net import YarnNet, lay_yarns
from warpdrape.errors import InputError
from warpdrape.forces.membrane_stiffness import stabiliser_stiffness
from warpdrape.materials.law_data import tension_stiffness
from warpdrape.materials.laws import Unwoven
from warpdrape.materials.softening import soften
from warpdrape.numerics import Numerics

RIM_STIFFNESS = 0.1
"""k in the rim over the larger line stiffness of the yarns [-]: their ends, which lead a clamp's
load to the first crossover; 1 N moves them some 0.3 µm, and the step is still the yarns'."""
MOST_RIM = 0.5
"""Share of a ply's area outside its cells beyond which the net is not the ply's any more [-]."""


@lru_cache(maxsize=8)
def net_of(ply: Ply) -> YarnNet:
    """The net of a ply, kept for the plies asked for last.

    Raises:
        InputError: if the ply has no yarns, or its mesh does not follow them.
    """
    if isinstance(ply.fabric.tension, Unwoven):
        raise InputError(
            f"bars are laid out along yarns, and fabric {ply.fabric.name!r} of ply {ply.name!r} "
            "has none: take approach = 'semi_discrete'"
        )
    net = lay_yarns(ply.mesh, ply.yarn_directions)
    if net is None:
        raise InputError(
            f"yarns are bars along mesh edges, and the mesh of ply {ply.name!r} does not follow "
            "its yarns: mesh it with mesh = 'aligned'"
        )
    if net.rim > MOST_RIM:
        raise InputError(
            f"{100 * net.rim:.0f} % of ply {ply.name!r} lie outside the cells of its yarns, more "
            f"than {100 * MOST_RIM:.0f} %: give a shorter edge, or more cells"
        )
    return net


def yarns_per_bar(ply: Ply, net: YarnNet) -> list[float]:
    """Yarns for which a bar of warp and of weft stands, on the mean [-].

    Bars of the warp lie as far apart as those of the weft are long, times sin θ0.
    """
    apart = np.average(np.abs(net.lengths[:, ::-1]), axis=0, weights=net.areas)
    widths = np.array(ply.fabric.yarn_width)
    return [float(n) for n in apart * np.sin(ply.fabric.yarn_angle) / widths]


def tie_stiffness(ply: Ply, numerics: Numerics) -> np.ndarray:
    """K of every carried vertex [N/m].

    In a cell as soft as the ply's shear, the stabiliser's: a tool may push it out of its cell. A
    stiff one would be a lever that lifts the crossovers around it off a tool's rounding.
    """
    rim = RIM_STIFFNESS * max(tension_stiffness(soften(ply.fabric, numerics.yarn_softening)))
    return np.where(net_of(ply).inside, float(stabiliser_stiffness(ply.fabric, numerics)), rim)
