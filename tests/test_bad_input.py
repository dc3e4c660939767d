"""What a user gets for input that cannot be used."""

import math
import sys

import pytest
import trimesh

import warpdrape as wd
from warpdrape import cli
from warpdrape.materials.laws import LinearTension
from warpdrape.scenes import hemisphere

SMALL = {"cells": 6, "duration": 0.005}


@pytest.fixture
def refused(tmp_path, capsys, monkeypatch):
    """Run the command line; check status 2 and one line; return it. Nothing may be computed."""

    def computed(*_):
        raise AssertionError("a step was computed")

    def call(*argv, out=None, compute=computed):
        folder = tmp_path / "results" if out is None else out
        with monkeypatch.context() as patch:
            patch.setattr("warpdrape.simulation.Recorder", compute)
            patch.setattr("warpdrape.warp_start.kernels_are_compiled", lambda: True)
            options = ["--out", folder] if argv[0] == "run" else []
            assert cli.main([str(a) for a in (*argv, *options)]) == 2
        said, complaint = capsys.readouterr()
        assert said == "" or argv[0] == "fabrics"
        assert complaint.startswith("warpdrape: error: ") and complaint.endswith("\n")
        assert len(complaint.splitlines()) == 1
        assert not (tmp_path / "results").exists()
        return complaint

    return call


@pytest.fixture
def script(tmp_path):
    """Write a scene script: the body of build(), with a few names at hand."""

    def write(body: str, parameters: str = "") -> str:
        path = tmp_path / "mine.py"
        lines = "".join(f"    {line}\n" for line in body.splitlines())
        path.write_text(f"{HEAD}\ndef build({parameters}):\n{lines}", encoding="utf-8")
        return str(path)

    return write


HEAD = """import numpy as np
import trimesh
from dataclasses import replace
from warpdrape import *
from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.materials.laws import LinearTension

def ply(name="a", z=3e-4, **options):
    return Ply.rectangle(name, "carbon_interlock", 0.1, cells=4, z=z, **options)

def scene(*plies, **options):
    return Scene(name="mine", plies=plies or [ply()], duration=1e-3, **options)
"""


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        ("rum hemisphere", "unknown command 'rum'; did you mean 'run'?"),
        ("run hemispher", "unknown scene 'hemispher'; did you mean 'hemisphere'? known: "),
        ("run press", "unknown scene 'press'"),
        (
            "run hemisphere.py",
            "hemisphere.py does not exist; the bundled scene is called 'hemisphere'",
        ),
        ("run .", "unknown scene '.'; known: "),
        (
            "run hemisphere --set cell=3",
            "no parameter 'cell'; did you mean 'cells'? known: accuracy",
        ),
        ("run hemisphere --set cells", "--set cells: write NAME=VALUE"),
        (
            "run hemisphere --set cells=20.5",
            "cells = '20.5' must be a whole number, such as cells=20",
        ),
        ("run hemisphere --set cells=many", "cells = 'many' must be a whole number"),
        ("run hemisphere --set cells=0", "cells = 0 must be a whole number of squares, 1 or more"),
        (
            "run hemisphere --set cells=100000",
            "more than 2e+07: take fewer cells, or a longer edge",
        ),
        ("run hemisphere --set facet=1e-6", "facet = 1e-06 m makes"),
        (
            "run hemisphere --set travel=75kg",
            "travel = '75kg': units it may be given with: m, cm, mm, ",
        ),
        (
            "run hemisphere --set travel=far",
            "travel = 'far' must be a number, such as travel=0.075",
        ),
        (
            "run hemisphere --set mass_scaling=selective --set minimum_time_step=1kg",
            "units it may be given with: s, ms, ",
        ),
        ("run hemisphere --set travel=nan", "travel = nan must be finite"),
        ("run hemisphere --set friction=-inf", "friction = -inf must be finite"),
        ("run hemisphere --set friction=-0.1", "friction = -0.1 must be zero or more"),
        (
            "run hemisphere --set travel=75",
            "'punch' travels 75 m, more than 20 times the plies' 0.3 m",
        ),
        ("run hemisphere --set blank_size=300", "ply 'ply_0' is 300 m across"),
        ("run hemisphere --set blank_size=-0.3", "width = -0.3 m must be above zero"),
        ("run hemisphere --set duration=0", "duration = 0.0 s must be above zero"),
        ("run hemisphere --set duration=1e7", "give seconds (80 ms is 0.08)"),
        ("run hemisphere --set angle_deg=900", "must lie in ±360°: give radians, as in 45 * deg"),
        ("run hemisphere --set mesh=gird", "unknown mesh pattern 'gird'; did you mean 'grid'?"),
        ("run hemisphere --set fabric=carbon_interlok", "did you mean 'carbon_interlock'?"),
        ("run hemisphere --set fabric=none.toml", "none.toml"),
        ("run hemisphere --set contact_share=0.5", "contact_share = 0.5 must not exceed 0.2"),
        ("run hemisphere --frames 0", "--frames 0 must be 1 or more"),
        ("run hemisphere --frames 2.5", "--frames 2.5 must be a whole number"),
        ("run hemisphere --device cuda:7", "no device 'cuda:7' here; there is: cpu"),
        ("run hemisphere --device gpu", "no device 'gpu' here"),
        ("run hemisphere --fast", "unrecognized arguments: --fast"),
        ("run", "the following arguments are required: SCENE"),
        ("scenes hemisfere", "did you mean 'hemisphere'?"),
        ("fabrics carbon", "unknown fabric 'carbon'; did you mean 'carbon_interlock'?"),
        ("fabrics --plot x.png", "warpdrape fabrics NAME --plot FILE"),
        ("fabrics carbon_interlock --plot no/where.png", "--plot no/where.png cannot be written"),
        ("picture nowhere", "run folder nowhere does not exist"),
        ("picture nowhere --frame last", "--frame last must be a whole number"),
        (
            "picture nowhere --ply a --stack",
            "give --ply NAME for one ply or --stack for all, not both",
        ),
    ],
)
def test_command_line(argv, words, refused):
    assert words in refused(*argv.split())


@pytest.mark.parametrize(
    ("body", "words"),
    [
        # Fabric values
        (
            "f = ply().fabric\nreplace(f, thickness=-6e-4)",
            "thickness = -0.0006 m must be above zero",
        ),
        ("replace(ply().fabric, thickness=0.6)", "thickness = 0.6 m: give metres, not millimetres"),
        ("replace(ply().fabric, areal_density=0)", "areal_density = 0 kg/m² must be above zero"),
        ("replace(ply().fabric, areal_density=630.)", "areal_density = 630.0 kg/m²: give kg/m²"),
        ("replace(ply().fabric, thickness=float('nan'))", "thickness = nan must be finite"),
        ("replace(ply().fabric, thickness='thin')", "thickness = 'thin' must be a number [m]"),
        ("LinearTension(float('nan'), 1.0)", "nan"),
        # Blanks
        ("FlatMesh([[0,0],[1,0],[0,1],[2,0]], [[0,1,2],[0,1,3]])", "triangles 1 have zero area"),
        ("FlatMesh([[0,0],[1,0],[0,1]], [[0,1,2],[2,0,1]])", "triangles 1 repeat another triangle"),
        (
            "FlatMesh([[0,0],[1,0],[0,1],[0,-1],[1,1]], [[0,1,2],[1,0,3],[0,1,4]])",
            "edges 0-1 (vertex-vertex) are shared by more than two triangles",
        ),
        (
            "FlatMesh([[0,0],[1,0],[0,1],[1,1]], [[0,1,2],[1,0,3]])",
            "two triangles at edge 0-1 lie on the same side of it and overlap",
        ),
        ("FlatMesh([[0,0],[1,0],[0,1],[5,5]], [[0,1,2]])", "vertices 3 belong to no triangle"),
        ("FlatMesh([[0,0],[1,np.nan],[0,1]], [[0,1,2]])", "vertices 1 are not finite"),
        ("FlatMesh([[0,0],[1,0],[0,1]], [[0,1,3]])", "triangles 0 name vertices outside 0..2"),
        ("Ply.from_file('a', 'carbon_interlock', 'no.stl')", "mesh file 'no.stl' does not exist"),
        ("ply('first ply')", "ply name = 'first ply' must be a plain identifier"),
        ("ply(warp_angle=45)", "give radians, as in 45 * deg"),
        # Stacks
        (
            "scene(ply('a'), ply('b'))",
            "plies 'a' and 'b' overlap at the start: 0 m apart, 0.0006 m",
        ),
        ("scene(ply('a', z=1e-3), ply('b'))", "ply 'b' lies 0.0007 m below 'a'"),
        ("scene(ply('a', z=1e-4), ply('b'))", "overlap at the start"),
        ("scene(ply('a'), ply('a', z=1e-3))", "two of the scene's ply names are 'a': rename one"),
        ("scene(ply(), 3)", "plies[1] = 3 is not a Ply"),
        ("Scene(name='s', plies=ply(), duration=1.0)", "must be a list of Ply"),
        ("Scene(name='s', plies=[], duration=1.0)", "a scene needs at least one ply"),
        # Tools
        ("Tool.from_mesh('t', trimesh.Trimesh())", "tool 't': its mesh has no facets"),
        (
            "Tool.from_mesh('t', trimesh.Trimesh([[0,0,0],[1,0,0],[0,np.nan,0]], [[0,1,2]],"
            " process=False))",
            "tool 't': its mesh holds NaN or infinite vertices",
        ),
        ("Tool.from_mesh('t', 'no.stl')", "tool 't': no mesh file 'no.stl'"),
        ("Tool.punch(radius=0)", "punch radius = 0 m must be above zero"),
        ("scene(tools=[Tool.punch(radius=0.05), Tool.punch(radius=0.05)])", "names are 'punch'"),
        ("scene(tools=[Tool.punch(radius=0.01, motion=5)])", "motion = 5 is not a motion"),
        # Clamps, motions and numerics
        ("Stroke(travel=(0, 0, 'down'), duration=1.0)", "must be three finite numbers"),
        ("scene(clamps=[Clamp(name='c', ply='b', where=[0])])", "unknown ply 'b'"),
        ("Clamp(name='c', ply='a', where=[0], motion=3)", "give a Stroke, Stages, Path or Still"),
        ("scene(numerics=Numerics(averaging='pair'))", "did you mean 'pairs'?"),
        ("scene(numerics=3)", "numerics = 3 must be a warpdrape.Numerics"),
        ("scene(gravity=-9.81)", "gravity = -9.81 must be three finite numbers"),
        # Scripts
        ("return 3", "build() returned int: it must return a warpdrape.Scene"),
        ("1 / 0", "mine.py, line 15: build() raised ZeroDivisionError: division by zero"),
        ("raise SystemExit(0)", "line 15: build() raised SystemExit"),
        ("raise MemoryError", "build() ran out of memory: take fewer cells or larger facets"),
    ],
)
def test_what_a_script_builds(body, words, refused, script):
    assert words in refused("run", script(body))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("numerics=Numerics(time_step=1.0)", "time_step = 1 s is above the stable"),
        (
            "clamps=[Clamp(name='c', ply='a', where=[9999])]",
            "ply 'a' has no vertex 9999, only 0..40",
        ),
        (
            "clamps=[Clamp(name='c', ply='a', where=lambda p: p[:, 0] > 1)]",
            "clamp 'c' holds no vertex of ply 'a'",
        ),
        # The pole of the punch 2 mm below the ply, then far below it, between vertices.
        (
            "tools=[Tool.punch(radius=0.05).moved((0, 0, -2e-3))]",
            "tool 'punch' starts inside ply 'a': raise it by 2.6 mm",
        ),
        (
            "tools=[Tool.punch(radius=2e-3, facet=1e-3).moved((0.012, 0.007, -1e-3))]",
            "tool 'punch' starts inside ply 'a': raise it by 1.6 mm",
        ),
        (
            "tools=[Tool.table(radius=0.04).moved((0, 0, 1e-4))]",
            "tool 'table' starts inside ply 'a': lower it by 0.1 mm",
        ),
        ("tools=[Tool.plate(width=1.0, height=1.0, facet=1.0).moved((0, 0, 3e-4))]", "inside"),
        # It stands clear of the ply, but its path begins in it.
        (
            "tools=[Tool.punch(radius=0.05, motion=Path(times=[0, 1], "
            "positions=[[0, 0, -.01], [0, 0, 0]])).moved((0, 0, 5e-3))]",
            "tool 'punch' starts inside ply 'a'",
        ),
        (
            "tools=[Tool.from_mesh('block', trimesh.creation.box((1.0, 1.0, 1.0)))]",
            "ply 'a' starts inside tool 'block'",
        ),
    ],
)
def test_what_a_scene_asks_for(options, words, refused, script):
    assert words in refused("run", script(f"return scene({options})"))


@pytest.mark.parametrize(
    "options",
    [
        "tools=[Tool.table(radius=0.04)]",
        "tools=[Tool.from_mesh('block', trimesh.creation.box((1, 1, 1))).moved((0, 0, -0.5))]",
        "tools=[Tool.punch(radius=0.05).moved((0, 0, 6e-4))]",
        "tools=[Tool.punch(radius=2e-3, facet=1e-3).moved((0.06, 0.0, -1e-3))]",  # beside the ply
        "tools=[Tool.die(hole_radius=0.03, edge_radius=5e-3, outer_radius=0.2)]",
    ],
)
def test_tools_that_touch_or_miss_the_ply_are_fine(options, script, tmp_path):
    argv = ["run", script(f"return scene({options})"), "--out", str(tmp_path / "o"), "--frames=1"]
    assert cli.main([*argv, "--quiet"]) == 0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = 1", "has no function build()"),
        ("build = 3", "has no function build()"),
        ("def build(", "line 1: "),
        ("import nothing_of_that_name", "line 1: the script raised ModuleNotFoundError: No module"),
        ("\n\nraise ValueError('one\\ntwo')", "line 3: the script raised ValueError: one two"),
        ("def build(a, *, b=1): pass", "parameter 'a' of build() must be a keyword with a default"),
        ("def build(a=1, /): pass", "parameter 'a' of build() must be a keyword with a default"),
    ],
)
def test_scripts(text, words, refused, tmp_path):
    path = tmp_path / "odd.py"
    path.write_text(text)
    assert words in refused("run", path)
    assert str(tmp_path) not in sys.path


@pytest.mark.parametrize(
    ("parameters", "setting", "words"),
    [
        ("x=True", "x=maybe", "x = 'maybe' must be true or false, such as x=true"),
        ("x: float | None = None", "x=much", "x = 'much' must be a number"),
        ("x: 'float' = 1", "x=inf", "x = inf must be finite"),
        ("x=(1, 2)", "x=3", "x cannot be given with --set (its default is (1, 2))"),
        ("x=0.5", "=0.5", "write NAME=VALUE"),
        ("**others", "x=1", "has no parameter 'x'"),
    ],
)
def test_settings(parameters, setting, words, refused, script):
    assert words in refused("run", script("return scene()", parameters), "--set", setting)


def test_output_folder(refused, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("x")
    assert "is a file: give another folder" in refused("run", "hemisphere", out=tmp_path / "file")
    assert "is a file" in refused("run", "hemisphere", out=tmp_path / "file" / "deeper")
    old = tmp_path / "old"
    old.mkdir()
    (old / "summary.json").write_text("{}")
    assert "holds summary.json of another run: give --overwrite" in refused(
        "run", "hemisphere", out=old
    )

    def forbidden(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("warpdrape.results.run_folder.tempfile.TemporaryFile", forbidden)
    assert "is not writable (Permission denied)" in refused("run", "hemisphere")


def test_python_gets_the_same_words():
    scene = hemisphere.build(**SMALL)
    with pytest.raises(wd.InputError, match="frames = 0 must be a whole number above zero"):
        scene.run(frames=0)
    with pytest.raises(wd.InputError, match="no device 'cuda:9' here"):
        scene.run(device="cuda:9")
    with pytest.raises(wd.InputError, match="thickness = nan must be finite"):
        wd.Fabric(name="f", areal_density=0.6, thickness=math.nan, tension=LinearTension(1.0, 1.0))
    with pytest.raises(wd.InputError, match="its mesh has no facets"):
        wd.Tool.from_mesh("t", trimesh.Trimesh())
