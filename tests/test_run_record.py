"""The record of a run: what a reader needs to understand it, in ``run.json``."""

import json
from dataclasses import replace

import numpy as np
import pytest

from warpdrape import Clamp, Float, InputError, Ply, Scene, Stroke, Tool, lay_up
from warpdrape.commands.scene_library import find_script
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.scenes import hemisphere, picture_frame

FABRIC = load_fabric("carbon_interlock")


def small(name="ply_0", fabric=FABRIC):
    return Ply.rectangle(name, fabric, 0.1, cells=2, mesh="grid")


def record_of(scene, folder):
    scene.run(folder, frames=1)
    return json.loads((folder / "run.json").read_text(encoding="utf-8"))


def test_clamps_with_what_they_hold_and_where_it_goes(tmp_path):
    pull = Stroke(travel=(0.0, 1e-4, 0.0), duration=1e-4)
    upper = Clamp(
        name="upper",
        ply="ply_0",
        where=lambda p: p[:, 1] > 0.049,
        motion=pull,
        follow=(0.0, 1.0, 0.0),
    )
    scene = Scene(name="pull", plies=[small()], clamps=[upper], duration=1e-4)
    (clamp,) = record_of(scene, tmp_path)["clamps"]
    assert (clamp["name"], clamp["ply"], clamp["vertices"]) == ("upper", "ply_0", 3)
    np.testing.assert_allclose(clamp["between_m"], [[-0.05, 0.05, 0.0], [0.05, 0.05, 0.0]])
    assert (clamp["motion"]["type"], clamp["motion"]["travel"]) == ("Stroke", [0.0, 1e-4, 0.0])
    assert clamp["follow"] == [0.0, 1.0, 0.0]
    assert clamp["matrix_at_end"] is None and clamp["travel_at_end_m"] is None


def test_functions_of_time_as_they_end(tmp_path):
    scene = picture_frame.build(edge=0.05, shear_angle_deg=30.0, duration=2e-3)
    (clamp,) = record_of(scene, tmp_path)["clamps"]
    half = np.radians(15.0)  # a frame sheared by γ is turned by γ/2 at either hinge
    expected = [[np.cos(half), np.sin(half), 0], [np.sin(half), np.cos(half), 0], [0, 0, 1]]
    np.testing.assert_allclose(clamp["matrix_at_end"], expected, atol=1e-12)
    # The diagonal of the square of side 0.1 m grows to 2 · 0.1 m · cos 30°.
    assert clamp["travel_at_end_m"] == pytest.approx(0.2 * np.cos(np.pi / 6) - 0.1 * np.sqrt(2.0))


def test_each_tool_has_its_own_friction(tmp_path):
    (ply,) = lay_up([small()])
    tools = [
        Tool.table(radius=0.02, edge_radius=2e-3, friction=0.05).moved((0.0, 0.0, -0.01)),
        Tool.plate(width=0.2, height=0.2, facet=0.2).moved((0.0, 0.0, -0.05)),
    ]
    scene = Scene(name="two", plies=[ply], tools=tools, duration=1e-5, friction=0.3)
    frictions = {t["name"]: t["friction"] for t in record_of(scene, tmp_path)["tools"]}
    assert frictions == {"table": 0.05, "plate": 0.3}


def test_what_floating_tools_weigh_is_told_as_it_acts(tmp_path):
    (ply,) = lay_up([small()])
    plate = Tool.plate("table", width=0.2, height=0.2, facet=0.2).moved((0.0, 0.0, -0.05))
    light = Tool.plate("light", width=0.2, height=0.2, facet=0.2, motion=Float(force=1.0))
    heavy = replace(light, name="heavy", motion=Float(force=1.0, mass=0.5))
    tools = [plate, light.moved((0.0, 0.0, -0.1)), heavy.moved((0.0, 0.0, -0.2))]
    scene = Scene(name="floats", plies=[ply], tools=tools, duration=1e-5)
    masses = record_of(scene, tmp_path)["floating_mass_kg"]
    own = pytest.approx(FABRIC.areal_density * 0.1**2)
    assert masses == {"light": own, "heavy": 0.5}


def test_fabrics_that_differ_are_kept_apart_under_one_name(tmp_path):
    heavy = replace(FABRIC, areal_density=0.7)
    plies = lay_up([small("a"), small("b", heavy), small("c")])
    record = record_of(Scene(name="mixed", plies=plies, duration=1e-5), tmp_path)
    used = [record["fabrics"][ply["fabric"]]["areal_density"] for ply in record["plies"]]
    assert used == [0.63, 0.7, 0.63]
    assert len(record["fabrics"]) == 2


def test_a_fabric_made_in_python_is_named_as_the_parameter_that_it_was(tmp_path):
    cloth = replace(load_fabric("carbon_interlock"), name="mine")
    scene = hemisphere.build(fabric=cloth, cells=4, duration=1e-3, travel=0.002)
    scene.run(tmp_path, frames=1, quiet=True)
    record = json.loads((tmp_path / "run.json").read_text("utf-8"))
    assert record["parameters"]["fabric"] == "mine" and "mine" in record["fabrics"]


def test_the_script_is_named_where_it_is_not_bundled(tmp_path):
    path = tmp_path / "own.py"
    path.write_text(
        "from warpdrape import Ply, Scene\n\n\n"
        "def build(*, size: float = 0.1) -> Scene:\n"
        "    ply = Ply.rectangle('p', 'carbon_interlock', size, cells=2)\n"
        "    return Scene(name='own', plies=[ply], duration=1e-5)\n"
    )
    record = record_of(find_script(path).make(["size=0.2"]), tmp_path / "out")
    assert record["script"] == str(path)
    assert record["parameters"] == {"size": 0.2}
    assert find_script("hemisphere").make(["cells=4"]).script == ""


def test_a_clamp_that_leads_nowhere_is_refused():
    def stretch(time):
        return np.sqrt(1.0 - time / 1e-4)[..., None, None] * np.eye(3)

    lead = Clamp(name="lead", ply="ply_0", where=[0], matrix=stretch)
    scene = Scene(name="s", plies=[small()], clamps=[lead], duration=2e-4)
    with np.errstate(invalid="ignore"), pytest.raises(InputError, match=r"not finite at 0.102 ms"):
        scene.run()
