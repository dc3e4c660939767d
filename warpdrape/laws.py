"""The laws of fabrics and sheets, under the name that scene scripts import them by."""

from warpdrape.materials.laws import (
    CrimpInterchange,
    IsotropicMembrane,
    LinearTension,
    MooneyRivlin,
    NoShear,
    ShearPolynomial,
    ShearTable,
    TabulatedTension,
)
from warpdrape.materials.viscosity import WLF, Arrhenius, Cross, Newtonian, PowerLaw

__all__ = [
    "WLF",
    "Arrhenius",
    "CrimpInterchange",
    "Cross",
    "IsotropicMembrane",
    "LinearTension",
    "MooneyRivlin",
    "Newtonian",
    "NoShear",
    "PowerLaw",
    "ShearPolynomial",
    "ShearTable",
    "TabulatedTension",
]
