"""The fishnet against closed forms on sphere, cylinder and cone, and nets by other means."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import trimesh

from warpdrape.coupons.closed_forms import net_shear_on_sphere
from warpdrape.fishnet.drape import as_surface, drape_fishnet
from warpdrape.fishnet.net import Net
from warpdrape.tools.profile import Line, revolve
from warpdrape.tools.tool import Tool
from warpdrape.verification.case import CaseResult, absolute
from warpdrape.verification.net_oracle import (
    DOUBLE_CURVED,
    Graph,
    net_on_graph,
    saddle,
    shear_of_cells,
)

RADIUS = 0.1
NEAR = 0.08
"""Half the side of the blank on which the mean error on the sphere is taken [m]."""
DEMO_SPACING = 0.022
"""Spacing in KinDrape's optimisation, whose blank has 20 x 20 cells about (0.25, 0.25) [m]."""
Pair = tuple[float, float]
Counts = tuple[int, int, int, int]
LEAST_START, LEAST_COUNTS = (0.25 + 6 * DEMO_SPACING, 0.25 - 4 * DEMO_SPACING), (4, 16, 14, 6)
"""Start and cells beside it where the objective of that optimisation is least, of 500 settings
within its bounds of 10 nodes and 10°."""


MEAN = 0.05
"""Limit of the mean shear angle [deg], over which cells that are off either way level out: single
ones are allowed six times as much."""


def turned_sphere(subdivisions: int) -> trimesh.Trimesh:
    """A sphere of nearly equal facets, turned so that no yarn runs along their edges."""
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions, radius=RADIUS)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(0.3, (1.0, 2.0, 3.0)))
    return mesh


def square(half: float) -> list[tuple[float, float]]:
    """Outline of a square blank from half its side [m]."""
    return [(-half, -half), (half, -half), (half, half), (-half, half)]


def sphere_error(net: Net) -> float:
    """Mean error of the size of the shear angle on a sphere from its pole [rad].

    Curvature sits at the facets' vertices, so that single cells are off by some of it either way;
    in the mean over the net that levels out.
    """
    number = np.indices(net.cells.shape) - np.array(net.middle)[:, None, None] + 0.5
    u, v = number * net.spacing / RADIUS
    exact = np.sign(u * v) * net_shear_on_sphere(np.abs(u * v).ravel()).reshape(u.shape)
    return float(((net.shear_angle - exact) * np.sign(exact))[net.cells].mean())


def diagonal_shear(net: Net, polar: float) -> float:
    """Largest size of the shear angle along the bias at a polar angle on a sphere [rad].

    Between the middles of the cells on the diagonal, by their true polar angles.
    """
    i, j = net.middle
    count = min(net.cells.shape[0] - i, net.cells.shape[1] - j)
    k = np.flatnonzero(net.cells[i + np.arange(count), j + np.arange(count)])
    corners = [net.points[i + k + a, j + k + b] for a in (0, 1) for b in (0, 1)]
    middle = np.mean(corners, axis=0)
    angle = np.arccos(middle[:, 2] / np.linalg.norm(middle, axis=1))
    return float(np.interp(polar, angle, np.abs(net.shear_angle[i + k, j + k])))


def graph_mesh(
    graph: Graph, low: float, high: float, edge: float, seed: int = 1
) -> trimesh.Trimesh:
    """Facets of a surface z = F(x, y) over a square, their inner vertices strewn at random."""
    from scipy.spatial import Delaunay

    count = round((high - low) / edge)
    line = np.linspace(low, high, count + 1)
    flat = np.stack(np.meshgrid(line, line, indexing="ij"), -1).reshape(-1, 2)
    inner = ((flat > low + 0.5 * edge) & (flat < high - 0.5 * edge)).all(axis=1)
    random = np.random.default_rng(seed)
    flat[inner] += random.uniform(-0.3, 0.3, (np.count_nonzero(inner), 2)) * edge
    points = np.column_stack([flat, graph.height(flat[:, 0], flat[:, 1])])
    return trimesh.Trimesh(points, Delaunay(flat).simplices, process=False)


def against_oracle(
    graph: Graph,
    box: tuple[float, float],
    start: tuple[float, float],
    angle: float,
    spacing: float,
    counts: tuple[int, int, int, int],
    edge: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Signed shear angles of a net's cells, and of one by other means [rad], shape [cell].

    Args:
        graph: the surface.
        box: from and to which x and y go [m].
        start: x and y of the start [m].
        angle: from x to the warp, seen from above [rad].
        spacing: of both nets [m].
        counts: crossovers from the start, warp forth and back, weft forth and back.
        edge: of the facets [m].
    """
    mesh = graph_mesh(graph, *box, edge)
    fx, fy = graph.slopes(*start)
    along = (math.cos(angle), math.sin(angle), fx * math.cos(angle) + fy * math.sin(angle))
    at = (*start, float(graph.height(*start)))
    right, left, top, bottom = (spacing * (np.array(counts) - 0.5)) * (1.0, -1.0, 1.0, -1.0)
    blank = [(left, bottom), (right, bottom), (right, top), (left, top)]
    net = drape_fishnet(mesh, spacing, start=at, warp=along, outline=blank)
    exact = shear_of_cells(net_on_graph(graph, start, angle, spacing, counts))
    return net.shear_angle[net.cells], exact[net.cells]


def unrolled_shear(angle: float) -> tuple[float, float]:
    """Largest shear angle [rad] of nets on a cylinder and a cone, the warp at an angle [rad]."""
    drum = Tool.drum(radius=0.05, length=0.3, facet=5e-3)
    warp = (math.cos(angle), math.sin(angle), 0.0)
    on_drum = drape_fishnet(drum, 4e-3, start=(1e-3, 2e-3, 0.05), warp=warp)
    cone = revolve([Line((0.02, 0.2), (0.1, 0.0))], 5e-3).mesh
    down = (0.08 * math.cos(angle), math.sin(angle), -0.2 * math.cos(angle))
    on_cone = drape_fishnet(cone, 4e-3, start=(0.06, 0.0, 0.1), warp=down, outline=square(0.07))
    largest = [float(np.abs(net.shear_angle).max()) for net in (on_drum, on_cone)]
    return largest[0], largest[1]


def nets(quick: bool) -> Iterator[CaseResult]:
    """All cases of this file."""
    mould = as_surface(turned_sphere(5 if quick else 6))
    steps = (0.04, 0.02) if quick else (0.04, 0.02, 0.01)
    pole, blank = (0.0, 0.0, RADIUS), square(NEAR * (1.0 - 1e-6))
    errors = [sphere_error(drape_fishnet(mould, s, start=pole, outline=blank)) for s in steps]
    rate = math.log(errors[0] / errors[-1]) / math.log(steps[0] / steps[-1])
    yield absolute("fishnet on a sphere: rate of convergence with the spacing", rate, 2.0, 0.2)
    net = drape_fishnet(mould, 2.5e-3, start=pole, outline=square(0.16))
    for polar, exact in ((45.0, 16.11), (90.0, 52.43)):
        measured = math.degrees(diagonal_shear(net, math.radians(polar)))
        words = f"fishnet on a sphere: shear on the bias {polar:g}° from the pole"
        yield absolute(words, measured, exact, 0.3, "°")
    for angle in (0.0, 30.0):
        for kind, shear in zip(
            ("cylinder", "cone"), unrolled_shear(math.radians(angle)), strict=True
        ):
            words = f"fishnet on a {kind}, warp at {angle:g}°: largest shear angle"
            yield absolute(words, shear, 0.0, 1e-9, "rad")
    yield from by_other_means(quick)


def by_other_means(quick: bool) -> Iterator[CaseResult]:
    """Nets on surfaces without a closed form."""
    times = 2 if quick else 1
    spacing, count, edge = times * 5e-3, 30 // times, times * 2.5e-3
    fine, demo = (spacing, (count, count, count, count)), (10, 10, 10, 10)
    mould = "KinDrape's double-curved mould"
    on_mould = (DOUBLE_CURVED, (0.0, 0.5))
    cases: Sequence[tuple[str, Graph, Pair, Pair, float, float, Counts]] = (
        ("a hyperbolic paraboloid", saddle(4.0), (-0.25, 0.25), (0.01, 0.02), 0.4, *fine),
        (mould, *on_mould, (0.25, 0.25), 0.0, *fine),
        (f"{mould}, its demo's blank", *on_mould, (0.25, 0.25), 0.0, DEMO_SPACING, demo),
        (f"{mould}, that moved", *on_mould, LEAST_START, 0.0, DEMO_SPACING, LEAST_COUNTS),
    )
    for where, graph, box, start, angle, spacing, counts in cases:
        oracle = against_oracle(graph, box, start, angle, spacing, counts, edge)
        found, exact = np.degrees(oracle)
        words, size, by_others = f"fishnet on {where}", np.abs(found), np.abs(exact)
        yield absolute(f"{words}: largest shear angle", size.max(), by_others.max(), 0.3, "°")
        yield absolute(f"{words}: mean shear angle", size.mean(), by_others.mean(), MEAN, "°")
        differ = np.abs(found - exact).max()
        yield absolute(f"{words}: largest difference of a cell", differ, 0.0, 0.3, "°")
