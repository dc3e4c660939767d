"""What a bar whose yarn slides pulls with: its own tension, and what its crossings add.

    W = Σ_bars w l0 w_f(ρ, λ) + Σ_quadrants A a1 a2 χ

With w(ρ1, ρ2, λ1, λ2) the energy per flat area (`slid_laws`), w_f is that of a family by itself,
the other as it lies flat, and χ = w − w_1 − w_2. A quadrant is where a bar of the warp meets one of
the weft, A its flat area; a, the product of g(c) = c² (3 − 2c) of a bar's crossovers, lets the
coupling go as a yarn's end goes by, without a jump of any force. Without slides this is the energy
of pinned crossovers; with a law of each family alone χ = 0.

Forces are slopes of it: F = ∂W/∂d draws the ends together, G = −∂W/∂l draws yarn in, and where a
share is falling −∂W/∂c acts on the slide through its crossover.
"""

import warp as wp

from .yarn_chains import (
    Bars,
    Crossovers,
    Slide,
    bar_distance,
    bar_holds,
    bar_material,
    end_shares,
    left_slope,
)

NONE = wp.constant(-1)


@wp.struct
class BarLoads:
    """What a bar does; no loads where it holds no more."""

    holds: bool  # whether there is yarn in both of its crossovers
    distance: wp.float64  # d [m]
    material: wp.float64  # l [m]
    tension: wp.float64  # F/w = ∂W/∂d over its width [N/m]
    draw: wp.float64  # G/w = −∂W/∂l over its width [N/m]
    ends: wp.vec2d  # −∂W/∂c ∂c/∂s of its lower and upper crossover [N]


@wp.func
def faded(share: wp.float64) -> wp.float64:
    """g(c) [-]."""
    return share * share * (wp.float64(3.0) - wp.float64(2.0) * share)


@wp.func
def faded_slope(share: wp.float64) -> wp.float64:
    """dg/dc [-]."""
    return wp.float64(6.0) * share * (wp.float64(1.0) - share)


@wp.func
def of_both(family: int, own: wp.float64, other: wp.float64) -> wp.vec2d:
    """Of warp and weft, given what is of a family and of the other."""
    if family == 0:
        return wp.vec2d(own, other)
    return wp.vec2d(other, own)


@wp.func
def drawn_out(
    bars: Bars, b: int, slides: wp.array(dtype=Slide), x: wp.array(dtype=wp.vec3d)
) -> wp.vec2d:
    """ρ and λ of a bar [-]."""
    flat = bars.lengths[b]
    return wp.vec2d(bar_distance(bars, b, x) / flat, bar_material(bars, b, slides) / flat)


@wp.func
def unloaded(
    bars: Bars,
    crossovers: Crossovers,
    b: int,
    slides: wp.array(dtype=Slide),
    x: wp.array(dtype=wp.vec3d),
) -> BarLoads:
    """What a bar has, before its law is asked."""
    out = BarLoads()
    out.distance = bar_distance(bars, b, x)
    out.material = bar_material(bars, b, slides)
    out.holds = bar_holds(bars, crossovers, b, slides)
    return out


def make_no_tension(Tension):
    """Make the law of quadrants whose tensions are counted here: ``(tension, tension_energy)``.

    Args:
        Tension: struct of the tension law.
    """

    @wp.func
    def no_tension(law: Tension, strain: wp.vec2d) -> wp.vec2d:
        return wp.vec2d()

    @wp.func
    def no_energy(law: Tension, strain: wp.vec2d) -> wp.float64:
        return wp.float64(0.0)

    return no_tension, no_energy


def make_own(slid_loads, slid_energy, Tension):
    """Make a family's own part of a law of both: ``(own_loads, own_energy)``.

    Args:
        slid_loads: wp.func (law, ρ, λ) → `slid_laws.SlidLoads`.
        slid_energy: wp.func (law, ρ, λ) → energy per flat area [J/m²].
        Tension: struct of the law.
    """

    @wp.func
    def own_loads(law: Tension, family: int, distance: wp.float64, yarn: wp.float64):
        one = wp.float64(1.0)
        loads = slid_loads(law, of_both(family, distance, one), of_both(family, yarn, one))
        return wp.vec2d(loads.pull[family], loads.draw[family])

    @wp.func
    def own_energy(law: Tension, family: int, distance: wp.float64, yarn: wp.float64) -> wp.float64:
        one = wp.float64(1.0)
        return slid_energy(law, of_both(family, distance, one), of_both(family, yarn, one))

    return own_loads, own_energy


def make_lone_loads(own_loads, own_energy, Tension):
    """Make the functions of a law of each family alone: ``(bar_loads, bar_energy)``.

    Args:
        own_loads: wp.func (law, family, ρ, λ) → ∂w_f/∂ρ and −∂w_f/∂λ [N/m], which depend on ρ/λ.
        own_energy: wp.func (law, family, ρ, λ) → w_f [J/m²], of twice ρ and λ twice as much.
        Tension: struct of the law.
    """

    @wp.func
    def bar_loads(
        law: Tension,
        bars: Bars,
        crossovers: Crossovers,
        b: int,
        slides: wp.array(dtype=Slide),
        x: wp.array(dtype=wp.vec3d),
    ) -> BarLoads:
        """Slopes of the energy by what a bar has: distance and yarn."""
        out = unloaded(bars, crossovers, b, slides, x)
        if out.holds:
            own = own_loads(law, bars.family[b], out.distance, out.material)
            out.tension = own[0]
            out.draw = own[1]
        return out

    @wp.func
    def bar_energy(
        law: Tension,
        bars: Bars,
        crossovers: Crossovers,
        b: int,
        slides: wp.array(dtype=Slide),
        x: wp.array(dtype=wp.vec3d),
    ) -> wp.float64:
        """Energy [J] of a bar's yarn."""
        distance = bar_distance(bars, b, x)
        material = bar_material(bars, b, slides)
        return bars.widths[b] * own_energy(law, bars.family[b], distance, material)

    return bar_loads, bar_energy


def make_coupled_loads(slid_loads, slid_energy, Tension):
    """Make the functions of a law of both families: ``(bar_loads, bar_energy)``.

    Args:
        slid_loads: wp.func (law, ρ, λ) → `slid_laws.SlidLoads`.
        slid_energy: wp.func (law, ρ, λ) → energy per flat area [J/m²].
        Tension: struct of the law.
    """
    own_loads, own_energy = make_own(slid_loads, slid_energy, Tension)

    @wp.func
    def coupling(law: Tension, family: int, at: wp.vec2d, mate: wp.vec2d) -> wp.float64:
        """χ [J/m²] of ρ and λ of a family's bar, and of one of the other family."""
        whole = slid_energy(law, of_both(family, at[0], mate[0]), of_both(family, at[1], mate[1]))
        own = own_energy(law, family, at[0], at[1])
        return whole - own - own_energy(law, 1 - family, mate[0], mate[1])

    @wp.func
    def bar_loads(
        law: Tension,
        bars: Bars,
        crossovers: Crossovers,
        b: int,
        slides: wp.array(dtype=Slide),
        x: wp.array(dtype=wp.vec3d),
    ) -> BarLoads:
        """Slopes of the energy by what a bar has: distance, yarn, shares of its crossovers."""
        out = unloaded(bars, crossovers, b, slides, x)
        if not out.holds:
            return out
        shares = end_shares(bars, crossovers, b, slides)
        f = bars.family[b]
        at = drawn_out(bars, b, slides, x)
        own = own_loads(law, f, at[0], at[1])
        out.tension = own[0]
        out.draw = own[1]
        size = bars.widths[b] * bars.lengths[b]
        ends = bars.numbers[b]
        kept = wp.vec2d(faded(shares[0]), faded(shares[1]))
        slopes = wp.vec2d(
            faded_slope(shares[0]) * left_slope(crossovers, ends[0], f, slides[ends[0]].s[f]),
            faded_slope(shares[1]) * left_slope(crossovers, ends[1], f, slides[ends[1]].s[f]),
        )
        leaving = wp.length_sq(slopes) > wp.float64(0.0)
        for k in range(4):
            mate = bars.mates[b][k]
            if mate != NONE:
                there = end_shares(bars, crossovers, mate, slides)
                area = bars.areas[b][k] * faded(there[0]) * faded(there[1])
                if area > wp.float64(0.0):
                    by = drawn_out(bars, mate, slides, x)
                    both = slid_loads(law, of_both(f, at[0], by[0]), of_both(f, at[1], by[1]))
                    portion = area * kept[0] * kept[1] / size
                    out.tension += portion * (both.pull[f] - own[0])
                    out.draw += portion * (both.draw[f] - own[1])
                    if leaving:
                        lost = area * coupling(law, f, at, by)
                        out.ends[0] -= lost * slopes[0] * kept[1]
                        out.ends[1] -= lost * slopes[1] * kept[0]
        return out

    @wp.func
    def bar_energy(
        law: Tension,
        bars: Bars,
        crossovers: Crossovers,
        b: int,
        slides: wp.array(dtype=Slide),
        x: wp.array(dtype=wp.vec3d),
    ) -> wp.float64:
        """Energy [J] of a bar's yarn, and half of that of its quadrants."""
        f = bars.family[b]
        at = drawn_out(bars, b, slides, x)
        total = bars.widths[b] * bars.lengths[b] * own_energy(law, f, at[0], at[1])
        shares = end_shares(bars, crossovers, b, slides)
        kept = faded(shares[0]) * faded(shares[1])
        for k in range(4):
            mate = bars.mates[b][k]
            if mate != NONE:
                there = end_shares(bars, crossovers, mate, slides)
                area = kept * bars.areas[b][k] * faded(there[0]) * faded(there[1])
                if area > wp.float64(0.0):
                    by = drawn_out(bars, mate, slides, x)
                    total += wp.float64(0.5) * area * coupling(law, f, at, by)
        return total

    return bar_loads, bar_energy
