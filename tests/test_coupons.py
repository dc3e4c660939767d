"""Coupon scenes: their files, their ends, what they refuse."""

import csv
import json
import math
from dataclasses import replace

import numpy as np
import pytest

from warpdrape.errors import InputError
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.materials.laws import IsotropicMembrane, NoShear
from warpdrape.scenes import bias_extension, biaxial_tension, picture_frame

WOVEN = load_fabric("carbon_interlock")
SLANTED = replace(WOVEN, yarn_angle=math.radians(60.0))
SHEET = replace(WOVEN, tension=IsotropicMembrane(1e4, 0.3), shear=NoShear())


def read(folder):
    with (folder / "coupon.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    columns = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
    return columns, json.loads((folder / "summary.json").read_text("utf-8"))


@pytest.mark.parametrize("mesh", ["crossed", "random"])
def test_picture_frame_writes_its_curve(tmp_path, mesh):
    scene = picture_frame.build(edge=0.025, mesh=mesh, shear_angle_deg=30.0, duration=0.05)
    result = scene.run(tmp_path, frames=30)
    curve, summary = read(tmp_path)
    assert summary["status"] == "completed" and summary["quasi_static"]
    coupon = summary["coupon"]
    assert coupon["shear_angle_deg"] == pytest.approx(30.0, abs=1e-9)
    assert coupon["force_n"] == pytest.approx(coupon["closed_form_force_n"], rel=0.01)
    late = curve["shear_angle_deg"] > 10.0
    exact = curve["closed_form_force_n"][late]
    np.testing.assert_allclose(curve["force_n"][late], exact, rtol=0.01)
    np.testing.assert_allclose(result.plies[0].shear_angle_deg, 30.0, atol=0.05)
    assert (tmp_path / "coupon.png").stat().st_size > 1000
    assert result.history["frame_displacement_m"][-1] == pytest.approx(coupon["travel_m"])


def test_a_coupon_says_from_where_on_inertia_bears_little(tmp_path):
    slow, hasty = (
        bias_extension.build(edge=0.02, shear_angle_deg=40.0, duration=duration)
        for duration in (0.06, 0.02)
    )
    starts = []
    for name, scene in (("slow", slow), ("hasty", hasty)):
        result = scene.run(tmp_path / name, frames=40)
        curve, summary = read(tmp_path / name)
        start = summary["coupon"]["quasi_static_from_shear_angle_deg"]
        after = curve["shear_angle_deg"] >= start
        kinetic, internal = result.history["kinetic_j"], result.history["internal_j"]
        assert (kinetic[after] < 0.05 * internal[after]).all()
        assert kinetic[~after][-1] >= 0.05 * internal[~after][-1]
        off = curve["force_n"][after] / curve["closed_form_force_n"][after] - 1.0
        assert np.abs(off).max() < 0.1
        starts.append(start)
    assert 2.0 < starts[0] < starts[1]


@pytest.mark.parametrize(
    ("coupon", "edge", "limit", "error"),
    [
        (picture_frame, 0.05, 1.5, 0.02),
        (bias_extension, 0.025, 3.0, 0.06),  # 2 % of it is not inertia's
    ],
    ids=["picture frame", "bias extension"],
)
def test_a_coupon_can_be_trusted_from_three_degrees_on(coupon, edge, limit, error, tmp_path):
    coupon.build(edge=edge).run(tmp_path, frames=80)
    curve, summary = read(tmp_path)
    assert 0.0 < summary["coupon"]["quasi_static_from_shear_angle_deg"] < limit
    late = (curve["shear_angle_deg"] > 3.0) & (curve["shear_angle_deg"] < 20.0)
    off = curve["force_n"][late] / curve["closed_form_force_n"][late] - 1.0
    assert late.sum() > 5 and np.abs(off).max() < error


def test_a_coupon_that_never_calms_says_so():
    scene = bias_extension.build(edge=0.02, shear_angle_deg=10.0, duration=0.004)
    summary = scene.run(frames=10).summary
    assert summary["coupon"]["quasi_static_from_shear_angle_deg"] is None
    assert not summary["quasi_static"]


@pytest.mark.parametrize("frames", [12, 40])
def test_few_frames_do_for_the_force_where_it_rises_steeply(frames):
    scene = picture_frame.build(edge=0.05, shear_angle_deg=55.0, duration=0.05)
    coupon = scene.run(frames=frames).summary["coupon"]
    assert coupon["force_n"] == pytest.approx(coupon["closed_form_force_n"], rel=0.005)
    assert coupon["measured_shear_angle_deg"] == pytest.approx(55.0, abs=0.01)


def test_a_coupon_is_replaced_only_when_asked(tmp_path):
    scene = picture_frame.build(edge=0.05, shear_angle_deg=10.0, duration=0.005)
    scene.run(tmp_path, frames=5)
    with pytest.raises(InputError, match="overwrite"):
        scene.run(tmp_path, frames=5)
    scene.run(tmp_path, frames=5, overwrite=True)


def test_bias_extension_meets_the_closed_form_on_a_coarse_mesh(tmp_path):
    fabric = replace(load_fabric("carbon_interlock"), compressive_factor=1.0)
    scene = bias_extension.build(fabric=fabric, edge=0.02, shear_angle_deg=40.0, duration=0.04)
    result = scene.run(tmp_path, frames=40)
    curve, summary = read(tmp_path)
    coupon = summary["coupon"]
    assert coupon["force_n"] == pytest.approx(coupon["closed_form_force_n"], rel=0.03)
    assert coupon["measured_shear_angle_deg"] == pytest.approx(40.0, abs=1.0)
    assert curve["shear_angle_deg"][0] == curve["closed_form_force_n"][0] == 0.0
    assert json.loads((tmp_path / "run.json").read_text("utf-8"))["parameters"]["fabric"]
    # The force along the pull is the slope of the clamp's work.
    pull = result.history["upper_force_n"]
    assert pull[-1] == pytest.approx(curve["force_n"][-2:].mean(), rel=0.01)
    assert result.history["lower_force_n"][-1] == pytest.approx(-pull[-1], rel=0.05)


def test_biaxial_tension_meets_crimp_interchange(tmp_path):
    scene = biaxial_tension.build(edge=0.05, weft_strain=0.003, duration=0.005)
    scene.run(tmp_path, frames=20)
    coupon = read(tmp_path)[1]["coupon"]
    for family in ("warp", "weft"):
        assert coupon[f"{family}_force_n"] > 1000.0
        assert abs(coupon[f"{family}_force_error"]) < 1e-6


@pytest.mark.parametrize(
    ("build", "given", "words"),
    [
        (bias_extension.build, {"height": 0.15}, "at least 0.2"),
        (bias_extension.build, {"shear_angle_deg": 95.0}, "lie on each other"),
        (bias_extension.build, {"mesh": "alligned"}, "did you mean 'aligned'"),
        (bias_extension.build, {"mesh": "random", "mesh_angle_deg": 15.0}, "leave it at 0"),
        (bias_extension.build, {"width": -0.1}, "width"),
        (bias_extension.build, {"edge": 0.5}, "longer than the outline"),
        (picture_frame.build, {"shear_angle_deg": 0.0}, "between 0 and 90"),
        (picture_frame.build, {"side": 0.0}, "side"),
        (biaxial_tension.build, {"side": -0.1}, "side"),
        (picture_frame.build, {"fabric": "carbon_interlok"}, "carbon_interlock"),
        (biaxial_tension.build, {"warp_strain": 0.0, "weft_strain": 0.0}, "above 0"),
        (biaxial_tension.build, {"warp_strain": 1.0}, "fraction"),
        (biaxial_tension.build, {"weft_strain": -0.01}, "weft_strain"),
        (picture_frame.build, {"fabric": SHEET}, "has no yarns"),
        (bias_extension.build, {"fabric": SLANTED}, "60° from warp to weft"),
        (biaxial_tension.build, {"fabric": SLANTED}, "right angles"),
        (bias_extension.build, {"duration": -1.0}, "^duration = -1.0 s"),
    ],
)
def test_impossible_specimens_are_refused(build, given, words):
    with pytest.raises(InputError, match=words):
        build(**given)


@pytest.mark.parametrize("scene", [bias_extension, picture_frame, biaxial_tension])
def test_the_stabiliser_of_a_coupon_is_that_of_its_verification_on_any_mesh(scene):
    fine = scene.build(edge=0.002)
    assert len(fine.plies[0].mesh.triangles) > 3200  # where a press's would be ten times as large
    assert fine.numerics.stabiliser == 1.0
