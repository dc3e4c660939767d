"""The plies as their contacts with each other, and with themselves, search them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
import warp as wp

from warpdrape.contact.compaction import Pads
from warpdrape.contact.friction import rubs
from warpdrape.contact.ply_surfaces import PlySurfaces
from warpdrape.interaction import Span
from warpdrape.kernels.contact.ply_contact import PlyStack
from warpdrape.materials.friction import Friction
from warpdrape.setup import Setup

NONE = Friction(coefficient=0.0)
"""Between a ply that does not touch itself and itself."""


def ply_stack(
    scene: Setup, surfaces: PlySurfaces, spans: Sequence[Span], pads: Pads, device: str
) -> PlyStack:
    """Put the plies on a device, from the lowest to the highest.

    Args:
        scene: what is computed.
        surfaces: the plies' surfaces.
        spans: where plies are.
        pads: what gives way in contacts.
        device: Warp device.
    """
    stack = PlyStack()
    meshes = [mesh.id for mesh in surfaces.meshes]
    stack.meshes = wp.array(meshes, dtype=wp.uint64, device=device)
    first = [span.first_triangle for span in spans]
    stack.first_triangle = wp.array(first, dtype=wp.int32, device=device)
    half = [0.5 * ply.fabric.thickness for ply in scene.plies]
    stack.half = wp.array(half, dtype=wp.float64, device=device)
    between = [
        NONE
        if one is other and not scene.touches_itself(one)
        else scene.friction_between(one, other)
        for one, other in product(scene.plies, repeat=2)
    ]
    stack.rubs = rubs(scene, between, device)
    stack.pads = wp.array(np.ravel(pads.of_plies), dtype=wp.int32, device=device)
    # Vertices of both plies bear an interface, each with half of its area.
    stack.areas = wp.array(0.5 * pads.areas, dtype=wp.float64, device=device)
    return stack
