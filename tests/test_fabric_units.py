"""Units of fabric files."""

import math

import pytest

from warpdrape.materials.fabric_units import UNITS, si_factor


def test_units_of_the_field():
    assert si_factor("couple", "N mm") is None
    assert si_factor("couple", "N·mm") == si_factor("couple", "N.mm") == 1e-3
    assert si_factor("areal density", "g/m2") == 1e-3
    assert si_factor("yarns per length", "1/inch") == pytest.approx(39.3700787)
    # One, written in the larger unit and in the smaller: the same quantity.
    for quantity, one, many, count in (
        ("areal density", "kg/m²", "g/m²", 1000),
        ("length", "m", "cm", 100),
        ("length", "cm", "mm", 10),
        ("length", "mm", "µm", 1000),
        ("yarns per length", "1/mm", "1/cm", 10),
        ("yarns per length", "1/cm", "1/m", 100),
        ("force", "kN", "N", 1000),
        ("force", "N", "cN", 100),
        ("couple", "N·m", "N·cm", 100),
        ("couple", "N·cm", "N·mm", 10),
        ("couple", "N·mm", "mN·m", 1),
        ("bending stiffness", "N·m", "N·mm", 1000),
        ("bending stiffness", "N·mm", "mN·m", 1),
        ("bending stiffness", "mN·m", "µN·m", 1000),
        ("bending stiffness", "cN·cm²/cm", "µN·m", 100),
        ("bending stiffness", "cN·cm²/cm", "gf·cm²/cm", 1 / 0.980665),
        ("curvature", "1/mm", "1/cm", 10),
        ("curvature", "1/cm", "1/m", 100),
        ("moment per width", "N", "mN", 1000),
        ("moment per width", "N·m/m", "N·mm/mm", 1),
        ("moment per width", "cN·cm/cm", "mN", 10),
        ("moment per width", "gf·cm/cm", "cN·cm/cm", 0.980665),
        ("force per length", "N/mm", "kN/m", 1),
        ("force per length", "kN/m", "N/m", 1000),
        ("angle", "rad", "°", 180.0 / math.pi),
        ("angle", "deg", "°", 1),
        ("ratio", "-", "%", 100),
    ):
        assert si_factor(quantity, one) == pytest.approx(count * si_factor(quantity, many)), one
    for quantity, units in UNITS.items():
        assert 1.0 in units.values(), quantity
        assert all(si_factor(quantity, unit) == factor for unit, factor in units.items())
