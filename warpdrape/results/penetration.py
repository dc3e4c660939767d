"""Warning of what lay so deep in each other that it may have passed, and why it gave way so far."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from warpdrape.dynamics.model import Model
from warpdrape.setup import Setup

DEEP = 0.5
"""Penetration over a ply's thickness above which a run warns [-]."""


def passed_through(model: Model, contacts: Mapping[str, Sequence[Mapping[str, Any]]]) -> list[str]:
    """Warning of the things that lay deepest in each other, if they may have passed.

    A vertex on a tool presses with its contact's stiffness times its depth: so the depth in a tool
    tells the force, and whether to doubt the loads or the stiffness.

    Args:
        model: the model.
        contacts: entries of what was met, by name.
    """
    deep = [
        (depth - room, depth, words)
        for depth, words, thickness, room in _depths(model.scene, contacts)
        if depth - room > DEEP * thickness
    ]
    if not deep:
        return []
    _, depth, words = max(deep)
    why, remedy = "", "lower the forces or the speed, refine the plies, or raise contact_share"
    if words.startswith("tool ") and not any(ply.fabric.compaction for ply in model.scene.plies):
        share = model.scene.numerics.contact_share
        stiffness = share * float(np.median(model.masses.mass)) / model.timing.time_step**2
        why = (
            f"contacts of {1e-3 * stiffness:.2g} N/mm give way so far where a vertex presses with "
            f"{stiffness * depth:.2g} N; "
        )
        remedy += " or shorten the step (in press scenes take accuracy = reference)"
    return [f"{words} lay {1e3 * depth:.3g} mm in each other and may have passed: {why}{remedy}"]


def _depths(
    scene: Setup, contacts: Mapping[str, Sequence[Mapping[str, Any]]]
) -> list[tuple[float, str, float, float]]:
    """Depth, words, thickness of the thinner ply, room that compaction laws allow [m]."""
    thin = {ply.name: ply.fabric.thickness for ply in scene.plies}
    rooms = {
        ply.name: 0.5 * ply.fabric.compaction.room if ply.fabric.compaction else 0.0
        for ply in scene.plies
    }
    found = [
        (entry, f"tool {tool.name!r} and a ply", min(thin.values()), max(rooms.values()))
        for tool, entry in zip(scene.tools, contacts.get("tools", ()), strict=False)
    ]
    for entry in contacts.get("interfaces", ()):
        one, other = entry["vertices_of"], entry["on"]
        words = f"plies {one!r} and {other!r}"
        found.append((entry, words, min(thin[one], thin[other]), rooms[one] + rooms[other]))
    for entry in contacts.get("self_contact", ()):
        name = entry["ply"]
        found.append((entry, f"folds of ply {name!r}", thin[name], 2.0 * rooms[name]))
    for entry in contacts.get("edge_contact", ()):
        one, other = entry["edges_of"], entry["on"]
        words = f"edges of plies {one!r} and {other!r}"
        if one == other:
            words = f"edges of folds of ply {one!r}"
        found.append((entry, words, min(thin[one], thin[other]), rooms[one] + rooms[other]))
    return [(entry["max_penetration_m"], *rest) for entry, *rest in found]
