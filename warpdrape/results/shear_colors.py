"""Colours of the shear angle in the animation: a perceptually uniform scale as linear light."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

COLOR_RANGE_DEG = 60.0
"""Shear angle at the bright end of ``displayColor`` [deg]; the dark end is 0."""

# viridis (perceptually uniform, CC0) at 17 even steps, sRGB in 1/255.
_VIRIDIS = np.array(
    [
        (68, 1, 84), (72, 24, 106), (71, 45, 123), (66, 64, 134), (59, 82, 139), (51, 99, 141),
        (44, 114, 142), (38, 130, 142), (33, 145, 140), (31, 160, 136), (40, 174, 128),
        (63, 188, 115), (94, 201, 98), (132, 212, 75), (173, 220, 48), (216, 226, 25),
        (253, 231, 37),
    ]
) / 255.0  # fmt: skip


def _linear_scale(colors: int) -> NDArray[np.float32]:
    """Return the scale in even steps as linear light, which USD takes colours to be."""
    at = np.linspace(0.0, len(_VIRIDIS) - 1.0, colors)
    steps = np.arange(len(_VIRIDIS))
    srgb = np.stack([np.interp(at, steps, _VIRIDIS[:, c]) for c in range(3)], axis=1)
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    return linear.astype(np.float32)


_SCALE = _linear_scale(1201)  # steps of 0.05°


def shear_color(shear_angle_deg: NDArray[np.floating]) -> NDArray[np.float32]:
    """Return colours of |γ|, from dark at 0 to bright at 60° and beyond.

    Args:
        shear_angle_deg: signed shear angles [deg], shape (m,).
    """
    last = len(_SCALE) - 1
    at = np.minimum(np.abs(shear_angle_deg) * (last / COLOR_RANGE_DEG), last)
    return _SCALE.take(np.rint(at).astype(np.intp), axis=0)
