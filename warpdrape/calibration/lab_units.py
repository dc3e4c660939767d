"""Units as laboratories write them, in headers of columns and beside values."""

from __future__ import annotations

import math
import re

from warpdrape.errors import InputError
from warpdrape.materials.fabric_units import UNITS, si_factor

GRAM_FORCE = 9.80665e-3
"""N."""
_MORE: dict[str, dict[str, float]] = {
    "length": {"inch": 0.0254, "in": 0.0254, "um": 1e-6},
    "force": {"mN": 1e-3, "gf": GRAM_FORCE, "kgf": 1e3 * GRAM_FORCE, "lbf": 4.4482216152605},
    "force per length": {
        "gf/cm": GRAM_FORCE * 1e2,
        "cN/cm": 1.0,
        "N/cm": 1e2,
        "mN/mm": 1.0,
        "N/5cm": 20.0,
        "N/50mm": 20.0,
    },
    "linear density": {"kg/m": 1.0, "g/m": 1e-3, "g/km": 1e-6, "tex": 1e-6, "ktex": 1e-3},
    "yarn bending": {"N·m²": 1.0, "N·mm²": 1e-6, "mN·mm²": 1e-9, "cN·cm²": 1e-6},
    "pressure": {
        "GPa": 1e9,
        "N/m²": 1.0,
        "N/mm²": 1e6,
        "mbar": 1e2,
        "gf/cm²": 98.0665,
        "psi": 6894.757293168,
    },
    "angle": {"grad": math.pi / 180, "degree": math.pi / 180, "degrees": math.pi / 180},
    "ratio": {"mm/mm": 1.0, "m/m": 1.0, "percent": 1e-2, "‰": 1e-3, "1": 1.0},
    "speed": {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2, "mm/min": 1e-3 / 60, "m/min": 1 / 60},
    "time": {"s": 1.0, "sec": 1.0, "ms": 1e-3, "min": 60.0},
    "compliance": {"m/N": 1.0, "mm/N": 1e-3, "µm/N": 1e-6, "mm/kN": 1e-6, "µm/kN": 1e-9},
    "area": {"mm²": 1e-6, "cm²": 1e-4, "m²": 1.0, "mm2": 1e-6, "cm2": 1e-4, "m2": 1.0},
    "count": {"": 1.0, "-": 1.0},
}
_WITH_UNIT = re.compile(r"\s*([-+]?[0-9]*[.,]?[0-9]+(?:[eE][-+]?[0-9]+)?)\s*(\S.*?)\s*")


def lab_factor(quantity: str, unit: str) -> float | None:
    """Factor from a unit as written to SI, None where it is no unit of the quantity.

    Letters' case is passed over where that leaves one unit only.

    Args:
        quantity: such as "force"; see `known_units`.
        unit: without brackets.
    """
    unit = unit.strip()
    more = _MORE.get(quantity, {})
    if unit in more:
        return more[unit]
    found = si_factor(quantity, unit) if quantity in UNITS else None
    if found is not None:
        return found
    alike = {f for u, f in _all(quantity).items() if u.lower() == unit.lower()}
    if unit[:1] in "mM" and unit[1:]:  # milli or mega: not to be guessed
        alike = {f for u, f in _all(quantity).items() if u[:1] == unit[:1]} & alike
    return alike.pop() if len(alike) == 1 else None


def known_units(quantity: str) -> str:
    """The units of a quantity, for messages."""
    return ", ".join(u for u in _all(quantity) if u)


def quantities_of(unit: str) -> list[str]:
    """Every quantity of which this may be a unit."""
    return [q for q in {**UNITS, **_MORE} if unit and lab_factor(q, unit) is not None]


def si_value(name: str, value: object, quantity: str) -> float:
    """A number with its unit in a text, such as "100 mm", in SI.

    A number alone is taken where the quantity has no unit.

    Raises:
        InputError: it is something else, or the unit is unknown.
    """
    plain = quantity in ("ratio", "count")
    if isinstance(value, int | float) and not isinstance(value, bool) and plain:
        number, unit = float(value), "-"
    else:
        found = _WITH_UNIT.fullmatch(value) if isinstance(value, str) else None
        if found is None:
            example = next(u for u in _all(quantity) if u)
            raise InputError(
                f"{name} = {value!r} must be a number with its unit in a text, as "
                f'"2.5 {example}" (known: {known_units(quantity)})'
            )
        number, unit = float(found[1].replace(",", ".")), found[2]
    factor = lab_factor(quantity, unit)
    if factor is None:
        raise InputError(
            f"{name} = {value!r}: {unit!r} is no unit of {quantity}; known: {known_units(quantity)}"
        )
    if not math.isfinite(number):
        raise InputError(f"{name} = {value!r} must be finite")
    return factor * number


def _all(quantity: str) -> dict[str, float]:
    return {**UNITS.get(quantity, {}), **_MORE.get(quantity, {})}
