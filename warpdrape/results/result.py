"""What a run leaves in memory: the formed plies, the history, the summary."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from warpdrape.defects.wrinkles import Wrinkling
from warpdrape.errors import one_of
from warpdrape.results import show
from warpdrape.results.frame_data import PlyFrame
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
        shown: dict[str, Any] = {}
        for both, parts in FAMILIES.items():
            values = getattr(self, both)
            shown |= zip(parts, (None, None) if values is None else values.T, strict=True)
        for field in dataclasses.fields(PlyFrame):
            if field.name not in shown:
                shown[field.name] = getattr(self, field.name)
        return PlyFrame(**shown)


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
