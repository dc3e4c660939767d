"""The double dome with springs at the blank's edges: their stiffness and place are parameters.

Each edge has two grips, alike to both sides of its middle, and each grip pulls straight outwards.
The blank may be turned on the die, with its yarns, and its corners be cut off. The summary tells
the shear of the part apart from that of the flange, which is trimmed away, grips and all.
"""

import math
from dataclasses import replace

import numpy as np

from warpdrape import InputError, Ply, Result, Scene, Spring, lay_up
from warpdrape.scenes.double_dome import build as double_dome

FRAME = 0.1
"""From a grip to the frame that its spring hangs on [m]."""
FLANGE = 0.005
"""Depth below the die's flat down to which it is flange [m]: half the radius of its edge."""


def build(
    *,
    long_stiffness: float = 0.0,
    long_place: float = 0.1,
    short_stiffness: float = 0.0,
    short_place: float = 0.06,
    grip: float = 0.04,
    turn_deg: float = 0.0,
    corner: float = 0.0,
    warp_angle_deg: float = 0.0,
    blank_length: float = 0.4,
    blank_width: float = 0.27,
    cells: int = 24,
    holder_force: float = 100.0,
    friction: float = 0.2,
    fabric: str = "carbon_interlock",
    travel: float = 0.062,
    duration: float = 0.08,
    brake: float = 0.3,
    facet: float = 0.006,
    accuracy: str = "standard",
) -> Scene:
    """Build the double dome with springs.

    Args:
        long_stiffness: of each of four springs at the edges along x, 0 for none [N/m].
        long_place: of their grips' middles, from the middle of the edge [m].
        short_stiffness: of each of four springs at the edges along y, 0 for none [N/m].
        short_place: of their grips' middles, from the middle of the edge [m].
        grip: width of a grip along the edge [m].
        turn_deg: by which the blank is turned on the die, its yarns with it [deg].
        corner: leg of the corners that are cut off, 0 for none [m].
        warp_angle_deg: from the blank's length to the warp [deg].
        blank_length: of the blank along x [m].
        blank_width: of the blank along y [m].
        cells: of the mesh along the blank's length.
        holder_force: on the blank holder [N].
        friction: Coulomb coefficient of tools on the ply [-].
        fabric: name or file of a fabric.
        travel: punch travel [m].
        duration: of the stroke [s].
        brake: share of the stroke in which the punch slows down, below 1 [-].
        facet: size of the tools' facets [m].
        accuracy: "draft", "standard" or "reference": the summary says what it costs.
    """
    parameters = dict(locals())
    half = np.array([0.5 * blank_length, 0.5 * blank_width])
    if not 0.0 <= corner < min(half):
        raise InputError(f"corner = {corner:g} m must lie from 0 to below {min(half):g} m")
    turn = math.radians(turn_deg)
    pressed = double_dome(
        blank_length=blank_length,
        blank_width=blank_width,
        cells=4,  # only its tools are used
        holder_force=holder_force,
        friction=friction,
        fabric=fabric,
        travel=travel,
        duration=duration,
        brake=brake,
        facet=facet,
        accuracy=accuracy,
    )
    ply = Ply.polygon(
        "ply_0",
        fabric,
        _outline(half, corner) @ _turned(turn).T,
        edge=blank_length / cells,
        warp_angle=turn + math.radians(warp_angle_deg),
    )
    flat = ply.rest_points[:, :2]
    springs = [
        *_pair("long", 1, long_stiffness, (long_place, half, grip, corner), turn, flat),
        *_pair("short", 0, short_stiffness, (short_place, half, grip, corner), turn, flat),
    ]
    return replace(
        pressed,
        name="double_dome_springs",
        plies=lay_up([ply]),
        springs=springs,
        parameters=parameters,
        report=_part,
    )


def _part(result: Result) -> dict[str, float]:
    """Largest shear angle of the part [deg], and that which 95 % of its triangles stay below."""
    ply = result.plies[0]
    inside = ply.points[ply.triangles].mean(axis=1)[:, 2] < -FLANGE
    shear = np.abs(ply.shear_angle_deg[inside])
    return {
        "part_max_shear_deg": float(shear.max(initial=0.0)),
        "part_p95_shear_deg": float(np.percentile(shear, 95.0)) if len(shear) else 0.0,
    }


def _outline(half: np.ndarray, corner: float) -> np.ndarray:
    """The blank's outline before it is turned [m], shape [n, 2]."""
    x, y = half
    if corner == 0.0:
        return np.array([(-x, -y), (x, -y), (x, y), (-x, y)])
    cut = [(corner - x, -y), (x - corner, -y), (x, corner - y), (x, y - corner)]
    return np.array([*cut, *(tuple(-np.array(point)) for point in cut)])


def _turned(angle: float) -> np.ndarray:
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])


def _pair(name, across, stiffness, where, turn, flat) -> list[Spring]:
    """The four grips of two edges, each as springs on the vertices that it holds.

    A vertex has the share of a grip that covers its piece of the edge, so that moving the grip by
    less than a triangle moves its pull too.

    Args:
        name: of the edges.
        across: axis that points out of them, 0 for x or 1 for y.
        stiffness: of each grip [N/m].
        where: place of the grips' middles, half the blank's sides, grips' width, cut corners [m].
        turn: of the blank [rad].
        flat: vertices of the blank [m], shape [n, 2].
    """
    place, half, grip, corner = where
    if stiffness == 0.0:
        return []
    along = 1 - across
    most = half[along] - corner - 0.5 * grip
    if not 0.5 * grip <= place <= most:
        raise InputError(
            f"{name}_place = {place:g} m must lie from half a grip, {0.5 * grip:g} m, to "
            f"{most:g} m, where the edge ends"
        )
    springs = []
    back = flat @ _turned(turn)
    for side in (-1.0, 1.0):
        outwards = np.zeros(2)
        outwards[across] = side * FRAME
        edge = np.flatnonzero(side * back[:, across] > half[across] - 1e-6)
        for end in (-1.0, 1.0):
            shares = _shares(back[edge, along], end * place, grip)
            for vertex, share in zip(edge[shares > 0.0], shares[shares > 0.0], strict=True):
                springs.append(
                    Spring(
                        name=f"{name}_{'pn'[side < 0]}{'pn'[end < 0]}_{vertex}",
                        ply="ply_0",
                        where=[int(vertex)],
                        to=(*(_turned(turn) @ outwards), 0.0),
                        stiffness=stiffness * float(share),
                    )
                )
    return springs


def _shares(places: np.ndarray, middle: float, grip: float) -> np.ndarray:
    """Share of a grip at each vertex of an edge, shape [n]: that of its piece that is covered.

    Args:
        places: of the vertices along the edge [m].
        middle: of the grip [m].
        grip: width of it [m].
    """
    order = np.argsort(places)
    ends = places[order]
    cuts = np.concatenate([ends[:1], 0.5 * (ends[1:] + ends[:-1]), ends[-1:]])
    covered = np.clip(cuts, middle - 0.5 * grip, middle + 0.5 * grip)
    shares = np.empty(len(places))
    shares[order] = np.diff(covered) / grip
    return shares


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
