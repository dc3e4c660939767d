"""Example scenes of optimisations: what their parameters do to the scene; the files are read."""

from pathlib import Path

import numpy as np
import pytest

from warpdrape.commands.scene_library import find_script
from warpdrape.errors import InputError
from warpdrape.optimisation.optimise_file import read_optimisation
from warpdrape.optimisation.space import place_of, row_at
from warpdrape.studies.study_file import read_study
from warpdrape.tools.motion import Stages

EXAMPLES = Path(__file__).parents[1] / "examples"
SPRINGS = find_script(EXAMPLES / "double_dome_springs.py")
SEGMENTS = find_script(EXAMPLES / "hemisphere_segments.py")
STAGES = find_script(EXAMPLES / "double_dome_stages.py")


def grips(*settings):
    """Of each grip: flat places of its vertices [m], their stiffness, which way it pulls."""
    scene = SPRINGS.make(["cells=40", "facet=20mm", *settings])
    points = scene.plies[0].rest_points
    found = {}
    for s in scene.springs:
        held, stiffness, _ = found.setdefault(s.name.rpartition("_")[0], ([], [], np.array(s.to)))
        held += list(points[s.vertices(points)])
        stiffness.append(s.stiffness)
    return {name: (np.array(a), np.array(b), to) for name, (a, b, to) in found.items()}


def test_springs_sit_where_they_are_put_and_pull_outwards():
    found = grips("long_stiffness=100", "short_stiffness=7", "long_place=100mm", "grip=30mm")
    assert len(found) == 8
    for name, (held, stiffness, to) in found.items():
        across = 1 if name.startswith("long") else 0
        side, end = (1.0 if letter == "p" else -1.0 for letter in name[-2:])
        assert held[:, across] == pytest.approx(side * (0.2, 0.135)[across])
        place = 0.1 if across == 1 else 0.06
        assert (abs(end * held[:, 1 - across] - place) <= 0.015 + 0.005 + 1e-6).all()
        assert stiffness.sum() == pytest.approx(100.0 if across == 1 else 7.0)
        middle = (stiffness @ held)[1 - across] / stiffness.sum()
        assert end * middle == pytest.approx(place, abs=1e-3)  # of pieces of 10 mm
        assert to[across] * side == pytest.approx(0.1) and abs(to[1 - across]) < 1e-12
    assert SPRINGS.make().springs == ()


def test_a_grip_moves_by_less_than_a_triangle():
    def middle(place):
        held, stiffness, _ = grips("long_stiffness=1", f"long_place={place}")["long_pp"]
        return stiffness @ held[:, 0]

    places = np.linspace(0.08, 0.11, 6)
    found = [middle(place) for place in places]
    assert (np.diff(found) > 1e-4).all() and found == pytest.approx(places, abs=2e-3)


def test_a_turned_blank_takes_its_yarns_and_springs_with_it():
    turned = grips("long_stiffness=100", "turn_deg=30")
    straight = grips("long_stiffness=100")
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    turn = np.array([[c, -s], [s, c]])
    for name, (held, _, to) in straight.items():
        assert turned[name][2][:2] == pytest.approx(turn @ to[:2])
        middle = turned[name][0][:, :2].mean(axis=0)
        assert middle == pytest.approx(turn @ held[:, :2].mean(axis=0), abs=0.01)
    ply = SPRINGS.make(["turn_deg=30", "warp_angle_deg=45"]).plies[0]
    assert np.degrees(ply.warp_angle) == pytest.approx(75.0)


def test_corners_are_cut_off():
    whole, cut = (SPRINGS.make([f"corner={corner}"]).plies[0] for corner in (0.0, 0.05))

    def area(ply):
        a, b, c = (ply.mesh.vertices[ply.mesh.triangles[:, k]] for k in range(3))
        u, v = b - a, c - a
        return 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum()

    assert area(whole) == pytest.approx(0.4 * 0.27)
    assert area(whole) - area(cut) == pytest.approx(4 * 0.5 * 0.05**2)


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("long_place=190mm", "long_place = 0.19 m must lie from half a grip, 0.02 m, to 0.18 m"),
        ("long_place=10mm", "where the edge ends"),
        ("corner=140mm", "corner = 0.14 m must lie from 0 to below 0.135 m"),
    ],
)
def test_what_cannot_be_is_refused(setting, words):
    with pytest.raises(InputError, match=words):
        SPRINGS.make(["long_stiffness=1", setting])


def test_shear_of_the_part_is_told_apart_from_the_flange():
    coarse = ["cells=8", "facet=10mm", "duration=10ms", "accuracy=standard", "long_stiffness=2000"]
    result = SPRINGS.make([*coarse, "long_place=60mm", "grip=100mm"]).run(frames=2, threads=1)
    ply, summary = result.plies[0], result.summary
    deep = ply.points[ply.triangles].mean(axis=1)[:, 2] < -0.005
    assert 0 < deep.sum() < len(deep)
    assert summary["part_max_shear_deg"] == np.abs(ply.shear_angle_deg[deep]).max()
    assert 0.0 < summary["part_p95_shear_deg"] <= summary["part_max_shear_deg"]
    assert summary["part_max_shear_deg"] <= summary["plies"][0]["max_shear_deg"] + 1e-9


def test_segments_press_each_with_its_force():
    forces = ["right_force=10", "back_force=80", "left_force=10", "front_force=80"]
    coarse = ["cells=8", "facet=10mm", "duration=20ms", "travel=20mm", "accuracy=standard"]
    result = SEGMENTS.make([*coarse, *forces]).run(frames=3, threads=1)
    assert result.completed, result.summary["message"]
    found = {tool["name"]: tool["force_n"] for tool in result.summary["tools"]}
    for name, force in (("right", 10), ("back", 80), ("left", 10), ("front", 80)):
        assert found[name] == pytest.approx(force, rel=0.15), name


def test_example_files_are_read_and_start_from_what_they_say():
    hemisphere = read_optimisation(EXAMPLES / "optimise_hemisphere.toml")
    assert place_of(hemisphere.axes, hemisphere.start) is not None
    dome = read_optimisation(EXAMPLES / "optimise_double_dome.toml")
    assert dome.study.script.name == "double_dome_springs" and dome.start["long_stiffness"] == 0.0
    assert dome.aims.constraints[0].words == "warp_strain ≤ 0.005"
    slopes = read_optimisation(EXAMPLES / "optimise_gradient.toml")
    assert slopes.method == "gradient" and place_of(slopes.axes, slopes.start) is not None
    stages = read_optimisation(EXAMPLES / "optimise_stages.toml")
    assert place_of(stages.axes, stages.start) is not None and stages.start["order"] == "together"


def test_the_meshs_own_study_makes_the_blank_larger_in_steps():
    rows = read_study(EXAMPLES / "study_mesh.toml").rows()
    assert [row["blank_size"] for row in rows] == pytest.approx(np.linspace(0.24, 0.3, 13))


def punches(*settings):
    tools = STAGES.make(["cells=4", "duration=0.1", *settings]).tools
    return [next(tool.motion for tool in tools if tool.name == name) for name in ("left", "right")]


@pytest.mark.parametrize("first", ["left", "right"])
def test_punches_go_in_their_order_at_their_profile(first):
    both = punches(f"order={first}_first", "overlap=0.25", "ramp=0.1", "brake=0.3")
    early, late = both if first == "left" else both[::-1]
    own = 0.1 / 1.75
    assert (early.start, early.end) == pytest.approx((0.0, own))
    assert (late.start, late.end) == pytest.approx((0.1 - own, 0.1))  # a quarter of it together
    assert early.end - late.start == pytest.approx(0.25 * own)
    for motion in both:
        assert (motion.ramp, motion.falling) == (0.1, 0.3)
        assert motion.displacement(np.array(0.1))[2] == pytest.approx(-0.062)
    assert [m.start for m in punches()] == [0.0, 0.0]


def test_a_punch_waits_at_a_depth():
    (left, right) = punches("first_depth=0.4", "wait=0.2")
    assert isinstance(left, Stages) and left.end == pytest.approx(0.1) == right.end
    times = np.array([0.4 * 0.08, 0.4 * 0.08 + 0.019])
    assert left.displacement(times)[:, 2] == pytest.approx([-0.4 * 0.062] * 2)
    assert left.displacement(np.array(0.1))[2] == pytest.approx(-0.062)


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("order=first", "order = 'first' must be one of together, left_first, right_first"),
        ("overlap=1.5", "overlap = 1.5 must lie from 0 to 1"),
        ("first_depth=0", "first_depth = 0 must lie from 0.05 to 1"),
    ],
)
def test_orders_that_cannot_be_are_refused(setting, words):
    with pytest.raises(InputError, match=words):
        STAGES.make([setting])


def test_the_other_order_is_the_mirror_image():
    coarse = ["cells=8", "facet=10mm", "duration=20ms", "overlap=0.3"]
    ends = [
        STAGES.make([*coarse, f"order={side}_first"]).run(frames=2, threads=1)
        for side in ("left", "right")
    ]
    summaries = [end.summary for end in ends]
    forces = [{t["name"]: t["force_n"] for t in s["tools"]} for s in summaries]
    assert forces[0]["left"] == pytest.approx(forces[1]["right"], rel=0.05)
    assert forces[0]["right"] == pytest.approx(forces[1]["left"], rel=0.05)
    assert forces[0]["right"] != pytest.approx(forces[0]["left"], rel=0.1)  # no symmetry else
    shear = [s["plies"][0]["p95_shear_deg"] for s in summaries]
    assert shear[0] == pytest.approx(shear[1], abs=0.3)  # facets of a punch are no mirror image
    assert shear[0] > 20.0


VARIABLES = {
    "holder forces by segment": ("hemisphere_segments.py", "right_force", "range = [10, 400]"),
    "where segments meet": ("hemisphere_segments.py", "turn_deg", "range = [0, 45]"),
    "stiffness of springs": ("double_dome_springs.py", "long_stiffness", "log_range = [10, 1e4]"),
    "place of springs": ("double_dome_springs.py", "short_place", "range = [0.03, 0.1]"),
    "rotation of the blank": ("double_dome_springs.py", "turn_deg", "range = [0, 45]"),
    "outline of the blank": ("double_dome_springs.py", "corner", "range = [0, 0.05]"),
    "size of the blank": ("double_dome_springs.py", "blank_width", "range = [0.2, 0.28]"),
    "angle of the yarns": ("double_dome_springs.py", "warp_angle_deg", "range = [0, 45]"),
    "angles of a stack": ("stacked_hemisphere", "layup", 'values = ["0/45", "45/0"]'),
    "order of tools": ("double_dome_stages.py", "order", 'values = ["together", "left_first"]'),
    "overlap of strokes": ("double_dome_stages.py", "overlap", "range = [0, 0.9]"),
    "stroke's depths": ("double_dome_stages.py", "first_depth", "range = [0.3, 1]"),
    "stroke's speed": ("double_dome_stages.py", "ramp", "range = [0.1, 0.4]"),
    "stroke's end": ("hemisphere", "brake", "range = [0.1, 0.6]"),
    "time of the stroke": ("hemisphere", "duration", 'range = ["20 ms", "80 ms"]'),
}
FIXED = {
    "double_dome_springs.py": 'set = { short_stiffness = 100, long_place = "80 mm" }',
    "double_dome_stages.py": "",
}


def made_of(scene):
    """All of a scene that parameters of a process may change."""
    tools = [(repr(t.motion), t.vertices.sum(axis=0).round(9).tolist()) for t in scene.tools]
    plies = [(p.warp_angle, p.rest_points.round(9).tolist()) for p in scene.plies]
    flat = scene.plies[0].rest_points
    springs = [(s.stiffness, tuple(s.to), s.vertices(flat).tolist()) for s in scene.springs]
    return repr((tools, plies, springs))


@pytest.mark.parametrize("what", VARIABLES)
def test_each_variable_can_be_named_in_a_study_file(tmp_path, what):
    scene, name, spread = VARIABLES[what]
    script = EXAMPLES / scene if scene.endswith(".py") else scene
    fixed = FIXED.get(scene, "")
    if name == "overlap":
        fixed = 'set = { order = "left_first" }'
    path = tmp_path / "one.toml"
    path.write_text(
        f'scene = "{script}"\n{fixed}\n[parameters.{name}]\n{spread}\n[measures]\n'
        'shear = "plies.*.max_shear_deg"\n[optimise]\nminimise = "shear"\nruns = 4\n',
        encoding="utf-8",
    )
    task = read_optimisation(path)
    (axis,) = task.axes
    ends = [
        task.study.script.make([*task.study.settings(row_at(task.axes, (end,))), "cells=8"])
        for end in (axis.low, axis.high)
    ]
    assert made_of(ends[0]) != made_of(ends[1]), what
