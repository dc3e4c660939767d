"""What is computed: plies, tools, clamps, and what happens to them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from warpdrape.blanks.ply import Ply
from warpdrape.defects.alignment import WantedDirection
from warpdrape.defects.thresholds import DefectThresholds
from warpdrape.errors import InputError, one_of, positive
from warpdrape.numerics import Numerics
from warpdrape.tools.motion import Float, Motion, Path, Still, Stroke, vector
from warpdrape.tools.tool import Tool

if TYPE_CHECKING:
    from warpdrape.results.result import Result
    from warpdrape.results.run_folder import RunFolder

LARGEST_PLY = 50.0
"""Width beyond which a ply must have been given in millimetres [m]."""
LONGEST_WAY = 20.0
"""Way of a tool over the plies' width beyond which it must have been [-]."""
LARGEST_TOOL, SMALLEST_TOOL = 200.0, 1e-3
"""Width of a tool over the plies' beyond, and below, which its file must have another unit [-]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Clamp:
    """Vertices of a ply that are held, or led along a prescribed motion.

    Attributes:
        name: how results call it.
        ply: name of the ply.
        where: vertex indices, or a function of the flat points [m] (shape [n, 3]) to a mask.
        motion: translation of the clamp; still by default.
        matrix: function of times [s] to 3×3 matrices that act on the flat points; identity if None.
        follow: direction along which the clamp's force and displacement are reported, shape [3].
        travel: function of times [s] to a coordinate δ [m] of the clamp; given it, δ and the force
            dW/dδ by the clamp's work W are reported in their place.
        slope: "held": the ply leaves the clamp in its direction; "free": it may turn there, as on
            a hinge. Matters to plies that resist bending.
    """

    name: str
    ply: str
    where: Callable[[np.ndarray], np.ndarray] | Sequence[int]
    motion: Motion = field(default_factory=Still)
    matrix: Callable[[np.ndarray], np.ndarray] | None = None
    follow: Sequence[float] = (0.0, 0.0, 1.0)
    travel: Callable[[np.ndarray], np.ndarray] | None = None
    slope: str = "held"

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.isidentifier():
            raise InputError(f"clamp name = {self.name!r} must be a plain identifier")
        if isinstance(self.motion, Float) or not isinstance(self.motion, Still | Stroke | Path):
            raise InputError(f"clamp {self.name!r}: motion = {self.motion!r} must be prescribed")
        vector(f"clamp {self.name!r}: follow", self.follow)
        one_of(f"slope of clamp {self.name!r}", self.slope, ("held", "free"))

    def vertices(self, points: np.ndarray) -> np.ndarray:
        """Indices of the held vertices among flat points [m], shape [n, 3]."""
        chosen = np.asarray(self.where(points) if callable(self.where) else self.where)
        if chosen.dtype == bool and chosen.shape != (len(points),):
            raise InputError(
                f"clamp {self.name!r}: its mask has shape {chosen.shape}, not "
                f"({len(points)},), one for each vertex of ply {self.ply!r}"
            )
        index = np.flatnonzero(chosen) if chosen.dtype == bool else chosen.astype(int)
        if index.size == 0:
            raise InputError(f"clamp {self.name!r} holds no vertex of ply {self.ply!r}")
        if index.min() < 0 or index.max() >= len(points):
            odd = index[(index < 0) | (index >= len(points))][0]
            raise InputError(
                f"clamp {self.name!r}: ply {self.ply!r} has no vertex {odd}, "
                f"only 0..{len(points) - 1}"
            )
        return index


@dataclass(frozen=True, kw_only=True, eq=False)
class Setup:
    """What a solver reads: everything of a `warpdrape.Scene`, described there, but its `run`."""

    name: str
    plies: Sequence[Ply]
    duration: float
    tools: Sequence[Tool] = ()
    clamps: Sequence[Clamp] = ()
    friction: float = 0.2
    ply_friction: float | Mapping[tuple[str, str], float] = 0.3
    self_contact: bool = True
    gravity: Sequence[float] = (0.0, 0.0, -9.81)
    numerics: Numerics = field(default_factory=Numerics)
    defects: DefectThresholds = field(default_factory=DefectThresholds)
    wanted: Sequence[WantedDirection] = ()
    parameters: Mapping[str, Any] = field(default_factory=dict)
    script: str = ""
    report: Callable[[Result], Mapping[str, Any]] | None = None
    write: Callable[[Result, RunFolder], None] | None = None

    def __post_init__(self) -> None:
        kinds = (("plies", Ply), ("tools", Tool), ("clamps", Clamp), ("wanted", WantedDirection))
        for name, kind in kinds:
            object.__setattr__(self, name, _all_of(name, getattr(self, name), kind))
        if not self.plies:
            raise InputError("a scene needs at least one ply")
        positive("duration", self.duration, unit="s")
        one_of("self_contact", self.self_contact, (True, False))
        positive("friction", self.friction, zero=True)
        vector("gravity", self.gravity)
        if not isinstance(self.numerics, Numerics):
            raise InputError(f"numerics = {self.numerics!r} must be a warpdrape.Numerics")
        if not isinstance(self.defects, DefectThresholds):
            raise InputError(f"defects = {self.defects!r} must be a warpdrape.DefectThresholds")
        for kind, things in (("ply", self.plies), ("tool or clamp", self.tools + self.clamps)):
            names = [thing.name for thing in things]
            for name in names:
                if names.count(name) > 1:
                    raise InputError(f"two of the scene's {kind} names are {name!r}: rename one")
        if not isinstance(self.ply_friction, Mapping):
            positive("ply_friction", self.ply_friction, zero=True)
        for one, other in combinations(self.plies, 2):
            self.friction_between(one, other)
        for ply in filter(self.touches_itself, self.plies):
            self.friction_between(ply, ply)
        _refuse_other_units(self.plies, self.tools)
        for clamp in self.clamps:
            one_of("ply", clamp.ply, [ply.name for ply in self.plies])
        for wanted in self.wanted:
            names = [ply.name for ply in self.plies]
            ply = self.plies[names.index(one_of("ply", wanted.ply, names))]
            wanted.region(ply.rest_points[np.asarray(ply.mesh.triangles)].mean(axis=1))
        for low, high in zip(self.plies, self.plies[1:], strict=False):
            need = 0.5 * (low.fabric.thickness + high.fabric.thickness)
            if low.z - high.z >= need:
                raise InputError(
                    f"ply {high.name!r} lies {low.z - high.z:.4g} m below {low.name!r} and comes "
                    "after it: list plies from the bottom up"
                )
            if high.z - low.z < need * (1.0 - 1e-9):
                raise InputError(
                    f"plies {low.name!r} and {high.name!r} overlap at the start: "
                    f"{high.z - low.z:.4g} m apart, {need:.4g} m needed; lay them up with "
                    "warpdrape.lay_up"
                )

    def touches_itself(self, ply: Ply) -> bool:
        """Whether folds of a ply are held apart: those of one that does not bend have no size."""
        return self.self_contact and ply.fabric.bends

    def friction_of(self, tool: Tool) -> float:
        """Coulomb coefficient of a tool against the plies [-]."""
        return self.friction if tool.friction is None else tool.friction

    def friction_between(self, one: Ply, other: Ply) -> float:
        """Coulomb coefficient between two plies, by their fabrics' names in either order [-].

        Raises:
            InputError: if ``ply_friction`` lacks these fabrics, or holds no coefficient for them.
        """
        if not isinstance(self.ply_friction, Mapping):
            return float(self.ply_friction)
        pair = (one.fabric.name, other.fabric.name)
        for names in (pair, pair[::-1]):
            if names in self.ply_friction:
                return positive(f"ply_friction[{names!r}]", self.ply_friction[names], zero=True)
        who = f"of plies {one.name!r} and {other.name!r}"
        if one is other:
            who = f"of a ply with itself, and ply {one.name!r} may touch itself"
        raise InputError(f"ply_friction lacks the fabrics {who}: add {pair!r}: its coefficient")


def _all_of(name: str, things: Any, kind: type) -> tuple[Any, ...]:
    """Return a sequence as a tuple; raise `InputError` where an entry is of another type."""
    if not isinstance(things, Sequence) or isinstance(things, str):
        raise InputError(f"{name} = {things!r} must be a list of {kind.__name__}")
    for number, thing in enumerate(things):
        if not isinstance(thing, kind):
            raise InputError(f"{name}[{number}] = {thing!r} is not a {kind.__name__}")
    return tuple(things)


def _refuse_other_units(plies: Sequence[Ply], tools: Sequence[Tool]) -> None:
    """Raise `InputError` where the size of a ply or tool, or a tool's way, betrays another unit."""
    sizes = [float(np.ptp(np.asarray(ply.mesh.vertices), axis=0).max()) for ply in plies]
    for ply, size in zip(plies, sizes, strict=True):
        if size > LARGEST_PLY:
            raise InputError(
                f"ply {ply.name!r} is {size:.4g} m across, more than "
                f"{LARGEST_PLY:g} m: give metres, as in 300 * mm"
            )
    for tool in tools:
        size = float(np.ptp(tool.vertices, axis=0).max())
        if not SMALLEST_TOOL * max(sizes) <= size <= LARGEST_TOOL * max(sizes):
            raise InputError(
                f"tool {tool.name!r} is {size:.4g} m across, the plies {max(sizes):.4g} m: give "
                "the metres per unit of its file, as in scale=1e-3 for millimetres"
            )
        if isinstance(tool.motion, Stroke | Path):
            motion = tool.motion
            ways = motion.travel if isinstance(motion, Stroke) else motion.positions
            way = float(np.linalg.norm(np.atleast_2d(ways), axis=1).max())
            if way > LONGEST_WAY * max(sizes):
                raise InputError(
                    f"tool {tool.name!r} travels {way:.4g} m, more than {LONGEST_WAY:g} times the "
                    f"plies' {max(sizes):.4g} m: give metres, as in 75 * mm"
                )
