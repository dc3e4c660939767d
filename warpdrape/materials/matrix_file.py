"""The matrix of a prepreg in a fabric file."""

from __future__ import annotations

from typing import Any

from warpdrape.errors import InputError
from warpdrape.materials.fabric import Source
from warpdrape.materials.fabric_file import Section, read_law
from warpdrape.materials.matrix import Heat, Matrix
from warpdrape.materials.viscosity import (
    WLF,
    Arrhenius,
    Cross,
    Newtonian,
    PowerLaw,
    ShiftLaw,
    ViscosityLaw,
)

LAWS = {
    "newtonian": {"viscosity": "viscosity"},
    "power": {
        "viscosity": "viscosity",
        "exponent": "ratio",
        "reference_rate": "rate",
        "lowest_rate": "rate",
    },
    "cross": {
        "at_rest": "viscosity",
        "at_last": "viscosity",
        "time": "time",
        "exponent": "ratio",
    },
}
SHIFTS = {
    "arrhenius": {
        "activation_energy": "energy per amount",
        "reference_temperature": "temperature",
        "lowest_temperature": "temperature",
    },
    "wlf": {
        "c1": "ratio",
        "c2": "temperature difference",
        "reference_temperature": "temperature",
        "lowest_temperature": "temperature",
    },
}
HEAT = {
    "capacity": "heat capacity per area",
    "conductance": "conductance",
    "between": "conductance",
    "emissivity": "ratio",
}
OPTIONAL_HEAT = ("between", "emissivity")
_VISCOSITIES = {"newtonian": Newtonian, "power": PowerLaw, "cross": Cross}
_SHIFT_LAWS = {"arrhenius": Arrhenius, "wlf": WLF}


def read_matrix(file: Section, sources: dict[str, Source]) -> Matrix | None:
    """Return the matrix that a fabric file describes, None where it has none.

    Args:
        file: the whole file.
        sources: by dotted names of values; added to.
    """
    if "matrix" not in file.values:
        return None
    others = ("shift", "rise", "modulus", "heat")
    section, law, values = read_law(file, "matrix", LAWS, sources, others)
    viscosity: ViscosityLaw = _made(section, _VISCOSITIES[law], _single(section, values))
    given: dict[str, Any] = {"viscosity": viscosity}
    if "shift" in section.values:
        inner, kind, values = read_law(section, "shift", SHIFTS, sources)
        shift: ShiftLaw = _made(inner, _SHIFT_LAWS[kind], _single(inner, values))
        given["shift"] = shift
    if "rise" in section.values:
        rise, sources["matrix.rise"] = section.quantity("rise", "ratio")
        if isinstance(rise, float) or rise.shape != (2,):
            section.fail("rise.value", "must be two numbers, of γ² and γ⁴")
        given["rise"] = tuple(map(float, rise))
    if "modulus" in section.values:
        given["modulus"], sources["matrix.modulus"] = section.number("modulus", "pressure")
    if "heat" in section.values:
        inner, found = section.section("heat", tuple(HEAT)), {}
        for name, kind in HEAT.items():
            if name in OPTIONAL_HEAT and name not in inner.values:
                continue
            found[name], sources[f"matrix.heat.{name}"] = inner.number(name, kind)
        given["heat"] = _made(inner, Heat, found)
    return _made(section, Matrix, given)


def _single(section: Section, values: dict[str, Any]) -> dict[str, float]:
    """The values of a law, each of which must be one number."""
    for name, value in values.items():
        if not isinstance(value, float):
            section.fail(f"{name}.value", "must be one number")
    return values


def _made(section: Section, kind: type, values: dict[str, Any]) -> Any:
    """A record of values; what it refuses is said at the key that it names."""
    try:
        return kind(**values)
    except InputError as error:
        section.blame(error)
