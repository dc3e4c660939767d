"""What ends a run early, or is said of it at the end: looked for at every frame, in plain words."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from warpdrape.blanks.ply import Ply
from warpdrape.contact.face_depths import FaceDepths
from warpdrape.contact.passages import Passages
from warpdrape.contact.squeeze import Squeeze, worst_squeeze
from warpdrape.dynamics.energy import Energies
from warpdrape.dynamics.model import Model
from warpdrape.errors import RunFailed
from warpdrape.growth import found, why_it_grew
from warpdrape.interaction import Measured
from warpdrape.results.result import FormedPly
from warpdrape.results.soundness import ENERGY_FAILURE
from warpdrape.state import State
from warpdrape.tools.floating import Float

SQUEEZED = 0.05
"""Share of its thickness by which a ply is squeezed between tools before that is said [-]."""


def number_of_ply(model: Model, vertex: int) -> int:
    """Number of the ply of a vertex."""
    return bisect_right([span.first_vertex for span in model.spans], vertex) - 1


def ply_of(model: Model, vertex: int) -> Ply:
    """The ply of a vertex."""
    return model.scene.plies[number_of_ply(model, vertex)]


def place(model: Model, vertex: int) -> str:
    """Name the ply, and a triangle in it, of a vertex."""
    number = number_of_ply(model, vertex)
    ply, local = model.scene.plies[number], vertex - model.spans[number].first_vertex
    triangle = int(np.argmax((np.asarray(ply.mesh.triangles) == local).any(axis=1)))
    return f"ply {ply.name!r}, triangle {triangle} (vertex {local})"


def loose_plies(model: Model, state: State, measured: Sequence[Measured]) -> tuple[str, ...]:
    """Names of the plies that nothing has held or touched so far: contact always loses energy."""
    lost = state.plies.lost.numpy()[:, :2].any(axis=1)
    held = {c.ply for c in model.scene.clamps} | {s.ply for s in model.scene.springs}
    touched = frozenset().union(*(each.touched for each in measured))
    return tuple(
        ply.name
        for number, (ply, span) in enumerate(zip(model.scene.plies, model.spans, strict=True))
        if ply.name not in held and number not in touched and not lost[span.vertices].any()
    )


@dataclass
class Seen:
    """All that changes of a `Watch`.

    Attributes:
        grown: share of the energy that came from nowhere, where that ended the run [-].
        squeezed: the deepest squeeze between tools so far, in words; empty where there was none.
        squeeze: the same in numbers.
        depths: deepest place of the plies at vertices, and between them, for each tool [m].
        found: energies of the last frame, by what they are in words [J].
    """

    grown: float = 0.0
    squeezed: str = ""
    squeeze: Squeeze | None = None
    depths: tuple[tuple[float, float], ...] = ()
    found: dict[str, float] = field(default_factory=dict)


class Watch:
    """Looks at a run's state for what is wrong, and keeps what is to be said of it.

    Attributes:
        seen: all of it that changes.
    """

    def __init__(self, model: Model, seen: Seen | None = None) -> None:
        """Nothing seen yet; or go on from what was."""
        self.seen = Seen() if seen is None else seen
        self._model = model
        self._passages = Passages(model.scene, model.spans, model.device)
        self._faces = FaceDepths(model.scene, model.spans, model.device)
        laws = [ply.fabric.compaction for ply in model.scene.plies]
        counts = [span.vertex_count for span in model.spans]
        self._rooms = np.repeat([law.room if law else 0.0 for law in laws], counts)

    def look(
        self,
        state: State,
        plies: Sequence[FormedPly],
        energies: Energies,
        measured: Sequence[Measured],
        now: float,
    ) -> None:
        """Look at a frame.

        Args:
            state: the state now.
            plies: formed so far.
            energies: their balance.
            measured: what forces and contacts show.
            now: simulated time [s].

        Raises:
            RunFailed: if a value is not finite, a tool has passed through a ply, or energy came
                from nowhere.
        """
        self._refuse_nonsense(plies, now)
        self._note_squeeze(state, now)
        self._note_depths(state)
        self._refuse_passage(state, now)
        self._refuse_growth(state, energies, measured, now)

    @staticmethod
    def _refuse_nonsense(plies: Sequence[FormedPly], now: float) -> None:
        """Raise `RunFailed` with ply and triangle where a value is not finite."""
        for ply in plies:
            measured = (ply.warp, ply.weft, ply.shear_angle, ply.strain, ply.line_tension)
            values = [array for array in measured if array is not None]
            if all(np.isfinite(array).all() for array in (ply.points, *values)):
                continue
            bad = ~np.isfinite(ply.points).all(axis=1)[ply.triangles].all(axis=1)
            for array in values:
                bad |= ~np.isfinite(array.reshape(len(bad), -1)).all(axis=1)
            if bad.any():
                raise RunFailed(
                    f"blew up at {1e3 * now:.4g} ms in ply {ply.name!r}, triangle "
                    f"{int(np.argmax(bad))}: its values are not finite; lower safety"
                )

    def where_it_blew_up(self, vertex: int, when: float) -> str:
        """Say when and in which ply and triangle a vertex ran away."""
        model, before = self._model, ""
        if self.seen.squeezed:
            before = f"; before that, {self.seen.squeezed}"
        remedy = "lower safety"
        if model.scene.tools:
            remedy += " or contact_share, slow the tools down"
        return (
            f"blew up at {1e3 * when:.4g} ms in {place(model, vertex)}: faster than "
            f"{model.medium.speed_limit:.4g} m/s; {remedy}, or refine the mesh there{before}"
        )

    def _refuse_growth(
        self, state: State, energies: Energies, measured: Sequence[Measured], now: float
    ) -> None:
        """Raise `RunFailed` where energy came from nowhere, with the place that moves fastest."""
        model = self._model
        speed = model.medium.speed_limit / 100.0
        scale = max(energies.largest, 0.5 * float(model.masses.mass.sum()) * speed**2)
        if not energies.unbalanced <= ENERGY_FAILURE * scale:
            self.seen.grown = energies.unbalanced / scale
            fastest = int(np.argmax((state.plies.v.numpy() ** 2).sum(axis=1)))
            if self.seen.squeeze is not None and not self._gives_way(self.seen.squeeze):
                raise RunFailed(self.seen.squeezed)
            before, number = self.seen.found, number_of_ply(model, fastest)
            grown = {words: e - before.get(words, 0.0) for words, e in found(energies).items()}
            raise RunFailed(
                f"energy grew without work at {1e3 * now:.4g} ms, fastest in "
                f"{place(model, fastest)}: {energies.unbalanced:.4g} J of {scale:.4g} J came from "
                f"nowhere; {why_it_grew(model.scene, grown, measured, number, fastest)}"
            )
        self.seen.found = found(energies)

    def _gives_way(self, squeeze: Squeeze) -> bool:
        """Whether one of two tools floats: it leaves what room its force lets it."""
        tools = self._model.scene.tools
        return any(isinstance(tools[number].motion, Float) for number in squeeze.tools)

    def _note_squeeze(self, state: State, now: float) -> None:
        """Keep the deepest squeeze of the run, in words."""
        model = self._model
        found = worst_squeeze(model.interactions, state, self._rooms)
        least = SQUEEZED if self.seen.squeeze is None else self.seen.squeeze.share
        if found is None or not least < found.share:
            return
        law = ply_of(model, found.vertex).fabric.compaction
        one, other = (model.scene.tools[tool].name for tool in found.tools)
        x, y, _ = 1e3 * state.plies.x.numpy()[found.vertex]
        self.seen.squeeze = found
        thinnest = found.thickness if law is None else law.thinnest
        limit = f"its thickness of {1e3 * found.thickness:.3g} mm"
        room = "" if self._gives_way(found) else "leave the ply its thickness between them, or "
        why = (
            "their force there is that of the contact's numerical stiffness; "
            f"{room}give its fabric a compaction law"
        )
        if law is not None:
            limit = f"{1e3 * thinnest:.3g} mm, the least thickness of its compaction law,"
            why = (
                "their force there is extrapolated; measure to higher pressures, or leave the ply "
                "more room"
            )
        if found.apart > thinnest:
            why = (
                f"they leave {1e3 * found.apart:.3g} mm there, but the ply's flat triangles span a "
                "hollow too narrow for them, and the force on them is the mesh's: refine the ply, "
                "or round the tools' edges there"
            )
        self.seen.squeezed = (
            f"tools {one!r} and {other!r} squeeze {place(model, found.vertex)} "
            f"{1e3 * found.depth:.3g} mm below {limit} at {1e3 * now:.4g} ms, "
            f"({x:.4g}, {y:.4g}) mm: {why}"
        )

    def _note_depths(self, state: State) -> None:
        deepest = self._faces.deepest(state, self.seen.depths)
        self.seen.depths = tuple(map(tuple, deepest.tolist()))

    def _refuse_passage(self, state: State, now: float) -> None:
        """Raise `RunFailed` where a tool has passed through a ply between its vertices."""
        found = self._passages.deepest(state)
        if found is None:
            return
        scene, before = self._model.scene, ""
        if self.seen.squeeze is not None and found.tool in self.seen.squeeze.tools:
            before = f"; before that, {self.seen.squeezed}"
        ply, tool = scene.plies[found.ply], scene.tools[found.tool]
        x, y = 1e3 * ply.rest_points[ply.mesh.triangles[found.triangle]].mean(axis=0)[:2]
        raise RunFailed(
            f"tool {tool.name!r} passed through ply {ply.name!r} by {1e3 * now:.4g} ms: it reaches "
            f"{1e3 * found.depth:.3g} mm or more beyond triangle {found.triangle}, at ({x:.4g}, "
            f"{y:.4g}) mm of the flat ply, whose sides are {1e3 * found.side:.3g} mm long: refine "
            f"the ply there, or slow the tool down{before}"
        )
