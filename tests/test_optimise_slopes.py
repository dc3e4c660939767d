"""Slopes at the start of an optimisation: derivatives, and those of jumps that are not trusted."""

import csv

import pytest
from optimise_checks import STUDY, MadeUp, bowl, write_formulas

from warpdrape.errors import InputError
from warpdrape.optimisation.book import Book
from warpdrape.optimisation.optimise_file import read_optimisation
from warpdrape.optimisation.runner import Runner
from warpdrape.optimisation.slopes import find_slopes, slopes_text, write_slopes
from warpdrape.studies.folder import StudyFolder

SMOOTH = STUDY.replace("runs = 24", "runs = 24\nstart = { x = 0.4, y = 0.98 }")


def test_slopes_are_the_derivatives_and_those_of_jumps_are_not_trusted(tmp_path):
    def formula(values):
        x, y = float(values["x"]), float(values["y"])
        return {"f": x**2 + 3.0 * y + 0.3 * (int(23 * x) % 2), "g": x**3 - 2.0 * y**2}

    text = SMOOTH + "[optimise.constraints]\ng = { most = 9 }\n"
    folder = StudyFolder(tmp_path / "o")
    folder.take()
    book = Book(read_optimisation(write_formulas(tmp_path, text)), folder)
    hands = MadeUp(folder, formula)
    slopes = {(s.parameter, s.measure): s for s in find_slopes(Runner(book, hands))}
    folder.release()
    assert len(hands.done) == 8
    assert slopes["x", "g"].narrow == pytest.approx(3 * 0.4**2, abs=1e-3)
    assert slopes["x", "g"].wide == pytest.approx(3 * 0.4**2 + 0.05**2)
    assert slopes["y", "g"].narrow == pytest.approx(-4.0 * 0.95)  # moved in from the end
    assert slopes["y", "f"].wide == pytest.approx(3.0)
    trusted = {key for key, slope in slopes.items() if slope.trusted}
    assert trusted == {("x", "g"), ("y", "g"), ("y", "f")}
    words = slopes_text(list(slopes.values()))
    assert words.count("not to be trusted") == 1
    with write_slopes(tmp_path, list(slopes.values())).open(encoding="utf-8") as file:
        assert [row["trusted"] for row in csv.DictReader(file)] == ["0", "1", "1", "1"]


def test_slopes_of_what_has_none(tmp_path):
    def slopes(text, name, formula=bowl):
        folder = StudyFolder(tmp_path / name)
        folder.take()
        book = Book(read_optimisation(write_formulas(tmp_path, text)), folder)
        found = find_slopes(Runner(book, MadeUp(folder, formula)))
        folder.release()
        return found

    with pytest.raises(InputError, match="outside of where is looked"):
        slopes(STUDY.replace("runs", "start = { x = 2 }\nruns"), "a")
    with pytest.raises(InputError, match="whole numbers or words"):
        slopes(STUDY.replace("range = [0, 1]", "values = [0.1, 0.9]"), "b")
    assert not any(s.trusted for s in slopes(STUDY, "c", lambda _: None))
