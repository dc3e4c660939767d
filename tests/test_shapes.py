"""Scenes of the benchmark shapes, coarse: sound, as symmetric as they are, refused where unfit."""

import dataclasses
import inspect

import numpy as np
import pytest
from contact_oracle import heights

from warpdrape.commands.scene_library import find_script
from warpdrape.errors import InputError
from warpdrape.scenes import double_dome, prism, square_box, tetrahedron
from warpdrape.scenes.pressed_shape import Press

SHAPES = {
    "square_box": square_box,
    "tetrahedron": tetrahedron,
    "prism": prism,
    "double_dome": double_dome,
}
FORCE = 100.0
DEEPEST = 1e-4  # a sixth of the thickness; contacts of fast runs are soft
COARSE = {"cells": 20}


@pytest.mark.parametrize("name", SHAPES)
def test_a_coarse_shape_is_sound(name):
    scene = SHAPES[name].build(**COARSE)
    result = scene.run(frames=6, threads=1)
    summary = result.summary
    assert summary["status"] == "completed", summary["message"]
    assert summary["energy_error"] < 0.02
    assert summary["max_penetration_m"] < DEEPEST
    tools = {tool["name"]: tool for tool in summary["tools"]}
    assert tools["holder"]["force_n"] == pytest.approx(FORCE, rel=0.02)  # it does not hammer
    # what pushes down pushes on the die, but for the ply's weight of 0.6 N and its inertia
    down = tools["punch"]["force_n"] + FORCE
    assert tools["die"]["force_n"] == pytest.approx(down, rel=0.1)
    (ply,) = result.plies
    depth = scene.parameters["travel"]
    # half a thickness under the punch's lowest point; under a flat bottom inertia lets it sag
    assert ply.points[:, 2].min() == pytest.approx(-depth, abs=6e-3)
    assert 20.0 < ply.max_shear_deg < 75.0
    assert_symmetric(name, ply)
    punch = scene.tools[0]
    moved = punch.vertices[punch.triangles] - (0.0, 0.0, depth)
    above = heights(ply.points, moved)
    assert np.nanmin(above[np.abs(above) < 2e-3]) > 3e-4 - 5e-5  # half a thickness, less 0.05 mm


def assert_symmetric(name, ply):
    """Draw-in and yarns mirror as the tools do, within what rounding and contact leave."""
    half = (np.ptp(ply.rest_points[:, 0]) / 2, np.ptp(ply.rest_points[:, 1]) / 2)
    ends = [
        np.abs(ply.rest_points[:, k] - side * half[k]) < 1e-9 for k in (0, 1) for side in (1, -1)
    ]
    drawn = [
        side * (ply.rest_points[end, k] - ply.points[end, k]).mean()
        for end, (k, side) in zip(ends, [(k, s) for k in (0, 1) for s in (1, -1)], strict=True)
    ]
    right, left, up, down = drawn
    assert min(drawn) > 1e-3
    assert up == pytest.approx(down, rel=0.1)
    if name != "tetrahedron":  # its edge along +x has a face opposite
        assert right == pytest.approx(left, rel=0.05)
    if name == "square_box":  # the two yarn families differ by 4 % in stiffness
        assert right == pytest.approx(up, rel=0.05)


@pytest.mark.parametrize("name", SHAPES)
def test_all_shapes_take_what_a_press_takes(name):
    script = find_script(name)
    shared = [field.name for field in dataclasses.fields(Press)]
    assert list(script.parameters)[-len(shared) :] == shared
    assert all(
        parameter.unit for parameter in script.parameters.values() if parameter.kind is float
    )
    assert all(parameter.description for parameter in script.parameters.values())
    assert script.read_settings(["travel=40mm", "fast=yes", "layup=0/45"]) == {
        "travel": 0.04,
        "fast": True,
        "layup": "0/45",
    }
    scene = script.make(["layup=0/45/90", "cells=6"])
    assert [np.degrees(ply.warp_angle) for ply in scene.plies] == pytest.approx([0.0, 45.0, 90.0])
    assert set(scene.parameters) == set(script.parameters)
    assert inspect.signature(SHAPES[name].build).parameters["cells"].default in (30, 40)


def test_a_stack_finds_room_between_punch_and_die():
    one, three = (square_box.build(layup=layup, cells=4) for layup in ("0", "0/0/0/0"))
    walls = [
        scene.tools[1].vertices[scene.tools[1].vertices[:, 2] < -0.02] for scene in (one, three)
    ]
    wide = [np.abs(wall[:, 0]).max() for wall in walls]
    assert wide == pytest.approx([0.078, 0.075 + 1.5 * 4 * 6e-4])


def test_tools_hold_the_whole_blank():
    for build in (module.build for module in SHAPES.values()):
        scene = build(cells=4)
        blank = np.linalg.norm(scene.plies[0].rest_points[:, :2], axis=1).max()
        for tool in scene.tools[1:]:
            rim = np.linalg.norm(tool.vertices[:, :2], axis=1)
            assert rim.max() > blank + 5e-3


@pytest.mark.parametrize(
    ("module", "given", "message"),
    [
        (square_box, {"blank_length": 0.15}, "blank_length = 0.15 m must exceed the die's opening"),
        (square_box, {"side": 0.5}, "blank_length = 0.3 m must exceed the die's opening"),
        (double_dome, {"blank_width": 0.1}, "blank_width = 0.1 m must exceed"),
        (square_box, {"corner_radius": 0.01}, "over a corner of radius 0.01 m"),
        (double_dome, {"travel": 0.03}, "travel = 0.03 m must be at least"),
        (tetrahedron, {"slope_deg": 90.0}, "must lie between 0° and 90°"),
        (prism, {"layup": "0;45"}, "must be angles in degrees"),
        (prism, {"fabric": "none_such"}, "none_such"),
        (tetrahedron, {"travel": -0.01}, "travel"),
        (
            square_box,
            {"travel": 75.0},
            "travel = 75 m must not exceed the blank's 0.3 m: give metres",
        ),
        (double_dome, {"waist": 0.06}, "waist = 0.06 m must not exceed the ends' radius"),
        (square_box, {"clearance": -1.0}, "clearance = -1.0 m must be"),
        (square_box, {"blank_width": 0.0}, "blank_width = 0.0 m"),
    ],
)
def test_presses_that_cannot_be_are_refused(module, given, message):
    with pytest.raises(InputError, match=message):
        module.build(**given)


@pytest.mark.parametrize("plies", [1, 4, 8])
@pytest.mark.parametrize("name", SHAPES)
def test_every_shape_takes_a_stack_as_it_comes(name, plies):
    """The double dome's own travel is longer where the stack asks for it, as one given must be."""
    build, stack = SHAPES[name].build, "/".join(["0"] * plies)
    scene = build(layup=stack, cells=4)
    assert build(layup=stack, cells=4, travel=None).parameters == scene.parameters
    usual = build(cells=4).parameters["travel"]
    thick = name == "double_dome" and plies > 3
    assert (scene.parameters["travel"] > usual) == thick
    if thick:
        with pytest.raises(InputError, match=r"travel = 0\.062 m must be at least"):
            build(layup=stack, cells=4, travel=0.062)


def test_an_unknown_parameter_is_refused_as_python_does():
    with pytest.raises(TypeError, match="hight"):
        square_box.build(hight=0.1)
