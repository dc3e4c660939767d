"""The verification cases, quick by default and in full when slow ones are asked for."""

import json
import math

import pytest

from warpdrape import cli
from warpdrape.verification import verify
from warpdrape.verification.case import absolute, relative
from warpdrape.verification.hypoelastic import rotation
from warpdrape.verification.led_sheet import LedSheet


def test_quick_verification_passes_and_leaves_its_table(tmp_path, capsys):
    assert verify.main(True, tmp_path) == 0
    printed = capsys.readouterr().out
    record = json.loads((tmp_path / verify.RECORD).read_text("utf-8"))
    assert len(record) > 20 and all(entry["passed"] for entry in record)
    assert all(entry["case"] in printed for entry in record)
    table = (tmp_path / verify.TABLE).read_text("utf-8").splitlines()
    assert len(table) == len(record) + 2
    assert (tmp_path / verify.FIGURE).stat().st_size > 1000


@pytest.mark.slow
def test_full_verification_passes(tmp_path):
    assert verify.main(False, tmp_path) == 0


def test_a_limit_of_zero_has_its_bar(tmp_path, monkeypatch):
    """As of a rate that must be at least so much."""
    cases = [absolute("reached", 1.5, 1.5, 0.0), absolute("missed", 1.4, 1.5, 0.0)]
    monkeypatch.setattr(verify, "_groups", lambda quick, folder: iter([cases]))
    assert verify.main(False, tmp_path) == 1
    assert (tmp_path / verify.FIGURE).stat().st_size > 1000


def test_a_case_outside_its_limit_fails_the_command(tmp_path, monkeypatch, capsys):
    bad = [absolute("fine", 1.0, 1.0, 0.1), relative("bad", 1.2, 1.0, 0.1, "N")]
    monkeypatch.setattr(verify, "_groups", lambda quick, folder: iter([bad]))
    assert cli.main(["verify", "--quick", "--out", str(tmp_path / "a" / "b")]) == 1
    assert "FAILED" in capsys.readouterr().out


def test_a_known_shortfall_is_no_pass_and_must_not_get_worse(tmp_path, monkeypatch, capsys):
    short = absolute("short", 2.0, 0.0, 1.5, "°", known=2.1)
    assert not short.passed and short.verdict == "SHORT"
    assert absolute("worse", 2.2, 0.0, 1.5, "°", known=2.1).verdict == "FAILED"
    assert relative("reached", 1.0, 1.0, 0.1, known=0.2).verdict == "ok"
    monkeypatch.setattr(verify, "_groups", lambda quick, folder: iter([[short]]))
    assert verify.main(True, tmp_path) == 0
    printed = capsys.readouterr().out
    assert "1.5° " in printed.replace(" °", "°") and "1 SHORT of theirs" in printed
    record = json.loads((tmp_path / verify.RECORD).read_text("utf-8"))
    assert record[0]["passed"] is False and record[0]["verdict"] == "SHORT"


def test_a_case_that_is_not_a_number_fails():
    assert not absolute("nan", math.nan, 1.0, 0.1).passed
    assert absolute("edge", 1.1, 1.0, 0.1 + 1e-12).passed


def test_stress_that_is_no_number_is_no_largest_change(monkeypatch):
    """Python's max keeps what it has beside NaN, and the case could not fail by it."""
    lost = LedSheet.shown
    monkeypatch.setattr(LedSheet, "shown", lambda led: lost(led)._replace(couple=math.nan))
    assert not rotation().passed


def test_a_folder_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    assert cli.main(["verify", "--out", str(tmp_path / "file")]) == 2
