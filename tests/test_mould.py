"""A mould's face, its counterpart at a constant distance, and the holder round its shape."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import shapely
import trimesh

import warpdrape as wd
from warpdrape.tools.counterpart import _distances, _ways
from warpdrape.tools.holder_ring import holder_ring
from warpdrape.tools.mould_face import face_of
from warpdrape.tools.profile import Arc, Line, revolve
from warpdrape.tools.tool_mesh import read_surface

STEEP = math.radians(70.0)


def bowl(fillet=8e-3, floor=25e-3, rim=90e-3, facet=2e-3):
    """A female mould: spherical floor, cone, rounding, flat rim at z = 0; its axis z."""
    a = STEEP
    outer = rim - 20e-3
    start = outer - fillet * math.sin(a)
    low = -fillet * (1.0 - math.cos(a))
    end = floor * math.sin(a)
    drop = (start - end) * math.tan(a)
    centre = low - drop + floor * math.cos(a)
    pieces = [
        Line((rim, 0.0), (outer, 0.0)),
        Arc((outer, -fillet), fillet, 0.5 * math.pi, 0.5 * math.pi + a),
        Line((start, low), (end, low - drop)),
        Arc((0.0, centre), floor, a - 0.5 * math.pi, -0.5 * math.pi),
    ]
    made = revolve(pieces, facet)
    mesh = trimesh.Trimesh(made.mesh.vertices, made.mesh.faces[:, ::-1], process=False)
    return wd.Tool(name="mould", surface=replace(made, mesh=mesh, normals=-made.normals[:, ::-1]))


def hump():
    """The bowl as a male mould, its rim at z = 0."""
    return bowl().turned((1.0, 0.0, 0.0), math.pi).flipped()


def test_the_bowl_is_female_and_its_rim_is_found():
    mould = wd.Mould.of(bowl())
    assert mould.kind == "female" and mould.has_rim and mould.face.level == pytest.approx(0.0)
    assert mould.level == pytest.approx(0.0) and mould.face.hidden == 0.0
    rim = mould.face.surface.mesh.triangles[mould.face.rim]
    assert np.hypot(*rim[..., :2].reshape(-1, 2).T).min() == pytest.approx(0.07, rel=1e-3)
    assert mould.face.outline.area == pytest.approx(math.pi * 0.07**2, rel=2e-3)
    assert "female, rim at z 0 mm" in repr(mould)


def test_the_hump_is_male_and_its_plies_lie_on_its_top():
    mould = wd.Mould.of(hump())
    assert mould.kind == "male" and mould.has_rim
    assert mould.face.level == pytest.approx(0.0, abs=1e-9) and mould.level > 0.05


@pytest.mark.parametrize("gap", [0.9e-3, 3e-3])
def test_a_counterpart_keeps_its_distance_everywhere(gap):
    mould = wd.Mould.of(bowl(facet=1.5e-3))
    punch = mould.counterpart("punch", gap=gap)
    near = _distances(mould.tool.surface.mesh, punch.vertices)
    np.testing.assert_allclose(near, gap, rtol=0.02)
    floor = punch.vertices[np.argmin(punch.vertices[:, 2])]
    assert floor[2] == pytest.approx(mould.tool.vertices[:, 2].min() + gap)
    facing = punch.surface.mesh.face_normals
    assert facing[:, 2].max() < 0.0
    assert np.einsum("fi,fki->fk", facing, punch.surface.normals).min() > 0.99
    assert not punch.surface.mesh.is_watertight  # it ends where the rim begins
    assert np.hypot(*punch.vertices[:, :2].T).max() == pytest.approx(0.07, rel=1e-3)


def test_over_a_male_mould_the_counterpart_covers_the_rim_too():
    mould = wd.Mould.of(hump())
    die = mould.counterpart("die", gap=1e-3)
    assert np.hypot(*die.vertices[:, :2].T).max() == pytest.approx(0.09, rel=1e-3)
    assert die.vertices[:, 2].min() == pytest.approx(1e-3)


def test_sharp_edges_keep_their_corner():
    faces = []
    corners = {}

    def add(*quad):
        index = [corners.setdefault(tuple(p), len(corners)) for p in quad]
        faces.extend([[index[0], index[1], index[2]], [index[0], index[2], index[3]]])

    line = [(-0.1, 0.0), (-0.03, 0.0), (0.0, -0.03), (0.03, 0.0), (0.1, 0.0)]
    for (x0, z0), (x1, z1) in pairwise(line):
        add((x0, -0.1, z0), (x1, -0.1, z1), (x1, 0.1, z1), (x0, 0.1, z0))
    surface = read_surface("v", trimesh.Trimesh(list(corners), faces, process=False), 1.0)
    mould = wd.Mould.of(wd.Tool(name="mould", surface=surface), kind="male")
    gap = 2e-3
    die = mould.counterpart("die", gap=gap)
    bottom = die.vertices[np.abs(die.vertices[:, 0]) < 1e-9]
    assert bottom[:, 2].tolist() == pytest.approx([-0.03 + gap * math.sqrt(2.0)] * 2)
    edge = die.vertices[np.abs(die.vertices[:, 0] - 0.03) < 1.5e-3]
    assert edge[:, 2].tolist() == pytest.approx([gap] * 2)
    assert edge[:, 0].tolist() == pytest.approx([0.03 - gap * math.tan(math.radians(22.5))] * 2)


def test_an_edge_keeps_its_corner_where_one_side_has_the_wider_facets():
    points = [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, -0.5, 0.0), (-1.0, 3.0, -1.0)]
    mesh = trimesh.Trimesh(points, [[0, 2, 1], [0, 1, 3]], process=False)
    normals = np.repeat(mesh.face_normals[:, None], 3, axis=1)
    way = _ways(mesh, normals, 0.01)[0]
    assert mesh.face_angles[0, 0] > 4.0 * mesh.face_angles[1, 0]
    np.testing.assert_allclose(mesh.face_normals @ way, 0.01, rtol=1e-9)


def test_a_rounding_narrower_than_the_gap_is_left_open_and_all_else_keeps_off():
    gap = 3e-3
    pieces = [
        Line((0.08, 0.0), (0.05, 0.0)),
        Arc((0.05, -5e-3), 5e-3, 0.5 * math.pi, 0.5 * math.pi + STEEP),
    ]
    end = (0.05 - 5e-3 * math.sin(STEEP), -5e-3 * (1 - math.cos(STEEP)))
    foot = (0.038, end[1] - (end[0] - 0.038) * math.tan(STEEP))
    sharp = 1e-3  # between wall and floor
    middle = (foot[0] - sharp * math.sin(STEEP), foot[1] + sharp * math.cos(STEEP))
    pieces += [
        Line(end, foot),
        Arc(middle, sharp, STEEP - 0.5 * math.pi, -0.5 * math.pi),
        Line((middle[0], middle[1] - sharp), (0.0, middle[1] - sharp)),
    ]
    made = revolve(pieces, 1e-3)
    tool = wd.Tool(name="mould", surface=made).flipped()
    mould = wd.Mould.of(tool)
    punch = mould.counterpart("punch", gap=gap)
    centres = punch.surface.mesh.triangles_center
    assert _distances(mould.tool.surface.mesh, centres).min() >= 0.9 * gap
    assert _distances(mould.tool.surface.mesh, punch.vertices).min() >= 0.9 * gap
    assert len(punch.triangles) < (~mould.face.rim).sum()
    whole = math.pi * 0.03**2
    flat = punch.surface.mesh.area_faces[punch.surface.mesh.face_normals[:, 2] < -0.999].sum()
    assert flat > 0.8 * whole  # the floor is there
    hollow = revolve([Arc((0.0, 0.0), 0.05, 0.0, -0.5 * math.pi)], 5e-3)
    bowl_only = wd.Mould.of(wd.Tool(name="mould", surface=hollow).flipped())
    with pytest.raises(wd.InputError, match="leaves nothing of the mould's counterpart"):
        bowl_only.counterpart("punch", gap=0.06)


def boxed(draft=0.0):
    """A block with a box-shaped pocket, its walls upright or drafted: a closed solid."""
    a, b, d = 0.1, 0.05, 0.03
    low = b - d * math.tan(draft)
    rings = [[(-s, -s), (s, -s), (s, s), (-s, s)] for s in (a, a, b, low)]
    heights = (-0.06, 0.0, 0.0, -d)
    points = [(x, y, z) for ring, z in zip(rings, heights, strict=True) for x, y in ring]
    faces = [[0, 2, 1], [0, 3, 2], [12, 13, 14], [12, 14, 15]]
    for ring in range(3):
        for k in range(4):
            p, q = 4 * ring + k, 4 * ring + (k + 1) % 4
            faces += [[p, q, q + 4], [p, q + 4, p + 4]]
    return trimesh.Trimesh(points, faces, process=False)


def test_upright_walls_of_a_pocket_belong_to_the_face_and_a_block_s_outside_does_not():
    mesh = boxed()
    assert mesh.is_watertight
    face = face_of("mould", read_surface("m", mesh, 1.0))
    area = 0.2**2 + 4 * 0.1 * 0.03
    assert face.surface.mesh.area == pytest.approx(area)
    assert face.rim.sum() == 8 and face.hollow
    drafted = face_of("mould", read_surface("m", boxed(math.radians(10)), 1.0))
    assert drafted.surface.mesh.vertices[:, 2].min() == pytest.approx(-0.03)


def test_what_lies_under_something_else_is_no_part_of_the_face():
    table = trimesh.creation.box((0.2, 0.2, 0.01))
    shelf = trimesh.creation.box((0.1, 0.1, 0.01))
    shelf.apply_translation((0.0, 0.0, -0.05))
    both = trimesh.util.concatenate([table, shelf])
    face = face_of("mould", read_surface("m", both, 1.0))
    assert face.surface.mesh.area == pytest.approx(0.04)
    assert face.hidden == pytest.approx(0.25)


def test_up_turns_the_file_and_an_open_sheet_may_face_either_way():
    tray = bowl()
    down = tray.turned((1.0, 0.0, 0.0), math.pi)
    again = wd.Mould.of(down, up="-z")
    np.testing.assert_allclose(
        np.sort(again.tool.vertices[:, 2]),
        np.sort(wd.Mould.of(tray).tool.vertices[:, 2]),
        atol=1e-9,
    )
    assert again.kind == "female"
    for up, axis, angle in (
        ("x", (0, 1, 0), 0.5 * math.pi),
        ("-x", (0, 1, 0), -0.5 * math.pi),
        ("y", (1, 0, 0), -0.5 * math.pi),
        ("-y", (1, 0, 0), 0.5 * math.pi),
    ):
        assert wd.Mould.of(tray.turned(axis, angle), up=up).kind == "female", up
    flipped = wd.Mould.of(tray.flipped())
    assert flipped.kind == "female" and flipped.face.surface.mesh.face_normals[:, 2].min() > 0.0
    with pytest.raises(wd.InputError, match="unknown up 'w'"):
        wd.Mould.of(tray, up="w")


@pytest.mark.parametrize("male", [False, True])
def test_a_holder_lies_flat_round_the_shape(male):
    mould = wd.Mould.of(hump() if male else bowl())
    thickness, clearance = 1e-3, 2e-3
    holder = mould.holder(thickness=thickness, force=50.0, clearance=clearance)
    points, facing = holder.vertices, holder.surface.mesh.face_normals
    z = mould.level if male else mould.level + thickness
    flat = np.abs(facing[:, 2]) > 0.999
    assert np.sign(facing[flat, 2]).tolist() == [1.0 if male else -1.0] * flat.sum()
    assert points[holder.triangles[flat]][..., 2] == pytest.approx(z)
    room = 0.07 + clearance + (thickness if male else 0.0)
    radius = np.hypot(*points[:, :2].T)
    assert radius.min() == pytest.approx(room, abs=2e-4)
    assert radius.max() == pytest.approx(0.09, rel=1e-3)
    area = math.pi * (0.09**2 - (room + 2e-3) ** 2)
    assert holder.surface.mesh.area_faces[flat].sum() == pytest.approx(area, rel=0.01)
    assert holder.motion.mass is None  # it weighs like the plies: its inertia is not the press's
    assert 50.0 / holder.motion.damping == pytest.approx(20.0 if male else 5.0)
    assert holder.motion.axis[2] == (1.0 if male else -1.0)
    assert np.einsum("fi,fki->fk", facing, holder.surface.normals).min() > 0.99
    up = points[:, 2] - z  # the rounding goes away from the plies
    assert (up >= -1e-12).all() != male and (up <= 1e-12).all() == male


def ridge(length=0.2):
    """A hat right through the mould, along x, on a base that ends beside it."""
    profile = [
        (-0.08, 0.0),
        (-0.025, 0.0),
        (-0.014, 0.025),
        (0.014, 0.025),
        (0.025, 0.0),
        (0.08, 0.0),
    ]
    points = [(x, y, z) for x in (-0.5 * length, 0.5 * length) for y, z in profile]
    n = len(profile)
    faces = [f for k in range(n - 1) for f in ((k, n + k, n + k + 1), (k, n + k + 1, k + 1))]
    mesh = trimesh.Trimesh(points, faces, process=False)
    return wd.Tool(name="mould", surface=read_surface("hat", mesh, 1.0))


def test_a_hat_through_the_border_is_male_and_a_groove_female():
    """Of a border that goes up and down the mean along its length tells, not its corners'."""
    hat = wd.Mould.of(ridge())
    assert hat.kind == "male" and not hat.has_rim and hat.face.undercut == 0.0
    assert hat.face.level == pytest.approx(0.4 * 0.025 * 0.039 / 0.16 / 0.4 * 160 / 360, rel=0.2)
    groove = wd.Mould.of(ridge(), up="-z")
    assert groove.kind == "female"


def test_an_undercut_is_measured():
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.04)
    ball.apply_translation((0.0, 0.0, 0.06))
    plate = trimesh.creation.box((0.2, 0.2, 0.01))
    both = read_surface("ball", trimesh.util.concatenate([plate, ball]), 1.0)
    found = face_of("ball", both)
    whole = found.surface.mesh.area
    assert found.undercut == pytest.approx(2.0 * math.pi * 0.04**2 / whole, rel=0.05)
    assert face_of("block", read_surface("block", plate, 1.0)).undercut == 0.0
    alone = trimesh.creation.icosphere(subdivisions=3, radius=0.04)
    assert face_of("ball", read_surface("ball", alone, 1.0)).undercut == 0.0  # it is the outside


def test_a_mould_without_a_flat_rim_has_no_holder():
    dome = wd.Tool.sphere(radius=0.05)
    mould = wd.Mould.of(dome)
    assert not mould.has_rim and mould.kind == "male"
    with pytest.raises(wd.InputError, match="has no flat rim round its shape"):
        mould.holder(thickness=1e-3, force=10.0)
    assert len(mould.counterpart("die", gap=1e-3).triangles) == len(mould.tool.triangles)
    with pytest.raises(wd.InputError, match="too narrow for a blank holder"):
        wd.Mould.of(bowl()).holder(thickness=1e-3, force=10.0, clearance=0.03)


def test_units_of_a_mesh_file_are_asked_and_believed_only_if_plausible(tmp_path):
    file = tmp_path / "bowl.stl"
    mesh = bowl().surface.mesh.copy()
    mesh.apply_scale(1e3)
    mesh.export(file)
    with pytest.raises(wd.InputError, match="states no unit: give units, one of m, cm, mm, inch"):
        wd.Mould.from_file(file)
    for units, across in (("m", "180 m"), ("furlong", "unknown unit")):
        with pytest.raises(wd.InputError, match=across):
            wd.Mould.from_file(file, units=units)
    mould = wd.Mould.from_file(file, units="mm")
    assert mould.unit == "mm" and np.ptp(mould.tool.vertices[:, 0]) == pytest.approx(0.18, rel=1e-3)
    assert wd.Mould.from_file(file, units="cm").tool.vertices[:, 0].max() == pytest.approx(
        0.9, rel=1e-3
    )


def dented(*depths, level=0.0):
    """A plate at a level with long dents (humps where the depth is negative) side by side."""
    across, along = np.linspace(-0.12, 0.12, 97), np.linspace(-0.12, 0.12, 97)
    x, y = (grid.ravel() for grid in np.meshgrid(across, along, indexing="ij"))
    z = np.full(len(x), level)
    middles = 0.08 * (np.arange(len(depths)) - 0.5 * (len(depths) - 1))
    for middle, depth in zip(middles, depths, strict=True):
        away = np.minimum(np.hypot(np.maximum(np.abs(y) - 0.04, 0.0), x - middle) / 0.025, 1.0)
        z -= 0.5 * depth * (1.0 + np.cos(np.pi * away))
    corner = (np.arange(96)[:, None] * 97 + np.arange(96)).ravel()
    faces = np.concatenate([corner[:, None] + (0, 97, 98), corner[:, None] + (0, 98, 1)])
    mesh = trimesh.Trimesh(np.stack([x, y, z], axis=1), faces, process=False)
    return wd.Tool(name="mould", surface=read_surface("dents", mesh, 1.0))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_holder_leaves_every_shape_open(sign):
    """A punch that went into a dent under the holder would press the ply through it."""
    mould = wd.Mould.of(dented(sign * 12e-3, sign * 8e-3))
    assert mould.kind == ("female" if sign > 0.0 else "male")
    assert len(mould.face.outline.geoms) == 2 and mould.middle == pytest.approx((0.0, 0.0))
    holder = mould.holder(thickness=1e-3, force=50.0)
    shape = mould.face.surface.mesh.triangles_center[~mould.face.rim][:, :2]
    level = np.abs(holder.surface.mesh.face_normals[:, 2]) > 0.999
    corners = holder.vertices[holder.triangles[level]]
    flat = shapely.union_all([shapely.Polygon(each[:, :2]) for each in corners])
    assert not shapely.intersects(flat, shapely.points(shape)).any()
    one = math.pi * 0.025**2 + 0.05 * 0.08
    assert 0.24**2 - flat.area == pytest.approx(2.0 * one, rel=0.35)


def test_noise_of_a_scanned_rim_is_no_shape():
    tool = dented(12e-3)
    points = tool.surface.mesh.vertices.copy()
    points[:, 2] += np.random.default_rng(3).uniform(-0.022e-3, 0.022e-3, len(points))
    mesh = trimesh.Trimesh(points, tool.surface.mesh.faces, process=False)
    tilted = mesh.face_normals[np.abs(points[mesh.faces][..., 2]).max(axis=1) < 1.1e-4, 2]
    assert (tilted < math.cos(math.radians(1.0))).mean() > 0.005
    mould = wd.Mould.of(wd.Tool(name="mould", surface=read_surface("scan", mesh, 1.0)))
    assert isinstance(mould.face.outline, shapely.Polygon)
    low, high = np.reshape(mould.face.outline.bounds, (2, 2))
    assert (high - low).tolist() == pytest.approx([0.05, 0.13], abs=6e-3)


def test_a_holders_straight_sides_do_not_bulge():
    """Normals at its corners are the true surface's for plies: a side d that they turn along from
    n_a to n_b bulges by d·(n_b − n_a)/8."""
    outline = shapely.LineString([(-0.04, 0.0), (0.04, 0.0)]).buffer(0.025, quad_segs=16)
    cut = outline.difference(shapely.box(0.0, -0.03, 0.006, 0.0))  # with re-entrant corners
    for opening in (outline, cut):
        ring = holder_ring("holder", opening, shapely.box(-0.1, -0.1, 0.1, 0.1), up=False)
        points = ring.mesh.triangles
        sides, turn = (np.roll(a, -1, axis=1) - a for a in (points, ring.normals))
        bulge = np.abs(np.einsum("fki,fki->fk", sides, turn)) / 8.0
        assert 1e-6 < bulge.max() < 0.12e-3
