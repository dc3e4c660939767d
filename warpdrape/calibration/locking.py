"""The locking angle of a shear curve, with a definition of its own."""

from __future__ import annotations

import numpy as np

PART = 6
"""The curve's flattest and steepest parts are this fraction of its range each: 1/PART."""
STEEPER = 3.0
"""How many times steeper than the flattest part the steepest one must be to call it locking [-]."""
DEFINITION = (
    "where the line through the steepest sixth of the shear couple's curve meets the line through "
    "the flattest sixth before it"
)


def locking_angle(angle: np.ndarray, couple: np.ndarray) -> tuple[float, float]:
    """Angle at which two lines meet, and how many times the steep one is steeper.

    Args:
        angle: γ, even from 0 on [rad], shape [n].
        couple: C(γ), shape [n].

    Returns:
        The angle [rad] and the ratio of slopes [-]; within the range, whatever the curve.
    """
    span = max(2, len(angle) // PART)
    slopes = (couple[span:] - couple[:-span]) / (angle[span:] - angle[:-span])
    steep = int(np.argmax(slopes))
    flat = int(np.argmin(slopes[: steep + 1]))
    gap = slopes[steep] - slopes[flat]
    if gap <= 0.0:
        return float(angle[-1]), 1.0
    level = (couple[flat] - slopes[flat] * angle[flat]) - (
        couple[steep] - slopes[steep] * angle[steep]
    )
    at = float(np.clip(level / gap, angle[0], angle[-1]))
    least = max(float(slopes[flat]), 1e-12 * float(slopes[steep]))
    return at, float(slopes[steep]) / least
