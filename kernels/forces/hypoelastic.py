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
    weft: wp.vec3d  # k2 [-]
    strain: wp.vec3d  # of warp and weft [-] and shear [rad], as its frame has seen them
    couple: wp.float64  # C [N/m]
    work: wp.vec3d  # done so far on yarns, shear and stabiliser, per area [J/m²]


@wp.struct
class PatchState:
    """State of a patch: what its triangles share."""

    strain: wp.vec2d  # mean of warp and weft, as the frames have seen them [-]
    change: wp.vec2d  # of it in the last step [-]
    tension: wp.vec2d  # N1, N2 in the frames [N/m]
    lost: wp.float64  # to the yarns' viscosity [J]


@wp.struct
class SheetStep:
    """What a triangle's frame sees of a step."""

    change: wp.vec3d  # Δε, with the shape in its middle
    before: wp.vec3d  # strains on which the stresses before do their work
    after: wp.vec3d  # … and those after
    rows: wp.mat33d  # B after it


@wp.struct
class PatchStep:
    """A patch's step: mean of the triangles' over the area."""

    change: wp.vec2d  # [-]
    before: wp.vec2d  # [-]
    after: wp.vec2d  # [-]
    strain: wp.vec2d  # of the yarns after it, k̂ [-]
    area: wp.float64  # m²


@wp.struct
class Sheets:
    """A ply's triangles by patch."""

    offsets: wp.array(dtype=wp.int32)  # first member of each patch, and their number
    members: wp.array(dtype=wp.int32)  # triangles by patch
    triangles: wp.array2d(dtype=wp.int32)  # vertices, shape [triangle, 3]
    gradients: wp.array(dtype=wp.vec4d)  # D [1/m], shape [triangle]
    areas: wp.array(dtype=wp.float64)  # flat [m²], shape [triangle]
    stabiliser: wp.float64  # κ C'(0) [N/m]
    rest_angle: wp.float64  # from warp to weft of the flat ply [rad]
    viscosity: wp.vec2d  # line tension of warp and weft per change of strain in a step [N/m]


@wp.func
def yarn_vector(sheets: Sheets, t: int, family: int, x: wp.array(dtype=wp.vec3d)) -> wp.vec3d:
    """Current k1 (family 0) or k2 of a triangle [-]."""
    origin = x[sheets.triangles[t, 0]]
    edge_b = x[sheets.triangles[t, 1]] - origin
    edge_c = x[sheets.triangles[t, 2]] - origin
    if family == 0:
        return warp_vector(sheets.gradients[t], edge_b, edge_c)
    return weft_vector(sheets.gradients[t], edge_b, edge_c)


@wp.func
def first_two(v: wp.vec3d) -> wp.vec2d:
    """Of warp and weft."""
    return wp.vec2d(v[0], v[1])


def make_hypoelastic(rows, tension, shear, Tension, Shear, woven):
    """Make the kernels for a frame and a pair of laws: ``(add_stress_forces, measure_stress)``.

    Args:
        rows: wp.func (metric, rest angle) → B of the frame; see `objective_rates`.
        tension: wp.func (law, strain) → line tensions [N/m].
        shear: wp.func (law, angle) → couple per area [N/m].
        Tension: struct of the tension law.
        Shear: struct of the shear law.
        woven: whether the sheet has yarns, whose tensions are then shown without the shear's part.
    """
    yarns = wp.constant(wp.float64(1.0 if woven else 0.0))

    @wp.func
    def sheet_step(known: SheetState, k1: wp.vec3d, k2: wp.vec3d, angle: wp.float64) -> SheetStep:
        half = wp.float64(0.5)
        d1 = k1 - known.warp
        d2 = k2 - known.weft
        g = metric(known.warp, known.weft)
        h = change_of_shape(known.warp, known.weft, d1, d2)
        now = metric(k1, k2)
        after = change_of_shape(k1, k2, d1, d2)
        out = SheetStep()
        out.rows = rows(now, angle)
        out.change = rows(half * (g + now), angle) * (half * (h + after))
        out.before = rows(g, angle) * h
        out.after = out.rows * after
        return out

    @wp.func
    def patch_step(
        sheets: Sheets, patch: int, x: wp.array(dtype=wp.vec3d), states: wp.array(dtype=SheetState)
    ) -> PatchStep:
        out = PatchStep()
        for slot in range(sheets.offsets[patch], sheets.offsets[patch + 1]):
            t = sheets.members[slot]
            k1 = yarn_vector(sheets, t, 0, x)
            k2 = yarn_vector(sheets, t, 1, x)
            step = sheet_step(states[t], k1, k2, sheets.rest_angle)
            area = sheets.areas[t]
            out.change += area * first_two(step.change)
            out.before += area * first_two(step.before)
            out.after += area * first_two(step.after)
            out.strain += area * triangle_strain(k1, k2)
            out.area += area
        out.change = out.change / out.area
        out.before = out.before / out.area
        out.after = out.after / out.area
        out.strain = out.strain / out.area
        return out

    @wp.func
    def patch_after(
        known: PatchState, step: PatchStep, law: Tension, viscosity: wp.vec2d
    ) -> PatchState:
        out = PatchState()
        out.strain = known.strain + step.change
        out.change = step.change
        out.tension = known.tension + (tension(law, out.strain) - tension(law, known.strain))
        drag = wp.cw_mul(known.change, step.before) + wp.cw_mul(step.change, step.after)
        out.lost = known.lost + wp.float64(0.5) * step.area * wp.dot(viscosity, drag)
        return out

    @wp.func
    def sheet_after(
        known: SheetState,
        step: SheetStep,
        patch: PatchState,
        now: PatchState,
        law: Shear,
        stabiliser: wp.float64,
    ) -> SheetState:
        """State after a step, but for the yarn vectors; its work is that of the nodal forces."""
        half = wp.float64(0.5)
        out = SheetState()
        out.strain = known.strain + step.change
        out.couple = known.couple + (shear(law, out.strain[2]) - shear(law, known.strain[2]))
        before = first_two(step.before)
        after = first_two(step.after)
        held = wp.dot(first_two(known.strain) - patch.strain, before)
        held += wp.dot(first_two(out.strain) - now.strain, after)
        out.work = known.work + half * wp.vec3d(
            wp.dot(patch.tension, before) + wp.dot(now.tension, after),
            known.couple * step.before[2] + out.couple * step.after[2],
            stabiliser * held,
        )
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
        moved = patch_step(sheets, patch, x, states)
        known = patches[patch]
        now = patch_after(known, moved, tension_law, sheets.viscosity)
        patches[patch] = now
        line = now.tension + wp.cw_mul(sheets.viscosity, now.change)
        for slot in range(sheets.offsets[patch], sheets.offsets[patch + 1]):
            t = sheets.members[slot]
            k1 = yarn_vector(sheets, t, 0, x)
            k2 = yarn_vector(sheets, t, 1, x)
            before = states[t]
            step = sheet_step(before, k1, k2, sheets.rest_angle)
            after = sheet_after(before, step, known, now, shear_law, sheets.stabiliser)
            after.warp = k1
            after.weft = k2
            states[t] = after
            own = line + sheets.stabiliser * (first_two(after.strain) - now.strain)
            stress = wp.transpose(step.rows) * wp.vec3d(own[0], own[1], after.couple)
            stress *= sheets.areas[t]
            add_triangle_loads(
                sheets.triangles[t, 0],
                sheets.triangles[t, 1],
                sheets.triangles[t, 2],
                sheets.gradients[t],
                stress[0] * k1 + stress[2] * k2,
                stress[2] * k1 + stress[1] * k2,
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
            strain: the patch's mean yarn strains [-], shape [triangle]; overwritten.
            line_tension: tensions along the yarns [N/m], shape [triangle]; overwritten.
            couple: shear couple on the yarns' angle [N/m], shape [triangle]; overwritten.
            work: on yarns, shear and stabiliser so far [J], shape [triangle]; overwritten.
            lost: to the yarns' viscosity so far [J], shape [patch]; overwritten.
        """
        patch = wp.tid()
        moved = patch_step(sheets, patch, x, states)
        known = patches[patch]
        now = patch_after(known, moved, tension_law, sheets.viscosity)
        lost[patch] = now.lost
        for slot in range(sheets.offsets[patch], sheets.offsets[patch + 1]):
            t = sheets.members[slot]
            k1 = yarn_vector(sheets, t, 0, x)
            k2 = yarn_vector(sheets, t, 1, x)
            step = sheet_step(states[t], k1, k2, sheets.rest_angle)
            after = sheet_after(states[t], step, known, now, shear_law, sheets.stabiliser)
            stress = wp.transpose(step.rows) * wp.vec3d(
                now.tension[0], now.tension[1], after.couple
            )
            g = metric(k1, k2)
            strain[t] = moved.strain
            shown = stress
            shown[2] = yarns * stress[2]
            line_tension[t] = along_yarns(g, shown)
            couple[t] = stress[2] * wp.sqrt(wp.max(g[0] * g[1] - g[2] * g[2], wp.float64(0.0)))
            work[t] = sheets.areas[t] * after.work

    return add_stress_forces, measure_stress
