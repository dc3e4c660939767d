"""Defects of the plies of a run: at every frame what is shown of them, at the end all of them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from warpdrape.defects.alignment import misalignment_entry, misalignments
from warpdrape.defects.gaps import ToolGaps
from warpdrape.defects.outline import outline_draw_in
from warpdrape.defects.spread import spread
from warpdrape.defects.thickness import (
    fibre_volume_fractions,
    formed_area_ratios,
    thicknesses,
)
from warpdrape.defects.wrinkles import Wrinkle, WrinkleSearch, Wrinkling
from warpdrape.defects.yarn_limits import shear_past_locking, yarn_strains
from warpdrape.results.result import FormedPly
from warpdrape.results.tool_defects import between_tools, coverages
from warpdrape.setup import Setup
from warpdrape.tools.pose import Pose


class DefectWatch:
    """Looks for defects of the plies of a scene.

    Args:
        scene: what is computed.
    """

    def __init__(self, scene: Setup) -> None:
        self._scene = scene
        self._gaps = ToolGaps(scene.tools)
        self._poses: Sequence[Pose] | None = None

    @cached_property
    def _searches(self) -> list[WrinkleSearch]:
        """Of each ply; one of plies that are alike, as its filters take a while."""
        kinds = [(ply.mesh, ply.fabric.thickness) for ply in self._scene.plies]
        found = {kind: WrinkleSearch(*kind, self._scene.defects) for kind in kinds}
        return [found[kind] for kind in kinds]

    def _ways(self, points: np.ndarray, poses: Sequence[Pose]) -> list[np.ndarray]:
        return list(self._gaps.ways(points, poses))

    def look(self, plies: Sequence[FormedPly], poses: Sequence[Pose]) -> tuple[FormedPly, ...]:
        """Return formed plies with thickness, fibre volume fraction and wrinkles.

        Args:
            plies: as they are.
            poses: where the tools are.
        """
        wrinklings = [
            search.look(formed.points, partial(self._ways, formed.points, poses))
            for formed, search in zip(plies, self._searches, strict=True)
        ]
        self._poses = list(poses)
        found = []
        for ply, formed, wrinkling in zip(self._scene.plies, plies, wrinklings, strict=True):
            pressures = [
                pressure
                for pressure in (formed.contact_pressure, formed.tool_pressure)
                if pressure is not None
            ]
            ratios = formed_area_ratios(
                ply.fabric,
                np.asarray(ply.mesh.areas),
                formed.points,
                formed.triangles,
                formed.strain,
                formed.shear_angle,
            )
            thickness = thicknesses(ply.fabric, pressures, formed.triangles, ratios)
            found.append(
                replace(
                    formed,
                    thickness=thickness,
                    fibre_volume_fraction=fibre_volume_fractions(ply.fabric, ratios, thickness),
                    wrinkle=wrinkling.amplitude[formed.triangles].mean(axis=1),
                    wrinkling=wrinkling,
                )
            )
        return tuple(found)

    def add_at_end(self, summary: dict[str, Any], plies: Sequence[FormedPly]) -> None:
        """Add to a summary what plies and tools have together at the end.

        Args:
            summary: as in ``summary.json``.
            plies: the last good frame, the last that was looked at.
        """
        poses = self._poses
        if poses is None or not self._scene.tools:
            return
        found = between_tools(self._scene, plies, self._gaps, poses)
        for entry, own in zip(summary["plies"], found, strict=True):
            entry["defects"].update(own)
        shares = coverages(self._scene, plies, poses)
        for entry, share in zip(summary["tools"], shares, strict=True):
            entry["coverage"] = share


def defect_columns(formed: FormedPly) -> dict[str, float]:
    """Entries of a row of the history: largest amplitudes of wrinkles [m]."""
    if formed.wrinkling is None:
        return {}
    return {
        f"{formed.name}_wrinkle_m": formed.wrinkling.largest(resolved=True),
        f"{formed.name}_short_wrinkle_m": formed.wrinkling.largest(resolved=False),
    }


def defect_entries(
    scene: Setup, number: int, formed: FormedPly, history: Mapping[str, np.ndarray]
) -> dict[str, Any]:
    """Entries of ``summary.json`` for a ply: thickness, fibre volume fraction, defects.

    Args:
        scene: what was computed.
        number: of the ply.
        formed: as it is at the end.
        history: columns over the frames.
    """
    if formed.wrinkling is None or formed.thickness is None:
        return {}
    ply = scene.plies[number]
    areas = np.asarray(ply.mesh.areas)
    yarns = yarn_strains(ply.fabric, formed.strain, areas, scene.defects.yarn_compression)
    entries: dict[str, Any] = {"thickness_m": spread(formed.thickness, areas)}
    if formed.fibre_volume_fraction is not None:
        entries["fibre_volume_fraction"] = spread(formed.fibre_volume_fraction, areas)
    entries["defects"] = {
        "wrinkles": _wrinkle_entries(scene, formed, formed.wrinkling, history),
        "shear": shear_past_locking(ply.fabric, formed.shear_angle, areas)
        | _place(formed, np.abs(formed.shear_angle)),
        "yarns": {
            family: own | _place(formed, formed.strain[:, number_of_family])
            for number_of_family, (family, own) in enumerate(yarns.items())
        },
        "draw_in": outline_draw_in(ply.mesh, formed.points),
        "misalignment": _misalignment(scene, formed, areas),
    }
    return entries


def _misalignment(scene: Setup, formed: FormedPly, areas: np.ndarray) -> list[dict[str, Any]]:
    """Entries of the directions that are wanted of a ply."""
    middles = formed.rest_points[formed.triangles].mean(axis=1)
    entries = []
    for wanted in scene.wanted:
        if wanted.ply == formed.name:
            yarns = getattr(formed, wanted.family)
            angles = misalignments(yarns, formed.points, formed.triangles, wanted.direction)
            entries.append(misalignment_entry(wanted, angles, areas, wanted.region(middles)))
    return entries


def _place(formed: FormedPly, values: np.ndarray) -> dict[str, Any]:
    """Where values on triangles are largest, on the formed ply and the flat blank [m]."""
    corners = formed.triangles[int(np.argmax(values))]
    return {
        "max_at_m": formed.points[corners].mean(axis=0).tolist(),
        "max_on_blank_m": formed.rest_points[corners, :2].mean(axis=0).tolist(),
    }


def _wrinkle_entries(
    scene: Setup, formed: FormedPly, wrinkling: Wrinkling, history: Mapping[str, np.ndarray]
) -> dict[str, Any]:
    numbers = {}
    for resolved, share in zip((True, False), wrinkling.area_share, strict=True):
        those = wrinkling.those(resolved=resolved)
        numbers[resolved] = {
            "number": len(those),
            "max_amplitude_m": wrinkling.largest(resolved=resolved),
            "area_share": share,
            "excess_length_m": math.fsum(wrinkle.excess for wrinkle in those),
            "first": first_wrinkle(scene, formed.name, history, resolved=resolved),
        }
    return numbers[True] | {
        "too_short_for_the_mesh": numbers[False],
        "list": [_wrinkle_entry(scene, formed, wrinkle) for wrinkle in wrinkling.wrinkles],
    }


def first_wrinkle(
    scene: Setup, ply: str, history: Mapping[str, np.ndarray], *, resolved: bool
) -> dict[str, Any] | None:
    """When a ply first wrinkles, and how far the tools have moved then; None where it never does.

    Args:
        scene: what was computed.
        ply: name of the ply.
        history: columns over the frames.
        resolved: of wrinkles that the mesh resolves, or of the others.
    """
    column = f"{ply}_wrinkle_m" if resolved else f"{ply}_short_wrinkle_m"
    rows = np.flatnonzero(history[column] > 0.0) if column in history else np.zeros(0, dtype=int)
    if not len(rows):
        return None
    row = int(rows[0])
    return {
        "frame": row,
        "time_s": float(history["time_s"][row]),
        "displacement_m": {
            tool.name: float(history[f"{tool.name}_displacement_m"][row]) for tool in scene.tools
        },
    }


def _wrinkle_entry(scene: Setup, formed: FormedPly, wrinkle: Wrinkle) -> dict[str, Any]:
    angles = {}
    crest = _direction(formed, wrinkle)
    at = np.flatnonzero((formed.triangles == wrinkle.vertex).any(axis=1))
    for family in ("warp", "weft"):
        yarn = getattr(formed, family)[at].mean(axis=0)
        cosine = abs(float(crest @ yarn)) / max(float(np.linalg.norm(yarn)), 1e-300)
        angles[f"angle_to_{family}_deg"] = math.degrees(math.acos(min(cosine, 1.0)))
    return {
        "at_m": formed.points[wrinkle.vertex].tolist(),
        "on_blank_m": formed.rest_points[wrinkle.vertex, :2].tolist(),
        "axis_on_blank": list(wrinkle.axis),
        "amplitude_m": wrinkle.amplitude,
        "wavelength_m": wrinkle.wavelength,
        "length_m": wrinkle.length,
        **angles,
        "excess_length_m": wrinkle.excess,
        "closed": wrinkle.closed,
        "resolved": wrinkle.resolved,
        "tool": None if wrinkle.tool < 0 else scene.tools[wrinkle.tool].name,
    }


def _direction(formed: FormedPly, wrinkle: Wrinkle) -> np.ndarray:
    """Unit direction of a wrinkle's crest on the formed ply, shape [3]."""
    at = np.flatnonzero((formed.triangles == wrinkle.vertex).any(axis=1))
    a, b, c = (formed.triangles[at, k] for k in range(3))
    flat = np.stack([(formed.rest_points[v] - formed.rest_points[a])[:, :2] for v in (b, c)], 2)
    now = np.stack([formed.points[v] - formed.points[a] for v in (b, c)], 2)
    along = np.einsum("mij,mjk,k->mi", now, np.linalg.inv(flat), np.array(wrinkle.axis))
    mean = along.mean(axis=0)
    return mean / max(float(np.linalg.norm(mean)), 1e-300)
