"""What a fabric's card says of its matrix: values, what follows from them, and a plot."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING

import numpy as np

from warpdrape.materials.fabric import Fabric
from warpdrape.materials.matrix import Matrix
from warpdrape.materials.viscosity import Cross, Newtonian, PowerLaw

if TYPE_CHECKING:
    from matplotlib.axes import Axes

RATES = (0.01, 0.1, 1.0)
"""Rates of the shear angle at which a card tells the couple [1/s]."""
NAMES = {Newtonian: "Newtonian", PowerLaw: "power law", Cross: "Cross"}
_UNITS = {
    "viscosity": "Pa·s",
    "at_rest": "Pa·s",
    "at_last": "Pa·s",
    "reference_rate": "1/s",
    "lowest_rate": "1/s",
    "time": "s",
    "activation_energy": "J/mol",
    "reference_temperature": "K",
    "lowest_temperature": "K",
    "c2": "K",
    "capacity": "J/(m²·K)",
    "conductance": "W/(m²·K)",
    "between": "W/(m²·K)",
}
"""Of the values that have one."""


def matrix_values(matrix: Matrix) -> list[tuple[str, str]]:
    """Names and SI values of a matrix, in the order of a card."""
    parts = {"matrix": matrix.viscosity, "matrix.shift": matrix.shift, "matrix.heat": matrix.heat}
    values = [
        (f"{path}.{field.name}", f"{getattr(part, field.name):.5g} {_UNITS.get(field.name, '')}")
        for path, part in parts.items()
        if part is not None
        for field in fields(part)
        if getattr(part, field.name) is not None
    ]
    if any(matrix.rise):
        values.append(("matrix.rise", "({:g}, {:g})".format(*matrix.rise)))
    if matrix.modulus is not None:
        values.append(("matrix.modulus", f"{matrix.modulus:.4g} Pa"))
    return [(name, text.rstrip()) for name, text in values]


def matrix_rows(fabric: Fabric) -> list[tuple[str, str]]:
    """What follows from the values of a fabric's matrix, none where it has none."""
    matrix = fabric.matrix
    if matrix is None:
        return []
    rows = []
    for rate in RATES:
        couple = fabric.thickness * float(matrix.stress(0.0, rate))
        rows.append((f"viscous couple per area at {rate:g} 1/s", f"{couple:.4g} N/m"))
    if matrix.heat is not None:
        rows.append(("time to cool on one tool, to 1/e", f"{1.0 / matrix.heat.rate:.3g} s"))
    return rows


def plot_matrix(fabric: Fabric, matrix: Matrix, axes: Axes) -> None:
    """Draw the viscous couple over the rate, at some temperatures if it depends on them."""
    rates = np.logspace(-3, 1, 161)
    shift = matrix.shift
    temperatures: list[float | None] = [None]
    if shift is not None:
        lowest, reference = shift.lowest_temperature, shift.reference_temperature
        temperatures = [lowest, 0.5 * (lowest + reference), reference]
    for temperature in temperatures:
        couples = fabric.thickness * matrix.stress(0.0, rates, temperature)
        words = None if temperature is None else f"{temperature - 273.15:.0f} °C"
        axes.loglog(rates, couples, label=words)
    axes.set(title="Viscous couple", xlabel="rate of the shear angle [1/s]")
    axes.set(ylabel="couple per area at 0° [N/m]")
    if shift is not None:
        axes.legend(frameon=False, fontsize="small")
