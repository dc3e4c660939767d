"""What a run's result depends on, part by part: a run goes on only where none of it has changed."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator, Mapping
from importlib import resources
from typing import Any

import numpy as np

from warpdrape.blanks.ply import Ply
from warpdrape.defects.alignment import WantedDirection
from warpdrape.dynamics.model import Model
from warpdrape.results.digest import digest, is_digest, mesh_digest, surface_digest
from warpdrape.results.run_record import plain, versions
from warpdrape.setup import Clamp, Setup
from warpdrape.tools.floating import Float
from warpdrape.tools.pressure import Pressure
from warpdrape.tools.spring import Spring
from warpdrape.tools.tool import Tool

COMPUTES = ("warpdrape", "warp-lang", "numpy")
"""Packages whose version counts."""
WORDS = ("sources", "description", "doubts")
"""Fields of a fabric that say where it comes from, and compute nothing."""
MOTIONS = "motion of "
"""How parts begin that an extension may change; it must begin where the run has come to."""
DAMPING = "numerics: damping"
"""A ply may come to rest in an extension."""
MOMENTS = 129
"""Times at which a clamp's functions are compared."""


def fingerprint(model: Model, threads: int) -> dict[str, Any]:
    """The parts by name: what JSON takes, digests in the place of what is long.

    Args:
        model: the model.
        threads: of the run.
    """
    scene, numerics = model.scene, dataclasses.asdict(model.scene.numerics)
    found = versions()
    parts = {
        **{f"version of {name}": found[name] for name in COMPUTES},
        "kernels": _kernels(),
        "device": model.device,
        "threads": threads,
        "scene": scene.name,
        "approach": scene.approach,
        "duration": scene.duration,
        "frames": model.timing.frames,
        "friction": _without_words(plain(scene.friction)),
        "ply_friction": _without_words(plain(scene.ply_friction)),
        "process_duration over duration": process_pace(scene),
        "air": None if scene.air is None else dataclasses.asdict(scene.air),
        "self_contact": scene.self_contact,
        "gravity": [float(g) for g in scene.gravity],
        "plies": [ply.name for ply in scene.plies],
        "tools": [tool.name for tool in scene.tools],
        "clamps": [clamp.name for clamp in scene.clamps],
        "pressures": [pressure.name for pressure in scene.pressures],
        "springs": [spring.name for spring in scene.springs],
        **{f"numerics: {name}": value for name, value in numerics.items()},
        **{f"defects: {name}": v for name, v in dataclasses.asdict(scene.defects).items()},
    }
    for ply in scene.plies:
        parts.update(_ply(ply))
    for tool in scene.tools:
        parts.update(_tool(scene, tool))
    for clamp in scene.clamps:
        parts.update(_clamp(scene, clamp))
    for wanted in scene.wanted:
        parts.update(_wanted(scene, wanted))
    for pressure in scene.pressures:
        parts.update(_pressure(scene, pressure))
    for spring in scene.springs:
        parts.update(_spring(scene, spring))
    return json.loads(json.dumps(parts))


def differences(
    ours: Mapping[str, Any], theirs: Mapping[str, Any], *, extending: bool
) -> list[str]:
    """In words, where two fingerprints differ.

    Args:
        ours: of the scene at hand.
        theirs: of the run that is to go on.
        extending: whether duration, frames and motions may.
    """
    return list(_differences(ours, theirs, extending))


def _differences(
    ours: Mapping[str, Any], theirs: Mapping[str, Any], extending: bool
) -> Iterator[str]:
    for name in [*ours, *(name for name in theirs if name not in ours)]:
        mine, other = ours.get(name), theirs.get(name)
        if mine == other:
            continue
        changes = name in ("duration", "frames", DAMPING) or name.startswith(MOTIONS)
        if extending and changes:
            continue
        if is_digest(mine) or is_digest(other) or name.startswith(MOTIONS):
            yield f"{name} is another"
        else:
            yield f"{name} = {mine!r}, the run's {other!r}"


def _kernels() -> str:
    """Of the sources of all kernels."""
    return digest(*_sources(resources.files("warpdrape.kernels")))


def _sources(folder: Any) -> Iterator[str]:
    for entry in sorted(folder.iterdir(), key=lambda e: e.name):
        if entry.is_dir():
            yield from _sources(entry)
        elif entry.name.endswith(".py"):
            yield entry.name
            yield entry.read_text(encoding="utf-8")


def _ply(ply: Ply) -> dict[str, Any]:
    fabric = ply.fabric
    laws = {
        f"{field.name} of the fabric of ply {ply.name!r}": digest(getattr(fabric, field.name))
        for field in dataclasses.fields(fabric)
        if field.name not in WORDS
    }
    return {
        f"mesh of ply {ply.name!r}": mesh_digest(ply),
        f"warp_angle of ply {ply.name!r}": float(ply.warp_angle),
        f"z of ply {ply.name!r}": float(ply.z),
        f"temperature of ply {ply.name!r}": ply.warmth,
        **laws,
    }


def _tool(scene: Setup, tool: Tool) -> dict[str, Any]:
    return {
        f"surface of tool {tool.name!r}": surface_digest(tool),
        f"friction of tool {tool.name!r}": _without_words(plain(scene.friction_of(tool))),
        f"temperature of tool {tool.name!r}": tool.temperature,
        **_motion(tool),
        **(
            {} if tool.turn is None else {f"{MOTIONS}tool {tool.name!r}, turning": plain(tool.turn)}
        ),
    }


def _motion(tool: Tool) -> dict[str, Any]:
    """Its motion; of one that floats the force alone may be another in an extension."""
    if not isinstance(tool.motion, Float):
        return {f"{MOTIONS}tool {tool.name!r}": plain(tool.motion)}
    motion = plain(tool.motion)
    force = {name: motion.pop(name) for name in ("force", "ramp")}
    return {f"{MOTIONS}tool {tool.name!r}": force, f"floating of tool {tool.name!r}": motion}


def _without_words(friction: Any) -> Any:
    """A friction, or several, without where the numbers are from."""
    if isinstance(friction, Mapping):
        return {k: _without_words(v) for k, v in friction.items() if k != "source"}
    return friction


def process_pace(scene: Setup) -> float | None:
    """Time of the process over that of the simulation, but for rounding [-]."""
    if scene.process_duration is None:
        return None
    return float(f"{scene.process_duration / scene.duration:.10g}")


def _wanted(scene: Setup, wanted: WantedDirection) -> dict[str, Any]:
    ply = next(ply for ply in scene.plies if ply.name == wanted.ply)
    region = wanted.region(ply.rest_points[np.asarray(ply.mesh.triangles)].mean(axis=1))
    name = f"wanted direction {wanted.name!r}"
    return {
        f"where {name} counts": digest(wanted.ply, wanted.family, region),
        name: [float(d) for d in wanted.direction],
    }


def _pressure(scene: Setup, pressure: Pressure) -> dict[str, Any]:
    ply = next(ply for ply in scene.plies if ply.name == pressure.ply)
    loaded = pressure.triangles(ply.rest_points, np.asarray(ply.mesh.triangles))
    name = f"pressure {pressure.name!r}"
    return {
        f"where {name} acts": digest(pressure.ply, pressure.side, loaded),
        f"{MOTIONS}{name}": plain([pressure.pressure, pressure.ramp]),
    }


def _spring(scene: Setup, spring: Spring) -> dict[str, Any]:
    ply = next(ply for ply in scene.plies if ply.name == spring.ply)
    name = f"spring {spring.name!r}"
    return {
        f"what {name} pulls at": digest(spring.ply, spring.vertices(ply.rest_points)),
        name: plain(dataclasses.replace(spring, where=())),
    }


def _clamp(scene: Setup, clamp: Clamp) -> dict[str, Any]:
    """A clamp; of its functions what they give at some times."""
    ply = next(ply for ply in scene.plies if ply.name == clamp.ply)
    times = np.linspace(0.0, scene.duration, MOMENTS)
    matrix = None if clamp.matrix is None else np.asarray(clamp.matrix(times), dtype=float)
    travel = None if clamp.travel is None else np.asarray(clamp.travel(times), dtype=float)
    name = f"clamp {clamp.name!r}"
    return {
        f"what {name} holds": digest(
            clamp.ply, clamp.vertices(ply.rest_points), clamp.slope, clamp.yarns
        ),
        f"follow of {name}": [float(f) for f in clamp.follow],
        f"{MOTIONS}{name}": [plain(clamp.motion), digest(matrix), digest(travel)],
    }
