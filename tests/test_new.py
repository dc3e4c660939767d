"""``warpdrape new``: a script that runs at once, for a mould and a blank of any kind."""

import ast
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from warpdrape import cli
from warpdrape.cli import joined
from warpdrape.commands import writing
from warpdrape.commands.scene_library import describe_scene, find_script, find_typed
from warpdrape.numerics import Numerics
from warpdrape.tools.profile import Arc, Line, revolve

TUTORIAL = Path(__file__).parents[1] / "examples" / "tutorial"


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """A folder with a female and a male mould as STL in millimetres."""
    monkeypatch.chdir(tmp_path)
    profile = [
        Line((90.0, 0.0), (60.0, 0.0)),
        Arc((60.0, -8.0), 8.0, 0.5 * math.pi, 0.75 * math.pi),
    ]
    start = (60.0 - 8.0 * math.sqrt(0.5), -8.0 * (1.0 - math.sqrt(0.5)))
    foot = (30.0, start[1] - (start[0] - 30.0))
    profile += [Line(start, foot), Line(foot, (0.0, foot[1]))]
    bowl = revolve(profile, 4.0).mesh
    bowl.export("bowl.stl")
    bowl.apply_transform(trimesh.transformations.rotation_matrix(math.pi, (1.0, 0.0, 0.0)))
    bowl.export("hump.stl")
    trimesh.creation.icosphere(3, 50.0).export("ball.stl")
    return tmp_path


def new(*argv):
    return cli.main(["new", *map(str, argv)])


def built(name, *settings):
    return find_typed(name).make(settings)


def test_a_female_mould_from_stl(capsys, place):
    assert new("part", "--mould", "bowl.stl", "--units", "mm", "--angles", "0,45,-30") == 0
    said = capsys.readouterr().out
    assert "part.py is written" in said and "counts in mm: a female mould with a flat rim" in said
    scene = built("part")
    assert [tool.name for tool in scene.tools] == ["mould", "punch", "holder"]
    angles = [math.degrees(ply.warp_angle) for ply in scene.plies]
    assert angles == pytest.approx([0.0, 45.0, -30.0])
    assert np.ptp(scene.tools[0].vertices[:, 0]) == pytest.approx(0.18, rel=1e-3)
    assert scene.limits.shear_deg == 50.0 and scene.plies[0].z == pytest.approx(3e-4)
    punch = scene.tools[1]
    assert punch.vertices[:, 2].min() == pytest.approx(3 * 6e-4)
    lowest = scene.tools[0].vertices[:, 2].min() + 1.5 * 3 * 6e-4
    ended = punch.pose(scene.duration).place(punch.vertices)[:, 2].min()
    assert ended == pytest.approx(lowest, abs=1e-6)
    assert [tool.name for tool in built("part", "holder_force=0").tools] == ["mould", "punch"]
    assert len(built("part", "angles=10").plies) == 1


def test_a_male_mould_has_its_holder_under_the_plies():
    assert new("part", "--mould", "hump.stl", "--units", "mm", "--blank", "140x120mm") == 0
    scene = built("part")
    assert [tool.name for tool in scene.tools] == ["mould", "die", "holder"]
    assert scene.tools[2].motion.axis[2] == 1.0
    top = scene.tools[0].vertices[:, 2].max()
    assert scene.plies[0].z == pytest.approx(top + 3e-4)
    np.testing.assert_allclose(np.ptp(scene.plies[0].mesh.vertices, axis=0), (0.14, 0.12))
    assert scene.tools[2].vertices[:, 2].max() == pytest.approx(top)


def test_without_a_rim_there_is_no_holder(capsys):
    assert new("part", "--mould", "ball.stl", "--units", "mm") == 0
    assert "no flat rim: there is no blank holder" in capsys.readouterr().out
    scene = built("part")
    assert [tool.name for tool in scene.tools] == ["mould", "die"]
    assert "holder_force" not in find_typed("part").parameters
    assert new("other", "--mould", "ball.stl", "--units", "mm", "--holder", "100N") == 2
    assert "no flat rim round its shape" in capsys.readouterr().err


def test_from_step_and_drawing_nothing_is_scaled_twice(capsys):
    pytest.importorskip("OCP.STEPControl")
    pytest.importorskip("ezdxf")
    (mould, blank) = (TUTORIAL / "tray.step", TUTORIAL / "tray_blank.dxf")
    assert new("part", "--mould", mould, "--blank", blank, "--holder", "0.2kN") == 0
    said = capsys.readouterr().out
    assert "tray.step states its unit, millimetre" in said and "5,306 facets" in said
    scene = built("part")
    np.testing.assert_allclose(np.ptp(scene.tools[0].vertices, axis=0), (0.22, 0.18, 0.025))
    np.testing.assert_allclose(np.ptp(scene.plies[0].mesh.vertices, axis=0), (0.2, 0.16), rtol=1e-3)
    np.testing.assert_allclose(scene.plies[0].mesh.vertices.mean(axis=0), 0.0, atol=1e-3)
    assert scene.tools[2].motion.force == 200.0
    assert new("again", "--mould", mould, "--units", "mm") == 2
    assert "states its unit, millimetre: leave units out" in capsys.readouterr().err
    inside = ["--mould", mould, "--blank", "0.02x0.02m"]
    assert new("small", *inside) == 2
    assert "does not go with the mould's shape" in capsys.readouterr().err
    assert not Path("small.py").exists() and not Path("again.py").exists()


@pytest.mark.parametrize(("units", "given"), [(0, "mm"), (5, "mm")])
def test_units_are_those_of_the_file_that_states_none(units, given):
    ezdxf = pytest.importorskip("ezdxf")
    drawing = ezdxf.new("R2010", units=units)
    scale = 1.0 if units == 0 else 0.1  # centimetres
    drawing.modelspace().add_circle((0.0, 0.0), 80.0 * scale)
    drawing.saveas("round.dxf")
    assert new("part", "--mould", "bowl.stl", "--units", given, "--blank", "round.dxf") == 0
    assert np.ptp(built("part").plies[0].mesh.vertices[:, 0]) == pytest.approx(0.16, rel=1e-3)
    if units == 0:
        pytest.importorskip("OCP.STEPControl")
        step = TUTORIAL / "tray.step"
        assert new("other", "--mould", step, "--units", given, "--blank", "round.dxf") == 0


def test_a_stand_in_until_there_is_a_mould(capsys):
    assert new("part") == 0
    said = capsys.readouterr().out
    assert "a double dome stands in for it; --mould FILE takes yours" in said
    assert len(built("part", "edge=30mm").tools) == 3
    assert "Mould.from_file(HERE" in Path("part.py").read_text("utf-8")


def test_a_blank_that_is_not_given_lies_within_a_round_border_where_it_can(capsys):
    assert new("part") == 0
    assert "281 × 281 mm, within the mould" in capsys.readouterr().out
    points = built("part").plies[0].rest_points
    assert 0.19 < np.linalg.norm(points[:, :2], axis=1).max() <= 0.2
    assert new("round", "--mould", "bowl.stl", "--units", "mm") == 0
    assert "mm, as the mould's shape needs, with corners beyond" in capsys.readouterr().out
    points = built("round").plies[0].rest_points
    shape = find_typed("round").make().tools[1].vertices  # the punch, as wide as the shape
    assert (points.max(axis=0)[:2] >= shape.max(axis=0)[:2]).all()


def test_a_prepreg_gets_the_presss_time(capsys):
    mould = ["--mould", "bowl.stl", "--units", "mm"]
    assert new("part", *mould, "--fabric", "synthetic_prepreg") == 0
    assert (
        "synthetic_prepreg has a viscous matrix; the press closes in 2 s" in capsys.readouterr().out
    )
    assert built("part").process_duration == pytest.approx(2.4)
    assert built("part", "closing_time=10").process_duration == pytest.approx(12.0)
    assert new("dry", *mould) == 0
    assert "closing_time" not in find_typed("dry").parameters
    assert built("dry").process_duration is None
    assert built("dry").numerics == Numerics.for_accuracy("standard")
    assert built("dry", "accuracy=reference").numerics == Numerics()
    assert built("part").numerics == Numerics()  # softer yarns would let the matrix lag


def test_the_script_is_plain_clean_and_described():
    assert new("part", "--mould", "bowl.stl", "--units", "mm") == 0
    text = Path("part.py").read_text("utf-8")
    assert max(map(len, text.splitlines())) <= 100 and len(text.splitlines()) < 110
    ruff = [
        sys.executable,
        "-m",
        "ruff",
        "check",
        "--isolated",
        "--select",
        "E,F,W,I,UP",
        "--line-length",
    ]
    assert subprocess.run([*ruff, "100", "part.py"], capture_output=True).returncode == 0
    imported = [n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.ImportFrom)]
    assert {n.module for n in imported} <= {
        "dataclasses",
        "pathlib",
        "warpdrape",
        "warpdrape.units",
        "warpdrape.cli",
    }
    described = describe_scene(find_typed("part"))
    for name in ("angles", "fabric", "edge", "room", "holder_force", "duration", "approach"):
        assert f"  {name} " in described
    assert "[deg]" in described and "[N]" in described


def test_a_mould_upside_down_is_refused_and_the_advice_works(capsys):
    block, ball = trimesh.creation.box((200, 200, 100)), trimesh.creation.icosphere(4, 40.0)
    ball.apply_translation((0.0, 0.0, -50.0))  # half of it looks out below
    trimesh.util.concatenate([block, ball]).export("block.stl")
    given = ["--mould", "block.stl", "--units", "mm"]
    assert new("part", *given) == 2
    assert "may lie upside down; give another --up, such as --up=-z" in capsys.readouterr().err
    assert new("part", *given, "--up=-z") == 0 and new("other", *given, "--up", "-z") == 0
    for name in ("part", "other"):
        assert [tool.name for tool in built(name).tools] == ["mould", "die", "holder"]


def test_signs_are_no_options(capsys):
    assert new("part", "--angles", "-45,45") == 0
    angles = [math.degrees(ply.warp_angle) for ply in built("part").plies]
    assert angles == pytest.approx([-45.0, 45.0])
    assert joined(["new", "x", "--up", "-x", "-q", "--out", "-.5"]) == [
        *("new", "x", "--up=-x", "-q", "--out=-.5")
    ]
    assert joined(["export", "r", "--trim", "-x+0.5*z>2mm"]) == [
        "export",
        "r",
        "--trim=-x+0.5*z>2mm",
    ]
    assert joined(["export", "--trim", "-z<-2mm", "-x"]) == ["export", "--trim=-z<-2mm", "-x"]
    assert joined(["picture", "--tools", "-xy"]) == ["picture", "--tools", "-xy"]
    assert joined(["picture", "-q", "-5"]) == ["picture", "-q", "-5"]
    assert joined(["picture", "--tools", "-q"]) == ["picture", "--tools", "-q"]


def test_what_may_not_be_meant_is_said(capsys):
    ball = trimesh.creation.icosphere(subdivisions=3, radius=40.0)
    ball.apply_translation((0.0, 0.0, 60.0))
    trimesh.util.concatenate([trimesh.creation.box((200, 200, 10)), ball]).export("under.stl")
    assert new("part", "--mould", "under.stl", "--units", "mm") == 0
    assert "% of it is undercut, looks down, and is left out" in capsys.readouterr().out
    trimesh.load("hump.stl").apply_scale(1.0 / 25.4).export("inches.stl")
    assert new("small", "--mould", "inches.stl", "--units", "mm") == 0
    assert "mm across: look whether mm is its unit" in capsys.readouterr().out
    assert new("right", "--mould", "inches.stl", "--units", "inch", "--kind", "female") == 0
    said = capsys.readouterr().out
    assert "It looks like a male mould; female was asked for." in said
    assert "look whether" not in said and "undercut" not in said and "does not cover" not in said
    trimesh.load("hump.stl").apply_scale(1e-3).export("metres.stl")
    assert new("wrong", "--mould", "metres.stl", "--units", "mm") == 2
    assert "give another of units: 'm', 180 mm" in capsys.readouterr().err
    assert new("wrong", "--mould", "metres.stl", "--units", "m") == 0


@pytest.mark.parametrize(("subdivisions", "coarse"), [(3, True), (5, False)])
def test_coarse_facets_are_said(subdivisions, coarse, capsys):
    trimesh.creation.icosphere(subdivisions, 50.0).export("part.stl")
    assert new("part", "--mould", "part.stl", "--units", "mm") == 0
    assert ("or as STEP" in capsys.readouterr().out) is coarse


def test_a_file_is_never_replaced(capsys):
    Path("part.py").write_text("mine")
    assert new("part") == 2
    assert "part.py is there already, and is not replaced" in capsys.readouterr().err
    assert Path("part.py").read_text() == "mine"


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (["1part"], "must be a plain name"),
        (["hemisphere"], "is that of a bundled scene"),
        (["nowhere/part"], "is no folder"),
        (["part", "--mould", "bowl.stl"], "bowl.stl is 180 × 180 × 26.69"),
        (["part", "--mould", "bowl.stl", "--units", "m"], "is 180 m across"),
        (["part", "--mould", "bowl.stl", "--units", "ell"], "unknown unit 'ell'"),
        (["part", "--mould", "none.stl", "--units", "mm"], "no mesh file 'none.stl'"),
        (
            ["part", "--mould", "bowl.stl", "--units", "mm", "--kind", "odd"],
            "unknown kind of mould",
        ),
        (["part", "--mould", "bowl.stl", "--units", "mm", "--up", "w"], "unknown up 'w'"),
        (["part", "--kind", "odd"], "unknown kind of mould"),
        (["part", "--kind", "male"], "--kind is of a mould: give --mould FILE too, or leave it"),
        (["part", "--up", "w"], "unknown up 'w'"),
        (["part", "--up", "-z"], "--up is of a mould"),
        (["part", "--units", "mm"], "--units is of a mould or a drawing"),
        (["part", "--layer", "cut"], "--layer is of a .dxf"),
        (["part", "--blank", "300x300mm", "--layer", "cut"], "--layer is of a .dxf"),
        (["part", "--angles", "0;45"], "must be degrees with commas"),
        (["part", "--angles", "nan"], "must be degrees with commas"),
        (["part", "--blank", "big"], "must be a .dxf, or a size such as 300x200mm"),
        (["part", "--blank", "none.dxf"], "none.dxf does not exist"),
        (["part", "--blank", "0x20mm"], "must be above zero"),
        (["part", "--fabric", "silk"], "silk"),
        (["part", "--holder", "strong"], "must be a force, such as 200N"),
    ],
)
def test_what_cannot_be_used_is_refused_and_nothing_is_left(argv, words, capsys):
    assert new(*argv) == 2
    assert words in capsys.readouterr().err
    assert list(Path().glob("*.py")) == []


def test_a_script_that_does_not_build_is_not_left_behind(monkeypatch, capsys):
    monkeypatch.setattr(writing, "script_text", lambda draft: "def build():\n    return 3\n")
    assert new("part") == 2
    assert "must return a warpdrape.Scene" in capsys.readouterr().err
    assert not Path("part.py").exists()


def test_on_a_terminal_it_asks_for_what_is_missing(monkeypatch, capsys):
    monkeypatch.setattr(writing, "_is_terminal", lambda arguments: True)
    answers = iter(["bowl.stl", "mm", "", "0, 90", ""])
    asked = []
    monkeypatch.setattr("builtins.input", lambda words: asked.append(words) or next(answers))
    assert new("part") == 0
    assert asked[0].startswith("Mould, a STEP")
    assert len(asked) == 5 and "bowl.stl is 180 × 180 × 26.69" in capsys.readouterr().out
    assert len(built("part").plies) == 2


def test_a_script_elsewhere_finds_its_files(place):
    (place / "scenes").mkdir()
    assert new("scenes/part", "--mould", "bowl.stl", "--units", "mm") == 0
    assert 'HERE / "../bowl.stl"' in (place / "scenes/part.py").read_text("utf-8")
    assert built("scenes/part").tools[0].name == "mould"


def test_what_is_typed_may_be_a_stem_and_what_is_recorded_may_not():
    assert new("part", "--mould", "bowl.stl", "--units", "mm") == 0
    assert find_typed("part").path.resolve() == Path("part.py").resolve()
    with pytest.raises(ValueError, match="unknown scene 'part'"):
        find_script("part")
    Path("hemisphere.py").write_text("raise SystemExit(1)")
    assert find_typed("hemisphere").bundled
