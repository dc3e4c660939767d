"""Closed forms that results are held against; each says where it comes from."""

from __future__ import annotations

import math

import numpy as np

from warpdrape.errors import InputError, finite, positive
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.laws import CrimpInterchange

COLLAPSE = math.pi / 2
"""Shear angle at which orthogonal yarns lie on each other [rad]."""


def check_shear_angle(name: str, degrees: float) -> float:
    """Return a shear angle [rad]; raise `InputError` unless it lies in 0 … 90°, both excluded."""
    angle = math.radians(finite(name, degrees, unit="deg"))
    if not 0.0 < angle < COLLAPSE:
        raise InputError(
            f"{name} = {degrees}° must lie between 0 and 90°: at 90° the yarns lie on each other"
        )
    return angle


def frame_travel(side: float, angle: np.ndarray) -> np.ndarray:
    """Travel δ [m] of a picture frame at shear angles [rad].

    The diagonal of a rhombus of side L whose corner there measures π/2 − γ is 2 L cos(π/4 − γ/2),
    √2 L at the start: δ = 2 L cos(π/4 − γ/2) − √2 L.

    Args:
        side: of the frame, between its hinges [m].
        angle: γ [rad].
    """
    return 2.0 * side * np.cos(math.pi / 4 - np.asarray(angle) / 2) - math.sqrt(2.0) * side


def frame_angle(side: float, travel: np.ndarray) -> np.ndarray:
    """Shear angle [rad] of a picture frame at travels [m]: `frame_travel` turned round.

    The diagonal is (√2 + δ/L) L, and its square 2 (1 + sin γ) L².
    """
    share = np.asarray(travel) / side
    return np.arcsin(np.minimum(share * (math.sqrt(2.0) + 0.5 * share), 1.0))


def frame_force(
    fabric: Fabric,
    side: float,
    angle: np.ndarray,
    sample: float | None = None,
    *,
    rate: np.ndarray | float = 0.0,
    temperature: float | None = None,
) -> np.ndarray:
    """Force [N] of a picture frame: F = C(γ) (L_fab²/L) √2/(cos γ/2 − sin γ/2).

    Power balance: F dδ = C L_fab² dγ with dδ/dγ = L sin(π/4 − γ/2).

    Args:
        fabric: of the sample.
        side: L of the frame [m].
        angle: γ [rad].
        sample: side L_fab of the sample [m]; the frame's if None.
        rate: of the angle, for a fabric with a viscous matrix [1/s].
        temperature: likewise [K]; None for that at which its viscosity is given.
    """
    area = (side if sample is None else sample) ** 2
    opening = np.cos(np.asarray(angle) / 2) - np.sin(np.asarray(angle) / 2)
    couple = wet_couple(fabric, angle, rate, temperature)
    return couple * area / side * math.sqrt(2.0) / opening


def bias_travel(width: float, height: float, angle: np.ndarray) -> np.ndarray:
    """Clamp travel d [m] of a bias-extension sample: d/D = cos γ/2 + sin γ/2 − 1, D = H − W.

    Inextensible yarns: the middle zone's diagonal D turns from π/4 to π/4 − γ/2 off its yarns, so
    that its length is √2 D cos(π/4 − γ/2).

    Args:
        width: W [m].
        height: H [m].
        angle: γ in the middle zone [rad].
    """
    half = np.asarray(angle) / 2
    return (height - width) * (np.cos(half) + np.sin(half) - 1.0)


def bias_angle(width: float, height: float, travel: np.ndarray) -> np.ndarray:
    """Shear angle [rad] in the middle of a bias-extension sample: `bias_travel` turned round.

    (1 + d/D)² = (cos γ/2 + sin γ/2)² = 1 + sin γ.
    """
    share = np.asarray(travel) / (height - width)
    return np.arcsin(np.minimum(share * (2.0 + share), 1.0))


def bias_force(
    fabric: Fabric,
    width: float,
    height: float,
    angle: np.ndarray,
    *,
    rate: np.ndarray | float = 0.0,
    temperature: float | None = None,
) -> np.ndarray:
    """Force [N] of bias extension.

    F (H/W − 1)(cos γ/2 − sin γ/2) = (2H − 3W) C(γ) + W C(γ/2): power balance over the middle zone,
    area W(2H − 3W)/2 at γ, and the four zones beside it, together W² at γ/2. Inextensible yarns.

    Args:
        fabric: of the sample.
        width: W [m].
        height: H [m], at least 2 W.
        angle: γ in the middle zone [rad].
        rate: of that angle, for a fabric with a viscous matrix, half of it in the four zones [1/s].
        temperature: likewise [K]; None for that at which its viscosity is given.
    """
    angle, rate = np.asarray(angle, dtype=float), np.asarray(rate, dtype=float)
    couple = wet_couple(fabric, angle, rate, temperature)
    half = wet_couple(fabric, angle / 2, rate / 2, temperature)
    opening = (height / width - 1.0) * (np.cos(angle / 2) - np.sin(angle / 2))
    return ((2.0 * height - 3.0 * width) * couple + width * half) / opening


def couple_per_area(fabric: Fabric, angle: np.ndarray) -> np.ndarray:
    """C = C_s/S [N/m] at shear angles [rad]."""
    return np.asarray(fabric.shear.couple(np.asarray(angle, dtype=float))) / fabric.cell_area


def wet_couple(
    fabric: Fabric,
    angle: np.ndarray,
    rate: np.ndarray | float,
    temperature: float | None = None,
) -> np.ndarray:
    """The same, and what a matrix adds where nothing is stored in a spring: h φ(γ) σ(a γ̇) [N/m].

    Args:
        fabric: with or without a matrix.
        angle: γ [rad].
        rate: of the angle in the process [1/s].
        temperature: [K]; None for that at which the viscosity is given.
    """
    couple = couple_per_area(fabric, angle)
    if fabric.matrix is None:
        return couple
    return couple + fabric.thickness * fabric.matrix.stress(angle, rate, temperature)


def crimp_tensions(law: CrimpInterchange, warp_strain: float, weft_strain: float) -> np.ndarray:
    """Tensions (T1, T2) [N per yarn] of taut saw-tooth yarns that straighten each other.

    Yarn i climbs h_i over p_i (1 + ε_i); h1 + h2 is kept and the vertical forces balance,
    t1 h1/L1 = t2 h2/L2, t_i = EA_i (L_i/l_i − 1); T_i = t_i p_i (1 + ε_i)/L_i. The share h1 is
    found by bisection, independently of the kernels' Newton iteration.

    Args:
        law: the weave.
        warp_strain: ε1 [-].
        weft_strain: ε2 [-].
    """
    from scipy.optimize import brentq

    spacing = np.array([law.spacing_warp, law.spacing_weft])
    stiffness = np.array([law.stiffness_warp, law.stiffness_weft])
    rest, total = np.array(law.lengths), sum(law.heights)
    across = spacing * (1.0 + np.array([warp_strain, weft_strain]))

    def pulls(first_height: float) -> tuple[np.ndarray, np.ndarray]:
        heights = np.array([first_height, total - first_height])
        lengths = np.hypot(across, heights)
        pull = np.maximum(stiffness * (lengths / rest - 1.0), 0.0)
        return pull * heights / lengths, pull * across / lengths

    share = brentq(lambda h: float(np.subtract(*pulls(h)[0])), 0.0, total, xtol=1e-18, rtol=1e-15)
    return pulls(share)[1]


def yarn_tensions(fabric: Fabric, strains: np.ndarray) -> np.ndarray:
    """Tensions (T1, T2) [N per yarn] of a fabric at (warp, weft) strains, shapes [n, 2].

    Crimp interchange by `crimp_tensions`; another law as it stands on the fabric's card.
    """
    if isinstance(fabric.tension, CrimpInterchange):
        return np.array([crimp_tensions(fabric.tension, *strain) for strain in strains])
    from warpdrape.materials.law_curves import sample_tensions

    return sample_tensions(fabric, np.asarray(strains, dtype=float))[0] * fabric.yarn_width


def net_shear_on_sphere(z: np.ndarray) -> np.ndarray:
    """Shear angle γ [rad] of an inextensible net on a sphere whose generators are great circles.

    z f'' + f' + sin f = 0, f(0) = π/2, γ = π/2 − f: the similarity solution of the Chebyshev net,
    f_uv = −sin f with f a function of z = u v/R². From z = 0 the series γ = z − z³/18 + …

    Args:
        z: u v/R², arc lengths u, v along the yarns from the pole, shape [...].
    """
    from scipy.integrate import solve_ivp

    z = np.asarray(z, dtype=float)
    start, end = 1e-3, max(float(z.max(initial=0.0)), 2e-3)
    slope = -1.0 + start**2 / 6.0

    def rates(at: float, f: np.ndarray) -> list[float]:
        return [f[1], -(f[1] + math.sin(f[0])) / at]

    first = [math.pi / 2 - start + start**3 / 18.0, slope]
    solved = solve_ivp(rates, (start, end), first, rtol=1e-11, atol=1e-13, dense_output=True)
    far = math.pi / 2 - solved.sol(np.maximum(z, start).ravel())[0].reshape(z.shape)
    return np.where(z < start, z - z**3 / 18.0, far)


def bias_diagonal_of_net(u: np.ndarray) -> np.ndarray:
    """Polar angle [rad] of the net's point u = v (both over R) on the bias diagonal of the sphere.

    Along u = v = s the diagonal is a great circle by symmetry and dθ/ds = 2 cos(f/2), f the angle
    between the yarns: the step (ds, ds) along two unit vectors f apart.

    Args:
        u: arc length along a yarn from the pole over the radius [-], rising from 0, shape [n].
    """
    u = np.asarray(u, dtype=float)
    fine = np.linspace(0.0, float(u.max()), 4001)
    between = math.pi / 2 - net_shear_on_sphere(fine**2)
    speed = 2.0 * np.cos(between / 2.0)
    polar = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(fine))])
    return np.interp(u, fine, polar)


def catenary_sag(length: float, span: float) -> float:
    """Sag [m] of an inextensible chain of a length between two points at one height.

    L = 2 a sinh(D/2a), sag = a (cosh(D/2a) − 1).

    Args:
        length: L [m].
        span: D [m].
    """
    from scipy.optimize import brentq

    if positive("catenary span", span) >= length:
        raise InputError(f"catenary span = {span} m must be below the length {length} m")
    a = brentq(lambda a: 2.0 * a * math.sinh(span / (2.0 * a)) - length, span / 100.0, 1e3 * span)
    return a * (math.cosh(span / (2.0 * a)) - 1.0)


def heavy_cantilever(load: float) -> tuple[float, float]:
    """Drop and reach of the tip of an inextensible strip under its weight, over its length.

    The elastica B θ'' = −w (L − s) cos θ with θ(0) = 0 and θ'(L) = 0.

    Args:
        load: w L³/B [-].
    """
    from scipy.integrate import solve_bvp

    s = np.linspace(0.0, 1.0, 201)
    guess = np.vstack([0.5 * math.pi * s * load / (load + 4.0), np.zeros_like(s)])

    def rates(at: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.vstack([y[1], -load * (1.0 - at) * np.cos(y[0])])

    solved = solve_bvp(
        rates, lambda a, b: np.array([a[0], b[1]]), s, guess, tol=1e-10, max_nodes=100_000
    )
    if not solved.success:
        raise InputError(f"load = {load:g}: no elastica found; give one below 1e4")
    fine = np.linspace(0.0, 1.0, 20001)
    angle = solved.sol(fine)[0]

    def over(values: np.ndarray) -> float:
        return float(np.abs(np.trapezoid(values, fine)))

    return over(np.sin(angle)), over(np.cos(angle))


def flexural_length(overhang: float, angle: float) -> float:
    """Flexural length c = (B/w)^⅓ [m] of a strip that hangs over an edge, by the elastica.

    At 41.5°, where ASTM D1388 cuts off, it is half the overhang.

    Args:
        overhang: of the strip [m].
        angle: from the horizontal to the chord from edge to tip [rad].
    """
    from scipy.optimize import brentq

    if not math.radians(1.0) <= angle <= math.radians(80.0):
        raise InputError(
            f"angle = {math.degrees(angle):.3g}° must lie in 1 … 80°: take another overhang"
        )

    def miss(logarithm: float) -> float:
        drop, reach = heavy_cantilever(math.exp(logarithm))
        return math.atan2(drop, reach) - angle

    load = math.exp(brentq(miss, math.log(0.05), math.log(200.0), xtol=1e-6))
    return overhang / load ** (1.0 / 3.0)
