"""What a verification case reports: a measured value beside the exact one, and its limit."""

from __future__ import annotations

import math
from dataclasses import dataclass


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
    """

    case: str
    measured: float
    exact: float
    error: float
    limit: float
    unit: str = "-"
    relative: bool = False

    @property
    def passed(self) -> bool:
        """Whether the error is a number and within the limit."""
        return math.isfinite(self.error) and self.error <= self.limit


def relative(case: str, measured: float, exact: float, limit: float, unit: str = "-") -> CaseResult:
    """Compare relative to the exact value, which is not zero."""
    error = abs(float(measured) / float(exact) - 1.0)
    return CaseResult(case, float(measured), float(exact), error, limit, unit, True)


def absolute(case: str, measured: float, exact: float, limit: float, unit: str = "-") -> CaseResult:
    """Compare in the value's own unit."""
    error = abs(float(measured) - float(exact))
    return CaseResult(case, float(measured), float(exact), error, limit, unit)
