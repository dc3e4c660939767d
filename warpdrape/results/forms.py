"""What values of a JSON file may be: forms that name every value that is not as it should be."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any

Form = Callable[[Any, str], Iterator[str]]
"""Yields the names of what is not as it should be: takes a value and its own name."""


def number(value: Any, name: str) -> Iterator[str]:
    """A finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not _finite(value):
        yield name


def count(value: Any, name: str) -> Iterator[str]:
    """A whole number, zero or more."""
    if isinstance(value, bool) or not isinstance(value, int) or value < 0 or not _finite(value):
        yield name


def text(value: Any, name: str) -> Iterator[str]:
    """Any text."""
    if not isinstance(value, str):
        yield name


def flag(value: Any, name: str) -> Iterator[str]:
    """True or false."""
    if not isinstance(value, bool):
        yield name


def one_of(*known: str) -> Form:
    """One of some texts."""

    def form(value: Any, name: str) -> Iterator[str]:
        if value not in known:
            yield name

    return form


def maybe(form: Form) -> Form:
    """A value of a form, or none."""
    return lambda value, name: iter(()) if value is None else form(value, name)


def each(form: Form, size: int | None = None) -> Form:
    """A list of values of one form, of a given size where it is given."""

    def of_list(value: Any, name: str) -> Iterator[str]:
        if not isinstance(value, list) or (size is not None and len(value) != size):
            yield name
            return
        for number_of, inside in enumerate(value):
            yield from form(inside, f"{name}[{number_of}]")

    return of_list


def by_name(form: Form) -> Form:
    """Values of one form under names of any kind."""

    def of_names(value: Any, name: str) -> Iterator[str]:
        if not isinstance(value, Mapping):
            yield name
            return
        for key, inside in value.items():
            yield from form(inside, f"{name}.{key}")

    return of_names


def entries(always: Mapping[str, Form], some: Mapping[str, Form] | None = None) -> Form:
    """Values of their own form each: some of them always there, others where there is any."""

    def of_entries(value: Any, name: str) -> Iterator[str]:
        if not isinstance(value, Mapping):
            yield name or "entries"
            return
        for known, needed in ((always, True), (some or {}, False)):
            for key, form in known.items():
                own = f"{name}.{key}" if name else key
                if key in value:
                    yield from form(value[key], own)
                elif needed:
                    yield own

    return of_entries


def either(key: str, with_it: Form, without: Form) -> Form:
    """Entries of one form where they have a certain one, of another where not."""

    def of_entries(value: Any, name: str) -> Iterator[str]:
        has = isinstance(value, Mapping) and key in value
        yield from (with_it if has else without)(value, name)

    return of_entries


def together(form: Form, names: Collection[str]) -> Form:
    """Entries of which some are none together, or not at all."""

    def of_entries(value: Any, name: str) -> Iterator[str]:
        odd = list(form(value, name))
        none = [key for key in names if not odd and value[key] is None]
        yield from odd or (f"{name}.{key}" for key in none if len(none) < len(names))

    return of_entries


def _finite(value: float) -> bool:
    try:
        return math.isfinite(float(value))
    except OverflowError:
        return False
