"""A run says where a ply has left the range in which its fabric was measured."""

import math
from dataclasses import replace

import numpy as np
import pytest
from law_checks import crimp_table

from warpdrape import BendingCurve, Compaction, Ply
from warpdrape.materials.fabric_card import card
from warpdrape.materials.fabric_library import with_bending
from warpdrape.materials.laws import ShearTable
from warpdrape.results.beyond_data import beyond_data
from warpdrape.results.result import FormedPly
from warpdrape.scenes import picture_frame

CLOTH = with_bending("carbon_interlock", "none")
TWENTY = ShearTable(np.radians([0.0, 10.0, 20.0]), (0.0, 1e-4, 2e-4))


def formed(ply, shear_deg=0.0, strain=0.0, curvature=None):
    m = len(ply.mesh.triangles)
    along = np.broadcast_to((1.0, 0.0, 0.0), (m, 3))
    return FormedPly(
        name=ply.name,
        rest_points=ply.rest_points,
        points=ply.rest_points,
        triangles=np.asarray(ply.mesh.triangles),
        warp=along,
        weft=along,
        shear_angle=np.radians(np.broadcast_to(shear_deg, m)),
        strain=np.broadcast_to(strain, (m, 2)),
        line_tension=np.zeros((m, 2)),
        curvature=curvature,
    )


def test_shear_beyond_the_last_angle_of_a_table():
    ply = Ply.rectangle("ply", replace(CLOTH, shear=TWENTY), 0.1, cells=4, mesh="grid")
    m = len(ply.mesh.triangles)
    angles = np.where(np.arange(m) < m // 4, -35.0, 19.0)
    (found,) = beyond_data(ply, formed(ply, angles))
    assert (found.largest, found.last) == (pytest.approx(35.0), pytest.approx(20.0))
    assert found.share == pytest.approx(0.25)
    assert found.words("ply").startswith(
        "ply 'ply': shear angle comes to 35°, beyond the last of its fabric's data, 20°, on 25 % "
    )
    assert beyond_data(ply, formed(ply, 19.9)) == []
    assert beyond_data(replace(ply, fabric=CLOTH), formed(ply, 60.0)) == []  # a formula has no end


def test_strain_beyond_a_table_of_tensions():
    table = crimp_table()
    ply = Ply.rectangle("ply", replace(CLOTH, tension=table), 0.1, cells=4)
    last = float(table.strain_weft[-1])
    (found,) = beyond_data(ply, formed(ply, strain=(0.0, 1.1 * last)))
    assert found.quantity == "weft strain" and found.share == pytest.approx(1.0)


def test_curvature_beyond_a_curve_of_moments():
    curve = BendingCurve(curvatures=(0, 10, 50), moments_warp=(0, 1, 2), moments_weft=(0, 1, 2))
    ply = Ply.rectangle("ply", replace(CLOTH, bending=curve), 0.1, cells=4)
    bent = np.zeros((len(ply.mesh.vertices), 2))
    bent[:2, 0] = -80.0
    (found,) = beyond_data(ply, formed(ply, curvature=bent))
    assert (found.quantity, found.largest) == ("warp curvature", 80.0)
    assert found.share == pytest.approx(2.0 / len(bent))


def test_a_run_says_it_and_the_card_marks_it():
    scene = picture_frame.build(shear_angle_deg=30.0, duration=0.01)
    cloth = replace(scene.plies[0].fabric, shear=TWENTY)
    result = replace(scene, plies=[replace(scene.plies[0], fabric=cloth)], report=None).run(
        frames=2
    )
    (entry,) = result.summary["plies"][0]["beyond_data"]
    assert entry["last"] == pytest.approx(20.0) and entry["share"] > 0.9
    assert any("shear angle comes to 30°" in words for words in result.summary["warnings"])
    lines = card(cloth).splitlines()
    for angle in (30, 45, 60):
        (line,) = (line for line in lines if f"shear force at {angle}°" in line)
        assert line.endswith("extrapolated")
    assert math.isclose(cloth.shear.angles[-1], math.radians(20.0))


def test_pressure_beyond_a_compaction_law():
    law = Compaction(thicknesses=(6e-4, 5e-4, 4e-4), pressures=(0.0, 1e4, 1e5))
    ply = Ply.rectangle("ply", replace(CLOTH, compaction=law), 0.1, cells=4)
    pressure = np.zeros(len(ply.mesh.vertices))
    pressure[:3] = 2e5
    (found,) = beyond_data(ply, replace(formed(ply), tool_pressure=pressure))
    assert "tool pressure comes to 200 kPa, beyond the last of its fabric's data, 100 kPa, on" in (
        found.words("ply")
    )
    assert beyond_data(ply, replace(formed(ply), contact_pressure=0.4 * pressure)) == []
