"""What a force of the plies, or a contact, is to the rest: launches, stored energy, entries.

Each is one module, in `warpdrape.forces` or `warpdrape.contact`, which makes an `Interaction`; the
step loop, the energy balance and the results ask a tuple of them, and know none by name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple, Protocol

import numpy as np
import warp as wp

from warpdrape.kernels.sweep import Sweep
from warpdrape.state import (
    ClampState,
    HeatState,
    LoadState,
    PlyState,
    PressingState,
    State,
    ToolState,
)


@dataclass(frozen=True)
class Span:
    """Where one ply's vertices and triangles are in the model's."""

    first_vertex: int
    vertex_count: int
    first_triangle: int
    triangle_count: int

    @property
    def vertices(self) -> slice:
        """Its vertices in arrays over all."""
        return slice(self.first_vertex, self.first_vertex + self.vertex_count)

    @property
    def triangles(self) -> slice:
        """Its triangles in arrays over all."""
        return slice(self.first_triangle, self.first_triangle + self.triangle_count)


class Run(NamedTuple):
    """Consecutive entries of an array."""

    first: int
    count: int  # type: ignore[assignment]  # in place of tuple.count, which nobody asks for


@dataclass(frozen=True)
class Share:
    """What one part of a model computes.

    Attributes:
        number: of the part.
        parts: how many there are.
        vertices: those that it moves, runs of all plies.
        by_ply: the same by ply, in the model's numbering.
    """

    number: int
    parts: int
    vertices: tuple[Run, ...]
    by_ply: tuple[tuple[Run, ...], ...]

    def of(self, total: int) -> Run:
        """Its part of so many things, such as elements."""
        first, last = (total * n // self.parts for n in (self.number, self.number + 1))
        return Run(first, last - first)

    @property
    def plies(self) -> range:
        """Numbers of plies of which it alone does what is done once for each."""
        return range(self.number, len(self.by_ply), self.parts)


class Launch(NamedTuple):
    """One launch of a kernel."""

    kernel: Any
    count: int  # type: ignore[assignment]  # as of `Run`
    inputs: list
    outputs: list

    def __call__(self, device: wp.DeviceLike) -> None:
        """Launch it."""
        wp.launch(self.kernel, self.count, inputs=self.inputs, outputs=self.outputs, device=device)


def sweeping_threads(device: wp.DeviceLike, count: int) -> int:
    """Threads that sweep over so many entries: one on the CPU, one for each entry on a card."""
    return 1 if wp.get_device(device).is_cpu else count


class Swept(NamedTuple):
    """One launch of a kernel that sweeps over a run, see `warpdrape.kernels.sweep`."""

    kernel: Any
    run: Run
    inputs: list
    outputs: list

    def __call__(self, device: wp.DeviceLike) -> None:
        """Launch it."""
        sweep = Sweep()
        sweep.first, sweep.end = self.run.first, sum(self.run)
        sweep.threads = sweeping_threads(device, self.run.count)
        inputs = [sweep, *self.inputs]
        wp.launch(self.kernel, sweep.threads, inputs=inputs, outputs=self.outputs, device=device)


@dataclass(frozen=True)
class Launches:
    """What a part launches, by stage; all parts have ended a stage before any goes to the next.

    A search has the stages up to ``walk``, at most every few steps; a step has the others.

    Attributes:
        prepare: first thing in a search, from positions.
        copy: positions for query meshes, before vertices ask.
        refit: query meshes moved along, likewise.
        measure: from what was prepared.
        ask: where vertices ask for what is nearest.
        walk: in its place where they go on from what they remember.
        scatter: forces on any vertices, from positions and velocities.
        push: forces on the part's own vertices, and on tools.
    """

    prepare: tuple[Launch | Swept, ...] = ()
    copy: tuple[Launch | Swept, ...] = ()
    refit: tuple[wp.Mesh, ...] = ()
    measure: tuple[Launch | Swept, ...] = ()
    ask: tuple[Launch | Swept, ...] = ()
    walk: tuple[Launch | Swept, ...] = ()
    scatter: tuple[Launch | Swept, ...] = ()
    push: tuple[Launch | Swept, ...] = ()

    def __add__(self, other: Launches) -> Launches:
        """Both, stage by stage."""
        return Launches(
            **{f.name: getattr(self, f.name) + getattr(other, f.name) for f in fields(Launches)}
        )


class Bodies(NamedTuple):
    """What interactions read and push, as a part has it.

    Heat is None where no ply cools, what contacts press with where nothing asks.
    """

    plies: PlyState
    tools: ToolState
    clamps: ClampState
    loads: LoadState
    step: wp.array
    heat: HeatState | None
    pressing: PressingState | None = None

    @property
    def cooling(self) -> HeatState:
        """Heat, for what is there only where a ply cools.

        Raises:
            LookupError: if none does.
        """
        if self.heat is None:
            raise LookupError("no ply of this scene cools: there is no heat to read")
        return self.heat

    @property
    def pressed(self) -> PressingState:
        """What contacts press with, for what is there only where something asks for it.

        Raises:
            LookupError: if nothing does.
        """
        if self.pressing is None:
            raise LookupError("nothing in this scene asks how hard contacts press")
        return self.pressing


def bodies_of(state: State) -> Bodies:
    """Those of a state."""
    return Bodies(
        state.plies,
        state.tools,
        state.clamps,
        state.loads,
        state.step,
        state.heat,
        state.pressing,
    )


@dataclass(frozen=True, eq=False)
class Measured:
    """What a force or contact shows at one instant.

    Attributes:
        stored: energies by name [J].
        lost: energies lost so far by name [J]; "friction" and "contact damping" of contacts.
        fields: by ply, arrays over its triangles or vertices by name; see `FormedPly`.
        pressing: normal forces on vertices by the name of their pressure [N], shape [row, vertex];
            rows are faces of the ply, lower and upper, or tools. What several contacts show adds.
        entries: lists of ``summary.json`` by name, one entry for each thing met in contact.
        flowed: part of what is lost that deforming took as it takes what is stored [J]: a fluid's.
        work: done on the plies from outside so far [J].
        readings: columns of ``history.csv`` by name.
        touched: numbers of plies that a contact has touched, but for what `PlyState.lost` tells.
        warnings: what to look at, in words.
    """

    stored: Mapping[str, float] = field(default_factory=dict)
    lost: Mapping[str, float] = field(default_factory=dict)
    fields: tuple[Mapping[str, np.ndarray], ...] = ()
    pressing: Mapping[str, np.ndarray] = field(default_factory=dict)
    entries: Mapping[str, Sequence[Mapping[str, Any]]] = field(default_factory=dict)
    flowed: float = 0.0
    work: float = 0.0
    readings: Mapping[str, float] = field(default_factory=dict)
    touched: frozenset[int] = frozenset()
    warnings: tuple[str, ...] = ()


def met_in_contact(measured: Sequence[Measured]) -> dict[str, list[dict[str, Any]]]:
    """Entries of all contacts by name; of what several have met, the largest values."""
    met: dict[str, list[dict[str, Any]]] = {}
    for name, entries in (item for each in measured for item in each.entries.items()):
        known = met.get(name)
        if known is None:
            met[name] = [dict(entry) for entry in entries]
            continue
        for mine, theirs in zip(known, entries, strict=True):
            mine.update({key: max(mine.get(key, value), value) for key, value in theirs.items()})
    return met


class Interaction(Protocol):
    """A force or a contact, ready on a device."""

    @property
    def name(self) -> str:
        """As the profile of a run calls its steps."""

    @property
    def searches(self) -> str:
        """As it calls its searches, empty if it has none."""

    def start(self) -> Any:
        """What it remembers, a record of arrays as it is at the start; None for nothing."""

    def launches(self, share: Share, bodies: Bodies, memory: Any) -> Launches:
        """What a part launches for it."""

    def measure(self, bodies: Bodies, memory: Any) -> Measured:
        """Energies and fields now."""


class Force(Interaction, Protocol):
    """A force, which also has its part in the summary."""

    def ply_entries(self, fields: Mapping[str, np.ndarray]) -> Mapping[str, float]:
        """What ``summary.json`` says of a ply, given what `measure` showed of it."""

    def entries(
        self, history: Mapping[str, np.ndarray], fields: Sequence[Mapping[str, np.ndarray]]
    ) -> tuple[Mapping[str, float], list[str]]:
        """What it says of all plies, and warnings."""


class MembraneForce(Force, Protocol):
    """The force of the plies' membranes: most of a step's work, and shared out as it says."""

    @property
    def order(self) -> Sequence[np.ndarray]:
        """Each ply's triangles in the order in which parts share them out."""
