"""Shear laws found again from frames, bias strips and loops; bands whose coverage is counted."""

import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from calibration_checks import pulled
from scipy.optimize import minimize
from scipy.stats import t as student

from warpdrape import cli
from warpdrape.calibration.bands import Band, bootstrap
from warpdrape.calibration.bounded import bounded_least_squares
from warpdrape.calibration.locking import locking_angle
from warpdrape.calibration.monotone import LeastSquares, RisingBasis
from warpdrape.calibration.normalisation import bias_rows, couple_by_steps, frame_rows, loop_rows
from warpdrape.calibration.polynomial import fit_polynomial, powers
from warpdrape.calibration.preparation import in_bins, loading_curve
from warpdrape.calibration.shear import ShearSpecimen, alone, disagreements, fit_shear
from warpdrape.coupons.closed_forms import (
    bias_angle,
    bias_force,
    bias_travel,
    frame_force,
)
from warpdrape.materials.fabric_library import load_fabric

EXAMPLES = Path(__file__).parents[1] / "examples"
CLOTH = load_fabric("carbon_interlock")
END = math.radians(55.0)


def couple(angle):
    """C [N/m] of the library's carbon interlock, an S-shaped curve."""
    return CLOTH.shear.couple(angle) / CLOTH.cell_area


def shear_specimen(kind, angle, force, values, name="s"):
    rows = {"picture_frame": frame_rows, "bias_extension": bias_rows}[kind]
    return ShearSpecimen(kind, kind, name, 1.0, angle, *rows(values, angle, force))


def frames(factors, angle, noise=0.0, rng=None):
    values, found = {"side": 0.2, "sample": 0.16}, []
    for k, factor in enumerate(factors):
        force = factor * frame_force(CLOTH, 0.2, angle, 0.16)
        if noise:
            at, force = in_bins(angle, force * (1 + noise * rng.standard_normal(len(angle))))
        else:
            at = angle
        found.append(shear_specimen("picture_frame", at, force, values, str(k)))
    return found


def strips(factors, angle, noise=0.0, rng=None, width=0.115, height=0.23):
    values, found = {"width": width, "height": height}, []
    for k, factor in enumerate(factors):
        force = factor * bias_force(CLOTH, width, height, angle)
        if noise:
            at, force = in_bins(angle, force * (1 + noise * rng.standard_normal(len(angle))))
        else:
            at = angle
        found.append(shear_specimen("bias_extension", at, force, values, str(k)))
    return found


@pytest.mark.parametrize("make", [frames, strips])
def test_shear_without_noise_is_the_law(make):
    angle = np.linspace(0.0, END, 200)
    fit = fit_shear(make([1.0, 1.0], angle), draws=20)
    at = np.radians(np.arange(3.0, 55.0, 1.0))
    # 0.4 %: twelve intervals of a cubic spline under a curve of the fifth power
    np.testing.assert_allclose(fit.couple(at), couple(at), rtol=4e-3)
    assert fit.angles[0] == 0.0 and fit.band.value[0] == 0.0
    assert fit.angles[-1] == pytest.approx(END)


def test_published_steps_give_the_law_too():
    angle = np.linspace(0.0, END, 400)
    (one,) = strips([1.0], angle)
    np.testing.assert_allclose(one.couple[20:], couple(angle[20:]), rtol=5e-3)
    known = couple_by_steps(
        angle, *frame_rows({"side": 0.2}, angle, frame_force(CLOTH, 0.2, angle))
    )
    np.testing.assert_allclose(known, couple(angle), rtol=1e-12)


def test_one_size_of_strip_predicts_another():
    """115 × 230 mm fitted, 150 × 450 mm predicted, within what the fit leaves (0.5 %)."""
    angle = np.linspace(0.0, END, 200)
    fit = fit_shear(strips([1.0, 1.0], angle), draws=20)
    width, height = 0.150, 0.450
    at = np.radians(np.arange(5.0, 55.0, 2.0))
    opening = (height / width - 1) * (np.cos(at / 2) - np.sin(at / 2))
    said = ((2 * height - 3 * width) * fit.couple(at) + width * fit.couple(at / 2)) / opening
    np.testing.assert_allclose(said, bias_force(CLOTH, width, height, at), rtol=5e-3)


def test_kawabata_shear_is_the_work_of_force_and_load():
    """∫(f cos γ − T sin γ)dγ is the work of both over their ways."""
    angle = np.linspace(0.0, 0.14, 4001)
    f, pulled = 3.0 * angle + 5.0 * angle**2, 10.0
    said, share = loop_rows({"tension": pulled}, angle, f)
    work = np.trapezoid(f, np.sin(angle)) + pulled * (np.cos(angle[-1]) - 1.0)
    assert not share.any()
    assert np.trapezoid(said, angle) == pytest.approx(work, rel=1e-6)


def coverage(draws, seed, makers):
    rng, hits = np.random.default_rng(seed), []
    angle = np.radians(np.linspace(0.5, 55.0, 300))
    for _ in range(draws):
        found = []
        for make in makers:
            found += make(np.exp(0.05 * rng.standard_normal(5)), angle, 0.05, rng)
        fit = fit_shear([alone(s) for s in found] if len(makers) > 1 else found, draws=120)
        at = fit.angles >= math.radians(5.0)
        true = couple(fit.angles[at])
        hits.append((fit.band.low[at] <= true) & (true <= fit.band.high[at]))
    return np.mean(hits)


def test_coverage_of_few_draws():
    """20 draws: a share of 0.9 comes out within 0.7 and 1 in 99 of 100 such counts."""
    assert 0.7 <= coverage(20, 3, [frames]) <= 1.0


@pytest.mark.slow
@pytest.mark.parametrize("makers", [[frames], [strips], [frames, strips]])
def test_coverage_of_bands(makers):
    """5 specimens, 5 % between them and 5 % on each point; 200 draws."""
    assert 0.80 <= coverage(200, 4, makers) <= 0.97


def test_band_of_a_mean_is_students():
    values = np.random.default_rng(1).normal(10.0, 1.0, 6)
    band = bootstrap([6], lambda c: c @ values / c.sum(), draws=4000)
    half = student.ppf(0.95, 5) * values.std(ddof=1) / math.sqrt(6)
    assert band.value[0] == pytest.approx(values.mean())
    # 4000 draws tell a standard error within 3 %
    assert 0.5 * (band.high[0] - band.low[0]) == pytest.approx(half, rel=0.03)


def test_single_specimens_are_drawn_together():
    """Six tests of one specimen have the band of one test of six; a lone one joins another."""
    values = np.random.default_rng(1).normal(10.0, 1.0, 6)

    def mean(counts):
        return counts @ values / counts.sum()

    one, six = bootstrap([6], mean), bootstrap([1] * 6, mean)
    assert (one.low, one.high) == (six.low, six.high) and six.specimens == 6
    assert bootstrap([5, 1], mean).specimens == 6
    assert not bootstrap([5, 1], mean, pool=False).told


def test_weights_of_tests():
    """Kinds that disagree: 0.9 and 1.2 times the law, weighing 1 and 2, make 1.1 times the law."""
    angle = np.linspace(0.0, END, 150)
    light = frames([0.9] * 3, angle)
    heavy = [alone(replace(s, weight=2.0)) for s in strips([1.2] * 3, angle)]
    at = np.radians(np.arange(10.0, 54.0, 4.0))
    ratio = fit_shear(light + heavy, draws=20).couple(at) / couple(at)
    np.testing.assert_allclose(ratio, 1.1, atol=0.01)
    even = fit_shear(light + [replace(s, weight=1.0) for s in heavy], draws=20).couple(at)
    assert (even < 0.985 * ratio * couple(at)).all()


def test_one_specimen_has_no_band():
    band = bootstrap([1], lambda c: np.array([2.0]))
    assert not band.told and band.low[0] == band.high[0] == 2.0
    assert "one specimen: no band" in band.words("N")


def test_offset_is_seen_and_taken_off():
    angle = np.linspace(0.0, END, 200)
    values = {"side": 0.2}
    force = frame_force(CLOTH, 0.2, angle)
    opening = np.cos(angle / 2) - np.sin(angle / 2)
    rubbed = force + 4.0 * 0.2 * math.sqrt(2.0) / opening  # 4 N/m at all angles
    found = [shear_specimen("picture_frame", angle, rubbed, values, str(k)) for k in range(3)]
    fit = fit_shear(found, keep_offset=False, draws=20)
    assert fit.offset.value[0] == pytest.approx(4.0, rel=0.02)
    at = np.radians(np.arange(5.0, 55.0, 5.0))
    np.testing.assert_allclose(fit.couple(at), couple(at), rtol=0.01)
    kept = fit_shear(found, keep_offset=True, draws=20)
    # its step at 0° rings in a cubic spline for some intervals of 4.6°
    np.testing.assert_allclose(kept.couple(at[4:]), couple(at[4:]) + 4.0, rtol=0.01)
    assert kept.band.value[0] == 0.0


def test_disagreement_of_two_kinds_is_reported():
    angle = np.linspace(0.0, END, 120)
    near = [0.99, 1.0, 1.01]
    fits = {
        "picture_frame": fit_shear(frames(near, angle), draws=40),
        "bias_extension": fit_shear(strips([1.3 * f for f in near], angle), draws=40),
    }
    (found,) = disagreements(fits)
    np.testing.assert_allclose(found.ratio, 1.3, rtol=0.01)
    assert found.apart.all()
    assert "their bands do not meet" in found.words()
    fits["bias_extension"] = fit_shear(strips(near, angle), draws=40)
    assert not disagreements(fits)[0].apart.any()


def test_locking_angle_is_where_the_lines_meet():
    angle = np.linspace(0.0, 1.0, 181)
    bent = 0.5 * angle + np.maximum(angle - 0.7, 0.0) * 9.5
    at, steeper = locking_angle(angle, bent)
    assert at == pytest.approx(0.7, abs=1e-9)
    assert steeper == pytest.approx(20.0)
    assert locking_angle(angle, angle)[1] == pytest.approx(1.0)
    # steep at first, as where friction sets in: the flat part is the one after
    steep_first = 5.0 * np.minimum(angle, 0.2) + bent
    assert locking_angle(angle, steep_first)[0] == pytest.approx(0.7, abs=1e-9)


def test_polynomial_is_the_law_and_never_falls():
    angle = np.linspace(0.0, END, 200)
    fit = fit_shear(frames([1.0, 1.0], angle), draws=20)
    band, off = fit_polynomial(fit, draws=20)
    at = np.radians(np.arange(3.0, 56.0))
    np.testing.assert_allclose(powers(at) @ band.value, couple(at), rtol=2e-3)
    assert off < 4e-3
    # a curve that falls: the polynomial does not, up to 80°
    values = {"side": 0.2}
    falling = np.where(angle < 0.5, angle, 1.0 - angle) * 20.0
    forced = [shear_specimen("picture_frame", angle, falling, values) for _ in range(2)]
    band, _ = fit_polynomial(fit_shear(forced, draws=20), draws=20)
    wide = np.radians(np.linspace(0.0, 80.0, 300))
    rising = powers(wide) @ band.value
    assert (np.diff(rising) > 0.0).all() and rising[5] > 0.0


def test_rising_curves_rise_whatever_the_data():
    rng = np.random.default_rng(2)
    basis = RisingBasis(1.0)
    at = np.linspace(0.0, 1.0, 300)
    rows, fine = basis.rows(at), basis.rows(np.linspace(0.0, 1.0, 2000))
    assert np.abs(rows[0]).max() == 0.0
    for _ in range(5):
        noise = rng.standard_normal(300).cumsum()
        coefficients = LeastSquares.of([(rows, noise, np.ones(300))]).fit(np.ones(1))
        assert (np.diff(fine @ coefficients) >= -1e-12).all()


def test_bounded_least_squares_is_another_optimisers():
    """scipy's SLSQP from the unbounded minimum; bounds that hold some variables and not others."""
    rng = np.random.default_rng(6)
    for _ in range(5):
        rows = rng.standard_normal((12, 5))
        product, side = rows.T @ rows, rng.standard_normal(5)
        bounds, least = rng.standard_normal((8, 5)), rng.uniform(-0.5, 0.1, 8)
        exact = minimize(
            lambda c, p=product, s=side: 0.5 * c @ p @ c - s @ c,
            np.linalg.solve(product, side),
            constraints={"type": "ineq", "fun": lambda c, b=bounds, g=least: b @ c - g},
            method="SLSQP",
            options={"ftol": 1e-14, "maxiter": 500},
        )
        found = bounded_least_squares(product, side, bounds, least)
        assert exact.success and (bounds @ found - least).min() > -1e-9
        assert (bounds @ np.linalg.solve(product, side) < least).any()
        np.testing.assert_allclose(found, exact.x, atol=1e-5)


def test_words_of_a_band():
    band = Band(np.array([0.5]), np.array([0.4]), np.array([0.6]), 5, True)
    assert band.words("kN", 10.0) == "5 kN (90% band 4 to 6)"


def test_bias_travel_is_that_of_the_closed_form():
    """The whole way from a raw travel: sizes, angle, couple."""
    angle = np.radians(np.linspace(0.0, 45.0, 300))
    values = {"width": 0.1, "height": 0.25}
    columns = {
        "travel": bias_travel(0.1, 0.25, angle),
        "force": bias_force(CLOTH, 0.1, 0.25, angle),
    }
    test = pulled("bias_extension", columns, values=values)
    curve = loading_curve(test, test.specimens[0])
    said, share = bias_rows(values, curve.at, curve.force)
    exact = couple(curve.at) + share * couple(curve.at / 2)
    np.testing.assert_allclose(said[4:], exact[4:], rtol=1e-3)


def published(size):
    """Angles [rad] and forces [N] of a published bias extension, width and height in mm."""
    lines = (EXAMPLES / "unit_cell" / "published_bias.csv").read_text("utf-8").splitlines()
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    own = [row for row in rows if (row["width_mm"], row["height_mm"]) == size]
    travel, force = (
        np.array([float(row[name]) for row in own]) for name in ("travel_mm", "force_n")
    )
    width, height = (1e-3 * float(side) for side in size)
    return bias_angle(width, height, 1e-3 * travel), force


def test_one_published_strip_predicts_the_other_up_to_35_degrees():
    """Two tests of one weave; docs/calibration.md has what is beyond."""
    angle, force = published(("115", "230"))
    values = {"width": 0.115, "height": 0.23}
    fit = fit_shear([shear_specimen("bias_extension", angle[1:], force[1:], values)], draws=2)
    angle, force = published(("150", "450"))
    couples = [np.interp(g, fit.angles, fit.band.value) for g in (angle, angle / 2)]
    working = 2.0 * (np.cos(angle / 2) - np.sin(angle / 2))  # (H/W − 1)
    predicted = ((0.90 - 0.45) * couples[0] + 0.15 * couples[1]) / working
    off = predicted / force - 1.0
    within = (angle > math.radians(5.0)) & (angle < math.radians(36.0))
    assert within.sum() == 9 and np.abs(off[within]).max() < 0.17
    assert -0.35 < off[-1] < -0.25  # 45°: the larger strip has stiffened


def test_the_glass_weave_of_the_library_has_its_shear_from_the_published_strips(tmp_path):
    """By the command that its card names; the raw tables are the published points."""
    tests, out = EXAMPLES / "calibration" / "glass_pp_plain.toml", tmp_path / "card.toml"
    options = ["--no-coupons", "--draws", "20", "--quiet"]
    assert cli.main(["calibrate", str(tests), "--out", str(out), *options]) == 0
    made, kept = load_fabric(out), load_fabric("glass_pp_plain")
    at = np.radians([5.0, 10.0, 20.0, 30.0, 40.0, 45.0])
    card, fitted = (np.interp(at, c.shear.angles, c.shear.couples) for c in (kept, made))
    assert card == pytest.approx(fitted, rel=0.02)  # the card is rounded
    assert made.areal_density == kept.areal_density and made.cell_area == kept.cell_area
    for size in (("115", "230"), ("150", "450")):
        raw = EXAMPLES / "calibration" / "published" / f"glass_plain_{'_'.join(size)}.csv"
        travel, force = np.loadtxt(raw, delimiter=",", skiprows=2).T
        width, height = (1e-3 * float(side) for side in size)
        angle, known = published(size)
        assert bias_angle(width, height, 1e-3 * travel) == pytest.approx(angle)
        assert force == pytest.approx(known)
