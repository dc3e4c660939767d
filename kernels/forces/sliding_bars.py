"""Bars of yarns that slide: their pull on the vertices, and the yarns' viscosity in them."""

import warp as wp

from .yarn_chains import (
    Bars,
    Crossovers,
    Slide,
    bar_strain,
)


@wp.struct
class BarMemory:
    """What a bar remembers for its viscosity."""

    lengthening: wp.float64  # distance of its ends less its yarn, over l0, in the step before [-]
    change: wp.float64  # up to it [-]
    lost: wp.float64  # [J]


@wp.func
def bar_drag(
    bars: Bars, b: int, known: BarMemory, distance: wp.float64, material: wp.float64
) -> wp.float64:
    """Line tension of the yarns' viscosity [N/m], against vertices and slides alike."""
    lengthening = (distance - material) / bars.lengths[b]
    return bars.viscosity[bars.family[b]] * (lengthening - known.lengthening)


@wp.func
def bar_after_step(
    bars: Bars, b: int, known: BarMemory, distance: wp.float64, material: wp.float64, holds: bool
) -> BarMemory:
    """Memory after a step: the drag before, η times the last change, acted over half of each."""
    now = BarMemory()
    now.lengthening = (distance - material) / bars.lengths[b]
    now.lost = known.lost
    if holds:
        now.change = now.lengthening - known.lengthening
        half = wp.float64(0.5) * known.change * (known.change + now.change)
        size = bars.widths[b] * bars.lengths[b] * bars.viscosity[bars.family[b]]
        now.lost += size * half
    return now


@wp.kernel(enable_backward=False)
def take_bars(first: int, kept: wp.array(dtype=BarMemory), memory: wp.array(dtype=BarMemory)):
    """Go on from what bars remember after a step; one thread a bar.

    Args:
        first: number of the first bar.
        kept: from `add_bar_forces`, shape [bar].
        memory: shape [bar]; overwritten.
    """
    b = first + wp.tid()
    memory[b] = kept[b]


def make_bar_kernels(bar_loads, bar_energy, Tension):
    """Make the kernels of bars for one law: ``(add_bar_forces, measure_bars)``.

    Args:
        bar_loads: from `bar_loads.make_lone_loads` or `make_coupled_loads`.
        bar_energy: likewise.
        Tension: struct of the tension law.
    """

    @wp.kernel(module="unique", enable_backward=False)
    def add_bar_forces(
        first: int,
        law: Tension,
        bars: Bars,
        crossovers: Crossovers,
        slides: wp.array(dtype=Slide),
        x: wp.array(dtype=wp.vec3d),
        memory: wp.array(dtype=BarMemory),
        kept: wp.array(dtype=BarMemory),
        f: wp.array(dtype=wp.vec3d),
    ):
        """Add the bars' tensions to ``f``; one thread a bar.

        Args:
            first: number of the first bar.
            law: line tension law [N/m].
            bars: of a ply.
            crossovers: of the ply.
            slides: of its crossovers, shape [crossover].
            x: positions [m], shape [vertex].
            memory: of bars, shape [bar].
            kept: the same after the step, shape [bar]; overwritten.
            f: forces [N], shape [vertex]; accumulated.
        """
        b = first + wp.tid()
        ends = bars.ends[b]
        along = x[ends[1]] - x[ends[0]]
        known = memory[b]
        loads = bar_loads(law, bars, crossovers, b, slides, x)
        distance = loads.distance
        material = loads.material
        if loads.holds:
            line = loads.tension + bar_drag(bars, b, known, distance, material)
            force = (bars.widths[b] * line / distance) * along
            wp.atomic_add(f, ends[0], force)
            wp.atomic_sub(f, ends[1], force)
        kept[b] = bar_after_step(bars, b, known, distance, material, loads.holds)

    @wp.kernel(module="unique", enable_backward=False)
    def measure_bars(
        law: Tension,
        bars: Bars,
        crossovers: Crossovers,
        slides: wp.array(dtype=Slide),
        x: wp.array(dtype=wp.vec3d),
        strain: wp.array(dtype=wp.float64),
        line_tension: wp.array(dtype=wp.float64),
        energy: wp.array(dtype=wp.float64),
    ):
        """Compute what bars show, nothing of those that a yarn has left; one thread a bar.

        Args:
            law: line tension law [N/m].
            bars: of a ply.
            crossovers: of the ply.
            slides: of its crossovers, shape [crossover].
            x: positions [m], shape [vertex].
            strain: [-], shape [bar]; overwritten.
            line_tension: [N/m], shape [bar]; overwritten.
            energy: [J], shape [bar]; overwritten.
        """
        b = wp.tid()
        loads = bar_loads(law, bars, crossovers, b, slides, x)
        line_tension[b] = loads.tension
        energy[b] = wp.float64(0.0)
        strain[b] = wp.float64(0.0)
        if loads.holds:
            energy[b] = bar_energy(law, bars, crossovers, b, slides, x)
            strain[b] = bar_strain(bars, b, slides, x)

    return add_bar_forces, measure_bars
