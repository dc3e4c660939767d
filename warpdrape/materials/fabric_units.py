"""The field's units in fabric files, and what they are in SI."""

from __future__ import annotations

import math

UNITS: dict[str, dict[str, float]] = {
    "areal density": {"kg/m²": 1.0, "g/m²": 1e-3},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "µm": 1e-6},
    "yarns per length": {"1/m": 1.0, "1/cm": 1e2, "1/mm": 1e3, "1/inch": 1 / 0.0254},
    "force": {"N": 1.0, "kN": 1e3, "cN": 1e-2},
    "couple": {"N·m": 1.0, "N·mm": 1e-3, "N·cm": 1e-2, "mN·m": 1e-3},
    "bending stiffness": {
        "N·m": 1.0,
        "N·mm": 1e-3,
        "mN·m": 1e-3,
        "µN·m": 1e-6,
        "cN·cm²/cm": 1e-4,
        "gf·cm²/cm": 9.80665e-5,
    },
    "curvature": {"1/m": 1.0, "1/cm": 1e2, "1/mm": 1e3},
    "moment per width": {
        "N": 1.0,
        "N·m/m": 1.0,
        "N·mm/mm": 1.0,
        "mN": 1e-3,
        "cN·cm/cm": 1e-2,
        "gf·cm/cm": 9.80665e-3,
    },
    "force per length": {"N/m": 1.0, "N/mm": 1e3, "kN/m": 1e3},
    "pressure": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "bar": 1e5},
    "density": {"kg/m³": 1.0, "g/cm³": 1e3},
    "angle": {"rad": 1.0, "deg": math.pi / 180, "°": math.pi / 180},
    "ratio": {"-": 1.0, "%": 1e-2},
}
"""Quantity → unit as written → factor to SI."""

_SPELLINGS = {
    "*": "·",
    ".": "·",
    "⋅": "·",
    "^2": "²",
    "m2": "m²",
    "^3": "³",
    "m3": "m³",
    "μ": "µ",
    "um": "µm",
    " ": "",
}


def si_factor(quantity: str, unit: str) -> float | None:
    """Factor from ``unit`` to SI, None where it is no unit of ``quantity``."""
    for written, meant in _SPELLINGS.items():
        unit = unit.replace(written, meant)
    return UNITS[quantity].get(unit)
