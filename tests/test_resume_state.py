"""A checkpoint holds all that a run changes: arrays, and records on the host."""

import dataclasses
import math

import numpy as np
import pytest
import warp as wp
from resume_checks import STIFF, press

from warpdrape.dynamics.loading import Loading
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.moving_arrays import moving_arrays, read_bytes, write_bytes
from warpdrape.dynamics.stepping import Stepper
from warpdrape.recorder import Recorder
from warpdrape.state import all_arrays


def moved_on(scene, blocks=40, threads=1):
    """A model's stepper after some blocks of its first frame."""
    model = build_model(scene, "cpu", 4)
    state = initial_state(model)
    stepper, loading = Stepper(model, state, threads), Loading(scene, model.timing)
    stepper.begin(loading.stretch(1))
    for _ in range(blocks):
        stepper.block()
    return model, state, stepper, loading


@pytest.mark.parametrize("threads", [1, 2])
def test_nothing_that_steps_write_is_left_out(threads):
    """Any array whose bytes change in a block is among those kept, whoever holds it.

    But for the shapes of plies, which every search makes before it reads them: they may be spoilt.
    """
    scene = press(STIFF, clamped=True)
    model, state, stepper, _ = moved_on(scene, 3, threads)
    surfaces = next(each for each in model.contacts if each.name == "ply surfaces")
    made = (surfaces.normals, surfaces.hollows)
    for array in made:
        array.fill_(math.nan)
    held = every_array([model, stepper.parts])
    before = {at: array.numpy().tobytes() for at, array in held.items()}
    for _ in range(20):
        stepper.block()
    changed = {at for at, array in held.items() if array.numpy().tobytes() != before[at]}
    kept = {array.ptr for array in moving_arrays(stepper.parts).values()}
    assert len(changed) > 15 and changed <= kept | {array.ptr for array in made}
    for array in made:
        assert np.isfinite(array.numpy()).all()  # a search came, and no step read what was spoilt
    assert np.isfinite(state.plies.x.numpy()).all()
    assert len(held) > len(kept)  # it looked at more than those


def every_array(things):
    """Every Warp array that can be reached, by its address."""
    found, seen, left = {}, set(), list(things)
    while left:
        thing = left.pop()
        if id(thing) in seen:
            continue
        seen.add(id(thing))
        if isinstance(thing, wp.array):
            if thing.size:
                found[thing.ptr] = thing
        elif isinstance(thing, list | tuple | set):
            left += thing
        elif isinstance(thing, dict):
            left += thing.values()
        elif isinstance(thing, wp.Mesh):
            left.append(thing.points)
        elif type(thing).__module__.startswith("warpdrape"):
            left += vars(thing).values() if hasattr(thing, "__dict__") else []
    return found


def test_a_state_must_not_hold_what_no_checkpoint_would_keep():
    @dataclasses.dataclass(frozen=True)
    class Memory:
        pushed: list

    with pytest.raises(TypeError, match="pushed is a list"):
        list(all_arrays((None, Memory([1.0]))))


def test_all_that_changes_on_the_host_is_in_its_record(tmp_path):
    """Loading, watch and recorder keep what they change in one record each."""
    scene = press(kinetic_limit=0.3)
    model, state, stepper, loading = moved_on(scene, 1)
    recorder = Recorder(model, None, loading)
    recorder.record(state, 0)
    kept = {
        loading: {"clock"},
        recorder.watch: {"seen"},
        # Rows are in their file; the last good frame is taken from the state again.
        recorder: {"tally", "_rows", "_plies", "_measured", "_loose"},
        stepper: {"blocks", "_asking"},  # the latter follows from the former
    }
    before = {thing: plainly(thing) for thing in kept}
    stepper.block()
    recorder.tally.steps += model.timing.search_every
    loading.stretch(1)
    loading.adapt(1.0, 0.5)
    recorder.watch.seen.squeezed = "deep"
    recorder.record(state, 1)
    for thing, names in kept.items():
        now = plainly(thing)
        assert {name for name in now if now[name] != before[thing][name]} <= names


def plainly(thing):
    """Attributes as texts or, where these would not show a change, as they are."""
    return {
        name: repr(value) if dataclasses.is_dataclass(value) else value
        for name, value in {n: v for n, v in vars(thing).items()}.items()
        if isinstance(value, int | float | str | None) or dataclasses.is_dataclass(value)
    } | {name: id(value) for name, value in vars(thing).items() if name in ("_plies", "_loose")}


def test_bytes_of_arrays_go_there_and_back():
    _, _, stepper, _ = moved_on(press(STIFF), 5)
    arrays = moving_arrays(stepper.parts)
    saved = read_bytes(arrays)
    other = moving_arrays(moved_on(press(STIFF), 0)[2].parts)
    assert other.keys() == arrays.keys()
    write_bytes(other, saved)
    for name, array in other.items():
        assert array.numpy().tobytes() == arrays[name].numpy().tobytes(), name
    short = {**saved, "plies.x": saved["plies.x"][1:]}
    with pytest.raises(ValueError, match=r"plies\.x is not the array"):
        write_bytes(other, short)
    with pytest.raises(ValueError, match=r"plies\.v is not the array"):
        write_bytes(other, {name: b for name, b in saved.items() if name != "plies.v"})
