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

__all__ = [
    "CrimpInterchange",
    "IsotropicMembrane",
    "LinearTension",
    "MooneyRivlin",
    "NoShear",
    "ShearPolynomial",
    "ShearTable",
    "TabulatedTension",
]
