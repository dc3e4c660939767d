"""The steps of a run: how long, how many to a frame, and how often contacts are searched."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from warpdrape.errors import InputError
from warpdrape.kernels.contact import look_ahead
from warpdrape.numerics import Numerics
from warpdrape.setup import Setup

SLOWEST_TOOL = 0.1
"""Speed [m/s] that contact searches allow for at least, as plies may move faster than tools."""
SLOWEST = 1.0
"""Speed [m/s] that contact searches allow for when no tool moves."""
ASK_EVERY = int(look_ahead.ASK_EVERY)
"""Contact searches from one in which every point asks for the nearest facet of a ply to the next
such one; between, it walks from the facet that it remembers."""
LOOKS = 240
"""Looks at the energies in a run whose motions they may hold back, at full pace, at least."""


@dataclass(frozen=True, eq=False)
class Timing:
    """Steps of a run.

    Attributes:
        time_step: Δt [s].
        stable_step: largest stable step [s].
        search_every: steps between two contact searches.
        frames: frames after the first.
        steps_per_frame: a multiple of ``search_every``.
        steps_ahead: steps whose motions are known at a time, likewise: a frame's, or those up to
            the next look at the energies.
    """

    time_step: float
    stable_step: float
    search_every: int
    frames: int
    steps_per_frame: int
    steps_ahead: int

    @property
    def steps(self) -> int:
        """Steps in all."""
        return self.frames * self.steps_per_frame


def ask_every(numerics: Numerics) -> int:
    """Contact searches of which one lets every point ask: see `ASK_EVERY`, or each if exact."""
    return 1 if numerics.contact == "exact" else ASK_EVERY


def frame_times(timing: Timing, frame: int) -> np.ndarray:
    """Time before the first step that leads to a frame, numbered from 1, and after each [s]."""
    steps = np.arange(timing.steps_per_frame + 1) + (frame - 1) * timing.steps_per_frame
    return steps * timing.time_step


def peak_speed(scene: Setup) -> float:
    """Largest speed [m/s] that tools and clamps reach, as contact searches allow for it."""
    moving = [tool.peak_speed for tool in scene.tools]
    moving += [clamp.motion.peak_speed for clamp in scene.clamps]
    return max([*moving, SLOWEST_TOOL]) if any(moving) else SLOWEST


def plan_steps(scene: Setup, stable: float, frames: int) -> Timing:
    """Divide a run into frames of whole blocks of steps, each as long as one search serves.

    Args:
        scene: what is computed.
        stable: largest stable step [s].
        frames: frames after the first.

    Raises:
        InputError: if the scene asks for a step above the stable one.
    """
    step = choose_step(scene, stable)
    per_search = math.floor(scene.numerics.search_slide / (peak_speed(scene) * step))
    every = 1 if scene.numerics.contact == "exact" else min(max(per_search, 1), 256)
    per_frame = every * math.ceil(scene.duration / (frames * every * step))
    looks = 1 if scene.numerics.kinetic_limit is None else math.ceil(LOOKS / frames)
    ahead = every * max(per_frame // (every * looks), 1)
    return Timing(scene.duration / (frames * per_frame), stable, every, frames, per_frame, ahead)


def choose_step(scene: Setup, stable: float) -> float:
    """Step to use [s].

    Raises:
        InputError: if the scene asks for more than the stable step.
    """
    asked = scene.numerics.time_step
    if asked is None:
        return scene.numerics.safety * stable
    if asked > stable:
        raise InputError(
            f"time_step = {asked:.4g} s is above the stable {stable:.4g} s: leave it out, "
            "or set minimum_time_step to add mass"
        )
    return asked
