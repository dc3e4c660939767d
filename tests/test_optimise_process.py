"""The process by which a measure is modelled: its formulas, its fit, what few noisy runs tell."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from warpdrape.optimisation import process as module
from warpdrape.optimisation.process import Process, prior
from warpdrape.optimisation.space import SHARE, Axis, spread_places


def space(count):
    return tuple(Axis(SimpleNamespace(spread=None), SHARE, 0.0, 1.0) for _ in range(count))


def valley(p):
    """A slope, a valley, two parameters that work together, one that hardly does anything."""
    x, y, z, w = np.asarray(p).T
    return x + 2.0 * (y - 0.6) ** 2 - 0.6 * y * z + 0.1 * w


def known(count, noise, seed, function=valley, axes=4):
    places = np.array(spread_places(space(axes), count, seed))
    random = np.random.default_rng(seed)
    return places, function(places) + noise * random.standard_normal(count)


def covariance(theta, a, b):
    """Matérn, ν = 5/2, with level and lengths."""
    level, lengths = np.exp(theta[0]), np.exp(theta[1:-1])
    r = math.sqrt(5.0) * np.linalg.norm((a[:, None] - b[None]) / lengths, axis=2)
    return level * (1.0 + r + r**2 / 3.0) * np.exp(-r)


def test_mean_and_deviation_are_those_of_the_formulas():
    places, values = known(15, 0.1, 3)
    process = Process(space(4), places, values, 1)
    theta = process._model.kernel_.theta
    y = (values - values.mean()) / values.std()
    whole = covariance(theta, places, places) + np.exp(theta[-1]) * np.eye(15)
    there = np.random.default_rng(0).random((40, 4))
    between = covariance(theta, there, places)
    mean = values.mean() + values.std() * between @ np.linalg.solve(whole, y)
    left = np.exp(theta[0]) - np.einsum("ij,ji->i", between, np.linalg.solve(whole, between.T))
    found, deviation = process.at(there)
    np.testing.assert_allclose(found, mean, rtol=1e-7)
    np.testing.assert_allclose(deviation, values.std() * np.sqrt(left), rtol=1e-5)
    assert process.noise == pytest.approx(values.std() * math.exp(0.5 * theta[-1]))


def test_scikit_learns_own_prediction_is_the_same_but_for_the_noise():
    from sklearn.gaussian_process import GaussianProcessRegressor

    places, values = known(20, 0.2, 4)
    process = Process(space(4), places, values, 1)
    kernel = process._model.kernel_
    own = GaussianProcessRegressor(kernel, optimizer=None, normalize_y=True).fit(places, values)
    there = np.random.default_rng(1).random((30, 4))
    mean, deviation = process.at(there)
    theirs, with_noise = own.predict(there, return_std=True)
    np.testing.assert_allclose(mean, theirs, rtol=1e-7)
    np.testing.assert_allclose(np.hypot(deviation, process.noise), with_noise, rtol=1e-6)


def test_the_kernel_is_the_most_probable_one():
    places, values = known(14, 0.15, 5)
    process = Process(space(4), places, values, 1)
    theta, y = process._model.kernel_.theta, (values - values.mean()) / values.std()
    middle, spread = prior(4)

    def improbable(at):
        whole = covariance(at, places, places) + (np.exp(at[-1]) + 1e-10) * np.eye(14)
        fit = 0.5 * y @ np.linalg.solve(whole, y) + 0.5 * np.linalg.slogdet(whole)[1]
        return fit + 0.5 * (((at - middle) / spread) ** 2).sum()

    least = improbable(theta)
    for k in range(len(theta)):
        for step in (-0.05, 0.05):
            assert improbable(theta + step * np.eye(len(theta))[k]) > least
    for other in np.random.default_rng(2).normal(middle, spread, (200, len(theta))):
        assert improbable(other) > least - 1e-6  # of all that are likely, not of those near alone


def test_two_runs_leave_the_kernel_as_it_was_beforehand():
    process = Process(space(4), *known(2, 0.0, 1), 1)
    middle, spread = prior(4)
    assert np.abs((process._model.kernel_.theta - middle) / spread).max() < 0.7


def test_noise_is_taken_for_noise():
    def bowl(p):
        return (p[:, 0] - 0.3) ** 2 + (p[:, 1] - 0.6) ** 2

    places, seen = known(48, 0.1, 0, bowl, 2)
    process = Process(space(2), places, seen, 1)
    mean, deviation = process.at(places)
    assert np.std(mean - bowl(places)) < 0.5 * np.std(seen - bowl(places))
    assert process.noise == pytest.approx(0.1, rel=0.25)
    assert deviation.max() < 0.1  # of the mean, not of one more run


def test_a_dozen_noisy_runs_are_not_taken_for_certain(monkeypatch):
    """By their likelihood alone half of such fits have no noise at all, and are sure of it."""

    def judged():
        inside, noises = [], []
        for seed in range(8):
            places, values = known(11, 0.15, seed)
            process = Process(space(4), places, values, seed)
            there = np.random.default_rng(99).random((200, 4))
            mean, deviation = process.at(there)
            inside.append(np.mean(np.abs(mean - valley(there)) < 1.645 * deviation))
            noises.append(process.noise)
        return np.mean(inside), np.median(noises)

    covered, noise = judged()
    assert 0.8 < covered < 0.98  # of bands of 90 %
    assert noise == pytest.approx(0.15, rel=0.6)
    for name in ("LENGTH_SPREAD", "NOISE_SPREAD", "LEVEL_SPREAD"):
        monkeypatch.setattr(module, name, 1e3)  # nothing known beforehand
    bare, none = judged()
    assert bare < covered - 0.05 and none < 0.3 * noise


def test_believed_places_are_known_and_change_nothing_else():
    places, values = known(12, 0.0, 0)
    process = Process(space(4), places, values, 1)
    there, far = np.array([[0.93, 0.07, 0.5, 0.5]]), np.array([[0.05, 0.95, 0.1, 0.9]])
    (before, beyond), (wide, doubt) = process.at(np.vstack([there, far]))
    kernel, noise = process._model.kernel_, process.noise
    for _ in range(6):  # at their mean: they tell of no other level and no other scatter
        process.believe(there)
    (after, still), (narrow, same) = process.at(np.vstack([there, far]))
    assert after == pytest.approx(before, abs=1e-3) and narrow < 0.6 * wide
    assert still == pytest.approx(beyond, abs=1e-3) and same == pytest.approx(doubt, rel=0.05)
    assert process._model.kernel_ == kernel and process.noise == noise
