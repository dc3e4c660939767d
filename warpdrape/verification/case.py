"""What a verification case reports: a measured value beside the exact one, and its limit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

OK, SHORT, FAILED = "ok", "SHORT", "FAILED"
"""Within the limit; outside it, as is known and documented; outside it."""


@dataclass(frozen=True)
class CaseResult:
    """One line of the verification table.

    Attributes:
        case: what was checked, in words.
        measured: the value found.
        exact: the value it should have.
        limit: largest error that passes.
        unit: of measured and exact; "-" for a plain number.
        known: largest error of a case that is known to miss its limit; beyond it it has got worse.
            None where the limit is reached.
        relative: whether error and limit are relative to the exact value, which is not zero then;
            else they are in ``unit``.
    """

    case: str
    measured: float
    exact: float
    limit: float
    unit: str = "-"
    known: float | None = None
    relative: bool = False

    @property
    def error(self) -> float:
        """How far off the measured value is."""
        if self.relative:
            return abs(float(self.measured) / float(self.exact) - 1.0)
        return abs(float(self.measured) - float(self.exact))

    @property
    def passed(self) -> bool:
        """Whether the error is a number and within the limit."""
        return math.isfinite(self.error) and self.error <= self.limit

    @property
    def verdict(self) -> str:
        """One of ``OK``, ``SHORT`` (misses its limit as is known, no worse) and ``FAILED``."""
        if self.passed:
            return OK
        return SHORT if self.known is not None and self.error <= self.known else FAILED


absolute = CaseResult
"""Compare in the value's own unit."""
relative = partial(CaseResult, relative=True)
"""Compare relative to the exact value."""
