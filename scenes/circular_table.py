"""A square sheet drapes over a round table under its own weight (paper, Figure 3)."""

import numpy as np

from warpdrape import Bending, Fabric, Numerics, Ply, Scene, Tool, lay_up
from warpdrape.errors import one_of
from warpdrape.laws import IsotropicMembrane, LinearTension, NoShear, ShearPolynomial
from warpdrape.materials.fabric_library import with_bending
from warpdrape.results.result import FormedPly, Result
from warpdrape.units import mm

CELL = 1 * mm
EDGE_RADIUS = 10 * mm
THICKNESS = 0.4 * mm
YARN_STIFFNESS = 2000.0
"""Line stiffness of both yarn families [N/m]: the weight strains them by less than 0.1 %."""
SHEET_STIFFNESS = 20000.0
"""Young's modulus times thickness of the isotropic sheet [N/m]; paper has ten times more.

A flat isotropic sheet can follow a table only by sharp folds; the softer it is against its weight,
the more it gives way beside them, and so hides what the case is to show.
"""
SHEAR_STIFFNESS = 20.0
"""Initial shear stiffness dC/dγ per area [N/m]: a hundredth of the yarns', 40 times the weight."""
BENDING_STIFFNESS = 1e-5
"""Of both yarn families, per metre of width [N·m]: a flexural length of 17 mm, a light cotton."""
CASES = ("fabric", "no_shear", "isotropic")


def sheet(case: str) -> Fabric:
    """The sheet of a case; a light cloth, its values chosen for this demonstration."""
    yarn = YARN_STIFFNESS * CELL
    shear = ShearPolynomial((SHEAR_STIFFNESS * CELL**2,))
    isotropic = case == "isotropic"
    tension = IsotropicMembrane(SHEET_STIFFNESS, 0.3) if isotropic else LinearTension(yarn, yarn)
    bending = Bending(warp=BENDING_STIFFNESS, weft=BENDING_STIFFNESS)
    if isotropic:
        bending = Bending.of_sheet(SHEET_STIFFNESS, 0.3, THICKNESS)
    return Fabric(
        name=f"table_{case}",
        areal_density=0.2,
        thickness=THICKNESS,
        cell_warp=CELL,
        cell_weft=CELL,
        tension=tension,
        shear=shear if case == "fabric" else NoShear(),
        bending=bending,
    )


def build(
    *,
    case: str = "fabric",
    cells: int = 100,
    sheet_size: float = 0.5,
    table_radius: float = 0.2,
    duration: float = 1.0,
    damping: float = 6.0,
    friction: float = 0.3,
    bending: str = "fabric",
    contact: str = "fast",
    approach: str = "semi_discrete",
) -> Scene:
    """Build the sheet on the table.

    Args:
        case: "fabric", "no_shear" or "isotropic": Figure 3 a, b, c.
        cells: squares of two triangles along a side.
        sheet_size: side of the sheet [m].
        table_radius: radius of the table [m].
        duration: simulated time [s].
        damping: mass-proportional damping rate [1/s].
        friction: Coulomb coefficient of sheet on table [-].
        bending: "fabric" for the sheet's own, "none", or a stiffness in all directions [N·m].
        contact: "fast", or "exact" to search for every vertex at every step.
        approach: "semi_discrete"; stress as a state, "green_naghdi" or "fibre_frame"; "yarns",
            chains of bars, or "sliding_yarns"; or a net, "fishnet", on the table and its side.
    """
    parameters = dict(locals())
    one_of("case", case, CASES)
    cloth = with_bending(sheet(case), bending)
    (ply,) = lay_up([Ply.rectangle("sheet", cloth, sheet_size, cells=cells, mesh="diagonal")])
    return Scene(
        name="circular_table",
        plies=[ply],
        tools=[Tool.table(radius=table_radius, edge_radius=EDGE_RADIUS, depth=sheet_size)],
        duration=duration,
        friction=friction,
        numerics=Numerics(
            damping=damping, search_slide=0.15 * mm, contact_share=0.1, contact=contact
        ),
        approach=approach,
        parameters=parameters,
        report=lambda result: {"table": drape_measures(result, table_radius)},
    )


def drape_measures(result: Result, table_radius: float) -> dict[str, float | None]:
    """Corner drop, shear in the corners, and how much the sheet wrinkles beside the table.

    Returns:
        ``corner_drop_m`` and ``side_drop_m``: how far corners and middles of the sides hang down;
        ``corner_shear_deg``: mean shear angle of the triangles nearest to the corners;
        ``wrinkle_angle_deg``: root mean square angle between neighbouring triangles in the ring
        from the table's rim to the circle inscribed in the sheet. The corners beyond are left out:
        without shear stiffness they collapse to strings. None where an approach has left that part
        of the sheet out.
    """
    ply = result.plies[0]
    flat = ply.rest_points[:, :2]
    size = np.abs(flat).max()
    corners = np.abs(flat).min(axis=1) > 0.999 * size
    sides = (np.abs(flat).max(axis=1) > 0.999 * size) & (np.abs(flat).min(axis=1) < 0.03 * size)
    drop = ply.rest_points[:, 2] - ply.points[:, 2]
    center = np.abs(flat[ply.triangles].mean(axis=1)).min(axis=1)
    near_corner = center > 0.9 * size
    radius = np.linalg.norm(flat[ply.triangles].mean(axis=1), axis=1)
    ring = (radius > table_radius + EDGE_RADIUS) & (radius < size)
    return {
        "corner_drop_m": _mean(drop[corners]),
        "side_drop_m": _mean(drop[sides]),
        "corner_shear_deg": _mean(np.abs(ply.shear_angle_deg[near_corner])),
        "wrinkle_angle_deg": wrinkle_angle(ply, ring) if ring.any() else None,
    }


def _mean(values: np.ndarray) -> float | None:
    return float(values.mean()) if len(values) else None


def wrinkle_angle(ply: FormedPly, chosen: np.ndarray) -> float:
    """Root mean square angle [deg] between neighbouring triangles of a part of a ply."""
    a, b, c = (ply.points[ply.triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    edges = np.sort(ply.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(ply.triangles)), 3)
    order = np.lexsort(edges.T)
    same = (edges[order][1:] == edges[order][:-1]).all(axis=1)
    left, right = owner[order][1:][same], owner[order][:-1][same]
    both = chosen[left] & chosen[right]
    cosine = np.clip((normals[left[both]] * normals[right[both]]).sum(axis=1), -1.0, 1.0)
    return float(np.degrees(np.sqrt(np.mean(np.arccos(cosine) ** 2))))


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
