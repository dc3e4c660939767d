"""Every array that the steps of a run write, as bytes: what a checkpoint keeps of the device.

Nobody lists them: they are those of the state, of every part's own state, and whatever else the
launches of forces and contacts have as an output. A contact that remembers more keeps more.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import warp as wp

from warpdrape.dynamics.partition import Part
from warpdrape.interaction import Launch, Launches
from warpdrape.state import all_arrays


def moving_arrays(parts: Sequence[Part]) -> dict[str, wp.array]:
    """Arrays by a name that is the same for the same scene, each piece of memory once.

    Args:
        parts: of the model, part 0 working on the state itself.
    """
    found: dict[str, wp.array] = {}
    known: set[int] = set()
    for name, array in _candidates(parts):
        if array.size and array.ptr not in known:
            known.add(array.ptr)
            found[name] = array
    return found


def _candidates(parts: Sequence[Part]) -> Iterator[tuple[str, wp.array]]:
    for part in parts:
        for name, array, _ in all_arrays(part.state):
            yield (f"part {part.number}: {name}" if part.number else name), array
    for part in parts:
        for number, launch in enumerate(_launches(part.launches)):
            for place, array in enumerate(launch.outputs):
                if isinstance(array, wp.array):
                    name = f"part {part.number}: {launch.kernel.key} {number}.{place}"
                    yield name, array


def _launches(launches: Launches) -> Iterator[Launch]:
    for field in dataclasses.fields(launches):
        for each in getattr(launches, field.name):
            if isinstance(each, Launch):
                yield each


def read_bytes(arrays: Mapping[str, wp.array]) -> dict[str, np.ndarray]:
    """Copies of arrays as bytes, shape [byte]; those between the fields of a structure too."""
    return {name: _as_bytes(array).numpy().copy() for name, array in arrays.items()}


def write_bytes(arrays: Mapping[str, wp.array], saved: Mapping[str, np.ndarray]) -> None:
    """Put bytes back that `read_bytes` gave.

    Raises:
        ValueError: naming an array that is missing, new or of another size; nothing is written.
    """
    odd = sorted(set(arrays) ^ set(saved))
    odd += [n for n in arrays if n in saved and saved[n].shape != _as_bytes(arrays[n]).shape]
    if odd:
        raise ValueError(f"{odd[0]} is not the array that it was")
    for name, array in arrays.items():
        _as_bytes(array).assign(saved[name])


def _as_bytes(array: wp.array) -> wp.array:
    """The same memory as bytes."""
    if not array.is_contiguous:
        raise TypeError("an array that a run changes must lie in one piece")
    size = array.size * wp.types.type_size_in_bytes(array.dtype)
    return wp.array(ptr=array.ptr, dtype=wp.uint8, shape=size, device=array.device)
