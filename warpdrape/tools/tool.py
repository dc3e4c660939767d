"""Rigid tools: their surfaces, how they move, how they rub."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Unpack

import numpy as np
import trimesh

from warpdrape.errors import InputError, finite, said
from warpdrape.materials.friction import Friction, friction_of
from warpdrape.materials.viscosity import check_temperature
from warpdrape.tools import basic_shapes
from warpdrape.tools.floating import Motion
from warpdrape.tools.motion import Prescribed, Still, vector
from warpdrape.tools.pose import Pose, rotation, shifted
from warpdrape.tools.profile import Surface
from warpdrape.tools.tool_mesh import read_surface
from warpdrape.tools.tool_options import ToolOptions
from warpdrape.tools.turn import Turn
from warpdrape.wording import heading, surface


@dataclass(frozen=True, kw_only=True, eq=False)
class Tool:
    """A rigid surface that meets the plies.

    Attributes:
        name: how results call it.
        surface: facets and normals, where the tool stands at the start [m].
        motion: still, along a stroke or path, or floating under a force.
        friction: Coulomb coefficient against the plies [-], or a `Friction`; None takes the
            scene's.
        turn: how it turns besides, None if it does not.
        temperature: that it keeps [K]; None for one that passes no heat.
    """

    name: str
    surface: Surface
    motion: Motion = field(default_factory=Still)
    friction: float | Friction | None = None
    turn: Turn | None = None
    temperature: float | None = None

    def __repr__(self) -> str:
        rubs = "the scene's" if self.friction is None else f"{self.friction:g}"
        shape = surface(self.vertices, self.triangles, "facets")
        turns = "" if self.turn is None else f"{self.turn!r}; "
        return f"{heading(self)}: {shape}; {self.motion!r}; {turns}friction {rubs}"

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.isidentifier():
            raise InputError(
                f"tool name = {said(self.name)} must be a plain identifier, such as 'punch'"
            )
        if not isinstance(self.motion, Motion):
            raise InputError(f"tool {self.name!r}: motion = {said(self.motion)} is not a motion")
        if not isinstance(self.turn, Turn | None):
            raise InputError(
                f"tool {self.name!r}: turn = {said(self.turn)} is not a warpdrape.Turn"
            )
        if self.friction is not None:
            friction_of(f"tool {self.name!r}: friction", self.friction)
        if self.temperature is not None:
            check_temperature(f"tool {self.name!r}: temperature", self.temperature)
        mesh = self.surface.mesh
        if len(mesh.faces) == 0:
            raise InputError(f"tool {self.name!r}: its mesh has no facets: give it a surface")
        if not np.isfinite(mesh.vertices).all():
            raise InputError(
                f"tool {self.name!r}: its mesh holds NaN or infinite vertices: repair it"
            )

    @property
    def vertices(self) -> np.ndarray:
        """Vertices at the start [m], shape [n, 3]."""
        return np.asarray(self.surface.mesh.vertices)

    @property
    def triangles(self) -> np.ndarray:
        """Facets, shape [m, 3]."""
        return np.asarray(self.surface.mesh.faces)

    @property
    def peak_speed(self) -> float:
        """Largest speed that a point of it reaches [m/s]; what it floats at is not counted."""
        if self.turn is None:
            return self.motion.peak_speed
        return self.motion.peak_speed + self.turn.peak_rate * self.turn.reach(self.vertices)

    @property
    def turning_points(self) -> tuple[float, ...]:
        """Times at which its motion, or its turn, begins, ends or goes back [s]."""
        led = self.motion.turns if isinstance(self.motion, Prescribed) else ()
        return (*led, *(() if self.turn is None else self.turn.turns))

    def pose(self, time: float) -> Pose:
        """Where it is at a time [s]; of one that floats, as it has turned where it started."""
        way = np.zeros(3)
        if isinstance(self.motion, Prescribed):
            way = self.motion.displacement(np.asarray(time, dtype=float))
        if self.turn is None:
            return shifted(way)
        turned = rotation(self.turn.axis, float(self.turn.at(np.asarray(time, dtype=float))))
        return Pose(turned, way + (self.turn.point - turned @ self.turn.point))

    def moved(self, offset: Sequence[float]) -> Tool:
        """Return the tool standing elsewhere, the axis about which it turns with it.

        Args:
            offset: translation [m], shape [3].
        """
        way = vector("offset", offset)
        turn = None if self.turn is None else self.turn.moved(way)
        return replace(self, surface=self.surface.moved(way), turn=turn)

    def turned(self, axis: Sequence[float], angle: float) -> Tool:
        """Return the tool turned about the origin, the axis about which it turns with it.

        Args:
            axis: direction of the axis, shape [3].
            angle: angle [rad].
        """
        matrix = _rotation(axis, angle)
        turn = None if self.turn is None else self.turn.turned(matrix)
        return replace(self, surface=self.surface.turned(matrix), turn=turn)

    def flipped(self) -> Tool:
        """Return the tool with its facets facing the other way."""
        return replace(self, surface=self.surface.flipped())

    @classmethod
    def from_mesh(
        cls,
        name: str,
        source: str | os.PathLike | trimesh.Trimesh,
        *,
        scale: float = 1.0,
        tolerance: float | None = None,
        **options: Unpack[ToolOptions],
    ) -> Tool:
        """Make a tool from a mesh or CAD file or a trimesh; its facets' outside meets the plies.

        Facets that differ in sense from their neighbours are turned, with a warning, and those of
        closed solids outward. An open surface that faces away from the plies as a whole is refused
        when the run starts; see `flipped`.

        STEP and IGES files state their unit and need no scale; their facets are made here, with the
        true surfaces' normals.

        Args:
            name: how results call it.
            source: file that trimesh reads, a STEP or IGES file, or a mesh.
            scale: metres per unit of a mesh file (1e-3 for millimetres).
            tolerance: largest distance of a CAD file's facets from its surfaces [m]; None takes a
                two thousandth of its size.
            options: motion, turn, friction, temperature.

        Raises:
            InputError: if the file is missing, unreadable, empty or holds NaN.
        """
        return cls(name=name, surface=read_surface(name, source, scale, tolerance), **options)

    @classmethod
    def punch(
        cls,
        name: str = "punch",
        *,
        radius: float,
        height: float | None = None,
        facet: float = 5e-3,
        **options: Unpack[ToolOptions],
    ) -> Tool:
        """Hemisphere on a cylinder, pole at the origin, pointing down.

        Args:
            name: how results call it.
            radius: of the hemisphere and the cylinder [m].
            height: from pole to top [m]; 1.5 radii if None.
            facet: facet size [m].
            options: motion, turn, friction, temperature.
        """
        surface = basic_shapes.punch(radius, height, facet)
        return cls(name=name, surface=surface, **options)

    @classmethod
    def die(
        cls,
        name: str = "die",
        *,
        hole_radius: float,
        edge_radius: float,
        outer_radius: float,
        depth: float = 0.03,
        facet: float = 5e-3,
        **options: Unpack[ToolOptions],
    ) -> Tool:
        """Flat ring facing up at z = 0, its hole's edge rounded.

        Args:
            name: how results call it.
            hole_radius: of the hole [m].
            edge_radius: of the rounding between flat and hole [m].
            outer_radius: of the ring [m].
            depth: of the hole's wall below the flat [m].
            facet: facet size [m].
            options: motion, turn, friction, temperature.
        """
        surface = basic_shapes.die(hole_radius, edge_radius, outer_radius, depth, facet)
        return cls(name=name, surface=surface, **options)

    @classmethod
    def blank_holder(
        cls,
        name: str = "holder",
        *,
        hole_radius: float,
        outer_radius: float,
        edge_radius: float = 2e-3,
        facet: float = 5e-3,
        sector: tuple[float, float] | None = None,
        **options: Unpack[ToolOptions],
    ) -> Tool:
        """Flat ring facing down at z = 0, its hole's edge rounded; or a sector of one.

        Several sectors, each with a force of its own, make a segmented blank holder.

        Args:
            name: how results call it.
            hole_radius: of the hole [m].
            outer_radius: of the ring [m].
            edge_radius: of the rounding between flat and hole [m].
            facet: facet size [m].
            sector: angles from and to which it goes, counter-clockwise from x [rad]; None all
                round.
            options: motion, turn, friction, temperature.
        """
        surface = basic_shapes.blank_holder(hole_radius, edge_radius, outer_radius, facet, sector)
        return cls(name=name, surface=surface, **options)

    @classmethod
    def table(
        cls,
        name: str = "table",
        *,
        radius: float,
        edge_radius: float = 5e-3,
        depth: float = 0.05,
        facet: float = 5e-3,
        **options: Unpack[ToolOptions],
    ) -> Tool:
        """Round table facing up at z = 0, its rim rounded.

        Args:
            name: how results call it.
            radius: of the table [m].
            edge_radius: of the rounding of its rim [m].
            depth: of its side below the top [m].
            facet: facet size [m].
            options: motion, turn, friction, temperature.
        """
        surface = basic_shapes.table(radius, edge_radius, depth, facet)
        return cls(name=name, surface=surface, **options)

    @classmethod
    def sphere(
        cls,
        name: str = "sphere",
        *,
        radius: float,
        facet: float = 5e-3,
        **options: Unpack[ToolOptions],
    ) -> Tool:
        """Upper three quarters of a sphere, its pole at the origin, pointing up."""
        return cls(name=name, surface=basic_shapes.sphere(radius, facet), **options)

    @classmethod
    def plate(
        cls,
        name: str = "plate",
        *,
        width: float,
        height: float,
        facing: str = "up",
        facet: float = 0.05,
        **options: Unpack[ToolOptions],
    ) -> Tool:
        """Flat plate at z = 0, centred at the origin.

        Args:
            name: how results call it.
            width: along x [m].
            height: along y [m].
            facing: "up" or "down".
            facet: facet size [m].
            options: motion, turn, friction, temperature.
        """
        surface = basic_shapes.plate(width, height, facing, facet)
        return cls(name=name, surface=surface, **options)

    @classmethod
    def drum(
        cls,
        name: str = "drum",
        *,
        radius: float,
        length: float,
        facet: float = 5e-3,
        **options: Unpack[ToolOptions],
    ) -> Tool:
        """Cylinder about the y axis, centred at the origin.

        Args:
            name: how results call it.
            radius: of the cylinder [m].
            length: along y [m].
            facet: facet size [m].
            options: motion, turn, friction, temperature.
        """
        return cls(name=name, surface=basic_shapes.drum(radius, length, facet), **options)


def _rotation(axis: Sequence[float], angle: float) -> np.ndarray:
    """Matrix of a rotation by an angle [rad] about the direction of an axis, shape [3, 3]."""
    direction, angle = vector("axis", axis), finite("angle", angle, unit="rad")
    largest = np.abs(direction).max()
    if largest == 0.0:
        raise InputError("axis must not be the zero vector")
    return trimesh.transformations.rotation_matrix(angle, direction / largest)[:3, :3]
