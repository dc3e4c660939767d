"""Where a formed part ends: at one side of a plane, or at closed curves on it or near it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from warpdrape.errors import InputError, one_of, said
from warpdrape.exports.outlines import border_loops
from warpdrape.exports.trim_file import UNITS, read_curves
from warpdrape.results.result import PlacedTool

MM = 1e3
"""Millimetres in a metre."""
AXES = "xyz"
"""Axes along which curves can cut."""
_TERM = re.compile(r"([+-]?)(?:(\d*\.?\d+(?:e[+-]?\d+)?)\*?)?([xyz])")
_LIMIT = re.compile(r"([+-]?\d*\.?\d+(?:e[+-]?\d+)?)(m|cm|mm)?")


@dataclass(frozen=True)
class Side:
    """What is kept: points x with normal · x below the limit [m].

    Attributes:
        normal: shape [3].
        limit: [m].
    """

    normal: np.ndarray
    limit: float


@dataclass(frozen=True)
class Curves:
    """Where the part ends.

    Attributes:
        loops: closed curves [m], each shape [n, 3].
        name: what they are called in messages.
        along: axis along which they cut; None to take each point to the ply's nearest one.
    """

    loops: Sequence[np.ndarray]
    name: str
    along: str | None = None


def read_trim(
    text: str, tools: Sequence[PlacedTool] = (), along: str | None = None
) -> Side | Curves:
    """Understand what a user gives.

    Args:
        text: a side such as ``z<-20mm`` or ``x+0.5*z>0``, ``tool:NAME`` for that tool's border, or
            a file.
        tools: where they are.
        along: "x", "y" or "z": curves cut along this axis, however far from the plies they lie.

    Raises:
        InputError: if it is none of these.
    """
    if along is not None:
        one_of("axis", along, AXES)
    if not isinstance(text, str | Path):
        raise InputError(
            f"trim = {said(text)} must be a file, a side such as z<-20mm, or tool:NAME"
        )
    words = str(text)
    if re.search(r"[<>]", words):
        if along is not None:
            raise InputError(f"trim = {words!r} is a plane, which along = {along} does not go with")
        return _side(words)
    if words.startswith("tool:"):
        return replace(_border(words.removeprefix("tool:"), tools), along=along)
    return Curves(read_curves(Path(text)), f"the curve in {Path(text).name}", along)


def _side(text: str) -> Side:
    """Read ``a*x+b*y+c*z < limit``, or >, a limit without unit in metres."""
    left, sign, right = re.split(r"([<>])", text.replace(" ", "").lower(), maxsplit=1)
    terms, limit = list(_TERM.finditer(left)), _LIMIT.fullmatch(right)
    if not terms or "".join(term[0] for term in terms) != left or limit is None:
        raise InputError(
            f"trim = {text!r} must be a side of a plane, such as z<-20mm or x+0.5*z>10mm"
        )
    normal = np.zeros(3)
    for term in terms:
        normal["xyz".index(term[3])] += float(term[2] or 1.0) * (-1.0 if term[1] == "-" else 1.0)
    if not normal.any():
        raise InputError(f"trim = {text!r} is no plane: its terms cancel")
    bound = float(limit[1]) * UNITS[limit[2] or "m"]
    return Side(normal, bound) if sign == "<" else Side(-normal, -bound)


def _border(name: str, tools: Sequence[PlacedTool]) -> Curves:
    names = [tool.name for tool in tools]
    tool = tools[names.index(one_of("tool", name, names))]
    places, same = np.unique(tool.vertices, axis=0, return_inverse=True)
    loops = border_loops(same.reshape(-1)[tool.triangles].tolist())
    if not loops:
        raise InputError(f"trim = tool:{name}: the tool is closed, it has no border; give a curve")
    return Curves([places[loop] for loop in loops], f"the border of {name}")
