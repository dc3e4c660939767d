"""Pressures and slip that results show: forces over areas, ways along the plies."""

import numpy as np
import pytest
from interaction_checks import of_kind
from pxr import Usd, UsdGeom

from warpdrape import Float, Numerics, Ply, Scene, Tool, lay_up
from warpdrape.contact.ply_contact import PlyContact
from warpdrape.contact.pressure import vertex_shapes
from warpdrape.dynamics.energy import measure
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.interaction import bodies_of
from warpdrape.materials.fabric_library import with_bending
from warpdrape.results.picture import draw_ply
from warpdrape.results.quantities import QUANTITIES
from warpdrape.results.snapshot import read_plies
from warpdrape.results.usd_reader import read_scene

FORCE, SIDE, THICKNESS = 50.0, 0.06, 6e-4


@pytest.fixture(scope="module")
def pressed(tmp_path_factory):
    """Three plies between two plates, the upper one pressed down; meshes do not match."""
    cloth = with_bending("carbon_interlock", 1e-3)
    plies = lay_up(
        [
            Ply.rectangle("low", cloth, SIDE, cells=8, mesh="grid"),
            Ply.rectangle("mid", cloth, SIDE, cells=7, mesh="random"),
            Ply.rectangle("high", cloth, SIDE, cells=6, mesh="diagonal"),
        ]
    )
    bottom = Tool.plate("bottom", width=0.2, height=0.2)
    top = Tool.plate(
        "top",
        width=0.2,
        height=0.2,
        facing="down",
        motion=Float(force=FORCE, mass=0.02, damping=20.0, ramp=2e-3),
    ).moved((0, 0, 3.001 * THICKNESS))
    folder = tmp_path_factory.mktemp("pressed") / "run"
    scene = Scene(
        name="pressed",
        plies=plies,
        tools=[bottom, top],
        duration=0.02,
        gravity=(0.0, 0.0, 0.0),
        numerics=Numerics(damping=500.0, yarn_softening=36.0),
    )
    return scene, scene.run(folder, frames=4, threads=1), folder


def area_of(ply):
    _, areas = vertex_shapes(ply.points, ply.triangles)
    assert areas.sum() == pytest.approx(SIDE**2, rel=1e-3)
    return areas


def test_a_plate_that_presses_is_felt_through_the_stack(pressed):
    _, result, _ = pressed
    for ply in result.plies:
        felt = float(ply.contact_pressure @ area_of(ply))
        assert felt == pytest.approx(FORCE, rel=0.15), ply.name  # the larger of both faces
    for name in ("low", "high"):
        ply = result.ply(name)
        assert float(ply.tool_pressure @ area_of(ply)) == pytest.approx(FORCE, rel=0.02)
    assert not result.ply("mid").tool_pressure.any()


def test_interfaces_bear_the_same_force_from_both_sides(pressed):
    _, result, _ = pressed
    entries = {(e["vertices_of"], e["on"]): e for e in result.summary["interfaces"]}
    for pair in (("low", "mid"), ("mid", "high")):
        one, other = entries[pair], entries[pair[::-1]]
        assert one["normal_force_n"] == other["normal_force_n"]
        assert one["normal_force_n"] == pytest.approx(FORCE, rel=0.02)
        for entry in (one, other):
            assert entry["mean_pressure_pa"] >= 0.98 * FORCE / SIDE**2
            assert entry["max_pressure_pa"] >= entry["mean_pressure_pa"]
    means = [entries[pair]["mean_pressure_pa"] for pair in (("low", "mid"), ("mid", "low"))]
    assert means[0] == pytest.approx(means[1], rel=0.2)


def test_the_file_holds_them_at_vertices(pressed):
    _, result, folder = pressed
    stage = Usd.Stage.Open(str(folder / "scene.usdc"))
    for ply in result.plies:
        primvars = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(f"/World/plies/{ply.name}"))
        for name, values in (
            ("contactPressure", ply.contact_pressure),
            ("toolPressure", ply.tool_pressure),
            ("slip", ply.slip),
        ):
            primvar = primvars.GetPrimvar(name)
            assert primvar.GetInterpolation() == UsdGeom.Tokens.vertex
            assert primvar.GetTimeSamples() == [0.0, 1.0, 2.0, 3.0, 4.0]
            np.testing.assert_allclose(np.array(primvar.Get(4.0)), values, rtol=1e-6, atol=1e-12)


def test_a_picture_shows_what_the_file_holds(pressed):
    _, result, folder = pressed
    quantity = QUANTITIES["contact-pressure"]
    (mid,) = read_scene(folder / "scene.usdc", ["mid"], -1, quantity).plies
    np.testing.assert_allclose(mid.values, 1e-3 * result.ply("mid").contact_pressure, rtol=1e-6)
    assert draw_ply(folder, "mid", field="contact-pressure").is_file()


def test_slip_is_the_way_along_the_ply_from_where_a_vertex_lay(pressed):
    scene, _, _ = pressed
    model = build_model(scene, "cpu", 1)
    state = initial_state(model)

    def slips():
        return [ply.slip for ply in read_plies(model, state, measure(model, state))]

    assert max(np.abs(slip).max() for slip in slips()) < 1e-12
    x = state.plies.x.numpy().copy()
    spans = [span.vertices for span in model.spans]
    way, turn = np.array([3e-3, -1e-3, 0.0]), np.array([[0.6, 0, 0.8], [0, 1, 0], [-0.8, 0, 0.6]])
    moved = x.copy()
    moved[spans[1]] += way + np.array([0.0, 0.0, 2e-4])  # the gap that opens is no slip
    state.plies.x.assign(moved @ turn.T)
    low, mid, high = (slip @ turn for slip in slips())
    np.testing.assert_allclose(low, np.broadcast_to(-way, low.shape), atol=1e-9)
    np.testing.assert_allclose(mid, np.broadcast_to(way, mid.shape), atol=1e-9)
    np.testing.assert_allclose(high, np.broadcast_to(-way, high.shape), atol=1e-9)
    contact, memory = of_kind(model, state, PlyContact)
    for entry in contact.measure(bodies_of(state), memory).entries["interfaces"]:
        for name in ("mean_net_slip_m", "max_net_slip_m"):
            assert entry[name] == pytest.approx(np.linalg.norm(way))


def test_a_vertex_that_lay_alone_has_no_slip():
    cloth = with_bending("carbon_interlock", "none")
    plies = lay_up(
        [
            Ply.rectangle("low", cloth, SIDE, cells=6, mesh="grid"),
            Ply.rectangle("high", cloth, 0.5 * SIDE, cells=3, mesh="grid"),
        ]
    )
    model = build_model(Scene(name="two", plies=plies, duration=1e-3), "cpu", 1)
    contact, _ = of_kind(model, initial_state(model), PlyContact)
    x, low = model.rest.numpy().copy(), model.spans[0].vertices
    x[low] += (1e-3, 0.0, 0.0)
    slip = contact.partners.slip(x, np.broadcast_to((0.0, 0.0, 1.0), x.shape))
    covered = np.abs(model.rest.numpy()[low, :2]).max(axis=1) < 0.2501 * SIDE
    np.testing.assert_allclose(slip[low][:, 0], np.where(covered, 1e-3, 0.0), atol=1e-12)


def test_a_single_ply_without_tools_has_none():
    ply = Ply.rectangle("ply", with_bending("carbon_interlock", "none"), SIDE, cells=3)
    result = Scene(name="alone", plies=[ply], duration=1e-4).run(frames=1)
    alone = result.ply("ply")
    assert alone.slip is None and alone.contact_pressure is None and alone.tool_pressure is None


def test_normals_and_areas_of_vertices_are_those_of_their_triangles():
    """Of each vertex: the sum of its triangles' normals by area, and thirds of their areas."""
    random = np.random.default_rng(5)
    mesh = Ply.rectangle("cloth", "carbon_interlock", 0.1, cells=3, mesh="random").mesh
    triangles = np.asarray(mesh.triangles)
    points = np.column_stack([mesh.vertices, np.zeros(len(mesh.vertices))])
    points += 0.01 * random.standard_normal(points.shape)
    normals, areas = vertex_shapes(points, triangles)
    for vertex in range(len(points)):
        round_it = triangles[(triangles == vertex).any(axis=1)]
        a, b, c = (points[round_it[:, k]] for k in range(3))
        faces = np.cross(b - a, c - a) / 2.0
        total = faces.sum(axis=0)
        np.testing.assert_allclose(normals[vertex], total / np.linalg.norm(total), atol=1e-12)
        assert areas[vertex] == pytest.approx(np.linalg.norm(faces, axis=1).sum() / 3.0)
