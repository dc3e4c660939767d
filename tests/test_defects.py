"""Thickness, fibre volume fraction, yarns past their limits, draw-in along the outline."""

import math
from dataclasses import replace

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from warpdrape import DefectThresholds, InputError, Scene, WantedDirection
from warpdrape.blanks.ply import Ply
from warpdrape.defects.alignment import misalignments
from warpdrape.defects.outline import outline_draw_in
from warpdrape.defects.thickness import (
    area_ratios,
    fibre_volume_fractions,
    thicknesses,
    yarn_area_ratios,
)
from warpdrape.defects.yarn_limits import shear_past_locking, yarn_strains
from warpdrape.materials.compaction import Compaction
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.results.defect_text import defect_lines, wrinkle_words
from warpdrape.results.defects import (
    DefectWatch,
    defect_columns,
    defect_entries,
    first_wrinkle,
)
from warpdrape.results.result import FormedPly
from warpdrape.scenes import hemisphere

SIDE = 0.2
CLOTH = load_fabric("carbon_interlock")


def square(cells=8, fabric="carbon_interlock", mesh="grid", **options):
    return Ply.rectangle("ply", fabric, SIDE, cells=cells, mesh=mesh, **options)


def test_shear_raises_the_fibre_volume_fraction_by_one_over_its_cosine():
    ply, shear = square(), math.radians(40.0)
    x, y = np.asarray(ply.mesh.vertices).T
    points = np.column_stack([x + y * math.sin(shear), y * math.cos(shear), 0.0 * x])
    triangles = np.asarray(ply.mesh.triangles)
    ratios = area_ratios(np.asarray(ply.mesh.areas), points, triangles)
    assert ratios == pytest.approx(math.cos(shear))
    strain, angles = np.zeros((len(triangles), 2)), np.full(len(triangles), shear)
    assert yarn_area_ratios(strain, angles, 0.5 * math.pi) == pytest.approx(ratios)
    thickness = thicknesses(CLOTH, [], triangles)
    flat = CLOTH.areal_density / (CLOTH.fibre_density * CLOTH.thickness)
    found = fibre_volume_fractions(CLOTH, ratios, thickness)
    assert found == pytest.approx(flat / math.cos(shear))
    assert 0.55 < flat < 0.65


def test_strain_and_skew_yarns_change_the_area_as_the_triangles_do():
    """A stretched and sheared ply whose yarns met at 70°."""
    cloth = replace(CLOTH, yarn_angle=math.radians(70.0))
    ply = square(fabric=cloth, mesh="diagonal")
    stretch = np.array([[1.05, 0.3], [0.02, 0.9]])
    flat = np.asarray(ply.mesh.vertices)
    points = np.column_stack([flat @ stretch.T, np.zeros(len(flat))])
    triangles = np.asarray(ply.mesh.triangles)
    expected = area_ratios(np.asarray(ply.mesh.areas), points, triangles)
    warp, weft = (stretch @ way for way in ply.yarn_directions)
    lengths = np.linalg.norm(warp), np.linalg.norm(weft)
    angle = math.acos(warp @ weft / (lengths[0] * lengths[1]))
    strain = np.tile(np.array(lengths) - 1.0, (len(triangles), 1))
    shear = np.full(len(triangles), cloth.yarn_angle - angle)
    assert yarn_area_ratios(strain, shear, cloth.yarn_angle) == pytest.approx(expected)


def test_a_ply_with_a_compaction_law_is_as_thick_as_its_pressure_leaves_it():
    law = Compaction(thicknesses=(6e-4, 5e-4, 4e-4), pressures=(0.0, 1e4, 5e4))
    cloth, triangles = replace(CLOTH, compaction=law), np.array([[0, 1, 2]])
    of_plies, of_tools = np.array([1e4, 0.0, 1e4]), np.array([0.0, 1e4, 1e4])
    assert thicknesses(cloth, [of_plies, of_tools], triangles) == pytest.approx(5e-4, rel=1e-3)
    assert thicknesses(cloth, [0.0 * of_plies], triangles) == pytest.approx(6e-4)
    thin = fibre_volume_fractions(cloth, np.ones(1), np.full(1, 3e-4))
    assert thin == pytest.approx(2 * fibre_volume_fractions(cloth, np.ones(1), np.full(1, 6e-4)))


def test_without_the_fibres_density_there_is_no_volume_fraction():
    cloth = replace(CLOTH, fibre_density=None)
    assert fibre_volume_fractions(cloth, np.ones(2), np.full(2, 6e-4)) is None


def test_shear_past_locking_is_judged_by_the_card_alone():
    shear, areas = np.radians([10.0, -50.0, 47.0]), np.array([1.0, 2.0, 5.0])
    unknown = replace(CLOTH, locking_angle=None)
    assert shear_past_locking(unknown, shear, areas)["area_share"] is None
    locking = replace(CLOTH, locking_angle=math.radians(48.0))
    found = shear_past_locking(locking, shear, areas)
    assert found["area_share"] == pytest.approx(2.0 / 8.0)
    assert found["max_past_deg"] == pytest.approx(2.0)
    assert shear_past_locking(locking, 0.5 * shear, areas)["max_past_deg"] == 0.0


def test_yarns_past_failure_and_in_compression():
    strain = np.array([[0.02, -0.01], [0.01, -1e-4], [-0.003, 0.0]])
    areas = np.array([1.0, 2.0, 5.0])
    cloth = replace(CLOTH, failure_strain_warp=0.015, failure_strain_weft=None)
    found = yarn_strains(cloth, strain, areas, compression=1e-3)
    assert found["warp"]["failed_area_share"] == pytest.approx(1 / 8)
    assert found["warp"]["compressed_area_share"] == pytest.approx(5 / 8)
    assert found["weft"]["failed_area_share"] is None
    assert found["weft"]["compressed_area_share"] == pytest.approx(1 / 8)
    assert found["weft"]["min_strain"] == -0.01 and found["warp"]["max_strain"] == 0.02


@pytest.mark.parametrize("mesh", ["grid", "random"])
def test_draw_in_all_along_the_outline(mesh):
    """A square that shrinks by 10 % along x and slides by 1 mm along y."""
    ply = square(mesh=mesh)
    points = ply.rest_points * [0.9, 1.0, 1.0] + [0.0, 1e-3, 5e-3]
    found = outline_draw_in(ply.mesh, points)
    x, y, drawn = (np.array(found[name]) for name in ("x_m", "y_m", "draw_in_m"))
    half = 0.5 * SIDE
    right = (x > half - 1e-9) & (np.abs(y) < half - 1e-9)
    top = (y > half - 1e-9) & (np.abs(x) < half - 1e-9)
    assert right.sum() >= 5 and drawn[right] == pytest.approx(0.1 * half)
    assert drawn[top] == pytest.approx(-1e-3)
    assert found["max_m"] == pytest.approx(drawn.max()) and found["min_m"] == drawn.min()
    along = np.array(found["along_m"])
    assert (np.diff(along) > 0.0).all() and along[-1] < 4 * SIDE
    sides = (0.1 * half + 0.1 * half - 1e-3 + 1e-3) / 4.0
    assert found["mean_m"] == pytest.approx(sides, rel=0.2)  # but for the corners


def test_a_hole_is_no_part_of_the_outline():
    corners = 0.5 * SIDE * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    ply = Ply.polygon("ply", "carbon_interlock", corners, holes=[0.4 * corners], edge=0.02)
    found = outline_draw_in(ply.mesh, ply.rest_points)
    assert np.abs(np.stack([found["x_m"], found["y_m"]])).max(axis=0) == pytest.approx(0.5 * SIDE)


def test_the_first_wrinkle_has_time_and_travel():
    scene = Scene(name="s", plies=[square()], duration=1.0)
    history = {"time_s": np.array([0.0, 1.0, 2.0]), "ply_wrinkle_m": np.array([0.0, 0.0, 1e-3])}
    found = first_wrinkle(scene, "ply", history, resolved=True)
    assert found == {"frame": 2, "time_s": 2.0, "displacement_m": {}}
    history["ply_wrinkle_m"][:] = 0.0
    assert first_wrinkle(scene, "ply", history, resolved=True) is None


def numbers(count, amplitude=0.0, first=None):
    entry = {"number": count, "max_amplitude_m": amplitude, "area_share": 0.1, "first": first}
    return entry | {"excess_length_m": 0.0}


def test_wrinkles_in_words():
    first = {"frame": 3, "time_s": 0.05, "displacement_m": {"punch": 0.06, "die": 0.0}}
    none = numbers(0)
    assert wrinkle_words(none | {"too_short_for_the_mesh": none}) == "no wrinkles"
    two = wrinkle_words(numbers(2, 1.5e-3, first) | {"too_short_for_the_mesh": none})
    assert two == (
        "2 wrinkles, the largest of amplitude 1.5 mm, on 10 % of it, the first at 50 ms, "
        "punch 60.0 mm"
    )
    short = wrinkle_words(none | {"too_short_for_the_mesh": numbers(1, 1e-3)})
    assert short.startswith("no wrinkles; 1 wave, the largest") and "refine" in short


def waved(scene, amplitude):
    """The scene's ply as a sheet of waves along x, sheared by nothing."""
    (ply,) = scene.plies
    points = ply.rest_points.copy()
    points[:, 2] += amplitude * np.sin(2.0 * np.pi / 0.03 * points[:, 0])
    m = len(ply.mesh.triangles)
    return FormedPly(
        name=ply.name,
        rest_points=ply.rest_points,
        points=points,
        triangles=np.asarray(ply.mesh.triangles),
        warp=np.broadcast_to((1.0, 0.0, 0.0), (m, 3)),
        weft=np.broadcast_to((0.0, 1.0, 0.0), (m, 3)),
        shear_angle=np.zeros(m),
        strain=np.zeros((m, 2)),
        line_tension=np.zeros((m, 2)),
    )


def test_wrinkles_come_into_the_history_and_the_summary():
    scene = Scene(name="s", plies=[square(cells=40)], duration=1.0)
    watch, rows, plies = DefectWatch(scene), [], ()
    for time, amplitude in ((0.0, 0.0), (0.5, 1e-4), (1.0, 1e-3)):
        plies = watch.look([waved(scene, amplitude)], [])
        rows.append({"time_s": time} | defect_columns(plies[0]))
    history = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    assert history["ply_wrinkle_m"] == pytest.approx([0.0, 0.0, 1e-3], rel=0.05)
    assert (history["ply_short_wrinkle_m"] == 0.0).all()
    entries = defect_entries(scene, 0, plies[0], history)
    wrinkles = entries["defects"]["wrinkles"]
    assert wrinkles["number"] == len(wrinkles["list"]) == 6
    assert wrinkles["first"]["time_s"] == 1.0
    assert wrinkles["max_amplitude_m"] == history["ply_wrinkle_m"][-1]
    largest = wrinkles["list"][0]
    assert largest["angle_to_weft_deg"] < 2.0 and largest["angle_to_warp_deg"] > 88.0
    assert largest["tool"] is None and largest["resolved"]
    assert np.array(largest["at_m"])[:2] == pytest.approx(largest["on_blank_m"])
    assert entries["thickness_m"]["mean"] == pytest.approx(CLOTH.thickness)
    assert plies[0].wrinkle.max() == pytest.approx(1e-3, rel=0.05)
    (line,) = defect_lines([{"name": "ply"} | entries])
    assert line.startswith("ply: 6 wrinkles") and "fibre volume 59.7" in line


def test_a_look_depends_on_the_plies_as_they_are_alone():
    """A run that goes on from a checkpoint must say what the uninterrupted one says."""
    scene = Scene(name="s", plies=[square(cells=30)], duration=1.0)
    watch = DefectWatch(scene)
    watch.look([waved(scene, 1e-3)], [])
    (again,) = watch.look([waved(scene, 1.001e-3)], [])
    (anew,) = DefectWatch(scene).look([waved(scene, 1.001e-3)], [])
    np.testing.assert_array_equal(again.wrinkle, anew.wrinkle)
    assert again.wrinkling.wrinkles == anew.wrinkling.wrinkles
    assert again.wrinkle.max() > 0.0


def test_a_run_writes_its_defects(tmp_path):
    scene = hemisphere.build(cells=6, duration=0.004, travel=0.004)
    result = scene.run(tmp_path / "run", frames=2)
    (formed,), (entry,) = result.plies, result.summary["plies"]
    assert entry["defects"]["wrinkles"]["number"] == 0
    assert entry["defects"]["bridging"]["number"] == 0
    assert set(entry["defects"]) == {
        "wrinkles",
        "bridging",
        "cavities",
        "shear",
        "yarns",
        "draw_in",
        "misalignment",
    }
    assert 0.0 < result.summary["tools"][1]["coverage"] < 1.0
    assert (result.history["ply_0_wrinkle_m"] == 0.0).all()
    stage = Usd.Stage.Open(str(tmp_path / "run" / "scene.usdc"))
    primvars = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/World/plies/ply_0"))
    for name, values in (
        ("wrinkle", formed.wrinkle),
        ("thickness", formed.thickness),
        ("fibreVolumeFraction", formed.fibre_volume_fraction),
    ):
        primvar = primvars.GetPrimvar(name)
        assert primvar.GetInterpolation() == "uniform"
        assert np.array(primvar.Get(2)) == pytest.approx(values, rel=1e-6)
        assert len(primvar.GetAttr().GetTimeSamples()) == 3


def test_misalignment_is_the_angle_in_the_ply_s_plane():
    """A flat ply tilted by 50° about x, its warp turned by 20° in its own plane."""
    ply, tilt, turn = square(), math.radians(50.0), math.radians(20.0)
    flat = np.asarray(ply.mesh.vertices)
    up = np.array([0.0, math.cos(tilt), math.sin(tilt)])
    points = flat[:, :1] * [1.0, 0.0, 0.0] + flat[:, 1:] * up
    triangles = np.asarray(ply.mesh.triangles)
    yarn = math.cos(turn) * np.array([1.0, 0.0, 0.0]) - math.sin(turn) * up
    yarns = np.tile(yarn, (len(triangles), 1))
    assert misalignments(yarns, points, triangles, (-3.0, 0.0, 0.0)) == pytest.approx(turn)
    right = misalignments(yarns, points, triangles, (0.0, 0.0, 1.0))  # projects on up
    assert right == pytest.approx(0.5 * math.pi - turn)


def test_wanted_directions_by_region_come_into_the_summary():
    left = WantedDirection(name="left", ply="ply", direction=(1, 1, 0), where=lambda p: p[:, 0] < 0)
    all_over = WantedDirection(name="all", ply="ply", direction=(0, 1, 0), family="weft")
    scene = Scene(name="s", plies=[square()], duration=1.0, wanted=[left, all_over])
    (formed,) = DefectWatch(scene).look([waved(scene, 0.0)], [])
    one, other = defect_entries(scene, 0, formed, {})["defects"]["misalignment"]
    assert (one["name"], one["mean_deg"]) == ("left", pytest.approx(45.0))
    assert other["max_deg"] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"direction": (0.0, 0.0, 0.0)}, "must not be zero"),
        ({"family": "both"}, "unknown family"),
        ({"where": lambda p: p[:, 0] > 9.0}, "holds no triangle"),
        ({"where": lambda p: p[:, 0]}, "truth values"),
        ({"ply": "other"}, "unknown ply 'other'"),
    ],
)
def test_bad_wanted_directions_are_refused(options, words):
    given = {"name": "rib", "ply": "ply", "direction": (1.0, 0.0, 0.0)} | options
    with pytest.raises(InputError, match=words):
        Scene(name="s", plies=[square()], duration=1.0, wanted=[WantedDirection(**given)])


def test_bad_thresholds_are_refused():
    for bad in ({"longest_wrinkle": 0.0}, {"longest_wrinkle": 1.5}, {"wrinkle_amplitude": -1.0}):
        with pytest.raises(InputError, match=next(iter(bad))):
            DefectThresholds(**bad)
    with pytest.raises(InputError, match="DefectThresholds"):
        Scene(name="s", plies=[square()], duration=1.0, defects={"bridge_gap": 1.0})


def test_more_fibres_than_fit_are_not_passed_over():
    scene = Scene(name="s", plies=[square()], duration=1.0)
    sheared = waved(scene, 0.0)
    sheared = replace(sheared, shear_angle=np.full(len(sheared.triangles), math.radians(55.0)))
    (formed,) = DefectWatch(scene).look([sheared], [])
    (line,) = defect_lines([{"name": "ply"} | defect_entries(scene, 0, formed, {})])
    assert "to 104 %, more than fits" in " ".join(line.split())


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"fibre_density": 900.0}, "fills 117 % of the ply"),
        ({"fibre_density": 0.0}, "above zero"),
        ({"locking_angle": 48.0}, "between 0 and 1.57"),
        ({"failure_strain_weft": 1.5}, "give 0.015 for 1.5 %"),
    ],
)
def test_limits_of_another_unit_are_refused(values, words):
    with pytest.raises(InputError, match=words):
        replace(CLOTH, **values)
