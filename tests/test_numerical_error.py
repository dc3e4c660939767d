"""What a run says that its numerics may have cost, and that this is true."""

from dataclasses import replace
from html import escape

import numpy as np
import pytest
from numerical_error_checks import MEASURES, blank

from warpdrape.blanks.ply import Ply, longest_yarn
from warpdrape.report.words import result_section
from warpdrape.results import numerical_error as cost
from warpdrape.results.numerical_error import (
    numerical_error,
    numerical_error_text,
)
from warpdrape.results.summary_text import summary_text
from warpdrape.scenes import hemisphere


def test_yarns_are_as_long_as_the_blank_along_them():
    assert longest_yarn(blank()) == pytest.approx(0.3)
    assert longest_yarn(blank(90.0)) == pytest.approx(0.3)
    assert longest_yarn(blank(45.0)) == pytest.approx(0.5 / np.sqrt(2.0))


def test_every_cause_counts_and_they_add_up():
    given = {"softening_strain": 5e-4, "kinetic_ratio_loaded": 0.02, "max_penetration_m": 3e-5}
    found = numerical_error(MEASURES | given, [blank()])
    shear = {
        "softer_yarns": cost.SOFTENING_SHEAR * 5e-4,
        "inertia": cost.INERTIA_SHEAR * 0.02,
        "soft_contact": cost.CONTACT_SHEAR * 3e-5,
    }
    drawn = {
        "softer_yarns": cost.SOFTENING_DRAW_IN * 5e-4 * 0.3,
        "inertia": cost.INERTIA_DRAW_IN * 0.02 * 0.3,
        "soft_contact": cost.CONTACT_DRAW_IN * 3e-5,
    }
    for cause in shear:
        assert found[cause]["p95_shear_deg"] == pytest.approx(shear[cause]) and shear[cause] > 0.0
        assert found[cause]["draw_in_m"] == pytest.approx(drawn[cause]) and drawn[cause] > 0.0
    assert found["p95_shear_deg"] == pytest.approx(sum(shear.values()))
    assert found["draw_in_m"] == pytest.approx(sum(drawn.values()))
    nothing = numerical_error(MEASURES, [blank()])
    assert nothing["p95_shear_deg"] == nothing["draw_in_m"] == 0.0
    larger = numerical_error(MEASURES | given, [blank(), blank(45.0)])
    assert larger["draw_in_m"] > found["draw_in_m"]


MEASURED = {
    "hemisphere 0, softened 36, 80 ms": (0.3, 7.2e-4, 0.0088, 34e-6, 0.08, 0.14),
    "hemisphere 0, softened 100, 40 ms": (0.3, 15.2e-4, 0.0347, 55e-6, 0.19, 0.15),
    "hemisphere 0, contacts five times as soft": (0.3, 6.7e-4, 0.0088, 111e-6, 0.10, 0.12),
    "hemisphere 0, softened 16 times": (0.3, 3.6e-4, 0.0, 18e-6, 0.02, 0.093),
    "hemisphere 45, softened 36, 80 ms": (0.424, 4.5e-4, 0.0103, 6e-6, 0.01, 0.07),
    "hemisphere 45, softened 100, 40 ms": (0.424, 12.7e-4, 0.0424, 22e-6, 0.03, 0.19),
    "hemisphere of 14 cells, softened 36": (0.3, 12.9e-4, 0.0, 38e-6, 0.36, 0.09),
    "hemisphere of 14 cells, softened 100 times": (0.3, 26.4e-4, 0.0, 66e-6, 0.54, 0.18),
    "double dome, full stiffness, 80 ms": (0.4, 0.0, 0.0122, 10e-6, 0.12, 0.65),
    "double dome, softened 36, 80 ms": (0.4, 23.6e-4, 0.0120, 54e-6, 0.10, 0.34),
    "double dome, softened 100, 40 ms": (0.4, 55.7e-4, 0.0411, 105e-6, 0.49, 0.69),
    "double dome, softened 64 times": (0.4, 39.2e-4, 0.0, 75e-6, 0.38, 0.63),
    "square box, softened 36, 80 ms": (0.3, 18.7e-4, 0.0091, 37e-6, 0.66, 0.19),
    "square box, softened 36 times": (0.3, 19.5e-4, 0.0, 37e-6, 0.70, 0.18),
    "square box, softened 16 times": (0.3, 8.3e-4, 0.0, 20e-6, 0.25, 0.07),
    "square box, softened 100, 40 ms": (0.3, 41.9e-4, 0.0362, 85e-6, 0.96, 0.31),
    "tetrahedron, softened 36, 80 ms": (0.3, 14.6e-4, 0.0077, 24e-6, 0.03, 0.20),
    "tetrahedron, softened 100, 40 ms": (0.3, 34.8e-4, 0.0351, 50e-6, 0.04, 0.24),
    "double dome, standard": (0.4, 5e-4, 0.012, 41e-6, 0.08, 0.49),
    "double dome, draft": (0.4, 9e-4, 0.043, 90e-6, 0.25, 0.85),
    "square box, standard": (0.3, 4e-4, 0.010, 32e-6, 0.28, 0.06),
    "square box, draft": (0.3, 8e-4, 0.040, 69e-6, 0.49, 0.15),
    "tetrahedron, standard": (0.3, 2e-4, 0.008, 22e-6, 0.08, 0.11),
    "tetrahedron, draft": (0.3, 4e-4, 0.036, 35e-6, 0.17, 0.42),
}
"""Of runs of one ply against converged ones (docs/performance.md): longest yarn [m], strain owed,
kinetic over internal energy (0 where both had one stroke), deepest [m]; error of the percentile
[deg], of the draw-in [mm]."""


@pytest.mark.parametrize("run", MEASURED)
def test_the_estimate_covers_all_that_was_measured(run):
    """That is what its factors are: the most that each measure has cost."""
    length, strain, kinetic, depth, off_deg, off_mm = MEASURED[run]
    shown = {
        "softening_strain": strain,
        "kinetic_ratio_loaded": kinetic,
        "max_penetration_m": depth,
    }
    ply = Ply.rectangle("ply", "carbon_interlock", length, 0.2, cells=4, mesh="grid")
    said = numerical_error(MEASURES | shown, [ply])
    assert off_deg <= said["p95_shear_deg"] and off_mm <= 1e3 * said["draw_in_m"]


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"status": "failed"}, "the run failed"),
        ({"tools": []}, "nothing is pressed"),
        ({"quasi_static": False}, "not quasi-static"),
    ],
)
def test_where_nothing_can_be_said_that_is_said(change, reason):
    entry = numerical_error(MEASURES | change, [blank()])
    assert entry == {"not_known": reason}
    words = numerical_error_text({"numerical_error": entry, "plies": [{}]})
    assert words == f"what the numerics cost is not known: {reason}"


def test_what_was_measured_on_dry_plies_says_nothing_of_prepregs():
    wet = replace(blank(), fabric="synthetic_prepreg")
    reason = "it was measured on dry plies, and a matrix is in these"
    assert numerical_error(MEASURES, [blank(), wet]) == {"not_known": reason}


def said(entry, plies):
    """An estimate in words, in a run of so many plies."""
    return numerical_error_text({"numerical_error": entry, "plies": [{}] * plies})


def test_a_summary_without_an_estimate_says_nothing():
    """One of an older run, or of a net."""
    assert numerical_error_text({"plies": [{}]}) == ""


def test_the_words_name_what_counts():
    given = {"softening_strain": 1e-3, "kinetic_ratio_loaded": 1e-6, "max_penetration_m": 1e-8}
    entry = numerical_error(MEASURES | given, [blank()])
    words = said(entry, 1)
    assert "may be off by 0.33° and 0.20 mm (softer yarns 0.33° and 0.20 mm)" in words
    assert "rounding" not in words and "rounding alone" in said(entry, 3)
    none = said(numerical_error(MEASURES, [blank()]), 1)
    assert none.endswith("may be off by 0.00° and 0.00 mm")


def test_run_and_report_say_it(pressed):
    result, _ = pressed
    words = numerical_error_text(result.summary)
    assert "numerics" in words and escape(words) in str(result_section(result.summary))
    assert words in " ".join(summary_text(result.summary).split())


def test_softer_yarns_and_contacts_cost_no_more_than_is_said():
    """At one stroke, so that inertia is common: 0.03°, and 0.12° where soft yarns stay so."""
    given = {"duration": 0.08}
    scenes = {name: hemisphere.build(accuracy=name, **given) for name in ("standard", "reference")}
    softer = replace(scenes["standard"].numerics, yarn_softening=36.0, yarn_recovery=0.0)
    scenes["softer"] = replace(scenes["standard"], numerics=softer)
    runs = {name: scene.run(frames=6, threads=1).summary for name, scene in scenes.items()}
    assert runs["standard"]["steps"] < 0.2 * runs["reference"]["steps"]
    exact = runs["reference"]["plies"][0]
    for accuracy in ("softer", "standard"):
        said, found = runs[accuracy]["numerical_error"], runs[accuracy]["plies"][0]
        off = abs(found["p95_shear_deg"] - exact["p95_shear_deg"])
        drawn = max(abs(v - exact["draw_in_m"][k]) for k, v in found["draw_in_m"].items())
        shear, way = (
            said["softer_yarns"][name] + said["soft_contact"][name]
            for name in ("p95_shear_deg", "draw_in_m")
        )
        assert off <= shear <= said["p95_shear_deg"] < 1.5, accuracy
        assert drawn <= way <= said["draw_in_m"] < 2e-3, accuracy
    least = runs["reference"]["numerical_error"]
    assert least["softer_yarns"]["p95_shear_deg"] == 0.0
