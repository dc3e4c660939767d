"""What a run changes: records of arrays, and how parts of a model on several threads hold them.

`State` is all of it: what moves, and what each force and contact remembers.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from enum import Enum
from typing import Any, ClassVar

import numpy as np
import warp as wp

from warpdrape.kernels.contact.look_ahead import Pace
from warpdrape.setup import Setup
from warpdrape.tools.pose import Pose


class Across(Enum):
    """How parts of a model hold an array."""

    SHARED = "one for all: a part writes entries of its own only"
    SCATTERED = "one each: whoever owns an entry takes over, every step, what others put there"
    SUMMED = "one each: part 0 takes over the others', every step"
    LARGEST = "one each: part 0 is raised to the others'"
    FIRST = "one each: part 0 takes another's where it has none (−1)"


SHARING_A_PLACE, MOST_PLACES = 1000, 64
"""Vertices that may add to one reaction of a tool on a graphics card, where a million adding to one
would wait for each other longer than the rest of the step takes; and most reactions of a tool."""
MOST_PARTS = 64
"""Parts of a model at most, each computed by a thread."""
Apart = Mapping[str, Across]
"""Arrays of a record, by name, that are not shared: its class attribute ``apart``."""


@dataclasses.dataclass(frozen=True, eq=False)
class PlyState:
    """The plies' vertices.

    Attributes:
        x: positions [m], shape [vertex].
        v: velocities [m/s], shape [vertex].
        f: forces of this step [N], shape [vertex].
        lost: (friction, contact damping, mass damping) [J], shape [vertex].
        runaway: first vertex that ran away, −1 while there is none, shape [1].
        speeds: the largest of the vertices of a part at the last search [m/s], shape [part].
        paces: how far the searches of a part look, shape [part].
    """

    x: wp.array
    v: wp.array
    f: wp.array
    lost: wp.array
    runaway: wp.array
    speeds: wp.array
    paces: wp.array
    apart: ClassVar[Apart] = {"f": Across.SCATTERED, "runaway": Across.FIRST}


@dataclasses.dataclass(frozen=True, eq=False)
class ToolState:
    """The tools; see `kernels.dynamics.motion`.

    Attributes:
        turned: rotations since the start, shape [tool].
        shift: translations [m], shape [tool]: a point X of a tool is at turned · X + shift.
        velocity: of its motion, that of the axis if it turns [m/s], shape [tool].
        spin: angular velocity [rad/s], shape [tool].
        reaction: contact forces of this step [N], in several places for each tool so that the
            threads of a graphics card do not wait for one, shape [place · tool].
        moment: theirs about a point of its axis [N·m], of tools that turn, likewise.
        impulse: sum over the steps of the reaction [N], shape [tool].
        twist: sum over the steps of the moment about the axis [N·m], shape [tool].
        work: done on the tools from outside [J], shape [tool].
        damped: lost in their dashpots [J], shape [tool].
        path: translation before the coming steps and after each [m], shape [tool, step + 1].
        force: along the axis, likewise [N].
        angle: turned about the axis, likewise [rad].
    """

    turned: wp.array
    shift: wp.array
    velocity: wp.array
    spin: wp.array
    reaction: wp.array
    moment: wp.array
    impulse: wp.array
    twist: wp.array
    work: wp.array
    damped: wp.array
    path: wp.array
    force: wp.array
    angle: wp.array
    apart: ClassVar[Apart] = {"reaction": Across.SUMMED, "moment": Across.SUMMED}

    def poses(self) -> list[Pose]:
        """Where the tools are now."""
        turned, shift = self.turned.numpy(), self.shift.numpy()
        return [Pose(r.copy(), s.copy()) for r, s in zip(turned, shift, strict=True)]


@dataclasses.dataclass(frozen=True, eq=False)
class ClampState:
    """The clamps; see `kernels.dynamics.motion.advance_clamped`.

    Attributes:
        work: done by them [J], shape [vertex].
        force: sum over the steps [N], shape [clamp].
        matrix: before the coming steps and after each, shape [clamp · (step + 1)].
        shift: likewise [m].
    """

    work: wp.array
    force: wp.array
    matrix: wp.array
    shift: wp.array
    apart: ClassVar[Apart] = {"force": Across.SUMMED}


@dataclasses.dataclass(frozen=True, eq=False)
class LoadState:
    """What acts on plies over time.

    Attributes:
        pressure: along the plies' normals before the coming steps and after each [Pa],
            shape [load, step + 1].
        damping: mass-proportional rate, likewise [1/s], shape [step + 1].
        process: time of the process, likewise [s], shape [step + 1].
    """

    pressure: wp.array
    damping: wp.array
    process: wp.array


@dataclasses.dataclass(frozen=True, eq=False)
class HeatState:
    """Temperatures of the plies; see `kernels.contact.heat`.

    Attributes:
        temperature: [K], shape [vertex].
        power: that comes from other plies in this step [W], shape [vertex].
        pull: of tools in this step: rate [1/s], and rate times temperature [K/s], shape [vertex].
        cover: what covers faces in this step, shape [vertex].
    """

    temperature: wp.array
    power: wp.array
    pull: wp.array
    cover: wp.array
    apart: ClassVar[Apart] = {"power": Across.SCATTERED}


@dataclasses.dataclass(frozen=True, eq=False)
class PressingState:
    """How hard contacts press on plies; see `kernels.contact.press_through`.

    Attributes:
        pressing: in this step, on both faces [N], shape [vertex].
        through: in the step before, through the ply [N], shape [vertex].
    """

    pressing: wp.array
    through: wp.array
    apart: ClassVar[Apart] = {"pressing": Across.SCATTERED}


@dataclasses.dataclass(frozen=True, eq=False)
class State:
    """Everything that a run changes, and what a restart needs.

    Attributes:
        plies: the plies' vertices.
        tools: the tools.
        clamps: the clamps.
        loads: pressures on the plies.
        heat: temperatures of the plies, None where none cools.
        pressing: how hard contacts press on them, None where nothing asks.
        scaled: momenta of selective mass scaling, None without.
        memory: what each force and contact remembers, in the model's order; None for nothing.
        step: number of the step since the tables of motion began, shape [1].
    """

    plies: PlyState
    tools: ToolState
    clamps: ClampState
    loads: LoadState
    heat: Any
    pressing: Any
    scaled: Any
    memory: tuple[Any, ...]
    step: wp.array


def start_plies(points: np.ndarray, device: str) -> PlyState:
    """Plies at rest at points [m], shape [vertex, 3]."""
    n = len(points)
    return PlyState(
        x=wp.array(points, dtype=wp.vec3d, device=device),
        v=wp.zeros(n, dtype=wp.vec3d, device=device),
        f=wp.zeros(n, dtype=wp.vec3d, device=device),
        lost=wp.zeros(n, dtype=wp.vec3d, device=device),
        runaway=wp.full(1, -1, dtype=wp.int32, device=device),
        speeds=wp.zeros(MOST_PARTS, dtype=wp.float64, device=device),
        paces=wp.zeros(MOST_PARTS, dtype=Pace, device=device),
    )


def start_tools(scene: Setup, vertices: int, steps: int, device: str) -> ToolState:
    """Tools where they start, with room for the motions of so many steps."""
    tools, real, vec = len(scene.tools), wp.float64, wp.vec3d
    places = 1
    if wp.get_device(device).is_cuda:
        places = min(1 + vertices // SHARING_A_PLACE, MOST_PLACES)
    vectors = ("shift", "velocity", "spin", "impulse")
    upright = np.broadcast_to(np.eye(3), (tools, 3, 3))
    return ToolState(
        **{name: wp.zeros(tools, dtype=vec, device=device) for name in vectors},
        turned=wp.array(upright, dtype=wp.mat33d, device=device),
        reaction=wp.zeros(places * tools, dtype=vec, device=device),
        moment=wp.zeros(places * tools, dtype=vec, device=device),
        twist=wp.zeros(tools, dtype=real, device=device),
        work=wp.zeros(tools, dtype=real, device=device),
        damped=wp.zeros(tools, dtype=real, device=device),
        path=wp.zeros((tools, steps + 1), dtype=vec, device=device),
        force=wp.zeros((tools, steps + 1), dtype=real, device=device),
        angle=wp.zeros((tools, steps + 1), dtype=real, device=device),
    )


def start_clamps(scene: Setup, vertices: int, steps: int, device: str) -> ClampState:
    """Clamps where they start, with room for the motions of so many steps."""
    clamps = len(scene.clamps)
    table = clamps * (steps + 1)
    return ClampState(
        work=wp.zeros(vertices, dtype=wp.float64, device=device),
        force=wp.zeros(clamps, dtype=wp.vec3d, device=device),
        matrix=wp.zeros(table, dtype=wp.mat33d, device=device),
        shift=wp.zeros(table, dtype=wp.vec3d, device=device),
    )


def start_loads(scene: Setup, steps: int, device: str) -> LoadState:
    """No load, with room for the pressures and the damping of so many steps."""
    shape = (len(scene.pressures), steps + 1)
    return LoadState(
        pressure=wp.zeros(shape, dtype=wp.float64, device=device),
        damping=wp.zeros(steps + 1, dtype=wp.float64, device=device),
        process=wp.zeros(steps + 1, dtype=wp.float64, device=device),
    )


def start_heat(scene: Setup, device: str) -> HeatState | None:
    """Temperatures of the plies as they are laid in; None where none cools."""
    if not scene.cooling:
        return None
    warmth = np.concatenate(
        [np.full(len(ply.mesh.vertices), ply.warmth or 0.0) for ply in scene.plies]
    )
    return HeatState(
        temperature=wp.array(warmth, dtype=wp.float64, device=device),
        power=wp.zeros(len(warmth), dtype=wp.float64, device=device),
        pull=wp.zeros(len(warmth), dtype=wp.vec2d, device=device),
        cover=wp.zeros(len(warmth), dtype=wp.vec4d, device=device),
    )


def start_pressing(vertices: int, device: str) -> PressingState:
    """Nothing presses on so many vertices."""
    real: dict[str, Any] = {"dtype": wp.float64, "device": device}
    return PressingState(wp.zeros(vertices, **real), wp.zeros(vertices, **real))


def all_arrays(record: Any, name: str = "") -> Iterator[tuple[str, wp.array, Across]]:
    """Every array of a record, those of records and tuples within: dotted name, array, sharing.

    Raises:
        TypeError: naming what is none of these, nor a constant: it would be left out.
    """
    if isinstance(record, wp.array):
        yield name, record, Across.SHARED
    elif isinstance(record, tuple):
        for number, each in enumerate(record):
            yield from all_arrays(each, f"{name}.{number}".lstrip("."))
    elif dataclasses.is_dataclass(record):
        for field in dataclasses.fields(record):
            value, inner = getattr(record, field.name), f"{name}.{field.name}".lstrip(".")
            if isinstance(value, wp.array):
                yield inner, value, _across(record, field.name)
            else:
                yield from all_arrays(value, inner)
    elif record is not None and not isinstance(record, str | int | float):
        raise TypeError(f"{name} is a {type(record).__name__}: a state holds arrays and records")


def _across(record: Any, name: str) -> Across:
    return getattr(record, "apart", {}).get(name, Across.SHARED)


def with_own(record: Any) -> Any:
    """A record for one more part: what is not shared is its own, and starts from nothing."""
    if isinstance(record, tuple):
        return tuple(map(with_own, record))
    if not dataclasses.is_dataclass(record) or isinstance(record, type):
        return record
    own = {}
    for field in dataclasses.fields(record):
        value, across = getattr(record, field.name), _across(record, field.name)
        if not isinstance(value, wp.array):
            own[field.name] = with_own(value)
        elif across is Across.FIRST:
            own[field.name] = wp.clone(value)
        elif across is not Across.SHARED:
            own[field.name] = wp.zeros_like(value)
    return dataclasses.replace(record, **own)


def copied(record: Any) -> Any:
    """A record with copies of all arrays."""
    if isinstance(record, tuple):
        return tuple(map(copied, record))
    if isinstance(record, wp.array):
        return wp.clone(record)
    if not dataclasses.is_dataclass(record) or isinstance(record, type):
        return record
    fields = dataclasses.fields(record)
    return dataclasses.replace(record, **{f.name: copied(getattr(record, f.name)) for f in fields})
