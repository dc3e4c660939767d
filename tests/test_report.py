"""The report as a file: what it holds, that nothing in it can act, and what it refuses."""

import base64
import hashlib
import json
import re
import shutil
import tomllib
import zlib
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import warpdrape as wd
from warpdrape import cli
from warpdrape.report import report
from warpdrape.report.markup import Html, element, json_block
from warpdrape.report.packing import NOTHING, Blocks, quantised
from warpdrape.report.report import write_report
from warpdrape.results.quantities import QUANTITIES

EVIL = "</script><script>document.title='taken'</script><img src=x onerror=alert(1)>"


class Page(HTMLParser):
    """A page taken apart by Python's own parser: its elements, blocks of data, and text."""

    def __init__(self, path):
        super().__init__()
        self.tags, self.blocks, self.scripts, self.styles, self.words = [], {}, [], [], []
        self._inside = None
        self.feed(path.read_text("utf-8"))
        self.data = json.loads(self.blocks["data"])
        self.text = " ".join(" ".join(self.words).split())

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self._inside = (tag, dict(attrs))

    def handle_endtag(self, tag):
        self._inside = None

    def handle_data(self, data):
        tag, attrs = self._inside or (None, {})
        if tag == "script" and "type" in attrs:
            self.blocks[attrs["id"]] = data
        elif tag in ("script", "style"):
            (self.scripts if tag == "script" else self.styles).append(data)
        else:
            self.words.append(data)

    def bytes(self, number):
        return zlib.decompress(base64.b64decode(self.blocks[f"block-{number}"]))

    def whole(self, number):
        return np.frombuffer(self.bytes(number), "<u4")

    def values(self, number, frames, low, high):
        low_bytes, high_bytes = np.frombuffer(self.bytes(number), np.uint8).reshape(2, -1)
        steps = low_bytes.astype(np.int64) + 256 * high_bytes.astype(np.int64)
        numbers = np.cumsum(steps.reshape(frames, -1), axis=0) % 65536
        return np.asarray(low) + numbers / 65534 * (np.asarray(high) - low), numbers


@pytest.fixture(scope="module")
def made(pressed, tmp_path_factory):
    return write_report([pressed[1]], tmp_path_factory.mktemp("report") / "r.html")


@pytest.fixture(scope="module")
def page(made):
    return Page(made)


@pytest.fixture
def copy(pressed, tmp_path):
    """A copy of a run folder, to be spoilt."""
    return shutil.copytree(pressed[1], tmp_path / "copy")


def change(path, action):
    data = json.loads(path.read_text("utf-8"))
    action(data)
    path.write_text(json.dumps(data), "utf-8")


def test_numbers_come_back_within_half_a_step():
    values = np.random.default_rng(1).normal(size=(5, 40, 3)) * [1.0, 1e-3, 1e6]
    values[2, 3, 1] = np.nan
    low, high = np.nanmin(values, axis=(0, 1)), np.nanmax(values, axis=(0, 1))
    numbers = quantised(values, low, high)
    assert numbers[2, 3, 1] == NOTHING and (numbers == NOTHING).sum() == 1
    back = low + numbers / 65534 * (high - low)
    off = np.abs(back - values) / (high - low)
    assert np.nanmax(np.where(numbers == NOTHING, np.nan, off)) <= 0.5 / 65534 * (1 + 1e-9)
    assert (quantised(np.full((2, 3), 7.0), 7.0, 7.0) == 0).all()
    assert (quantised(values[:, :, 0], low[0], high[0]).ravel() < NOTHING).all()


def test_the_page_holds_what_the_run_folder_does(pressed, page):
    (run,) = page.data["runs"]
    assert run["frames"] == [0, 1, 2, 3, 4] and run["of"] == 5
    low, high = np.array(run["low"]), np.array(run["high"])
    for frame in (0, 2, 4):
        read = wd.read_run(pressed[1], frame=frame)
        assert run["times"][frame] == read.time_s
        travel = 1e3 * read.history["punch_displacement_m"][frame]
        assert run["travel"]["punch"][frame] == pytest.approx(travel)
        assert "die" not in run["travel"]  # it stands still
        for ply, packed in zip(read.plies, run["plies"], strict=True):
            corners = page.whole(packed["corners"]).reshape(-1, 3)
            np.testing.assert_array_equal(corners, ply.triangles)
            n = len(ply.points)
            points, _ = page.values(packed["points"], 5, np.tile(low, n), np.tile(high, n))
            off = np.abs(points[frame].reshape(-1, 3) - ply.points)
            assert (off <= 0.501 * (high - low) / 65534).all()
            check_fields(page, packed["fields"], ply, frame)
        for tool, packed in zip(read.tools, run["tools"], strict=True):
            n = len(tool.vertices)
            bounds = np.tile(packed["low"], n), np.tile(packed["high"], n)
            start, _ = page.values(packed["points"], 1, *bounds)
            place = np.reshape(packed["places"][frame], (4, 4))  # column by column
            placed = start.reshape(-1, 3) @ place[:3, :3] + place[3, :3]
            size = np.ptp(tool.vertices, axis=0).max()
            np.testing.assert_allclose(placed, tool.vertices, atol=0.6 * size / 65534)


def check_fields(page, fields, ply, frame):
    arrays = {
        "shear": ply.shear_angle_deg,
        "warp-strain": 100 * ply.strain[:, 0],
        "weft-tension": 1e-3 * ply.line_tension[:, 1],
        "warp-curvature": ply.curvature[:, 0],
        "slip": 1e3 * np.linalg.norm(ply.slip, axis=1),
        "contact-pressure": 1e-3 * ply.contact_pressure,
        "tool-pressure": 1e-3 * ply.tool_pressure,
        "thickness": 1e3 * ply.thickness,
        "fibre-volume": 100 * ply.fibre_volume_fraction,
        "wrinkle": 1e3 * ply.wrinkle,
    }
    assert set(fields) == set(QUANTITIES) - {
        "temperature",
        "warp-slide",
        "weft-slide",
    }  # of none of its plies
    for name, values in arrays.items():
        packed = fields[name]
        found, _ = page.values(packed["block"], 5, packed["low"], packed["high"])
        step = (packed["high"] - packed["low"]) / 65534
        assert packed["atVertices"] is (len(values) == len(ply.points)), name
        np.testing.assert_allclose(found[frame], values, atol=0.501 * step + 1e-12, err_msg=name)


def test_colours_have_one_scale_that_holds_all(pressed, page):
    fields = {field["name"]: field for field in page.data["fields"]}
    largest = max(np.abs(ply.shear_angle_deg).max() for ply in pressed[0].plies)
    assert fields["shear"]["scale"] == [0.0, max(5.0 * np.ceil(largest / 5.0), 5.0)]
    assert not fields["shear"]["signed"] and fields["warp-strain"]["signed"]
    assert len(page.data["colours"]["plain"]) == 256
    assert page.data["colours"]["plain"][0] == "440154"  # viridis


def test_curves_are_those_of_the_history(pressed, page):
    history = pressed[0].history
    plots = {plot["title"]: plot for plot in page.data["runs"][0]["plots"]}
    lines = {line["name"]: line["values"] for line in plots["Forces"]["lines"]}
    assert list(lines) == ["punch", "die", "holder"]
    np.testing.assert_allclose(lines["punch"], history["punch_force_n"], rtol=1e-5)
    np.testing.assert_allclose(plots["Forces"]["times"], 1e3 * history["time_s"], rtol=1e-5)
    drawn = {line["name"]: line["values"] for line in plots["Draw-in of the edge"]["lines"]}
    at_end = pressed[0].summary["plies"][1]["defects"]["draw_in"]
    assert drawn["ply_1, largest"][-1] == pytest.approx(1e3 * at_end["max_m"], rel=1e-4)
    assert drawn["ply_1, mean"][-1] == pytest.approx(1e3 * at_end["mean_m"], rel=1e-4)
    assert drawn["ply_1, mean"][0] == pytest.approx(0.0, abs=1e-5)
    shown = {line["name"] for title in plots for line in plots[title]["lines"]}
    assert {"kinetic", "external work", "gravity work", "ply_0"} <= shown
    columns = [name for name in history if name.endswith("_j")]
    assert not history["clamp_work_j"].any()  # and such parts are no curves
    main = ("internal", "kinetic", "friction", "damping", "contact", "external_work")
    columns = [n for n in columns if history[n].any() or n.removesuffix("_j") in main]
    energies = plots["Energies"]["lines"] + plots["Energies: parts"]["lines"]
    assert sorted(line["name"] for line in energies) == sorted(
        name.removesuffix("_j").replace("_", " ") for name in columns
    )


def test_it_is_a_record_in_words(pressed, page):
    summary, record = pressed[0].summary, json.loads((pressed[1] / "run.json").read_text("utf-8"))
    for words in (
        f"{summary['plies'][0]['max_shear_deg']:.1f}°",
        "no wrinkles",
        "energy error",
        "ply_0 on ply_1",
        *summary["warnings"],
        "three_ply_hemisphere",
        "holder_force",
        record["fabrics"]["carbon_interlock"]["sources"]["tension.warp"]["text"],
        record["fabrics"]["carbon_interlock"]["doubts"][0],
        "46000 N per unit strain",
        "0.63 kg/m²",
        record["versions"]["warp-lang"],
        hashlib.sha256((pressed[1] / "summary.json").read_bytes()).hexdigest(),
    ):
        assert " ".join(words.split()) in page.text, words
    assert "{'" not in page.text and "': " not in page.text  # tables, not Python's records
    assert page.text.count("(0, 0, -9.81)") == 1 and "gravity_m_s2" in page.text
    buttons = [attrs for tag, attrs in page.tags if tag == "button" and "data-block" in attrs]
    kept = {attrs["data-file"]: page.bytes(attrs["data-block"]) for attrs in buttons}
    assert set(kept) == {"history.csv", "summary.json", "run.json"}
    for name, content in kept.items():
        assert content == (pressed[1] / name).read_bytes()


def test_nothing_is_fetched_and_only_its_own_scripts_may_run(made, page):
    assert made.stat().st_size < 10e6
    for tag, attrs in page.tags:
        assert tag not in ("link", "iframe", "object", "embed", "base", "form")
        assert "src" not in attrs and not any(name.startswith("on") for name in attrs)
        assert tag != "a" or attrs["href"].startswith("#")
        assert "style" not in attrs
    (policy,) = [a["content"] for t, a in page.tags if t == "meta" and "http-equiv" in a]
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    assert rules["default-src"] == "'none'"
    for kind, texts in (("script-src", page.scripts), ("style-src", page.styles)):
        digests = [hashlib.sha256(text.encode()).digest() for text in texts]
        wanted = {f"'sha256-{base64.b64encode(d).decode()}'" for d in digests}
        assert texts and set(rules[kind].split()) == wanted


def test_what_a_stranger_wrote_stays_text(copy, tmp_path, page):
    def rename(data):
        data["plies"][0]["name"] = data["tools"][0]["name"] = EVIL
        data["warnings"].append(EVIL)

    change(copy / "summary.json", rename)
    change(copy / "run.json", lambda data: data.update(scene=EVIL, **{EVIL: {EVIL: EVIL}}))
    change(copy / "run.json", lambda d: d["fabrics"]["carbon_interlock"].update(name=EVIL))
    folder = copy.rename(tmp_path / "&lt;b&gt;run")
    evil = Page(write_report([folder]))
    known = [tag for tag, _ in page.tags]
    for tag in ("script", "img", "b"):
        assert [t for t, _ in evil.tags].count(tag) == known.count(tag), tag
    assert evil.data["runs"][0]["plies"][0]["name"] == EVIL
    assert EVIL in evil.text and "&lt;b&gt;run" in evil.text


def test_markup_escapes_what_is_not_markup():
    inside = element("p", "a < b & 'c'", Html("<br>"), title='"x"', class_="k", lang=None)
    assert inside == ('<p title="&quot;x&quot;" class="k">a &lt; b &amp; &#x27;c&#x27;<br></p>')
    text = json_block("d", {"a": "</script><!--\u2028", "b": [1.5]})
    assert text.count("<") == 2 and json.loads(re.findall(">(.*)<", text)[0])["b"] == [1.5]
    with pytest.raises(ValueError, match="not JSON compliant"):
        json_block("d", [float("nan")])


def test_frames_are_left_out_evenly_and_that_is_said(pressed, tmp_path, monkeypatch):
    few = Page(write_report([pressed[1]], tmp_path / "few.html", frames=3))
    assert few.data["runs"][0]["frames"] == [0, 2, 4]
    assert "3 of 5 frames, evenly spaced" in few.text
    assert few.data["runs"][0]["times"] == pressed[0].history["time_s"][[0, 2, 4]].tolist()
    assert len(few.data["runs"][0]["plots"][0]["times"]) == 5
    last = Page(write_report([pressed[1]], tmp_path / "last.html", frames=1))
    assert last.data["runs"][0]["frames"] == [4]
    monkeypatch.setattr("warpdrape.report.run_data.MOST_VALUES", 1)
    monkeypatch.setattr("warpdrape.report.run_data.LEAST_FRAMES", 2)
    thin = Page(write_report([pressed[1]], tmp_path / "thin.html"))
    assert thin.data["runs"][0]["frames"] == [0, 4]


def test_a_failed_run_says_why_and_what_is_not_known(copy):
    def fail(data):
        data.update(status="failed", message="the plies flew away")
        for ply in data["plies"]:
            del ply["defects"]

    change(copy / "summary.json", fail)
    (copy / "run.json").unlink()
    text = Page(write_report([copy])).text
    assert "Failed after" in text and "the plies flew away" in text
    assert "holds no run.json: how it was made is not known" in text
    assert "Defects" not in text


def test_two_runs_stand_beside_each_other(pressed, copy, tmp_path):
    change(copy / "run.json", lambda data: data["parameters"].update(holder_force=55.5))
    both = Page(write_report([pressed[1], copy], tmp_path / "both.html"))
    one, other = both.data["runs"]
    assert (one["name"], other["name"]) == ("run", "copy")
    assert other["matches"] == [{"ply": k, "same": True} for k in range(3)]
    assert "matches" not in one
    differing = both.text.partition("What differs entry run copy ")[2]
    assert differing.startswith("parameters.holder_force 100 55.5 run ")  # and nothing else
    assert "ply_0: run" in both.text and "ply_0: copy" in both.text


def test_what_cannot_be_reported_is_refused_in_a_sentence(pressed, copy, tmp_path, monkeypatch):
    def refuse(words, runs, out=None):
        with pytest.raises(wd.InputError, match=words):
            write_report(runs, out)

    refuse("nothing does not exist: give the folder of a finished run", [tmp_path / "nothing"])
    refuse("must end in .html", [copy], copy / "scene.usdc")
    (tmp_path / "a.html").mkdir()
    refuse("a.html is a folder", [copy], tmp_path / "a.html")
    refuse("is given twice", [copy, copy], tmp_path / "b.html")
    refuse("7 runs: a report takes 1 to 6", [copy] * 7)
    refuse("cannot be written", [copy], copy / "run.json" / "b.html")
    whole = (copy / "summary.json").read_bytes()
    for entry, value in (("plies", 2.5), ("tools", 3), ("tools", None)):
        change(copy / "summary.json", lambda d, e=entry, v=value: d[e][1].update(name=v))
        refuse(
            rf"summary.json has no usable {entry}\[1\].name: it is of another version, damaged",
            [copy],
        )
        (copy / "summary.json").write_bytes(whole)
    (copy / "run.json").write_text("[1]")
    refuse("run.json is no record of a run", [copy])
    (copy / "run.json").write_text("{")
    refuse("run.json is not readable JSON", [copy])
    (copy / "scene.usdc").rename(copy / ".scene.partial.usdc")
    refuse("no scene.usdc but an unfinished one: wait for the run", [copy])
    change(copy / "summary.json", lambda data: data.update(status="failed", message="it blew up"))
    refuse("as the run failed: it blew up", [copy])
    assert not list(copy.glob("*.html")) and not list(tmp_path.glob("*b.html"))


def test_commands(pressed, copy, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["report", str(copy)]) == 0
    assert capsys.readouterr().out.strip() == str(copy / "report.html")
    assert cli.main(["report", str(copy), str(pressed[1]), "--frames", "2"]) == 0
    assert capsys.readouterr().out.strip() == report.COMPARISON
    assert len(Page(tmp_path / report.COMPARISON).data["runs"]) == 2
    assert cli.main(["report", str(copy), "--frames", "0"]) == 2
    assert "--frames 0 must be 1 or more" in capsys.readouterr().err
    quick = ["--set", "cells=4", "--set", "duration=0.002", "--frames", "2", "--quiet"]
    assert cli.main(["run", "hemisphere", *quick, "--out", "mine", "--report"]) == 0
    assert "report.html   all of it as one page" in capsys.readouterr().out
    (ply,) = Page(tmp_path / "mine" / "report.html").data["runs"][0]["plies"]
    assert "slip" not in ply["fields"] and "tool-distance" in ply["fields"]  # a single ply
    assert cli.main(["run", "hemisphere", *quick, "--out", "mine"]) == 2  # results are kept
    assert "report.html" in capsys.readouterr().err
    monkeypatch.setattr(report, "MOST_RUNS", 0)
    assert cli.main(["run", "hemisphere", *quick, "--out", "mine", "--report", "--overwrite"]) == 0
    assert "no report: 1 runs" in capsys.readouterr().err  # the run itself is safe
    assert not (tmp_path / "mine" / "report.html").exists()  # that of the run before is gone


def test_a_run_that_ends_before_its_first_frame_has_no_report(tmp_path, monkeypatch, capsys):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("warpdrape.simulation.Stepper", interrupted)
    quick = ["--set", "cells=4", "--frames", "2", "--quiet", "--out", str(tmp_path / "mine")]
    assert cli.main(["run", "hemisphere", *quick, "--report"]) == 1
    assert capsys.readouterr().err == "warpdrape: error: interrupted by the user\n"
    assert not (tmp_path / "mine" / "report.html").exists()
    assert cli.main(["report", str(tmp_path / "mine")]) == 2
    assert "as the run failed: interrupted by the user" in capsys.readouterr().err


def test_blocks_are_numbered_in_order():
    blocks = Blocks()
    assert [blocks.whole_numbers([1]), blocks.values([[1.0]], 0, 2), blocks.text(b"x")] == [0, 1, 2]


def test_all_that_the_page_needs_is_packaged_with_its_licences():
    root = Path(__file__).parents[1]
    project = tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["tool"]["setuptools"]
    patterns = project["package-data"]["warpdrape.report"]
    folder = root / "warpdrape" / "report"
    packaged = {path for pattern in patterns for path in folder.glob(pattern)}
    wanted = {p for p in folder.rglob("*") if p.is_file() and p.suffix not in (".py", ".pyc")}
    assert wanted == packaged and len(wanted) > 12
    for name, holder in (("three", "three.js authors"), ("uplot", "Leon Sorokin")):
        text = (folder / "vendor" / f"{name}.LICENSE").read_text("utf-8")
        assert "Permission is hereby granted, free of charge" in text and holder in text
    contributing = (root / "CONTRIBUTING.md").read_text("utf-8")
    for name in ("three", "uplot"):
        start = (folder / "vendor" / f"{name}.min.js").read_text("utf-8")[:120]
        (version,) = re.findall(r"\d+\.\d+\.\d+", start)
        assert version in contributing


def test_a_coupon_shows_its_curve(copy):
    from PIL import Image

    Image.new("RGB", (3, 2)).save(copy / "coupon.png")
    found = [a["src"] for tag, a in Page(write_report([copy])).tags if tag == "img"]
    start = "data:image/png;base64,"
    assert [base64.b64decode(src.removeprefix(start)) for src in found] == [
        (copy / "coupon.png").read_bytes()
    ]
    (copy / "coupon.png").write_text("<svg onload=alert(1)>")
    assert not any(tag == "img" for tag, _ in Page(write_report([copy])).tags)


def test_licences_go_with_the_page(page):
    assert page.text.count("Permission is hereby granted, free of charge") == 2
