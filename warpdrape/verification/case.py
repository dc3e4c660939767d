"""What a verification case reports: a measured value beside the exact one, and its limit."""

from __future__ import annotations

import math
from dataclasses import dataclass

OK, SHORT, FAILED = "ok", "SHORT", "FAILED"
"""Within the limit; outside it, as is known and documented; outside it."""


@dataclass(frozen=True)
class CaseResult:
    """One line of the verification table.

    Attributes:
        case: what was checked, in words.
        measured: the value found.
        exact: the value it should have.
        error: how far off it is: relative where ``relative``, else in ``unit``.
        limit: largest error that passes.
        unit: of measured and exact; "-" for a plain number.
        relative: whether error and limit are relative to the exact value.
        known: largest error of a case that is known to miss its limit; beyond it it has got worse.
            None where the limit is reached.
    """

    case: str
    measured: float
    exact: float
    error: float
    limit: float
    unit: str = "-"
    relative: bool = False
    known: float | None = None

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


def relative(
    case: str,
    measured: float,
    exact: float,
    limit: float,
    unit: str = "-",
    known: float | None = None,
) -> CaseResult:
    """Compare relative to the exact value, which is not zero."""
    error = abs(float(measured) / float(exact) - 1.0)
    return CaseResult(case, float(measured), float(exact), error, limit, unit, True, known)


def absolute(
    case: str,
    measured: float,
    exact: float,
    limit: float,
    unit: str = "-",
    known: float | None = None,
) -> CaseResult:
    """Compare in the value's own unit."""
    error = abs(float(measured) - float(exact))
    return CaseResult(case, float(measured), float(exact), error, limit, unit, False, known)
