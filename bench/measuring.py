"""What measuring a frame takes as meshes get finer: ``python bench measuring [CELLS ...]``.

A coarse run of three plies is made, and its frames are carried over to finer meshes by smooth
interpolation: their shapes are those of a formed stack, without the hours that forming it takes.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from functools import partial
from types import SimpleNamespace

import numpy as np
import warp as wp
from scipy.interpolate import CloughTocher2DInterpolator

from warpdrape.contact.face_depths import FaceDepths
from warpdrape.defects.gaps import ToolGaps
from warpdrape.defects.wrinkles import WrinkleSearch
from warpdrape.dynamics.model import build_model
from warpdrape.scenes import three_ply_hemisphere
from warpdrape.setup import Setup
from warpdrape.tools.pose import Pose
from warpdrape.watch import Watch

COARSE = 20
"""Cells of the run whose frames are carried over."""
INSIDE = 1.0 - 1e-6
"""By which a finer blank is drawn in, so that its rim lies inside the coarse one."""


class Frame:
    """Positions of the vertices [m], and poses of the tools, as a state has them."""

    def __init__(self, x: np.ndarray, poses: Sequence[Pose]) -> None:
        self.x, self._poses = x, list(poses)
        self.plies = SimpleNamespace(x=wp.array(x, dtype=wp.vec3d, device="cpu"))
        self.tools = SimpleNamespace(poses=lambda: self._poses)

    def on(self, coarse: Setup, fine: Setup) -> Frame:
        """The same shapes on other meshes."""
        own = np.split(self.x, np.cumsum([len(ply.rest_points) for ply in coarse.plies])[:-1])
        carried = [
            CloughTocher2DInterpolator(a.rest_points[:, :2], x)(INSIDE * b.rest_points[:, :2])
            for a, b, x in zip(coarse.plies, fine.plies, own, strict=True)
        ]
        return Frame(np.concatenate(carried), self._poses)


def frames_of(scene: Setup, count: int) -> list[Frame]:
    """Run a scene and return its frames."""
    kept: list[Frame] = []
    look = Watch.look

    def keep(watch: Watch, state, *rest) -> None:
        kept.append(Frame(state.plies.x.numpy().copy(), state.tools.poses()))
        look(watch, state, *rest)

    Watch.look = keep
    try:
        scene.run(frames=count, quiet=True, threads=1)
    finally:
        Watch.look = look
    return kept


def spent_on(scene: Setup, spans: Sequence, frames: Sequence[Frame]) -> dict[str, float]:
    """Processor time of measuring a frame, by what is measured [s], without the first one."""
    faces, gaps, known = FaceDepths(scene, spans, "cpu"), ToolGaps(scene.tools), ()
    searches = [WrinkleSearch(p.mesh, p.fabric.thickness, scene.defects) for p in scene.plies]
    spent = {"depths": 0.0, "wrinkles": 0.0}
    for number, frame in enumerate(frames):
        poses, began = frame.tools.poses(), time.process_time()
        known = faces.deepest(frame, known)
        between = time.process_time()
        for search, span in zip(searches, spans, strict=True):
            points = frame.x[span.vertices].copy()
            search.look(points, partial(gaps.ways, points, poses))
        if number:
            spent["depths"] += (between - began) / (len(frames) - 1)
            spent["wrinkles"] += (time.process_time() - between) / (len(frames) - 1)
    return spent


def main(arguments: Sequence[str] | None = None) -> int:
    """Print a line for each mesh."""
    parser = argparse.ArgumentParser(prog="python bench measuring", description=__doc__)
    parser.add_argument("cells", nargs="*", type=int, default=[20, 46], help="along a side")
    parser.add_argument("--frames", type=int, default=40, help="of the run")
    parser.add_argument("--rate", type=float, default=16e6, help="of steps [triangle-steps/s]")
    chosen = parser.parse_args(arguments)
    coarse = three_ply_hemisphere.build(cells=COARSE)
    frames = frames_of(coarse, chosen.frames)
    print("triangles, ms a frame: depths, wrinkles; share of a run's steps and these")
    for cells in chosen.cells:
        scene = three_ply_hemisphere.build(cells=cells)
        model = build_model(scene, "cpu", frames=chosen.frames)
        carried = [frame.on(coarse, scene) for frame in frames]
        spent = spent_on(scene, model.spans, carried)
        triangles = sum(span.triangle_count for span in model.spans)
        steps = model.timing.steps * triangles / chosen.rate
        all_frames = (chosen.frames + 1) * sum(spent.values())
        figures = ", ".join(f"{1e3 * seconds:.1f}" for seconds in spent.values())
        share = 100.0 * all_frames / (steps + all_frames)
        print(f"{triangles:,}, {figures}; {share:.1f} %", flush=True)
    return 0
