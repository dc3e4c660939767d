"""Values that commands share: where results go, and whole numbers as they are typed."""

from __future__ import annotations

OUT = "runs"
"""Folder, in the current one, that takes a run's folder where ``--out`` is not given."""


def whole(option: str, text: str, least: int | None = None) -> int:
    """Read a whole number; raise `InputError` if it is none, or too small."""
    from warpdrape.errors import InputError

    try:
        number = int(text)
    except ValueError:
        raise InputError(f"{option} {text} must be a whole number") from None
    if least is not None and number < least:
        raise InputError(f"{option} {number} must be {least} or more")
    return number
