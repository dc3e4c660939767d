"""Where features that know nothing of each other meet: nets, rubber, turning tools, exports."""

import dataclasses
import json
import warnings

import numpy as np
import pytest

import warpdrape as wd
from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.cli import main
from warpdrape.contact.face_depths import FaceDepths
from warpdrape.defects.limits import Limits
from warpdrape.defects.outline import outer_loop
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.exports.export import export
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.results.judgement import judge, not_judged
from warpdrape.scenes import circular_table, diaphragm, hemisphere, three_ply_hemisphere
from warpdrape.tools.pose import Pose, pose_between, rotation


@pytest.fixture(scope="module")
def bagged(tmp_path_factory):
    """A ply under a rubber sheet, a little drawn down."""
    folder = tmp_path_factory.mktemp("bagged") / "run"
    small = {"blank_size": 0.12, "edge": 0.03, "duration": 0.01, "vacuum": 2e3, "facet": 0.01}
    scene = diaphragm.build(layup="0", diaphragms=1, **small)
    assert scene.run(folder, frames=2).completed
    return folder


def test_a_border_that_touches_itself_is_followed_to_its_end():
    """Squares in a row, corner to corner, the last one larger: none of its border is lost."""
    squares = [((0.0, 0.0), 1.0), ((1.0, 1.0), 1.0), ((2.0, 2.0), 1.5)]
    points, triangles = [], []
    for (x, y), size in squares:
        corners = [(x, y), (x + size, y), (x + size, y + size), (x, y + size)]
        for corner in corners:
            if corner not in points:
                points.append(corner)
        a, b, c, d = (points.index(corner) for corner in corners)
        triangles += [(a, b, c), (a, c, d)]
    mesh = FlatMesh(0.01 * np.array(points), np.array(triangles))
    loop = outer_loop(mesh)
    x, y = np.asarray(mesh.vertices)[loop].T
    area = 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))
    assert area >= 0.999 * 1.5**2 * 1e-4 and len(set(loop.tolist())) <= len(points)


def test_a_net_keeps_the_blank_s_edges_where_tools_go_on(tmp_path):
    scene = three_ply_hemisphere.build(cells=12, travel=0.02, approach="fishnet")
    result = scene.run(quiet=True)
    assert result.summary["warnings"] == []
    for ply, formed in zip(scene.plies, result.plies, strict=True):
        assert len(formed.triangles) == len(ply.mesh.triangles)


def test_a_net_that_covers_nothing_leaves_its_reason(tmp_path):
    tool = wd.Tool.die(hole_radius=0.004, edge_radius=0.001, outer_radius=0.008)
    ply = wd.Ply.rectangle("ply", "carbon_interlock", 0.3, cells=4)
    scene = wd.Scene(
        name="small",
        plies=[ply],
        tools=[tool.moved((0.0, 0.0, -3e-4))],
        duration=0.01,
        approach="fishnet",
    )
    with pytest.raises((wd.RunFailed, wd.InputError)) as reason:
        scene.run(tmp_path / "run", quiet=True)
    if isinstance(reason.value, wd.RunFailed):
        said = json.loads((tmp_path / "run" / "summary.json").read_text("utf-8"))
        assert said == {"status": "failed", "message": str(reason.value)}
        assert json.loads((tmp_path / "run" / "run.json").read_text("utf-8"))["scene"] == "small"


def test_a_net_says_what_it_does_not_see():
    scene = hemisphere.build(cells=6, approach="fishnet")
    held = wd.Clamp(name="held", ply="ply_0", where=lambda p: p[:, 0] < -0.14)
    air = wd.Pressure(name="air", ply="ply_0", pressure=10.0)
    seen = dataclasses.replace(scene, clamps=[held], pressures=[air]).run(quiet=True).summary
    assert "a net does not see clamps 'held' and pressures 'air'" in seen["warnings"]


def test_a_table_s_report_leaves_out_what_a_net_has_not():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = circular_table.build(cells=30, approach="fishnet").run(quiet=True)
    found = result.summary["table"]
    assert found["side_drop_m"] > 0.0
    assert all(value is None or np.isfinite(value) for value in found.values())


def test_a_net_is_not_resumed_and_has_no_phases(tmp_path, capsys):
    out = str(tmp_path / "net")
    short = ["--set", "cells=6", "--set", "approach=fishnet", "--out", out, "-q", "--profile"]
    assert main(["run", "hemisphere", *short]) == 0
    capsys.readouterr()
    for more in ([], ["--extend", "5mm"]):
        assert main(["resume", out, *more]) == 2
        assert "a fishnet's, which has no checkpoints" in capsys.readouterr().err


@pytest.mark.parametrize("to", ["inp", "dyna", "nastran", "svg", "permeability"])
def test_rubber_is_left_out_of_what_has_yarns(bagged, tmp_path, to):
    if to == "permeability":
        pytest.importorskip("pyvista")
    endings = {"inp": "inp", "dyna": "k", "nastran": "bdf", "svg": "svg", "permeability": "csv"}
    out = tmp_path / f"file.{endings[to]}"
    options = {"fibre_diameter": 7e-6} if to == "permeability" else {}
    with pytest.warns(UserWarning, match="upper left out of"):
        export(bagged, to, out, **options)
    text = out.read_text("utf-8")
    assert "upper" not in text.lower() and "ply_0" in text.lower()


def test_a_diaphragm_that_spans_the_mould_is_no_fault_of_the_part(bagged):
    result = wd.read_run(bagged)
    assert [ply["woven"] for ply in result.summary["plies"]] == [True, False]
    bridge = {"resolved": True, "gap_m": 0.02, "tool": "mould", "at_m": None, "on_blank_m": None}
    for ply in result.summary["plies"]:  # both span it: the part's own is a fault
        ply["defects"]["bridging"] = {"list": [bridge]}
    faults = judge(result.summary, result.history, Limits(wrinkle_amplitude=None))
    assert [fault.who for fault in faults if "bridges" in fault.what] == ["ply_0"]


def test_a_writer_that_stops_leaves_nothing_half_written(bagged, tmp_path, monkeypatch):
    def stop(*_):
        raise wd.InputError("stopped")

    monkeypatch.setattr("warpdrape.exports.dyna.layers", stop, raising=False)
    monkeypatch.setattr("warpdrape.results.read_run.RunReader.ply_thicknesses", stop)
    with pytest.warns(UserWarning), pytest.raises(wd.InputError, match="stopped"):
        export(bagged, "dyna", tmp_path / "file.k")
    assert list(tmp_path.iterdir()) == []


def test_the_pose_between_two_places_is_found():
    random = np.random.default_rng(1)
    for points in (random.normal(size=(20, 3)), random.normal(size=(9, 3)) * [1.0, 1.0, 0.0]):
        pose = Pose(rotation((0.6, 0.0, 0.8), 2.5), np.array([0.1, -0.2, 0.3]))
        found = pose_between(points, pose.place(points))
        np.testing.assert_allclose(found.turned, pose.turned, atol=1e-12)
        np.testing.assert_allclose(found.shift, pose.shift, atol=1e-12)
    still = pose_between(points, points + 0.5)
    np.testing.assert_array_equal(still.turned, np.eye(3))


def test_faces_are_looked_at_where_a_turned_tool_is(device):
    """A plate turned upright about its edge: a sheet that stood clear of it is cut by it."""
    turn = wd.Turn(axis=(0, 1, 0), point=(0, 0, 0), angle=[(0.0, 0.0), (1e-3, np.pi / 2)])
    ball = wd.Tool.sphere(radius=0.05, facet=4e-3, turn=turn)  # its pole is at the origin
    ply = wd.Ply.rectangle("ply", "carbon_interlock", 0.1, edge=0.02, mesh="grid", z=0.2)
    scene = wd.Scene(name="turned", plies=[ply], tools=[ball], duration=1e-3)
    model = build_model(scene, device, frames=1)
    state = initial_state(model)
    pose = Pose(rotation((0, 1, 0), np.pi / 2), np.zeros(3))
    state.tools.turned.assign(pose.turned[None])
    flat = ply.rest_points * [1.0, 1.0, 0.0]
    aside = np.array([2e-4, 0.0, 0.0])
    upright = np.c_[
        np.full(len(flat), 3e-4), flat[:, 1], flat[:, 0]
    ]  # the plane x = half of 0.6 mm
    state.plies.x.assign(upright - aside)
    at_vertices, between = FaceDepths(scene, model.spans, device).deepest(state)[0]
    assert at_vertices == pytest.approx(2e-4, abs=2e-6)  # the pole now points along x
    state.plies.x.assign(upright + aside)
    assert FaceDepths(scene, model.spans, device).deepest(state).max() == 0.0
    assert between <= 2.02e-4


def test_yarns_of_a_net_are_not_called_fit(tmp_path):
    fabric = dataclasses.replace(load_fabric("carbon_interlock"), failure_strain_warp=0.01)
    ply = wd.Ply.rectangle("ply", fabric, 0.2, cells=4)
    tools = [wd.Tool.table(radius=0.04).moved((0, 0, -3e-4))]
    scene = wd.Scene(name="net", plies=[ply], tools=tools, duration=0.01, approach="fishnet")
    summary = scene.run(quiet=True).summary
    said = not_judged(summary, Limits(yarn_strain=0.001, failed_yarn_area=0.0))
    assert any("yarn strain" in words for words in said)
    assert any("failed yarns (the approach" in words for words in said)
