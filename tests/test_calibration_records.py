"""What a machine adds to a record is taken off: slack, preload, toe, its own give."""

import math
from dataclasses import replace

import numpy as np
import pytest
from calibration_checks import pulled

from warpdrape.calibration.preparation import loading_curve
from warpdrape.calibration.raw_table import Specimen
from warpdrape.coupons.closed_forms import frame_angle, frame_force, frame_travel
from warpdrape.errors import InputError
from warpdrape.materials.fabric_library import load_fabric

CLOTH = load_fabric("carbon_interlock")


def test_machine_slack_and_preload_are_undone():
    angle = np.radians(np.linspace(0.0, 50.0, 400))
    travel, force = frame_travel(0.2, angle), frame_force(CLOTH, 0.2, angle)
    give, slack, tare = 2e-5, 3e-3, 1.5
    recorded = travel + give * force + slack
    values = {"side": 0.2, "compliance": give, "slack": slack, "tare": tare}
    test = pulled("picture_frame", {"travel": recorded, "force": force + tare}, values=values)
    curve = loading_curve(test, test.specimens[0])
    # bins of 0.6° under a curved line
    np.testing.assert_allclose(curve.force[3:], frame_force(CLOTH, 0.2, curve.at[3:]), rtol=2e-3)
    preload = float(np.interp(math.radians(5.0), angle, force))
    values = {"side": 0.2, "preload": preload}
    test = pulled("picture_frame", {"travel": travel + 0.01, "force": force}, values=values)
    curve = loading_curve(test, test.specimens[0])
    assert curve.raw_force[0] == pytest.approx(preload, rel=0.03)
    assert curve.raw_at[0] < math.radians(0.2)


def test_toe_empty_machine_sign_and_unloading():
    strain = np.concatenate([np.linspace(0.0, 0.02, 200), np.linspace(0.02, 0.01, 80)])
    force = 1e4 * np.maximum(strain - 0.004, 0.0)
    values = {"width": 0.05, "gauge": 0.2, "family": "warp"}
    columns = {"travel": -0.2 * strain, "force": -force}
    test = pulled("uniaxial_tension", columns, values=values, toe="line")
    curve = loading_curve(test, test.specimens[0])
    np.testing.assert_allclose(curve.force, 1e4 * curve.at, rtol=1e-3, atol=0.5)
    assert curve.failed_at == pytest.approx(0.016, rel=0.02)  # it fell by more than a fifth
    assert curve.raw_at[-1] == pytest.approx(0.016, rel=0.02)
    travel = np.linspace(0.0, 0.05, 100)
    empty = Specimen("e", "e.csv", {"travel": travel, "force": 3.0 + 0 * travel})
    test = pulled(
        "picture_frame", {"travel": travel, "force": 40 * travel + 3.0}, values={"side": 0.2},
        empty=empty,
    )  # fmt: skip
    curve = loading_curve(test, test.specimens[0])
    assert curve.raw_force[0] == pytest.approx(0.0, abs=1e-9)
    assert not any("beyond where it ends" in step for step in curve.steps)
    half = Specimen("e", "e.csv", {"travel": 0.5 * travel, "force": 3.0 + 0 * travel})
    steps = loading_curve(replace(test, empty=half), test.specimens[0]).steps
    assert "its last force beyond where it ends" in steps


def test_a_machine_gives_way_to_the_force_of_the_empty_frame_too():
    angle = np.radians(np.linspace(0.0, 50.0, 400))
    travel, force = frame_travel(0.2, angle), frame_force(CLOTH, 0.2, angle)
    give, rubbing, tare = 5e-5, 20.0, 1.5
    recorded = travel + give * (force + rubbing)
    values = {"side": 0.2, "compliance": give, "tare": tare}
    empty = Specimen("e", "e.csv", {"travel": np.array([0.0, 0.2]), "force": np.full(2, rubbing)})
    columns = {"travel": recorded, "force": force + rubbing + tare}
    test = pulled("picture_frame", columns, values=values, empty=empty)
    curve = loading_curve(test, test.specimens[0])
    np.testing.assert_allclose(curve.force[3:], frame_force(CLOTH, 0.2, curve.at[3:]), rtol=2e-3)


@pytest.mark.parametrize("signs", [(1, -1), (-1, 1), (-1, -1)])
def test_whichever_way_the_machine_counts(signs):
    """It counts an empty frame's force and a tare in the same way."""
    angle = np.radians(np.linspace(0.0, 50.0, 400))
    travel, force = frame_travel(0.2, angle), frame_force(CLOTH, 0.2, angle)
    rubbing, tare = 20.0 * travel, 1.5

    def curve(way, pull):
        values = {"side": 0.2, "tare": pull * tare}
        empty = Specimen("e", "e.csv", {"travel": way * travel, "force": pull * rubbing})
        columns = {"travel": way * travel, "force": pull * (force + rubbing + tare)}
        test = pulled("picture_frame", columns, values=values, empty=empty)
        return loading_curve(test, test.specimens[0])

    found = curve(*signs)
    np.testing.assert_array_equal(found.force, curve(1, 1).force)
    np.testing.assert_allclose(found.force[3:], frame_force(CLOTH, 0.2, found.at[3:]), rtol=2e-3)
    assert "pulling was negative" in found.steps[1]


@pytest.mark.parametrize("way", [1, -1])
def test_places_of_the_crosshead_want_a_preload(way):
    angle = np.radians(np.linspace(0.0, 50.0, 400))
    travel, force = frame_travel(0.2, angle), frame_force(CLOTH, 0.2, angle)
    columns = {"travel": 0.3 + way * travel, "force": force}
    preload = {"preload": float(force[8])}
    test = pulled("picture_frame", columns, values={"side": 0.2, **preload})
    curve = loading_curve(test, test.specimens[0])
    assert curve.raw_at[-1] == pytest.approx(frame_angle(0.2, travel[-1] - travel[8]))
    test = pulled("picture_frame", columns, values={"side": 0.2})
    with pytest.raises(InputError, match="not count from the start of its test: give preload, or"):
        loading_curve(test, test.specimens[0])


@pytest.mark.parametrize(
    ("kind", "columns", "values", "words"),
    [
        ("picture_frame", {"travel": np.linspace(0, 0.2, 50), "force": np.ones(50)},
         {"side": 0.2}, "yarns lie on each other"),
        ("picture_frame", {"angle": np.linspace(0, 2, 50), "force": np.ones(50)},
         {"side": 0.2}, "stay below 90°"),
        ("picture_frame", {"travel": np.linspace(0, 0.01, 5), "force": np.ones(5)},
         {"side": 0.2}, "fewer than 8"),
        ("picture_frame", {"travel": np.linspace(0, 0.01, 50), "force": np.ones(50)},
         {"side": 0.2, "preload": 5.0}, "never reaches the preload of 5 N"),
        ("picture_frame", {"angle": np.linspace(0, 0.5, 50), "force": np.ones(50)},
         {"side": 0.2, "compliance": 1e-6}, "compliance corrects a travel"),
    ],
)  # fmt: skip
def test_records_that_cannot_be_used(kind, columns, values, words):
    test = pulled(kind, columns, values=values)
    with pytest.raises(InputError) as error:
        loading_curve(test, test.specimens[0])
    assert words in str(error.value)


def test_until_cuts_off_what_goes_beyond_all_bounds():
    travel = np.linspace(0.0, 0.2, 200)
    values = {"side": 0.2, "until": math.radians(40.0)}
    test = pulled("picture_frame", {"travel": travel, "force": 1.0 + travel}, values=values)
    curve = loading_curve(test, test.specimens[0])
    assert math.radians(38.0) < curve.raw_at[-1] <= math.radians(40.0)
