"""The record of a run, ``run.json``: what is needed to understand it, and to do it again."""

from __future__ import annotations

import dataclasses
import platform
from collections.abc import Mapping
from typing import Any

import numpy as np

from warpdrape.model import Model
from warpdrape.scene import Scene


def run_record(scene: Scene, model: Model, frames: int, threads: int) -> dict[str, Any]:
    """Everything of ``run.json``: what is needed to do it again."""
    return {
        "scene": scene.name,
        "parameters": dict(scene.parameters),
        "duration_s": scene.duration,
        "frames": frames,
        "friction": scene.friction,
        "ply_friction": scene.ply_friction,
        "gravity_m_s2": [float(g) for g in scene.gravity],
        "numerics": dataclasses.asdict(scene.numerics),
        "time_step_s": model.timing.time_step,
        "search_every": model.timing.search_every,
        "device": model.device,
        "threads": threads,
        "versions": versions(),
        "plies": [
            {
                "name": ply.name,
                "fabric": ply.fabric.name,
                "warp_angle_deg": float(np.degrees(ply.warp_angle)),
                "z_m": float(ply.z),
                "vertices": len(ply.mesh.vertices),
                "triangles": len(ply.mesh.triangles),
            }
            for ply in scene.plies
        ],
        "fabrics": {ply.fabric.name: plain(ply.fabric) for ply in scene.plies},
        "tools": [
            {"name": tool.name, "facets": len(tool.triangles), "motion": plain(tool.motion)}
            for tool in scene.tools
        ],
    }


def plain(value: Any) -> Any:
    """Records as JSON takes them."""
    if dataclasses.is_dataclass(value):
        record = {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
        return {"type": type(value).__name__, **record}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    return value


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
