"""Made-up raw tests of a made-up fabric, written as different laboratories write them.

Every law is known (``TRUTH``), so that what `warpdrape calibrate` finds can be held against it.
Nothing here was measured.  python examples/calibration/make_raw_tests.py [FOLDER]
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

from warpdrape.calibration.hysteresis import friction_history
from warpdrape.coupons.closed_forms import (
    bias_travel,
    crimp_tensions,
    flexural_length,
    frame_travel,
)
from warpdrape.materials.laws import CrimpInterchange

TRUTH = {
    "areal_density": 0.6,
    "yarns_per_m": (500.0, 490.0),
    "couple_n_mm": (0.35, -0.80, 1.00),
    "crimp": (0.006, 0.010),
    "yarn_n": (20e3, 19e3),
    "bending_n_m": (1.8e-3, 1.2e-3),
    "loop": {"warp": (0.060, 25.0), "weft": (0.045, 25.0)},
    "loop_friction_n": {"warp": 0.012, "weft": 0.008},
    "loop_friction_over": 8.0,
    "tool_friction": (0.28, -0.08, 0.05),
    "ply_friction": (0.34, -0.05),
    "packing": (0.38 * 1000**-0.07, 0.07),
    "fibre_density": 2550.0,
}
"""Laws; friction μ = μ0 (p/10 kPa)^a (v/1 mm/s)^b; a loop's M = M0 (1 − exp(−κ/κ0)) [N, 1/m]."""
SCATTER, NOISE = 0.05, 0.02
"""Of specimens about the law, and of points about their specimen's curve [-]."""
FRAME, SAMPLE, WIDTH, HEIGHT = 0.200, 0.170, 0.115, 0.230


def couple_per_area(angle: np.ndarray) -> np.ndarray:
    """C [N/m] of the true law."""
    area = 1.0 / (TRUTH["yarns_per_m"][0] * TRUTH["yarns_per_m"][1])
    terms = enumerate(TRUTH["couple_n_mm"])
    return sum(1e-3 * c * angle ** (2 * i + 1) for i, c in terms) / area


def write(path: Path, lines: list[str], encoding: str = "utf-8") -> None:
    """Write lines in an encoding."""
    path.write_bytes("\n".join([*lines, ""]).encode(encoding))


def comma(value: float, digits: int = 4) -> str:
    """A number with a decimal comma."""
    return f"{value:.{digits}f}".replace(".", ",")


def specimen(rng: np.random.Generator) -> float:
    """Factor of one specimen."""
    return math.exp(SCATTER * rng.standard_normal())


def noisy(rng: np.random.Generator, values: np.ndarray) -> np.ndarray:
    """Values with noise on every point."""
    return values * (1.0 + NOISE * rng.standard_normal(len(values)))


def picture_frames(folder: Path, rng: np.random.Generator) -> None:
    """A German machine: preamble, decimal commas, units on a line of their own, code page 1252."""
    angle = np.radians(np.linspace(0.0, 56.0, 150))
    opening = np.cos(angle / 2) - np.sin(angle / 2)
    for number in range(1, 6):
        force = couple_per_area(angle) * SAMPLE**2 / FRAME * math.sqrt(2.0) / opening
        force = noisy(rng, specimen(rng) * force)
        lines = [
            '"Prüfer";"N. N."',
            f'"Probe";"{number}"',
            '"Prüfgeschwindigkeit";"20";"mm/min"',
            "",
        ]
        lines += ["Standardweg;Standardkraft;Prüfzeit", "mm;N;s"]
        travel = 1e3 * frame_travel(FRAME, angle)
        lines += [
            f"{comma(d)};{comma(f)};{comma(3.0 * d, 2)}" for d, f in zip(travel, force, strict=True)
        ]
        write(folder / f"frame_{number}.csv", lines, "cp1252")


def bias_extension(folder: Path, rng: np.random.Generator) -> None:
    """All specimens below each other with a column that says which; tabs, kN."""
    lines = ["# bias extension, 115 x 230 mm", "Specimen\tExtension (mm)\tLoad (kN)"]
    for number in range(1, 6):
        angle = np.radians(np.linspace(0.0, 48.0, 120))
        opening = (HEIGHT / WIDTH - 1.0) * (np.cos(angle / 2) - np.sin(angle / 2))
        force = (2 * HEIGHT - 3 * WIDTH) * couple_per_area(angle)
        force = noisy(rng, specimen(rng) * (force + WIDTH * couple_per_area(angle / 2)) / opening)
        travel = 1e3 * bias_travel(WIDTH, HEIGHT, angle)
        lines += [f"B{number}\t{d:.4f}\t{1e-3 * f:.7f}" for d, f in zip(travel, force, strict=True)]
    write(folder / "bias.txt", lines)


def strips(folder: Path, rng: np.random.Generator) -> None:
    """Tables side by side; crimp is straightened first, and each strip fails in the end."""
    for family, name in enumerate(("warp", "weft")):
        crimp, stiffness = TRUTH["crimp"][family], TRUTH["yarn_n"][family]
        strain = np.linspace(0.0, crimp + 0.014, 100)
        columns, heads = [], []
        for number in range(1, 6):
            tension = stiffness * np.maximum((1 + strain) / (1 + crimp) - 1.0, 0.0)
            force = noisy(rng, specimen(rng) * tension) * 0.050 * TRUTH["yarns_per_m"][family]
            columns += [100 * strain, np.append(force[:-3], force[-4] * np.array([0.5, 0.2, 0.1]))]
            heads += [f"Strain {number} [%]", f"Force {number} [N]"]
        lines = [";".join(heads)]
        lines += [";".join(f"{v:.5g}" for v in row) for row in zip(*columns, strict=True)]
        write(folder / f"strip_{name}.csv", lines)


def biaxial(folder: Path, rng: np.random.Generator) -> None:
    """Comma-separated, three ratios of strains."""
    spacing = tuple(1.0 / y for y in TRUTH["yarns_per_m"][::-1])
    law = CrimpInterchange(*spacing, *TRUTH["crimp"], *TRUTH["yarn_n"])
    for ratio, (warp, weft) in {"1to1": (1.0, 1.0), "2to1": (1.0, 0.5), "1to2": (0.5, 1.0)}.items():
        strains = np.linspace(0.0, 0.012, 40)[:, None] * np.array([warp, weft])
        for number in (1, 2, 3):
            tension = np.array([crimp_tensions(law, *each) for each in strains])
            force = tension * 0.100 * np.array(TRUTH["yarns_per_m"]) * specimen(rng)
            force = np.stack([noisy(rng, force[:, 0]), noisy(rng, force[:, 1])], axis=1)
            lines = ["Warp strain [%],Weft strain [%],Warp force [kN],Weft force [kN]"]
            lines += [
                f"{100 * e1:.4f},{100 * e2:.4f},{1e-3 * f1:.6f},{1e-3 * f2:.6f}"
                for (e1, e2), (f1, f2) in zip(strains, force, strict=True)
            ]
            write(folder / f"biaxial_{ratio}_{number}.csv", lines)


def cantilevers(folder: Path, rng: np.random.Generator) -> None:
    """Readings: the overhang at 41.5°, one row a strip, in centimetres."""
    for family, name in enumerate(("warp", "weft")):
        length = (TRUTH["bending_n_m"][family] / (9.81 * TRUTH["areal_density"])) ** (1 / 3)
        assert abs(flexural_length(1.0, math.radians(41.5)) - 0.5) < 0.005
        lines = ["overhang [cm]"]
        lines += [f"{200 * length * specimen(rng) ** (1 / 3):.2f}" for _ in range(6)]
        write(folder / f"cantilever_{name}.csv", lines)


def loops(folder: Path, rng: np.random.Generator) -> None:
    """Kawabata's bending loops in his units, with a byte-order mark."""
    way = np.concatenate(
        [[0.0], *([np.linspace(a, b, 61)[1:] for a, b in ((0, 250), (250, -250), (-250, 0))])]
    )
    for name in ("warp", "weft"):
        moment, over = TRUTH["loop"][name]
        for number in (1, 2, 3, 4):
            curve = moment * (1 - np.exp(-np.abs(way) / over)) * np.sign(way) + 2e-4 * way
            rubbed = TRUTH["loop_friction_n"][name] * friction_history(
                way, TRUTH["loop_friction_over"]
            )
            total = specimen(rng) * (curve + rubbed)
            total = total + NOISE * moment * rng.standard_normal(len(way))
            lines = ["K (1/cm); M (gf·cm/cm)"]
            lines += [
                f"{1e-2 * k:.4f}; {m / 9.80665e-3:.5f}" for k, m in zip(way, total, strict=True)
            ]
            write(folder / f"loop_{name}_{number}.csv", lines, "utf-8-sig")


def frictions(folder: Path, rng: np.random.Generator) -> None:
    """Readings against the tool; traces of a sled of plies at two pressures."""
    base, by_pressure, by_speed = TRUTH["tool_friction"]
    lines = ["pressure [kPa],speed [mm/s],friction coefficient [-]"]
    for kpa, speed in ((5, 1), (10, 1), (30, 1), (10, 0.1), (10, 10)):
        for _ in range(4):
            value = base * (kpa / 10) ** by_pressure * speed**by_speed * specimen(rng)
            lines.append(f"{kpa},{speed},{value:.4f}")
    write(folder / "tool_friction.csv", lines)
    base, by_pressure = TRUTH["ply_friction"]
    for kpa in (5, 20):
        for number in (1, 2, 3):
            travel = np.linspace(0.0, 60.0, 90)
            normal = kpa * 1e3 * 0.01
            value = base * (kpa / 10) ** by_pressure * specimen(rng)
            force = normal * value * np.minimum(travel / 2.0, 1.0 + 0.2 * np.exp(-travel / 3.0))
            lines = ["Displacement mm;Force N"]
            lines += [
                f"{comma(d, 3)};{comma(f, 3)}"
                for d, f in zip(travel, noisy(rng, force), strict=True)
            ]
            write(folder / f"sled_{kpa}kPa_{number}.csv", lines)


def plates(folder: Path, rng: np.random.Generator) -> None:
    """Four plies between plates of 2500 mm²; the machine gives way by 2 µm a kN."""
    factor, exponent = TRUTH["packing"]
    solid = TRUTH["areal_density"] / TRUTH["fibre_density"]
    pressure = np.geomspace(500.0, 2e5, 80)
    for number in (1, 2, 3, 4):
        thickness = 4 * solid / (factor * pressure**exponent) * specimen(rng) ** 0.3
        force = pressure * 2.5e-3
        gap = thickness * (1 + 0.1 * NOISE * rng.standard_normal(80)) - 2e-9 * force
        lines = ["Gap [mm];Load [N]"]
        lines += [f"{comma(1e3 * g, 5)};{comma(f, 3)}" for g, f in zip(gap, force, strict=True)]
        write(folder / f"plates_{number}.csv", lines)


def make(folder: Path, seed: int = 1) -> None:
    """Write all raw tables into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for number, test in enumerate(
        (picture_frames, bias_extension, strips, biaxial, cantilevers, loops, frictions, plates)
    ):
        test(folder, np.random.default_rng([seed, number]))


if __name__ == "__main__":
    make(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "raw")
