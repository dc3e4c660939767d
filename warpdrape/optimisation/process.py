"""A Gaussian process through what is known of one number: its mean, and the doubt about that.

scikit-learn's, with a Matérn kernel of its own length along each axis and white noise, which takes
up both what differs from run to run and what jumps from place to place. A dozen runs do not tell
noise from short lengths: the likelihood has several maxima, and the highest is often a process that
goes through every run, or one that is all noise. So the fit is of the most probable kernel, its
lengths, level and noise each lognormal beforehand.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.optimize import minimize

from warpdrape.optimisation.space import Axis, features
from warpdrape.optional import needed

SMOOTH = 2.5
"""Of the Matérn kernel: twice differentiable."""
LEVELS, LENGTHS, NOISES = (0.05, 20.0), (0.05, 20.0), (1e-5, 1.0)
"""Bounds of the variance, of lengths over the axis, and of the noise, over the values' variance."""
LENGTH, LENGTH_SPREAD = 0.5, 0.8
"""Median of the lengths beforehand, over the space's diagonal, and spread of their logarithm."""
NOISE, NOISE_SPREAD = 0.05, 1.5
"""Likewise of the noise, over the values' variance: 0.005 to 0.5 within a band of 90 %."""
LEVEL_SPREAD = 1.0
"""Of the logarithm of the variance over that of the values, about none."""
RESTARTS = 2
"""Further starts of the fit."""


class Process:
    """A Gaussian process through what is known of one number.

    Args:
        axes: the space.
        places: shape [run, axis].
        values: shape [run].
        seed: of the fit's further starts.
    """

    def __init__(
        self, axes: Sequence[Axis], places: np.ndarray, values: np.ndarray, seed: int
    ) -> None:
        self._axes, self._x = axes, features(axes, places)
        self._middle, self._scale = float(np.mean(values)), float(np.std(values)) or 1.0
        self._y = (values - self._middle) / self._scale
        gaussian = needed("sklearn.gaussian_process", "optimise")
        self._model = gaussian.GaussianProcessRegressor(
            self._kernel(),
            optimizer=self._most_probable,
            n_restarts_optimizer=RESTARTS,
            random_state=seed % 2**32,
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of lengths at their bounds, which may be
            self._model.fit(self._x, self._y)
        self._model.set_params(kernel=self._model.kernel_, optimizer=None)

    @property
    def noise(self) -> float:
        """Standard deviation of one run about the mean."""
        return self._scale * math.sqrt(self._model.kernel_.k2.noise_level)

    def believe(self, places: np.ndarray) -> None:
        """Take the mean at places, shape [n, axis], for known; the kernel stays as it was."""
        there = features(self._axes, places)
        self._y = np.append(self._y, self._model.predict(there))
        self._x = np.vstack([self._x, there])
        self._model.fit(self._x, self._y)

    def at(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean, and standard deviation without the noise of a run, both shape [n]."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            mean, deviation = self._model.predict(features(self._axes, places), return_std=True)
        variance = deviation**2 - self._model.kernel_.k2.noise_level
        deviation = self._scale * np.sqrt(np.maximum(variance, 1e-12))
        return self._middle + self._scale * mean, deviation

    def _kernel(self) -> Any:
        kernels = needed("sklearn.gaussian_process.kernels", "optimise")
        count = self._x.shape[1]
        lengths = np.clip(np.full(count, LENGTH * math.sqrt(count)), *LENGTHS)
        shape = kernels.Matern(lengths, LENGTHS, nu=SMOOTH)
        return kernels.ConstantKernel(1.0, LEVELS) * shape + kernels.WhiteKernel(NOISE, NOISES)

    def _most_probable(
        self, unlikely: Callable[..., tuple[float, np.ndarray]], first: np.ndarray, bounds: Any
    ) -> tuple[np.ndarray, float]:
        """The kernel's most probable logarithms, as scikit-learn asks for an optimiser."""
        middle, spread = prior(self._x.shape[1])

        def improbable(theta: np.ndarray) -> tuple[float, np.ndarray]:
            value, slope = unlikely(theta)
            off = (theta - middle) / spread
            return value + 0.5 * float(off @ off), slope + off / spread

        found = minimize(improbable, first, jac=True, bounds=bounds, method="L-BFGS-B")
        return found.x, float(found.fun)


def prior(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Means and spreads of the kernel's logarithms beforehand: level, lengths, noise.

    Args:
        count: of features.
    """
    lengths = np.full(count, math.log(LENGTH * math.sqrt(count)))
    middle = np.concatenate([[0.0], lengths, [math.log(NOISE)]])
    spread = np.concatenate([[LEVEL_SPREAD], np.full(count, LENGTH_SPREAD), [NOISE_SPREAD]])
    return middle, spread
