"""Tools: the surfaces that profiles and mesh files give, their normals, their dimensions."""

import importlib.metadata
import math
import re
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from warpdrape import Ply, Scene
from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.dynamics.model import build_model
from warpdrape.errors import InputError
from warpdrape.mesh_file import MORE
from warpdrape.numerics import Numerics
from warpdrape.tools.floating import Float
from warpdrape.tools.profile import Arc, Line, extrude, revolve
from warpdrape.tools.tool import Tool

RADIUS = 0.04


def corners(tool):
    return tool.vertices[tool.triangles]


def radial(points):
    """Unit vectors away from the z axis."""
    out = points * (1.0, 1.0, 0.0)
    return out / np.linalg.norm(out, axis=-1, keepdims=True)


def towards(points, centers):
    return (points - centers) / np.linalg.norm(points - centers, axis=-1, keepdims=True)


def sphere_normals(p):
    return towards(p, np.array([0.0, 0.0, -RADIUS]))


def punch_normals(p):
    low = p[..., 2:] < RADIUS
    return np.where(low, towards(p, np.array([0.0, 0.0, RADIUS])), radial(p))


def ring_normals(p, hole, edge, up):
    """A ring with a rounded hole; its wall below the rounding, its flat outside it."""
    out = radial(p)
    center = out * (hole + edge) - (0.0, 0.0, up * edge)
    r = np.linalg.norm(p[..., :2], axis=-1)[..., None]
    wall = up * p[..., 2:] < -edge * (1 + 1e-9)
    flat = r > hole + edge * (1 + 1e-9)
    return np.where(wall, -out, np.where(flat, (0.0, 0.0, up), towards(p, center)))


def table_normals(p):
    out, edge = radial(np.add(p, (1e-12, 0.0, 0.0))), 5e-3
    r = np.linalg.norm(p[..., :2], axis=-1)[..., None]
    center = out * (RADIUS - edge) - (0.0, 0.0, edge)
    flat = r < (RADIUS - edge) * (1 - 1e-9)
    wall = p[..., 2:] < -edge * (1 + 1e-9)
    return np.where(flat, (0.0, 0.0, 1.0), np.where(wall, out, towards(p, center)))


def drum_normals(p):
    return towards(p, p * (0.0, 1.0, 0.0))


TOOLS = {
    # name: tool, exact normals at points of the surface, number of open borders, box
    "punch": (
        Tool.punch(radius=RADIUS, height=0.07),
        punch_normals,
        1,
        [(-RADIUS, 0), (RADIUS, 0.07)],
    ),
    "die": (
        Tool.die(hole_radius=0.05, edge_radius=0.01, outer_radius=0.1, depth=0.03),
        lambda p: ring_normals(p, 0.05, 0.01, 1.0),
        2,
        [(-0.1, -0.03), (0.1, 0)],
    ),
    "holder": (
        Tool.blank_holder(hole_radius=0.06, outer_radius=0.1, edge_radius=2e-3),
        lambda p: ring_normals(p, 0.06, 2e-3, -1.0),
        2,
        [(-0.1, 0), (0.1, 0.01)],
    ),
    "table": (
        Tool.table(radius=RADIUS, depth=0.02),
        table_normals,
        1,
        [(-RADIUS, -0.02), (RADIUS, 0)],
    ),
    "sphere": (
        Tool.sphere(radius=RADIUS),
        sphere_normals,
        1,
        [(-RADIUS, -RADIUS * (1 + math.sqrt(0.5))), (RADIUS, 0)],
    ),
    "drum": (Tool.drum(radius=RADIUS, length=0.02), drum_normals, 2, None),
    "plate": (
        Tool.plate(width=0.06, height=0.02),
        lambda p: np.broadcast_to((0.0, 0.0, 1.0), p.shape),
        1,
        None,
    ),
    "ceiling": (
        Tool.plate(width=0.06, height=0.02, facing="down"),
        lambda p: np.broadcast_to((0.0, 0.0, -1.0), p.shape),
        1,
        None,
    ),
}


def open_borders(mesh):
    """Number of loops of edges that belong to one facet only."""
    edges = np.sort(mesh.edges, axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    assert count.max() <= 2
    single = unique[count == 1]
    labels = trimesh.graph.connected_component_labels(single, node_count=len(mesh.vertices))
    assert (np.bincount(single.ravel())[np.unique(single)] == 2).all()
    return len(np.unique(labels[single]))


@pytest.mark.parametrize("name", TOOLS)
def test_surface_is_whole_outward_and_has_exact_normals(name):
    tool, normals_at, borders, box = TOOLS[name]
    mesh, normals = tool.surface.mesh, tool.surface.normals
    assert tool.surface.exact
    assert mesh.is_winding_consistent
    assert open_borders(mesh) == borders
    assert (mesh.area_faces > 0).all()
    assert ((mesh.face_normals[:, None] * normals).sum(axis=2) > math.cos(math.radians(10))).all()
    exact = np.array(normals_at(corners(tool)))
    error = np.linalg.norm(normals - exact, axis=2)
    # Where two pieces meet in a corner (drum ends, plate rims) each keeps its own normal; all
    # profiles here are tangent where they meet, so every corner has one.
    assert error.max() < 1e-7
    if box is not None:
        (low_r, low_z), (high_r, high_z) = box
        np.testing.assert_allclose(mesh.bounds[:, 2], (low_z, high_z), atol=1e-12)
        # The sphere's equator lies between two of its rings.
        np.testing.assert_allclose(mesh.bounds[:, 0], (low_r, high_r), atol=1e-3 * high_r)


def test_hole_radii_and_box_of_plate_and_drum():
    for name, hole in (("die", 0.05), ("holder", 0.06)):
        reach = np.linalg.norm(TOOLS[name][0].vertices[:, :2], axis=1)
        assert reach.min() == pytest.approx(hole, rel=1e-12)
        assert reach.max() == pytest.approx(0.1, rel=1e-12)
    for name, size in (("drum", (2 * RADIUS, 0.02, 2 * RADIUS)), ("plate", (0.06, 0.02, 0.0))):
        np.testing.assert_allclose(TOOLS[name][0].surface.mesh.extents, size, atol=1e-12)


def test_hollow_arcs_turn_their_normals_inward():
    # A trough, drawn counter-clockwise: the open side lies to the left of the profile.
    trough = extrude([Arc((0.0, 0.0), RADIUS, math.pi, 2 * math.pi)], 0.1, 5e-3)
    points = trough.mesh.vertices[trough.mesh.faces]
    np.testing.assert_allclose(trough.normals, -drum_normals(points), atol=1e-12)
    assert ((trough.mesh.face_normals[:, None] * trough.normals).sum(axis=2) > 0.98).all()


@pytest.mark.parametrize("facet", [2e-3, 8e-3])
def test_facets_have_the_size_asked_for(facet):
    edges = Tool.sphere(radius=RADIUS, facet=facet).surface.mesh.edges_unique_length
    limit = min(facet, RADIUS * math.radians(6.0))  # an arc turns 6° a facet at most
    assert 0.8 * limit < edges.max() < 1.5 * limit  # of diagonals


def test_area_of_facets_comes_to_that_of_the_sphere():
    errors = []
    for facet in (4e-3, 2e-3, 1e-3):
        mesh = Tool.sphere(radius=RADIUS, facet=facet).surface.mesh
        exact = 2 * math.pi * RADIUS**2 * (1 + math.sqrt(0.5))
        errors.append(1 - mesh.area / exact)
    assert 0 < errors[2] < 1e-3
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.1)


HOLDER = {"hole_radius": 0.06, "outer_radius": 0.1, "edge_radius": 2e-3}


def test_sectors_of_a_holder_make_the_whole_ring():
    whole = Tool.blank_holder(**HOLDER)
    quarters = [
        Tool.blank_holder(**HOLDER, sector=(math.pi / 2 * k, math.pi / 2 * (k + 1)))
        for k in range(4)
    ]
    areas = [part.surface.mesh.area for part in quarters]
    assert sum(areas) == pytest.approx(whole.surface.mesh.area, rel=1e-3)
    assert np.ptp(areas) < 1e-9 * areas[0]
    middle = quarters[1].surface.mesh.triangles_center
    assert (middle[:, 0] < 0.0).all() and (middle[:, 1] > 0.0).all()
    assert quarters[0].surface.normals[..., 2].min() == pytest.approx(-1.0)


def test_each_segment_of_a_holder_presses_with_its_own_force(device):
    """A ply on a plate under three segments: each bears its force, and the plate all of them."""
    ply = Ply.rectangle("ply", "carbon_interlock", 0.22, cells=22)
    half = 0.5 * ply.fabric.thickness
    forces = (30.0, 10.0, 20.0)
    segments = [
        Tool.blank_holder(
            f"segment_{k}",
            **HOLDER,
            sector=(2.1 * k, 2.1 * k + 2.0),
            motion=Float(force=force, mass=0.3, ramp=2e-3),
        ).moved((0.0, 0.0, half))
        for k, force in enumerate(forces)
    ]
    table = Tool.plate(name="table", width=0.4, height=0.4).moved((0.0, 0.0, -half))
    scene = Scene(name="held", plies=[ply], tools=[table, *segments], duration=12e-3)
    history = scene.run(device=device, frames=6).history
    for k, force in enumerate(forces):
        assert history[f"segment_{k}_force_n"][-1] == pytest.approx(force, rel=0.02)
    weight = ply.fabric.areal_density * 0.22**2 * 9.81
    assert history["table_force_n"][-1] == pytest.approx(sum(forces) + weight, rel=0.02)


def pressed_plies(mass, **numerics):
    ply = Ply.rectangle("ply", "carbon_interlock", 0.22, cells=4)
    press = Float(force=10.0, mass=mass)
    holder = Tool.blank_holder(**HOLDER, motion=press).moved((0.0, 0.0, 0.5 * ply.fabric.thickness))
    other = replace(ply, name="other", z=-ply.fabric.thickness)
    numerics = Numerics(**numerics)
    return Scene(name="press", plies=[other, ply], tools=[holder], duration=1e-3, numerics=numerics)


@pytest.mark.parametrize("step", [None, 1e-4])
def test_a_floating_tool_weighs_like_the_plies_with_what_scaling_added(step):
    scene = pressed_plies(None, minimum_time_step=step)
    model = build_model(scene, "cpu", 1)
    ply = scene.plies[0]
    alone = 2.0 * ply.fabric.areal_density * 0.22**2
    assert bool(model.masses.mass.sum() > 1.5 * alone) is (step is not None)
    assert model.floating.mass.numpy().tolist() == [model.masses.mass.sum()]
    own = build_model(pressed_plies(0.7), "cpu", 1)
    assert own.floating.mass.numpy().tolist() == [0.7]


def test_a_tool_too_light_to_float_is_refused_and_the_advice_runs():
    with pytest.raises(InputError, match=r"mass = 0\.001 kg is too light to float") as refused:
        pressed_plies(1e-3).run(frames=1)
    least = float(str(refused.value).split("give it ")[1].split(" kg")[0])
    assert pressed_plies(1.001 * least).run(frames=1).completed


def test_moved_and_turned_tools_keep_their_normals():
    tool = TOOLS["punch"][0]
    there = tool.moved((0.1, 0.2, 0.3))
    np.testing.assert_allclose(there.vertices, np.add(tool.vertices, (0.1, 0.2, 0.3)), atol=1e-15)
    assert there.surface.normals is tool.surface.normals
    turned = tool.turned((0.0, 1.0, 0.0), math.pi / 2)  # z goes to x
    np.testing.assert_allclose(turned.vertices[:, 0], tool.vertices[:, 2], atol=1e-15)
    np.testing.assert_allclose(
        turned.surface.normals[..., 0], tool.surface.normals[..., 2], atol=1e-15
    )
    facing = (turned.surface.mesh.face_normals[:, None] * turned.surface.normals).sum(axis=2)
    assert (facing > 0.98).all()


def test_corners_of_a_box_stay_sharp_and_a_ball_is_smooth():
    box = Tool.from_mesh("box", trimesh.creation.box((0.1, 0.2, 0.3)))
    expected = np.repeat(box.surface.mesh.face_normals[:, None], 3, axis=1)
    np.testing.assert_allclose(box.surface.normals, expected, atol=1e-12)
    assert not box.surface.exact
    ball = Tool.from_mesh("ball", trimesh.creation.icosphere(subdivisions=3, radius=0.1))
    radial_normals = corners(ball) / np.linalg.norm(corners(ball), axis=2, keepdims=True)
    assert np.linalg.norm(ball.surface.normals - radial_normals, axis=2).max() < 0.01
    by_facet = ball.surface.mesh.face_normals[:, None] - radial_normals
    assert np.linalg.norm(by_facet, axis=2).max() > 0.05


def test_rim_of_a_cylinder_is_sharp_but_its_side_smooth():
    tool = Tool.from_mesh("can", trimesh.creation.cylinder(radius=0.05, height=0.1, sections=60))
    caps = np.abs(tool.surface.mesh.face_normals[:, 2]) > 0.5
    np.testing.assert_allclose(np.abs(tool.surface.normals[caps][..., 2]), 1.0, atol=1e-12)
    side = tool.surface.normals[~caps]
    np.testing.assert_allclose(side, radial(corners(tool)[~caps]), atol=0.03)
    facets = tool.surface.mesh.face_normals[~caps][:, None]
    assert np.abs(side - facets).max() > 0.04  # not those of the flat facets


def test_mesh_files_come_with_a_scale(tmp_path):
    path = tmp_path / "box.stl"
    trimesh.creation.box((100.0, 200.0, 300.0)).export(path)
    tool = Tool.from_mesh("box", path, scale=1e-3, friction=0.1, motion=Float(force=10.0))
    np.testing.assert_allclose(tool.surface.mesh.extents, (0.1, 0.2, 0.3), rtol=1e-6)
    assert len(tool.vertices) == 8  # an STL repeats them
    assert tool.friction == 0.1 and isinstance(tool.motion, Float)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Tool.punch(radius=-1.0), "punch radius = -1.0"),
        (lambda: Tool.punch(radius=0.1, height=0.05), "punch height .* exceed"),
        (lambda: Tool.die(hole_radius=0.1, edge_radius=0.01, outer_radius=0.1), "die outer_radius"),
        (lambda: Tool.plate(width=0.1, height=0.1, facing="left"), "'up' or 'down'"),
        (lambda: Tool.table(radius=0.1, edge_radius=0.2), "edge_radius = 0.2"),
        (lambda: Tool.drum(radius=float("nan"), length=1.0), "drum radius = nan must be finite"),
        (lambda: Tool.plate("no name", width=1.0, height=1.0), "plain identifier"),
        (lambda: Tool.plate(width=1.0, height=1.0, friction=-0.1), "friction = -0.1"),
        (lambda: Tool.plate(width=1.0, height=1.0, motion=3), "not a motion"),
        (lambda: Tool.from_mesh("it", "missing.stl"), "no mesh file 'missing.stl'"),
        (lambda: Tool.from_mesh("it", trimesh.Trimesh()), "no facets"),
        (lambda: Tool.from_mesh("it", trimesh.creation.box(), scale=0.0), "scale = 0.0"),
        (
            lambda: Tool.from_mesh(
                "it",
                trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]], process=False),
            ),
            "NaN",
        ),
        (
            lambda: Tool.from_mesh(
                "it", trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], process=False)
            ),
            "zero area",
        ),
        (lambda: revolve([Line((-0.1, 0.0), (0.1, 0.0))], 0.01), "cross the axis"),
        (
            lambda: extrude([Line((0, 0), (1, 0)), Arc((0, 0), 2.0, 0.0, 1.0)], 1.0, 0.1),
            "does not start where",
        ),
        (lambda: Tool.blank_holder(**HOLDER, sector=(0.0, 90.0)), "less than a whole turn, in rad"),
        (lambda: Tool.blank_holder(**HOLDER, sector=(1.0, 0.5)), "must rise"),
        (lambda: Tool.blank_holder(**HOLDER, sector=1.0), "must be two angles"),
    ],
)
def test_bad_tools_are_refused(make, words):
    with pytest.raises(InputError, match=words):
        make()


def test_unreadable_mesh_file_is_refused(tmp_path):
    path = tmp_path / "broken.stl"
    path.write_bytes(b"\xff" * 100)
    with pytest.raises(InputError, match=r"cannot read .*broken\.stl"):
        Tool.from_mesh("it", path)


def test_the_remedy_for_other_formats_brings_their_packages():
    brought = " ".join(r for r in importlib.metadata.requires("trimesh") if "easy" in r)
    assert MORE == "trimesh[easy]"
    for package in ("networkx", "lxml", "pycollada"):
        assert re.search(rf"\b{package}\b", brought)


def test_a_3mf_file_is_read_where_its_packages_are(tmp_path):
    for package in ("networkx", "lxml"):
        pytest.importorskip(package)
    ball = trimesh.creation.icosphere(2, radius=0.05)
    ball.export(tmp_path / "ball.3mf")
    assert Tool.from_mesh("ball", tmp_path / "ball.3mf").triangles.shape == ball.faces.shape


@pytest.mark.parametrize(
    ("raised", "words"),
    [
        (
            ModuleNotFoundError("No module", name="networkx"),
            r"\.3mf files need the Python package 'networkx': pip install 'trimesh\[easy\]', or ",
        ),
        (
            ImportError("missing `pip install x`"),
            r"need one more package \(missing `pip install x`",
        ),
        (ValueError("odd header"), "odd header; save it as STL, OBJ, PLY, OFF or GLB"),
    ],
)
def test_why_a_file_cannot_be_read_is_said_with_the_remedy(raised, words, tmp_path, monkeypatch):
    def fail(*_, **__):
        raise raised

    monkeypatch.setattr(trimesh, "load", fail)
    monkeypatch.setattr(trimesh, "load_mesh", fail)
    path = tmp_path / "part.3mf"
    path.write_bytes(b"x")
    for read in (lambda: Tool.from_mesh("it", path), lambda: FlatMesh.from_file(path)):
        with pytest.raises(InputError, match=words):
            read()
