"""Where tools are and which of them turn, for the kernels."""

from __future__ import annotations

import numpy as np
import warp as wp

from warpdrape.kernels.tool_pose import ToolPoses, TurningTools
from warpdrape.setup import Setup
from warpdrape.state import ToolState


def turning_tools(scene: Setup, device: str) -> TurningTools:
    """Which tools turn, and about which axes."""
    turns = [tool.turn for tool in scene.tools]
    turning = TurningTools()
    turning.turns = wp.array([t is not None for t in turns], dtype=wp.int32, device=device)
    axes = [(0.0, 0.0, 1.0) if t is None else t.axis for t in turns]
    turning.axis = wp.array(np.reshape(axes, (-1, 3)), dtype=wp.vec3d, device=device)
    points = [np.zeros(3) if t is None else t.point for t in turns]
    turning.point = wp.array(np.reshape(points, (-1, 3)), dtype=wp.vec3d, device=device)
    return turning


def tool_poses(turning: TurningTools, tools: ToolState) -> ToolPoses:
    """The tools' arrays as the kernels of contact take them."""
    poses = ToolPoses()
    poses.turning = turning
    for name in ("turned", "shift", "velocity", "spin"):
        setattr(poses, name, getattr(tools, name))
    return poses
