"""What two tools that close on a ply make of it: thickness and fibre volume of a filled cavity."""

import math
from dataclasses import replace

import numpy as np
import pytest

from warpdrape import DefectThresholds, Float, InputError, Scene
from warpdrape.blanks.ply import Ply, lay_up
from warpdrape.defects.cavity import find_cavities
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.results.defect_text import defect_lines
from warpdrape.results.defects import DefectWatch, defect_entries
from warpdrape.results.result import FormedPly
from warpdrape.tools.tool import Tool

SIDE, GAP = 0.2, 1.5e-3
CLOTH = load_fabric("carbon_interlock")
FLAT = CLOTH.areal_density / CLOTH.fibre_density


def plates(width=1.0, gap=GAP):
    """Two plates of the same size, the lower one at z = 0."""
    lower = Tool.plate("lower", width=width, height=1.0)
    upper = Tool.plate("upper", width=width, height=1.0, facing="down").moved((0.0, 0.0, gap))
    return [lower, upper]


def formed(ply, height, shear=0.0):
    """A ply that is flat between plates, sheared along x."""
    x, y = np.asarray(ply.mesh.vertices).T
    m = len(ply.mesh.triangles)
    points = np.column_stack([x + y * math.sin(shear), y * math.cos(shear), 0.0 * x + height])
    return FormedPly(
        name=ply.name,
        rest_points=ply.rest_points,
        points=points,
        triangles=np.asarray(ply.mesh.triangles),
        warp=np.broadcast_to((1.0, 0.0, 0.0), (m, 3)),
        weft=np.broadcast_to((math.sin(shear), math.cos(shear), 0.0), (m, 3)),
        shear_angle=np.full(m, shear),
        strain=np.zeros((m, 2)),
        line_tension=np.zeros((m, 2)),
    )


def entries(tools, heights, *, cells=8, shear=0.0, fabrics=None, **thresholds):
    """Entries of plies between tools, as a summary has them."""
    fabrics = fabrics or ["carbon_interlock"] * len(heights)
    plies = [
        Ply.rectangle(f"ply_{k}", fabric, SIDE, cells=cells, mesh="grid")
        for k, fabric in enumerate(fabrics)
    ]
    found = DefectThresholds(**thresholds)
    scene = Scene(name="s", plies=lay_up(plies), tools=tools, duration=1.0, defects=found)
    watch = DefectWatch(scene)
    poses = [tool.pose(0.0) for tool in tools]
    flat = [formed(ply, z, shear) for ply, z in zip(plies, heights, strict=True)]
    looked = watch.look(flat, poses)
    summary = {
        "plies": [
            {"name": ply.name} | defect_entries(scene, k, ply, {}) for k, ply in enumerate(looked)
        ],
        "tools": [{"name": tool.name} for tool in tools],
    }
    watch.add_at_end(summary, looked)
    return summary["plies"]


@pytest.mark.parametrize("cells", [8, 16, 32])
@pytest.mark.parametrize("height", [0.3e-3, 1.0e-3])
def test_a_ply_between_plates_gets_as_thick_as_their_room_wherever_it_lies(cells, height):
    (ply,) = entries(plates(), [height], cells=cells, shear=math.radians(30.0))
    (cavity,) = ply["defects"]["cavities"]
    assert cavity["tools"] == ["lower", "upper"]
    assert cavity["area_share"] == pytest.approx(1.0)
    for name in ("room_m", "thickness_m"):
        assert cavity[name]["min"] == pytest.approx(GAP, rel=1e-5)
        assert cavity[name]["max"] == pytest.approx(GAP, rel=1e-5)
    expected = FLAT / (GAP * math.cos(math.radians(30.0)))
    assert cavity["fibre_volume_fraction"]["mean"] == pytest.approx(expected, rel=1e-5)


def test_plies_share_the_room_by_their_own_thickness():
    names = ["carbon_interlock", "synthetic_plain_crimp"]
    thick = [load_fabric(name).thickness for name in names]
    thin, fat = entries(plates(gap=3e-3), [0.5e-3, 2e-3], fabrics=names)
    for ply, own in ((thin, thick[0]), (fat, thick[1])):
        (cavity,) = ply["defects"]["cavities"]
        assert cavity["thickness_m"]["mean"] == pytest.approx(3e-3 * own / sum(thick), rel=1e-5)
        assert cavity["room_m"]["mean"] == pytest.approx(3e-3, rel=1e-5)
    (without,) = fat["defects"]["cavities"]  # that card has no density of fibres
    assert without["fibre_volume_fraction"] is None


def test_a_room_wider_than_the_threshold_is_no_cavity():
    for room, number in ((3.99, 1), (4.01, 0)):
        (ply,) = entries(plates(gap=room * CLOTH.thickness), [0.3e-3])
        assert len(ply["defects"]["cavities"]) == number
    (ply,) = entries(plates(gap=4.01 * CLOTH.thickness), [0.3e-3], cavity_room=5.0)
    assert len(ply["defects"]["cavities"]) == 1


def test_what_hangs_out_of_the_tools_and_what_has_one_tool_is_in_no_cavity():
    (ply,) = entries(plates(width=0.5 * SIDE), [0.3e-3], cells=40)
    (cavity,) = ply["defects"]["cavities"]
    # a vertex beyond the edge still faces the plates within 30° of its normal: less than a square
    assert cavity["area_share"] == pytest.approx(0.5, abs=0.026)
    (alone,) = entries(plates()[:1], [0.3e-3])
    assert alone["defects"]["cavities"] == []
    two_below = [plates()[0], Tool.plate("second", width=1.0, height=1.0).moved((0, 0, -1e-4))]
    (above,) = entries(two_below, [0.3e-3])
    assert above["defects"]["cavities"] == []


def test_the_room_between_spheres_is_that_of_their_radii():
    """A ply that leans by up to 20° off its shell: the ways are to the nearest points."""
    ply = Ply.rectangle("ply", CLOTH, SIDE, cells=20, mesh="grid")
    x, y = np.asarray(ply.mesh.vertices).T
    outwards = np.column_stack([x, y, np.full(len(x), 0.25)])
    outwards /= np.linalg.norm(outwards, axis=1, keepdims=True)
    ways = np.stack([0.4e-3 * outwards, -0.9e-3 * outwards])
    lean = np.array([math.sin(math.radians(20.0)), 0.0, 0.0])
    normals = outwards + lean
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    (cavity,) = find_cavities(ways, normals, np.asarray(ply.mesh.triangles), 2e-3)
    assert (cavity.below, cavity.above) == (0, 1) and cavity.inside.all()
    assert cavity.room == pytest.approx(1.3e-3)
    assert find_cavities(ways, normals, np.asarray(ply.mesh.triangles), 1.2e-3) == []
    steep = outwards + 0.75 * np.array([1.0, 0.0, 0.0])  # by 20° to 53°: it stands in the room
    steep /= np.linalg.norm(steep, axis=1, keepdims=True)
    lean = (steep * outwards).sum(axis=1)[np.asarray(ply.mesh.triangles)]
    (part,) = find_cavities(ways, steep, np.asarray(ply.mesh.triangles), 2e-3)
    np.testing.assert_array_equal(part.inside, (lean >= math.cos(math.radians(30.0))).all(axis=1))
    assert 0.02 < part.inside.mean() < 0.98


def test_two_pairs_of_tools_are_told_apart():
    """Left and right halves of a die under one plate: each pair has its own part of the ply."""
    left = Tool.plate("left", width=0.5, height=1.0).moved((-0.25, 0.0, 0.0))
    right = Tool.plate("right", width=0.5, height=1.0).moved((0.25, 0.0, -0.5e-3))
    upper = plates()[1]
    (ply,) = entries([left, right, upper], [0.3e-3], cells=40)
    one, other = ply["defects"]["cavities"]
    assert (one["tools"], other["tools"]) == (["left", "upper"], ["right", "upper"])
    assert one["thickness_m"]["max"] == pytest.approx(GAP, rel=0.05)
    assert other["thickness_m"]["max"] == pytest.approx(GAP + 0.5e-3, rel=1e-5)
    assert one["area_share"] + other["area_share"] == pytest.approx(1.0, abs=0.03)


def test_a_holder_s_flange_is_in_the_summary_but_not_in_the_words():
    die, plate = plates()
    press = replace(plate, motion=Float(force=10.0, mass=0.1))
    (ply,) = entries([die, press], [0.3e-3])
    assert ply["defects"]["cavities"][0]["under_force"]
    assert "if filled" not in defect_lines([ply])[0]


def test_the_edge_of_an_open_die_is_in_the_summary_but_not_in_the_words():
    """Where a punch passes it, some per cent of the ply are between two tools that are no mould."""
    (ply,) = entries(plates(), [0.3e-3])
    (cavity,) = ply["defects"]["cavities"]
    for share, told in ((0.04, False), (0.099, False), (0.1, True)):
        cavity["area_share"] = share
        assert ("if filled" in defect_lines([ply])[0]) == told


def test_the_words_tell_room_and_fibres():
    plies = entries(plates(), [0.3e-3])
    (line,) = defect_lines(plies)
    words = " ".join(line.split())
    assert "between lower and upper on 1e+02 %" not in words
    assert (
        f"between lower and upper on 100 %: if filled 1.5 mm thick, {1e2 * FLAT / GAP:.3g} %"
        in words
    )


def test_a_threshold_that_cannot_be_is_refused():
    with pytest.raises(InputError, match=r"cavity_room = 0\.0 must be"):
        DefectThresholds(cavity_room=0.0)
