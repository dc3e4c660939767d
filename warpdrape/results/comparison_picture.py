"""A picture of one ply by several approaches, side by side on one scale."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from warpdrape.errors import InputError, RunFailed
from warpdrape.results.comparison import Compared
from warpdrape.results.picture import DEFAULT_VIEW, WIDTH, camera_of, drawn, paint_of
from warpdrape.results.picture_layout import DPI, image_width
from warpdrape.results.quantities import quantity_named
from warpdrape.results.run_folder import write_whole
from warpdrape.results.usd_reader import SceneView, find_scene, read_scene

COMPARISON_PICTURE = "comparison.png"
"""File of the picture, in the folder that holds the runs."""


def draw_comparison(runs: Sequence[Compared], ply: str, out: Path, field: str = "shear") -> Path:
    """Draw a ply as each approach forms it, at the end, under the approach's name; return the file.

    Args:
        runs: of one scene; those without a result are left out.
        ply: name of the ply.
        out: the PNG (or PDF).
        field: what to colour by, one of `warpdrape.results.quantities.QUANTITIES`.

    Raises:
        InputError: if a run has no such field, or the file cannot be written.
    """
    quantity = quantity_named(field)
    plies, time_s = [], float("nan")
    for run in runs:
        if run.completed:
            number = [formed.name for formed in run.plies].index(ply)
            scene = read_scene(find_scene(run.folder), None, -1, quantity)
            plies.append(replace(scene.plies[number], name=run.approach))
            time_s = scene.time_s
    camera = camera_of([plies], [], DEFAULT_VIEW, image_width(WIDTH, len(plies)))
    paint = paint_of(quantity, plies, None)
    figure = drawn(SceneView(time_s, plies, []), plies, [], camera, paint, 1.0)
    try:
        write_whole(out, lambda partial: figure.savefig(partial, dpi=DPI, facecolor="white"))
    except (OSError, ValueError, RunFailed) as error:
        raise InputError(f"{out} cannot be written ({error}): give another --out") from error
    return out
