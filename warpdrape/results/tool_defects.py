"""What plies and tools have together at the end of a run: bridges, cavities, coverage."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from warpdrape.defects.bridging import Bridge, clearances, find_bridges
from warpdrape.defects.cavity import find_cavities
from warpdrape.defects.coverage import coverage
from warpdrape.defects.crest_lobes import edge_graph
from warpdrape.defects.gaps import SurfaceGaps, ToolGaps
from warpdrape.defects.spread import spread
from warpdrape.defects.thickness import fibre_volume_fractions, formed_area_ratios
from warpdrape.defects.wrinkle_field import vertex_normals
from warpdrape.results.result import FormedPly
from warpdrape.setup import Setup
from warpdrape.tools.floating import Float
from warpdrape.tools.pose import Pose


def between_tools(
    scene: Setup, plies: Sequence[FormedPly], gaps: ToolGaps, poses: Sequence[Pose]
) -> list[dict[str, Any]]:
    """The entries ``bridging`` and ``cavities`` of each ply.

    Args:
        scene: what was computed.
        plies: as they are at the end, from the bottom up.
        gaps: distances from the tools.
        poses: where the tools are.
    """
    found = []
    for number, formed in enumerate(plies):
        ways = gaps.ways(formed.points, poses)
        normals = vertex_normals(formed.points, formed.triangles)
        beneath = gaps.beneath(formed.points, normals, poses)
        bridges = _bridges(scene, number, formed, ways, beneath)
        found.append(
            {
                "bridging": _bridge_entry(scene, formed, bridges),
                "cavities": _cavity_entries(scene, number, formed, ways, normals),
            }
        )
    return found


def _bridge_entry(scene: Setup, formed: FormedPly, bridges: Sequence[Bridge]) -> dict[str, Any]:
    return _numbers([bridge for bridge in bridges if bridge.resolved]) | {
        "too_small_for_the_mesh": _numbers([b for b in bridges if not b.resolved]),
        "list": [
            {
                "tool": scene.tools[bridge.tool].name,
                "at_m": formed.points[bridge.vertex].tolist(),
                "on_blank_m": formed.rest_points[bridge.vertex, :2].tolist(),
                "gap_m": bridge.gap,
                "area_m2": bridge.area,
                "resolved": bridge.resolved,
            }
            for bridge in bridges
        ],
    }


def _cavity_entries(
    scene: Setup, number: int, formed: FormedPly, ways: np.ndarray, normals: np.ndarray
) -> list[dict[str, Any]]:
    """What the room between two tools makes of a ply, for each pair of tools that close on it."""
    ply, stack = scene.plies[number], sum(each.fabric.thickness for each in scene.plies)
    areas, share = np.asarray(ply.mesh.areas), ply.fabric.thickness / stack
    ratios = formed_area_ratios(
        ply.fabric, areas, formed.points, formed.triangles, formed.strain, formed.shear_angle
    )
    entries = []
    widest = scene.defects.cavity_room * stack
    for cavity in find_cavities(ways, normals, formed.triangles, widest):
        own, thickness = areas[cavity.inside], share * cavity.room
        volume = fibre_volume_fractions(ply.fabric, ratios[cavity.inside], thickness)
        pair = [scene.tools[cavity.below], scene.tools[cavity.above]]
        entries.append(
            {
                "tools": [tool.name for tool in pair],
                "under_force": any(isinstance(tool.motion, Float) for tool in pair),
                "area_share": float(own.sum() / areas.sum()),
                "room_m": spread(cavity.room, own),
                "thickness_m": spread(thickness, own),
                "fibre_volume_fraction": None if volume is None else spread(volume, own),
            }
        )
    return entries


def _numbers(bridges: Sequence[Bridge]) -> dict[str, Any]:
    return {
        "number": len(bridges),
        "max_gap_m": max((bridge.gap for bridge in bridges), default=0.0),
        "area_m2": float(sum(bridge.area for bridge in bridges)),
    }


def _bridges(
    scene: Setup, number: int, formed: FormedPly, ways: np.ndarray, beneath: np.ndarray
) -> tuple[Bridge, ...]:
    """Bridges of one ply of the stack, by its number."""
    mesh, points, triangles = scene.plies[number].mesh, formed.points, formed.triangles
    thick = np.array([ply.fabric.thickness for ply in scene.plies])
    below = float(thick[:number].sum() + 0.5 * thick[number])
    above = float(thick[number + 1 :].sum() + 0.5 * thick[number])
    off = clearances(ways, points, triangles, below, above)
    outline, least = np.asarray(mesh.boundary_vertices), scene.defects.bridge_gap * thick[number]
    return find_bridges(edge_graph(mesh), outline, points, triangles, off, beneath, least)


def coverages(scene: Setup, plies: Sequence[FormedPly], poses: Sequence[Pose]) -> list[float]:
    """Share of each tool's surface that has a ply on it [-]; arguments as above."""
    surfaces = [
        SurfaceGaps(
            ply.points, ply.triangles, vertex_normals(ply.points, ply.triangles)[ply.triangles]
        )
        for ply in plies
    ]
    thickest = max(ply.fabric.thickness for ply in scene.plies)
    reach = (0.5 + scene.defects.bridge_gap) * thickest
    return [
        coverage(tool, pose, surfaces, reach) for tool, pose in zip(scene.tools, poses, strict=True)
    ]
