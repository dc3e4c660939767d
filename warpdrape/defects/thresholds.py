"""From which size on something counts as a defect: scale-free, the same for every part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpdrape.errors import InputError, finite, positive


@dataclass(frozen=True, kw_only=True)
class DefectThresholds:
    """Sizes over the ply's own.

    Attributes:
        wrinkle_amplitude: least amplitude of a wrinkle over the ply's thickness [-].
        wrinkle_steepness: least amplitude of a wrinkle over its wavelength [-]: 0.01 turns the
            yarns by up to 3.6° out of the ply.
        longest_wrinkle: longest wavelength over the square root of the blank's area [-]; longer
            waves are the ply's shape.
        bridge_gap: least gap of a bridge over the ply's thickness [-].
        yarn_compression: shortening from which on a yarn counts as compressed [-].
        cavity_room: widest room between two tools that makes a cavity, over the thickness of the
            stack between them [-].
    """

    wrinkle_amplitude: float = 0.5
    wrinkle_steepness: float = 0.01
    longest_wrinkle: float = 0.25
    bridge_gap: float = 1.0
    yarn_compression: float = 1e-3
    cavity_room: float = 4.0

    def __post_init__(self) -> None:
        positive("wrinkle_amplitude", self.wrinkle_amplitude)
        positive("wrinkle_steepness", self.wrinkle_steepness, zero=True)
        positive("bridge_gap", self.bridge_gap)
        positive("yarn_compression", self.yarn_compression, zero=True)
        positive("cavity_room", self.cavity_room)
        if not 0.0 < finite("longest_wrinkle", self.longest_wrinkle) <= 1.0:
            raise InputError(
                f"longest_wrinkle = {self.longest_wrinkle!r} must lie above 0 and up to 1: it is "
                "a share of the blank's size"
            )

    def least_amplitude(self, thickness: float, wavelength: np.ndarray) -> np.ndarray:
        """Least amplitude of a wrinkle of a wavelength, in a ply of a thickness [m]."""
        return np.maximum(
            self.wrinkle_amplitude * thickness, self.wrinkle_steepness * np.asarray(wavelength)
        )
