"""How fast tools and clamps go through their motions: as given, or held back by kinetic energy.

Motions are functions of a time of their own, the *loading time*. It is the simulated time unless
`Numerics.kinetic_limit` is given: then it goes slower wherever plies and floating tools carry more
kinetic energy than that share of what the plies store, so that a stroke given too short becomes as
long as it must be, and only where it must.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warpdrape.blanks.ply import Ply
from warpdrape.blanks.triangles import flat_gradients
from warpdrape.materials.law_curves import sample_couples
from warpdrape.materials.law_data import initial_shear_stiffness, tension_stiffness
from warpdrape.materials.laws import Unwoven
from warpdrape.setup import Setup
from warpdrape.timing import Timing, frame_times

SLOWEST_PACE = 0.1
"""Least loading time that passes in a second [-]."""
SLOWING, HASTENING = 0.8, 1.1
"""Factors by which the pace changes at most from one look to the next [-]: tools that stop short
let go of what they push."""
UNLOADED_SHEAR, UNLOADED_STRAIN = math.radians(5.0), 2e-5
"""Plies that are sheared and stretched by less than this throughout count as hardly loaded: what
they store then is added to what they store. At the start of a stroke that is nothing, however slow
it is."""
PASSED = 2.0
"""Kinetic energy over the limit, at its largest, from which a run warns [-]."""


def reference_energy(plies: Sequence[Ply]) -> float:
    """Energy [J] that the plies store at `UNLOADED_SHEAR` and `UNLOADED_STRAIN` throughout."""
    total = 0.0
    for ply in plies:
        _, areas = flat_gradients(ply)
        if isinstance(ply.fabric.tension, Unwoven):
            sheared = 0.5 * initial_shear_stiffness(ply.fabric) * UNLOADED_SHEAR**2
        else:
            sheared = float(sample_couples(ply.fabric, np.array([UNLOADED_SHEAR]))[1][0])
        stretched = 0.5 * sum(tension_stiffness(ply.fabric)) * UNLOADED_STRAIN**2
        total += (sheared + stretched) * float(areas.sum())
    return total


@dataclass
class Clock:
    """All that changes of a `Loading`.

    Attributes:
        steps: done so far, or begun together.
        time: loading time after them [s].
        pace: loading time that passes in a second then [-].
        coming: the pace to come to by the next look [-].
        slowest: the slowest so far [-].
        most: kinetic energy over what is allowed, at its largest [-].
        left: how many of these steps are begun, but still to do.
    """

    steps: int = 0
    time: float = 0.0
    pace: float = 1.0
    coming: float = 1.0
    slowest: float = 1.0
    most: float = 0.0
    left: int = 0


class Loading:
    """The clock of the motions.

    Attributes:
        clock: all of it that changes.
    """

    def __init__(self, scene: Setup, timing: Timing, clock: Clock | None = None) -> None:
        """Begin at zero, at full pace; or go on from a clock."""
        self.clock = Clock() if clock is None else clock
        self._scene, self._timing = scene, timing
        self._limit = scene.numerics.kinetic_limit
        self._reference = reference_energy(scene.plies) if self.limited else 0.0

    @property
    def steps(self) -> int:
        """Done so far, those of the stretch among them."""
        return self.clock.steps

    @property
    def time(self) -> float:
        """Loading time at the end of the stretch [s]."""
        return self.clock.time

    @property
    def left(self) -> int:
        """Steps of the stretch that are still to do."""
        return self.clock.left

    @property
    def here(self) -> float:
        """Loading time within the stretch [s], near enough to be shown where the pace changes."""
        return self.time - self.left * self._timing.time_step * self.pace

    def did(self, steps: int) -> None:
        """Take note of steps of the stretch that were done."""
        self.clock.left -= steps

    @property
    def pace(self) -> float:
        """Loading time that passes in a second now [-]."""
        return self.clock.pace

    @property
    def limited(self) -> bool:
        """Whether the kinetic energy holds the motions back."""
        return self._limit is not None

    @property
    def simulated(self) -> float:
        """Simulated time so far [s]."""
        return self.steps * self._timing.time_step

    def come_to(self, frame: int) -> bool:
        """Whether loading has come to a frame; they are evenly spaced in loading time."""
        if not self.limited:
            return self.steps >= frame * self._timing.steps_per_frame
        return self.time >= self._end(frame)

    def stretch(self, frame: int) -> np.ndarray:
        """Go on for some steps, at most to a frame.

        Args:
            frame: number of the frame to come, from 1.

        Returns:
            Loading times before the first of these steps and after each of them [s].
        """
        timing, clock = self._timing, self.clock
        if not self.limited:
            times = frame_times(timing, frame)
        else:
            steps = self._steps_to_look(frame)
            # The pace goes to the next one as 3r² − 2r³: tools feel neither jump nor corner.
            r = np.arange(steps + 1) / steps
            gone = clock.pace * r + (clock.coming - clock.pace) * (r**3 - 0.5 * r**4)
            times = clock.time + steps * timing.time_step * gone
            clock.pace = clock.coming
        clock.left = len(times) - 1
        clock.steps, clock.time = clock.steps + clock.left, float(times[-1])
        return times

    def adapt(self, kinetic: float, internal: float) -> None:
        """Choose the pace to come to by the next look; without a limit it stays as it is.

        Args:
            kinetic: energy of plies and floating tools now [J].
            internal: what the plies store now [J].
        """
        if self._limit is None:
            return
        if not math.isfinite(kinetic + internal):  # the run is about to fail: keep the pace
            return
        clock = self.clock
        allowed = self._limit * (max(internal, 0.0) + self._reference)
        clock.most = max(clock.most, kinetic / allowed)
        wanted = clock.pace * math.sqrt(allowed / kinetic) if kinetic > 0.0 else 1.0
        wanted = min(max(wanted, SLOWING * clock.pace), HASTENING * clock.pace)
        clock.coming = min(max(wanted, SLOWEST_PACE), 1.0)
        clock.slowest = min(clock.slowest, clock.coming)

    def entries(self) -> dict[str, float]:
        """Entries of ``summary.json``: the limit, how slow loading became, how well it was kept."""
        if self._limit is None:
            return {}
        return {
            "kinetic_limit": float(self._limit),
            "slowest_pace": self.clock.slowest,
            "kinetic_over_limit": self.clock.most,
        }

    def warnings(self) -> list[str]:
        """Warn where kinetic energy passed the limit by far."""
        if self.clock.most <= PASSED:
            return []
        return [
            f"kinetic energy came to {self.clock.most:.3g} times what kinetic_limit = "
            f"{self._limit:g} allows, at paces down to {self.clock.slowest:.2g}: lengthen the "
            "duration"
        ]

    def _end(self, frame: int) -> float:
        return frame * self._scene.duration / self._timing.frames * (1.0 - 1e-12)

    def _steps_to_look(self, frame: int) -> int:
        """Steps to the next look, or as many as lead just beyond a frame; whole blocks."""
        timing = self._timing
        every = timing.search_every
        mean = 0.5 * (self.pace + self.clock.coming)
        left = (self._end(frame) - self.time) / (mean * timing.time_step)
        return min(timing.steps_ahead, every * max(math.ceil(left / every), 1))
