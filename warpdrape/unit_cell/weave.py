"""Weaves in which all warp yarns are alike, and all weft yarns: plain, twill, satin."""

from __future__ import annotations

import math
from dataclasses import dataclass

from warpdrape.errors import InputError, one_of

WEAVES = ("plain", "twill", "satin")
MOST_HARNESSES = 16


@dataclass(frozen=True)
class Weave:
    """A regular weave.

    Attributes:
        over: whether warp yarn 0 lies over weft yarn j, for the j of one repeat.
        move: by how many weft yarns the pattern has moved on from one warp yarn to the next.
        name: in words.
    """

    over: tuple[bool, ...]
    move: int
    name: str = "weave"

    def __post_init__(self) -> None:
        n = len(self.over)
        if not 2 <= n <= MOST_HARNESSES:
            raise InputError(f"a weave repeats after 2 to {MOST_HARNESSES} yarns, not {n}")
        if all(self.over) or not any(self.over):
            raise InputError("a warp yarn that never changes sides is not woven in: change over")
        if math.gcd(self.move, n) != 1:
            raise InputError(
                f"move = {self.move} and the repeat of {n} yarns have a common factor, so that "
                "weft yarns differ: give a move without one"
            )

    @property
    def repeat(self) -> int:
        """Yarns after which it repeats, both ways."""
        return len(self.over)

    @property
    def signs(self) -> tuple[int, ...]:
        """1 where warp yarn 0 lies over weft yarn j, −1 where under."""
        return tuple(1 if up else -1 for up in self.over)

    def matrix(self) -> list[list[int]]:
        """1 where warp yarn i (row) lies over weft yarn j (column), else 0."""
        n = self.repeat
        return [[int(self.over[(j - self.move * i) % n]) for j in range(n)] for i in range(n)]

    def weft_offset(self, weft: int) -> int:
        """By how many warp yarns weft yarn ``weft`` is moved on from weft yarn 0."""
        return (weft * pow(self.move, -1, self.repeat)) % self.repeat

    def weft_signs(self) -> tuple[int, ...]:
        """1 where weft yarn 0 lies over warp yarn i, −1 where under."""
        n = self.repeat
        return tuple(-self.signs[(-self.move * i) % n] for i in range(n))


def plain() -> Weave:
    """Over one, under one."""
    return Weave((True, False), 1, "plain")


def twill(over: int = 2, under: int = 2) -> Weave:
    """Over some, under some, moved by one from yarn to yarn.

    Args:
        over: weft yarns that a warp yarn passes over at a time.
        under: … and under.
    """
    return Weave((True,) * over + (False,) * under, 1, f"twill {over}/{under}")


def satin(harness: int = 5, move: int = 2) -> Weave:
    """Over one, under all others, moved so that no two binding points touch.

    Args:
        harness: yarns of the repeat, five or more.
        move: 2 … harness − 2, without a common factor with it.
    """
    if harness < 5:
        raise InputError(
            f"harness = {harness} of a satin must be 5 or more: take a twill 1/{harness - 1}"
        )
    if not 2 <= move <= harness - 2:
        raise InputError(
            f"move = {move} of a satin of {harness} must lie in 2 … {harness - 2}: with others "
            "binding points touch, as in a twill"
        )
    return Weave((True,) + (False,) * (harness - 1), move, f"satin {harness}, move {move}")


def weave_of(kind: str, **numbers: int) -> Weave:
    """A weave by name.

    Args:
        kind: one of `WEAVES`.
        numbers: over and under of a twill, harness and move of a satin.

    Raises:
        InputError: unknown weave, or numbers that are not of its kind.
    """
    one_of("weave", kind, WEAVES)
    known = {"plain": (), "twill": ("over", "under"), "satin": ("harness", "move")}[kind]
    for name, number in numbers.items():
        if name not in known:
            raise InputError(f"{name} = {number} says nothing of a {kind} weave: leave it out")
        if not 1 <= number <= MOST_HARNESSES:
            raise InputError(f"{name} = {number} must lie in 1 … {MOST_HARNESSES}")
    return {"plain": plain, "twill": twill, "satin": satin}[kind](**numbers)
