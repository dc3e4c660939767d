"""Shear tests made independent of the specimen's size: couple per area, and normalised force."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np


def frame_rows(values: Mapping[str, Any], angle: np.ndarray, force: np.ndarray) -> tuple:
    """Couple per area [N/m] of a picture frame: C = F (L/L_fab²)(cos γ/2 − sin γ/2)/√2.

    Power balance, as `coupons.closed_forms.frame_force`; the same as the normalised shear force
    F_sh = C/cos γ of Cao et al. (2008), in which L_fab²/L stands for the sample.

    Args:
        values: ``side`` and, where the sample does not fill it, ``sample`` [m].
        angle: γ [rad], shape [n].
        force: F [N], shape [n].

    Returns:
        C, and the share of C(γ/2) in it, none here.
    """
    side = values["side"]
    opening = np.cos(angle / 2) - np.sin(angle / 2)
    area = values.get("sample", side) ** 2
    return force * side / area * opening / math.sqrt(2.0), np.zeros_like(angle)


def bias_rows(values: Mapping[str, Any], angle: np.ndarray, force: np.ndarray) -> tuple:
    """What bias extension says: C(γ) + W/(2H − 3W) C(γ/2) [N/m], from its force.

    Power balance, as `coupons.closed_forms.bias_force`: the normalisation of Cao et al. (2008),
    after Harrison, Clifford and Long (2004), with C = F_sh cos γ.

    Args:
        values: ``width`` W and ``height`` H [m].
        angle: γ in the middle zone [rad], shape [n].
        force: F [N], shape [n].

    Returns:
        F (H/W − 1)(cos γ/2 − sin γ/2)/(2H − 3W), and the share of C(γ/2) in it.
    """
    width, height = values["width"], values["height"]
    opening = (height / width - 1.0) * (np.cos(angle / 2) - np.sin(angle / 2))
    middle = 2.0 * height - 3.0 * width
    return force * opening / middle, np.full_like(angle, width / middle)


def loop_rows(values: Mapping[str, Any], angle: np.ndarray, line_force: np.ndarray) -> tuple:
    """Couple per area [N/m] of Kawabata's shear: C = f cos γ − T sin γ.

    Yarns of constant length between clamps that approach each other against a dead load: the shear
    force f and the load T, both per width, do f cos γ dγ − T sin γ dγ per area.

    Args:
        values: ``tension`` T [N/m] where the record still holds its part.
        angle: γ [rad], shape [n].
        line_force: f [N/m], shape [n].

    Returns:
        C, and the share of C(γ/2) in it, none here.
    """
    pulled = values.get("tension", 0.0)
    return line_force * np.cos(angle) - pulled * np.sin(angle), np.zeros_like(angle)


ROWS = {"picture_frame": frame_rows, "bias_extension": bias_rows, "shear_loop": loop_rows}


def couple_by_steps(angle: np.ndarray, said: np.ndarray, share: np.ndarray) -> np.ndarray:
    """C(γ) [N/m] from C(γ) + share C(γ/2), angle after angle as published; for one specimen.

    C at half the angle is read between angles done before, on a line from no couple at 0°.

    Args:
        angle: γ, rising [rad], shape [n].
        said: C(γ) + share C(γ/2) [N/m], shape [n].
        share: [-], shape [n].
    """
    known_at, known = [0.0], [0.0]
    for at, value, part in zip(angle, said, share, strict=True):
        if at <= 0.0:
            continue
        half = at / 2
        if half <= known_at[-1]:
            below = float(np.interp(half, known_at, known))
            couple = float(value) - part * below
        else:  # C(γ/2) lies on the line to the last known point and on to C(γ) itself
            t = (half - known_at[-1]) / (at - known_at[-1])
            couple = (float(value) - part * (1.0 - t) * known[-1]) / (1.0 + part * t)
        known_at.append(float(at))
        known.append(couple)
    return np.interp(angle, known_at, known)


def normalised_force(angle: np.ndarray, couple: np.ndarray) -> np.ndarray:
    """F_sh = C/cos γ [N/m], as shear curves are published."""
    return couple / np.cos(angle)
