"""A ply's sliding yarns on a device: bars with their quadrants, crossovers with their springs."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.yarn_chains import NONE, YarnChains, chain_yarns
from warpdrape.errors import InputError
from warpdrape.forces.membrane import yarn_viscosity
from warpdrape.forces.ply_net import net_of
from warpdrape.interaction import Span
from warpdrape.kernels.forces.bar_loads import make_coupled_loads, make_lone_loads
from warpdrape.kernels.forces.slid_laws import (
    crimp_press,
    linear_own_energy,
    linear_own_loads,
    make_no_press,
    make_slid_law,
    slid_crimp_energy,
    slid_crimp_loads,
)
from warpdrape.kernels.forces.slides import LEAST_SPACING, SLIDES_SHARE, make_slide_kernels
from warpdrape.kernels.forces.sliding_bars import make_bar_kernels
from warpdrape.kernels.forces.yarn_chains import Bars, Crossovers
from warpdrape.kernels.materials.crimp import CrimpInterchange as CrimpStruct
from warpdrape.kernels.materials.tension import LinearTension as LinearStruct
from warpdrape.materials.crossover import Crossover
from warpdrape.materials.law_data import membrane_functions, tension_struct
from warpdrape.materials.laws import CrimpInterchange, LinearTension
from warpdrape.materials.softening import soften
from warpdrape.numerics import Numerics
from warpdrape.setup import Setup

CLOSEST = float(LEAST_SPACING)
"""Length of a bar over its flat one below which no more yarn slides out of it [-]."""
MOST_MATES = 4
"""Quadrants of a bar: two at either end."""


@dataclass(frozen=True, eq=False)
class ChainKernels:
    """What is launched on bars and crossovers, for one law of tension.

    Attributes:
        pull: adds the bars' forces.
        slide: moves the yarns.
        measure_bars: strain, tension, energy of bars.
        measure_slides: energies of crossovers.
    """

    pull: Any
    slide: Any
    measure_bars: Any
    measure_slides: Any


def crossover_of(ply: Ply) -> Crossover:
    """How the yarns of a ply's fabric slide.

    Raises:
        InputError: where its card does not say so.
    """
    fabric = ply.fabric
    net_of(ply)
    if fabric.crossover is None:
        raise InputError(
            f"approach = 'sliding_yarns' needs the [crossover] of fabric {fabric.name!r} of ply "
            f"{ply.name!r}, slip force and stiffness: give them in its file, or take "
            "approach = 'yarns', whose crossovers are pinned"
        )
    law = fabric.crossover
    knows_press = isinstance(fabric.tension, CrimpInterchange) or law.friction > 0.0
    if law.yarn_friction > 0.0 and not knows_press:
        raise InputError(
            f"crossover.yarn_friction = {law.yarn_friction:g} of fabric {fabric.name!r} rubs with "
            "the force that the yarns' crimp presses with, and its tension law knows no crimp: "
            "give crossover.friction beside it, per tension of the crossed yarn"
        )
    return law


def is_coupled(ply: Ply) -> bool:
    """Whether tensions of warp and weft depend on each other's strains."""
    return not isinstance(ply.fabric.tension, LinearTension)


def kernels_of(ply: Ply) -> ChainKernels:
    """The kernels of a ply's law."""
    tension, tension_energy, _, _, Tension, _ = membrane_functions(ply.fabric)
    return _made(tension, tension_energy, Tension)


@functools.cache
def _made(tension: Callable, tension_energy: Callable, Tension: type) -> ChainKernels:
    press = make_no_press(Tension)
    if Tension is LinearStruct:
        loads, energy = make_lone_loads(linear_own_loads, linear_own_energy, Tension)
    elif Tension is CrimpStruct:
        loads, energy = make_coupled_loads(slid_crimp_loads, slid_crimp_energy, Tension)
        press = crimp_press
    else:
        slid = make_slid_law(tension, tension_energy, Tension)
        loads, energy = make_coupled_loads(*slid, Tension)
    pull, measure_bars = make_bar_kernels(loads, energy, Tension)
    slide, measure_slides = make_slide_kernels(loads, press, Tension)
    return ChainKernels(pull, slide, measure_bars, measure_slides)


def law_of(ply: Ply, numerics: Numerics, device: str) -> Any:
    """The tension law for these kernels, softened as the run asks."""
    return tension_struct(soften(ply.fabric, numerics.yarn_softening), device)


def mates_of(chains: YarnChains, areas: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bars of the other family in each bar's quadrants, `NONE` for none; flat areas [m²].

    Args:
        chains: of a ply.
        areas: of its quadrants [m²], shape [quadrant].

    Returns:
        Shapes [bar, 4].
    """
    count = len(chains.ends)
    mates = np.full((count, MOST_MATES), NONE, np.int32)
    shared = np.zeros((count, MOST_MATES))
    for own, other in (chains.quadrants.T, chains.quadrants.T[::-1]):
        order = np.argsort(own, kind="stable")
        first = np.searchsorted(own[order], own[order])
        place = np.arange(len(own)) - first
        mates[own[order], place] = other[order]
        shared[own[order], place] = areas[order]
    return mates, shared


def bars_on(ply: Ply, chains: YarnChains, numerics: Numerics, span: Span, device: str) -> Bars:
    """Put a ply's bars on a device."""
    mates, shared = mates_of(chains, net_of(ply).areas)
    bars = Bars()
    bars.ends = wp.array(chains.ends + span.first_vertex, dtype=wp.vec2i, device=device)
    bars.numbers = wp.array(chains.numbers, dtype=wp.vec2i, device=device)
    bars.family = wp.array(chains.family, dtype=wp.int32, device=device)
    bars.lengths = wp.array(chains.lengths, dtype=wp.float64, device=device)
    bars.widths = wp.array(chains.widths, dtype=wp.float64, device=device)
    bars.mates = wp.array(mates, dtype=wp.vec4i, device=device)
    bars.areas = wp.array(shared, dtype=wp.vec4d, device=device)
    bars.viscosity = wp.vec2d(*yarn_viscosity(ply.fabric, numerics))
    return bars


def crossovers_on(
    scene: Setup,
    ply: Ply,
    law: Crossover,
    chains: YarnChains,
    stiffness: np.ndarray,
    device: str,
) -> Crossovers:
    """Springs of bundles: as many as there are crossings of single yarns in their area.

    Args:
        scene: whose clamps may grip yarns.
        ply: the ply.
        law: of its crossovers.
        chains: its yarns.
        stiffness: from `along_bars` [N/m], shape [bar].
        device: Warp device.
    """
    fabric = ply.fabric
    crossings = (chains.areas / fabric.cell_area)[:, None]
    held = np.zeros(len(ply.mesh.vertices), np.int32)
    for clamp in scene.clamps:
        if clamp.ply == ply.name and clamp.yarns == "held":
            held[clamp.vertices(ply.rest_points)] = 1
    below, above = chains.passed

    def pairs(values: np.ndarray) -> wp.array:
        return wp.array(values, dtype=wp.vec2d, device=device)

    out = Crossovers()
    out.bars = wp.array(chains.bars, dtype=wp.vec4i, device=device)
    out.slip = pairs(crossings * np.array((law.slip_force_warp, law.slip_force_weft)))
    out.stiffness = pairs(crossings * np.array((law.stiffness_warp, law.stiffness_weft)))
    crossed = fabric.yarn_width[::-1]  # of the yarn that is crossed, whose tension presses
    out.friction = pairs(crossings * law.friction * np.array(crossed))
    rubbing = law.yarn_friction * crossings[:, 0]
    out.rubbing = wp.array(rubbing, dtype=wp.float64, device=device)
    out.pressed = wp.zeros(len(rubbing), dtype=wp.float64, device=device)
    beside = np.where(chains.bars < 0, 0.0, stiffness[chains.bars]).reshape(-1, 2, 2).sum(axis=2)
    out.inertia = pairs(np.where(beside > 0.0, 2.0 / SLIDES_SHARE * beside, 1.0))
    out.below, out.above, out.span = pairs(below), pairs(above), pairs(chains.span)
    out.held = wp.array(held[chains.vertices], dtype=wp.int32, device=device)
    return out


def closeness(ply: Ply) -> float:
    """Length over the flat one by which the stiffness of the shortest bars is bounded [-].

    A bar's own is as k/l. The coupling belongs to crossings, which stay as many, ∂²χ/∂l² as 1/l²:
    with φ'' ≥ 0 the sum is at most k l0/l².
    """
    return CLOSEST**2 if is_coupled(ply) else CLOSEST


def along_bars(ply: Ply, chains: YarnChains, stiffness: np.ndarray) -> np.ndarray:
    """Stiffness of bars that are as short as they may get [N/m], shape [bar].

    Args:
        ply: the ply.
        chains: its yarns.
        stiffness: line stiffness of warp and weft [N/m], shape [2].
    """
    return stiffness[chains.family] * chains.widths / (closeness(ply) * chains.lengths)


def chains_of(ply: Ply) -> YarnChains:
    """A ply's yarns from end to end."""
    return chain_yarns(net_of(ply))
