import csv
import json
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from pxr import Usd
from study_checks import write_study

import warpdrape
from warpdrape import cli
from warpdrape.command_line.command import UNFIT
from warpdrape.commands.scene_library import bundled_scenes, find_script
from warpdrape.commands.scene_parameters import read_parameters
from warpdrape.errors import InputError
from warpdrape.results.summary_text import summary_text
from warpdrape.simulation import Stepper

FRAME = """
base = "carbon_interlock"
[tests.frame]
kind = "picture_frame"
files = ["frame.csv"]
side = "100 mm"
"""
QUICK = ["--set", "cells=6", "--set", "duration=0.005", "--frames", "3", "--quiet"]
ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "examples"


def run(*argv) -> int:
    return cli.main([str(a) for a in argv])


def test_run_writes_a_folder_and_says_what_came_out(tmp_path, capsys):
    out = tmp_path / "press"
    assert run("run", "hemisphere", "--set", "angle_deg=45", "--out", out, *QUICK) == 0
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert summary["status"] == "completed"
    record = json.loads((out / "run.json").read_text(encoding="utf-8"))
    assert (record["parameters"]["cells"], record["parameters"]["angle_deg"]) == (6, 45.0)
    assert record["numerics"]["stabiliser"] is None and record["plies"][0]["stabiliser_n_m"]
    with open(out / "history.csv", encoding="utf-8") as file:
        assert len(list(csv.reader(file))) == 1 + 4
    said, complaints = capsys.readouterr()
    ply, punch = summary["plies"][0], summary["tools"][0]
    for words in (
        "Completed",
        "ply_0",
        f"{ply['max_shear_deg']:.1f}°",
        f"{ply['p95_shear_deg']:.1f}°",
        "draw-in",
        f"{1e3 * ply['draw_in_m']['bias']:.1f} mm",
        f"{punch['max_force_n']:.1f} N",
        "75.00 mm",
        "energy error",
        "quasi-static",
        "warning:",
        str(out),
        "scene.usdc",
    ):
        assert words in said
    assert complaints == ""


def test_progress_and_three_plies_with_the_paper_beside_them(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run("run", "three_ply_hemisphere", *QUICK[:-1]) == 0
    said, progress = capsys.readouterr()
    summary = json.loads((tmp_path / "runs/three_ply_hemisphere/summary.json").read_text())
    done = f"{1e3 * summary['simulated_s']:.1f}"
    assert f"100 % {done} of {done} ms" in progress and "\r" not in progress
    assert summary["reported"] == ["central_ply"]
    assert summary["central_ply"]["max_shear_deg"] == summary["plies"][1]["max_shear_deg"]
    largest = summary["plies"][1]["max_shear_deg"]
    assert f"central ply: name ply_1, max shear {largest:.1f}°, paper max shear 46.0°" in said
    assert "ply_0 on ply_1" in said
    assert run("picture", "runs/three_ply_hemisphere") == 0
    assert Path(capsys.readouterr().out.strip()) == Path("runs/three_ply_hemisphere/ply_1.png")


def test_overwrite(tmp_path, capsys):
    assert run("run", "hemisphere", "--out", tmp_path, *QUICK) == 0
    first = (tmp_path / "run.json").read_text()
    again = ["run", "hemisphere", "--set", "friction=0.1", "--out", tmp_path, *QUICK]
    assert run(*again) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert (tmp_path / "run.json").read_text() == first
    assert run(*again, "--overwrite") == 0
    assert json.loads((tmp_path / "run.json").read_text())["parameters"]["friction"] == 0.1


def test_interrupt_keeps_the_frames(tmp_path, capsys, monkeypatch):
    block, done = Stepper.block, []

    def interrupted(self):
        if self._state.step.numpy()[0] == 0:
            done.append(1)
        if len(done) > 2:
            raise KeyboardInterrupt
        block(self)

    monkeypatch.setattr(Stepper, "block", interrupted)
    assert run("run", "hemisphere", "--out", tmp_path, *QUICK) == 1
    assert capsys.readouterr().err == "warpdrape: error: interrupted by the user\n"
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert (summary["status"], summary["message"]) == ("failed", "interrupted by the user")
    record = json.loads((tmp_path / "run.json").read_text())
    assert summary["simulated_s"] == pytest.approx(2 / 3 * record["duration_s"])
    assert Usd.Stage.Open(str(tmp_path / "scene.usdc")).GetEndTimeCode() == 2.0
    assert len((tmp_path / "history.csv").read_text().splitlines()) == 1 + 3
    assert not list(tmp_path.glob(".*"))


@pytest.mark.parametrize("moment", ["simulation.Stepper", "recorder.measure"])
def test_interrupt_before_the_first_frame(moment, tmp_path, capsys, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"warpdrape.{moment}", interrupted)
    assert run("run", "hemisphere", "--out", tmp_path, *QUICK) == 1
    assert capsys.readouterr().err == "warpdrape: error: interrupted by the user\n"
    assert json.loads((tmp_path / "summary.json").read_text())["status"] == "failed"
    assert not list(tmp_path.glob(".*"))  # nothing unfinished is left


def test_a_fault_of_ours_is_one_line_and_keeps_the_frames(tmp_path, capsys, monkeypatch):
    def faulty(self):
        raise RuntimeError("two\nlines")

    monkeypatch.setattr(Stepper, "block", faulty)
    assert run("run", "hemisphere", "--out", tmp_path, *QUICK) == 1
    complaint = capsys.readouterr().err
    assert "RuntimeError in test_cli.py" in complaint and "two lines; please report it" in complaint
    assert len(complaint.splitlines()) == 1
    assert "RuntimeError" in json.loads((tmp_path / "summary.json").read_text())["message"]


def test_lists(capsys):
    assert run("scenes") == 0
    lines = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert lines == bundled_scenes()
    assert {"hemisphere", "three_ply_hemisphere"} <= set(lines)
    assert "press" not in lines
    assert run("fabrics") == 0
    fabrics = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert fabrics["carbon_interlock"].startswith("Carbon interlock weave")


@pytest.mark.parametrize("name", bundled_scenes())
def test_every_bundled_scene_says_its_parameters_with_units(name, capsys):
    assert run("scenes", name) == 0
    said = capsys.readouterr().out
    script = find_script(name)
    assert said.startswith(f"{name}: {script.title}")
    for parameter in script.parameters.values():
        assert parameter.kind is not None
        assert parameter.description
        assert f"  {parameter.name} " in said
        if parameter.kind is float:
            assert "[" in parameter.description, f"{name}: {parameter.name} has no unit"


def test_fabric_card_and_its_curves(tmp_path, capsys):
    assert run("fabrics", "carbon_interlock", "--plot", tmp_path / "card.png") == 0
    assert "second-hand" in capsys.readouterr().out
    assert (tmp_path / "card.png").read_bytes().startswith(b"\x89PNG")


def test_info(capsys):
    assert run("info") == 0
    said = capsys.readouterr().out
    for words in ("warpdrape ", "warp-lang ", "usd-core ", "cpu", "kernel cache"):
        assert words in said


def test_help_names_every_command(capsys):
    assert run("--help") == 0
    said = capsys.readouterr().out
    assert all(f"\n    {name} " in said for name in ("run", "scenes", "fabrics", "picture", "info"))
    assert run() == 0
    assert capsys.readouterr().out == said
    assert run("--version") == 0
    assert capsys.readouterr().out.startswith("warpdrape ")


def test_script_with_its_own_neighbour_and_report(tmp_path, capsys):
    (tmp_path / "blank.py").write_text("SIZE = 0.1\n")
    (tmp_path / "fall.py").write_text(SCRIPT)
    out = tmp_path / "out"
    script = [sys.executable, str(tmp_path / "fall.py"), "--set", "soft=no", "--set", "note=a=b"]
    folder = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    ended = subprocess.run(
        [*script, "--out", str(out), "--frames", "2", "--quiet"],
        capture_output=True,
        encoding="utf-8",
        env={**os.environ, "PYTHONPATH": os.pathsep.join(folder), "PYTHONIOENCODING": "utf-8"},
    )
    assert (ended.returncode, ended.stderr) == (0, "")  # nothing about a missing GPU either
    assert "fell: 4.905 mm" in ended.stdout
    assert "the scene's report" not in ended.stdout
    record = json.loads((out / "run.json").read_text(encoding="utf-8"))
    assert record["parameters"] == {"soft": False, "note": "a=b", "limit": None}
    assert run("scenes", tmp_path / "fall.py") == 0
    assert "soft   true  whether it is soft." in capsys.readouterr().out
    assert "blank" not in sys.modules or sys.modules["blank"].SIZE == 0.1


SCRIPT = '''"""A ply that falls."""

from blank import SIZE

from warpdrape import Ply
from warpdrape import Scene


def build(*, soft: bool = True, note: str = "", limit: float | None = None) -> Scene:
    """Build it.

    Args:
        soft: whether it is soft.
        note: what you like.
        limit: none, or one [m].
    """
    assert soft is False
    ply = Ply.rectangle("ply_0", "carbon_interlock", SIZE, cells=2, mesh="grid")
    return Scene(name="fall", plies=[ply], duration=0.0316227766,
                 report=lambda result: {"fell_m": -result.ply("ply_0").points[:, 2].mean()})


if __name__ == "__main__":
    from warpdrape.cli import run_script

    run_script(__file__)
'''


def test_a_report_that_fails_does_not_cost_the_result():
    from warpdrape import Ply, Scene

    ply = Ply.rectangle("ply_0", "carbon_interlock", 0.1, cells=2, mesh="grid")
    for report in (lambda r: 1 / 0, lambda r: {"angle_deg": float("nan")}):
        summary = Scene(name="fall", plies=[ply], duration=1e-3, report=report).run().summary
        assert (summary["status"], summary["reported"]) == ("completed", [])
        assert any("report failed" in warning for warning in summary["warnings"])
        assert "report failed" in summary_text(summary)


def test_public_names_are_all_there_and_come_late():
    for name in warpdrape.__all__:
        assert getattr(warpdrape, name) is not None
        assert name in dir(warpdrape)
    assert set(warpdrape._HOME) == set(warpdrape.__all__) - {"units"}
    with pytest.raises(AttributeError, match="has no attribute 'Plie'"):
        warpdrape.Plie  # noqa: B018
    heavy = "{'warp', 'numpy', 'pxr', 'trimesh', 'scipy', 'matplotlib'}"
    code = f"import sys, warpdrape.cli as c; c.main(['--help']); print({heavy} & set(sys.modules))"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert ended.stdout.splitlines()[-1] == "set()"


def test_building_a_scene_brings_no_command_line_with_it():
    modules = ", ".join(bundled_scenes())
    seen = "print('warpdrape.cli' in sys.modules)"
    code = f"import sys; from warpdrape.scenes import {modules}; {seen}"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert ended.stdout.split() == ["False"], ended.stderr


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("travel", "75mm", 0.075),
        ("travel", "7.5 cm", 0.075),
        ("travel", "0.075", 0.075),
        ("duration", "80ms", 0.08),
        ("holder_force", "0.2kN", 200.0),
        ("angle_deg", "45°", 45.0),
        ("angle_deg", "-1rad", -57.29577951308232),
        ("friction", "20%", 0.2),
        ("contact_share", "4e-2", 0.04),
    ],
)
def test_values_may_have_their_unit(name, text, value):
    settings = find_script("hemisphere").read_settings([f"{name}={text}"])
    assert settings[name] == pytest.approx(value, rel=1e-12)


def build_with_lists(
    *,
    gaps: tuple[float, ...] = (0.001, 0.002),
    counts: list[int] = [3, 4],  # noqa: B006
    names: Sequence[str] | None = None,
    pitch_um: int = 5,
    layers: int = 3,
):
    """Build nothing.

    Args:
        gaps: between things [m].
        counts: of things.
        names: of things.
        pitch_um: of something [m].
        layers: of things.
    """


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("gaps", "10mm,2 cm,1m", (0.01, 0.02, 1.0)),
        ("gaps", "(0.1, 2e-1)", (0.1, 0.2)),
        ("gaps", "5mm", (0.005,)),
        ("counts", "1,2,3", (1, 2, 3)),
        ("names", "a, b", ("a", "b")),
        ("names", "none", None),
        ("pitch_um", "2000mm", 2),
        ("gaps", "10mm,20", "give every number its unit, or none"),
        ("gaps", "1mm,far", "must be a list of numbers with commas, such as gaps=0.001,0.002"),
        ("gaps", "1kg,2kg", "units it may be given with: m, cm"),
        ("counts", "1,2.5", "counts = '2.5' must be"),
        ("pitch_um", "2500mm", "must be a whole number"),
        ("layers", "3mm", "it has no unit and is given as a number alone: layers=3"),
    ],
)
def test_lists_and_whole_numbers_may_have_their_unit_or_are_refused(name, text, value):
    parameter = read_parameters(build_with_lists)[name]
    if isinstance(value, str):
        with pytest.raises(InputError, match=re.escape(value)):
            parameter.read(text)
        return
    read = parameter.read(text)
    assert read == (value if value is None or isinstance(value, int) else pytest.approx(value))
    assert type(read) is type(value)


COMMANDS = {
    "new": ["part", "--angles", "0", "--blank", "300x300mm"],
    "check": ["hemisphere", "--set", "cells=4", "--out", "scene.png"],
    "unit_cell": ["EXAMPLES/unit_cell/glass_plain.toml", "--dry"],
    "optimise": ["EXAMPLES/optimise_hemisphere.toml", "--plan"],
    "scenes": ["hemisphere"],
    "fabrics": ["carbon_interlock", "--plot", "card.png"],
    "info": [],
    "picture": ["RUN", "--out", "ply.png"],
    "export": ["RUN", "--to", "csv", "--out", "table.csv", "--overwrite"],
    "judge": ["RUN", "--out", "marked.png"],
    "report": ["RUN", "--out", "report.html"],
    "calibrate": ["tests.toml", "--dry"],
    "study": ["tiny.toml", "--plan"],
    "verify": ["--quick"],
}
COMPUTING = {"run", "resume", "compare"}
"""Commands whose figures are shown however quiet they are; tests of their own."""


def test_every_command_is_tried():
    assert {*COMMANDS, *COMPUTING} == {*cli.COMMANDS}


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_can_be_quiet(name, pressed, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        "warpdrape.verification.verify.main", lambda *_: print("a table") or cli.DONE
    )
    (tmp_path / "frame.csv").write_text("angle [deg];force [N]\n0;0\n10;1\n20;3\n30;6\n40;9\n")
    (tmp_path / "tests.toml").write_text(FRAME)
    write_study(tmp_path)
    places = {"RUN": str(pressed[1]), "EXAMPLES": str(ROOT / "examples")}
    command = [name, *COMMANDS[name]]
    for place, path in places.items():
        command = [word.replace(place, path) for word in command]
    status = run(*command)
    assert status == cli.DONE or (name == "judge" and status == UNFIT)
    assert capsys.readouterr().out
    (tmp_path / "part.py").unlink(missing_ok=True)
    assert run(*command, "-q") == status
    assert capsys.readouterr() == ("", "")


def test_a_quiet_command_still_says_what_is_wrong(capsys):
    assert run("scenes", "hemispere", "--quiet") == 2
    said, complaints = capsys.readouterr()
    assert said == "" and "did you mean 'hemisphere'" in complaints
