"""The file of a unit cell: one table of names and values with units; and settings beside it."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from warpdrape.calibration.lab_units import si_value
from warpdrape.errors import InputError
from warpdrape.materials.fabric import STATUSES
from warpdrape.materials.fabric_file import Section, read_sections
from warpdrape.unit_cell.cell import FAMILIES, UnitCell, fibre_shares
from warpdrape.unit_cell.compaction import YarnCompaction
from warpdrape.unit_cell.loading import Loads
from warpdrape.unit_cell.weave import WEAVES, Weave, weave_of

TEXTS = ("name", "description", "weave", "section", "source", "status")
WHOLE = ("over", "under", "harness", "move", "points", "elements")
OF_A_FAMILY = {
    "spacing": "length",
    "yarns": "yarns per length",
    "width": "length",
    "height": "length",
    "crimp": "ratio",
    "linear_density": "linear density",
    "stiffness": "force",
    "bending": "yarn bending",
    "shear_tension": "force",
}
"""Names that may end in _warp or _weft; without it they are of both."""
OF_ALL = {
    "fibre_modulus": "pressure",
    "fibre_density": "density",
    "compaction_pressure": "pressure",
    "compaction_exponent": "ratio",
    "friction": "ratio",
    "sticking_angle": "angle",
    "largest_strain": "ratio",
    "largest_angle": "angle",
}
ASSUMED = {
    "bending": "0.1 N·mm²",
    "compaction_pressure": "5 kPa",
    "compaction_exponent": 8.0,
    "friction": 0.25,
    "sticking_angle": "1 °",
    "shear_tension": "1 N",
}
"""What is taken where nothing is given, and told on the card as assumed."""
MOST_ELEMENTS = 40


@dataclass(frozen=True, eq=False)
class Plan:
    """What a file of a unit cell asks for.

    Attributes:
        file: what messages call it.
        name: of the fabric.
        description: of it, in a line.
        source: where the values come from.
        status: of the values.
        cell: the cell.
        loads: what is done to it.
        linear_density: of a warp, a weft yarn [kg/m].
        fibre_density: of the fibres [kg/m³].
        fibre_share: of a warp, a weft yarn's section, as woven [-].
        elements: of a yarn from crossover to crossover.
        given: every name and value as given.
        assumed: names that were not given.
    """

    file: str
    name: str
    description: str
    source: str
    status: str
    cell: UnitCell
    loads: Loads
    linear_density: tuple[float, float]
    fibre_density: float
    fibre_share: tuple[float, float]
    elements: int
    given: Mapping[str, Any]
    assumed: tuple[str, ...]


def known_names() -> tuple[str, ...]:
    """Every name that a file may hold."""
    families = (f"{n}_{f}" for n in OF_A_FAMILY for f in FAMILIES)
    return (*TEXTS, *WHOLE, *OF_A_FAMILY, *families, *OF_ALL)


def read_cell(weave: str | os.PathLike[str], settings: Sequence[str] = ()) -> Plan:
    """Read a file of a unit cell, or take a weave by its name; with settings over it.

    Args:
        weave: a file that ends in .toml, or plain, twill or satin.
        settings: NAME=VALUE each.

    Raises:
        InputError: unknown names, values that are missing, have another unit or do not fit.
    """
    given = os.fspath(weave)
    if given in WEAVES:
        section = Section(given, {}, "", {"weave": given, "name": f"{given}_weave"})
    elif given.endswith(".toml") or Path(given).is_file():
        section = read_sections(Path(given), given)
    else:
        raise InputError(f"WEAVE = {given!r} must be {', '.join(WEAVES)} or a .toml file")
    own = _settings(settings)
    section = Section(section.file, section.lines, "", {**section.values, **own})
    try:
        section.check_keys(known_names())
        return _plan(section)
    except InputError as error:
        raise InputError(_placed(str(error), section, own)) from error


def _placed(text: str, section: Section, own: Mapping[str, Any]) -> str:
    """A complaint with the file's line, or with --set where the value is from there."""
    where = f"{section.file}, line "
    if not text.startswith(where):  # from a record, which knows no file
        named = [key for key in section.values if key in text]
        key = min(named, key=lambda name: (text.find(name), -len(name)), default="")
        line = section.lines.get(key, 1)
        text = f"{where}{line}: " + (f"key {key!r}: " if key else "") + text
    if any(f"key {key!r}" in text for key in own):
        return "--set: " + text.partition(": ")[2]
    if not section.lines:
        return f"{section.file}: " + text.partition(": ")[2]
    return text


def _settings(settings: Sequence[str]) -> dict[str, Any]:
    """NAME=VALUE, the value as in TOML or a bare text."""
    found: dict[str, Any] = {}
    for setting in settings:
        name, equals, text = setting.partition("=")
        name, text = name.strip(), text.strip()
        if not equals or not name or not text:
            raise InputError(f'--set {setting} must be NAME=VALUE, as --set width="4 mm"')
        try:
            found[name] = tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError:
            found[name] = text
    return found


def _plan(section: Section) -> Plan:
    texts = {name: section.text(name) for name in TEXTS}
    for name in ("name", "weave"):
        if not texts[name]:
            section.fail("", f"{name!r} (a text) is missing")
    status = texts["status"] or "assumed"
    if status not in STATUSES:
        section.fail("status", f"{status!r} must be one of {', '.join(STATUSES)}")
    numbers = {name: _whole(section, name) for name in WHOLE if name in section.values}
    shape = {n: v for n, v in numbers.items() if n not in ("points", "elements")}
    weave = weave_of(texts["weave"], **shape)
    assumed = tuple(name for name in ASSUMED if not _is_given(section, name))
    filled = replace(
        section, values={**{name: ASSUMED[name] for name in assumed}, **section.values}
    )
    pairs = {name: _pair(filled, name) for name in OF_A_FAMILY}
    single = {n: _si(filled, n, OF_ALL[n]) for n in OF_ALL if n in filled.values}
    mass = _needed(section, "linear_density", pairs)
    if "fibre_density" not in single:
        section.fail("", "'fibre_density' (such as 2.55 g/cm³) is missing")
    density = single["fibre_density"]
    cell = _cell(section, weave, texts["section"] or "lens", pairs, single, mass)
    loads = Loads(
        _needed(section, "shear_tension", pairs),
        single.get("largest_strain"),
        single.get("largest_angle"),
        numbers.get("points", 9),
    )
    elements = numbers.get("elements", 8)
    if elements % 2 or not 4 <= elements <= MOST_ELEMENTS:
        section.fail("elements", f"{elements} must be even and lie in 4 … {MOST_ELEMENTS}")
    return Plan(
        section.file,
        texts["name"],
        texts["description"],
        texts["source"],
        status,
        cell,
        loads,
        mass,
        density,
        _fibre_shares(cell, mass, density),
        elements,
        dict(section.values),
        assumed,
    )


def _fibre_shares(cell: UnitCell, mass: tuple[float, float], density: float) -> tuple[float, float]:
    areas = (mass[0] / density, mass[1] / density)
    return fibre_shares(cell.section, cell.width, cell.height, areas)


def _cell(
    section: Section,
    weave: Weave,
    form: str,
    pairs: Mapping[str, tuple],
    single: Mapping[str, float],
    mass: tuple[float, float],
) -> UnitCell:
    """The cell of what a file gives, and of what is assumed."""
    return UnitCell(
        weave=weave,
        spacing=_spacing(section, pairs),
        width=_needed(section, "width", pairs),
        height=_needed(section, "height", pairs),
        stiffness=_stiffness(section, pairs, single, mass),
        bending=_needed(section, "bending", pairs),
        compaction=YarnCompaction(single["compaction_pressure"], single["compaction_exponent"]),
        crimp=pairs["crimp"],
        section=form,
        friction=single["friction"],
        sticking_angle=single["sticking_angle"],
    )


def _whole(section: Section, name: str) -> int:
    value = section.values[name]
    if isinstance(value, bool) or not isinstance(value, int):
        section.fail(name, f"{value!r} must be a whole number")
    return value


def _is_given(section: Section, name: str) -> bool:
    return any(n in section.values for n in (name, f"{name}_warp", f"{name}_weft"))


def _si(section: Section, name: str, quantity: str) -> float:
    try:
        return si_value(name, section.values[name], quantity)
    except InputError as error:
        section.fail(name, str(error).removeprefix(f"{name} = "))


def _pair(section: Section, name: str) -> tuple[float | None, float | None]:
    """Of warp and weft; one value without a family is of both."""
    found = []
    for family in FAMILIES:
        own = f"{name}_{family}"
        key = own if own in section.values else name
        found.append(_si(section, key, OF_A_FAMILY[name]) if key in section.values else None)
    return found[0], found[1]


def _needed(section: Section, name: str, pairs: Mapping[str, tuple]) -> tuple[float, float]:
    for family, value in zip(FAMILIES, pairs[name], strict=True):
        if value is None:
            section.fail("", f"'{name}' or '{name}_{family}' ({OF_A_FAMILY[name]}) is missing")
        if value <= 0.0:
            key = name if name in section.values else f"{name}_{family}"
            section.fail(key, f"{section.values[key]} must be above zero")
    return pairs[name]


def _spacing(section: Section, pairs: Mapping[str, tuple]) -> tuple[float, float]:
    """Between yarns of a family [m], given as such or as yarns per length."""
    found = []
    for k, family in enumerate(FAMILIES):
        spacing, yarns = pairs["spacing"][k], pairs["yarns"][k]
        if (spacing is None) == (yarns is None):
            section.fail("", f"give either 'spacing_{family}' or 'yarns_{family}', or of both")
        value = spacing if yarns is None else (1.0 / yarns if yarns > 0.0 else -1.0)
        if value <= 0.0:
            section.fail("", f"spacing_{family} and yarns_{family} must be above zero")
        found.append(value)
    return found[0], found[1]


def _stiffness(
    section: Section,
    pairs: Mapping[str, tuple],
    single: Mapping[str, float],
    mass: tuple[float, float],
) -> tuple[float, float]:
    """EA [N], given as such, or fibre modulus times mass per length over density."""
    found = []
    for k, family in enumerate(FAMILIES):
        value = pairs["stiffness"][k]
        if value is None:
            if "fibre_modulus" not in single:
                section.fail("", f"give 'fibre_modulus', or 'stiffness_{family}' (EA of a yarn)")
            value = single["fibre_modulus"] * mass[k] / single["fibre_density"]
        found.append(value)
    return found[0], found[1]
