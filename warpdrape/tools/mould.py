"""A mould from a file, where its file has it, and the tools that follow from it."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Unpack

import numpy as np

from warpdrape.cad_file import is_cad
from warpdrape.errors import InputError, one_of, positive
from warpdrape.errors import length as size
from warpdrape.materials.friction import Friction
from warpdrape.mesh_file import UNITS
from warpdrape.tools.counterpart import counterpart
from warpdrape.tools.floating import Float
from warpdrape.tools.holder_ring import holder_ring
from warpdrape.tools.mould_face import Face, face_of
from warpdrape.tools.tool import Tool
from warpdrape.tools.tool_mesh import cad_surface
from warpdrape.tools.tool_options import ToolOptions

KINDS = ("female", "male")
UPWARD = {
    "z": ((1, 0, 0), 0.0),
    "-z": ((1, 0, 0), np.pi),
    "x": ((0, 1, 0), -0.5 * np.pi),
    "-x": ((0, 1, 0), 0.5 * np.pi),
    "y": ((1, 0, 0), 0.5 * np.pi),
    "-y": ((1, 0, 0), -0.5 * np.pi),
}
"""Directions of a file that may be up: axis and angle that turn each to z [rad]."""
SLOW, ALONG = 5.0, 20.0
"""Speeds at which a holder's dashpot bears its force, and that of one which goes along [m/s]."""
FORCE_RISES = 2e-3
"""Time in which a holder's force rises [s]."""
PLAUSIBLE = (5e-3, 20.0)
"""Sizes between which a mould is believed to be [m]."""


@dataclass(frozen=True, eq=False)
class Mould:
    """A rigid mould that stands still, facing up, and on which plies are laid.

    Its face is what is seen from above. The other tools follow from it: a counterpart that closes
    on it, and a blank holder where a flat rim goes round its shape. Make one with `of` or
    `from_file`.

    Attributes:
        tool: the face as a tool, where the file has it.
        kind: "female", a cavity into which the plies go, or "male", a hump over which they go.
        unit: of the file, as it is stated in it or was given; "" for one that is no file.
        face: the face, and which of it is its rim.
    """

    tool: Tool
    kind: str
    unit: str
    face: Face

    def __repr__(self) -> str:
        rim = f"rim at z {1e3 * self.face.level:.4g} mm" if self.has_rim else "no flat rim"
        return f"Mould, {self.kind}, {rim}: {self.tool!r}"

    @classmethod
    def of(cls, tool: Tool, *, kind: str | None = None, up: str = "z", unit: str = "") -> Mould:
        """Make a mould of a tool.

        Args:
            tool: a body or a surface; what it shows from above becomes the mould's face.
            kind: "female" or "male"; None takes which of them it looks like.
            up: the direction of it that is to be up: "z", "-z", "x", …
            unit: in which it came, for the record.

        Raises:
            InputError: if nothing of it faces up.
        """
        axis, angle = UPWARD[one_of("up", up, UPWARD)]
        turned = tool.turned(axis, angle) if angle else tool
        face = face_of(f"mould {tool.name!r}", turned.surface)
        if kind is None:
            kind = "female" if face.hollow else "male"
        kind = one_of("kind of mould", kind, KINDS)
        return cls(replace(turned, surface=face.surface), kind, unit, face)

    @classmethod
    def from_file(
        cls,
        path: str | os.PathLike[str],
        *,
        units: str | None = None,
        tolerance: float | None = None,
        kind: str | None = None,
        up: str = "z",
        name: str = "mould",
        friction: float | Friction | None = None,
    ) -> Mould:
        """Read a mould from a file.

        Args:
            path: STEP or IGES, which state their unit; or STL, OBJ, PLY, OFF, GLB, which do not.
            units: of a mesh file: "mm", "cm", "m" or "inch".
            tolerance: chord error of a CAD file's facets [m]; a tenth of a ply's thickness is good.
            kind: "female" or "male"; None takes which of them it looks like.
            up: the direction of the file that is to be up: "z", "-z", "x", …
            name: of the tool.
            friction: of the tool; None takes the scene's.

        Raises:
            InputError: if the file cannot be read, states no unit and none is given, or is of a
                size that no mould has.
        """
        tool, unit = _read(path, name, units, tolerance, friction)
        across = float(np.ptp(tool.vertices, axis=0).max())
        if not PLAUSIBLE[0] <= across <= PLAUSIBLE[1]:
            remedy = _other_unit(path, across / UNITS[unit]) if units else "its file is wrong there"
            raise InputError(
                f"mould {os.fspath(path)!r} is {across:.4g} m across with its numbers in {unit}, "
                f"not {PLAUSIBLE[0]:g} to {PLAUSIBLE[1]:g} m: {remedy}"
            )
        return cls.of(tool, kind=kind, up=up, unit=unit)

    @property
    def has_rim(self) -> bool:
        """Whether a flat rim goes round its shape."""
        return bool(self.face.rim.any())

    @cached_property
    def level(self) -> float:
        """Height at which plies are laid, that of its highest point [m]."""
        return float(self.tool.vertices[:, 2].max())

    @property
    def middle(self) -> tuple[float, float]:
        """Of its shape as seen from above [m]."""
        low, high = np.reshape(self.face.outline.bounds, (2, 2))
        x, y = 0.5 * (low + high)
        return float(x), float(y)

    def counterpart(self, name: str, *, gap: float, **options: Unpack[ToolOptions]) -> Tool:
        """Make the tool that closes on it, where it stands at the end.

        In a female mould it ends where the flat rim begins, which is the holder's; over a male one
        it covers the rim too. What a rounding of the mould narrower than the gap would turn inside
        out is left open.

        Args:
            name: such as "punch".
            gap: between the two [m]: the plies' thickness and more.
            options: motion, turn, friction, temperature.
        """
        size("gap", gap)
        female = self.kind == "female" and self.has_rim
        chosen = ~self.face.rim if female else np.ones(len(self.face.rim), dtype=bool)
        who = f"tool {name!r}"
        return Tool(name=name, surface=counterpart(who, self.face.surface, chosen, gap), **options)

    def holder(
        self, name: str = "holder", *, thickness: float, force: float, clearance: float = 1e-3
    ) -> Tool:
        """Make a floating blank holder that presses the plies round its shape.

        On a female mould it lies on the plies and presses them down onto the rim; round a male one
        it lies under them and presses them up against the counterpart.

        Args:
            name: of the tool.
            thickness: of the plies together [m].
            force: with which it presses [N].
            clearance: from the mould's shape, as seen from above [m].

        Raises:
            InputError: if the mould has no flat rim, or one too narrow.
        """
        who = f"tool {name!r}"
        positive(f"{who}: force", force, unit="N")
        positive(f"{who}: clearance", clearance, unit="m", zero=True)
        size("thickness", thickness)
        if not self.has_rim:
            raise InputError(
                f"{who}: the mould has no flat rim round its shape to hold the plies on: leave the "
                "holder out, or give the mould a rim"
            )
        male = self.kind == "male"
        room = clearance + (thickness if male else 0.0)
        opening = self.face.outline.buffer(room, quad_segs=16)
        surface = holder_ring(who, opening, self.face.outer, up=male)
        way = (0.0, 0.0, 1.0 if male else -1.0)
        damping = force / (ALONG if male else SLOW)
        press = Float(force=force, axis=way, ramp=FORCE_RISES, damping=damping)
        ring = Tool(name=name, surface=surface, motion=press)
        return ring.moved((0.0, 0.0, self.level + (0.0 if male else thickness)))


def _other_unit(path: str | os.PathLike[str], count: float) -> str:
    """What to give in place of a unit with which a file that states none has no mould's size."""
    fitting = [u for u, metres in UNITS.items() if PLAUSIBLE[0] <= count * metres <= PLAUSIBLE[1]]
    if not fitting:
        return "look what the file holds"
    sizes = (f"{unit!r}, {1e3 * count * UNITS[unit]:.4g} mm" for unit in fitting)
    return f"give another of units: {' or '.join(sizes)}"


def _read(
    path: str | os.PathLike[str],
    name: str,
    units: str | None,
    tolerance: float | None,
    friction: float | Friction | None,
) -> tuple[Tool, str]:
    """The tool in a file, and the file's unit: stated there, or given."""
    if is_cad(path):
        surface, unit = cad_surface(name, path, tolerance=tolerance)
        if units is not None:
            raise InputError(
                f"units = {units!r}, but {os.fspath(path)!r} states its unit, {unit}: leave "
                "units out"
            )
        return Tool(name=name, surface=surface, friction=friction), unit
    if units is None:
        raise InputError(
            f"{os.fspath(path)!r} states no unit: give units, one of {', '.join(UNITS)}"
        )
    unit = one_of("unit", units, UNITS)
    made = Tool.from_mesh(name, path, scale=UNITS[unit], tolerance=tolerance, friction=friction)
    return made, unit
