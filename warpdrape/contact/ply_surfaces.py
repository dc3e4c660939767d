"""The plies' surfaces as contacts search them: query meshes, triangles, normals, hollows."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import warp as wp

from warpdrape.contact.folds import cut_into_patches
from warpdrape.contact.law import near_reach
from warpdrape.contact.ply_facets import build_facets
from warpdrape.interaction import Bodies, Launch, Launches, Measured, Run, Share, Span, Swept
from warpdrape.kernels.contact import look_ahead
from warpdrape.kernels.contact import ply_surfaces as kernels
from warpdrape.kernels.contact.facets import PlyFacets
from warpdrape.kernels.contact.folds import Patches
from warpdrape.kernels.contact.on_ply import PlySearch
from warpdrape.setup import Setup
from warpdrape.state import PlyState
from warpdrape.timing import Timing, ask_every, peak_speed

FADING = 2e-4
"""Time in which a penetration that appeared by a jump of the gap is pushed out [s].

Pushing it out does work that nothing supplies: in the three-ply hemisphere about a hundredth of the
energy, at 4 ms a third of that, but then up to 0.2 mm are on their way out at a time, not 0.03 mm.
"""
PUSH_OUT = 0.1
"""… but no faster than at this share of the tools' speed [-]. A vertex that has slid over another
ply's border and back is found 2 mm deep; out in 0.2 ms it was thrown up at 40 m/s.
"""


@dataclass(frozen=True, eq=False)
class PlySurfaces:
    """Surfaces of all plies; what moves with them is made anew at every search.

    Attributes:
        device: Warp device.
        scene: what is computed.
        timing: the steps.
        spans: where plies are.
        facets: the plies' triangles.
        meshes: per ply, moved along for searches.
        normals: at vertices [-], shape [vertex].
        hollows: room on either side of a vertex [m], shape [vertex].
        patches: all plies cut into patches, which say where one may have folded.
        patch_runs: which patches are of each ply.
        shapes: whether normals and hollows are needed; self-contact does without.
    """

    device: str
    scene: Setup
    timing: Timing
    spans: tuple[Span, ...]
    facets: PlyFacets
    meshes: tuple[wp.Mesh, ...]
    normals: wp.array
    hollows: wp.array
    patches: Patches
    patch_runs: tuple[Run, ...]
    shapes: bool
    name: str = "ply surfaces"
    searches: str = "ply surfaces"

    def start(self) -> None:
        """Nothing to remember; how fast plies are is theirs to tell."""

    def launches(self, share: Share, bodies: Bodies, memory: None) -> Launches:
        """A part's own vertices, and the query meshes in its care."""
        plies, part = bodies.plies, share.number
        x = plies.x
        prepare: list[Launch | Swept] = [Launch(look_ahead.forget_speed, 1, [part], [plies.speeds])]
        measure: list[Launch | Swept] = [self._set_pace(part, plies)]
        for run in share.vertices:
            inputs = [part, plies.v]
            prepare.append(Swept(look_ahead.find_speed, run, inputs, [plies.speeds]))
            if self.shapes:
                inputs, outputs = [self.facets, x], [self.normals]
                prepare.append(Swept(kernels.compute_vertex_normals, run, inputs, outputs))
                inputs = [self.facets, x, self.normals]
                measure.append(Swept(kernels.compute_hollows, run, inputs, [self.hollows]))
        copy = [
            Launch(
                kernels.copy_to_single,
                self.spans[number].vertex_count,
                [self.spans[number].first_vertex, x],
                [self.meshes[number].points],
            )
            for number in share.plies
        ]
        return Launches(
            prepare=tuple(prepare),
            copy=(Launch(look_ahead.say_asking, 1, [part], [plies.paces]), *copy),
            refit=tuple(self.meshes[number] for number in share.plies),
            measure=tuple(measure),
        )

    def _set_pace(self, part: int, plies: PlyState) -> Launch:
        thinnest = min(ply.fabric.thickness for ply in self.scene.plies)
        interval = self.timing.search_every * self.timing.time_step
        inputs = [part, near_reach(self.scene), interval, thinnest, plies.speeds]
        return Launch(look_ahead.set_pace, 1, inputs, [plies.paces])

    def measure(self, bodies: Bodies, memory: None) -> Measured:
        """Surfaces store no energy; whether contact between plies was looked for far enough."""
        outrun = float(bodies.plies.paces.numpy()["outrun"].max())
        return Measured(warnings=_passing(outrun) if len(self.scene.plies) > 1 else ())


def _passing(outrun: float) -> tuple[str, ...]:
    if outrun <= 1.0:
        return ()
    return (
        f"plies gained speed faster than contact between them looks ahead (by {outrun:.3g} times), "
        "so that they may have passed each other: load them more slowly, or set contact to exact",
    )


def build(
    scene: Setup, spans: tuple[Span, ...], timing: Timing, device: str, *, shapes: bool
) -> PlySurfaces:
    """Put the plies' surfaces on a device.

    Args:
        scene: what is computed.
        spans: where plies are.
        timing: the steps.
        device: Warp device.
        shapes: whether normals and hollows are needed.
    """
    meshes = tuple(
        wp.Mesh(
            wp.array(ply.rest_points, dtype=wp.vec3f, device=device),
            wp.array(np.ravel(ply.mesh.triangles), dtype=wp.int32, device=device),
        )
        for ply in scene.plies
    )
    vertices = spans[-1].vertices.stop
    patches, runs = cut_into_patches(scene.plies, spans, device)
    first_vertex = np.array([*(span.first_vertex for span in spans), vertices])
    return PlySurfaces(
        device,
        scene,
        timing,
        spans,
        build_facets([ply.mesh.triangles for ply in scene.plies], first_vertex, device),
        meshes,
        wp.zeros(vertices, dtype=wp.vec3d, device=device),
        wp.zeros(vertices, dtype=wp.vec2d, device=device),
        patches,
        runs,
        shapes,
    )


def ply_search(
    scene: Setup,
    timing: Timing,
    plies: PlyState,
    part: int,
    thickness: float,
    *,
    asking: bool,
) -> PlySearch:
    """How a part's searches look for plies that are touched at a thickness [m] at most."""
    search = PlySearch()
    search.asks, search.part, search.paces = int(asking), part, plies.paces
    search.thickness = thickness
    interval = timing.search_every * timing.time_step
    search.interval = interval
    search.asked = interval * ask_every(scene.numerics)
    search.keep = math.exp(-interval / FADING)
    search.ease = PUSH_OUT * peak_speed(scene) * interval
    return search
