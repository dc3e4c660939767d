"""Friction: a block on an incline, a rope over a drum."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from warpdrape import Clamp, Friction, Numerics, Path, Ply, Scene, Tool, Turn, lay_up
from warpdrape.verification.case import CaseResult, absolute, relative
from warpdrape.verification.strip import yarn_fabric

GRAVITY = 9.81
DRUM = 0.05
EDGE = 5e-3


def _slide(friction: float | Friction, angle: float, duration: float, **settings: Any) -> float:
    """Way [m] that a patch slides down a plate; gravity is tilted in place of the plate."""
    ply = Ply.rectangle("block", yarn_fabric(1e5, 0.6), 0.02, cells=2)
    scene = Scene(
        name="incline",
        plies=lay_up([ply]),
        tools=[Tool.plate(width=0.5, height=0.5)],
        duration=duration,
        friction=friction,
        gravity=(GRAVITY * math.sin(angle), 0.0, -GRAVITY * math.cos(angle)),
        **settings,
    )
    formed = scene.run(frames=4).plies[0]
    return float((formed.points - formed.rest_points)[:, 0].mean())


def incline() -> list[CaseResult]:
    """Above the angle of friction g (sin α − μ cos α) t²/2; below it nothing moves."""
    friction, angle, duration = 0.2, 0.35, 0.03
    exact = 0.5 * GRAVITY * (math.sin(angle) - friction * math.cos(angle)) * duration**2
    stuck = _slide(friction, 0.95 * math.atan(friction), 0.1)
    return [
        relative("incline: way slid in 30 ms", _slide(friction, angle, duration), exact, 5e-3, "m"),
        absolute("incline: creep below the angle of friction in 0.1 s", stuck, 0.0, 1e-6, "m"),
    ]


def _wound(wrap: float, duration: float, pulls: dict[str, float], friction: float, **drum) -> Scene:
    """A strip wound round a drum by involutes, then pulled at its ends.

    Args:
        wrap: angle of the drum that it covers [rad].
        duration: of all; three fifths of it for the winding [s].
        pulls: how far each end is pulled [m], by the names of the left and the right clamp.
        friction: on the drum.
        drum: options of the drum.
    """
    half, winding = 0.12, 0.6
    cloth = yarn_fabric(3e5, 0.7)
    radius = DRUM + 0.5 * cloth.thickness
    u = np.linspace(0.0, 1.0, 61)
    turned = 0.5 * wrap * (3.0 * u**2 - 2.0 * u**3)
    free = half - radius * turned
    x = radius * np.sin(turned) + free * np.cos(turned) - half
    z = radius * (np.cos(turned) - 1.0) - free * np.sin(turned)
    pull = np.linspace(0.0, 1.0, 31)[1:]
    times = duration * np.concatenate([winding * u, winding + (1.0 - winding) * pull])
    rise = 3.0 * pull**2 - 2.0 * pull**3

    def end(side: float) -> Callable[[np.ndarray], np.ndarray]:
        return lambda p: side * p[:, 0] > half - 1e-9

    clamps = []
    for (name, stretch), side in zip(pulls.items(), (-1.0, 1.0), strict=True):
        outward = np.array([side * math.cos(0.5 * wrap), 0.0, -math.sin(0.5 * wrap)])
        laid = np.column_stack([side * x, 0.0 * x, z])
        further = laid[-1] + (stretch * rise)[:, None] * outward
        clamps.append(
            Clamp(
                name=name,
                ply="rope",
                follow=outward.tolist(),
                motion=Path(
                    times=times.tolist(), positions=np.concatenate([laid, further]).tolist()
                ),
                where=end(side),
            )
        )
    tool = Tool.drum(radius=DRUM, length=3 * EDGE, facet=EDGE, **drum)
    return Scene(
        name="capstan",
        clamps=clamps,
        duration=duration,
        friction=friction,
        plies=[Ply.rectangle("rope", cloth, 2.0 * half, EDGE, edge=EDGE, mesh="grid")],
        tools=[tool.moved((0.0, 0.0, -radius))],
        gravity=(0.0, 0.0, 0.0),
        numerics=Numerics(damping=300.0),
    )


def capstan(friction: float = 0.3, wrap: float = math.pi) -> CaseResult:
    """Tension ratio e^{μφ} of a strip wound round a drum, then pulled at one end."""
    scene = _wound(wrap, 0.04, {"held": 0.0, "pulled": 0.0072}, friction)
    history = scene.run(frames=20).history
    ratio = float(np.mean(history["pulled_force_n"][-4:] / history["held_force_n"][-4:]))
    return relative(
        "capstan: tension ratio, μ = 0.3 over 180°", ratio, math.exp(friction * wrap), 0.01
    )


def roller(friction: float = 0.3, wrap: float = math.pi) -> list[CaseResult]:
    """The same where the ends are held and the drum turns: it drags the strip along.

    The ratio is e^{μφ} again, and the drum's torque (T2 − T1) times its radius and half the
    strip's thickness, where the tensions act.
    """
    turn = Turn(axis=(0.0, 1.0, 0.0), angle=2.0, duration=0.024, start=0.026, ramp=0.2)
    scene = _wound(wrap, 0.05, {"tight": 0.0018, "slack": 0.0018}, friction, turn=turn)
    result = scene.run(frames=25)
    history = result.history
    going = slice(19, 23)  # the speed is even then
    tight, slack, torque = (
        float(np.mean(history[name][going]))
        for name in ("tight_force_n", "slack_force_n", "drum_torque_nm")
    )
    arm = DRUM + 0.5 * scene.plies[0].fabric.thickness
    return [
        relative(
            "turning roller: tension ratio, μ = 0.3 over 180°",
            tight / slack,
            math.exp(friction * wrap),
            0.01,
        ),
        relative("turning roller: torque", torque, (tight - slack) * arm, 0.01, "N·m"),
        absolute("turning roller: unbalanced energy", result.summary["energy_error"], 0.0, 0.01),
    ]


def viscous() -> CaseResult:
    """Where μ rises in proportion to the speed, v = (a/b)(1 − e^(−bt)), a = g sin α."""
    duration, angle, slower, rise = 0.02, 0.4, 50.0, 100.0
    law = Friction(coefficient=1.0, by_speed=((0.0, 0.0), (1.0, rise)))
    way = _slide(law, angle, duration, process_duration=slower * duration)
    a, b = GRAVITY * math.sin(angle), rise / slower * GRAVITY * math.cos(angle)
    exact = a / b * (duration - (1.0 - math.exp(-b * duration)) / b)
    return relative("incline: way slid, friction by speed", way, exact, 0.01, "m")


def pressed() -> CaseResult:
    """Where μ falls with pressure, that of the block's own weight."""
    duration, angle = 0.03, 0.4
    law = Friction(coefficient=0.3, by_pressure=((0.0, 0.5), (10.0, 0.05)))
    mu = law(pressure=yarn_fabric(1e5, 0.6).areal_density * GRAVITY * math.cos(angle))
    exact = 0.5 * GRAVITY * (math.sin(angle) - mu * math.cos(angle)) * duration**2
    way = _slide(law, angle, duration)
    return relative("incline: way slid, friction by pressure", way, exact, 0.01, "m")


def friction(quick: bool) -> list[CaseResult]:
    """All cases of this file."""
    return [*incline(), viscous(), pressed(), capstan(), *roller()]
