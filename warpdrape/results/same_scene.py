"""Whether a run folder's record is of a scene as it stands."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
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
_VALUES = ("parameters", "numerics")
"""Those whose own entries have values that a line can say."""
_WORDS = {
    "duration_s": "duration",
    "ply_friction": "friction between plies",
    "self_contact": "contact of plies with themselves",
    "process_duration_s": "duration of the process",
    "gravity_m_s2": "gravity",
    THRESHOLDS: "thresholds of defects",
    "wanted": "wanted directions",
}
"""Names of entries in words, where these are others."""
_STABILISER = "stabiliser_n_m"
"""Entry of a ply: smallest and largest of what holds its pairs of triangles together [N/m]."""


def scene_difference(
    record: Mapping[str, Any], scene: Setup, *, without: Collection[str] = ()
) -> str:
    """Say what a run has that a scene has otherwise; empty where it is a run of it.

    Args:
        record: of the run, as in ``run.json``.
        scene: as it would be run.
        without: entries that may differ.
    """
    return record_difference(record, record_of(scene), without=without)


def record_of(scene: Setup, frames: int = 1) -> dict[str, Any]:
    """The record that a run of a scene would have, as far as it is known before it runs."""
    record: dict[str, Any] = as_json(run_record(scene, None, frames, 1), "run")
    return record


def record_difference(
    record: Mapping[str, Any], wanted: Mapping[str, Any], *, without: Collection[str] = ()
) -> str:
    """Likewise of the record that a run of a scene would have."""
    for name in _OF_SCENE:
        if name not in without and record.get(name) != wanted[name]:
            return _other(name, record.get(name), wanted[name])
    return ""


def _other(name: str, there: Any, wanted: Any) -> str:
    """Name what is other, and of a parameter or a field of the numerics its value there."""
    if name in _VALUES and isinstance(there, dict):
        odd = next(key for key in [*wanted, *there] if there.get(key) != wanted.get(key))
        words = f"a run with {odd} = {there.get(odd)}, not {wanted.get(odd)}"
        return " ".join(words.split())
    if name == "plies" and isinstance(there, list) and _but_stabiliser(there, wanted):
        return _other_stabiliser(there, wanted)
    return f"a run with other {_WORDS.get(name, name)}"


def _but_stabiliser(there: Sequence[Mapping], wanted: Sequence[Mapping]) -> bool:
    """Whether plies differ in nothing but in what holds their pairs of triangles together."""
    bare = [[{**ply, _STABILISER: None} for ply in plies] for plies in (there, wanted)]
    return bare[0] == bare[1]


def _other_stabiliser(there: Sequence[Mapping], wanted: Sequence[Mapping]) -> str:
    """Say how the first ply whose stabiliser is another was held together."""
    pairs = zip(there, wanted, strict=True)
    old, new = next(pair for pair in pairs if pair[0].get(_STABILISER) != pair[1][_STABILISER])
    if _STABILISER not in old:
        return "a run of before its stabiliser was written down, which may have been another"
    held = [_span(ply[_STABILISER]) for ply in (old, new)]
    return f"a run with a stabiliser of {held[0]} on ply {new['name']}, not {held[1]}"


def _span(stabiliser: Sequence[float] | None) -> str:
    """Smallest and largest stabiliser of a ply in words."""
    if stabiliser is None:
        return "none"
    ends = [f"{value:.6g}" for value in stabiliser]
    return f"{' to '.join(dict.fromkeys(ends))} N/m"
