"""The approaches by which a scene may be computed: their names, and where each is."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING

from warpdrape.errors import one_of

if TYPE_CHECKING:
    from warpdrape.results.result import Result

SEMI_DISCRETE = "semi_discrete"
"""The default: explicit dynamics of triangles of woven cells."""
SLIDING_YARNS = "sliding_yarns"
"""Needs a card that says how yarns slide, which few do."""
APPROACHES = {
    SEMI_DISCRETE: "warpdrape.simulation",
    "green_naghdi": "warpdrape.simulation",
    "fibre_frame": "warpdrape.simulation",
    "yarns": "warpdrape.simulation",
    SLIDING_YARNS: "warpdrape.simulation",
    "fishnet": "warpdrape.fishnet_run",
}
"""Name → module whose ``run_scene`` computes a scene; it is imported when it is used.

Those of `warpdrape.simulation` differ by the force of the plies' membranes:
`warpdrape.dynamics.interactions.MEMBRANES`."""
RECOVERING = frozenset({SEMI_DISCRETE, "yarns", "fishnet"})
"""Those whose softened yarns can recover their tension; a net knows no tension."""
PAIRED = frozenset({SEMI_DISCRETE, "green_naghdi", "fibre_frame"})
"""Those whose triangles share yarn strains in pairs, which a stabiliser holds together."""


def solver_of(approach: str) -> Callable[..., Result]:
    """The ``run_scene`` of an approach; raise `InputError` for a name that is none."""
    return import_module(APPROACHES[one_of("approach", approach, APPROACHES)]).run_scene
