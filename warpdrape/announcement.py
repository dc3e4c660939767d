"""What a run will take, said before it starts: steps, time, memory, space on the disk."""

from __future__ import annotations

import psutil

from warpdrape.dynamics.model import Model
from warpdrape.dynamics.phases import time_phases
from warpdrape.results.progress import in_words
from warpdrape.results.snapshot import shown_at_vertices, shown_of_defects
from warpdrape.state import State

RATE = 4e6
"""Triangles that one core advances by a step in a second, roughly: which runs are long."""
LONG = 60.0
"""Time from which a run counts as long [s], so that its steps are timed before it starts."""
PER_TRIANGLE, PER_VERTEX, FIELD = 48, 24, 4
"""Bytes of a frame: directions, shear, strains, tensions, colour; positions, normals; each further
quantity in a triangle or at a vertex, of which slip has three."""


def announcement(model: Model, state: State, first: int, *, written: bool) -> str:
    """Say what the steps to come will take.

    Args:
        model: the model.
        state: its state before them; nothing of it changes.
        first: frame from which the run goes on, 0 at its start.
        written: whether frames go to the disk.
    """
    timing = model.timing
    steps = (timing.frames - first) * timing.steps_per_frame
    words = [f"{steps:,} steps of {1e6 * timing.time_step:.3g} µs"]
    if steps * model.triangles > LONG * RATE:
        seconds = steps * sum(time_phases(model, state).values())
        words.append(f"{in_words(seconds)} or more on one thread, more as contacts grow")
    words.append(f"{megabytes(psutil.Process().memory_info().rss)} of memory")
    if written:
        words.append(f"up to {megabytes((timing.frames + 1) * frame_bytes(model))} on the disk")
    return ", ".join(words)


def frame_bytes(model: Model) -> int:
    """Size of a frame in the animation [byte]."""
    size = 0
    for ply, span in zip(model.scene.plies, model.spans, strict=True):
        fields = shown_at_vertices(model.scene, ply)
        columns = len(fields) + 2 * ("slip" in fields)
        in_triangle = PER_TRIANGLE + FIELD * len(shown_of_defects(ply))
        size += in_triangle * span.triangle_count
        size += (PER_VERTEX + FIELD * columns) * span.vertex_count
    return size


def megabytes(size: float) -> str:
    """Say a size as a person does: 12 MB, 1.3 GB."""
    return f"{size / 1e9:.1f} GB" if size >= 1e9 else f"{max(size / 1e6, 1.0):.0f} MB"
