"""Warning of plies that lie deep in tools: the force that it tells, and its advice."""

import re
from dataclasses import replace

import pytest
from law_checks import fabric

from warpdrape.blanks.ply import Ply
from warpdrape.materials.laws import LinearTension
from warpdrape.numerics import Numerics
from warpdrape.scene import Scene
from warpdrape.tools.floating import Float
from warpdrape.tools.tool import Tool

CLOTH = fabric(LinearTension(400.0, 420.0))
SOFT = {"contact_share": 0.02, "time_step": 1e-5}
"""A step that is given, so that contacts follow the share alone."""
PRESSED = Numerics(**SOFT)


def pressed(force, numerics):
    """A ply between two plates, the upper one under a force."""
    ply = Ply.rectangle("ply", CLOTH, 0.1, cells=4)
    half = 0.5 * CLOTH.thickness
    press = Float(force=force, damping=0.5 * force, ramp=4e-3)
    plate = {"width": 0.2, "height": 0.2}
    upper = Tool.plate("upper", facing="down", motion=press, **plate).moved((0.0, 0.0, half))
    lower = Tool.plate("lower", **plate).moved((0.0, 0.0, -half))
    return Scene(
        name="pressed",
        plies=[ply],
        tools=[upper, lower],
        duration=12e-3,
        gravity=(0.0, 0.0, 0.0),
        numerics=numerics,
    )


def deep(summary):
    return [words for words in summary["warnings"] if "may have passed" in words]


@pytest.fixture(scope="module")
def force():
    """Force that presses vertices into each plate by a ply's whole thickness [N]."""
    scene = pressed(1.0, PRESSED)
    mass = CLOTH.areal_density * 0.1**2
    return SOFT["contact_share"] * mass / SOFT["time_step"] ** 2 * scene.plies[0].fabric.thickness


def test_depth_in_a_tool_is_told_with_the_force_that_made_it(force):
    result = pressed(force, PRESSED).run(frames=4)
    (words,) = deep(result.summary)
    depth = max(tool["max_penetration_m"] for tool in result.summary["tools"])
    assert depth > 0.9 * CLOTH.thickness
    assert re.search(rf"lay {1e3 * depth:.3g} mm in each other", words)
    told = float(re.search(r"presses with ([\d.e+-]+) N", words)[1])
    stiffness = 1e3 * float(re.search(r"contacts of ([\d.e+-]+) N/mm", words)[1])
    # most vertices have a 48th of the ply's mass, and so of what the plate presses with
    assert told == pytest.approx(force / 48.0 * depth / CLOTH.thickness, rel=0.05)
    assert told == pytest.approx(stiffness * depth, rel=0.1)


@pytest.mark.parametrize("cure", [{"contact_share": 0.1}, {"time_step": 5e-6}])
def test_its_advice_makes_contacts_stiffer(cure, force):
    stiffer = pressed(force, replace(PRESSED, **cure)).run(frames=4)
    assert stiffer.completed and not deep(stiffer.summary)
    lighter = pressed(0.4 * force, PRESSED).run(frames=4)
    assert lighter.completed and not deep(lighter.summary)
