"""The card of a fabric: every value with unit, status, source and doubts; and its curves."""

from __future__ import annotations

import math
import os
import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from warpdrape.materials.bending import GRAVITY, Bending, BendingCurve
from warpdrape.materials.crossover import Crossover
from warpdrape.materials.fabric import Fabric, Source
from warpdrape.materials.law_curves import sample_tensions
from warpdrape.materials.law_data import initial_shear_stiffness, shear_stiffness
from warpdrape.materials.laws import (
    CrimpInterchange,
    IsotropicMembrane,
    LinearTension,
    MooneyRivlin,
    NoShear,
    ShearTable,
    TabulatedTension,
    TensionLaw,
    Unwoven,
)
from warpdrape.materials.matrix_card import NAMES, matrix_rows, matrix_values, plot_matrix

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTH = 96
"""Columns of a card."""
_TENSION_NAMES = {
    LinearTension: "linear yarns",
    TabulatedTension: "table of biaxial tensions",
    CrimpInterchange: "crimp interchange",
    IsotropicMembrane: "isotropic membrane in place of yarns",
    MooneyRivlin: "incompressible rubber (Mooney–Rivlin) in place of yarns",
}


def card(fabric: Fabric) -> str:
    """Return the card of a fabric as text for a terminal."""
    notes: list[tuple[str, str]] = []
    rows: list[tuple[str, ...]] = [("value", "as given", "SI", "status", "note")]
    for name, value in _values(fabric):
        source = fabric.sources.get(name)
        status = source.status if source else "not stated"
        given = source.given if source and source.given else "-"
        rows.append((name, given, value, status, _note(source, notes)))
    parts = [_heading(fabric), _table(rows), _table(_derived(fabric))]
    if notes:
        parts.append(_numbered(notes))
    if fabric.doubts:
        parts.append("\n".join(["Doubts", *(_wrap("  - ", d) for d in fabric.doubts)]))
    return "\n\n".join(parts)


def _heading(fabric: Fabric) -> str:
    lines = [fabric.name]
    if fabric.description:
        lines.append(textwrap.fill(fabric.description, WIDTH))
    shear = fabric.shear
    couple = "no shear stiffness" if isinstance(shear, NoShear) else "odd polynomial"
    if isinstance(shear, ShearTable):
        couple = "curve through points"
    if isinstance(fabric.tension, Unwoven):
        couple = "that of the membrane"
    laws = f"tension: {_TENSION_NAMES[type(fabric.tension)]}; shear: {couple}"
    if fabric.matrix is not None:
        laws += f", beside a viscous matrix: {NAMES[type(fabric.matrix.viscosity)]}"
    lines.append(laws)
    return "\n".join(lines)


def _values(fabric: Fabric) -> list[tuple[str, str]]:
    """Names and SI values of a fabric, in the order of its card."""
    values = [
        ("areal_density", f"{fabric.areal_density:.4g} kg/m²"),
        ("thickness", f"{fabric.thickness:.4g} m"),
    ]
    if fabric.fibre_density is not None:
        values.append(("fibre_density", f"{fabric.fibre_density:.4g} kg/m³"))
    yarns = not isinstance(fabric.tension, Unwoven)
    if yarns:
        values += [
            ("cell_warp", f"{fabric.cell_warp:.4g} m"),
            ("cell_weft", f"{fabric.cell_weft:.4g} m"),
            ("compressive_factor", f"{fabric.compressive_factor:.4g}"),
        ]
    if "yarn_angle" in fabric.sources or abs(fabric.yarn_angle - math.pi / 2) > 1e-12:
        values.append(("yarn_angle", f"{fabric.yarn_angle:.4g} rad"))
    if fabric.locking_angle is not None:
        values.append(("locking_angle", f"{fabric.locking_angle:.4g} rad"))
    for name in ("failure_strain_warp", "failure_strain_weft"):
        if getattr(fabric, name) is not None:
            values.append((name, f"{getattr(fabric, name):.4g}"))
    values += [(f"tension.{name}", text) for name, text in _tension_values(fabric.tension)]
    if isinstance(fabric.shear, ShearTable):
        angles, couples = np.asarray(fabric.shear.angles), fabric.shear.couples
        values.append(("shear.angles", f"{angles.size} points to {angles[-1]:.4g} rad"))
        values.append(("shear.couples", f"to {couples[-1]:.4g} N·m"))
    elif not isinstance(fabric.shear, NoShear):
        terms = fabric.shear.coefficients
        shown = "(" + ", ".join(f"{c:.5g}" for c in terms) + ") N·m"
        source = fabric.sources.get("shear.coefficients")
        if source and source.given:
            shown = "of " + ", ".join(("γ", "γ³", "γ⁵", "γ⁷")[: len(terms)])
        values.append(("shear.coefficients", shown))
    if isinstance(fabric.bending, BendingCurve):
        curve = fabric.bending
        count, last = len(curve.curvatures), curve.curvatures[-1]
        values.append(("bending.curvatures", f"{count} points to {last:.4g} 1/m"))
        for family in ("warp", "weft"):
            moment = getattr(curve, f"moments_{family}")[-1]
            values.append((f"bending.moments_{family}", f"to {moment:.4g} N"))
        if any(curve.friction):
            values.append(("bending.friction_warp", f"{curve.friction[0]:.4g} N"))
            values.append(("bending.friction_weft", f"{curve.friction[1]:.4g} N"))
    elif fabric.bending is not None:
        stated = ("warp", "weft", *(n for n in ("twist",) if f"bending.{n}" in fabric.sources))
        values += [(f"bending.{n}", f"{getattr(fabric.bending, n):.4g} N·m") for n in stated]
    if fabric.compaction is not None:
        law = fabric.compaction
        if "compaction.coefficient" in fabric.sources:
            values += [
                (f"compaction.{n}", fabric.sources[f"compaction.{n}"].given)
                for n in ("coefficient", "exponent", "fibre_density", "largest_pressure")
            ]
        else:
            values.append(("compaction.thicknesses", f"to {law.thinnest:.4g} m"))
            values.append(("compaction.pressures", f"to {law.pressures[-1]:.4g} Pa"))
    if fabric.matrix is not None:
        values += matrix_values(fabric.matrix)
    if fabric.crossover is not None:
        values += _crossover_values(fabric.crossover, fabric.sources)
    return values


def _crossover_values(law: Crossover, sources: Mapping[str, Source]) -> list[tuple[str, str]]:
    families = ("warp", "weft")
    values = [(f"crossover.slip_force_{f}", f"{law.slip(f):.4g} N") for f in families]
    values += [(f"crossover.stiffness_{f}", f"{law.stiffness(f):.4g} N/m") for f in families]
    for name in ("friction", "yarn_friction"):
        if getattr(law, name) or f"crossover.{name}" in sources:
            values.append((f"crossover.{name}", f"{getattr(law, name):.4g}"))
    return values


def _tension_values(law: TensionLaw) -> list[tuple[str, str]]:
    match law:
        case LinearTension():
            return [("warp", f"{law.warp:.6g} N"), ("weft", f"{law.weft:.6g} N")]
        case TabulatedTension():
            axes = [(n, getattr(law, n)) for n in ("strain_warp", "strain_weft")]
            tables = [(n, getattr(law, n)) for n in ("tension_warp", "tension_weft")]
            return [(n, f"{a.size} from {a[0]:.4g} to {a[-1]:.4g}") for n, a in axes] + [
                (n, f"{t.min():.4g} to {t.max():.4g} N") for n, t in tables
            ]
        case CrimpInterchange():
            return [
                ("crimp_warp", f"{law.crimp_warp:.4g}"),
                ("crimp_weft", f"{law.crimp_weft:.4g}"),
                ("stiffness_warp", f"{law.stiffness_warp:.6g} N"),
                ("stiffness_weft", f"{law.stiffness_weft:.6g} N"),
            ]
        case MooneyRivlin():
            return [
                ("c10", f"{law.c10:.6g} Pa"),
                ("c01", f"{law.c01:.6g} Pa"),
                ("largest_stretch", f"{law.largest_stretch:.4g}"),
            ]
        case _:
            return [("stiffness", f"{law.stiffness:.4g} N/m"), ("poisson", f"{law.poisson:.4g}")]


def _derived(fabric: Fabric) -> list[tuple[str, ...]]:
    """What follows from the values, as rows of a table."""
    rows: list[tuple[str, ...]] = [("computed from these", "")]
    if not isinstance(fabric.tension, Unwoven):
        b1, b2 = fabric.yarn_width
        rows += [
            ("yarns per cm, warp and weft", f"{0.01 / b1:.4g}, {0.01 / b2:.4g}"),
            ("cell area", f"{fabric.cell_area * 1e6:.4g} mm²"),
        ]
    if fabric.fibre_density is not None:
        packed = fabric.areal_density / (fabric.fibre_density * fabric.thickness)
        rows.append(("fibre volume fraction, flat", f"{100 * packed:.3g} %"))
    rows.append(("shear stiffness at 0°", f"{initial_shear_stiffness(fabric):.4g} N/m"))
    if not isinstance(fabric.shear, NoShear):
        for angle in (30, 45, 60):
            couple = fabric.shear_per_area(math.radians(angle))
            force = couple / math.cos(math.radians(angle)) / 1e3
            beyond = isinstance(fabric.shear, ShearTable) and (
                math.radians(angle) > fabric.shear.angles[-1] * (1.0 + 1e-9)
            )
            said = ", extrapolated" if beyond else ""
            rows.append((f"normalised shear force at {angle}°", f"{force:.4g} N/mm{said}"))
        stiffest = shear_stiffness(fabric, math.radians(60))
        rows.append(("largest shear stiffness up to 60°", f"{stiffest:.4g} N/m"))
    if fabric.bends and isinstance(fabric.bending, Bending):
        weight = GRAVITY * fabric.areal_density
        lengths = [(b / weight) ** (1 / 3) for b in (fabric.bending.warp, fabric.bending.weft)]
        shown = ", ".join(f"{1e3 * length:.3g}" for length in lengths)
        rows.append(("flexural length, warp and weft", f"{shown} mm"))
        if "bending.twist" not in fabric.sources:
            rows.append(("twisting stiffness", f"{fabric.bending.twist:.4g} N·m"))
    if fabric.compaction is not None:
        for pressure in (1e4, 1e5):
            if pressure <= fabric.compaction.pressures[-1]:
                thickness = fabric.compaction.thickness_at(pressure)
                rows.append(
                    (f"thickness under {pressure / 1e3:g} kPa", f"{1e3 * thickness:.4g} mm")
                )
    return rows + matrix_rows(fabric)


def _note(source: Source | None, notes: list[tuple[str, str]]) -> str:
    """Number of the note that holds a source and its doubt."""
    if source is None:
        return ""
    if (source.text, source.doubt) not in notes:
        notes.append((source.text, source.doubt))
    return f"[{notes.index((source.text, source.doubt)) + 1}]"


def _table(rows: list[tuple[str, ...]]) -> str:
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )


def _numbered(notes: list[tuple[str, str]]) -> str:
    lines = ["Sources"]
    for number, (text, doubt) in enumerate(notes, start=1):
        lines.append(_wrap(f"  [{number}] ", text))
        if doubt:
            lines.append(_wrap("      doubt: ", doubt))
    return "\n".join(lines)


def _wrap(first: str, text: str) -> str:
    indent = " " * len(first)
    return textwrap.fill(text, WIDTH, initial_indent=first, subsequent_indent=indent)


def plot_card(fabric: Fabric, path: str | os.PathLike[str]) -> None:
    """Draw tensions, shear couple and normalised shear force of a fabric to a picture file."""
    from matplotlib.figure import Figure

    count = 3 if fabric.matrix is None else 4
    figure = Figure(figsize=(4.0 * count, 3.8), layout="constrained")
    tension, couple, force, *viscous = figure.subplots(1, count)
    if fabric.matrix is not None:
        plot_matrix(fabric, fabric.matrix, *viscous)
    _plot_tensions(fabric, tension)
    _plot_shear(fabric, couple, force)
    figure.suptitle(fabric.name)
    figure.savefig(path, dpi=120)


def _plot_rubber(law: MooneyRivlin, thickness: float, axes: Axes) -> None:
    """Nominal line tension over stretch, pulled one way with free sides, and both ways."""
    step = 1e-5
    stretch = np.linspace(1.0, law.largest_stretch, 201)
    for text, style, across in (
        ("one way", "-", lambda s: s**-0.5),
        ("both ways", "--", lambda s: s),
    ):
        rise = law.energy(stretch + step, across(stretch)) - law.energy(
            stretch - step, across(stretch)
        )
        line = thickness * rise / (2.0 * step)
        axes.plot(100 * (stretch - 1.0), line / 1e3, style, label=text)
    axes.set(ylabel="line tension per flat width [N/mm]", title="Rubber")


def _plot_tensions(fabric: Fabric, axes: Axes) -> None:
    axes.set(xlabel="strain [%]", title="Yarn tension")
    if isinstance(fabric.tension, MooneyRivlin):
        _plot_rubber(fabric.tension, fabric.thickness, axes)
    elif isinstance(fabric.tension, IsotropicMembrane):
        strain = np.linspace(0.0, 0.02, 2)
        law = fabric.tension
        line = law.stiffness / (1 - law.poisson**2) * strain
        axes.plot(100 * strain, line / 1e3, label="other strain 0")
        axes.plot(100 * strain, line * (1 + law.poisson) / 1e3, "--", label="other strain equal")
        axes.set(ylabel="line tension [N/mm]", title="Membrane tension, small strains")
    else:
        largest = 0.015
        if isinstance(fabric.tension, TabulatedTension):
            largest = min(fabric.tension.strain_warp[-1], fabric.tension.strain_weft[-1])
        strain = np.linspace(-0.25 * largest, largest, 251)
        coupled = not isinstance(fabric.tension, LinearTension)
        for family, name in enumerate(("warp", "weft")):
            for ratio, style in ((0.0, "-"), (1.0, "--"))[: 1 + coupled]:
                both = np.stack([strain, ratio * strain], axis=1)
                line = sample_tensions(fabric, both[:, ::-1] if family else both)[0][:, family]
                axes.plot(
                    100 * strain,
                    line * fabric.yarn_width[family],
                    style,
                    color=f"C{family}",
                    linewidth=1.2 if family else 3.0,
                    label=f"{name}, other strain {'equal' if ratio else '0'}" if coupled else name,
                )
        axes.set(ylabel="tension [N per yarn]")
    axes.axhline(0.0, color="0.8", linewidth=0.8, zorder=0)
    axes.legend(frameon=False, fontsize="small")


def _plot_shear(fabric: Fabric, couple: Axes, force: Axes) -> None:
    couple.set(title="Shear couple", ylabel="couple C$_s$ [N·mm per cell]")
    force.set(title="Normalised shear force", ylabel="C/cos γ [N/mm]")
    for axes in (couple, force):
        axes.set(xlabel="shear angle [°]")
    if isinstance(fabric.shear, NoShear):
        membrane = isinstance(fabric.tension, Unwoven)
        text = "shears as the membrane" if membrane else "shears freely"
        for axes in (couple, force):
            axes.set(xticks=[], yticks=[])
            axes.text(0.5, 0.5, text, ha="center", va="center", transform=axes.transAxes)
        return
    last = 70.0
    if isinstance(fabric.shear, ShearTable):
        last = min(85.0, math.degrees(fabric.shear.angles[-1]) * 1.1)
        points = np.degrees(fabric.shear.angles), np.asarray(fabric.shear.couples) * 1e3
        couple.plot(*points, "o", color="C0", markersize=3)
    end = math.degrees(fabric.shear.angles[-1]) if isinstance(fabric.shear, ShearTable) else last
    for first, until, style, label in ((0.0, end, "-", None), (end, last, "--", "extrapolated")):
        if until <= first:
            continue
        angles = np.linspace(first, until, 281)
        values = fabric.shear.couple(np.radians(angles))
        normal = values / fabric.cell_area / np.cos(np.radians(angles)) / 1e3
        couple.plot(angles, values * 1e3, style, color="C0", label=label)
        force.plot(angles, normal, style, color="C0", label=label)
        if label:
            couple.legend(frameon=False, fontsize="small")
