"""What contacts press on crossings of sliding yarns: forces through plies, and how they hold."""

import dataclasses

import numpy as np
import pytest
from sliding_checks import blank
from test_edge_contact import crossed
from test_engine import small_press
from test_self_contact import pressed as folded
from test_threads import Always
from test_tool_features import TOOLS
from test_tool_features import pressed as pricked

import warpdrape as wd
from warpdrape.contact.edge_contact import EdgeContact
from warpdrape.contact.ply_contact import PlyContact
from warpdrape.contact.self_contact import SelfContact
from warpdrape.contact.tool_contact import ToolContact
from warpdrape.contact.tool_features import FeatureContact
from warpdrape.dynamics import stepping
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.forces.ply_net import net_of
from warpdrape.forces.pressed_crossings import bearing
from warpdrape.forces.sliding_chains import chains_of
from warpdrape.interaction import bodies_of
from warpdrape.scenes import yarn_pull_out
from warpdrape.setup import Setup

FRICTION = 0.3


def after(scene, blocks, threads=1, together=False):
    """A scene and its state after so many blocks of steps."""
    model = build_model(scene, "cpu", frames=1)
    return model, run_on(model, initial_state(model), blocks, threads, together)


def run_on(model, state, blocks, threads=1, together=False):
    stepper = stepping.Stepper(model, state, threads)
    stepper._pace = Always(together)
    stepper.begin_frame(1)
    for _ in range(blocks):
        stepper.block()
    stepper.close()
    return state


def told(model, state):
    """Normal forces of each contact on the vertices' faces [N], by its type."""
    bodies = bodies_of(state)
    found = {}
    for thing, memory in zip(model.interactions, state.memory, strict=True):
        for rows in thing.measure(bodies, memory).pressing.values():
            found[type(thing)] = np.asarray(rows).sum(axis=0)
    return found


@pytest.mark.parametrize("threads", [1, 2])
def test_what_goes_through_a_ply_is_half_of_what_contacts_tell(threads, monkeypatch):
    """Of every contact, as its results show it by other means."""
    monkeypatch.setattr(Setup, "yarns_rub", True)
    roofs = crossed("cpu", 1e-5)
    height = roofs[0].rest.numpy()[:, 2]
    ways = np.where(height > height.mean(), -0.5, 0.5)
    roofs[1].plies.v.assign(ways[:, None] * (0.0, 0.0, 1.0))
    run_on(*roofs, 3, threads)
    blade = pricked(TOOLS["blade"], duration=0.01, travel=5e-3)
    cases = [
        ({PlyContact, ToolContact}, after(small_press(), 150, threads)),
        ({FeatureContact}, after(blade, 40, threads)),
        ({SelfContact, ToolContact}, folded("cpu", self_contact=True)[2:]),
        ({EdgeContact}, roofs),
    ]
    for kinds, (model, state) in cases:
        rows = told(model, state)
        assert all(rows[kind].sum() > 1e-4 for kind in kinds), kinds
        faces = sum(rows.values())
        through = state.pressing.through.numpy()
        np.testing.assert_allclose(through, 0.5 * faces, rtol=1e-9, atol=1e-12 * faces.max())
        assert np.abs(state.pressing.pressing.numpy()).max() == 0.0


@pytest.mark.parametrize(
    ("mesh", "warp_angle"), [("grid", 0.0), ("diagonal", 0.0), ("aligned", 0.4)]
)
def test_whatever_goes_through_a_ply_goes_through_its_crossings(mesh, warp_angle):
    ply = blank(cells=8, mesh=mesh, warp_angle=warp_angle)
    chains = chains_of(ply)
    rows = bearing(ply, chains)
    crossings = chains.areas / ply.fabric.cell_area
    np.testing.assert_allclose(crossings @ rows, 1.0, rtol=1e-12)
    even = rows @ ply.mesh.vertex_areas  # of a pressure of 1 Pa, in N
    inside = np.abs(chains.areas - chains.areas.max()) < 1e-6 * chains.areas.max()
    assert inside.any()
    if mesh != "aligned":
        np.testing.assert_allclose(even[inside], ply.fabric.cell_area, rtol=1e-9)
    assert (len(net_of(ply).carried) > 0) == (mesh != "diagonal")


def pulled(plates, force=40.0):
    """A pull-out of 0.05 mm under so many plates that press with a force [N]: force, and run."""
    scene = yarn_pull_out.build(
        length=0.04, edge=0.01, sides=1, slip_force=1.0, stiffness=2e5, travel=5e-5, duration=4e-3
    )
    ply = scene.plies[0]
    held = dataclasses.replace(ply.fabric.crossover, friction=0.1, yarn_friction=FRICTION)
    ply = dataclasses.replace(ply, fabric=dataclasses.replace(ply.fabric, crossover=held))
    half = 0.5 * ply.fabric.thickness
    tools = []
    for name, facing, way in (("low", "up", 1.0), ("top", "down", -1.0)):
        pressing = wd.Float(force=force, axis=(0.0, 0.0, way), ramp=5e-4, mass=0.02, damping=200.0)
        plate = wd.Tool.plate(name, width=0.2, height=0.2, facing=facing, motion=pressing)
        tools.append(plate.moved((0.0, 0.0, -way * half)))
    tools = tools[:plates]
    result = dataclasses.replace(scene, plies=[ply], tools=tools, friction=0.0).run(frames=20)
    assert result.completed and result.summary["energy_error"] < 1e-3
    at, work = (result.history[f"end_{name}"] for name in ("displacement_m", "work_j"))
    return np.diff(work)[-1] / np.diff(at)[-1], result


def test_a_yarn_between_plates_is_harder_to_pull_out_by_what_they_press():
    """Coulomb: μ times what goes through the bundle's crossings; the energy is closed.

    Under one plate it is half of its force: the clamp that bears it holds the yarns' middles.
    """
    bare, _ = pulled(0)
    for plates in (1, 2):
        pressed, result = pulled(plates)
        formed = result.plies[0]
        areas = np.zeros(len(formed.points))
        np.add.at(areas, formed.triangles, _third_of_areas(formed)[:, None])
        on_face = formed.tool_pressure * areas
        assert on_face.sum() == pytest.approx(40.0, rel=1e-3)
        x, y = formed.rest_points[:, :2].T
        bundle = (np.abs(y) < 1e-9) & (x < 0.041)  # its last vertex is its end, gripped
        assert 0.3 < on_face[bundle].sum() / 40.0 < 0.6
        added = FRICTION * 0.5 * plates * on_face[bundle].sum()
        assert pressed - bare == pytest.approx(added, rel=2e-3) and added > 0.01 * bare


def _third_of_areas(formed):
    a, b, c = (formed.points[formed.triangles[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6.0
