"""Membrane triangles whose stress is a state: hypoelastic laws, eqs. [1] to [3] of the paper.

As Hughes & Winget (1980) step it, stress in a frame that turns with the sheet grows by

    Δσ = C Δε,   Δε = B(ḡ) h̄

with the shape ḡ and the change h̄ in the middle of the step, so that rotation alone changes
nothing; ḡ is the mean of the metrics before and after, where they take that of the middle
positions, equal to second order and blind to rotations of any size. C is the mean of the card's
tangents over the step, ∂N/∂ε and dC/dγ at the strains that the frame has seen so far.

Stress is per initial area (Kirchhoff's, times thickness): cells do not lose yarns when they are
sheared. Yarn strains are averaged over a patch of triangles as in `membrane`; each triangle carries
the patch's tensions in its own frame, and its own couple.
"""

import warp as wp

from ..materials.yarns import warp_vector, weft_vector
from .membrane import add_triangle_loads, triangle_strain
from .objective_rates import along_yarns, change_of_shape, metric


@wp.struct
class SheetState:
    """State of a triangle, at the positions of its last forces."""

    warp: wp.vec3d  # k1 [-]
    weft: wp.vec3d
    strain: wp.vec3d  # of warp and weft [-] and shear [rad], as its frame has seen them
    couple: wp.float64  # C [N/m]


@wp.struct
class PatchState:
    """State of a patch: what its triangles share, and the work done on them."""

    strain: wp.vec2d  # mean of warp and weft, as the frames have seen them [-]
    change: wp.vec2d  # of it in the last step [-]
    tension: wp.vec2d  # N1, N2 in the frames [N/m]
    work: wp.vec3d  # done so far on yarns, shear and stabiliser [J]
    lost: wp.float64  # to the yarns' viscosity [J]


@wp.struct
class SheetStep:
    """What a triangle's frame sees of a step."""

    change: wp.vec3d  # Δε, with the shape in its middle
    before: wp.vec3d  # strains on which the stresses before do their work
    after: wp.vec3d  # … and those after


@wp.struct
class PatchStep:
    """A patch's step: sums over its triangles, strains as means over the area."""

    area: wp.float64  # m²
    change: wp.vec2d  # [-]
    before: wp.vec2d  # [-]
    after: wp.vec2d  # [-]
    sheared: wp.float64  # work on the couples [J]
    apart: wp.float64  # work on the triangles' own strains, over the stabiliser [m²]
    yarns: wp.vec2d  # strains of the yarns themselves after it [-]


@wp.struct
class Sheets:
    """A ply's triangles by patch."""

    offsets: wp.array(dtype=wp.int32)  # first member of each patch, and their number
    members: wp.array(dtype=wp.int32)  # triangles by patch
    triangles: wp.array2d(dtype=wp.int32)  # vertices, shape [triangle, 3]
    gradients: wp.array(dtype=wp.vec4d)  # D [1/m], shape [triangle]
    areas: wp.array(dtype=wp.float64)  # flat [m²], shape [triangle]
    stabiliser: wp.array(dtype=wp.float64)  # κ C'(0) [N/m], shape [patch]
    rest: wp.vec2d  # cos θ0 and sin θ0 of the flat ply [-]
    viscosity: wp.vec2d  # line tension of warp and weft per change of strain in a step [N/m]


@wp.func
def first_two(v: wp.vec3d) -> wp.vec2d:
    """Of warp and weft."""
    return wp.vec2d(v[0], v[1])


def make_hypoelastic(rows, tension, shear, Tension, Shear, woven):
    """Make the kernels for a frame and a pair of laws: ``(add_stress_forces, measure_stress)``.

    Args:
        rows: wp.func (metric, (cos θ0, sin θ0)) → B of the frame; see `objective_rates`.
        tension: wp.func (law, strain) → line tensions [N/m].
        shear: wp.func (law, angle) → couple per area [N/m].
        Tension: struct of the tension law.
        Shear: struct of the shear law.
        woven: whether the sheet has yarns, whose tensions are then shown without the shear's part.
    """
    yarns = wp.constant(wp.float64(1.0 if woven else 0.0))

    @wp.func
    def sheet_step(known: SheetState, k1: wp.vec3d, k2: wp.vec3d, rest: wp.vec2d) -> SheetStep:
        half = wp.float64(0.5)
        d1 = k1 - known.warp
        d2 = k2 - known.weft
        g = metric(known.warp, known.weft)
        h = change_of_shape(known.warp, known.weft, d1, d2)
        now = metric(k1, k2)
        after = change_of_shape(k1, k2, d1, d2)
        out = SheetStep()
        out.change = rows(half * (g + now), rest) * (half * (h + after))
        out.before = rows(g, rest) * h
        out.after = rows(now, rest) * after
        return out

    @wp.func
    def step_sheets(
        sheets: Sheets,
        patch: int,
        law: Shear,
        x: wp.array(dtype=wp.vec3d),
        states: wp.array(dtype=SheetState),
        moved: wp.array(dtype=SheetState),
    ) -> PatchStep:
        """Step a patch's triangles from ``states`` to ``moved``, which may be the same."""
        half = wp.float64(0.5)
        out = PatchStep()
        for slot in range(sheets.offsets[patch], sheets.offsets[patch + 1]):
            t = sheets.members[slot]
            known = states[t]
            now = SheetState()
            origin = x[sheets.triangles[t, 0]]
            edge_b = x[sheets.triangles[t, 1]] - origin
            edge_c = x[sheets.triangles[t, 2]] - origin
            now.warp = warp_vector(sheets.gradients[t], edge_b, edge_c)
            now.weft = weft_vector(sheets.gradients[t], edge_b, edge_c)
            step = sheet_step(known, now.warp, now.weft, sheets.rest)
            now.strain = known.strain + step.change
            rise = shear(law, now.strain[2]) - shear(law, known.strain[2])
            now.couple = known.couple + rise
            moved[t] = now
            area = sheets.areas[t]
            before = first_two(step.before)
            after = first_two(step.after)
            out.area += area
            out.change += area * first_two(step.change)
            out.before += area * before
            out.after += area * after
            out.sheared += (half * area) * (
                known.couple * step.before[2] + now.couple * step.after[2]
            )
            out.apart += (half * area) * (
                wp.dot(first_two(known.strain), before) + wp.dot(first_two(now.strain), after)
            )
            out.yarns += area * triangle_strain(now.warp, now.weft)
        out.change = out.change / out.area
        out.before = out.before / out.area
        out.after = out.after / out.area
        out.yarns = out.yarns / out.area
        return out

    @wp.func
    def step_patch(
        known: PatchState, patch: int, step: PatchStep, law: Tension, sheets: Sheets
    ) -> PatchState:
        """State after a step; work and loss are those of the nodal forces, to rounding."""
        half = wp.float64(0.5) * step.area
        out = PatchState()
        out.strain = known.strain + step.change
        out.change = step.change
        out.tension = known.tension + (tension(law, out.strain) - tension(law, known.strain))
        drawn = wp.dot(known.tension, step.before) + wp.dot(out.tension, step.after)
        mean = wp.dot(known.strain, step.before) + wp.dot(out.strain, step.after)
        out.work = known.work + wp.vec3d(
            half * drawn, step.sheared, sheets.stabiliser[patch] * (step.apart - half * mean)
        )
        drag = wp.cw_mul(known.change, step.before) + wp.cw_mul(step.change, step.after)
        out.lost = known.lost + half * wp.dot(sheets.viscosity, drag)
        return out

    @wp.kernel(module="unique", enable_backward=False)
    def add_stress_forces(
        first: int,
        sheets: Sheets,
        tension_law: Tension,
        shear_law: Shear,
        x: wp.array(dtype=wp.vec3d),
        states: wp.array(dtype=SheetState),
        patches: wp.array(dtype=PatchState),
        f: wp.array(dtype=wp.vec3d),
    ):
        """Step the stress and add its forces to ``f``; one thread a patch of triangles.

        Args:
            first: number of the first patch.
            sheets: the triangles.
            tension_law: line tension law [N/m].
            shear_law: shear couple law [N/m].
            x: positions [m], shape [vertex].
            states: of triangles, shape [triangle]; updated.
            patches: of patches, shape [patch]; updated.
            f: forces [N], shape [vertex]; accumulated.
        """
        patch = first + wp.tid()
        step = step_sheets(sheets, patch, shear_law, x, states, states)
        now = step_patch(patches[patch], patch, step, tension_law, sheets)
        patches[patch] = now
        line = now.tension + wp.cw_mul(sheets.viscosity, now.change)
        for slot in range(sheets.offsets[patch], sheets.offsets[patch + 1]):
            t = sheets.members[slot]
            sheet = states[t]
            own = line + sheets.stabiliser[patch] * (first_two(sheet.strain) - now.strain)
            across = rows(metric(sheet.warp, sheet.weft), sheets.rest)
            stress = wp.transpose(across) * wp.vec3d(own[0], own[1], sheet.couple)
            stress *= sheets.areas[t]
            add_triangle_loads(
                sheets.triangles[t, 0],
                sheets.triangles[t, 1],
                sheets.triangles[t, 2],
                sheets.gradients[t],
                stress[0] * sheet.warp + stress[2] * sheet.weft,
                stress[2] * sheet.warp + stress[1] * sheet.weft,
                f,
            )

    @wp.kernel(module="unique", enable_backward=False)
    def measure_stress(
        sheets: Sheets,
        tension_law: Tension,
        shear_law: Shear,
        states: wp.array(dtype=SheetState),
        patches: wp.array(dtype=PatchState),
        x: wp.array(dtype=wp.vec3d),
        moved: wp.array(dtype=SheetState),
        strain: wp.array(dtype=wp.vec2d),
        line_tension: wp.array(dtype=wp.vec2d),
        couple: wp.array(dtype=wp.float64),
        work: wp.array(dtype=wp.vec3d),
        lost: wp.array(dtype=wp.float64),
    ):
        """Compute what triangles show at positions, whose step is yet to come; one thread a patch.

        Args:
            sheets: the triangles.
            tension_law: line tension law [N/m].
            shear_law: shear couple law [N/m].
            states: of triangles, shape [triangle].
            patches: of patches, shape [patch].
            x: positions [m], shape [vertex].
            moved: states there, shape [triangle]; overwritten.
            strain: the patch's mean yarn strains [-], shape [triangle]; overwritten.
            line_tension: tensions along the yarns [N/m], shape [triangle]; overwritten.
            couple: shear couple on the yarns' angle [N/m], shape [triangle]; overwritten.
            work: on yarns, shear and stabiliser so far [J], shape [patch]; overwritten.
            lost: to the yarns' viscosity so far [J], shape [patch]; overwritten.
        """
        patch = wp.tid()
        step = step_sheets(sheets, patch, shear_law, x, states, moved)
        now = step_patch(patches[patch], patch, step, tension_law, sheets)
        work[patch] = now.work
        lost[patch] = now.lost
        for slot in range(sheets.offsets[patch], sheets.offsets[patch + 1]):
            t = sheets.members[slot]
            sheet = moved[t]
            g = metric(sheet.warp, sheet.weft)
            stress = wp.transpose(rows(g, sheets.rest)) * wp.vec3d(
                now.tension[0], now.tension[1], sheet.couple
            )
            couple[t] = stress[2] * wp.sqrt(wp.max(g[0] * g[1] - g[2] * g[2], wp.float64(0.0)))
            stress[2] = yarns * stress[2]
            line_tension[t] = along_yarns(g, stress)
            strain[t] = step.yarns

    return add_stress_forces, measure_stress
