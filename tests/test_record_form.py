"""Every entry of a run's record with every odd value: refused by its name, or it can be read."""

import json
import shutil

import pytest
from run_damage import ODD, places

import warpdrape as wd
from warpdrape.commands.finished import what_differs
from warpdrape.commands.judging import _own_thresholds
from warpdrape.report.record import record_section
from warpdrape.results.read_run import RunReader
from warpdrape.results.record_form import odd_entries
from warpdrape.results.run_tables import read_record
from warpdrape.results.same_scene import record_difference, record_of
from warpdrape.scenes import three_ply_hemisphere

GONE = object()


@pytest.fixture(scope="module")
def scene():
    return three_ply_hemisphere.build(cells=6, travel=0.03, duration=0.01)


@pytest.fixture
def good(pressed):
    """The record of a press, with one of what there are several of, and little of its fabric."""
    record = json.loads((pressed[1] / "run.json").read_text("utf-8"))
    fabric = record["fabrics"]["carbon_interlock"]
    record["fabrics"]["carbon_interlock"] = {
        name: fabric[name] for name in ("name", "thickness", "tension", "sources")
    }
    del record["plies"][1:], record["tools"][1:]
    return record


@pytest.fixture
def copy(pressed, tmp_path):
    """A copy of the run that a test may change."""
    return shutil.copytree(pressed[1], tmp_path / "run")


def test_what_a_run_writes_is_taken(pressed, good):
    whole = json.loads((pressed[1] / "run.json").read_text("utf-8"))
    assert odd_entries(whole) == odd_entries(good) == []
    assert odd_entries({"scene": "of an older version"}) == []


def test_every_odd_value_is_refused_by_its_name_or_can_be_read(good, scene):
    wanted = record_of(scene)
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
                assert any(str(key) in " ".join(found) for key in way) or way[0] == "fabrics"
            else:
                taken += 1
                try:
                    record_section(good)
                    said = record_difference(good, wanted)
                except Exception as error:
                    raise AssertionError(f"{way} = {odd!r}: {error!r}") from error
                assert said.isprintable()
            if odd is GONE and isinstance(owner, list):
                owner.insert(way[-1], was)
            else:
                owner[way[-1]] = was
    assert taken > 500 and refused > 500


@pytest.mark.parametrize(
    ("way", "value", "named"),
    [
        (("scene",), 3, "scene"),
        (("plies", 1, "name"), None, "plies[1].name"),
        (("plies", 0, "fabric"), "silk", "plies[0].fabric"),
        (("plies", 2, "stabiliser_n_m"), [1.0], "plies[2].stabiliser_n_m"),
        (("fabrics", "carbon_interlock", "thickness"), "x", "fabrics.carbon_interlock.thickness"),
        (("call",), {"settings": "cells=6"}, "call.settings"),
        (("versions",), {}, "versions.warpdrape"),
        (("defect_thresholds", "bridge_gap"), None, "defect_thresholds.bridge_gap"),
    ],
)
def test_what_is_odd_is_named_to_whoever_reads_it(way, value, named, copy, scene):
    record = json.loads((copy / "run.json").read_text("utf-8"))
    owner = record
    for key in way[:-1]:
        owner = owner[key]
    owner[way[-1]] = value
    (copy / "run.json").write_text(json.dumps(record), "utf-8")
    words = f"run.json has no usable {named}: it is of another version, damaged, or changed by hand"
    assert words in what_differs(copy, scene, frames=4, device="cpu")
    for read in (read_record, lambda folder: RunReader(folder).ply_thicknesses(), _own_thresholds):
        with pytest.raises(wd.InputError) as refused:
            read(copy)
        assert words in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize("needed", ["plies", "fabrics", "defect_thresholds", "frames", "call"])
def test_what_is_needed_and_not_there_is_named(needed, copy, scene):
    record = json.loads((copy / "run.json").read_text("utf-8"))
    del record[needed]
    (copy / "run.json").write_text(json.dumps(record), "utf-8")
    assert "scene" in read_record(copy)
    readers = {
        "plies": lambda: RunReader(copy).ply_thicknesses(),
        "fabrics": lambda: RunReader(copy).ply_thicknesses(),
        "defect_thresholds": lambda: _own_thresholds(copy),
    }
    if needed in readers:
        with pytest.raises(wd.InputError, match=rf"run.json has no usable {needed}: it is of"):
            readers[needed]()
    else:
        assert f"no usable {needed}" in what_differs(copy, scene, frames=4, device="cpu")


def test_thicknesses_are_those_of_the_plies_by_name(copy):
    record = json.loads((copy / "run.json").read_text("utf-8"))
    thick = json.loads(json.dumps(record["fabrics"]["carbon_interlock"])) | {"thickness": 2e-3}
    record["fabrics"]["thick"] = thick
    record["plies"][2]["fabric"] = "thick"
    record["plies"].reverse()
    (copy / "run.json").write_text(json.dumps(record), "utf-8")
    thin = record["fabrics"]["carbon_interlock"]["thickness"]
    assert RunReader(copy).ply_thicknesses() == [thin, thin, 2e-3]
    del record["plies"][0]
    (copy / "run.json").write_text(json.dumps(record), "utf-8")
    with pytest.raises(wd.InputError, match=r"run.json has other plies than summary.json"):
        RunReader(copy).ply_thicknesses()
