"""The report in a browser: it draws, its slider moves the plies, it tells what is there."""

import json
import shutil

import numpy as np
import pytest
from browser import Browser
from matplotlib.tri import Triangulation

import warpdrape as wd
from warpdrape.report.report import write_report
from warpdrape.scenes import three_ply_hemisphere

RIGHT, LEFT, HOME = ("ArrowRight", 39), ("ArrowLeft", 37), ("Home", 36)
VIEWS = "window.report.stage.views"
CANVAS = "(b => [b.x, b.y, b.width, b.height])(report.stage.canvas.getBoundingClientRect())"
ENDS = "report.stage.cut.lines.map(l => [...l.geometry.attributes.instanceStart.array])"


@pytest.fixture(scope="module")
def browser():
    browser = Browser()
    yield browser
    browser.close()


@pytest.fixture(scope="module")
def made(pressed, tmp_path_factory):
    return write_report([pressed[1]], tmp_path_factory.mktemp("page") / "r.html")


@pytest.fixture(scope="module")
def coarser(browser, tmp_path_factory):
    """A run like `pressed` on other meshes; not computed where there is no browser."""
    folder = tmp_path_factory.mktemp("coarser") / "run"
    scene = three_ply_hemisphere.build(cells=4, travel=0.03, duration=0.01, mesh="random")
    scene.run(folder, frames=3)
    return folder


@pytest.fixture
def page(browser, made):
    browser.open(made)
    browser.until("window.report.stage.views[0].plies[2].fields.size === 14")
    yield browser
    assert browser.complaints() == []
    assert browser.asked_for() == {made.resolve().as_uri()}


def choose(browser, name, value, event="change"):
    browser.value(
        f"(e => {{ e.value = {json.dumps(value)}; e.dispatchEvent(new Event('{event}')); }})"
        f"(document.getElementById('{name}'))"
    )
    browser.value("new Promise((done) => setTimeout(done, 150))")


def points_of(browser, ply, run=0):
    return np.reshape(browser.value(f"[...{VIEWS}[{run}].plies[{ply}].points]"), (-1, 3))


def test_it_draws_and_the_slider_moves_the_plies(page, pressed):
    drawn = page.picture("#canvas")
    assert np.unique(drawn.reshape(-1, 3), axis=0).shape[0] > 500  # colours, shades, lines
    assert (np.abs(drawn - drawn[2, 2]).max(axis=2) > 0.05).mean() > 0.15
    packed = page.value("(({low, high}) => [low, high])(window.report.data.runs[0])")
    step = np.ptp(packed, axis=0).max() / 65534
    page.value("document.getElementById('time').focus()")
    for key, frame in ((LEFT, 3), (HOME, 0), (RIGHT, 1)):
        page.press(*key)
        page.until(f"{VIEWS}[0].frame === {frame}")
        read = wd.read_run(pressed[1], frame=frame)
        for k, ply in enumerate(read.plies):
            off = np.abs(points_of(page, k) - ply.points).max()
            assert off <= 0.5 * step + 1e-7  # and the browser's single precision
        words = page.value("document.getElementById('moment').textContent")
        assert words.startswith(f"{1e3 * read.time_s:.3g} ms · punch ")
        shift = page.value(f"{VIEWS}[0].tools[0].group.matrix.elements[14]")
        moved = read.history["punch_displacement_m"][frame]
        assert shift == pytest.approx(-moved, abs=1e-8)
        now = page.picture("#canvas")
        assert (np.abs(now - drawn).max(axis=2) > 0.02).mean() > 0.02, frame
        drawn = now


def test_the_pointer_is_told_what_is_there(page, pressed):
    ran = pressed[0]
    choose(page, "look", "below")
    left, top, width, height = page.value(CANVAS)
    for x, y in ((0.5, 0.5), (0.44, 0.55), (0.57, 0.4), (0.5, 0.3)):
        page.point_at(1, 1)
        page.until("document.getElementById('tip').hidden")
        at = np.round([left + x * width, top + y * height])
        page.point_at(*at)
        page.until("!document.getElementById('tip').hidden")
        lines = page.value("[...document.getElementById('tip').children].map(e => e.textContent)")
        ply, place = ran.ply(lines[0]), 1e-3 * numbers_in(lines[1].partition("at ")[2])
        number = int(lines[1].split(",")[0].removeprefix("triangle "))
        assert np.abs(projected(page, place) - at).max() < 1.5  # 0.05 mm of rounding, and a pixel
        corners = ply.points[ply.triangles[number]]
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        off = (place - corners[0]) @ normal / np.linalg.norm(normal)
        assert abs(off) < 1e-4  # 0.05 mm of rounding along each axis
        told = dict(line.split(": ") for line in lines[3:])
        assert float(told["shear angle"][:-1]) == pytest.approx(
            ply.shear_angle_deg[number], abs=0.06
        )
        strain = float(told["warp strain"].split()[0])
        assert strain == pytest.approx(100 * ply.strain[number, 0], rel=0.02, abs=1e-5)
        thickness = float(told["thickness"].split()[0])
        assert thickness == pytest.approx(1e3 * ply.thickness[number], rel=0.01)


def numbers_in(text):
    return np.array([float(n) for n in text.strip("() m").split(",")])


def projected(browser, place):
    """Pixel of a place, by the camera's matrices."""
    camera = "window.report.stage.camera"
    script = f"[{camera}.projectionMatrix.elements, {camera}.matrixWorldInverse.elements]"
    projection, view = (np.reshape(e, (4, 4)).T for e in browser.value(script))
    x, y, _, w = projection @ view @ [*place, 1.0]
    left, top, width, height = browser.value(CANVAS)
    return np.array([left + (x / w + 1) / 2 * width, top + (1 - y / w) / 2 * height])


SHOWN = {  # field → unit, and its values at the corners of the triangles
    "shear": ("°", lambda ply: np.repeat(np.abs(ply.shear_angle_deg), 3)),
    "weft-tension": ("N/mm", lambda ply: np.repeat(1e-3 * ply.line_tension[:, 1], 3)),
    "slip": ("mm", lambda ply: 1e3 * np.linalg.norm(ply.slip, axis=1)[ply.triangles].ravel()),
}


def test_colours_are_those_of_the_values(page, pressed):
    for field, (unit, values) in SHOWN.items():
        choose(page, "field", field)
        page.until(f"window.report.field.name === {field!r}")
        low, high = page.value(f"window.report.scales[{field!r}]")
        for k, ply in enumerate(pressed[0].plies):
            uv = page.value(f"[...{VIEWS}[0].plies[{k}].mesh.geometry.attributes.uv.array]")
            across, row = np.reshape(uv, (-1, 2)).T
            np.testing.assert_allclose(row, 0.125)  # the first of four rows of colours
            share = np.clip((values(ply) - low) / (high - low), 0.0, 1.0)
            np.testing.assert_allclose(across, (0.5 + 255 * share) / 256, atol=2e-4)
        legend = page.value("document.querySelector('#legend .title').textContent")
        assert legend.endswith(f"[{unit}]")


def test_a_plane_cuts_and_switches_switch(page):
    whole = page.picture("#canvas")
    choose(page, "cut-axis", "1", "input")
    choose(page, "cut-place", "200", "input")
    cut = page.picture("#canvas")
    assert (np.abs(cut - whole).max(axis=2) > 0.02).mean() > 0.03
    low, high = page.value("(({min, max}) => [min.y, max.y])(report.stage.box)")
    at = low + 0.4 * (high - low)
    assert page.value("document.getElementById('cut-words').textContent").endswith(" mm")
    ends = page.value(ENDS)
    assert len(ends) >= 4  # three plies, and tools
    for line in ends:
        np.testing.assert_allclose(np.reshape(line, (-1, 3))[:, 1], at, atol=1e-7)
    choose(page, "cut-axis", "", "input")
    np.testing.assert_allclose(page.picture("#canvas"), whole, atol=0.02)
    for name, count in (("plies", 3), ("tools", 3)):
        boxes = f"document.querySelectorAll('#{name} input')"
        assert page.value(f"{boxes}.length") == count
        page.value(f"{boxes}.forEach(box => box.click())")
        page.until("!window.report.stage._waiting")
    bare = page.picture("#canvas")
    assert np.ptp(bare[5:-5, 5:-5].reshape(-1, 3), axis=0).max() < 0.02  # nothing is left


def test_curves_follow_the_slider_and_lead_it(page):
    assert page.value("document.querySelectorAll('#plots canvas').length") >= 6
    page.value("window.report.setTime(5)")
    page.until(f"{VIEWS}[0].frame === 2")  # of 0, 2.5, 5, 7.5, 10 ms and the rest that follows
    assert page.value("window.report.plots.time") == pytest.approx(
        1e3 * page.value("window.report.data.runs[0].times[2]")
    )


def test_a_dark_page_is_dark(browser, made):
    browser.open(made, dark=True)
    assert browser.picture().mean() < 0.35  # white is 1; of a light page it is 0.8 and more
    assert browser.complaints() == []


def test_differences_are_those_of_the_same_material_points(browser, pressed, coarser, tmp_path):
    out = write_report([pressed[1], coarser], tmp_path / "two.html")
    browser.open(out)
    choose(browser, "mode", "moved")
    browser.until("report.mode === 'moved'")
    one, other = wd.read_run(pressed[1]), wd.read_run(coarser)
    ply = "report.stage.views[1].plies[1]"
    count = len(other.plies[1].points)
    told = browser.value(
        f"Array.from({{length: {count}}}, (_, k) => differenceAt({ply}, {{name: 'moved'}}, k))"
    )
    expected = moved(one.plies[1], other.plies[1])
    known = np.isfinite(expected)
    assert known.mean() > 0.8 and np.nanmax(expected) > 0.3
    told = np.array([np.nan if v is None else v for v in told])
    np.testing.assert_allclose(told[known], expected[known], atol=0.02)  # 16 bits of each, in mm
    middles = other.plies[1].rest_points[other.plies[1].triangles].mean(axis=1)
    finder = finder_of(one.plies[1])
    there = finder(*middles[:, :2].T)
    mine = np.abs(other.plies[1].shear_angle_deg)
    shear = mine - np.abs(one.plies[1].shear_angle_deg)[there]
    told = browser.value(
        f"Array.from({{length: {len(mine)}}}, (_, k) =>"
        f" differenceAt({ply}, {{name: 'shear'}}, k, Math.abs))"
    )
    agree = np.abs(np.array(told, float) - shear) < 2e-3
    assert agree[there >= 0].mean() > 0.95  # middles on a side of two triangles may go either way
    assert browser.value("document.getElementById('names').children.length") == 2
    choose(browser, "mode", "difference")
    assert browser.value("report.differenceScale[1]") >= np.abs(shear).max()
    assert browser.complaints() == []


def finder_of(ply):
    return Triangulation(*ply.rest_points[:, :2].T, ply.triangles).get_trifinder()


def moved(one, other):
    """Distance [mm] of a ply's vertices from where their material points are in another run."""
    flat = other.rest_points[:, :2]
    there = finder_of(one)(*flat.T)
    found = np.full(len(flat), np.nan)
    for k, triangle in enumerate(there):
        if triangle >= 0:
            corners = one.triangles[triangle]
            rest = np.column_stack([one.rest_points[corners, :2], np.ones(3)])
            weights = np.linalg.solve(rest.T, [*flat[k], 1.0])
            found[k] = 1e3 * np.linalg.norm(other.points[k] - weights @ one.points[corners])
    return found


def test_a_strangers_names_do_nothing(browser, pressed, tmp_path):
    copy = shutil.copytree(pressed[1], tmp_path / "copy")
    name = "</script><script>window.taken=1</script><img src=x onerror='window.taken=1'>"
    path = copy / "summary.json"
    data = json.loads(path.read_text("utf-8"))
    data["plies"][0]["name"] = data["tools"][0]["name"] = name
    path.write_text(json.dumps(data), "utf-8")
    browser.open(write_report([copy]))
    labels = browser.value("[...document.querySelectorAll('#plies label')].map(e => e.textContent)")
    assert labels[0] == f" {name}"
    assert browser.value("window.taken === undefined && !document.querySelector('img')")
    assert browser.complaints() == []
