"""The laws of fabrics and sheets, under the name that scene scripts import them by."""

from warpdrape.materials.laws import (
    CrimpInterchange,
    IsotropicMembrane,
    LinearTension,
    NoShear,
    ShearPolynomial,
    ShearTable,
    TabulatedTension,
)

__all__ = [
    "CrimpInterchange",
    "IsotropicMembrane",
    "LinearTension",
    "NoShear",
    "ShearPolynomial",
    "ShearTable",
    "TabulatedTension",
]
