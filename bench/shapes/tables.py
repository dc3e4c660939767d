"""The tables by name: each with its page and what makes it."""

from __future__ import annotations

from collections.abc import Callable

from press import shapes, tetrahedron_force, two_plies
from runs import Runs

TABLES: dict[str, tuple[str, Callable[[Runs], str]]] = {
    "shapes": ("benchmarks.md", shapes),
    "tetrahedron_force": ("benchmarks/tetrahedron.md", tetrahedron_force),
    "two_plies": ("benchmarks/two_plies.md", two_plies),
}
