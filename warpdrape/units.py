"""Factors to SI, so that scenes read ``75 * mm``."""

import math

m = 1.0
mm = 1e-3
um = 1e-6
kg = 1.0
g = 1e-3
s = 1.0
ms = 1e-3
us = 1e-6
N = 1.0
kN = 1e3
J = 1.0
rad = 1.0
deg = math.pi / 180.0
MPa = 1e6
GPa = 1e9
gsm = 1e-3
"""Gram per square metre in kg/m²."""
FREEZING = 273.15
"""0 °C in kelvin."""


def celsius(degrees: float) -> float:
    """Kelvin of a temperature in degrees Celsius."""
    return degrees + FREEZING
