"""Rubber sheets: pulled one way and both ways, blown up flat and as a ball."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import trimesh
import warp as wp
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from warpdrape import Clamp, Fabric, Numerics, Ply, Pressure, Scene
from warpdrape.kernels.forces.sheet import add_rubber_forces
from warpdrape.materials.law_data import tension_struct
from warpdrape.verification.case import CaseResult, relative

C10, C01, THICKNESS, DENSITY = 1.5e5, 2e4, 1e-3, 1100.0
"""Constants of the cases [Pa], thickness [m] and density [kg/m³]: a soft rubber, made up."""
SIDE = 0.02
"""Of the square that is pulled [m]."""


def rubber(c10: float = C10, c01: float = C01) -> Fabric:
    """The sheet of all cases, without bending."""
    return Fabric.rubber(
        "rubber", thickness=THICKNESS, density=DENSITY, c10=c10, c01=c01, bends=False
    )


def pulled(stretch: float, *, both: bool) -> Scene:
    """A square that clamps stretch, all along its edge or at two ends, inside free.

    Args:
        stretch: λ at the end.
        both: in both directions; else the ends become narrower as a free strip does, λ^−½.
    """
    duration = 0.04

    def matrix(time: np.ndarray) -> np.ndarray:
        u = np.clip(np.asarray(time) / (0.7 * duration), 0.0, 1.0)
        now = 1.0 + (stretch - 1.0) * u**2 * (3.0 - 2.0 * u)
        across = now if both else 1.0 / np.sqrt(now)
        return np.stack([now, across, np.ones_like(now)], axis=-1)[..., None] * np.eye(3)

    def edge(points: np.ndarray) -> np.ndarray:
        sides = np.abs(points[:, :2]) > 0.5 * SIDE * (1.0 - 1e-6)
        return sides.any(axis=1) if both else sides[:, 0]

    return Scene(
        name="pulled",
        plies=[Ply.rectangle("sheet", rubber(), SIDE, edge=4e-3, mesh="random")],
        clamps=[Clamp(name="edge", ply="sheet", where=edge, matrix=matrix)],
        duration=duration,
        numerics=Numerics(damping=300.0),
        gravity=(0.0, 0.0, 0.0),
    )


def stored(one: float, other: float, c10: float = C10, c01: float = C01) -> float:
    """Energy per volume [J/m³] of incompressible rubber at two stretches in its plane."""
    a, b, c = one**2, other**2, (one * other) ** -2
    return c10 * (a + b + c - 3.0) + c01 * (a * b + b * c + c * a - 3.0)


def stretched() -> list[CaseResult]:
    """Energies of a square at λ = 2 one way and λ = 1.5 both ways, over the closed forms."""
    cases = []
    for text, stretch, both in (("one way, λ = 2", 2.0, False), ("both ways, λ = 1.5", 1.5, True)):
        history = pulled(stretch, both=both).run(frames=4, quiet=True).history
        exact = stored(stretch, stretch if both else stretch**-0.5) * THICKNESS * SIDE**2
        found = float(history["yarn_j"][-1])
        cases.append(relative(f"rubber pulled {text}: energy", found, exact, 1e-3, "J"))
    return cases


def ball_pressure(stretch: float, c10: float, c01: float, subdivisions: int = 5) -> float:
    """Pressure [Pa] that holds a ball of triangles, of unit radius, blown up by λ.

    Its flat triangles are laid on a sphere one by one. What the nodes' forces do as the radius
    grows is the pressure's work on the volume: p dV = −Σ f·dx.
    """
    ball = trimesh.creation.icosphere(subdivisions)
    corners = ball.vertices[ball.faces]
    along = corners[:, 1] - corners[:, 0]
    length = np.linalg.norm(along, axis=1)
    first = along / length[:, None]
    second = np.cross(ball.face_normals, first)
    other = corners[:, 2] - corners[:, 0]
    u, v = (other * first).sum(axis=1), (other * second).sum(axis=1)
    zero = np.zeros_like(u)
    gradients = np.stack([1.0 / length, zero, -u / (length * v), 1.0 / v], axis=1)
    law = tension_struct(rubber(c10, c01))
    x = stretch * ball.vertices
    force = wp.zeros(len(x), dtype=wp.vec3d, device="cpu")
    inputs = [
        0,
        wp.array(ball.faces, dtype=wp.int32, device="cpu"),
        wp.array(gradients, dtype=wp.vec4d, device="cpu"),
        wp.array(0.5 * length * v, dtype=wp.float64, device="cpu"),
        law,
        wp.array(x, dtype=wp.vec3d, device="cpu"),
    ]
    wp.launch(add_rubber_forces, len(ball.faces), inputs, outputs=[force], device="cpu")
    volume = ball.volume * stretch**3
    return -float((force.numpy() * x).sum()) / (3.0 * volume)


def sphere(stretch: float, c10: float, c01: float) -> float:
    """The closed form: p R/h = 4 (λ⁻¹ − λ⁻⁷)(C10 + C01 λ²), here with R = 1 m."""
    return 4.0 * THICKNESS * (stretch**-1 - stretch**-7) * (c10 + c01 * stretch**2)


def balls() -> list[CaseResult]:
    """A ball led by its radius, as pressure cannot lead it past the most that neo-Hooke bears.

    That is at λ = 7^(1/6), from where a larger ball needs less pressure.
    """
    mooney = relative(
        "ball of Mooney–Rivlin rubber at λ = 2: pressure",
        ball_pressure(2.0, C10, C01),
        sphere(2.0, C10, C01),
        1e-3,
        "Pa",
    )
    stretches = np.linspace(1.2, 1.6, 41)
    pressures = np.array([ball_pressure(s, C10, 0.0, 3) for s in stretches])
    flat = np.polynomial.Polynomial.fit(stretches, pressures, 6).deriv().roots()
    top = float(flat[np.isreal(flat) & (flat.real > 1.25) & (flat.real < 1.55)].real[0])
    return [
        mooney,
        relative("ball of neo-Hookean rubber: λ of the most pressure", top, 7.0 ** (1 / 6), 1e-3),
        relative(
            "ball of neo-Hookean rubber: the most pressure",
            ball_pressure(7.0 ** (1 / 6), C10, 0.0),
            sphere(7.0 ** (1 / 6), C10, 0.0),
            1e-3,
            "Pa",
        ),
    ]


def blown(
    pressure: float, radius: float, edge: float, duration: float = 0.3, damping: float = 120.0
) -> Scene:
    """A round flat sheet of rubber held at its rim, under a pressure from below."""
    ply = Ply.disc("sheet", rubber(), radius, edge=edge, mesh="random")

    def rim(points: np.ndarray) -> np.ndarray:
        return np.hypot(points[:, 0], points[:, 1]) > radius * (1.0 - 1e-3)

    air = Pressure(name="air", ply="sheet", pressure=pressure, side="lower", ramp=0.5 * duration)
    return Scene(
        name="blown",
        plies=[ply],
        clamps=[Clamp(name="rim", ply="sheet", where=rim)],
        pressures=[air],
        duration=duration,
        numerics=Numerics(damping=damping),
        gravity=(0.0, 0.0, 0.0),
    )


def blown_height(pressure: float, radius: float) -> float:
    """Height in the middle [m] of a round sheet of rubber that a pressure has blown up.

    Adkins & Rivlin (1952): a point at ρ of the flat sheet comes to (r, z). With nominal tensions
    P_i = h ∂W/∂λ_i along the meridian and round the axis, and the meridian's slope φ,

        ρ P1 sin φ = p r²/2,  d(ρ P1 cos φ)/dρ = P2 − p r λ1 sin φ,  dr/dρ = λ1 cos φ

    shot from the stretch at the pole so that the rim stays in place; the least stretch counts.
    """
    small = 1e-6 * radius

    def nominal(one: float, other: float) -> float:
        step = 1e-6
        slope = stored(one + step, other) - stored(one - step, other)
        return THICKNESS * slope / (2.0 * step)

    def meridian(tension: float, other: float) -> float:
        return brentq(lambda one: nominal(one, other) - tension, 0.3, 20.0, xtol=1e-12)

    def split(rho: float, r: float, along: float) -> tuple[float, float, float]:
        lift = 0.5 * pressure * r**2
        whole = np.hypot(lift, along)
        return meridian(whole / rho, r / rho), lift / whole, along / whole

    def slopes(rho: float, y: np.ndarray) -> list[float]:
        r, along, _ = y
        one, sine, cosine = split(rho, r, along)
        around = nominal(r / rho, one)
        return [one * cosine, around - pressure * r * one * sine, one * sine]

    def shot(pole: float) -> np.ndarray:
        start = [pole * small, small * nominal(pole, pole), 0.0]
        found = solve_ivp(slopes, (small, radius), start, rtol=1e-9, atol=1e-12)
        return found.y[:, -1]

    pole = _least_root(lambda s: shot(s)[0] - radius, 1.0 + np.geomspace(1e-4, 2.0, 80))
    return float(shot(pole)[2])


def _least_root(function: Callable[[float], float], at: np.ndarray) -> float:
    """The least root between values that rise."""
    before = None
    for s in at:
        try:
            now = function(float(s))
        except ValueError:  # so little stretched at the pole that no meridian bears the pressure
            before = None
            continue
        if before is not None and before[1] * now <= 0.0:
            return brentq(function, before[0], float(s), xtol=1e-10)
        before = (float(s), now)
    raise ArithmeticError("no stretch at the pole leaves the rim in place")


def bubble(quick: bool) -> CaseResult:
    """A round sheet blown up to about half its radius, on the branch that pressure reaches."""
    radius, pressure = 0.05, 6e3
    scene = blown(pressure, radius, edge=6e-3 if quick else 3e-3)
    height = float(scene.run(frames=4, quiet=True).plies[0].points[:, 2].max())
    exact = blown_height(pressure, radius)
    return relative("rubber blown up flat: height in the middle", height, exact, 0.01, "m")


def rubber_sheets(quick: bool) -> list[CaseResult]:
    """All cases of this file."""
    return [*stretched(), *balls(), bubble(quick)]
