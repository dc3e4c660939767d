"""Whether a run folder's record is of a scene as it stands."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from warpdrape.results.run_folder import as_json
from warpdrape.results.run_record import run_record
from warpdrape.setup import Setup

THRESHOLDS = "defect_thresholds"
"""Entry of the record with what counts as a defect: it changes no result but defects."""
_OF_SCENE = (
    "scene",
    "approach",
    "parameters",
    "fabrics",
    "duration_s",
    "friction",
    "ply_friction",
    "self_contact",
    "process_duration_s",
    "air",
    "gravity_m_s2",
    "numerics",
    THRESHOLDS,
    "limits",
    "wanted",
    "plies",
    "tools",
    "clamps",
    "pressures",
    "springs",
)
"""Entries of a run's record that a scene fixes before it runs, the most telling first."""


def scene_difference(
    record: Mapping[str, Any], scene: Setup, *, without: Collection[str] = ()
) -> str:
    """Say what a run has that a scene has otherwise; empty where it is a run of it.

    Args:
        record: of the run, as in ``run.json``.
        scene: as it would be run.
        without: entries that may differ.
    """
    wanted: dict[str, Any] = as_json(run_record(scene, None, 1, 1), "run")
    for name in _OF_SCENE:
        if name not in without and record.get(name) != wanted[name]:
            return _other(name, record.get(name), wanted[name])
    return ""


def _other(name: str, there: Any, wanted: Any) -> str:
    """Name what is other, and of a parameter its value there."""
    if name == "parameters" and isinstance(there, dict):
        odd = next(key for key in [*wanted, *there] if there.get(key) != wanted.get(key))
        return f"a run with {odd} = {there.get(odd)}, not {wanted.get(odd)}"
    return f"a run with other {name.partition('_')[0]}"
