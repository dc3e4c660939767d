"""The field's units in fabric files, and what they are in SI."""

from __future__ import annotations

import math

from warpdrape.units import FREEZING

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
    "viscosity": {"Pa·s": 1.0, "kPa·s": 1e3, "MPa·s": 1e6},
    "rate": {"1/s": 1.0, "1/min": 1.0 / 60.0, "rad/s": 1.0, "°/s": math.pi / 180},
    "time": {"s": 1.0, "ms": 1e-3, "min": 60.0},
    "temperature": {"K": 1.0, "°C": 1.0},
    "temperature difference": {"K": 1.0},
    "energy per amount": {"J/mol": 1.0, "kJ/mol": 1e3},
    "heat capacity per area": {"J/(m²·K)": 1.0, "J/m²K": 1.0, "kJ/(m²·K)": 1e3},
    "conductance": {"W/(m²·K)": 1.0, "W/m²K": 1.0},
}
"""Quantity → unit as written → factor to SI."""

ZEROS = {("temperature", "°C"): FREEZING}
"""Where a unit's zero is, in SI, unless that is zero."""

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
    return UNITS[quantity].get(_spelt(unit))


def si_zero(quantity: str, unit: str) -> float:
    """What is added after the factor: the zero of ``unit`` in SI."""
    return ZEROS.get((quantity, _spelt(unit)), 0.0)


def _spelt(unit: str) -> str:
    for written, meant in _SPELLINGS.items():
        unit = unit.replace(written, meant)
    return unit
