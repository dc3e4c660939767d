"""What is to be best, and what must hold: objectives and constraints on a study's measures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, cast

from warpdrape.errors import InputError, finite, nearest, said
from warpdrape.studies.study_file import check_keys

LOCKING = "locking"
"""Limit that is the fabric's own: its locking angle."""
MOST_OBJECTIVES = 2


@dataclass(frozen=True)
class Objective:
    """A measure that is to be as small, or as large, as can be.

    Attributes:
        measure: its name.
        sign: 1 to make it small, -1 to make it large.
    """

    measure: str
    sign: float = 1.0

    @property
    def words(self) -> str:
        """What is to be done with it."""
        return f"{'least' if self.sign > 0.0 else 'largest'} {self.measure}"


@dataclass(frozen=True)
class Constraint:
    """What a measure may be at most, or must be at least.

    Attributes:
        measure: its name.
        limit: in the measure's unit.
        sign: 1 for at most, -1 for at least.
    """

    measure: str
    limit: float
    sign: float = 1.0

    def excess(self, value: float) -> float:
        """By how much a value is beyond the limit; zero or less where it holds."""
        return self.sign * (value - self.limit)

    @property
    def words(self) -> str:
        """As a condition."""
        return f"{self.measure} {'≤' if self.sign > 0.0 else '≥'} {self.limit:.6g}"


@dataclass(frozen=True)
class Aims:
    """All that is wanted of a run.

    Attributes:
        objectives: one or two.
        constraints: that must hold.
        quasi_static: whether runs that are not count as failed.
    """

    objectives: tuple[Objective, ...]
    constraints: tuple[Constraint, ...] = ()
    quasi_static: bool = True

    @property
    def every(self) -> tuple[Objective | Constraint, ...]:
        """Objectives, then constraints."""
        return (*self.objectives, *self.constraints)

    @property
    def measures(self) -> list[str]:
        """Names of the measures that are needed, each once."""
        return list(dict.fromkeys(each.measure for each in self.every))

    def score(self, values: Mapping[str, float | None], summary: Mapping[str, Any]) -> Score:
        """What a run that completed is worth.

        Args:
            values: its measures by name.
            summary: of the run.
        """
        missing = [name for name in self.measures if values.get(name) is None]
        if missing:
            return Score(values, why=f"it has no {', '.join(missing)}")
        if self.quasi_static and summary.get("quasi_static") is False:
            return Score(
                values,
                why="not quasi-static: its end is one of motion, not of the press; give it a "
                "longer duration",
            )
        return self.of_values(values)

    def of_values(self, values: Mapping[str, Any]) -> Score:
        """The score of measures that are all there."""
        return Score(
            values,
            tuple(o.sign * values[o.measure] for o in self.objectives),
            tuple(c.excess(values[c.measure]) for c in self.constraints),
        )


@dataclass(frozen=True)
class Score:
    """What a run is worth.

    Attributes:
        values: its measures by name.
        objectives: each as something to be made small; none where the run does not count.
        excess: of each constraint, in its measure's unit; zero or less where it holds.
        why: why the run does not count; empty if it does.
    """

    values: Mapping[str, float | None] = field(default_factory=dict)
    objectives: tuple[float, ...] = ()
    excess: tuple[float, ...] = ()
    why: str = ""

    def value(self, measure: str) -> float:
        """A measure of a run that counts, where none is None."""
        return cast(float, self.values[measure])

    @property
    def counts(self) -> bool:
        """Whether it came to a result that can be judged."""
        return not self.why

    @property
    def feasible(self) -> bool:
        """Whether it counts, and all constraints hold."""
        return self.counts and all(each <= 0.0 for each in self.excess)


def read_aims(given: Mapping[str, Any], known: Sequence[str], locking_deg: float | None) -> Aims:
    """Read objectives and constraints from the table of an optimisation.

    Args:
        given: the table.
        known: names of the study's measures.
        locking_deg: the fabric's locking angle [deg], None where its card has none.

    Raises:
        InputError: nothing or too much is to be best, or a limit makes no sense.
    """
    objectives = [
        Objective(_measure(key, name, known), sign)
        for key, sign in (("minimise", 1.0), ("maximise", -1.0))
        for name in _names(key, given.get(key, []))
    ]
    names = [objective.measure for objective in objectives]
    if not 1 <= len(objectives) <= MOST_OBJECTIVES or len(set(names)) < len(names):
        raise InputError(
            f"optimise: give one objective or two, as minimise = {said(known[0])}; there are "
            f"{len(names)}; state the others as constraints"
        )
    table = given.get("constraints", {})
    if not isinstance(table, Mapping):
        raise InputError(
            f"optimise: constraints = {said(table)} must be a table, as "
            "[optimise.constraints] with NAME = { most = 40 }"
        )
    constraints = [
        found
        for name, limits in table.items()
        for found in _constraints(_measure("constraints", name, known), limits, locking_deg)
    ]
    quasi_static = given.get("quasi_static", True)
    if not isinstance(quasi_static, bool):
        raise InputError(f"optimise: quasi_static = {said(quasi_static)} must be true or false")
    return Aims(tuple(objectives), tuple(constraints), quasi_static)


def _names(key: str, given: Any) -> list[str]:
    names = [given] if isinstance(given, str) else given
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InputError(f"optimise: {key} = {said(given)} must be a measure's name, or two")
    return names


def _measure(key: str, name: str, known: Sequence[str]) -> str:
    if name not in known:
        raise InputError(f"optimise: {key}: there is no measure {name!r}{nearest(name, known)}")
    return name


def _constraints(name: str, limits: Any, locking_deg: float | None) -> list[Constraint]:
    where = f"optimise: constraints: {name}"
    if not isinstance(limits, Mapping) or not limits:
        raise InputError(
            f"{where} = {said(limits)} must be {{ most = NUMBER }} or {{ least = NUMBER }}"
        )
    check_keys(f"{where}: ", limits, ("most", "least"))
    found = []
    for key, sign in (("most", 1.0), ("least", -1.0)):
        if key not in limits:
            continue
        limit = limits[key]
        if limit == LOCKING:
            if locking_deg is None:
                raise InputError(
                    f"{where}: the fabric's card has no locking_angle: give a number in degrees"
                )
            limit = locking_deg
        found.append(Constraint(name, finite(f"{where}: {key}", limit), sign))
    if len(found) == 2 and found[0].limit < found[1].limit:
        raise InputError(f"{where} = {dict(limits)!r}: nothing is below most and above least")
    return found
