"""What is computed: cases, and ways to compute them."""

from __future__ import annotations

from typing import Any

CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "hemisphere_0": ("hemisphere", {}),
    "hemisphere_45": ("hemisphere", {"angle_deg": 45.0}),
    "three_plies": ("three_ply_hemisphere", {}),
    "eight_plies": ("stacked_hemisphere", {}),
    "double_dome": ("double_dome", {"cells": 20}),
    "square_box": ("square_box", {"cells": 20}),
    "tetrahedron": ("tetrahedron", {"cells": 20, "holder_force": 20.0}),
    "circular_table": ("circular_table", {"cells": 32, "bending": "0.0003"}),
}
"""Scene and parameters of each case: as coarse as their errors still mean something."""
CONVERGED: dict[str, Any] = {"accuracy": "reference"}
"""The reference of presses."""
CONVERGED_DRAPE: dict[str, Any] = {"safety": 0.45}
"""The reference of a scene in which nothing is pressed: half of its step."""
WAYS: dict[str, dict[str, Any]] = {
    "reference": {"accuracy": "reference"},
    "reference, 320 ms": {"accuracy": "reference", "duration": 0.32},
    "standard": {"accuracy": "standard"},
    "draft": {"accuracy": "draft"},
    "full stiffness, 80 ms, brake 0.3": {
        "accuracy": "reference",
        "duration": 0.08,
        "brake": 0.3,
    },
    "full stiffness, 80 ms": {"accuracy": "reference", "duration": 0.08},
    "full stiffness, 40 ms": {"accuracy": "reference", "duration": 0.04},
    "brake 0.3": {"brake": 0.3},
    "no recovery, softening 36": {"yarn_softening": 36.0, "yarn_recovery": 0.0},
    "no recovery, softening 100": {"yarn_recovery": 0.0},
    "recovery 0.1": {"yarn_recovery": 0.1},
    "recovery 0.2": {"yarn_recovery": 0.2},
    "softening 16": {"yarn_softening": 16.0},
    "softening 36": {"yarn_softening": 36.0},
    "softening 64": {"yarn_softening": 64.0},
    "softening 64, 40 ms": {"yarn_softening": 64.0, "duration": 0.04},
    "160 ms": {"duration": 0.16},
    "40 ms": {"duration": 0.04},
    "20 ms": {"duration": 0.02},
    "share 0.02": {"contact_share": 0.02},
    "share 0.1": {"contact_share": 0.1},
    "share 0.2": {"contact_share": 0.2},
    "slide 0.04 mm": {"search_slide": 4e-5},
    "slide 0.25 mm": {"search_slide": 2.5e-4},
    "selective": {"mass_scaling": "selective", "minimum_time_step": 7e-6},
}
"""Parameters of the scene, and fields of its numerics, of each way, where they are not the standard
accuracy's."""
TUNED = ("contact_share", "yarn_softening", "yarn_recovery", "search_slide")
"""Of those, what is set beside the accuracy's own, whatever the scene makes of its parameters."""


def reference_of(case: str) -> dict[str, Any]:
    """How a case is computed as its reference."""
    return CONVERGED_DRAPE if is_drape(case) else CONVERGED


def changes_of(case: str, way: str) -> dict[str, Any]:
    """What a way changes of a case: a drape has neither a stroke nor an accuracy."""
    changes = WAYS[way]
    if is_drape(case):
        changes = {name: value for name, value in changes.items() if name == "yarn_softening"}
    return changes


def is_drape(case: str) -> bool:
    """Whether nothing is pressed in a case."""
    return CASES[case][0] == "circular_table"
