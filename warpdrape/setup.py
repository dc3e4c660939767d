"""What is computed: plies, tools, clamps, and what happens to them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from warpdrape.approaches import APPROACHES, RECOVERING, SEMI_DISCRETE, SLIDING_YARNS
from warpdrape.blanks.ply import Ply
from warpdrape.defects.alignment import WantedDirection
from warpdrape.defects.limits import Limits
from warpdrape.defects.thresholds import DefectThresholds
from warpdrape.errors import InputError, one_of, positive, said, true_or_false
from warpdrape.materials.friction import Friction, friction_of
from warpdrape.materials.matrix import Heat
from warpdrape.numerics import Numerics
from warpdrape.tools.air import Air
from warpdrape.tools.chosen import Chosen, chosen_vertices
from warpdrape.tools.motion import Prescribed, Still, vector
from warpdrape.tools.pressure import Pressure
from warpdrape.tools.spring import Spring
from warpdrape.tools.tool import Tool
from warpdrape.wording import brief, heading

if TYPE_CHECKING:
    from warpdrape.results.result import Result
    from warpdrape.results.run_folder import RunFolder

MOST_SHOWN = 12
"""Plies, tools and clamps of a scene that it shows of itself."""
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
        yarns: "held": yarns are gripped where the clamp holds their crossovers; "free": they slide
            through these as through others. Matters to approach = "sliding_yarns".
    """

    name: str
    ply: str
    where: Chosen
    motion: Prescribed = field(default_factory=Still)
    matrix: Callable[[np.ndarray], np.ndarray] | None = None
    follow: Sequence[float] = (0.0, 0.0, 1.0)
    travel: Callable[[np.ndarray], np.ndarray] | None = None
    slope: str = "held"
    yarns: str = "held"

    __repr__ = brief

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.isidentifier():
            raise InputError(f"clamp name = {said(self.name)} must be a plain identifier")
        if not isinstance(self.motion, Prescribed):
            raise InputError(
                f"clamp {self.name!r}: motion = {said(self.motion)} must be prescribed: give a "
                "Stroke, Stages, Path or Still; a force pulls by a Spring"
            )
        vector(f"clamp {self.name!r}: follow", self.follow)
        one_of(f"slope of clamp {self.name!r}", self.slope, ("held", "free"))
        one_of(f"yarns of clamp {self.name!r}", self.yarns, ("held", "free"))

    def vertices(self, points: np.ndarray) -> np.ndarray:
        """Indices of the held vertices among flat points [m], shape [n, 3]."""
        return chosen_vertices(f"clamp {self.name!r}", self.where, self.ply, points)


@dataclass(frozen=True, kw_only=True, eq=False)
class Setup:
    """What a solver reads: everything of a `warpdrape.Scene`, described there, but its `run`."""

    name: str
    plies: Sequence[Ply]
    duration: float
    tools: Sequence[Tool] = ()
    clamps: Sequence[Clamp] = ()
    pressures: Sequence[Pressure] = ()
    springs: Sequence[Spring] = ()
    friction: float | Friction = 0.2
    ply_friction: float | Friction | Mapping[tuple[str, str], float | Friction] = 0.3
    process_duration: float | None = None
    air: Air | None = None
    self_contact: bool = True
    gravity: Sequence[float] = (0.0, 0.0, -9.81)
    numerics: Numerics = field(default_factory=Numerics)
    defects: DefectThresholds = field(default_factory=DefectThresholds)
    limits: Limits | None = None
    wanted: Sequence[WantedDirection] = ()
    approach: str = SEMI_DISCRETE
    parameters: Mapping[str, Any] = field(default_factory=dict)
    script: str = ""
    call: Mapping[str, Any] = field(default_factory=dict)
    report: Callable[[Result], Mapping[str, Any]] | None = None
    write: Callable[[Result, RunFolder], None] | None = None

    def __repr__(self) -> str:
        things = [repr(each) for each in (*self.plies, *self.tools, *self.clamps)]
        if len(things) > MOST_SHOWN:
            things = [*things[: MOST_SHOWN - 1], f"… and {len(things) - MOST_SHOWN + 1} more"]
        return "\n  ".join([f"{heading(self)}: {1e3 * self.duration:.4g} ms", *things])

    def __post_init__(self) -> None:
        kinds = (("plies", Ply), ("tools", Tool), ("clamps", Clamp), ("pressures", Pressure))
        for name, kind in (*kinds, ("springs", Spring), ("wanted", WantedDirection)):
            object.__setattr__(self, name, _all_of(name, getattr(self, name), kind))
        if not self.plies:
            raise InputError("a scene needs at least one ply")
        positive("duration", self.duration, unit="s")
        one_of("approach", self.approach, APPROACHES)
        true_or_false("self_contact", self.self_contact)
        friction_of("friction", self.friction)
        vector("gravity", self.gravity)
        if not isinstance(self.numerics, Numerics):
            raise InputError(f"numerics = {said(self.numerics)} must be a warpdrape.Numerics")
        if self.numerics.yarn_recovery > 0.0 and self.approach not in RECOVERING:
            raise InputError(
                f"approach = {self.approach!r} does not know yarn_recovery: set it to 0 in the "
                "numerics, and yarn_softening to 36 at most, as strains then grow by it"
            )
        if not isinstance(self.defects, DefectThresholds):
            raise InputError(f"defects = {said(self.defects)} must be a warpdrape.DefectThresholds")
        self._check_limits()
        held: list[Clamp | Pressure | Spring] = [*self.clamps, *self.pressures, *self.springs]
        acting_names = [thing.name for thing in self.tools] + [thing.name for thing in held]
        ply_names = [ply.name for ply in self.plies]
        both = (("ply", ply_names), ("tool, clamp, pressure or spring", acting_names))
        for words, names in both:
            for name in names:
                if names.count(name) > 1:
                    raise InputError(f"two of the scene's {words} names are {name!r}: rename one")
        if not isinstance(self.ply_friction, Mapping):
            friction_of("ply_friction", self.ply_friction)
        for one, other in combinations(self.plies, 2):
            self.friction_between(one, other)
        for ply in filter(self.touches_itself, self.plies):
            self.friction_between(ply, ply)
        self._check_process()
        self._check_friction()
        _refuse_other_units(self.plies, self.tools)
        for thing in held:
            one_of("ply", thing.ply, ply_names)
        for wanted in self.wanted:
            ply = self.plies[ply_names.index(one_of("ply", wanted.ply, ply_names))]
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

    @cached_property
    def friction_laws(self) -> tuple[Friction, ...]:
        """Frictions that are more than a coefficient, each once."""
        plies, touching = self.plies, filter(self.touches_itself, self.plies)
        interfaces = [self.friction_of(tool) for tool in self.tools]
        interfaces += [self.friction_between(one, other) for one, other in combinations(plies, 2)]
        interfaces += [self.friction_between(ply, ply) for ply in touching]
        return tuple({id(law): law for law in interfaces if law.varies}.values())

    @property
    def pace(self) -> float:
        """Rates in the process over those of the simulation [-]."""
        return 1.0 if self.process_duration is None else self.duration / self.process_duration

    def process_time(self, time: np.ndarray) -> np.ndarray:
        """Time of the process [s] at times of the motions [s]."""
        return time / self.pace

    @cached_property
    def cooling(self) -> Mapping[int, Heat]:
        """What decides how the temperatures of plies change, by their numbers; none of those kept.

        A ply's card says how, and tools, the air or other such plies take heat or give it.
        """
        held = {
            number: matrix.heat
            for number, ply in enumerate(self.plies)
            if (matrix := ply.fabric.matrix) is not None and matrix.heat is not None
        }
        outside = self.air is not None or any(tool.temperature is not None for tool in self.tools)
        several = sum(heat.between is not None for heat in held.values()) > 1
        return held if outside or several else {}

    def cools(self, ply: Ply) -> bool:
        """Whether a ply's temperature changes."""
        return any(self.plies[number] is ply for number in self.cooling)

    def _check_limits(self) -> None:
        """Raise `InputError` where limits are none, or of what the scene has not."""
        if self.limits is None:
            return
        if not isinstance(self.limits, Limits):
            raise InputError(f"limits = {said(self.limits)} must be warpdrape.Limits")
        for name in self.limits.coverage:
            one_of("tool of limits.coverage", name, [tool.name for tool in self.tools])
        for name in self.limits.misalignment_deg:
            wanted = [each.name for each in self.wanted]
            one_of("wanted direction of limits.misalignment_deg", name, wanted)

    def _check_process(self) -> None:
        """Raise `InputError` where a viscous matrix lacks what it depends on, or is not known."""
        if self.process_duration is not None:
            positive("process_duration", self.process_duration, unit="s")
        wet = [ply for ply in self.plies if ply.fabric.matrix is not None]
        if not isinstance(self.air, Air | None):
            raise InputError(f"air = {said(self.air)} must be a warpdrape.Air")
        warm = {f"tool {tool.name!r}: temperature": tool.temperature for tool in self.tools}
        if self.air is not None:
            warm["air: temperature"] = self.air.temperature
        for what, kelvin in warm.items():
            if kelvin is not None and not self.cooling:
                raise InputError(
                    f"{what} = {kelvin:g} K is of no use: no ply's fabric has a matrix with heat; "
                    "leave it out, or give matrix.heat"
                )
        if not wet or self.approach == "fishnet":  # a net knows no forces
            return
        who = f"ply {wet[0].name!r} has a viscous matrix"
        if self.process_duration is None:
            raise InputError(
                f"{who} and needs process_duration = …, the time [s] that the press takes for what "
                f"is simulated in {self.duration:g} s: it resists by the rates of the press"
            )
        if self.approach in ("yarns", SLIDING_YARNS):
            raise InputError(
                f"{who}, which approach = {self.approach!r} does not know: take 'semi_discrete'"
            )
        if self.numerics.mass_scaling == "selective":
            raise InputError(f"{who}, which mass_scaling = 'selective' does not know: take 'plain'")

    def _check_friction(self) -> None:
        """Raise `InputError` where a friction law lacks what it depends on."""
        for tool in self.tools:
            if self.friction_of(tool).by_angle:
                raise InputError(
                    f"friction of tool {tool.name!r} has by_angle, the angle between the yarns of "
                    "two plies: a tool has no yarns; leave it out"
                )
        shifts = (p.fabric.matrix is not None and p.fabric.matrix.shift for p in self.plies)
        if any(law.shifted for law in self.friction_laws) and not any(shifts):
            raise InputError(
                "friction.shifted lets its viscosity follow the plies' temperature as their matrix "
                "does, and no ply's fabric has matrix.shift: leave it out, or give matrix.shift"
            )
        if not any(law.has_speed for law in self.friction_laws):
            return
        if self.process_duration is None:
            raise InputError(
                "friction by speed needs process_duration = …, the time [s] that the press takes "
                f"for what is simulated in {self.duration:g} s: plies slip that much slower there"
            )
        if self.numerics.kinetic_limit is not None:
            raise InputError(
                "friction by speed needs tools that keep their pace: leave out kinetic_limit"
            )

    def touches_itself(self, ply: Ply) -> bool:
        """Whether folds of a ply are held apart: those of one that does not bend have no size."""
        return self.self_contact and ply.fabric.bends

    @property
    def yarns_rub(self) -> bool:
        """Whether yarns slide, and rub where they cross: by how hard contacts press on them."""
        cards = (ply.fabric.crossover for ply in self.plies)
        return self.approach == SLIDING_YARNS and any(
            card is not None and card.yarn_friction > 0.0 for card in cards
        )

    def friction_of(self, tool: Tool) -> Friction:
        """Friction of a tool on the plies."""
        if tool.friction is None:
            return friction_of("friction", self.friction)
        return friction_of(f"tool {tool.name!r}: friction", tool.friction)

    def friction_between(self, one: Ply, other: Ply) -> Friction:
        """Friction between two plies, by their fabrics' names in either order.

        Raises:
            InputError: if ``ply_friction`` lacks these fabrics, or holds no coefficient for them.
        """
        if not isinstance(self.ply_friction, Mapping):
            return friction_of("ply_friction", self.ply_friction)
        pair = (one.fabric.name, other.fabric.name)
        for names in (pair, pair[::-1]):
            if names in self.ply_friction:
                return friction_of(f"ply_friction[{names!r}]", self.ply_friction[names])
        who = f"of plies {one.name!r} and {other.name!r}"
        if one is other:
            who = f"of a ply with itself, and ply {one.name!r} may touch itself"
        raise InputError(f"ply_friction lacks the fabrics {who}: add {pair!r}: its coefficient")


def _all_of(name: str, things: Any, kind: type) -> tuple[Any, ...]:
    """Return a sequence as a tuple; raise `InputError` where an entry is of another type."""
    if not isinstance(things, Sequence) or isinstance(things, str):
        raise InputError(f"{name} = {said(things)} must be a list of {kind.__name__}")
    for number, thing in enumerate(things):
        if not isinstance(thing, kind):
            raise InputError(f"{name}[{number}] = {said(thing)} is not a {kind.__name__}")
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
        if isinstance(tool.motion, Prescribed):
            way = tool.motion.largest_way
            if way > LONGEST_WAY * max(sizes):
                raise InputError(
                    f"tool {tool.name!r} travels {way:.4g} m, more than {LONGEST_WAY:g} times the "
                    f"plies' {max(sizes):.4g} m: give metres, as in 75 * mm"
                )
