"""What a force presses deep into a tool stays in contact with it, however deep."""

import re

import numpy as np
import pytest
from tool_search_checks import HALF, gap_and_push, searcher

from warpdrape import Clamp, Numerics, Ply, Scene, Stroke, Tool

RADIUS = 0.04


@pytest.mark.parametrize("contact", ["fast", "exact"])
def test_a_vertex_deep_in_a_ball_is_pushed_out_by_all_its_depth(contact, device):
    """Three times as deep as a search looks for what is not held."""
    ball = Tool.punch(radius=RADIUS)
    model, state = searcher([ball], device, cells=4, contact=contact)
    count = len(model.masses.mass)
    turns = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    out = np.stack([0.3 * np.cos(turns), 0.3 * np.sin(turns), np.full(count, -0.954)], axis=1)
    out /= np.linalg.norm(out, axis=1)[:, None]
    for depth in (0.0, *np.arange(0.1e-3, 9e-3, 0.3e-3)):
        x = (0.0, 0.0, RADIUS) + (RADIUS + HALF - depth) * out
        gap, push = gap_and_push(model, state, x)
    np.testing.assert_allclose(gap, -depth, rtol=0.02)
    np.testing.assert_allclose((push * out).sum(axis=1), 1.0, atol=1e-3)


def test_a_blank_that_is_held_all_round_stretches_over_a_ball_and_the_depth_is_told():
    """Soft contacts give way by millimetres: that is warned of, and nothing leaps."""
    blank = Ply.rectangle("blank", "carbon_interlock", 0.2, cells=12, z=3e-4)
    down = Stroke(travel=(0.0, 0.0, -0.035), duration=0.015)
    scene = Scene(
        name="ball",
        plies=[blank],
        tools=[Tool.punch(radius=RADIUS, motion=down).moved((0.0, 0.0, 6e-4))],
        clamps=[
            Clamp(name="rim", ply="blank", where=lambda p: np.abs(p[:, :2]).max(axis=1) > 0.0999)
        ],
        duration=0.015,
        numerics=Numerics(contact_share=0.02),
    )
    result = scene.run(quiet=True, frames=10)
    assert result.completed
    message = result.summary["message"]
    depth = float(re.search(r"tool 'punch' and a ply lay (\S+) mm in each other", message)[1])
    assert depth > 3.5 and "raise contact_share" in message
    assert result.summary["energy_error"] < 1e-3
