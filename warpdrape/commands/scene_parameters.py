"""Parameters of a scene: names, types, units and defaults, read off its ``build`` function."""

from __future__ import annotations

import inspect
import math
import re
import types
import typing
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from warpdrape.errors import InputError

_TRUE = ("true", "yes", "on", "1")
_FALSE = ("false", "no", "off", "0")
_WORDS = {float: "a number", int: "a whole number", bool: "true or false", str: "a text"}
_UNITS: dict[str, dict[str, float]] = {
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "µm": 1e-6, "um": 1e-6},
    "N": {"N": 1.0, "kN": 1e3},
    "s": {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "us": 1e-6},
    "deg": {"deg": 1.0, "°": 1.0, "rad": 180.0 / math.pi},
    "Pa": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "bar": 1e5},
    "kg": {"kg": 1.0, "g": 1e-3},
    "m/s": {"m/s": 1.0, "mm/s": 1e-3},
    "N·m": {"N·m": 1.0, "Nm": 1.0, "N·mm": 1e-3, "Nmm": 1e-3},
    "-": {"%": 1e-2},
}
"""Unit of a parameter → units with which it may be given → factor."""
_WITH_UNIT = re.compile(r"([-+]?[\d.]+(?:[eE][-+]?\d+)?) ?([^\W\d_]+(?:[·/][^\W\d_]+)?|°|%)")
_OWN_UNIT = re.compile(r"\[([^\]]*)\]")
_ARGUMENT = re.compile(r"(\*{0,2}\w+)(?: \([^)]*\))?:\s*(.*)")


@dataclass(frozen=True)
class Parameter:
    """A parameter of a scene.

    Attributes:
        name: as given with ``--set``.
        kind: float, int, bool or str, of each entry where ``several``; None for one that text
            cannot say.
        default: its value when not given.
        optional: whether "none" is a value.
        description: its line in the docstring of ``build``, with the unit.
        several: whether it is a list, written with commas.
    """

    name: str
    kind: type | None
    default: Any
    optional: bool
    description: str
    several: bool = False

    def read(self, text: str) -> Any:
        """Return the value that ``text`` says; raise `InputError` if it is of another type."""
        if self.kind is None:
            raise InputError(
                f"{self.name} cannot be given with --set (its default is {self.default!r}): "
                "call build() from Python"
            )
        if self.optional and text.lower() == "none":
            return None
        if not self.several:
            return self._one(text)
        entries = [entry.strip() for entry in text.strip("()[] ").split(",")]
        bare = [_number(float, entry) is not None for entry in entries]
        if self.kind in (float, int) and any(bare) and not all(bare):
            raise InputError(
                f"{self.name} = {text!r}: give every number its unit, or none: 10mm,20mm"
            )
        return tuple(map(self._one, entries))

    def _one(self, text: str) -> Any:
        """Value of one number, word or text."""
        if self.kind is None or self.kind is str:
            return text
        value = _number(self.kind, text)
        if value is None and self.kind in (float, int):
            value = self._with_unit(text)
        if value is None:
            words = "a list of numbers with commas" if self.several else _WORDS[self.kind]
            raise InputError(
                f"{self.name} = {text!r} must be {words}, such as {self.name}={shown(self.default)}"
            )
        if isinstance(value, float) and not math.isfinite(value):
            raise InputError(f"{self.name} = {text} must be finite")
        return value

    @property
    def unit(self) -> str:
        """Its unit, the first one in square brackets of its description; "" if it has none."""
        found = _OWN_UNIT.search(self.description)
        return found[1] if found else ""

    def _bare(self, number: str) -> str:
        """How it is given, in words, where no unit may stand behind the number."""
        its = f"is in {self.unit}" if self.unit else "has no unit"
        return f"it {its} and is given as a number alone: {self.name}={number}"

    def _with_unit(self, text: str) -> float | int | None:
        """Value of a number with a unit, such as 75mm; None for anything else.

        Raises:
            InputError: if the unit is none of the parameter's.
        """
        found = _WITH_UNIT.fullmatch(text.strip().replace("μ", "µ"))
        number = _number(float, found[1]) if found else None
        if found is None or number is None:
            return None
        units = _UNITS.get(self.unit, {})
        if found[2] not in units:
            known = ", ".join(units)
            remedy = f"units it may be given with: {known}" if known else self._bare(found[1])
            raise InputError(f"{self.name} = {text!r}: {remedy}")
        value = number * units[found[2]]
        if self.kind is float:
            return value
        whole = round(value)
        return whole if math.isclose(whole, value, rel_tol=1e-9) else None


def read_parameters(build: Callable[..., Any]) -> dict[str, Parameter]:
    """Return the parameters of ``build`` by name, in their order.

    Raises:
        InputError: naming a parameter that is no keyword with a default.
    """
    lines = _argument_lines(inspect.getdoc(build) or "")
    hints = _hints(build)
    parameters = {}
    for parameter in inspect.signature(build).parameters.values():
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        name, default = parameter.name, parameter.default
        if default is parameter.empty or parameter.kind is parameter.POSITIONAL_ONLY:
            raise InputError(
                f"parameter {name!r} of build() must be a keyword with a default, "
                f"such as {name}=0.1"
            )
        hint, several = _entry_hint(hints.get(name))
        kind, optional = _kind(hint, default)
        line = lines.get(name, "")
        parameters[name] = Parameter(name, kind, default, optional, line, several)
    return parameters


def _entry_hint(hint: Any) -> tuple[Any, bool]:
    """Annotation of the entries of a list of any length, and whether it is one."""
    if isinstance(hint, types.UnionType) or typing.get_origin(hint) is typing.Union:
        lists = [entry for entry, several in map(_entry_hint, typing.get_args(hint)) if several]
        return (lists[0], True) if lists else (hint, False)
    of, entries = typing.get_origin(hint), typing.get_args(hint)
    if of in (list, Sequence) or (of is tuple and entries[1:] == (Ellipsis,)):
        return entries[0], True
    return hint, False


def _kind(hint: Any, default: Any) -> tuple[type | None, bool]:
    """Type of a parameter from its annotation, else from its default; and whether None is one."""
    options = typing.get_args(hint) if isinstance(hint, types.UnionType) else (hint,)
    if typing.get_origin(hint) is typing.Union:
        options = typing.get_args(hint)
    kinds = [kind for kind in (float, int, bool, str) if kind in options]
    if not kinds and type(default) in _WORDS:
        kinds = [type(default)]
    return (kinds[0] if kinds else None), type(None) in options or default is None


def _hints(build: Callable[..., Any]) -> dict[str, Any]:
    try:
        return typing.get_type_hints(build)
    except Exception:  # an annotation that names nothing: the defaults' types must do
        return {}


def _number(kind: type, text: str) -> float | int | bool | None:
    if kind is bool:
        word = text.lower()
        return word in _TRUE if word in (*_TRUE, *_FALSE) else None
    try:
        return kind(text)
    except ValueError:
        return None


def shown(value: Any) -> str:
    """Return a value as one writes it after ``--set NAME=``."""
    if isinstance(value, bool) or value is None:
        return str(value).lower()
    if isinstance(value, list | tuple):
        return ",".join(map(shown, value))
    return f"{value:g}" if isinstance(value, float) else str(value)


def _argument_lines(docstring: str) -> dict[str, str]:
    """Read the ``Args:`` of a Google docstring: name → text."""
    _, _, block = docstring.partition("\nArgs:\n")
    found: dict[str, str] = {}
    name = ""
    for line in block.splitlines():
        if line.strip() and not line.startswith(" "):
            break
        match = _ARGUMENT.fullmatch(line.strip())
        if match and len(line) - len(line.lstrip()) <= 4:
            name, found[match[1]] = match[1], match[2]
        elif name and line.strip():
            found[name] += " " + line.strip()
    return found
