"""Every command of the tutorial runs, in its order, and comes out as the page says."""

import json
import re
import shlex
import shutil
from pathlib import Path

import pytest

from warpdrape import cli

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "tutorial.md").read_text("utf-8")
BLOCKS = re.findall(r"```(\w*)\n(.*?)```", PAGE, re.DOTALL)
COMMANDS = [
    words
    for kind, text in BLOCKS
    if kind == "sh"
    for words in (shlex.split(line, comments=True) for line in text.splitlines())
    if words[0] == "warpdrape"
]
SAID = [text for kind, text in BLOCKS if not kind]


def test_the_page_has_the_whole_way():
    steps = [words[1] for words in COMMANDS]
    assert steps == ["new", "check", "run", "judge", "report", "picture"] + ["export"] * 4


@pytest.fixture(scope="module")
def walked(tmp_path_factory):
    """The folder in which all commands ran, and what each said and returned."""
    pytest.importorskip("OCP.STEPControl")
    ezdxf = pytest.importorskip("ezdxf")
    folder = tmp_path_factory.mktemp("tutorial")
    for name in ("tray.step", "tray_blank.dxf"):
        shutil.copy(ROOT / "examples" / "tutorial" / name, folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        ended = [_said(words[1:]) for words in COMMANDS]
    return folder, ended, ezdxf


def _said(words):
    import io
    from contextlib import redirect_stderr, redirect_stdout

    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        status = cli.main(words)
    return status, out.getvalue(), err.getvalue()


def test_every_command_ends_as_the_page_says(walked):
    _, ended, _ = walked
    expected = [3 if words[1] == "judge" else 0 for words in COMMANDS]
    for words, status, (got, out, err) in zip(COMMANDS, expected, ended, strict=True):
        assert got == status, (words, out, err)


def test_what_new_and_judge_say_is_what_the_page_shows(walked):
    _, ended, _ = walked
    new, judged = SAID
    assert [line for line in new.splitlines() if line not in ended[0][1]] == []
    got, shown = (_numbers(text) for text in (ended[3][1], judged))
    assert got[0][:1] == shown[0][:1]
    for line, beside in zip(got[1:3], shown[1:3], strict=True):  # rounding differs by machine
        assert line[0] == pytest.approx(beside[0], abs=2.0)


def _numbers(text):
    lines = text.splitlines()
    return [[float(n) for n in re.findall(r"(?<![\w.])\d+\.?\d*", line)] for line in lines]


def test_check_told_the_steps_and_the_time_of_what_it_found(walked):
    folder, ended, _ = walked
    said = ended[1][1]
    for words in (
        "mould from tray.step, which is in millimetre",
        "smallest radius 5.9",
        "punch: touches ply_1" if "punch: touches ply_1" in said else "punch: in touch with ply_1",
        "1.50 times that",
        "steps of",
        "of memory",
        "Limits: wrinkle_amplitude 0.5 mm",
    ):
        assert words in said, words
    assert (folder / "tray_check.png").stat().st_size > 20_000


def test_the_run_is_one_to_trust(walked):
    folder, _, _ = walked
    summary = json.loads((folder / "runs/tray/summary.json").read_text("utf-8"))
    assert summary["status"] == "completed" and summary["quasi_static"]
    assert summary["energy_error"] < 0.02 and summary["max_penetration_m"] < 1e-4
    punch = next(tool for tool in summary["tools"] if tool["name"] == "punch")
    assert punch["displacement_m"] == pytest.approx(24.4e-3, abs=1e-4)
    assert summary["limits"]["shear_deg"] == 50.0


def test_pattern_and_decks_are_written(walked):
    folder, _, ezdxf = walked
    exports = folder / "runs" / "tray" / "export"
    assert {"pattern.dxf", "pattern.svg", "formed.inp", "formed.k"} == {
        file.name for file in exports.iterdir()
    }
    drawing = ezdxf.readfile(exports / "pattern.dxf")
    layers = {layer.dxf.name for layer in drawing.layers}
    assert {"CUT_ply_0", "CUT_ply_1"} <= layers
    assert (folder / "runs/tray/report.html").stat().st_size > 100_000


def test_a_mesh_twice_as_coarse_as_the_moulds_radius_comes_through_the_closing(walked, tmp_path):
    """Folds of 10 mm in a gap of 1.8 mm, which bulge against the punch's border from aside."""
    folder, _, _ = walked
    coarse = [f"--set={setting}" for setting in ("edge=10mm", "duration=15ms", "angles=45,0")]
    status, _, err = _said(
        ["run", str(folder / "tray.py"), *coarse, "--frames=4", f"--out={tmp_path / 'run'}"]
    )
    assert status == 0, err
    summary = json.loads((tmp_path / "run" / "summary.json").read_text("utf-8"))
    assert summary["energy_error"] < 0.01
