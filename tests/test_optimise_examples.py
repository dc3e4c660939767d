"""Example scenes of optimisations: what their parameters do to the scene; the files are read."""

from pathlib import Path

import numpy as np
import pytest

from warpdrape.commands.scene_library import find_script
from warpdrape.errors import InputError
from warpdrape.optimisation.optimise_file import read_optimisation
from warpdrape.optimisation.space import place_of

EXAMPLES = Path(__file__).parents[1] / "examples"
SPRINGS = find_script(EXAMPLES / "double_dome_springs.py")
SEGMENTS = find_script(EXAMPLES / "hemisphere_segments.py")


def grips(*settings):
    """Flat places that each spring holds [m], and which way it pulls, by its name."""
    scene = SPRINGS.make(["cells=40", *settings])
    points = scene.plies[0].rest_points
    return {s.name: (points[s.vertices(points)], np.array(s.to)) for s in scene.springs}


def test_springs_sit_where_they_are_put_and_pull_outwards():
    found = grips("long_stiffness=100", "short_stiffness=7", "long_place=100mm", "grip=30mm")
    assert len(found) == 8
    for name, (held, to) in found.items():
        across = 1 if name.startswith("long") else 0
        side, end = (1.0 if letter == "p" else -1.0 for letter in name[-2:])
        assert held[:, across] == pytest.approx(side * (0.2, 0.135)[across])
        place = 0.1 if across == 1 else 0.06
        assert (abs(end * held[:, 1 - across] - place) <= 0.015 + 1e-6).all() and len(held) >= 2
        assert to[across] * side == pytest.approx(0.1) and abs(to[1 - across]) < 1e-12
    scene = SPRINGS.make(["long_stiffness=100", "short_stiffness=7"])
    assert sorted({s.stiffness for s in scene.springs}) == [7.0, 100.0]
    assert SPRINGS.make().springs == ()


def test_a_turned_blank_takes_its_yarns_and_springs_with_it():
    turned = grips("long_stiffness=100", "turn_deg=30")
    straight = grips("long_stiffness=100")
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    turn = np.array([[c, -s], [s, c]])
    for name, (held, to) in straight.items():
        assert turned[name][1][:2] == pytest.approx(turn @ to[:2])
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
