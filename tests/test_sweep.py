"""Sweeps: one thread for all vertices, as on the CPU, or one for each, as on a card."""

import numpy as np
import pytest
import warp as wp

from warpdrape import interaction
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.stepping import Stepper
from warpdrape.interaction import Run, Swept
from warpdrape.kernels.sweep import Sweep
from warpdrape.scenes import three_ply_hemisphere
from warpdrape.state import all_arrays


@wp.kernel(enable_backward=False)
def count_visits(sweep: Sweep, visits: wp.array(dtype=wp.int32)):
    """Count how often entries are visited; a sweep."""
    for i in range(sweep.first + wp.tid(), sweep.end, sweep.threads):
        wp.atomic_add(visits, i, 1)


@pytest.mark.parametrize("threads", [1, 3, 7, 20])
def test_every_entry_of_a_run_is_visited_once(threads, monkeypatch, device):
    monkeypatch.setattr(interaction, "sweeping_threads", lambda *_: threads)
    visits = wp.zeros(12, dtype=wp.int32, device=device)
    Swept(count_visits, Run(2, 7), [], [visits])(device)
    assert visits.numpy().tolist() == [0, 0] + 7 * [1] + 3 * [0]


def test_one_thread_sweeps_on_the_cpu():
    assert interaction.sweeping_threads("cpu", 50) == 1


def state_when_pressed():
    """Arrays of the state of three plies that tools and each other press, by name."""
    scene = three_ply_hemisphere.build(cells=6, accuracy="draft", duration=0.02)
    model = build_model(scene, "cpu", 20)
    state = initial_state(model)
    stepper = Stepper(model, state)
    for frame in (1, 2, 3):
        stepper.begin_frame(frame)
        for _ in range(model.timing.steps_per_frame // model.timing.search_every):
            stepper.block()
    return {name: array.numpy().copy() for name, array, _ in all_arrays(state)}


def test_a_thread_for_each_vertex_computes_the_same(monkeypatch):
    """On a CPU threads go one after the other, so that even the bits are the same."""
    swept = state_when_pressed()
    monkeypatch.setattr(interaction, "sweeping_threads", lambda _, count: count)
    each = state_when_pressed()
    touching = [name for name, array in swept.items() if name.endswith("stored") and array.any()]
    assert touching, "nothing touches: the test would show little"
    for name, array in swept.items():
        assert np.array_equal(array, each[name]), name
