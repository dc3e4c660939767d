"""Forces of tools on plies: penalty, friction, and the energy that they leave alone."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from tool_search_checks import CLOTH, HALF

from warpdrape.blanks.ply import Ply
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.stepping import Stepper
from warpdrape.numerics import Numerics
from warpdrape.scene import Scene
from warpdrape.scenes import hemisphere
from warpdrape.setup import Clamp
from warpdrape.tools import profile
from warpdrape.tools.motion import Stroke
from warpdrape.tools.tool import Tool

IN = Stroke(travel=(2.5e-3, 0.0, 0.0), duration=4e-3)
"""Of a ply that is led under a plate."""


@pytest.mark.parametrize("share", [0.02, 0.1])
def test_a_pressed_vertex_feels_penalty_off_half_the_thickness(share, device):
    tool = Tool.plate(width=1.0, height=1.0)
    ply = Ply.rectangle("ply", CLOTH, 0.01, cells=2, z=1.0)
    numerics = Numerics(contact_share=share, contact_damping=0.0, search_slide=1e-9)
    scene = Scene(
        name="press",
        plies=[ply],
        tools=[tool],
        duration=1e-4,
        numerics=numerics,
        gravity=(0.0, 0.0, 0.0),
    )
    model = build_model(scene, device, 1)
    assert model.timing.search_every == 1
    for depth in (1e-6, 2e-6, -1e-9):
        state = initial_state(model)
        x = ply.rest_points * (1.0, 1.0, 0.0) + (0.0, 0.0, HALF - depth)  # flat: no membrane force
        stepper = Stepper(model, state)
        state.plies.x.assign(x)
        stepper.begin_frame(1)
        stepper.block()
        force = model.masses.mass * state.plies.v.numpy()[:, 2] / model.timing.time_step
        expected = share * model.masses.mass / model.timing.time_step**2 * max(depth, 0.0)
        np.testing.assert_allclose(force, expected, rtol=1e-8, atol=1e-20)
        np.testing.assert_allclose(state.plies.v.numpy()[:, :2], 0.0, atol=1e-6 * abs(depth) / 1e-6)
        pushed = state.tools.impulse.numpy()[0]
        np.testing.assert_allclose(pushed, (0.0, 0.0, -expected.sum()), rtol=1e-8, atol=1e-15)


def test_friction_of_a_slipping_vertex_opposes_slip_and_obeys_coulomb(device):
    tool = Tool.plate(width=1.0, height=1.0, friction=0.25)
    ply = Ply.rectangle("ply", CLOTH, 0.01, cells=2, z=1.0)
    numerics = Numerics(contact_damping=0.0, search_slide=1e-9)
    scene = Scene(
        name="rub",
        plies=[ply],
        tools=[tool],
        duration=1e-4,
        numerics=numerics,
        gravity=(0.0, 0.0, 0.0),
    )
    model = build_model(scene, device, 1)
    state = initial_state(model)
    state.plies.x.assign(ply.rest_points * (1.0, 1.0, 0.0) + (0.0, 0.0, HALF - 1e-7))
    velocity = np.array([3.0, -4.0, 0.0])
    state.plies.v.assign(np.broadcast_to(velocity, (len(ply.rest_points), 3)))
    stepper = Stepper(model, state)
    stepper.begin_frame(1)
    stepper.block()
    force = model.masses.mass[:, None] * (state.plies.v.numpy() - velocity) / model.timing.time_step
    normal = (
        model.scene.numerics.contact_share * model.masses.mass / model.timing.time_step**2 * 1e-7
    )
    expected = normal[:, None] * (-0.25 * 0.6, 0.25 * 0.8, 1.0)
    np.testing.assert_allclose(force, expected, rtol=1e-6)
    lost = state.plies.lost.numpy()
    slid = 5.0 * model.timing.time_step
    work = 0.25 * normal * slid
    # The spring was slack before: half of its force acted over the step's mean.
    assert (lost[:, 0] > 0.45 * work).all() and (lost[:, 0] < 1.01 * work).all()


@pytest.mark.parametrize("beside", [0.05, 0.2])
def test_a_ply_that_comes_from_aside_meets_a_border_without_a_jump(beside):
    """Led under a plate that it overlaps, a ply is pushed back by as much as leads it.

    A plate that went on flat beyond its border would push at once as deep as the ply overlaps.
    """
    ply = Ply.rectangle("ply", CLOTH, 0.01, cells=2)
    led = Clamp(name="all", ply="ply", where=lambda p: p[:, 0] < 1.0, motion=IN)
    plate = Tool.plate("plate", width=0.04, height=0.04, facing="down")
    scene = Scene(
        name="aside",
        plies=[ply],
        clamps=[led],
        tools=[plate.moved((0.0262, 0.0, HALF * (1.0 - beside)))],
        duration=4e-3,
        friction=0.0,
        gravity=(0.0, 0.0, 0.0),
        self_contact=False,
        numerics=Numerics(search_slide=2e-5),
    )
    history = scene.run(frames=40).history
    pressed = history["contact_j"].max()
    assert pressed > 5e-6
    assert history["unbalanced_j"].max() < 1e-3 * pressed  # nothing from nowhere
    # Planes that serve for a way of the size of the edge lose some: half as much in half the way.
    assert history["unbalanced_j"].min() > -0.3 * pressed


def test_a_press_with_coarse_facets_makes_no_energy(monkeypatch):
    """Facets that turn by 17° from one to the next, without the true surface's normals."""
    monkeypatch.setattr(profile, "FACET_ANGLE", np.radians(17.0))
    scene = hemisphere.build(cells=12, duration=0.02, facet=22e-3)
    tools = [
        replace(tool, surface=Tool.from_mesh(tool.name, tool.surface.mesh).surface)
        for tool in scene.tools
    ]
    result = replace(scene, tools=tools).run(frames=4)
    assert result.completed and result.summary["energy_error"] < 5e-3


def test_a_sharp_box_below_a_ply_touches_nothing():
    """1 mm below it, with an edge between two rows of vertices: free fall until then."""
    ply = Ply.rectangle("ply", CLOTH, 0.1, cells=5, z=1e-3 + HALF)
    solid = trimesh.creation.box(extents=(0.12, 0.12, 0.05))
    box = Tool.from_mesh("box", solid).moved((-0.055, 0.0, -0.025))
    result = Scene(name="box", plies=[ply], tools=[box], duration=0.01).run(frames=2)
    assert result.completed and np.abs(result.history["box_force_n"]).max() == 0.0
    assert result.plies[0].points[:, 2] == pytest.approx(ply.z - 0.5 * 9.81 * 1e-4, abs=1e-6)
