"""The fabric library: bundled fabric files, and a user's own of the same form."""

from __future__ import annotations

import math
import os
import warnings
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from warpdrape.errors import InputError, one_of, said
from warpdrape.materials.bending import Bending, BendingCurve, from_flexural_length
from warpdrape.materials.compaction import Compaction
from warpdrape.materials.crossover import Crossover
from warpdrape.materials.fabric import Fabric, Source
from warpdrape.materials.fabric_file import Section, read_law, read_sections
from warpdrape.materials.laws import (
    CrimpInterchange,
    IsotropicMembrane,
    LinearTension,
    MooneyRivlin,
    NoShear,
    ShearLaw,
    ShearPolynomial,
    ShearTable,
    TabulatedTension,
    TensionLaw,
    Unwoven,
)
from warpdrape.materials.matrix_file import read_matrix

Sources = dict[str, Source]

_TEXTS = ("name", "description", "doubts")
_LAWS = ("tension", "shear", "bending", "compaction", "crossover", "matrix")
_SCALARS = {
    "areal_density": "areal density",
    "thickness": "length",
    "compressive_factor": "ratio",
    "yarn_angle": "angle",
    "fibre_density": "density",
    "locking_angle": "angle",
    "failure_strain_warp": "ratio",
    "failure_strain_weft": "ratio",
}
_CELL = {
    "yarns_warp": "yarns per length",
    "yarns_weft": "yarns per length",
    "cell_warp": "length",
    "cell_weft": "length",
}
_TENSION_KEYS = {
    "linear": {"warp": "force", "weft": "force"},
    "table": {
        "strain_warp": "ratio",
        "strain_weft": "ratio",
        "tension_warp": "force",
        "tension_weft": "force",
    },
    "crimp": {
        "crimp_warp": "ratio",
        "crimp_weft": "ratio",
        "stiffness_warp": "force",
        "stiffness_weft": "force",
    },
    "isotropic": {"stiffness": "force per length", "poisson": "ratio"},
    "rubber": {"c10": "pressure", "c01": "pressure", "largest_stretch": "ratio"},
}
_BENDING = {
    "warp": "bending stiffness",
    "weft": "bending stiffness",
    "twist": "bending stiffness",
    "flexural_length_warp": "length",
    "flexural_length_weft": "length",
}
_BENDING_CURVE = {
    "curvatures": "curvature",
    "moments_warp": "moment per width",
    "moments_weft": "moment per width",
    "in_plane_warp": "bending stiffness",
    "in_plane_weft": "bending stiffness",
    "twist": "bending stiffness",
    "friction_warp": "moment per width",
    "friction_weft": "moment per width",
    "friction_curvature": "curvature",
}
"""The first three must be given."""
_COMPACTION = {
    "table": {"thicknesses": "length", "pressures": "pressure"},
    "power": {
        "coefficient": "ratio",
        "exponent": "ratio",
        "fibre_density": "density",
        "largest_pressure": "pressure",
    },
}
_CROSSOVER = {
    "slip_force_warp": "force",
    "slip_force_weft": "force",
    "stiffness_warp": "force per length",
    "stiffness_weft": "force per length",
    "friction": "ratio",
    "yarn_friction": "ratio",
}
_MAY_RUB = ("friction", "yarn_friction")
"""Those of it that may be left out."""
SOFTEST_YARN, STIFFEST_YARN = 1e6, 4e8
"""Stiffness of yarns over their mass per length, E/ρ of their fibres, that is plausible [m²/s²]."""
_SHEAR_KEYS = {
    "polynomial": {"coefficients": "couple"},
    "table": {"angles": "angle", "couples": "couple"},
    "none": {},
}


def fabric_names() -> list[str]:
    """Names of the bundled fabrics, sorted."""
    files = resources.files("warpdrape.fabrics").iterdir()
    return sorted(f.name.removesuffix(".toml") for f in files if f.name.endswith(".toml"))


def load_fabric(name_or_path: str | os.PathLike[str]) -> Fabric:
    """Return a bundled fabric by name, or one read from a user's file.

    Args:
        name_or_path: a bundled name, or a path that exists or ends in ``.toml``.

    Raises:
        InputError: unknown name (the nearest known one is given), or a file with a fault (file,
            line and key are given).
    """
    if not isinstance(name_or_path, str | os.PathLike):
        raise InputError(f"fabric = {said(name_or_path)} must be a name or the path of a file")
    given = os.fspath(name_or_path)
    names = fabric_names()
    if given not in names and (given.endswith(".toml") or os.path.isfile(given)):
        return _fabric(read_sections(Path(given), given))
    name = one_of("fabric", given, names)
    bundled = resources.files("warpdrape.fabrics").joinpath(f"{name}.toml")
    with resources.as_file(bundled) as path:
        return _fabric(read_sections(path, f"{name}.toml"))


def with_bending(fabric: Fabric | str | os.PathLike[str], choice: str | float) -> Fabric:
    """Return a fabric with its own bending, none, or one stiffness in all directions.

    Args:
        fabric: a fabric, or its name or file.
        choice: "fabric", "none", or a stiffness [N·m], also as text.

    Raises:
        InputError: for anything else.
    """
    fabric = fabric if isinstance(fabric, Fabric) else load_fabric(fabric)
    if choice == "fabric":
        return fabric
    if choice == "none":
        return replace(fabric, bending=None)
    try:
        stiffness = float(choice)
    except (TypeError, ValueError):
        raise InputError(
            f"bending = {said(choice)} must be 'fabric', 'none' or a stiffness [N·m], as 0.001"
        ) from None
    return replace(fabric, bending=Bending.isotropic(stiffness))


def _fabric(file: Section) -> Fabric:
    """Build the fabric that a file describes."""
    file.check_keys((*_TEXTS, *_SCALARS, *_CELL, *_LAWS))
    file.require("name", str, "a text")
    sources: Sources = {}
    isotropic = file.section("tension").values.get("law") in ("isotropic", "rubber")
    required = {"areal_density", "thickness"}
    values: dict[str, Any] = {}
    for key, kind in _SCALARS.items():
        if key in required or key in file.values:
            values[key], sources[key] = file.number(key, kind)
    if not isotropic:
        values |= _cell(file, values.get("yarn_angle", math.pi / 2), sources)
    tension = _tension(file, values, sources)
    shear = _shear(file, sources)
    bending = _bending(file, values, tension, sources)
    compaction = _compaction(file, values, sources)
    crossover = _crossover(file, sources)
    _one_fibre_density(file, values, sources)
    matrix = read_matrix(file, sources)
    try:
        fabric = Fabric(
            name=file.text("name"),
            description=file.text("description"),
            doubts=_doubts(file),
            tension=tension,
            shear=shear,
            bending=bending,
            compaction=compaction,
            matrix=matrix,
            crossover=crossover,
            sources=sources,
            **values,
        )
    except InputError as error:
        file.blame(error)
    for words in odd_yarns(fabric):
        warnings.warn(f"{file.file}: {words}", stacklevel=3)
    return fabric


def odd_yarns(fabric: Fabric) -> list[str]:
    """Yarns far stiffer or softer for their mass than any fibre, in words: a unit is wrong, likely.

    Each family is taken to have half of the fabric's mass.

    Args:
        fabric: with linear or crimp-interchange yarns; others are not looked at.
    """
    law = fabric.tension
    if isinstance(law, LinearTension):
        stiffness = (law.warp, law.weft)
    elif isinstance(law, CrimpInterchange):
        stiffness = (law.stiffness_warp, law.stiffness_weft)
    else:
        return []
    found = []
    for name, each, width in zip(("warp", "weft"), stiffness, fabric.yarn_width, strict=True):
        specific = each / (0.5 * fabric.areal_density * width)
        if not SOFTEST_YARN <= specific <= STIFFEST_YARN:
            found.append(
                f"{name} yarns of {1e-3 * each:.4g} kN, {0.01 / width:.4g} per cm, are "
                f"{specific:.2g} m²/s² stiff for their mass (carbon 1.3e8, glass 3e7): check the "
                "stiffness, the yarns per length, the areal density and their units"
            )
    return found


def _doubts(file: Section) -> tuple[str, ...]:
    doubts = file.values.get("doubts", [])
    if not isinstance(doubts, list) or not all(isinstance(d, str) for d in doubts):
        file.fail("doubts", "must be an array of texts")
    return tuple(" ".join(d.split()) for d in doubts)


def _cell(file: Section, yarn_angle: float, sources: Sources) -> dict[str, float]:
    """Lengths of the unit cell [m], given as such or as yarns per length of the sheet."""
    cell = {}
    for along, across in (("warp", "weft"), ("weft", "warp")):
        length, count = f"cell_{along}", f"yarns_{across}"
        if (length in file.values) == (count in file.values):
            file.fail(count if count in file.values else "", f"give either {count!r} or {length!r}")
        key = length if length in file.values else count
        value, sources[length] = file.number(key, _CELL[key])
        if value <= 0.0:
            file.fail(f"{key}.value", f"{sources[length].given} must be above zero")
        cell[length] = value
        if key == count:
            cell[length] = 1.0 / (value * math.sin(yarn_angle))
            given = f"{across} yarns: {sources[length].given}"
            sources[length] = replace(sources[length], given=given)
    return cell


def _tension(file: Section, cell: dict[str, float], sources: Sources) -> TensionLaw:
    section, law, values = read_law(file, "tension", _TENSION_KEYS, sources)
    try:
        match law:
            case "linear":
                return LinearTension(**values)
            case "table":
                return TabulatedTension(**values)
            case "crimp":
                return CrimpInterchange(cell["cell_warp"], cell["cell_weft"], **values)
            case "rubber":
                return MooneyRivlin(**values)
            case _:
                return IsotropicMembrane(**values)
    except InputError as error:
        section.blame(error)


def _shear(file: Section, sources: Sources) -> ShearLaw:
    if "shear" not in file.values:
        return NoShear()
    section, law, values = read_law(file, "shear", _SHEAR_KEYS, sources)
    if isinstance(values.get("coefficients"), float):
        section.fail("coefficients.value", "must be an array of numbers")
    try:
        match law:
            case "polynomial":
                return ShearPolynomial(tuple(map(float, values["coefficients"])))
            case "table":
                return ShearTable(**values)
            case _:
                return NoShear()
    except InputError as error:
        section.blame(error)


def _bending(
    file: Section, values: dict[str, Any], tension: TensionLaw, sources: Sources
) -> Bending | BendingCurve | None:
    """Bending as stiffness or flexural length per family; of a solid isotropic sheet its own."""
    if "bending" not in file.values:
        return None
    section = file.section("bending")
    law = section.text("law") or "linear"
    isotropic = isinstance(tension, Unwoven)
    laws = ("linear", "solid") if isotropic else ("linear", "curve")
    if law not in laws:
        section.fail("law", f"{law!r} is unknown here; known: {', '.join(laws)}")
    keys = {"linear": _BENDING, "curve": _BENDING_CURVE, "solid": ()}[law]
    section.check_keys(("law", *keys))
    if law == "curve":
        return _bending_curve(section, sources)
    if law == "solid":
        thickness = values["thickness"]
        if isinstance(tension, MooneyRivlin):
            return Bending.of_sheet(3.0 * tension.shear_modulus * thickness, 0.5, thickness)
        if isinstance(tension, IsotropicMembrane):
            return Bending.of_sheet(tension.stiffness, tension.poisson, thickness)
    found: dict[str, float] = {}
    for family in ("warp", "weft"):
        length = f"flexural_length_{family}"
        if (family in section.values) == (length in section.values):
            key = length if length in section.values else ""
            section.fail(key, f"give either {family!r} or {length!r}")
        key = length if length in section.values else family
        found[family], source = section.number(key, _BENDING[key])
        if key == length:
            source = replace(source, given=f"flexural length {source.given}")
            found[family] = from_flexural_length(found[family], values["areal_density"])
        sources[f"bending.{family}"] = source
    if "twist" in section.values:
        found["twist"], sources["bending.twist"] = section.number("twist", _BENDING["twist"])
    try:
        return Bending(**found)
    except InputError as error:
        section.blame(error)


def _compaction(file: Section, values: dict[str, Any], sources: Sources) -> Compaction | None:
    if "compaction" not in file.values:
        return None
    section, law, found = read_law(file, "compaction", _COMPACTION, sources)
    try:
        if law == "table":
            return Compaction(**found)
        numbers = {key: float(np.asarray(value).item()) for key, value in found.items()}
        return Compaction.power_law(
            areal_density=values["areal_density"], thickness=values["thickness"], **numbers
        )
    except ValueError as error:
        section.fail("", f"coefficient, exponent, fibre_density, largest_pressure: {error}")
    except InputError as error:
        section.blame(error)


def _crossover(file: Section, sources: Sources) -> Crossover | None:
    if "crossover" not in file.values:
        return None
    section, found = file.section("crossover", tuple(_CROSSOVER)), {}
    for key, kind in _CROSSOVER.items():
        if key not in _MAY_RUB or key in section.values:
            found[key], sources[f"crossover.{key}"] = section.number(key, kind)
    try:
        return Crossover(**found)
    except InputError as error:
        section.blame(error)


def _one_fibre_density(file: Section, values: dict[str, Any], sources: Sources) -> None:
    """Take the fibres' density from the compaction law where it is given there alone."""
    if "compaction.fibre_density" not in sources:
        return
    section = file.section("compaction")
    density, source = section.quantity("fibre_density", "density")
    density = float(np.asarray(density).item())
    own = values.setdefault("fibre_density", density)
    sources.setdefault("fibre_density", source)
    if not math.isclose(own, density, rel_tol=1e-6):
        section.fail(
            "fibre_density.value",
            f"{density:.6g} kg/m³, the fabric's fibre_density is {own:.6g}: give both the same",
        )


def _bending_curve(section: Section, sources: Sources) -> BendingCurve:
    found: dict[str, Any] = {}
    for key, kind in _BENDING_CURVE.items():
        if key in section.values or key in ("curvatures", "moments_warp", "moments_weft"):
            found[key], sources[f"bending.{key}"] = section.quantity(key, kind)
    for name, default in (("in_plane", None), ("friction", 0.0)):
        pair = [found.pop(f"{name}_{family}", default) for family in ("warp", "weft")]
        if None not in pair:
            found[name] = tuple(pair)
        elif pair != [None, None]:
            section.fail("", f"give {name!r} of both warp and weft")
    try:
        return BendingCurve(**found)
    except InputError as error:
        section.blame(error)
