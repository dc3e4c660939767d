"""Tools that float under a force, on a device."""

from __future__ import annotations

import numpy as np
import warp as wp

from warpdrape.kernels.dynamics.motion import FloatingTools
from warpdrape.setup import Setup
from warpdrape.tools.floating import Float


def floating_tools(scene: Setup, plies: float, device: str) -> FloatingTools:
    """Which tools float, along which axes, with what mass and damping.

    Args:
        scene: what is computed.
        plies: mass of all plies [kg], that of a tool which has none of its own.
        device: Warp device.
    """
    motions = [tool.motion if isinstance(tool.motion, Float) else None for tool in scene.tools]
    floats = [motion is not None for motion in motions]
    floating = FloatingTools()
    floating.floats = wp.array(floats, dtype=wp.int32, device=device)
    axes = [m.axis if m else (0.0, 0.0, 1.0) for m in motions]
    floating.axis = wp.array(np.reshape(axes, (-1, 3)), dtype=wp.vec3d, device=device)
    mass = [plies if m and m.mass is None else m.mass if m else 1.0 for m in motions]
    floating.mass = wp.array(mass, dtype=wp.float64, device=device)
    damping = [m.damping if m else 0.0 for m in motions]
    floating.damping = wp.array(damping, dtype=wp.float64, device=device)
    return floating
