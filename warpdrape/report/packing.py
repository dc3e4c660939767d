"""Numbers as the report's page holds them: 16 bits each, differences in time, compressed, base64.

A value v becomes the whole number nearest to (v - low) / step, with step = (high - low) / 65534,
so that it is off by half a step at most; 65535 stands for no value. Along time only the first frame
is kept as it is, of the others the difference to the one before (modulo 65536); then the low bytes
of all come first and the high bytes after, which are nearly all alike and compress to little.
``assets/decode.js`` undoes it.
"""

from __future__ import annotations

import base64
import zlib
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

NOTHING = 65535
"""The number that stands for no value."""
_LEVEL = 9  # of compression: a report is made once and kept


@dataclass
class Blocks:
    """The page's blocks of packed numbers.

    Attributes:
        texts: each block in base64.
    """

    texts: list[str] = field(default_factory=list)

    def whole_numbers(self, numbers: ArrayLike) -> int:
        """Take up whole numbers from 0 on, of 32 bits; return the number of their block."""
        return self._add(np.asarray(numbers).astype("<u4").tobytes())

    def values(self, values: ArrayLike, low: ArrayLike, high: ArrayLike) -> int:
        """Take up values as 16 bits between bounds; return the number of their block.

        Args:
            values: shape [frame, value] or, with bounds per column, [frame, value, column].
            low: lower bound, or one per column.
            high: upper bound, or one per column.
        """
        numbers = quantised(values, low, high)
        numbers = numbers.reshape(len(numbers), -1)
        steps = np.diff(numbers, axis=0, prepend=np.zeros_like(numbers[:1]))
        planes = np.ascontiguousarray(steps.astype("<u2")).view(np.uint8).reshape(-1, 2).T
        return self._add(np.ascontiguousarray(planes).tobytes())

    def text(self, data: bytes) -> int:
        """Take up a file's content; return the number of its block."""
        return self._add(data)

    @property
    def size(self) -> int:
        """Characters of all blocks."""
        return sum(map(len, self.texts))

    def _add(self, data: bytes) -> int:
        self.texts.append(base64.b64encode(zlib.compress(data, _LEVEL)).decode("ascii"))
        return len(self.texts) - 1


def quantised(values: ArrayLike, low: ArrayLike, high: ArrayLike) -> NDArray[np.uint16]:
    """Values as whole numbers of 16 bits; what is not finite becomes `NOTHING`."""
    values = np.asarray(values, np.float64)
    low, width = np.asarray(low, np.float64), np.asarray(high, np.float64) - low
    share = (values - low) / np.where(width > 0.0, width, 1.0)
    numbers = np.rint(np.clip(np.nan_to_num(share), 0.0, 1.0) * (NOTHING - 1))
    return np.where(np.isfinite(values), numbers, NOTHING).astype(np.uint16)


def step(low: float, high: float) -> float:
    """Distance of neighbouring values that 16 bits can hold between bounds."""
    return (high - low) / (NOTHING - 1)
