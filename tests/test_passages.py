"""What passes between the vertices of a ply all the same is refused, or fails the run."""

import numpy as np
import pytest
import trimesh

from warpdrape import InputError, Ply, Scene, Stroke, Tool
from warpdrape.contact.passages import Passages
from warpdrape.dynamics.model import build_model, initial_state

HALF = 0.3e-3


def pressed(mesh, travel, edge=0.03, at=(0.013, 0.007), duration=0.03):
    """A tool that starts 0.1 mm above a sheet held by a ring, and is pressed down."""
    sheet = Ply.rectangle("sheet", "carbon_interlock", 0.24, edge=edge, mesh="grid")
    low = mesh.vertices[:, 2].min()
    motion = Stroke(travel=(0.0, 0.0, -travel), duration=duration)
    pin = Tool.from_mesh("pin", mesh, motion=motion).moved((*at, HALF + 1e-4 - low))
    ring = Tool.die(hole_radius=0.09, edge_radius=0.01, outer_radius=0.2).moved((0, 0, -HALF))
    return Scene(name="pin", plies=[sheet], tools=[pin, ring], duration=duration)


def gutter(width, angle=0.0):
    """A narrow trough of 90 degrees, blunt side down, turned about its length."""
    turns = np.radians(np.linspace(-45.0, 45.0, 7))
    radius = width / (2.0 * np.sin(turns[-1]))
    section = radius * np.stack([np.sin(turns), -np.cos(turns)], axis=1)
    points = [(x, y, z) for x, z in section for y in (-0.03, 0.03)]
    facets = [f for k in range(0, 12, 2) for f in ([k, k + 1, k + 2], [k + 2, k + 1, k + 3])]
    mesh = trimesh.Trimesh(points, facets, process=False)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(angle, (0.0, 1.0, 0.0)))
    return mesh


@pytest.mark.parametrize("angle", [0.0, 0.1])
def test_a_narrow_surface_that_would_pass_unfelt_is_refused_and_the_advice_cures_it(angle):
    narrow = gutter(6e-3, angle)
    with pytest.raises(InputError, match=r"'pin' is an open surface 6.* mm wide .* ply 'sheet', "):
        pressed(narrow, 0.01).run(frames=4, quiet=True)
    finer = pressed(narrow, 0.01, edge=5.5e-3, duration=0.005).run(frames=4, quiet=True)
    box = trimesh.creation.box((6e-3, 0.06, 6e-3))
    solid = pressed(box, 0.01, duration=0.01).run(frames=4, quiet=True)
    for felt in (finer, solid):
        assert felt.completed
        assert felt.plies[0].points[:, 2].min() < -7e-3  # pushed down
        assert felt.summary["tools"][0]["max_force_n"] > 0.01


def test_a_tool_that_goes_through_at_once_fails_the_run_with_the_place(monkeypatch):
    none = lambda scene: [np.zeros((0, 3)) for _ in scene.tools]  # noqa: E731
    for where in ("tool_features.points_of", "features.points_of"):
        monkeypatch.setattr(f"warpdrape.contact.{where}", none)
    pin = trimesh.creation.cylinder(3e-3, 0.05)
    head = trimesh.creation.cylinder(0.04, 0.01)
    head.apply_translation((0.0, 0.0, 0.03))
    result = pressed(trimesh.util.concatenate([pin, head]), 0.04).run(frames=12, quiet=True)
    assert result.summary["status"] == "failed"
    message = result.summary["message"]
    assert message.startswith("tool 'pin' passed through ply 'sheet' by ")
    assert "refine the ply there" in message
    assert len(result.history["time_s"]) >= 2  # what was good is kept


def test_depth_is_that_of_the_tip_beyond_the_sheet(device):
    ball = trimesh.creation.icosphere(4, 0.03)
    scene = pressed(ball, 0.06, edge=0.012, at=(0.0, 0.0))
    model = build_model(scene, device, 4)
    state = initial_state(model)
    sought = Passages(scene, model.spans, device)
    assert sought.deepest(state) is None
    for depth, seen in ((0.006, False), (0.01, True)):
        shift = np.zeros((2, 3))
        shift[0, 2] = -(depth + HALF + 1e-4)
        state.tools.shift.assign(shift)
        found = sought.deepest(state)
        assert (found is not None) == seen
    assert (found.tool, found.ply) == (0, 0)
    assert found.depth == pytest.approx(0.01, abs=2e-4)
    assert found.side == pytest.approx(0.012, rel=1e-6)


def test_what_lies_beside_the_ply_s_border_has_not_passed_through_it(device):
    """A box reaches 60 mm beyond the border of a sheet that lies 0.2 mm in its top."""
    sheet = Ply.rectangle("sheet", "carbon_interlock", 0.1, edge=0.025, mesh="grid")
    wide = trimesh.creation.box((0.22, 0.22, 0.05))
    box = Tool.from_mesh("box", wide).moved((0.0, 0.0, -0.025))
    scene = Scene(name="bed", plies=[sheet], tools=[box], duration=0.01)
    model = build_model(scene, device, 1)
    state = initial_state(model)
    x = state.plies.x.numpy()
    x[:, 2] = -2e-4
    state.plies.x.assign(x)
    looked = Passages(scene, model.spans, device)
    assert looked.deepest(state) is None
    x[:, 2] = -0.02  # the whole of it now lies deep in the box
    state.plies.x.assign(x)
    assert looked.deepest(state).depth == pytest.approx(0.02, rel=1e-3)
