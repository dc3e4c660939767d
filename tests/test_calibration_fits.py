"""Fits of laws to tests whose laws are known, and bands whose coverage is counted."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize
from scipy.stats import t as student

from warpdrape.calibration.bands import Band, bootstrap
from warpdrape.calibration.bending import fit_cantilever, fit_loops
from warpdrape.calibration.biaxial_table import fit_table
from warpdrape.calibration.bounded import bounded_least_squares
from warpdrape.calibration.compaction import fit_compaction, pressed
from warpdrape.calibration.friction import Reading, fit_friction, readings
from warpdrape.calibration.hysteresis import first_loading, friction_history, loop_width
from warpdrape.calibration.locking import locking_angle
from warpdrape.calibration.monotone import LeastSquares, RisingBasis
from warpdrape.calibration.normalisation import bias_rows, couple_by_steps, frame_rows, loop_rows
from warpdrape.calibration.polynomial import fit_polynomial, powers
from warpdrape.calibration.predictions import Prediction
from warpdrape.calibration.preparation import in_bins, loading_curve
from warpdrape.calibration.raw_table import Specimen
from warpdrape.calibration.shear import ShearSpecimen, alone, disagreements, fit_shear
from warpdrape.calibration.tension import (
    BiaxialPoints,
    YarnCurve,
    crimp_tensions_of,
    fit_crimp,
    fit_failure,
    fit_linear,
    free_strip,
)
from warpdrape.calibration.tests_file import Test
from warpdrape.coupons.closed_forms import (
    bias_force,
    bias_travel,
    crimp_tensions,
    flexural_length,
    frame_force,
    frame_travel,
)
from warpdrape.errors import InputError
from warpdrape.materials.fabric_library import load_fabric
from warpdrape.materials.laws import CrimpInterchange

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


def pulled(kind, columns, **options):
    values = options.pop("values")
    specimen = Specimen("s", "s.csv", {k: np.asarray(v, float) for k, v in columns.items()})
    return Test("t", kind, values, (specimen,), **options)


def test_machine_slack_and_preload_are_undone():
    angle = np.radians(np.linspace(0.0, 50.0, 400))
    travel, force = frame_travel(0.2, angle), frame_force(CLOTH, 0.2, angle)
    give, slack, tare = 2e-5, 3e-3, 1.5
    recorded = travel + give * force + slack
    values = {"side": 0.2, "compliance": give, "slack": slack, "tare": tare}
    test = pulled("picture_frame", {"travel": recorded, "force": force + tare}, values=values)
    curve = loading_curve(test, test.specimens[0])
    # bins of 0.6° under a curved line
    np.testing.assert_allclose(curve.force[3:], frame_force(CLOTH, 0.2, curve.at[3:]), rtol=2e-3)
    preload = float(np.interp(math.radians(5.0), angle, force))
    values = {"side": 0.2, "preload": preload}
    test = pulled("picture_frame", {"travel": travel + 0.01, "force": force}, values=values)
    curve = loading_curve(test, test.specimens[0])
    assert curve.raw_force[0] == pytest.approx(preload, rel=0.03)
    assert curve.raw_at[0] < math.radians(0.2)


def test_toe_empty_machine_sign_and_unloading():
    strain = np.concatenate([np.linspace(0.0, 0.02, 200), np.linspace(0.02, 0.01, 80)])
    force = 1e4 * np.maximum(strain - 0.004, 0.0)
    values = {"width": 0.05, "gauge": 0.2, "family": "warp"}
    columns = {"travel": -0.2 * strain, "force": -force}
    test = pulled("uniaxial_tension", columns, values=values, toe="line")
    curve = loading_curve(test, test.specimens[0])
    np.testing.assert_allclose(curve.force, 1e4 * curve.at, rtol=1e-3, atol=0.5)
    assert curve.failed_at == pytest.approx(0.016, rel=0.02)  # it fell by more than a fifth
    assert curve.raw_at[-1] == pytest.approx(0.016, rel=0.02)
    travel = np.linspace(0.0, 0.05, 100)
    empty = Specimen("e", "e.csv", {"travel": travel, "force": 3.0 + 0 * travel})
    test = pulled(
        "picture_frame", {"travel": travel, "force": 40 * travel + 3.0}, values={"side": 0.2},
        empty=empty,
    )  # fmt: skip
    assert loading_curve(test, test.specimens[0]).raw_force[0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("kind", "columns", "values", "words"),
    [
        ("picture_frame", {"travel": np.linspace(0, 0.2, 50), "force": np.ones(50)},
         {"side": 0.2}, "yarns lie on each other"),
        ("picture_frame", {"angle": np.linspace(0, 2, 50), "force": np.ones(50)},
         {"side": 0.2}, "stay below 90°"),
        ("picture_frame", {"travel": np.linspace(0, 0.01, 5), "force": np.ones(5)},
         {"side": 0.2}, "fewer than 8"),
        ("picture_frame", {"travel": np.linspace(0, 0.01, 50), "force": np.ones(50)},
         {"side": 0.2, "preload": 5.0}, "never reaches the preload of 5 N"),
        ("picture_frame", {"angle": np.linspace(0, 0.5, 50), "force": np.ones(50)},
         {"side": 0.2, "compliance": 1e-6}, "compliance corrects a travel"),
    ],
)  # fmt: skip
def test_records_that_cannot_be_used(kind, columns, values, words):
    test = pulled(kind, columns, values=values)
    with pytest.raises(InputError) as error:
        loading_curve(test, test.specimens[0])
    assert words in str(error.value)


def test_until_cuts_off_what_goes_beyond_all_bounds():
    travel = np.linspace(0.0, 0.2, 200)
    values = {"side": 0.2, "until": math.radians(40.0)}
    test = pulled("picture_frame", {"travel": travel, "force": 1.0 + travel}, values=values)
    curve = loading_curve(test, test.specimens[0])
    assert math.radians(38.0) < curve.raw_at[-1] <= math.radians(40.0)


LAW = CrimpInterchange(2e-3, 2.04e-3, 0.006, 0.010, 20e3, 19e3)
PARAMETERS = np.array([0.006, 0.010, 20e3, 19e3])
SPACING = np.array([2e-3, 2.04e-3])


def test_crimp_law_is_that_of_the_card():
    rng = np.random.default_rng(3)
    strains = rng.uniform(-0.002, 0.015, (40, 2))
    exact = np.array([crimp_tensions(LAW, *each) for each in strains])
    assert exact.max() > 100.0
    found = crimp_tensions_of(PARAMETERS, SPACING, strains)
    np.testing.assert_allclose(found, exact, rtol=1e-9, atol=1e-7)


def biaxial(ratios, factor=1.0):
    found = []
    for warp, weft in ratios:
        strains = np.linspace(0.0, 0.012, 25)[:, None] * np.array([warp, weft])
        tensions = np.array([crimp_tensions(LAW, *each) for each in strains])
        found.append(BiaxialPoints("b", f"{warp} {weft}", strains, factor * tensions))
    return found


def test_crimp_law_is_found_again():
    strain = np.linspace(0.0, 0.02, 60)
    pulled_strips = [
        YarnCurve(f"u{k}", f, f, strain, free_strip(PARAMETERS, k, strain))
        for k, f in enumerate(("warp", "weft"))
    ]
    band = fit_crimp(pulled_strips, biaxial([(1, 1), (1, 0.5), (0.5, 1)]), SPACING, draws=2)
    np.testing.assert_allclose(band.value, PARAMETERS, rtol=1e-3)


def test_table_of_tensions_has_the_laws_of_its_points():
    ratios = [(1, 1), (1, 0.5), (0.5, 1), (1, 0), (0, 1), (1, 0.8), (0.8, 1), (1, 0.25), (0.25, 1)]
    fit = fit_table(biaxial(ratios), (2.04e-3, 2e-3), draws=2)
    grid = np.stack([g.ravel() for g in np.meshgrid(*fit.strains, indexing="ij")], axis=1)
    exact = np.array([crimp_tensions(LAW, *each) for each in grid]).reshape(6, 6, 2)
    for family in range(2):
        # 2 % of the largest: a kink (slack yarns) under cubic splines of five intervals
        off = np.abs(fit.table(family) - exact[..., family])
        assert off.max() < 0.02 * exact.max()
        own = np.diff(fit.table(family), axis=family)
        assert own.min() > -1e-6 * exact.max()
    assert not fit.beyond.any()
    assert fit_table(biaxial([(1, 1)]), (2.04e-3, 2e-3), draws=2).beyond.sum() > 15


def test_tables_of_tension_do_not_fall_whatever_the_data():
    points = biaxial([(1, 1), (1, 0.5), (0.5, 1)])
    falling = [replace(p, tensions=p.tensions * (1.5 - 100 * p.strains)) for p in points]
    assert np.diff(falling[0].tensions[:, 0]).min() < -1.0
    fit = fit_table(falling, (2.04e-3, 2e-3), draws=2)
    for family in range(2):
        own = np.diff(fit.table(family), axis=family)
        assert own.min() > -1e-6 * fit.table(family).max()


def test_errors_count_within_the_cards_data_only():
    at = np.arange(5.0)
    each = Prediction("t", "s", at, 2.0 * at, 2.0 * at + np.where(at > 3, 8.0, 0.8), "", "", 3.0)
    np.testing.assert_allclose(each.errors, np.full(4, 0.1))


def test_linear_yarns_and_failure():
    strain = np.linspace(0.0, 0.02, 100)
    curves = [
        YarnCurve("u", "warp", str(k), strain, f * 3e4 * np.maximum(strain - 0.005, 0.0), at)
        for k, (f, at) in enumerate(((0.9, 0.019), (1.0, 0.020), (1.1, None)))
    ]
    fit = fit_linear(curves)
    assert fit.stiffness.value[0] == pytest.approx(3e4, rel=1e-9)
    assert fit.start.value[0] == pytest.approx(0.005, rel=1e-9)
    assert fit.stiffness.low[0] < 2.7e4 < 3.3e4 < fit.stiffness.high[0]  # t = 2.92 of three
    assert fit_failure(curves).value[0] == pytest.approx(0.0195)
    assert fit_failure(curves[2:] * 2 + curves[:1]) is None


def test_cantilever_by_the_elastica():
    """Overhangs and angles of one strip give one stiffness; at 41.5° half the overhang."""
    stiffness, density = 2e-3, 0.6
    length = (stiffness / (9.81 * density)) ** (1 / 3)
    angles = np.radians([20.0, 41.5, 60.0])
    over = [length / flexural_length(1.0, float(a)) for a in angles]
    test = pulled("cantilever", {"overhang": over, "angle": angles}, values={"family": "warp"})
    fit = fit_cantilever([test], density)
    # 41.5° is 0.5 to 0.3 %: Peirce's figure against the elastica
    np.testing.assert_allclose(fit.readings["t"], stiffness, rtol=0.01)
    assert len(fit.readings["t"]) == 3 and fit.stiffness.told


WAY = np.concatenate([np.linspace(0, 250, 80), np.linspace(250, -250, 160)[1:],
                      np.linspace(-250, 0, 80)[1:]])  # fmt: skip


def test_dahls_friction_is_its_equation():
    for part in (slice(0, 80), slice(79, 239)):
        way = WAY[part]
        sign = np.sign(way[-1] - way[0])
        start = 0.0 if part.start == 0 else friction_history(WAY, 12.0)[79]
        solved = solve_ivp(
            lambda s, p, sign=sign: [(1 - sign * p[0]) / 12.0 * sign], (0.0, abs(way[-1] - way[0])),
            [start], t_eval=np.abs(way - way[0]), rtol=1e-10, atol=1e-12,
        )  # fmt: skip
        found = friction_history(WAY, 12.0)[part]
        np.testing.assert_allclose(found, solved.y[0], atol=1e-8)


def test_loops_give_their_curve_and_friction():
    curve = 0.05 * (1 - np.exp(-np.abs(WAY) / 60.0)) * np.sign(WAY)
    moment = curve + 0.01 * friction_history(WAY, 9.0)
    tests = [
        Test("l", "bending_loop", {"family": "warp"}, tuple(
            Specimen(str(k), "l.csv", {"curvature": WAY, "moment": moment}) for k in range(2)
        ))
    ]  # fmt: skip
    fit = fit_loops(tests, draws=20)
    assert fit.friction.value[0] == pytest.approx(0.01, rel=0.01)
    assert fit.over == pytest.approx(9.0, rel=0.03)
    exact = 0.05 * (1 - np.exp(-fit.curvatures / 60.0))
    np.testing.assert_allclose(fit.moments.value, exact, atol=2e-4)
    np.testing.assert_allclose(fit.moment(WAY), moment, atol=4e-4)
    # at 100 1/m both branches have all their friction: 2HB = 2 M_y
    assert fit.width.value[0] == pytest.approx(0.02, rel=0.01)
    slope = np.polyfit(WAY[16:49], moment[16:49], 1)[0]  # 50 to 150 1/m
    assert fit.stiffness.value[0] == pytest.approx(slope, rel=0.05)


def test_first_way_out_of_a_loop():
    specimen = Specimen("s", "s.csv", {"a": -WAY, "b": -3.0 * WAY})
    at, value = first_loading(specimen, "a", "b")
    assert at[0] == 0.0 and at[-1] == 250.0 and len(at) == 80
    np.testing.assert_allclose(value, 3.0 * at)
    assert loop_width(specimen, "a", "b", 100.0) == pytest.approx(0.0, abs=1e-9)
    assert loop_width(specimen, "a", "b", 300.0) is None


def grid_readings(noise=0.0):
    rng, found = np.random.default_rng(5), []
    for p in (5e3, 1e4, 3e4):
        for v in (1e-4, 1e-3, 1e-2):
            for k in range(3):
                mu = 0.3 * (p / 1e4) ** -0.1 * (v / 1e-3) ** 0.06
                mu *= math.exp(noise * rng.standard_normal())
                found.append(Reading("f", f"{k}", p, v, None, mu))
    return found


def test_friction_factors_are_found_again():
    fit = fit_friction(grid_readings(), draws=20)
    law = fit.law("made up")
    for p, v in ((5e3, 1e-4), (3e4, 1e-2), (1e4, 1e-3)):
        exact = 0.3 * (p / 1e4) ** -0.1 * (v / 1e-3) ** 0.06
        assert law(pressure=p, speed=v) == pytest.approx(exact, rel=1e-9)
    assert fit.apart == pytest.approx(0.0, abs=1e-9)
    noisy = fit_friction(grid_readings(0.05), draws=100)
    at = noisy.bands["pressure"]
    assert (at.low < at.value).all() and (at.value < at.high).all() and noisy.apart > 1e-3


def test_friction_effects_that_change_together_are_refused():
    both = [Reading("f", "a", p, v, None, 0.3) for p, v in ((1e3, 1e-3), (1e4, 1e-2))]
    with pytest.raises(InputError, match="cannot be told apart"):
        fit_friction(both * 2)


def test_sled():
    travel = np.linspace(0.0, 0.06, 100)
    force = np.where(travel < 0.01, 40.0 * travel / 0.004, 30.0)
    force = np.minimum(force, np.where(travel < 0.01, 45.0, 30.0))
    values = {"pressure": 1e4, "area": 0.01, "speed": 1e-3, "against": "ply"}
    (found,) = readings(pulled("sled", {"travel": travel, "force": force}, values=values))
    assert found.kinetic == pytest.approx(0.3) and found.static == pytest.approx(0.45)
    values = {**values, "normal": 2.0}
    with pytest.raises(InputError, match=r"coefficient of 15: check normal force"):
        readings(pulled("sled", {"travel": travel, "force": force}, values=values))


def test_compaction_power_law_and_table():
    solid, a, b = 0.6 / 2550.0, 0.23, 0.07
    pressure = np.geomspace(500.0, 2e5, 120)
    thickness = solid / (a * pressure**b)
    values = {"area": 2.5e-3, "plies": 4.0, "compliance": 1e-7}
    columns = {"thickness": 4 * thickness - 1e-7 * 2.5e-3 * pressure, "force": 2.5e-3 * pressure}
    test = pulled("compaction", columns, values=values)
    fit = fit_compaction(pressed(test), contact_pressure=1e3, solid=solid, draws=20)
    assert fit.exponent.value[0] == pytest.approx(b, rel=2e-3)
    assert fit.coefficient.value[0] == pytest.approx(a, rel=2e-3)
    np.testing.assert_allclose(fit.thickness.value, solid / (a * fit.pressures**b), rtol=1e-3)
    thicknesses, pressures = fit.table
    assert (np.diff(thicknesses) < 0).all() and pressures[0] == 0.0
    with pytest.raises(InputError, match="contact_pressure = 100 Pa must lie within"):
        fit_compaction(pressed(test), contact_pressure=100.0, solid=None, draws=20)


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
