"""Tools that close to less than a ply's thickness are named, with place and by how much."""

import re

import numpy as np
import pytest

from warpdrape import Ply, Scene, Stroke, Tool

SHEET = Ply.rectangle("sheet", "carbon_interlock", 0.1, cells=6, mesh="grid")
THICKNESS = SHEET.fabric.thickness


def closed(left):
    """The sheet between plates that close until so much is left between them [m]."""
    lower = Tool.plate("mould", width=0.3, height=0.3).moved((0, 0, -0.5 * THICKNESS))
    way = 1e-3 + THICKNESS - left
    upper = Tool.plate(
        "punch",
        width=0.06,
        height=0.06,
        facing="down",
        motion=Stroke(travel=(0.0, 0.0, -way), duration=0.02),
    ).moved((0, 0, 0.5 * THICKNESS + 1e-3))
    scene = Scene(name="closed", plies=[SHEET], tools=[lower, upper], duration=0.02)
    return scene.run(frames=4, quiet=True)


def complaints(result):
    return [text for text in result.summary["warnings"] if "squeeze" in text]


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_plates_that_leave_too_little_room_are_named(share):
    result = closed(share * THICKNESS)
    (said,) = complaints(result)
    assert said.startswith("tools 'mould' and 'punch' squeeze ply 'sheet', triangle ")
    below = float(re.search(r"\) (\S+) mm below its thickness of 0.6 mm at 20 ms", said)[1])
    assert below == pytest.approx(1e3 * (1.0 - share) * THICKNESS, rel=0.05)
    x, y = map(float, re.search(r"ms, \((\S+), (\S+)\) mm: ", said).groups())
    assert max(abs(x), abs(y)) <= 30.0 + 1e-6
    assert result.summary["tools"][1]["max_force_n"] > 100.0
    assert "leave the ply its thickness" in said


def test_plates_that_leave_the_ply_its_thickness_are_not():
    result = closed(THICKNESS)
    assert complaints(result) == []
    assert np.isfinite(result.plies[0].points).all()
