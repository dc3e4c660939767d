"""What cells with more yarn in them, or less, resist with, per flat area of the sheet.

With ρ the distance of a bar's ends over its flat length and λ the yarn in it likewise, w is the
energy per flat area, whose crossings stay as many however far the yarns slide. Without slides,
λ = 1, it is the card's Φ(ρ1 − 1, ρ2 − 1).

- Of saw-tooth yarns it is known: those of a cell with λ l of yarn climb as high as before.
- A law that knows only strains ε = ρ/λ − 1 says nothing of it. Then φ_1 = Φ(ε1, 0) − Φ(0, 0), and
  φ_2 likewise, belong to the yarn itself, of which there is λ times as much, and the rest, what
  the families do to each other, to their crossings:

      w = λ1 φ_1 + λ2 φ_2 + χ,   χ = Φ − φ_1 − φ_2 − Φ(0, 0)

  which is exact where they do nothing to each other.
- Linear yarns do not: of them, which are computed most, w_f alone is told, without the rest.
"""

import warp as wp

from ..materials.crimp import (
    CrimpInterchange,
    climb_force,
    exchanged_height,
    family_energy,
    family_tension,
    yarn_stretches,
)
from ..materials.tension import LinearTension, kinked

LEAST_RUN = wp.constant(wp.float64(0.05))
"""Run of a yarn along a cell over its length, at least [-]: steeper ones stand on end."""


@wp.struct
class SlidLoads:
    """Slopes of w [N/m]."""

    pull: wp.vec2d  # ∂w/∂ρ
    draw: wp.vec2d  # −∂w/∂λ


@wp.func
def alone(family: int, strain: wp.vec2d) -> wp.vec2d:
    """Strains of which one family keeps its own [-]."""
    if family == 0:
        return wp.vec2d(strain[0], wp.float64(0.0))
    return wp.vec2d(wp.float64(0.0), strain[1])


def make_no_press(Tension):
    """Make the function of a law that does not know how its yarns climb over each other."""

    @wp.func
    def no_press(law: Tension, distance: wp.vec2d, yarn: wp.vec2d) -> wp.float64:
        return wp.float64(0.0)

    return no_press


@wp.func
def linear_own_loads(law: LinearTension, family: int, distance: wp.float64, yarn: wp.float64):
    """∂w_f/∂ρ and −∂w_f/∂λ [N/m] of linear yarns: N and (1 + ½ ε) N."""
    strain = distance / yarn - wp.float64(1.0)
    pull = law.stiffness[family] * kinked(strain, law.compressive_factor)
    return wp.vec2d(pull, pull * (wp.float64(1.0) + wp.float64(0.5) * strain))


@wp.func
def linear_own_energy(
    law: LinearTension, family: int, distance: wp.float64, yarn: wp.float64
) -> wp.float64:
    """w_f = ½ λ N ε [J/m²]."""
    strain = distance / yarn - wp.float64(1.0)
    pull = law.stiffness[family] * kinked(strain, law.compressive_factor)
    return wp.float64(0.5) * yarn * pull * strain


def make_slid_law(tension, tension_energy, Tension):
    """Make the functions of a law that knows only strains: ``(slid_loads, slid_energy)``.

    Args:
        tension: wp.func (law, strain) → line tensions [N/m].
        tension_energy: wp.func (law, strain) → energy per area [J/m²].
        Tension: struct of the law.
    """

    @wp.func
    def own_energy(law: Tension, family: int, strain: wp.vec2d) -> wp.float64:
        """φ of a family [J/m²]."""
        return tension_energy(law, alone(family, strain)) - tension_energy(law, wp.vec2d())

    @wp.func
    def slid_energy(law: Tension, distance: wp.vec2d, yarn: wp.vec2d) -> wp.float64:
        """W [J/m²] of ρ and λ, but for Φ(0, 0)."""
        strain = wp.cw_div(distance, yarn) - wp.vec2d(wp.float64(1.0), wp.float64(1.0))
        warp = own_energy(law, 0, strain)
        weft = own_energy(law, 1, strain)
        whole = tension_energy(law, strain) - tension_energy(law, wp.vec2d())
        return yarn[0] * warp + yarn[1] * weft + (whole - warp - weft)

    @wp.func
    def slid_loads(law: Tension, distance: wp.vec2d, yarn: wp.vec2d) -> SlidLoads:
        """Slopes of `slid_energy`."""
        out = SlidLoads()
        stretch = wp.cw_div(distance, yarn)
        strain = stretch - wp.vec2d(wp.float64(1.0), wp.float64(1.0))
        both = tension(law, strain)
        for f in range(2):
            own = tension(law, alone(f, strain))[f]
            added = (both[f] - own) / yarn[f]
            out.pull[f] = own + added
            out.draw[f] = stretch[f] * (own + added) - own_energy(law, f, strain)
        return out

    return slid_loads, slid_energy


@wp.func
def with_yarn(law: CrimpInterchange, yarn: wp.vec2d) -> CrimpInterchange:
    """The cell with λ of yarn in it, flat where this climbs as high as before."""
    out = CrimpInterchange()
    out.height = law.height
    out.stiffness = law.stiffness
    out.cell_area = law.cell_area
    out.compressive_factor = law.compressive_factor
    for f in range(2):
        length = yarn[f] * law.length[f]
        out.length[f] = length
        run = length * length - law.height[f] * law.height[f]
        out.spacing[f] = wp.sqrt(wp.max(run, LEAST_RUN * LEAST_RUN * length * length))
    return out


@wp.func
def strain_in(law: CrimpInterchange, cell: CrimpInterchange, distance: wp.vec2d) -> wp.vec2d:
    """Strain of a cell `with_yarn` [-] at ρ."""
    one = wp.float64(1.0)
    return wp.vec2d(
        distance[0] * law.spacing[0] / cell.spacing[0] - one,
        distance[1] * law.spacing[1] / cell.spacing[1] - one,
    )


@wp.func
def slid_crimp_energy(law: CrimpInterchange, distance: wp.vec2d, yarn: wp.vec2d) -> wp.float64:
    """W [J/m²] of saw-tooth yarns."""
    cell = with_yarn(law, yarn)
    strain = strain_in(law, cell, distance)
    stretch = yarn_stretches(cell, strain)
    warp = family_energy(cell, 0, strain[0], stretch[0])
    return warp + family_energy(cell, 1, strain[1], stretch[1])


@wp.func
def slid_crimp_loads(law: CrimpInterchange, distance: wp.vec2d, yarn: wp.vec2d) -> SlidLoads:
    """Slopes of `slid_crimp_energy`, heights at balance.

    With e the strain of the yarn itself,

    −∂w/∂λ = EA l/S [e + ½ e² + c (ε (1 + ε) − ½ ε²) λ l/p], the last where ε < 0.
    """
    half = wp.float64(0.5)
    one = wp.float64(1.0)
    out = SlidLoads()
    cell = with_yarn(law, yarn)
    strain = strain_in(law, cell, distance)
    stretch = yarn_stretches(cell, strain)
    for f in range(2):
        e = stretch[f]
        pulled = family_tension(cell, f, strain[f], e)
        out.pull[f] = pulled * law.spacing[f] / cell.spacing[f]
        below = wp.min(strain[f], wp.float64(0.0))
        pressed = law.compressive_factor * (below * (one + below) - half * below * below)
        pressed = pressed * cell.length[f] / cell.spacing[f]
        size = law.stiffness[f] * law.length[f] / law.cell_area
        out.draw[f] = size * (e + half * e * e + pressed)
    return out


@wp.func
def crimp_press(law: CrimpInterchange, distance: wp.vec2d, yarn: wp.vec2d) -> wp.float64:
    """Force of the yarns of a crossing on each other [N]: 2 t h/L, the same of both at balance."""
    cell = with_yarn(law, yarn)
    strain = strain_in(law, cell, distance)
    rise = exchanged_height(cell, strain)
    warp = climb_force(cell, 0, strain[0], rise)[0]
    return warp + climb_force(cell, 1, strain[1], -rise)[0]
