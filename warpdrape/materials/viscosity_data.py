"""Viscosities and their shifts with temperature as kernels take them."""

from __future__ import annotations

from warpdrape.kernels.materials import viscosity as kernels
from warpdrape.materials.viscosity import (
    GAS_CONSTANT,
    WLF,
    Arrhenius,
    Cross,
    Newtonian,
    PowerLaw,
    ShiftLaw,
    ViscosityLaw,
)


def viscosity_struct(law: ViscosityLaw) -> kernels.Viscosity:
    """A viscosity for the kernels."""
    out = kernels.Viscosity()
    match law:
        case Newtonian():
            out.law, out.at_rest, out.rate, out.exponent = (
                kernels.NEWTONIAN,
                law.viscosity,
                1.0,
                1.0,
            )
        case PowerLaw():
            out.law, out.at_rest = kernels.POWER, law.at_rest
            out.rate, out.exponent = law.lowest_rate, law.exponent
        case Cross():
            out.law, out.at_rest, out.at_last = kernels.CROSS, law.at_rest, law.at_last
            out.rate, out.exponent = 1.0 / law.time, law.exponent
    return out


def shift_struct(law: ShiftLaw | None) -> kernels.Shift:
    """A shift of rates with temperature for the kernels."""
    out = kernels.Shift()
    if law is None:
        out.law = kernels.UNSHIFTED
        return out
    out.reference, out.lowest = law.reference_temperature, law.lowest_temperature
    match law:
        case Arrhenius():
            out.law, out.first = kernels.ARRHENIUS, law.activation_energy / GAS_CONSTANT
        case WLF():
            out.law, out.first, out.second = kernels.WLF, law.c1, law.c2
    return out
