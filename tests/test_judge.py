"""The verdict on a run: what fails, where and when; limits and their file; exit status."""

import json
from pathlib import Path

import numpy as np
import pytest

from warpdrape import InputError, cli
from warpdrape.command_line.command import UNFIT
from warpdrape.defects.limits import (
    Limits,
    limits_entry,
    limits_of,
    read_limits,
    read_thresholds,
)
from warpdrape.defects.thresholds import DefectThresholds
from warpdrape.results.defect_text import judgement_lines
from warpdrape.results.judgement import judge, not_judged, verdict
from warpdrape.results.run_folder import JUDGEMENT
from warpdrape.results.run_tables import read_history, read_summary
from warpdrape.scenes import hemisphere


def wrinkle(amplitude, resolved=True):
    entry = {"at_m": [0.1, 0.0, -0.01], "on_blank_m": [0.12, 0.0], "amplitude_m": amplitude}
    return entry | {"resolved": resolved, "length_m": 0.03, "axis_on_blank": [1.0, 0.0]}


def group(wrinkles):
    largest = max((w["amplitude_m"] for w in wrinkles), default=0.0)
    share = 0.2 if wrinkles else 0.0
    return {"number": len(wrinkles), "max_amplitude_m": largest, "area_share": share}


def ply(wrinkles=(), bridges=(), **shear):
    resolved = [w for w in wrinkles if w["resolved"]]
    short = [w for w in wrinkles if not w["resolved"]]
    place = {"max_at_m": [0.0, 0.0, 0.0], "max_on_blank_m": [0.0, 0.0]}
    locking = {"locking_angle_deg": None, "max_past_deg": None, "area_share": None}
    yarn = {"failure_strain": 0.01, "max_strain": 0.02, "failed_area_share": 0.0} | place
    return {
        "name": "ply_0",
        "max_shear_deg": 47.0,
        "fibre_volume_fraction": {"min": 0.5, "mean": 0.6, "max": 0.8},
        "defects": {
            "wrinkles": group(resolved)
            | {"too_short_for_the_mesh": group(short), "list": list(wrinkles)},
            "shear": locking | place | shear,
            "yarns": {"warp": yarn, "weft": yarn},
            "bridging": {"list": list(bridges)},
            "misalignment": [{"name": "rib", "family": "warp", "mean_deg": 4.0, "max_deg": 9.0}],
        },
    }


def summary(*args, **options):
    tools = [{"name": "punch", "coverage": 0.4}]
    return {"status": "completed", "plies": [ply(*args, **options)], "tools": tools}


HISTORY = {
    "time_s": np.array([0.0, 0.1, 0.2, 0.3]),
    "ply_0_wrinkle_m": np.array([0.0, 2e-3, 0.5e-3, 2e-3]),
    "ply_0_short_wrinkle_m": np.zeros(4),
    "ply_0_max_shear_deg": np.array([0.0, 20.0, 45.0, 47.0]),
}
NOTHING = dict.fromkeys(
    ("wrinkle_amplitude", "past_locking_area", "bridge_gap", "failed_yarn_area"), None
)


def test_a_part_without_defects_is_fit():
    assert judge(summary(), HISTORY, Limits()) == []
    assert verdict([]).startswith("Fit")


def test_a_wrinkle_fails_above_its_limit_where_and_since_when_it_stays_there():
    run = summary([wrinkle(2e-3), wrinkle(0.5e-3)])
    (fault,) = judge(run, HISTORY, Limits(wrinkle_amplitude=1e-3))
    assert fault.words() == (
        "ply_0: 1 wrinkle above 1 mm, the largest of amplitude 2 mm, at (100, 0, -10) mm, "
        "since 300 ms"
    )
    assert judge(run, HISTORY, Limits(wrinkle_amplitude=2e-3)) == []
    (fault,) = judge(run, HISTORY, Limits(**NOTHING, wrinkle_area=0.1))
    assert "wrinkled on 20 %" in fault.what


def test_a_wave_too_short_for_the_mesh_fails_too_and_says_so():
    (fault,) = judge(summary([wrinkle(2e-3, resolved=False)]), HISTORY, Limits())
    assert "1 wave, the largest" in fault.what and "refine" in fault.what


@pytest.mark.parametrize(
    ("limit", "words"),
    [
        ({"shear_deg": 46.0}, "shear of 47.0°, allowed 46°"),
        ({"yarn_strain": 0.015}, "warp strain of 2 %, allowed 1.5 %"),
        ({"fibre_volume_fraction": 0.7}, "fibre volume fraction of 80 %, allowed 70 %"),
        ({"misalignment_deg": {"rib": 3.0}}, "warp off rib by 4.0° in the mean, allowed 3°"),
        ({"coverage": {"punch": 0.5}}, "covered by plies on 40 %, wanted 50 %"),
    ],
)
def test_each_limit_has_its_fault(limit, words):
    faults = judge(summary(), HISTORY, Limits(**(NOTHING | limit)))
    assert faults[0].what == words
    assert judge(summary(), HISTORY, Limits(**NOTHING)) == []


@pytest.mark.parametrize(("softening", "owed"), [(1.0, 0.0), (36.0, 0.05), (100.0, 1e-5)])
def test_strains_of_softened_yarns_are_doubted(softening, owed):
    """They stretch farther: unfit, but perhaps by that alone; not where they have recovered."""
    run = summary() | {"yarn_softening": softening, "softening_strain": owed}
    for yarn in run["plies"][0]["defects"]["yarns"].values():
        yarn["failed_area_share"] = 0.1
    limits = Limits(**(NOTHING | {"yarn_strain": 0.015, "failed_yarn_area": 0.0}))
    faults = judge(run, HISTORY, limits)
    assert len(faults) == 4
    for fault in faults:
        doubted = "softened 36 times, which stretches them by up to 5 % too far" in fault.what
        assert doubted == (owed == 0.05)
        assert fault.what.endswith("accuracy = reference, to be sure)") == doubted


def test_bridges_and_locking():
    bridge = {"tool": "die", "gap_m": 3e-3, "at_m": [0, 0, 0], "on_blank_m": [0, 0]}
    small = bridge | {"resolved": False}  # perhaps a chord of the mesh: said, not judged
    bridge["resolved"] = True
    assert judge(summary(bridges=[small]), HISTORY, Limits()) == []
    found = judge(summary(bridges=[bridge, small]), HISTORY, Limits())
    assert len(found) == 1
    assert found[0].what == "bridges die with a gap of 3 mm, allowed 0 mm"
    past = {"locking_angle_deg": 44.0, "max_past_deg": 3.0, "area_share": 0.05}
    (fault,) = judge(summary(**past), HISTORY, Limits())
    assert fault.what == "past its locking angle of 44° on 5 %, by up to 3°"
    assert fault.since == 0.2


def test_what_is_not_known_is_said_not_to_be_judged():
    (words,) = not_judged(summary(), Limits())
    assert words == "shear past locking (no locking_angle in the fabric) of ply_0"
    assert "not judged" in verdict([], [words])


def test_an_unknown_tool_or_an_old_run_is_unusable():
    with pytest.raises(InputError, match="did you mean 'punch'"):
        judge(summary(), HISTORY, Limits(coverage={"punsh": 0.1}))
    with pytest.raises(InputError, match="unknown wanted direction 'web'"):
        judge(summary(), HISTORY, Limits(misalignment_deg={"web": 3.0}))
    old = summary()
    del old["plies"][0]["defects"]
    with pytest.raises(InputError, match="older version"):
        judge(old, HISTORY, Limits())


def test_the_file_of_limits(tmp_path):
    file = tmp_path / "limits.toml"
    file.write_text('wrinkle_amplitude = "0.8 mm"\nwrinkle_area = "5 %"\nshear_deg = 50\n')
    limits = read_limits(file)
    assert limits.wrinkle_amplitude == pytest.approx(8e-4)
    assert (limits.wrinkle_area, limits.shear_deg) == (0.05, 50)
    assert limits.bridge_gap is None  # not named, not judged
    for text, words in (
        ('wrinkle_amplitud = "1 mm"', "did you mean 'wrinkle_amplitude'"),
        ('bridge_gap = "1 kg"', "'kg' is no unit of a length"),
        ("yarn_strain = -0.1", "yarn_strain = -0.1 must be zero or more"),
        ('shear_deg = "50 deg"', "must be a number"),
        ("coverage = {punch = 1.5}", "must be a share"),
        ("coverage = 0.5", "must be a table"),
        ("= 1", "not valid TOML"),
    ):
        file.write_text(text)
        with pytest.raises(InputError, match=words):
            read_limits(file)
    with pytest.raises(InputError, match="cannot be read"):
        read_limits(tmp_path / "none.toml")


def test_the_file_of_the_documents_can_be_read(tmp_path):
    page = (Path(__file__).parents[1] / "docs" / "defects.md").read_text("utf-8")
    file = tmp_path / "limits.toml"
    file.write_text(page.partition("```toml\n")[2].partition("```")[0], encoding="utf-8")
    limits = read_limits(file)
    assert limits.bridge_gap == pytest.approx(5e-4) and limits.coverage == {"punch": 0.4}
    file.write_text(page.split("```toml\n")[2].partition("```")[0], encoding="utf-8")
    thresholds = read_thresholds(file, DefectThresholds())
    assert (thresholds.longest_wrinkle, thresholds.cavity_room) == (0.4, 5)
    assert read_limits(file).wrinkle_amplitude == 1e-3


def test_judging_a_run_folder(tmp_path, capsys):
    folder = tmp_path / "run"
    hemisphere.build(cells=6, duration=0.004, travel=0.01).run(folder, frames=2)
    assert cli.main(["judge", str(folder)]) == cli.DONE
    said, _ = capsys.readouterr()
    assert said.startswith("Fit") and (folder / JUDGEMENT).stat().st_size > 5000
    limits = tmp_path / "limits.toml"
    limits.write_text("coverage = {punch = 0.9}\nshear_deg = 0.001\n")
    picture = tmp_path / "marked.png"
    assert cli.main(["judge", str(folder), str(limits), "--out", str(picture)]) == UNFIT == 3
    said, _ = capsys.readouterr()
    assert said.startswith("Unfit: 2 defects") and picture.is_file()
    assert len(read_history(folder)["time_s"]) == 3
    failed = read_summary(folder) | {"status": "failed", "message": "blew up"}
    (folder / "summary.json").write_text(json.dumps(failed))
    assert cli.main(["judge", str(folder)]) == cli.FAILED
    assert cli.main(["judge", str(tmp_path / "nowhere")]) == cli.UNUSABLE


def test_limits_of_the_scene_come_back_from_the_summary_and_are_judged_by():
    own = Limits(shear_deg=40.0, wrinkle_amplitude=None, coverage={"punch": 0.5})
    kept = json.loads(json.dumps(limits_entry(own)))
    assert limits_of({"limits": kept}) == own
    assert limits_of({}) == limits_of({"limits": None}) == Limits()
    assert limits_entry(None) is None
    with pytest.raises(InputError, match="limits of another version"):
        limits_of({"limits": {"sheen": 3}})
    (line,) = judgement_lines(
        summary() | {"status": "completed", "limits": limits_entry(Limits(shear_deg=40.0))}
    )
    assert "shear of 47.0°, allowed 40°" in line
    (fit,) = judgement_lines(summary() | {"status": "completed", "limits": None})
    assert fit.startswith("Fit")
