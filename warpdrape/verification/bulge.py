"""A round membrane, held at its rim, blown up by a pressure."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_bvp

from warpdrape import Clamp, Fabric, Numerics, Ply, Pressure, Scene
from warpdrape.materials.laws import IsotropicMembrane, NoShear
from warpdrape.verification.case import CaseResult, relative

RADIUS, STIFFNESS, POISSON = 0.1, 1e4, 0.3
"""Of the sheet: radius [m], Young's modulus times thickness [N/m], Poisson's ratio [-]."""
PRESSURE = 10.0
"""Pa: the middle rises by 3 % of the radius, within what the closed form allows."""


def blown_up(
    pressure: float,
    *,
    edge: float,
    radius: float = RADIUS,
    stiffness: float = STIFFNESS,
    poisson: float = POISSON,
) -> Scene:
    """A round membrane held at its rim under a pressure from below."""
    sheet = Fabric(
        name="sheet",
        areal_density=0.6,
        thickness=5e-4,
        tension=IsotropicMembrane(stiffness, poisson),
        shear=NoShear(),
    )
    ply = Ply.disc("sheet", sheet, radius, edge=edge, mesh="random")

    def rim(points: np.ndarray) -> np.ndarray:
        return np.hypot(points[:, 0], points[:, 1]) > radius * (1.0 - 1e-3)

    return Scene(
        name="bulge",
        plies=[ply],
        clamps=[Clamp(name="rim", ply="sheet", where=rim)],
        pressures=[Pressure(name="air", ply="sheet", pressure=pressure, side="lower", ramp=0.05)],
        duration=0.25,
        numerics=Numerics(damping=60.0),
        gravity=(0.0, 0.0, 0.0),
    )


def hencky(pressure: float, radius: float, stiffness: float, poisson: float) -> float:
    """Height in the middle of a clamped round membrane over its radius (Hencky 1915).

    Slopes are small. With ρ = r/a, N = n Eh, q = p a/(Eh): n θ = −q ρ/2 for the slope θ, and
    ρ d/dρ(1/ρ d(ρ² n)/dρ) = −θ²/2; u = 0 at the rim: d(ρ n)/dρ = ν n.
    """
    q = pressure * radius / stiffness
    small = 1e-6

    def slopes(r: np.ndarray, y: np.ndarray) -> np.ndarray:  # n, m = n', w
        n, m, _ = y
        tilt = -0.5 * q * r / n
        return np.stack([m, -3.0 * m / r - 0.5 * tilt**2 / r**2, tilt])

    def ends(left: np.ndarray, right: np.ndarray) -> np.ndarray:
        return np.array([left[1], right[0] + right[1] - poisson * right[0], right[2]])

    r = np.linspace(small, 1.0, 200)
    n = 0.43 * q ** (2.0 / 3.0)
    start = np.stack([np.full_like(r, n), np.zeros_like(r), 0.25 * q / n * (1.0 - r**2)])
    found = solve_bvp(slopes, ends, r, start, tol=1e-8, max_nodes=100_000)
    if not found.success:
        raise ArithmeticError(f"no solution for the membrane: {found.message}")
    return float(found.y[2, 0])


def bulge(quick: bool) -> list[CaseResult]:
    """All cases of this file."""
    scene = blown_up(PRESSURE, edge=8e-3 if quick else 5e-3)
    height = float(scene.run(frames=4).plies[0].points[:, 2].max())
    exact = RADIUS * hencky(PRESSURE, RADIUS, STIFFNESS, POISSON)
    return [relative("membrane under pressure: height in the middle", height, exact, 0.01, "m")]
