"""Closed form of a yarn pulled out of a patch whose crossovers stay where they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpdrape.errors import positive

POINTS = 400
"""Of each of the three branches of the curve."""


@dataclass(frozen=True, kw_only=True)
class PullOut:
    """An elastic yarn in crossings that hold it like springs up to a limit: a shear lag.

    κ and q are the stiffness and the limit of the crossings per length of yarn, EA its stiffness, L
    its length in the patch; z from its free end. With β² = κ/EA:

    - held: the slide is u cosh(βz)/cosh(βL), F = EA β u tanh(βL), until u = q/κ;
    - slipping over a from the pulled end: F = EA β (q/κ) tanh(β(L − a)) + q a, and
      u = q/κ + ((F − q a) a + ½ q a²)/EA;
    - slipping all along, its end drawn in by d since: F = q (L − d), u = q/κ + d + ½ q (L − d)²/EA.

    What the end has been drawn in before, q/κ at most, is not taken off L.

    Attributes:
        length: L [m].
        stiffness: EA [N].
        hold: κ [N/m²].
        limit: q [N/m].
    """

    length: float
    stiffness: float
    hold: float
    limit: float

    def __post_init__(self) -> None:
        for name in ("length", "stiffness", "hold", "limit"):
            positive(name, getattr(self, name))

    @property
    def slips_from(self) -> float:
        """Pulled length at which the first crossing slips [m]."""
        return self.limit / self.hold

    @property
    def curve(self) -> tuple[np.ndarray, np.ndarray]:
        """Pulled lengths u [m] and forces F [N], until the yarn is out."""
        length, stiff, q, first = self.length, self.stiffness, self.limit, self.slips_from
        beta = np.sqrt(self.hold / stiff)
        held = np.linspace(0.0, first, POINTS)
        slipping = np.linspace(0.0, length, POINTS)
        kept = stiff * beta * first * np.tanh(beta * (length - slipping))
        drawn = length * np.linspace(0.0, 1.0, POINTS) ** 2
        left = length - drawn
        pulled = (
            held,
            first + (kept * slipping + 0.5 * q * slipping**2) / stiff,
            first + drawn + 0.5 * q * left**2 / stiff,
        )
        force = (stiff * beta * held * np.tanh(beta * length), kept + q * slipping, q * left)
        return np.concatenate(pulled), np.concatenate(force)

    def force(self, pulled: np.ndarray) -> np.ndarray:
        """Force F [N] at pulled lengths u [m]."""
        return np.interp(pulled, *self.curve, right=0.0)

    def mean_force(self, pulled: np.ndarray) -> np.ndarray:
        """Mean force [N] from each of n pulled lengths [m] to the next, shape [n − 1]."""
        at, _ = self.curve
        both = np.union1d(at, pulled)
        work = np.cumsum(np.diff(both, prepend=0.0) * self.force(0.5 * (both + np.roll(both, 1))))
        return np.diff(np.interp(pulled, both, work)) / np.diff(pulled)
