"""Patches, holes and strips in a stack: no deeper in their neighbours than whole plies, or told."""

import numpy as np
import pytest

from warpdrape import Clamp, Ply, Scene, Stroke, Tool, lay_up
from warpdrape.numerics import Numerics

CLOTH = "carbon_interlock"
SIZE, PUNCH, TRAVEL = 0.2, 0.04, 0.025
THICKNESS = 6e-4


def whole(name, angle=0.0, cells=8):
    return Ply.rectangle(name, CLOTH, SIZE, cells=cells, warp_angle=angle)


def square(half, x=0.0, y=0.0):
    return [(x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half)]


def at_rim(points):
    return np.abs(points[:, :2]).max(axis=1) > 0.499 * SIZE


def formed(plies, clamped, duration=0.035):
    """Push a ball into a stack whose whole plies are held at their rim."""
    plies = lay_up(plies)
    top = plies[-1].z + 0.5 * THICKNESS
    stroke = Stroke(travel=(0.0, 0.0, -TRAVEL), duration=0.03, ramp=0.3, brake=0.3)
    punch = Tool.punch(radius=PUNCH, motion=stroke).moved((0.0, 0.0, top))
    scene = Scene(
        name="drops",
        plies=plies,
        tools=[punch],
        clamps=[Clamp(name=f"rim_{name}", ply=name, where=at_rim) for name in clamped],
        duration=duration,
        # Soft to the end: yarns of the fabric's stiffness would not let a ball in between clamps.
        numerics=Numerics.for_accuracy("draft", yarn_recovery=0.0),
    )
    return scene.run(frames=6)


def left(summary):
    return [words for words in summary["warnings"] if "has left the stack" in words]


DROPS = {
    "patch": lambda: Ply.rectangle("drop", CLOTH, SIZE / 3, cells=3),
    "turned patch": lambda: Ply.rectangle("drop", CLOTH, SIZE / 3, cells=3, warp_angle=0.8),
    "fine patch": lambda: Ply.rectangle("drop", CLOTH, SIZE / 5, cells=8),
    "patch aside": lambda: Ply.polygon("drop", CLOTH, square(0.03, 0.03, 0.015), edge=0.015),
    "hole": lambda: Ply.polygon("drop", CLOTH, square(0.5 * SIZE), holes=[square(0.02)], edge=0.02),
    "strip": lambda: Ply.polygon(
        "drop", CLOTH, [(-0.06, -0.003), (0.06, -0.003), (0.06, 0.003), (-0.06, 0.003)], edge=0.006
    ),
}


def depth(result):
    """Deepest of plies in each other [m]: mostly the give of contacts under the ball."""
    entries = result.summary["interfaces"] + result.summary["edge_contact"]
    return max(entry["max_penetration_m"] for entry in entries)


@pytest.fixture(scope="module")
def whole_depth():
    names = ("low", "mid", "high")
    return depth(formed([whole(name, 0.8 * (name == "high")) for name in names], names))


@pytest.mark.parametrize("kind", DROPS)
def test_what_ends_within_a_stack_lies_between_its_neighbours(kind, whole_depth):
    result = formed([whole("low"), DROPS[kind](), whole("high", 0.8)], ("low", "high"))
    summary = result.summary
    assert result.completed and not left(summary), summary["message"]
    assert summary["energy_error"] < 0.01
    assert depth(result) < 1.5 * whole_depth
    assert max(entry["max_gap_jump_m"] for entry in summary["interfaces"]) < 0.25 * THICKNESS
    assert not any(entry["across_vertices"] for entry in summary["interfaces"])
    # It went along: its deepest place is between those of the plies under and over it.
    lowest = {ply.name: ply.points[:, 2].min() for ply in result.plies}
    assert lowest["high"] < -0.9 * TRAVEL
    if kind not in ("hole", "patch aside"):
        assert lowest["low"] < lowest["drop"] < lowest["high"]


def test_a_patch_that_falls_off_is_told_and_the_advice_holds_it():
    def patch():
        return Ply.rectangle("patch", CLOTH, SIZE / 3, cells=3)

    fallen = formed([patch(), whole("high")], ("high",), 0.09)
    assert fallen.completed
    (words,) = left(fallen.summary)
    assert "'patch'" in words
    gap = fallen.plies[1].points[:, 2].min() - fallen.plies[0].points[:, 2].max()
    told = float(words.split("lies ")[1].split(" mm")[0])
    assert 1e3 * gap - 1.0 < told < 1e3 * gap + 10.0  # its middle sags
    between = formed([whole("low"), patch(), whole("high")], ("low", "high"), 0.09)
    assert not left(between.summary)
    clamped = formed([whole("patch"), whole("high")], ("patch", "high"), 0.09)
    assert not left(clamped.summary)
