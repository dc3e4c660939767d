"""Loops of bending and shear: their branches, how wide they are, and friction in them."""

from __future__ import annotations

import numpy as np

from warpdrape.calibration.preparation import FEWEST
from warpdrape.calibration.raw_table import Specimen
from warpdrape.errors import InputError


def first_loading(specimen: Specimen, along: str, value: str) -> tuple[np.ndarray, np.ndarray]:
    """The first way out of a loop, from zero to its first turn, both signs taken positive.

    Args:
        specimen: with the loop's record.
        along: column of what is led.
        value: column of what answers.
    """
    at, answer = specimen.columns[along], specimen.columns[value]
    turn = first_turn(at)
    at, answer = at[: turn + 1], answer[: turn + 1]
    sign = 1.0 if at[-1] >= 0.0 else -1.0
    at, answer = sign * at, sign * answer
    before = np.concatenate([[-np.inf], np.maximum.accumulate(at)[:-1]])
    kept = (at > before) & (at >= 0.0)
    if kept.sum() < FEWEST:
        raise InputError(
            f"{specimen.file}: {specimen.name} has {int(kept.sum())} rows on its first way out, "
            f"fewer than {FEWEST}: a loop starts at zero"
        )
    return at[kept], answer[kept]


def first_turn(at: np.ndarray) -> int:
    """Row at which a record first turns back by more than a tenth of its range."""
    back = 0.1 * float(np.ptp(at))
    for sign in (1.0, -1.0):
        ahead = np.maximum.accumulate(sign * at)
        turned = np.flatnonzero(ahead - sign * at > back)
        if len(turned):
            first = int(np.argmax(sign * at[: turned[0] + 1]))
            if first > 0:
                return first
    return len(at) - 1


def loop_width(specimen: Specimen, along: str, value: str, at: float) -> float | None:
    """Height between a loop's ways out and back at a place, mean of both sides; None if not there.

    Args:
        specimen: with the loop's record.
        along: column of what is led.
        value: column of what answers.
        at: place, positive.
    """
    led, answer = specimen.columns[along], specimen.columns[value]
    widths = []
    for sign in (1.0, -1.0):
        found: dict[bool, list[float]] = {True: [], False: []}
        for k in range(len(led) - 1):
            low, high = sorted((sign * led[k], sign * led[k + 1]))
            if low <= at < high:
                out = sign * (led[k + 1] - led[k]) > 0.0
                share = (at - sign * led[k]) / (sign * (led[k + 1] - led[k]))
                found[out].append(sign * (answer[k] + share * (answer[k + 1] - answer[k])))
        if found[True] and found[False]:
            widths.append(np.mean(found[True]) - np.mean(found[False]))
    return float(np.mean(widths)) if widths else None


def friction_history(at: np.ndarray, over: float) -> np.ndarray:
    """Dahl's friction of unit moment along a record, as `kernels.forces.bending_curve` has it.

    dp/dκ = (1 − sgn(dκ) p)/κ_c, exact for each step of one direction; none at the start.

    Args:
        at: κ of each row [1/m], shape [n].
        over: κ_c, change over which it builds up [1/m].
    """
    steps = np.diff(at)
    kept = np.exp(-np.abs(steps) / over)
    found = np.zeros(len(at))
    for k, (step, keep) in enumerate(zip(np.sign(steps), kept, strict=True)):
        found[k + 1] = step + (found[k] - step) * keep if step else found[k]
    return found
