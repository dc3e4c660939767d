"""The net against closed forms, other nets, and a walk over facets in space."""

import math

import numpy as np
import pytest
import trimesh

import warpdrape as wd
from warpdrape.fishnet.drape import as_surface
from warpdrape.fishnet.onto import laid_on
from warpdrape.fishnet.surface import NetSurface
from warpdrape.tools.profile import Line, revolve
from warpdrape.units import deg
from warpdrape.verification import nets
from warpdrape.verification.net_oracle import DOUBLE_CURVED, saddle

square = nets.square


def plate(outer, cells=8):
    """Facets of the squares (i, j) of a flat lattice for which ``outer`` holds, 0.1 m a square."""
    line = np.arange(cells + 1) * 0.1
    points = np.stack(np.meshgrid(line, line, [0.0], indexing="ij"), -1).reshape(-1, 3)
    corner = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    facets = []
    for i in range(cells):
        for j in range(cells):
            if outer(i, j):
                a, b, c, d = (
                    corner[i, j],
                    corner[i + 1, j],
                    corner[i + 1, j + 1],
                    corner[i, j + 1],
                )
                facets += [[a, b, c], [a, c, d]] if (i + j) % 2 else [[a, b, d], [b, c, d]]
    return trimesh.Trimesh(points, facets, process=False)


def bent(mesh, at, angle):
    """A flat mesh folded along the line x = at by an angle."""
    points = mesh.vertices.copy()
    far = points[:, 0] - at
    over = far > 0.0
    points[over, 0] = at + far[over] * math.cos(angle)
    points[over, 2] = far[over] * math.sin(angle)
    return trimesh.Trimesh(points, mesh.faces, process=False)


def walked(surface, facet, point, along, length):
    """Where a straight way over facets ends, in space: its direction is turned about each edge."""
    points, facets, twins = surface.points, surface.facets, surface.twins
    entry, left = -1, length
    while True:
        corners = points[facets[facet]]
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        best, out = left, -1
        for k in range(3):
            if k == entry:
                continue
            side = corners[(k + 1) % 3] - corners[k]
            outward = np.cross(side, normal)
            speed = outward @ along
            if speed > 0.0 and (far := max(outward @ (corners[k] - point) / speed, 0.0)) < best:
                best, out = far, k
        point = point + best * along
        if out < 0:
            return point
        axis = corners[(out + 1) % 3] - corners[out]
        axis = axis / np.linalg.norm(axis)
        twin = twins[3 * facet + out]
        other = points[facets[twin // 3]]
        turned = np.cross(other[1] - other[0], other[2] - other[0])
        inward = np.cross(turned, -axis) / np.linalg.norm(turned)
        outward = np.cross(axis, normal) / np.linalg.norm(normal)
        along = (along @ axis) * axis + (along @ outward) * inward
        facet, entry, left = twin // 3, twin % 3, left - best


def misses(net, every=7):
    """How far walks along the net's segments, from their nearer ends, end from the others [m]."""
    surface, found = net.surface, []
    for family, axis in (("warp", 0), ("weft", 1)):
        joined = net.segments[axis]
        leave = getattr(net, f"{family}_leave")
        for at in np.argwhere(joined)[::every]:
            other = at.copy()
            other[axis] += 1
            ends = (at, other) if at[axis] >= net.middle[axis] else (other, at)
            near, far = (tuple(end) for end in ends)
            facet = int(net.facets[near])
            first, second, _ = surface.frames[facet]
            along = math.cos(leave[far]) * first + math.sin(leave[far]) * second
            end = walked(surface, facet, net.points[near], along, net.spacing)
            found.append(np.linalg.norm(end - net.points[far]))
    return np.array(found)


@pytest.fixture(scope="module")
def sphere():
    return as_surface(nets.turned_sphere(5))


def test_sphere_second_order_in_the_spacing(sphere):
    pole, blank = (0.0, 0.0, nets.RADIUS), square(nets.NEAR * (1.0 - 1e-6))
    errors = [
        nets.sphere_error(wd.drape_fishnet(sphere, s, start=pole, outline=blank))
        for s in (0.04, 0.02)
    ]
    assert errors[0] > 1e-3  # there is something to converge
    assert math.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.2)


def test_sphere_bias_diagonal(sphere):
    net = wd.drape_fishnet(sphere, 2.5e-3, start=(0.0, 0.0, nets.RADIUS), outline=square(0.16))
    found = [math.degrees(nets.diagonal_shear(net, at * deg)) for at in (45, 90)]
    assert found == pytest.approx([16.11, 52.43], abs=0.4)  # facets of 4 mm, as the spacing


def test_sphere_all_quadrants_with_their_signs(sphere):
    net = wd.drape_fishnet(sphere, 5e-3, start=(0.0, 0.0, nets.RADIUS), outline=square(0.08))
    n = net.middle[0]
    blocks = [net.shear_angle[n:, n:], net.shear_angle[n - 1 :: -1, n:]]
    blocks += [net.shear_angle[n - 1 :: -1, n - 1 :: -1], net.shear_angle[n:, n - 1 :: -1]]
    for number, block in enumerate(blocks):
        sign = 1.0 if number % 2 == 0 else -1.0
        assert (sign * block[3:, 3:] > 0.0).all()
        assert np.abs(sign * block - blocks[0]).max() < 1.0 * deg  # facets differ: 0.6°


def test_facets_matter_less_the_finer_they_are(sphere):
    """At one spacing; curvature sits at vertices, so that the order is nearer 3/2 than 2."""
    pole, blank = (0.0, 0.0, nets.RADIUS), square(nets.NEAR * (1.0 - 1e-6))
    fields = [
        wd.drape_fishnet(mould, 0.02, start=pole, outline=blank).shear_angle
        for mould in (nets.turned_sphere(2), nets.turned_sphere(3), sphere)
    ]
    coarse, middle = (np.sqrt(((f - fields[-1]) ** 2).mean()) for f in fields[:2])
    assert coarse > 1.0 * deg
    assert coarse / middle > 2.0**1.2


@pytest.mark.parametrize("angle", [0.0, 30.0, 77.0])
def test_no_shear_on_what_unrolls(angle):
    assert max(nets.unrolled_shear(angle * deg)) < 1e-9


def test_geodesic_pattern_on_a_cylinder():
    """Unrolled along its facets' true widths, the net is a square lattice."""
    drum = wd.Tool.drum(radius=0.05, length=0.3, facet=5e-3)
    angle = 25 * deg
    warp = (math.cos(angle), math.sin(angle), 0.0)
    net = wd.drape_fishnet(drum, 4e-3, start=(1e-3, 2e-3, 0.05), warp=warp, outline=square(0.06))
    around = np.unique(np.round(np.arctan2(drum.vertices[:, 0], drum.vertices[:, 2]), 9))
    width = 2.0 * 0.05 * math.sin(0.5 * np.diff(around).mean())
    points = net.points[net.placed]
    bearing = np.arctan2(points[:, 0], points[:, 2])
    facet = np.searchsorted(around, bearing) - 1
    half = 0.5 * np.diff(around)[facet]
    middle = around[facet] + half
    way = 0.05 * np.cos(half) * np.tan(bearing - middle)
    unrolled = np.stack([(facet + 0.5) * width + way, points[:, 1]], axis=1)
    flat = net.flat_points[net.placed]
    start = np.flatnonzero((flat == 0.0).all(axis=1))[0]
    tilt = middle[start]  # the warp is projected onto the facet there
    angle = math.atan2(math.sin(angle), math.cos(angle) * math.cos(tilt))
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    expected = flat @ turn.T
    error = unrolled - unrolled[start] - expected + expected[start]
    assert len(flat) > 800
    assert np.abs(error).max() < 1e-7  # tool vertices are merged to 1e-8 m


def test_spacing_along_the_facets(sphere):
    for net in (
        wd.drape_fishnet(sphere, 6e-3, start=(0.01, 0.0, nets.RADIUS), outline=square(0.07)),
        wd.drape_fishnet(nets.graph_mesh(DOUBLE_CURVED, 0.0, 0.5, 0.03), 0.011),
    ):
        found = misses(net)
        assert len(found) > 90
        # A way through a vertex with more than a full turn round it is bent there: few are.
        assert (found < 1e-10 * net.spacing).mean() > 0.97
        assert found.max() < 1e-2 * net.spacing


MOULD = (DOUBLE_CURVED, (0.0, 0.5))


@pytest.mark.parametrize(
    ("graph", "box", "start", "angle", "spacing", "counts", "shown"),
    [
        (saddle(4.0), (-0.25, 0.25), (0.01, 0.02), 0.4, 1e-2, (15,) * 4, None),
        (DOUBLE_CURVED, (0.0, 0.5), (0.25, 0.25), 0.0, 1e-2, (15,) * 4, None),
        (*MOULD, (0.25, 0.25), 0.0, nets.DEMO_SPACING, (10,) * 4, (22.5, 1.9)),
        (*MOULD, nets.LEAST_START, 0.0, nets.DEMO_SPACING, nets.LEAST_COUNTS, (9.0, 2.6)),
    ],
)
def test_as_a_net_by_other_means(graph, box, start, angle, spacing, counts, shown):
    """Also with the public inputs of KinDrape's optimisation; what they show is in the docs."""
    found, exact = nets.against_oracle(graph, box, start, angle, spacing, counts, 7e-3)
    assert found.shape == ((counts[0] + counts[1]) * (counts[2] + counts[3]),)
    assert np.abs(exact).max() > 5.0 * deg
    assert abs(np.abs(found).max() - np.abs(exact).max()) < 0.3 * deg
    assert np.abs(found - exact).max() < 0.5 * deg
    if shown is not None:
        largest, mean = np.degrees((np.abs(found).max(), np.abs(found).mean()))
        assert (largest, mean) == pytest.approx(shown, abs=0.3)


def test_curvature_of_an_apex_is_the_shear_beyond_it():
    """Gauss and Bonnet: cells shear by the apex if their rectangle to the generators holds it."""
    slope = 0.5
    cone = revolve([Line((0.0, 0.2 * slope), (0.2, 0.0))], 0.02).mesh
    mould = as_surface(cone)
    apex = int(np.argmax(mould.points[:, 2]))
    corners = mould.points[mould.facets]
    at = mould.facets == apex
    defect = 2.0 * math.pi
    for k in range(3):
        a, b, c = (corners[at[:, k], (k + m) % 3] for m in range(3))
        cosine = ((b - a) * (c - a)).sum(1)
        cosine /= np.linalg.norm(b - a, axis=1) * np.linalg.norm(c - a, axis=1)
        defect -= np.arccos(cosine).sum()
    start = (-0.081, -0.063, 0.1 - 0.5 * math.hypot(0.081, 0.063))
    net = wd.drape_fishnet(mould, 0.01, start=start, warp=(1.0, 0.1, 0.3))
    shear = np.unique(np.round(net.shear_angle[net.cells], 9))
    held = np.abs(net.shear_angle - defect) < 1e-9
    i, j = np.argwhere(held & net.cells).T
    assert len(i) > 20
    assert i.min() > net.middle[0] and j.min() > net.middle[1]
    inside = net.cells.copy()
    inside[i.min() - 1 :, j.min() - 1 :] = False
    assert np.abs(net.shear_angle[inside]).max() < 1e-9
    assert len(shear) >= 2
    (dart,) = wd.suggest_darts(net, 0.5 * defect)
    assert dart.angle == pytest.approx(0.5 * defect, abs=0.02)  # a cell's mean holds part of it
    assert np.linalg.norm(np.array(dart.tip_at) - mould.points[apex]) < 0.025
    assert wd.suggest_darts(net, 1.2 * defect) == ()


def test_hole_is_spanned_or_ends_the_net():
    mesh = plate(lambda i, j: not (i in (5, 6) and j in (4, 5)))
    start = (0.2501, 0.1303, 0.0)
    over = wd.drape_fishnet(mesh, 0.02, start=start, warp=(1.0, 0.2, 0.0))
    round_it = wd.drape_fishnet(mesh, 0.02, start=start, warp=(1.0, 0.2, 0.0), holes="end")
    for net in (over, round_it):
        assert np.abs(net.shear_angle).max() < 1e-9
        assert {end.reason for end in net.ends} == {"border"}
        lattice = net.points[net.placed] - net.points[net.middle]
        turn = np.array([1.0, 0.2]) / math.hypot(1.0, 0.2)
        flat = net.flat_points[net.placed]
        expected = np.stack([flat @ [turn[0], -turn[1]], flat @ [turn[1], turn[0]]], axis=1)
        assert np.abs(lattice[:, :2] - expected).max() < 1e-9
    hole = 0.04 / 0.02**2
    assert 0.64 / 0.02**2 - over.count == pytest.approx(0.0, abs=60)  # but for the edges
    # Behind the hole, seen from the start, the yarns begin again.
    assert over.count - round_it.count == pytest.approx(hole, abs=30)


def test_net_reaches_both_legs_of_an_l():
    mesh = plate(lambda i, j: i < 3 or j < 3)
    net = wd.drape_fishnet(mesh, 0.02, start=(0.151, 0.503, 0.0), warp=(1.0, 0.0, 0.0))
    points = net.points[net.placed]
    assert net.count * 0.02**2 == pytest.approx(0.39, rel=0.06)  # 39 squares of a hundredth
    assert points[:, 0].max() > 0.77 and points[:, 1].max() > 0.77
    assert np.abs(net.shear_angle).max() < 1e-9


def test_sharp_fold_unrolls():
    mesh = bent(plate(lambda i, j: True), 0.4, 90 * deg)
    net = wd.drape_fishnet(mesh, 0.03, start=(0.201, 0.303, 0.0), warp=(1.0, 0.3, 0.0))
    assert net.count * 0.03**2 == pytest.approx(0.64, rel=0.1)
    assert np.abs(net.shear_angle).max() < 1e-9


def test_yarns_that_are_not_square_to_each_other():
    net = wd.drape_fishnet(
        plate(lambda i, j: True),
        0.02,
        start=(0.4, 0.4, 0.0),
        yarn_angle=60 * deg,
        shear_limit=50 * deg,
        outline=square(0.15),
    )
    area = np.count_nonzero(net.cells) * 0.02**2 * math.sin(60 * deg)
    assert area == pytest.approx(0.3**2, rel=0.3)  # whole cells cover it
    low, high = net.flat_points[net.placed].min(axis=0), net.flat_points[net.placed].max(axis=0)
    assert (low < -0.15).all() and (high > 0.15).all()
    assert area > 0.3**2
    flat = net.points[net.placed][:, :2] - 0.4
    assert np.abs(flat - net.flat_points[net.placed]).max() < 1e-12
    assert np.abs(net.shear_angle).max() < 1e-9


def test_ply_is_laid_where_its_yarns_are():
    turn = np.array([[math.cos(0.3), math.sin(0.3)], [-math.sin(0.3), math.cos(0.3)]])
    net = wd.drape_fishnet(
        plate(lambda i, j: True), 0.05, start=(0.4, 0.4, 0.0), warp=(*turn[0], 0.0)
    )
    flat = np.random.default_rng(0).uniform(-0.2, 0.2, (50, 2))
    points, there = laid_on(net, flat)
    assert there.all()
    assert np.abs(points[:, :2] - 0.4 - flat @ turn).max() < 1e-12
    _, there = laid_on(net, np.array([[0.0, 2.0], [0.0, 0.0]]))
    assert there.tolist() == [False, True]


def test_plane_generators_lie_in_their_planes():
    drum = wd.Tool.drum(radius=0.05, length=0.3, facet=5e-3)
    warp = (math.cos(0.5), math.sin(0.5), 0.0)
    net = wd.drape_fishnet(
        drum, 4e-3, start=(0.0, 2e-3, 0.05), warp=warp, generators="plane", outline=square(0.05)
    )
    i, j = net.middle
    for line in (net.points[:, j], net.points[i]):
        _, sizes, _ = np.linalg.svd(line - line.mean(axis=0))
        assert sizes[2] < 1e-9 and sizes[1] > 1e-3
    assert np.abs(net.shear_angle).max() > 1.0 * deg  # no geodesic, so it shears
    assert misses(net).max() < 1e-10 * net.spacing


def test_generators_of_least_shear():
    mesh = nets.graph_mesh(saddle(6.0), -0.2, 0.2, 0.04)
    start = (0.05, -0.03, -9e-3)
    options = {"start": start, "warp": (1.0, 0.6, 0.0), "outline": square(0.14)}
    shear = [
        wd.drape_fishnet(mesh, 0.02, generators=kind, **options)
        for kind in ("geodesic", "least_shear")
    ]
    straight, bent_ones = (np.sqrt((n.shear_angle[n.cells] ** 2).mean()) for n in shear)
    assert shear[1].cells.sum() >= shear[0].cells.sum()
    assert bent_ones < 0.97 * straight
    assert misses(shear[1]).max() < 1e-2 * 0.02


def test_start_line_is_passed():
    line = np.array([[0.103, 0.1, 0.0], [0.4, 0.2, 0.0], [0.6, 0.5, 0.0]])
    net = wd.drape_fishnet(plate(lambda i, j: True), 0.015, start=line)
    warp = net.points[net.middle[0] :, net.middle[1]][net.placed[net.middle[0] :, net.middle[1]]]
    for point in line:
        assert np.linalg.norm(warp - point, axis=1).min() < 0.5 * 0.015 + 1e-12
    ahead = warp[-1] - warp[-2]
    assert ahead[:2] @ [0.2, 0.3] / np.linalg.norm(ahead) / math.hypot(0.2, 0.3) > 0.99


def test_net_goes_half_way_round_a_closed_surface():
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=0.1)
    net = wd.drape_fishnet(mesh, 0.01)
    assert {end.reason for end in net.ends} == {"sheared"}
    i, j = net.middle
    assert net.placed[:, j].all() and net.placed[i].all()
    for end in (net.points[0, j], net.points[-1, j], net.points[i, 0], net.points[i, -1]):
        assert np.linalg.norm(end - net.points[i, j]) > 0.19
    assert net.max_shear_deg <= 85.0


def test_several_starts_share_the_surface():
    starts = np.array([[0.203, 0.41, 0.0], [0.61, 0.38, 0.0], [0.42, 0.71, 0.0]])
    warps = [(1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (2.0, -1.0, 0.0)]
    parts = wd.drape_fishnets(plate(lambda i, j: True), 0.01, starts, warps=warps)
    total = 0.0
    random = np.random.default_rng(1).uniform(0.0, 0.8, (4000, 2))
    nearest = np.linalg.norm(random[:, None] - starts[:, :2], axis=2).argmin(axis=1)
    for number, part in enumerate(parts):
        area = np.count_nonzero(part.cells) * 0.01**2
        # Its share by chance's count, but for cells at its edges.
        assert area == pytest.approx(0.64 * (nearest == number).mean(), rel=0.1)
        total += area
    assert total == pytest.approx(0.64, rel=0.05)
    with pytest.raises(wd.InputError, match="2 warps for 3 starts: give one for each"):
        wd.drape_fishnets(plate(lambda i, j: True), 0.01, starts, warps=warps[:2])
    with pytest.raises(wd.InputError, match="must be two points"):
        wd.drape_fishnets(plate(lambda i, j: True), 0.01, starts[:1])


def test_offset_moves_along_the_normals(sphere):
    moved = sphere.offset(1e-3)
    assert isinstance(moved, NetSurface)
    radii = np.linalg.norm(moved.points, axis=1)
    assert np.abs(radii - nets.RADIUS - 1e-3).max() < 1e-6
