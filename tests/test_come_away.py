"""Plies that have left their stack: by how far they lie off, unless something holds or presses."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from warpdrape import Clamp, Ply, Scene, Spring, lay_up
from warpdrape.dynamics.model import build_model
from warpdrape.interaction import Measured
from warpdrape.results.complaints import come_away

COARSE, FINE = 0.1, 0.02
"""Squares of the two plies, whose longest sides are √2 times as long [m]."""


@pytest.fixture(scope="module")
def stack():
    low = Ply.rectangle("low", "carbon_interlock", 0.2, edge=COARSE, mesh="diagonal")
    high = Ply.rectangle("high", "carbon_interlock", 0.04, edge=FINE, mesh="diagonal")
    return build_model(Scene(name="s", plies=lay_up([low, high]), duration=0.03), "cpu", 1)


def said(model, away, measured=(), loose=(), aside=0.0, **held):
    """Warnings with the fine ply so far over the coarse one, and so far aside [m]."""
    plies = []
    for ply, shift in zip(model.scene.plies, ((0.0, 0.0, 0.0), (aside, 0.0, away)), strict=True):
        points = np.pad(ply.mesh.vertices, ((0, 0), (0, 1))) + shift
        plies.append(SimpleNamespace(name=ply.name, points=points, triangles=ply.mesh.triangles))
    scene = replace(model.scene, **held)
    asked = SimpleNamespace(scene=scene, spans=model.spans)
    words = come_away(asked, measured, plies, loose)
    named = [name for name in ("low", "high") if any(f"{name!r} has left" in w for w in words)]
    return named, words


def test_beyond_the_longest_side_of_either_ply_it_has_left(stack):
    """By its nearest vertex; a fine patch may lie within a triangle of its neighbour."""
    side = COARSE * np.sqrt(2.0)
    assert said(stack, 0.99 * side)[0] == []
    names, words = said(stack, 1.01 * side)
    assert names == ["low", "high"]
    assert f"it lies {1e3 * 1.01 * side:.3g} mm from the nearest" in words[1]
    # Aside, its far end lies farther off than that and its near one does not.
    beside = 0.1 + 0.02 + 0.9 * side
    assert said(stack, 0.0, aside=beside)[0] == []
    assert said(stack, 0.0, aside=beside + 0.11 * side)[0] == ["low", "high"]


def test_what_is_held_or_pressed_on_has_not(stack):
    far = 0.5
    assert said(stack, far, loose=["low"])[0] == ["high"]
    hold = {"ply": "low", "where": lambda p: p[:, 0] < 0.0}
    assert said(stack, far, clamps=(Clamp(name="c", **hold),))[0] == ["high"]
    spring = Spring(name="s", stiffness=1e3, to=(0.0, 0.0, 0.1), **hold)
    assert said(stack, far, springs=(spring,))[0] == ["high"]
    push = np.zeros((2, stack.spans[-1].vertices.stop))
    assert said(stack, far, [Measured(pressing={"a": push})])[0] == ["low", "high"]
    push[1, -1] = 1.0
    pressed = [Measured(), Measured(pressing={"a": 0.0 * push, "b": push})]
    assert said(stack, far, pressed)[0] == ["low"]
