"""From a file of tests to a fabric's card, start to end."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from warpdrape.calibration.bands import DRAWS
from warpdrape.calibration.card_file import card_place, fabric_of, write_card
from warpdrape.calibration.card_tables import card_tables, source_of
from warpdrape.calibration.coupons import CouponRun, run_coupons
from warpdrape.calibration.fits import Fits, fit_all
from warpdrape.calibration.law_text import law_lines
from warpdrape.calibration.pictures import draw_tests
from warpdrape.calibration.predictions import Prediction, predictions
from warpdrape.calibration.report import (
    residual_rows,
    residual_text,
    understood,
    write_residuals,
)
from warpdrape.calibration.tests_file import Plan, read_plan
from warpdrape.errors import InputError
from warpdrape.materials.card_text import card_text
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.friction import TABLES
from warpdrape.results.run_folder import write_whole

REPORT, RESIDUALS = "report.txt", "residuals.csv"
_PLAIN = re.compile(r"[A-Za-z0-9_\-]+")


@dataclass(frozen=True, eq=False)
class Calibration:
    """What came out.

    Attributes:
        plan: the tests.
        fits: of all laws.
        text: of the card.
        fabric: as the card is read back.
        predictions: of every specimen by the card.
        coupons: simulated.
        rows: of the table of residuals.
    """

    plan: Plan
    fits: Fits
    text: str
    fabric: Fabric
    predictions: tuple[Prediction, ...]
    coupons: tuple[CouponRun, ...]
    rows: tuple[dict, ...]

    def report(self) -> str:
        """Laws with bands, residuals, and what went wrong, in words."""
        parts = ["\n".join(law_lines(self.fits))]
        parts.append(
            "errors of the card, and of its coupons, over each specimen's largest value\n"
            + residual_text(self.rows)
        )
        wrong = [f"coupon of {c.test} failed: {c.wrong}" for c in self.coupons if c.wrong]
        return "\n\n".join(parts + (["\n".join(wrong)] if wrong else []))


def calibrate(
    plan: Plan,
    *,
    draws: int = DRAWS,
    coupons: bool = True,
    say: Callable[[str], None] = lambda _: None,
) -> Calibration:
    """Fit a card to tests, and lay it and its coupons over them.

    Args:
        plan: the tests; see `read_plan`.
        draws: of the bootstrap.
        coupons: run them.
        say: takes lines of progress.

    Raises:
        InputError: a test cannot be used.
    """
    say("fitting …")
    fits = fit_all(plan, draws)
    tables = {**plan.fabric, **card_tables(plan, fits)}
    first = (
        f"Made by warpdrape calibrate from {Path(plan.file).name}"
        + (f" and the card {plan.base}" if plan.base else "")
        + ".\nStatus of a value: measured, second-hand, inferred, assumed."
    )
    text = card_text(tables, first)
    fabric = fabric_of(text, plan.file)
    found = predictions(plan, fits, fabric)
    runs = run_coupons(plan, fits, fabric, say) if coupons else []
    rows = residual_rows(found, runs)
    return Calibration(plan, fits, text, fabric, tuple(found), tuple(runs), tuple(rows))


def run_calibration(
    tests: str | os.PathLike[str],
    out: str | os.PathLike[str] | None,
    *,
    dry: bool = False,
    coupons: bool = True,
    draws: int = DRAWS,
    overwrite: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> str:
    """What the command does; returns what it prints.

    Args:
        tests: the file of tests.
        out: the card to write; may be left out of a dry run.
        dry: say what was understood, and stop.
        coupons: run them.
        draws: of the bootstrap, 20 or more.
        overwrite: replace the card.
        say: takes lines of progress.

    Raises:
        InputError: a test cannot be used, or the card cannot be written.
    """
    if draws < 20:
        raise InputError(f"--draws {draws} is too few for a band: give 20 or more")
    path = None if dry else card_place(out, overwrite)
    plan = read_plan(tests)
    _check_names(plan)
    if path is None:
        return understood(plan)
    found = calibrate(plan, draws=draws, coupons=coupons, say=say)
    folder = path.with_name(f"{path.stem}_calibration")
    files = _write(found, path, folder)
    return f"{found.report()}\n\n{files}"


def _check_names(plan: Plan) -> None:
    """Refuse names of tests that are no names of files."""
    for test in plan.tests:
        if not _PLAIN.fullmatch(test.name):
            raise InputError(
                f"{plan.file}: tests.{test.name}: name it with letters, digits, - and _ only: its "
                "picture has that name"
            )


def _write(found: Calibration, path: Path, folder: Path) -> str:
    """Write everything; the card last, so that it is never there without its report."""
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder} cannot be made ({error.strerror}): move it away") from error
    _remove_earlier(folder)
    pictures = draw_tests(found.plan, found.fits, found.predictions, found.coupons, folder)
    write_residuals(folder / RESIDUALS, found.rows)
    report = understood(found.plan) + "\n\n" + found.report() + "\n"
    write_whole(folder / REPORT, lambda p: p.write_text(report, encoding="utf-8", newline="\n"))
    frictions = _write_friction(found, folder)
    write_card(path, found.text)
    lines = [f"Card in {path}: warpdrape fabrics {path}", f"Beside it in {folder}"]
    lines.append(f"  {REPORT}, {RESIDUALS}, pictures: {', '.join(p.name for p in pictures)}")
    lines += [f"  {name}: warpdrape.load_friction reads it" for name in frictions]
    return "\n".join(lines)


def _remove_earlier(folder: Path) -> None:
    """Remove pictures and laws of the calibration before, whose tests may have been others."""
    try:
        with (folder / RESIDUALS).open(encoding="utf-8", newline="") as file:
            tests = {row.get("test") or "" for row in csv.DictReader(file)}
    except (OSError, ValueError, csv.Error):
        tests = set()
    old = [folder / f"{test}.png" for test in tests if _PLAIN.fullmatch(test)]
    old += [*folder.glob("friction_*.png"), *folder.glob("friction_*.toml")]
    try:
        for path in old:
            path.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"{folder} cannot be cleared ({error.strerror}): move it away") from error


def _write_friction(found: Calibration, folder: Path) -> list[str]:
    """Laws of friction, which belong to an interface and not to a card."""
    names = []
    for face, fit in found.fits.friction.items():
        tests = [t for t in found.plan.tests if t.values.get("against") == face]
        law = fit.law(source_of(tests))
        tables: dict[str, object] = {
            "coefficient": float(f"{law.coefficient:.5g}"),
            "source": law.source,
        }
        for table in TABLES:
            pairs = getattr(law, table)
            if pairs:
                tables[table] = [[float(f"{v:.5g}") for v in pair] for pair in pairs]
        name = f"friction_{face}.toml"
        text = card_text(tables, "Pressure in Pa, speed in m/s, angle in degrees.")
        write_card(folder / name, text)
        names.append(name)
    return names
