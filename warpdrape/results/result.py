"""What a run leaves in memory: the formed plies, the history, the summary."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from warpdrape.approaches import SLIDING_YARNS
from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import yarn_gradients
from warpdrape.contact.pressure import vertex_shapes
from warpdrape.defects.wrinkles import Wrinkling
from warpdrape.dynamics.model import Model
from warpdrape.errors import one_of
from warpdrape.interaction import Measured
from warpdrape.results import show
from warpdrape.results.frame_data import PlyFrame, ToolShape
from warpdrape.setup import Setup
from warpdrape.state import State
from warpdrape.tools.pose import Pose
from warpdrape.tools.tool import Tool
from warpdrape.wording import heading, surface

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pyvista import MultiBlock

FAMILIES = {
    "strain": ("warp_strain", "weft_strain"),
    "line_tension": ("warp_tension", "weft_tension"),
    "curvature": ("warp_curvature", "weft_curvature"),
    "yarn_slide": ("warp_slide", "weft_slide"),
}
"""Arrays of a formed ply that hold both yarn families → those of `PlyFrame` that hold one each.
Whatever else both have, they have under one name."""


@dataclass(frozen=True, eq=False)
class FormedPly:
    """A ply at the end of a run (or its last good frame); per triangle but for the points.

    Attributes:
        name: the ply's name.
        rest_points: the flat blank [m], shape [n, 3].
        points: formed positions [m], shape [n, 3].
        triangles: vertices, shape [m, 3].
        warp: unit warp directions, shape [m, 3].
        weft: unit weft directions, shape [m, 3].
        shear_angle: signed shear angle γ [rad], shape [m].
        strain: warp and weft strain, as the pairs of triangles share them [-], shape [m, 2].
        line_tension: of warp and weft [N per metre of initial width], shape [m, 2]; None of an
            approach without forces.
        curvature: of warp and weft yarns out of the ply's plane at vertices [1/m], positive where
            hollow towards the flat ply's upper side, shape [n, 2]; None without bending.
        slip: how far vertices have slid along the ply from where they lay on the ply above, those
            of the topmost ply on the one below [m], shape [n, 3]; None for a single ply.
        contact_pressure: of plies on the face where they press more [Pa], shape [n]; None where
            none can touch.
        tool_pressure: of the tool that presses most [Pa], shape [n]; None without tools.
        temperature: at vertices [K], shape [n]; None of a ply that keeps its own.
        thickness: [m], shape [m]; None before defects were looked for, as the next three.
        fibre_volume_fraction: [-], shape [m]; None too where the fabric has no ``fibre_density``.
        wrinkle: local amplitude of wrinkles, 0 where there is none [m], shape [m].
        yarn_slide: how much warp and weft yarn has gone through the crossover at a vertex, each
            along its own direction [m], 0 where none cross, shape [n, 2]; None where crossovers
            are pinned.
        wrinkling: the wrinkles, each with its place and size; None of a run that was read back,
            whose summary lists them.
    """

    name: str
    rest_points: np.ndarray
    points: np.ndarray
    triangles: np.ndarray
    warp: np.ndarray
    weft: np.ndarray
    shear_angle: np.ndarray
    strain: np.ndarray
    line_tension: np.ndarray | None
    curvature: np.ndarray | None = None
    slip: np.ndarray | None = None
    contact_pressure: np.ndarray | None = None
    tool_pressure: np.ndarray | None = None
    temperature: np.ndarray | None = None
    thickness: np.ndarray | None = None
    fibre_volume_fraction: np.ndarray | None = None
    wrinkle: np.ndarray | None = None
    yarn_slide: np.ndarray | None = None
    wrinkling: Wrinkling | None = None

    @property
    def shear_angle_deg(self) -> np.ndarray:
        """Signed shear angle [deg], shape [m]."""
        return np.degrees(self.shear_angle)

    @property
    def max_shear_deg(self) -> float:
        """Largest shear angle either way [deg]."""
        return float(np.abs(self.shear_angle_deg).max())

    def __repr__(self) -> str:
        rest = dataclasses.fields(self)[4:]
        arrays = [field.name for field in rest if getattr(self, field.name) is not None]
        return (
            f"{heading(self)}: {surface(self.points, self.triangles)}, shear up to "
            f"{self.max_shear_deg:.1f}°; has {', '.join(arrays)}"
        )

    @classmethod
    def from_frame(
        cls, name: str, rest_points: np.ndarray, triangles: np.ndarray, frame: PlyFrame
    ) -> FormedPly:
        """Make a ply from what the animation shows of it: `frame` turned round.

        Args:
            name: the ply's name.
            rest_points: the flat blank [m], shape [n, 3].
            triangles: vertices, shape [m, 3].
            frame: the moment.
        """
        shown = {field.name: getattr(frame, field.name) for field in dataclasses.fields(frame)}
        own = {name: shown[name] for name in cls.__dataclass_fields__ if name in shown}
        for both, parts in FAMILIES.items():
            found = [shown[part] for part in parts]
            own[both] = None if found[0] is None else np.column_stack(found)
        shear = np.radians(frame.shear_angle_deg)
        return cls(
            name=name, rest_points=rest_points, triangles=triangles, shear_angle=shear, **own
        )

    def frame(self) -> PlyFrame:
        """What the animation shows of it."""
        pulled = (None, None) if self.line_tension is None else self.line_tension.T
        bent = (None, None) if self.curvature is None else self.curvature.T
        slid = (None, None) if self.yarn_slide is None else self.yarn_slide.T
        return PlyFrame(
            self.points,
            self.warp,
            self.weft,
            self.shear_angle_deg,
            self.strain[:, 0],
            self.strain[:, 1],
            pulled[0],
            pulled[1],
            bent[0],
            bent[1],
            self.slip,
            self.contact_pressure,
            self.tool_pressure,
            self.temperature,
            self.thickness,
            self.fibre_volume_fraction,
            self.wrinkle,
            slid[0],
            slid[1],
        )


@dataclass(frozen=True, eq=False)
class PlacedTool:
    """A tool at the same moment.

    Attributes:
        name: the tool's name.
        vertices: positions [m], shape [n, 3].
        triangles: vertices of its facets, shape [m, 3].
    """

    name: str
    vertices: np.ndarray
    triangles: np.ndarray

    def __repr__(self) -> str:
        return f"{heading(self)}: {surface(self.vertices, self.triangles, 'facets')}"


@dataclass(frozen=True, eq=False)
class Result:
    """A finished run; at the end of a notebook's cell it shows a table and a picture.

    Attributes:
        plies: the formed plies in stacking order.
        summary: as in ``summary.json``.
        history: column name → values over the frames, as in ``history.csv``.
        tools: where they are then.
        frame: row of the history at which plies and tools are shown; the last good one by default.
    """

    plies: Sequence[FormedPly]
    summary: Mapping[str, Any]
    history: Mapping[str, np.ndarray]
    tools: Sequence[PlacedTool] = ()
    frame: int = -1

    def __repr__(self) -> str:
        return show.text(self)

    def _repr_html_(self) -> str:
        return show.html(self)

    def plot(self) -> Figure:
        """Draw forces and travel, shear, and energies over time; a matplotlib figure."""
        return show.plot(self)

    def picture(
        self, field: str = "shear", ply: str | None = None, *, tools: bool = False
    ) -> Figure:
        """Draw the formed plies side by side; a matplotlib figure.

        Args:
            field: what to colour by, as for ``warpdrape picture --field``.
            ply: name of the one to draw; all of them if None.
            tools: draw the tools, translucent.
        """
        plies = self.plies if ply is None else [self.ply(ply)]
        return show.picture(self, plies, field, tools=tools)

    def to_pyvista(self) -> MultiBlock:
        """Return plies and tools as a PyVista ``MultiBlock``, every field an array with its unit.

        Raises:
            InputError: if PyVista is not installed.
        """
        from warpdrape.results.pyvista_mesh import blocks

        return blocks(self.plies, self.tools)

    @property
    def time_s(self) -> float:
        """Simulated time of the plies shown [s]."""
        return float(self.history["time_s"][self.frame])

    @property
    def completed(self) -> bool:
        """Whether the run went to its end."""
        return self.summary["status"] == "completed"

    def ply(self, name: str) -> FormedPly:
        """Return the ply of that name."""
        names = [ply.name for ply in self.plies]
        return self.plies[names.index(one_of("ply", name, names))]


def read_plies(model: Model, state: State, measured: Sequence[Measured]) -> tuple[FormedPly, ...]:
    """Copy the plies from the device.

    Args:
        model: the model.
        state: its state.
        measured: what forces and contacts show, from `energy.measure`.
    """
    x = state.plies.x.numpy()
    pressures = _pressures(model, x, measured)
    formed = []
    for number, (ply, span) in enumerate(zip(model.scene.plies, model.spans, strict=True)):
        points = x[span.vertices].copy()
        triangles = np.asarray(ply.mesh.triangles)
        gradients, _ = yarn_gradients(ply.mesh.vertices, triangles, *ply.yarn_directions)
        warp, weft, shear = yarn_state(points, triangles, gradients, ply.fabric.yarn_angle)
        fields: dict[str, Any] = {
            name: array.copy()
            for each in measured
            if each.fields
            for name, array in each.fields[number].items()
        }
        fields |= {name: pressure[span.vertices].copy() for name, pressure in pressures.items()}
        formed.append(
            FormedPly(ply.name, ply.rest_points, points, triangles, warp, weft, shear, **fields)
        )
    return tuple(formed)


def tool_shape(tool: Tool) -> ToolShape:
    """A tool for the animation, where it stands at the start."""
    axis, point = (None, None) if tool.turn is None else (tool.turn.axis, tool.turn.point)
    return ToolShape(tool.name, tool.vertices, tool.triangles, axis, point)


def place_tools(scene: Setup, poses: Sequence[Pose]) -> tuple[PlacedTool, ...]:
    """Tools where they have come to.

    Args:
        scene: the scene.
        poses: theirs.
    """
    return tuple(
        PlacedTool(tool.name, pose.place(tool.vertices), tool.triangles)
        for tool, pose in zip(scene.tools, poses, strict=True)
    )


def _pressures(model: Model, x: np.ndarray, measured: Sequence[Measured]) -> dict[str, np.ndarray]:
    """Largest pressure on any face, or of any tool, at each vertex [Pa], by name."""
    forces: dict[str, np.ndarray] = {}
    for each in measured:
        for name, pressing in each.pressing.items():
            forces[name] = forces[name] + pressing if name in forces else pressing
    if not forces:
        return {}
    corners = [
        np.asarray(ply.mesh.triangles) + span.first_vertex
        for ply, span in zip(model.scene.plies, model.spans, strict=True)
    ]
    _, areas = vertex_shapes(x, np.concatenate(corners))
    return {name: pressing.max(axis=0) / areas for name, pressing in forces.items()}


def shown_at_vertices(scene: Setup, ply: Ply) -> tuple[str, ...]:
    """Names of the quantities of `PlyFrame` at vertices that a ply's frames have in a scene."""
    names: tuple[str, ...] = ()
    if ply.fabric.bends:
        names = ("warp_curvature", "weft_curvature")
    several = len(scene.plies) > 1
    if several:
        names += ("slip",)
    if several or any(map(scene.touches_itself, scene.plies)):
        names += ("contact_pressure",)
    if scene.tools:
        names += ("tool_pressure",)
    if scene.cools(ply):
        names += ("temperature",)
    if scene.approach == SLIDING_YARNS:
        names += ("warp_slide", "weft_slide")
    return names


def shown_of_defects(ply: Ply) -> tuple[str, ...]:
    """Names of the quantities of `PlyFrame` in triangles that a ply's frames have by its fabric."""
    if ply.fabric.fibre_density is None:
        return ("thickness", "wrinkle")
    return ("thickness", "fibre_volume_fraction", "wrinkle")


def yarn_state(
    points: np.ndarray, triangles: np.ndarray, gradients: np.ndarray, yarn_angle: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit yarn directions and shear angle [rad] of a formed ply.

    Args:
        points: formed positions [m], shape [n, 3].
        triangles: vertices, shape [m, 3].
        gradients: of the yarn families, as in `Membrane` [1/m], shape [m, 4].
        yarn_angle: from warp to weft in the flat ply [rad].
    """
    columns = np.ascontiguousarray(points.T)  # sums over rows of three are slow in numpy
    a, b, c = (columns.take(corner, axis=1) for corner in triangles.T)
    ab, ac = b - a, c - a
    d = gradients.T
    k1, k2 = _unit(d[0] * ab + d[1] * ac), _unit(d[2] * ab + d[3] * ac)
    angle = np.arccos(np.clip(_dot(k1, k2), -1.0, 1.0))
    return np.ascontiguousarray(k1.T), np.ascontiguousarray(k2.T), yarn_angle - angle


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.sqrt(_dot(vectors, vectors))
