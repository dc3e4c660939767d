"""The record of a run, ``run.json``: what is needed to understand it, and to do it again."""

from __future__ import annotations

import dataclasses
import platform
from collections.abc import Mapping
from typing import Any

import numpy as np

from warpdrape.approaches import PAIRED
from warpdrape.blanks.ply import Ply
from warpdrape.defects.alignment import WantedDirection
from warpdrape.defects.limits import limits_entry
from warpdrape.dynamics.model import Model
from warpdrape.forces.membrane_stiffness import stabiliser_range
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.friction import Friction
from warpdrape.materials.laws import Unwoven
from warpdrape.results.digest import mesh_digest, plain, surface_digest
from warpdrape.setup import Clamp, Setup
from warpdrape.tools.floating import Float
from warpdrape.tools.pressure import Pressure
from warpdrape.tools.spring import Spring
from warpdrape.tools.tool import Tool


def run_record(scene: Setup, model: Model | None, frames: int, threads: int) -> dict[str, Any]:
    """Everything of ``run.json``: what is needed to do it again.

    Args:
        scene: what is computed.
        model: of the dynamics; None of an approach without.
        frames: after the first.
        threads: of the run.
    """
    fabrics, fabric_of = _fabrics(scene)
    return {
        "scene": scene.name,
        "approach": scene.approach,
        "script": scene.script,
        "parameters": {
            name: value.name if isinstance(value, Fabric) else value
            for name, value in scene.parameters.items()
        },
        "call": dict(scene.call),
        "duration_s": scene.duration,
        "frames": frames,
        "friction": plain(scene.friction),
        "ply_friction": _ply_friction(scene),
        "self_contact": scene.self_contact,
        "process_duration_s": scene.process_duration,
        "air": None if scene.air is None else dataclasses.asdict(scene.air),
        "gravity_m_s2": [float(g) for g in scene.gravity],
        "numerics": dataclasses.asdict(scene.numerics),
        "defect_thresholds": dataclasses.asdict(scene.defects),
        "limits": limits_entry(scene.limits),
        "wanted": [_wanted(wanted) for wanted in scene.wanted],
        "time_step_s": None if model is None else model.timing.time_step,
        "search_every": None if model is None else model.timing.search_every,
        "floating_mass_kg": _floating_mass(scene, model),
        "device": "cpu" if model is None else model.device,
        "threads": threads,
        "versions": versions(),
        "plies": [
            _ply(scene, ply, fabric) for ply, fabric in zip(scene.plies, fabric_of, strict=True)
        ],
        "fabrics": fabrics,
        "tools": [_tool(scene, tool) for tool in scene.tools],
        "clamps": [_clamp(scene, clamp) for clamp in scene.clamps],
        "pressures": [_pressure(pressure) for pressure in scene.pressures],
        "springs": [_spring(scene, spring) for spring in scene.springs],
    }


def _wanted(wanted: WantedDirection) -> dict[str, Any]:
    """A direction that is wanted of a ply."""
    return {
        "name": wanted.name,
        "ply": wanted.ply,
        "family": wanted.family,
        "direction": [float(d) for d in wanted.direction],
    }


def _ply(scene: Setup, ply: Ply, fabric: str) -> dict[str, Any]:
    """A ply as it is laid up; its fabric by the name that it has in the record."""
    return {
        "name": ply.name,
        "fabric": fabric,
        "warp_angle_deg": float(np.degrees(ply.warp_angle)),
        "z_m": float(ply.z),
        "temperature_k": ply.warmth,
        "vertices": len(ply.mesh.vertices),
        "triangles": len(ply.mesh.triangles),
        "mesh_digest": mesh_digest(ply),
        "stabiliser_n_m": _stabiliser(scene, ply),
    }


def _tool(scene: Setup, tool: Tool) -> dict[str, Any]:
    """A tool: its surface, how it moves and rubs."""
    return {
        "name": tool.name,
        "facets": len(tool.triangles),
        "surface_digest": surface_digest(tool),
        "friction": _friction(scene.friction_of(tool)),
        "motion": plain(tool.motion),
        "turn": plain(tool.turn),
        "temperature_k": tool.temperature,
    }


def _floating_mass(scene: Setup, model: Model | None) -> dict[str, float] | None:
    """Of floating tools as it acts, which without one of their own is the plies' [kg]."""
    if model is None:
        return None
    masses = zip(scene.tools, model.floating.mass.numpy().tolist(), strict=True)
    return {tool.name: mass for tool, mass in masses if isinstance(tool.motion, Float)}


def _stabiliser(scene: Setup, ply: Ply) -> list[float] | None:
    """Smallest and largest of what holds pairs of triangles together, as it acts [N/m]."""
    paired = scene.approach in PAIRED and scene.numerics.averaging == "pairs"
    if not paired or isinstance(ply.fabric.tension, Unwoven):
        return None
    return list(stabiliser_range(ply, scene.numerics))


def _fabrics(scene: Setup) -> tuple[dict[str, Any], list[str]]:
    """Fabrics by name, and each ply's; a second fabric of the same name gets a number."""
    fabrics: dict[str, Any] = {}
    names = []
    for ply in scene.plies:
        record, name, number = plain(ply.fabric), ply.fabric.name, 1
        while fabrics.setdefault(name, record) != record:
            number += 1
            name = f"{ply.fabric.name} ({number})"
        names.append(name)
    return fabrics, names


def _clamp(scene: Setup, clamp: Clamp) -> dict[str, Any]:
    """A clamp: what it holds, and where that goes.

    Functions of time cannot be written down: the record has what they give at the end.
    """
    ply = next(ply for ply in scene.plies if ply.name == clamp.ply)
    held = ply.rest_points[clamp.vertices(ply.rest_points)]
    end = np.array(scene.duration)
    return {
        "name": clamp.name,
        "ply": clamp.ply,
        "vertices": len(held),
        "between_m": [held.min(axis=0).tolist(), held.max(axis=0).tolist()],
        "motion": plain(clamp.motion),
        "matrix_at_end": None if clamp.matrix is None else plain(clamp.matrix(end[None])[0]),
        "travel_at_end_m": None if clamp.travel is None else float(clamp.travel(end)),
        "follow": plain(np.asarray(clamp.follow, dtype=float)),
        "slope": clamp.slope,
        "yarns": clamp.yarns,
    }


def _pressure(pressure: Pressure) -> dict[str, Any]:
    """A pressure; whether it acts on a part of its ply only."""
    part = pressure.where is not None
    return {**plain(dataclasses.replace(pressure, where=None)), "where": "a part" if part else None}


def _spring(scene: Setup, spring: Spring) -> dict[str, Any]:
    """A spring; of what it pulls at how many vertices, and where."""
    ply = next(ply for ply in scene.plies if ply.name == spring.ply)
    pulled = ply.rest_points[spring.vertices(ply.rest_points)]
    between = [pulled.min(axis=0).tolist(), pulled.max(axis=0).tolist()]
    record = plain(dataclasses.replace(spring, where=()))
    return {**record, "where": {"vertices": len(pulled), "between_m": between}}


def versions() -> dict[str, str]:
    """Versions of what computes."""
    from importlib.metadata import PackageNotFoundError, version

    found = {"python": platform.python_version()}
    for name in ("warpdrape", "warp-lang", "numpy", "scipy", "trimesh", "usd-core", "rustworkx"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:  # a checkout that is only on the path
            found[name] = "not installed"
    return found


def _friction(friction: Friction) -> float | dict[str, Any]:
    """A coefficient, or all of a law."""
    return plain(friction) if friction.varies or friction.source else friction.coefficient


def _ply_friction(scene: Setup) -> Any:
    """One coefficient for all, or that of each pair of fabrics."""
    if not isinstance(scene.ply_friction, Mapping):
        return plain(scene.ply_friction)
    return [
        {"fabrics": list(fabrics), "friction": plain(friction)}
        for fabrics, friction in scene.ply_friction.items()
    ]
