"""What ``warpdrape check`` says: first contacts, roundings, gaps, steps; and that a run agrees."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from warpdrape import Float, InputError, Limits, Ply, Scene, Stroke, Tool, cli, lay_up
from warpdrape.checks import check as checking
from warpdrape.checks.check import check_scene
from warpdrape.checks.first_contact import first_touches
from warpdrape.checks.picture import section
from warpdrape.checks.roundings import smallest_rounding
from warpdrape.checks.words import cautions, geometry_words
from warpdrape.contact.closing import closing_tools, narrowest_gaps
from warpdrape.dynamics.stepping import Stepper
from warpdrape.scenes import hemisphere, prepreg_hemisphere
from warpdrape.tools.motion import smooth_ramp

THICKNESS = 6e-4
LOW, HIGH = np.array([-1.0, -1.0]), np.array([1.0, 1.0])


def scene(*, above=5e-3, travel=15e-3, count=2, radius=0.02, **changes):
    """A ball punch above a stack on a table."""
    plies = lay_up(
        [Ply.rectangle(f"ply_{n}", "carbon_interlock", 0.1, cells=6) for n in range(count)]
    )
    down = Stroke(travel=(0.0, 0.0, -travel), duration=0.02)
    punch = Tool.punch(radius=radius, motion=down).moved((0.01, 0.0, count * THICKNESS + above))
    table = Tool.die(hole_radius=0.03, edge_radius=5e-3, outer_radius=0.1, depth=0.02)
    options = {"plies": plies, "tools": [table, punch], "duration": 0.022} | changes
    return Scene(name="ball", **options)


def test_the_first_touch_is_when_the_stroke_has_come_so_far():
    table, punch = first_touches(scene())
    assert (table.tool, table.ply, table.time) == ("die", "ply_0", 0.0)
    assert (punch.tool, punch.ply) == ("punch", "ply_1")
    share = brentq(lambda u: float(smooth_ramp(np.array(u), 0.3, 0.3)) - 5.0 / 15.0, 0.0, 1.0)
    assert punch.time == pytest.approx(0.02 * share, rel=1e-3)
    assert punch.way == pytest.approx(5e-3, rel=1e-3) and punch.gap == pytest.approx(5e-3, rel=1e-6)
    np.testing.assert_allclose(punch.place, (0.01, 0.0, 2 * THICKNESS), atol=2e-4)


def test_tools_that_touch_nothing_while_the_plies_lie_flat_are_said():
    far = scene(travel=4e-3)
    (punch,) = [touch for touch in first_touches(far) if touch.tool == "punch"]
    assert punch.ply == "" and punch.gap == pytest.approx(5e-3, rel=1e-6)
    assert "punch: none while the plies lie flat, 5 mm off them" in geometry_words(far)
    beside = scene()
    moved = [beside.tools[0], beside.tools[1].moved((0.5, 0.0, 0.0))]
    assert "punch: none while the plies lie flat, beside them" in geometry_words(
        replace(beside, tools=moved)
    )


def test_a_holder_that_lies_on_the_plies_touches_from_the_start():
    ring = Tool.blank_holder(hole_radius=0.03, outer_radius=0.08, motion=Float(force=10.0))
    held = scene()
    held = replace(held, tools=[*held.tools, ring.moved((0.0, 0.0, 2 * THICKNESS))])
    (touch,) = [each for each in first_touches(held) if each.tool == "holder"]
    assert (touch.ply, touch.time) == ("ply_1", 0.0)
    assert np.hypot(*touch.place[:2]) > 0.02  # a place on the ring, not its middle
    words = geometry_words(held)
    assert "holder: in touch with ply_1" in words and "floats, force 10 N" in words


@pytest.mark.parametrize(
    ("tool", "radius"),
    [
        (Tool.punch(radius=0.04, facet=2e-3), 0.04),
        (Tool.drum(radius=0.025, length=0.2, facet=2e-3), 0.025),
        (Tool.die(hole_radius=0.05, edge_radius=6e-3, outer_radius=0.1, facet=2e-3), 6e-3),
        (Tool.plate(width=0.2, height=0.2), math.inf),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_the_smallest_radius_is_that_of_the_tool(tool, radius):
    assert smallest_rounding(tool, LOW, HIGH).radius == pytest.approx(radius, rel=0.02)


def test_sharp_edges_are_measured_and_what_lies_beside_the_plies_does_not_count():
    import trimesh

    box = Tool.from_mesh("box", trimesh.creation.box((0.1, 0.1, 0.02)))
    found = smallest_rounding(box, LOW, HIGH)
    assert found.sharp == pytest.approx(8 * 0.1 + 4 * 0.02) and math.isinf(found.radius)
    aside = smallest_rounding(box, LOW + 5.0, HIGH + 5.0)
    assert aside.sharp == 0.0 and math.isinf(aside.radius)
    assert "sharp edges of 880 mm in all" in geometry_words(
        replace(scene(), tools=[box.moved((0, 0, -0.0101))])
    )


def test_words_hold_sizes_fabric_angles_and_the_gap():
    turned = lay_up([Ply.rectangle("low", "carbon_interlock", 0.1, cells=6, warp_angle=0.5)])
    deep = scene(count=1, travel=25e-3, plies=turned)
    words = geometry_words(deep)
    for text in (
        "low: 100 × 100 mm, carbon_interlock, 0.6 mm, 630 g/m²",
        "warp at 28.65° from x, weft at 118.6°",
        "smallest radius 20 mm",
        "at up to 1.8 m/s",
        "die: 200 × 200 × 20 mm",
    ):
        assert text in words, text


def test_gaps_are_given_where_there_is_room_and_named_where_there_is_not():
    start, left = 2e-3, 1.5 * THICKNESS
    top = Tool.plate("top", width=0.06, height=0.06, facing="down")
    bottom = Tool.plate("bottom", width=0.3, height=0.3)

    def plates(left):
        down = Stroke(travel=(0.0, 0.0, left - start), duration=0.01)
        tools = [bottom, replace(top.moved((0.0, 0.0, start)), motion=down)]
        plies = lay_up([Ply.rectangle("ply", "carbon_interlock", 0.1, cells=3)])
        return Scene(name="plates", plies=plies, tools=tools, duration=0.02)

    (gap,) = narrowest_gaps(plates(left))
    assert not gap.lacks and gap.gap == pytest.approx(left, rel=1e-3)
    assert gap.time == pytest.approx(0.01, rel=0.1) and closing_tools(plates(left)) == []
    assert "0.9 mm at the least" in geometry_words(plates(left))
    assert "0.6 mm thick: 1.50 times that" in geometry_words(plates(left))
    (lacking,) = narrowest_gaps(plates(0.5 * THICKNESS))
    assert lacking.lacks and str(lacking) in geometry_words(plates(0.5 * THICKNESS))


def test_cautions_of_coarse_plies_and_of_plies_beyond_the_holder():
    ring = Tool.blank_holder(hole_radius=0.03, outer_radius=0.045, motion=Float(force=10.0))
    fine = scene(radius=0.02, tools=[scene().tools[1], ring.moved((0, 0, 2 * THICKNESS))])
    for name, beyond in zip(("ply_0", "ply_1"), cautions(fine), strict=True):
        # The corner's 25.7 mm, and what the ring's facets cut off its circle.
        assert f"ply {name!r} goes 25.8 mm beyond tool 'holder'" in beyond
    coarse = [Ply.rectangle("ply_0", "carbon_interlock", 0.1, cells=3)]
    said = cautions(scene(plies=lay_up(coarse)))
    assert said[0].startswith("triangles with sides of 33.3 mm span radii as chords: 4.98 mm of")
    assert "sides of 5 mm or less" in said[0]


def test_a_section_of_a_ball_lies_on_its_circle():
    ball = Tool.punch(radius=0.05, facet=3e-3)
    cut = section(ball.vertices[ball.triangles], 1, 0.01)
    np.testing.assert_allclose(cut[:, :, 1], 0.01, atol=1e-12)
    low = cut.reshape(-1, 3)[cut.reshape(-1, 3)[:, 2] < 0.045]
    radius = np.linalg.norm(low - (0.0, 0.0, 0.05), axis=1)
    np.testing.assert_allclose(radius, 0.05, rtol=2e-3)
    along = np.linalg.norm(cut[:, 1] - cut[:, 0], axis=1).sum()
    assert along > 2 * 0.05  # there and back round the ball
    assert section(ball.vertices[ball.triangles], 1, 1.0).shape == (0, 2, 3)


@pytest.fixture
def undrawn(monkeypatch):
    """The path of a picture that is not drawn."""
    monkeypatch.setattr(checking, "draw_start", lambda _, out: out)
    return Path("a.png")


@pytest.fixture
def no_steps(monkeypatch):
    """A stepper that must not step."""

    def step(*_):
        raise AssertionError("it runs")

    monkeypatch.setattr(Stepper, "block", step)


def check(*argv):
    return cli.main(["check", *map(str, argv)])


def test_check_says_draws_and_does_not_run(tmp_path, monkeypatch, capsys, no_steps):
    monkeypatch.chdir(tmp_path)
    assert check("hemisphere", "--set", "cells=6", "--set", "duration=0.005") == 0
    said = capsys.readouterr().out
    for title in ("Tools:", "Plies, from the bottom up:", "First contacts", "Room between tools:"):
        assert title in said
    assert "Picture: hemisphere_check.png" in said and "s on one thread; 60 frames" in said
    assert (tmp_path / "hemisphere_check.png").read_bytes().startswith(b"\x89PNG")
    assert [file.name for file in tmp_path.iterdir()] == ["hemisphere_check.png"]


def test_check_and_run_announce_the_same_steps(undrawn, capfd):
    built = hemisphere.build(cells=6, duration=0.005)
    said = []
    check_scene(built, undrawn, device="cpu", frames=3, say=said.append)
    built.run(frames=3, quiet=False)
    steps = [line for line in capfd.readouterr().err.splitlines() if " steps of " in line]
    first = steps[0].partition(",")[0] + "," + steps[0].split(",")[1]
    assert " steps of " in first and any(first in text for text in said)


def test_what_a_run_refuses_check_refuses_in_its_words_with_the_picture_drawn(tmp_path, capsys):
    bad = scene(above=-3e-3)
    with pytest.raises(InputError) as by_run:
        bad.run()
    with pytest.raises(InputError) as by_check:
        check_scene(bad, tmp_path / "a.png", device="cpu", frames=60, say=lambda _: None)
    assert str(by_check.value) == str(by_run.value) and "starts inside ply" in str(by_run.value)
    assert (tmp_path / "a.png").is_file()
    assert check("no_such_scene") == 2
    assert "unknown scene" in capsys.readouterr().err


def test_check_of_a_net_says_what_it_does_not_see(undrawn):
    said = []
    net = replace(scene(travel=0.03), approach="fishnet")
    check_scene(net, undrawn, device="cpu", frames=60, say=said.append)
    assert any("a net of yarns on the closed tools" in text for text in said)


def test_limits_of_the_scene_are_said_and_kept(undrawn):
    limited = scene(limits=Limits(wrinkle_amplitude=5e-4, shear_deg=40.0))
    said = []
    check_scene(limited, undrawn, device="cpu", frames=60, say=said.append)
    assert any("wrinkle_amplitude 0.5 mm" in text and "shear_deg 40" in text for text in said)
    with pytest.raises(InputError, match=r"limits = 3 must be warpdrape.Limits"):
        scene(limits=3)


def test_limits_of_what_a_scene_has_not_are_refused_before_it_runs():
    with pytest.raises(InputError, match=r"limits.coverage 'punsh'; did you mean 'punch'"):
        scene(limits=Limits(coverage={"punsh": 0.1}))
    with pytest.raises(InputError, match=r"limits.misalignment_deg 'spar'"):
        scene(limits=Limits(misalignment_deg={"spar": 5.0}))
    assert scene(limits=Limits(coverage={"punch": 0.1})).limits.coverage == {"punch": 0.1}


def test_a_prepreg_is_said_with_its_clock_and_temperatures(tmp_path):
    said: list[str] = []
    wet = prepreg_hemisphere.build(cells=4, facet=0.02, closing_time=5.0)
    check_scene(wet, tmp_path / "wet.png", device="cpu", frames=2, say=said.append)
    words = "\n".join(said)
    assert "ms for 6 s of the process, by the approach" in said[0]
    assert words.count("; at 200 °C") == 3 and words.count("; at 260 °C") == 1
    assert "°C" not in geometry_words(hemisphere.build(cells=4, facet=0.02))
