"""What the documents promise is there: links, files, commands, scripts, dependencies."""

import math
import re
import runpy
import shlex
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import warpdrape as wd
from warpdrape.cli import build_parser
from warpdrape.commands.scene_library import find_script
from warpdrape.materials.fabric_library import load_fabric

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / f"{name}.md" for name in ("README", "CONTRIBUTING", "CHANGELOG")]
PAGES += sorted((ROOT / "docs").rglob("*.md"))
LINK = re.compile(r"\]\(([^)\s]+)\)")
BLOCK = re.compile(r"```(\w+)\n(.*?)```", re.DOTALL)


def pages():
    return pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)


def blocks(page: Path, language: str) -> list[str]:
    return [text for kind, text in BLOCK.findall(page.read_text("utf-8")) if kind == language]


def commands(program: str) -> list[list[str]]:
    lines = [line for page in PAGES for text in blocks(page, "sh") for line in text.splitlines()]
    split = [shlex.split(line, comments=True) for line in lines]
    return [words for words in split if words and words[0] == program]


def anchor(heading: str) -> str:
    """As GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


@pages()
def test_links_lead_somewhere(page):
    for link in LINK.findall(page.read_text("utf-8")):
        if link.startswith("https://"):
            continue
        name, _, section = link.partition("#")
        target = (page.parent / name).resolve() if name else page
        assert target.is_file(), f"{page.name}: {link}"
        if section:
            headings = re.findall(r"^#+ (.*)$", target.read_text("utf-8"), re.MULTILINE)
            assert section in map(anchor, headings), f"{page.name}: {link}"


def test_every_page_is_found_from_the_first():
    first = ROOT / "docs" / "README.md"
    found, ahead = {first}, [first]
    while ahead:
        page = ahead.pop()
        links = (link.partition("#")[0] for link in LINK.findall(page.read_text("utf-8")))
        for target in ((page.parent / link).resolve() for link in links if link.endswith(".md")):
            if target.is_file() and target.is_relative_to(ROOT / "docs") and target not in found:
                found.add(target)
                ahead.append(target)
    assert not {*(ROOT / "docs").rglob("*.md")} - found


def test_the_page_on_a_package_index_has_no_link_that_only_a_checkout_can_follow():
    namespace = runpy.run_path(str(ROOT / "setup.py"), run_name="read")
    page = namespace["package_page"]((ROOT / "README.md").read_text("utf-8"))
    assert all(link.startswith("https://") for link in LINK.findall(page))
    assert "usage (`docs/usage.md` in the source)" in page
    for file in re.findall(r"`([^`]+)` in the source", page):
        assert (ROOT / file).is_file()


@pytest.mark.parametrize("room", ["tests", "bench", "docs", "examples", "warpdrape/report"])
def test_a_source_distribution_has_all_files(room):
    """Python's own files of the package are in it anyway."""
    lines = (ROOT / "MANIFEST.in").read_text("utf-8").splitlines()
    rules = [line.split()[1:] for line in lines if line.startswith("recursive-include ")]
    for file in (ROOT / room).rglob("*"):
        made = any(part.startswith((".", "__pycache__")) for part in file.relative_to(ROOT).parts)
        if made or file.is_dir() or (room.startswith("warpdrape") and file.suffix == ".py"):
            continue
        taken = (
            file.is_relative_to(ROOT / folder) and any(map(file.match, patterns))
            for folder, *patterns in rules
        )
        assert any(taken), file


@pages()
def test_files_named_are_there(page):
    for name in re.findall(r"`((?:[\w.]+/)+[\w.]*)`", page.read_text("utf-8")):
        made_by_the_user = name.startswith(("runs/", ".venv/"))
        assert made_by_the_user or (ROOT / name).exists(), f"{page.name}: {name}"


@pages()
def test_no_path_of_some_machine_and_nothing_left_to_fill_in(page):
    text = page.read_text("utf-8")
    absolute = re.findall(r"(?<![\w.:/*)>–])/(?!World/)[a-z][\w.-]*/[\w./-]+", text)
    assert absolute == [], page.name
    assert re.findall(r"TODO|FIXME|\b[A-Z]+_(?:TABLE|ROWS)\b", text) == [], page.name


def test_commands_exist():
    written = commands("warpdrape")
    assert {"run", "scenes", "fabrics", "picture", "verify"} <= {words[1] for words in written}
    for words in written:
        arguments = build_parser().parse_args(words[1:])
        if arguments.command == "run" and not arguments.scene.endswith(".py"):
            find_script(arguments.scene).read_settings(arguments.settings)
        if arguments.command == "fabrics":
            load_fabric(arguments.fabric)


def test_friction_laws_of_the_page_of_fabrics():
    (text,) = blocks(ROOT / "docs" / "fabrics.md", "python")
    laws = {"wd": wd}
    exec(text.partition("scene = ")[0], laws)
    assert laws["dry"](pressure=30e3, angle_deg=22.5) == pytest.approx(0.27 * 0.28 / 0.3)
    assert laws["melt"](pressure=1e4, speed=1e-2) > laws["melt"](pressure=1e5, speed=1e-2)


def test_bootstrap_commands_name_a_scene():
    runs = [words for words in commands("python") if words[1:3] == ["bootstrap.py", "run"]]
    assert runs
    for words in runs:
        find_script(words[3])


def test_script_of_the_usage_page(tmp_path):
    script = tmp_path / "press_disc.py"
    script.write_text(blocks(ROOT / "docs" / "usage.md", "python")[0], encoding="utf-8")
    scene = find_script(script).make(["angle_deg=30"])
    assert [tool.name for tool in scene.tools] == ["die", "holder", "punch"]


def test_card_of_the_page_of_fabrics(tmp_path):
    text, compaction, crossover = blocks(ROOT / "docs" / "fabrics.md", "toml")
    fabric = tmp_path / "my_twill.toml"
    fabric.write_text(text, encoding="utf-8")
    assert load_fabric(fabric).areal_density == 0.6
    fabric.write_text(text + compaction, encoding="utf-8")
    assert load_fabric(fabric).compaction.pressures[-1] == 75e3
    fabric.write_text(text + crossover, encoding="utf-8")
    law = load_fabric(fabric).crossover
    assert (law.slip_force_weft, law.stiffness_warp, law.friction) == (0.06, 800.0, 0.0)


def test_lines_of_python_on_the_usage_page(capsys):
    (text,) = [block for block in blocks(ROOT / "docs" / "usage.md", "python") if "print(" in block]
    exec(compile(text, "usage.md", "exec"), {})
    assert "(144,) (144, 3)" in capsys.readouterr().out


def test_segments_grips_clamps_and_pins_of_the_page_of_devices():
    """Each does what the page says of it, and its reaction is in the history."""
    page = blocks(ROOT / "docs" / "devices.md", "python")
    (text,) = [block for block in page if "segments = [" in block]
    names = {"wd": wd, "Ply": wd.Ply, "lay_up": wd.lay_up, "stack_top": wd.stack_top}
    names |= {"mm": 1e-3, "ms": 1e-3, "deg": math.pi / 180.0, "replace": replace}
    exec(compile(text, "devices.md", "exec"), names)
    result = names["scene"].run(frames=8, threads=1, quiet=True)
    history, (ply,) = result.history, result.plies
    assert result.completed and history["punch_displacement_m"][-1] == pytest.approx(0.03)
    assert history["segment_1_force_n"][3] == pytest.approx(40.0, rel=0.05)
    assert history["segment_3_force_n"][-1] == pytest.approx(5.0, rel=0.05)
    flat = ply.rest_points
    moved = ply.points - flat
    assert np.abs(moved[flat[:, 0] < -0.149] - moved[0]).max() < 1e-9
    assert history["led_displacement_m"][-1] == pytest.approx(5e-3) == moved[0, 0]
    assert np.linalg.norm(moved[flat[:, :2].sum(axis=1).argmax()]) < 1e-9
    pin = max(np.abs(history[f"pin_force_{axis}_n"]).max() for axis in "xy")
    assert pin > 5.0 and history["led_force_n"].max() > 20.0
    assert history["grip_force_n"][0] == pytest.approx(5.0, rel=1e-3)
    assert history["grip_force_n"].max() < 8.0 and history["grip_slip_m"][-1] > 1e-3


def test_lines_of_python_on_the_page_of_approaches(capsys):
    (text,) = blocks(ROOT / "docs" / "approaches.md", "python")
    names = {}
    exec(compile(text.replace("5 * mm", "10 * mm"), "approaches.md", "exec"), names)
    assert "Net: " in capsys.readouterr().out
    assert len(names["darts"]) == 4


def test_card_and_lines_of_python_on_the_page_of_prepregs(tmp_path):
    page = ROOT / "docs" / "prepreg.md"
    (matrix,) = blocks(page, "toml")
    card = tmp_path / "my_prepreg.toml"
    card.write_text(blocks(ROOT / "docs" / "fabrics.md", "toml")[0] + matrix, encoding="utf-8")
    assert load_fabric(card).matrix == load_fabric("synthetic_prepreg").matrix
    (text,) = blocks(page, "python")
    names = {}
    exec(compile(text.replace("cells=10", "cells=4"), "prepreg.md", "exec"), names)
    result = names["scene"].run(frames=1)
    assert result.completed and result.summary["process_clock"]["process_s"] == pytest.approx(2.0)
    assert result.plies[0].temperature.min() < result.plies[0].temperature.max()


def test_lines_of_python_on_the_notebook_page(tmp_path, monkeypatch):
    pytest.importorskip("pyvista")
    monkeypatch.chdir(tmp_path)
    start, *rest = blocks(ROOT / "docs" / "notebook.md", "python")
    names = {}
    exec(compile(start.replace("cells=8", "cells=4"), "notebook.md", "exec"), names)
    for text in rest:
        exec(compile(text, "notebook.md", "exec"), names)
    assert names["half_way"].frame == 30
    assert names["blocks"].keys()[0] == "ply_0"


def test_every_dependency_has_its_reason():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    lists = [project["dependencies"], *project["optional-dependencies"].values()]
    wanted = [name for each in lists for name in each if not name.startswith("warpdrape[")]
    text = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
    table = text.partition("## Dependencies")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| (`[^|]+) \|", table, re.MULTILINE)
    given = [name for row in rows for name in re.findall(r"`([\w-]+)`", row)]
    assert sorted(given) == sorted(re.match(r"[\w-]+", name)[0] for name in wanted)
