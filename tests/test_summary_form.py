"""Every entry of a summary with every odd value: refused by its name, or whoever reads it can."""

import copy
import json

import pytest
from run_damage import ODD, places

from warpdrape.defects.limits import Limits
from warpdrape.errors import InputError
from warpdrape.report import words
from warpdrape.results.judgement import judge, not_judged, verdict
from warpdrape.results.judgement_picture import _mark
from warpdrape.results.summary_form import odd_entries

GONE = object()
STRICT = Limits(
    wrinkle_amplitude=0.0,
    wrinkle_area=0.0,
    shear_deg=1.0,
    past_locking_area=0.0,
    bridge_gap=0.0,
    yarn_strain=0.0,
    failed_yarn_area=0.0,
    fibre_volume_fraction=0.1,
    misalignment_deg={"rib": 1.0},
)
FIRST = {"time_s": 0.01, "displacement_m": {"punch": -0.02}}
PLACE = {"at_m": [0.1, 0.0, -0.01], "on_blank_m": [0.12, 0.0]}


class Plan:
    """In place of matplotlib's axes."""

    def plot(self, *_, **__):
        pass

    annotate = plot


def wrinkles():
    """One that the mesh resolves, and one that it does not."""
    shape = PLACE | {"axis_on_blank": [1.0, 0.0], "length_m": 0.03}
    sums = {"number": 1, "max_amplitude_m": 2e-3, "area_share": 0.1, "first": FIRST}
    sizes = ((2e-3, True), (2e-3, False))
    return copy.deepcopy(sums) | {
        "too_short_for_the_mesh": copy.deepcopy(sums),
        "list": [shape | {"amplitude_m": size, "resolved": well} for size, well in sizes],
    }


def bridging():
    """Likewise of bridges."""
    sums = {"number": 1, "max_gap_m": 3e-3, "area_m2": 1e-4}
    one = {"tool": "punch", "gap_m": 3e-3, **PLACE}
    listed = [one | {"resolved": True}, one | {"resolved": False}]
    return sums | {"too_small_for_the_mesh": dict(sums), "list": listed}


@pytest.fixture
def good(pressed):
    """The summary of a press with one of everything that is read."""
    summary = json.loads(json.dumps(pressed[0].summary))
    del summary["plies"][1:]
    defects = summary["plies"][0]["defects"]
    for name in ("along_m", "x_m", "y_m", "draw_in_m"):
        del defects["draw_in"][name]
    spread = {"min": 0.5, "mean": 0.6, "max": 0.7}
    cavity = {"tools": ["die", "punch"], "under_force": False, "area_share": 0.5}
    cavity |= {"thickness_m": dict(spread), "fibre_volume_fraction": dict(spread)}
    rib = {"name": "rib", "family": "warp", "mean_deg": 4.0, "max_deg": 9.0}
    judged = {"locking_angle_deg": 40.0, "max_past_deg": 1.0, "area_share": 0.1}
    defects |= {"wrinkles": wrinkles(), "bridging": bridging(), "cavities": [cavity]}
    defects["misalignment"] = [rib]
    defects["shear"] |= judged
    summary |= {"made_up": 1.5, "reported": ["made_up"]}
    summary |= {"kinetic_limit": 0.1, "slowest_pace": 0.5, "kinetic_over_limit": 0.7}
    summary["process_clock"] = {"process_s": 1.0, "inertia": 10.0}
    parts = dict.fromkeys(("p95_shear_deg", "draw_in_m"), 0.01)
    causes = ("softer_yarns", "inertia", "soft_contact")
    summary["numerical_error"] = parts | {name: dict(parts) for name in causes}
    return summary


def read(summary):
    """All that the commands and notebooks read of a summary."""
    for limits in (Limits(), STRICT):
        faults = judge(summary, {}, limits)
        verdict(faults, not_judged(summary, limits))
        for ply in summary["plies"]:
            _mark(Plan(), ply["name"], ply["defects"], faults)
    words.result_section(summary)
    words.side_by_side(["one", "other"], [summary, summary])


def test_one_of_everything_is_taken_and_said(good):
    assert odd_entries(good) == []
    said = str(words.result_section(good))
    for part in ("1 wrinkle", "1 wave", "1 bridge", "off rib by 4.0", "past locking", "if filled"):
        assert part in said, part
    assert len(judge(good, {}, STRICT)) > 8


def test_every_odd_value_is_refused_by_its_name_or_can_be_read(good):
    taken = refused = 0
    for way in list(places(good)):
        owner = good
        for key in way[:-1]:
            owner = owner[key]
        was = owner[way[-1]]
        for odd in (*ODD, GONE):
            if odd is GONE:
                del owner[way[-1]]
            else:
                owner[way[-1]] = odd
            found = odd_entries(good)
            if found:
                refused += 1
                assert all(isinstance(name, str) and name for name in found)
                assert any(str(key) in " ".join(found) for key in way), (way, odd, found)
            else:
                taken += 1
                try:
                    read(good) if all("defects" in ply for ply in good["plies"]) else None
                except InputError:
                    assert way[0] in ("limits", "plies")  # others than are known: said so
                except Exception as error:
                    raise AssertionError(f"{way} = {odd!r}: {error!r}") from error
            if odd is GONE and isinstance(owner, list):
                owner.insert(way[-1], was)
            else:
                owner[way[-1]] = was
    assert taken > 500 and refused > 2000


@pytest.mark.parametrize(
    ("way", "value", "named"),
    [
        (("plies", 0, "defects", "wrinkles", "number"), 2, "plies[0].defects.wrinkles.list"),
        (("plies", 0, "defects", "bridging", "max_gap_m"), 1.0, "plies[0].defects.bridging.list"),
        (("plies", 0, "defects", "shear", "max_past_deg"), None, "defects.shear.max_past_deg"),
        (("numerical_error", "inertia"), {}, "numerical_error.inertia.p95_shear_deg"),
        (("reported",), ["made_up", "gone"], "reported.gone"),
        (("status",), "done", "status"),
        (("plies", 0, "triangles"), True, "plies[0].triangles"),
        (("tools", 1, "name"), 3, "tools[1].name"),
    ],
)
def test_what_does_not_agree_is_named(way, value, named, good):
    owner = good
    for key in way[:-1]:
        owner = owner[key]
    owner[way[-1]] = value
    assert odd_entries(good)[0].endswith(named)


def test_a_net_gives_no_forces(good):
    """What an approach does not give may be none; what the others give may not."""
    for name in ("energy_error", "kinetic_ratio", "max_penetration_m", "quasi_static"):
        good[name] = None
    assert odd_entries(good) == [
        "quasi_static", "energy_error", "kinetic_ratio", "max_penetration_m",
    ]  # fmt: skip
    assert odd_entries(good | {"not_given": ["forces"]}) == []
