"""A fabric's card as text: tables of values with unit, status and source, as TOML."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

BARE = re.compile(r"[A-Za-z0-9_-]+")
"""Keys that TOML takes without quotes."""


def card_text(tables: Mapping[str, Any], first: str = "") -> str:
    """A card as TOML.

    Args:
        tables: texts, lists, tables of values, and tables of such tables.
        first: comment at its head.
    """
    lines = [f"# {line}" for line in first.splitlines()]
    plain = {k: v for k, v in tables.items() if not isinstance(v, Mapping)}
    lines += [f"{_key(key)} = {_toml(value)}" for key, value in plain.items()]
    for key, table in tables.items():
        if isinstance(table, Mapping):
            lines += _table(_key(key), table)
    return "\n".join(lines) + "\n"


def _table(path: str, table: Mapping[str, Any]) -> list[str]:
    plain = {k: v for k, v in table.items() if not isinstance(v, Mapping)}
    lines = ["", f"[{path}]", *(f"{_key(key)} = {_toml(value)}" for key, value in plain.items())]
    for key, inner in table.items():
        if isinstance(inner, Mapping):
            lines += _table(f"{path}.{_key(key)}", inner)
    return lines


def _toml(value: Any) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple | np.ndarray):
        return "[" + ", ".join(_toml(v) for v in value) + "]"
    return repr(value.item() if isinstance(value, np.generic) else value)


def _key(name: str) -> str:
    return name if BARE.fullmatch(name) else _toml(name)
