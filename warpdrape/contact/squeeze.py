"""Where two tools press one ply from both sides closer together than it is thick."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from warpdrape.contact.tool_contact import ToolContact, ToolMemory
from warpdrape.contact.tool_features import FeatureContact, FeatureContactMemory
from warpdrape.interaction import Interaction
from warpdrape.kernels.contact.passages import find_gaps
from warpdrape.state import State

OPPOSED = -0.5
"""Cosine between the tools' normals below which they press against each other [-]."""
FAR = 10.0
"""Distance over a ply's thickness up to which it is looked how far tools are apart [-]."""


@dataclass(frozen=True)
class Squeeze:
    """A vertex between two tools that leave it less room than its ply is thick.

    Attributes:
        vertex: its number in the model.
        tools: numbers of the tools.
        depth: by how much they are too close, beyond what the ply's compaction law holds [m].
        thickness: of the ply [m].
        apart: distance of the tools there, 0 where they do not face each other [m]. Of a triangle
            that a feature presses it may be more than the ply needs: it spans, flat as it is, a
            hollow that the feature reaches into.
    """

    vertex: int
    tools: tuple[int, int]
    depth: float
    thickness: float
    apart: float

    @property
    def share(self) -> float:
        """Depth over thickness [-]."""
        return self.depth / self.thickness


def worst_squeeze(
    interactions: Sequence[Interaction], state: State, rooms: np.ndarray
) -> Squeeze | None:
    """The deepest squeeze of now over the thickness of its ply; None where there is none.

    Args:
        interactions: forces and contacts of the model.
        state: its state.
        rooms: by how much vertices' plies can be compacted [m], shape [vertex].
    """
    both = list(zip(interactions, state.memory, strict=True))
    held = [
        _Held(state, rooms, contact, memory)
        for contact, memory in both
        if isinstance(contact, ToolContact)
    ]
    found = [_between_vertices(tools) for tools in held]
    found += [
        _at_features(tools, contact, memory)
        for tools in held
        for contact, memory in both
        if isinstance(contact, FeatureContact)
    ]
    return max((each for each in found if each), key=lambda each: each.share, default=None)


class _Held:
    """Vertices that tools hold now: which they press, shape [tool, vertex], how deep, which way."""

    def __init__(
        self, state: State, rooms: np.ndarray, contact: ToolContact, memory: ToolMemory
    ) -> None:
        count, x = len(contact.meshes), state.plies.x.numpy()
        planes = memory.planes.numpy().reshape(count, -1)
        self.meshes, self.poses = contact.meshes, state.tools.poses()
        at = np.array([pose.into(x) for pose in self.poses])
        self.depth = np.maximum(planes["level"] - (planes["normal"] * at).sum(axis=2), 0.0)
        turned = [pose.direct(n) for pose, n in zip(self.poses, planes["normal"], strict=True)]
        self.normals = np.array(turned)
        self.pressed = (memory.holds.numpy()["stored"] > 0.0).reshape(count, -1)
        self.thickness = 2.0 * contact.offset.numpy()
        self.rooms = rooms


def _between_vertices(held: _Held) -> Squeeze | None:
    worst, found = 0.0, None
    for one in range(len(held.pressed)):
        for other in range(one):
            at = np.flatnonzero(held.pressed[one] & held.pressed[other])
            if not len(at):
                continue
            against = (held.normals[one, at] * held.normals[other, at]).sum(axis=1) < OPPOSED
            depth = held.depth[one, at] + held.depth[other, at] - held.rooms[at]
            share = np.where(against, depth / held.thickness[at], 0.0)
            k = int(np.argmax(share))
            if share[k] > worst:
                worst = float(share[k])
                thickness, least = float(held.thickness[at[k]]), float(held.rooms[at[k]])
                apart = thickness - least - float(depth[k])
                found = Squeeze(int(at[k]), (other, one), float(depth[k]), thickness, apart)
    return found


def _at_features(
    held: _Held, contact: FeatureContact, memory: FeatureContactMemory
) -> Squeeze | None:
    """Between a feature of a tool and another that presses corners of the triangle it meets."""
    pressing = np.flatnonzero(memory.stored.numpy() > 0.0)
    if not len(pressing):
        return None
    kept, gap = memory.contacts.numpy()[pressing], memory.seen.numpy()["gap"][pressing]
    number = pressing % contact.count
    own = contact.features.tools.numpy()[number]
    vertices, weights = np.stack([kept[corner] for corner in "abc"], axis=1), kept["weights"]
    nearest = vertices[np.arange(len(kept)), weights.argmax(axis=1)]
    worst, found = 0.0, None
    for other in range(len(held.pressed)):
        # The feature's own normal, towards the ply, is the contact's turned round.
        along = np.einsum("ncd,nd->nc", held.normals[other, vertices], kept["normal"])
        against = (along > -OPPOSED) & held.pressed[other, vertices] & (own != other)[:, None]
        there = (weights * np.where(against, held.depth[other, vertices], 0.0)).sum(axis=1)
        depth = np.maximum(-gap, 0.0) + there - held.rooms[nearest]
        share = np.where(against.any(axis=1), depth / held.thickness[nearest], 0.0)
        k = int(np.argmax(share))
        if share[k] > worst:
            worst = float(share[k])
            tools = (min(int(own[k]), other), max(int(own[k]), other))
            thickness = float(held.thickness[nearest[k]])
            point = contact.features.points.numpy()[number[k]]
            apart = _apart(held, (int(own[k]), other), point, -kept["normal"][k], FAR * thickness)
            found = Squeeze(int(nearest[k]), tools, float(depth[k]), thickness, apart)
    return found


def _apart(
    held: _Held, tools: tuple[int, int], point: np.ndarray, outward: np.ndarray, reach: float
) -> float:
    """Distance of a point of one tool from another that faces it [m]; 0 if none within ``reach``.

    Args:
        held: the tools.
        tools: numbers of the one and the other.
        point: in the one tool's frame [m], shape [3].
        outward: unit normal there, as the tool has turned, shape [3].
        reach: how far to look [m].
    """
    one, ground = (held.poses[tool] for tool in tools)
    mesh = held.meshes[tools[1]]
    device = mesh.device
    gap = wp.zeros(1, dtype=wp.float32, device=device)
    seen = ground.into(one.place(point[None])), ground.into_directions(outward[None])
    asked: list[wp.array] = [wp.array(each, dtype=wp.vec3f, device=device) for each in seen]
    same = wp.mat33f(*np.eye(3).ravel())
    inputs = [*asked, mesh.id, same, wp.vec3f(), reach]
    wp.launch(find_gaps, 1, inputs=inputs, outputs=[gap], device=device)
    found = gap.numpy()[0]
    return float(found) if found < np.float32(reach) else 0.0  # as the kernel has it
