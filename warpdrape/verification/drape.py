"""Folds of Cusick's drape test against bending length, by the closed form of a stretched sheet."""

from __future__ import annotations

import math
from collections.abc import Iterator

from warpdrape.scenes import cusick_drape
from warpdrape.verification.case import CaseResult, relative
from warpdrape.verification.wrinkling import wavelength

SPECIMEN, DISC = 0.15, 0.09
"""Radii of specimen and discs, ISO 9073-9 [m]."""
ONE_MORE = 1.0
"""Folds by which other rounding may change a run: their number is whole, and several can stand."""


def folds_expected(bending_length: float) -> float:
    """Number of folds of the specimen, were its overhang a sheet stretched by its own weight.

    λ = 2√π (B/T)^¼ √L of Cerda and Mahadevan (2003) with L the overhang, T = w L the weight that
    hangs from the disc's edge, and B = w c³: λ = 2√π c^¾ L^¼, and a fold for every λ of the
    overhang's middle circle. Put together here, not taken from a text. That n falls as c^-¾ is the
    theory's; the factor hangs on the choice of T and circle, by a fifth or so each.

    Args:
        bending_length: c [m].
    """
    overhang = SPECIMEN - DISC
    wave = wavelength(bending_length**3, overhang, overhang)  # over the weight w
    return math.pi * (SPECIMEN + DISC) / wave


def drape(quick: bool) -> Iterator[CaseResult]:
    """Folds of specimens of two bending lengths; none in a quick verification."""
    if quick:
        return
    for length in (0.02, 0.04):
        scene = cusick_drape.build(
            bending_length=length, specimen_radius=SPECIMEN, disc_radius=DISC
        )
        folds = scene.run(frames=4, threads=1).summary["drape"]["folds"]
        exact = folds_expected(length)
        case = f"drape test, bending length {1e3 * length:g} mm: folds"
        yield relative(case, folds, exact, 0.1, known=ONE_MORE / exact + 0.1)
