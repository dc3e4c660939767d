"""Closed forms of wrinkles against brute force, what measures waves, and the drape test."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import minimize, minimize_scalar

from warpdrape.errors import InputError
from warpdrape.scenes import cusick_drape
from warpdrape.verification.flange import (
    FOLD,
    flange_force,
    flange_wavelength,
    longest_wave_by_friction,
)
from warpdrape.verification.fully_wrinkled import SHAPES, SqueezedSheet
from warpdrape.verification.wrinkling import LENGTH, stretched_sheet, wavelength, waves_across


def test_a_stretched_sheet_wrinkles_first_at_the_closed_form():
    bending, tension, length = 6e-5, 100.0, 0.09

    def squeeze(wave):  # at which w = sin(πx/L) cos(ky) is in equilibrium, in full
        k, q = 2.0 * math.pi / wave, math.pi / length
        return (bending * (k * k + q * q) ** 2 + tension * q * q) / k**2

    found = minimize_scalar(squeeze, bounds=(0.01, 0.1), method="bounded", options={"xatol": 1e-9})
    # the closed form leaves out the bending along the sheet: B q²/T of k⁴
    assert wavelength(bending, tension, length) == pytest.approx(found.x, rel=1e-3)


SHEET = SqueezedSheet(bending=6e-5, tension=100.0, stiffness=1e4, length=0.09)


def test_far_from_the_threshold_slopes_are_those_of_the_energy():
    amplitudes = 1e-4 * np.random.default_rng(1).standard_normal(SHAPES)
    step, k, squeeze = 1e-9, 200.0, 3e-3
    _, slopes = SHEET.energy(amplitudes, k, squeeze)
    for j in range(SHAPES):
        ends = []
        for side in (1.0, -1.0):
            moved = amplitudes.copy()
            moved[j] += side * step
            ends.append(SHEET.energy(moved, k, squeeze)[0])
        assert slopes[j] == pytest.approx((ends[0] - ends[1]) / (2.0 * step), rel=1e-4)
    assert np.abs(slopes).min() > 1e-3


def test_far_from_the_threshold_the_energy_is_that_of_the_wave():
    """By sums over x and y of a wave's own curvature, slope and compression."""
    amplitudes, k, squeeze = np.zeros(SHAPES), 200.0, 3e-3
    amplitudes[:2] = 3e-4, 1e-4
    n = 400
    x = (np.arange(n) + 0.5) / n * SHEET.length
    y = (np.arange(n) + 0.5) / n * 2.0 * math.pi / k
    orders = math.pi / SHEET.length * np.array([1.0, 3.0])
    f = np.sin(np.outer(x, orders)) @ amplitudes[:2]
    slope = (np.cos(np.outer(x, orders)) * orders) @ amplitudes[:2]
    curved = -(np.sin(np.outer(x, orders)) * orders**2) @ amplitudes[:2]
    wave = np.cos(k * y)
    bend = 0.5 * SHEET.bending * np.mean(np.outer(curved - k**2 * f, wave) ** 2)
    pull = 0.5 * SHEET.tension * np.mean(np.outer(slope, wave) ** 2)
    taken = 0.5 * np.mean(np.outer(f, k * np.sin(k * y)) ** 2, axis=1)
    left = 0.5 * SHEET.stiffness * np.mean((squeeze - taken) ** 2)
    assert SHEET.energy(amplitudes, k, squeeze)[0] == pytest.approx(bend + pull + left, rel=1e-4)


def test_just_beyond_the_threshold_the_wave_is_the_closed_form_s_and_then_shorter():
    closed = wavelength(SHEET.bending, SHEET.tension, SHEET.length)
    first = 2.0 * math.pi / SHEET.first_wave_number
    assert first == pytest.approx(closed, rel=1e-3)
    assert SHEET.wavelength(0.9 * SHEET.threshold) == first
    waves = [SHEET.wavelength(times * SHEET.threshold) for times in (1.01, 2.0, 7.0, 15.0)]
    assert waves[0] == pytest.approx(first, rel=1e-3)
    assert waves == sorted(waves, reverse=True)
    assert waves[2] == pytest.approx(0.90 * first, rel=0.01)
    # a sheet that is flat below the threshold, and no longer above it
    k, flat = SHEET.first_wave_number, 1.0
    assert SHEET.least_energy(k, 0.99 * SHEET.threshold) == pytest.approx(flat, abs=1e-6)
    assert SHEET.least_energy(k, 1.2 * SHEET.threshold) < flat - 1e-3


def test_a_flange_folds_at_the_closed_form_with_the_exact_shape_of_its_waves():
    """Least energy over every shape of a wave between two contacts, not only a sine."""
    bending, pressure, shortening = FOLD["bending"], FOLD["pressure"], FOLD["shortening"]
    share = np.linspace(0.0, 1.0, 2001)

    def energy(unknown):  # span from trough to crest, and odd harmonics of cos πξ
        span, coefficients = math.exp(unknown[0]), np.array([1.0, *unknown[1:]])
        orders = math.pi * np.arange(1, 2 * len(coefficients), 2)
        waves = np.outer(share, orders)
        slope = (coefficients * orders * np.sin(waves)).sum(axis=1)
        bend = (coefficients * orders**2 * np.cos(waves)).sum(axis=1)
        high = 2.0 * coefficients.sum()
        steep, bent = np.trapezoid(slope**2, share), np.trapezoid(bend**2, share)
        scale = span * math.sqrt(2.0 * shortening / steep)
        return 0.5 * bending * scale**2 * bent / span**4 + pressure * abs(high) * scale

    sine = minimize(energy, [math.log(0.02)], method="Nelder-Mead", options={"xatol": 1e-8})
    closed = flange_wavelength(bending, pressure, shortening)
    assert 2.0 * math.exp(sine.x[0]) == pytest.approx(closed, rel=1e-4)
    best = minimize(energy, [sine.x[0], 0.0, 0.0], method="Nelder-Mead")
    assert best.fun < sine.fun * (1.0 + 1e-9)
    assert 2.0 * math.exp(best.x[0]) == pytest.approx(closed, rel=0.04)  # what a sine costs


def test_a_flange_is_pressed_by_what_its_energy_says_and_friction_brings_no_more():
    """The slope of the least energy by the shortening; a wave as long as friction allows."""
    bending, pressure, shortening = 2e-3, 800.0, 0.07

    def least(e):  # of bending and of the holder's way, over the wave that costs least
        wave = flange_wavelength(bending, pressure, e)
        grid = wave * np.linspace(0.5, 2.0, 3001)
        bent = 4.0 * math.pi**2 * bending * e / grid**2
        return (bent + 2.0 * pressure * grid * math.sqrt(e) / math.pi).min()

    step = 1e-4
    slope = (least(shortening + step) - least(shortening - step)) / (2.0 * step)
    assert flange_force(bending, pressure, shortening) == pytest.approx(slope, rel=1e-4)
    wave = flange_wavelength(bending, pressure, shortening)
    reach = flange_force(bending, pressure, shortening) / (0.6 * pressure)  # by which 0.6 is enough
    assert longest_wave_by_friction(0.6, reach, shortening) == pytest.approx(wave, rel=1e-12)
    assert longest_wave_by_friction(0.3, reach, shortening) == pytest.approx(wave / 2, rel=1e-12)


@pytest.mark.parametrize("edge", [0.005, 0.0036])  # an even and an odd number of cells
def test_waves_across_a_sheet_are_measured(edge):
    scene = stretched_sheet(0.03, width=0.2, edge=edge)
    flat = scene.plies[0].rest_points
    points = (
        flat
        + np.array([0.0, 0.0, 1.0])
        * (1e-3 * np.cos(math.pi * flat[:, 0] / LENGTH) * np.cos(2 * math.pi * flat[:, 1] / 0.027))[
            :, None
        ]
    )
    made = SimpleNamespace(plies=[SimpleNamespace(rest_points=flat, points=points)])
    found, halves = waves_across(made)
    assert found == pytest.approx(0.027, rel=0.02)  # five points a wave
    assert halves in (6, 7)


def test_folds_of_an_outline_are_counted():
    at = np.linspace(-math.pi, math.pi, cusick_drape.RIM, endpoint=False)
    for number in (2, 5, 8):
        outline = 0.12 + 0.01 * np.cos(number * at + 0.4) + 1e-3 * np.cos(40 * at)
        assert cusick_drape.count_folds(outline, 0.06) == number
        moved = outline + 0.02 * np.cos(at)  # a specimen that hangs to one side
        assert cusick_drape.strongest_wave(moved) == number
    assert cusick_drape.count_folds(np.full(720, 0.15), 0.06) == 0


def ring_drop(inner, outer, length):
    """Drop [m] of the free edge of a plate ring held at its inner edge, ν = 0, q/D = 1/length³."""
    load, a, b = length**-3, inner, outer
    # w = q r⁴/64D + c0 + c1 r² + c2 ln r + c3 r² ln r; w, w′ at a; w″, (∇²w)′ at b
    matrix = [
        [1.0, a * a, math.log(a), a * a * math.log(a)],
        [0.0, 2.0 * a, 1.0 / a, a * (2.0 * math.log(a) + 1.0)],
        [0.0, 2.0, -1.0 / b**2, 2.0 * math.log(b) + 3.0],
        [0.0, 0.0, 0.0, 4.0 / b],
    ]
    known = [-load * a**4 / 64, -load * a**3 / 16, -load * b * b * 3 / 16, -load * b / 2]
    c = np.linalg.solve(matrix, known)
    return load * b**4 / 64 + c @ [1.0, b * b, math.log(b), b * b * math.log(b)]


def test_a_stiff_specimen_stays_flat_and_a_soft_one_folds():
    stiff = cusick_drape.build(bending_length=0.2, edge=0.01, duration=0.2, damping=30.0)
    drape = stiff.run(frames=2, threads=1).summary["drape"]
    assert drape["folds"] == 0
    # the disc's edge lies up to an edge away from the vertices that feel it
    assert drape["edge_drop_m"] == pytest.approx(ring_drop(0.09, 0.15, 0.2), rel=0.15)
    assert drape["drape_coefficient"] == pytest.approx(1.0, abs=0.02)  # the outline's chords
    soft = cusick_drape.build(bending_length=0.02, edge=0.012, duration=0.6)
    drape = soft.run(frames=2, threads=1).summary["drape"]
    assert 3 <= drape["folds"] <= 10
    assert 0.3 < drape["drape_coefficient"] < 0.8 and drape["edge_drop_m"] > 0.03


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"disc_radius": 0.15}, "disc_radius = 0.15 m must be below"),
        ({"bending_length": -1.0}, "bending_length = -1.0 m"),
        ({"fabric": "no_cloth"}, "no_cloth"),
    ],
)
def test_drapes_that_cannot_be_are_refused(given, message):
    with pytest.raises(InputError, match=message):
        cusick_drape.build(**given)
