"""A study: scene, parameters, design, measures, and how each run is computed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from warpdrape.commands.scene_library import SceneScript
from warpdrape.defects.limits import Limits
from warpdrape.studies.cards import Card
from warpdrape.studies.design import Design, Row
from warpdrape.studies.measures import Measure
from warpdrape.studies.parameters import Varied, exact

FRAMES = 10
"""Frames of each run, where nothing is asked: a study looks at how runs end."""


@dataclass(frozen=True)
class RunOptions:
    """How each run is computed.

    Attributes:
        frames: of its animation.
        device: "cpu" or "cuda:0".
        threads: of the processor.
        checkpoint: how often it keeps one, as of ``warpdrape run``.
    """

    frames: int = FRAMES
    device: str = "cpu"
    threads: int = 1
    checkpoint: str = "auto"


@dataclass(frozen=True)
class MapOptions:
    """What counts on maps.

    Attributes:
        locking_deg: shear angle past which a place counts as locked [deg]; None for the fabric's.
        wrinkle: amplitude above which it counts as wrinkled [m].
    """

    locking_deg: float | None = None
    wrinkle: float = 0.0


@dataclass(frozen=True, eq=False)
class Study:
    """A study as its file has it.

    Attributes:
        name: of the study.
        path: of its file.
        script: the scene.
        fixed: settings that all runs share, ``NAME=VALUE``.
        parameters: what differs.
        design: how runs are chosen.
        options: how each is computed.
        measures: numbers that are taken from each.
        maps: what counts on maps.
        limits: what a part may have, for the column ``fit``; None without.
        card: of the fabric, where values of it vary.
    """

    name: str
    path: Path
    script: SceneScript
    fixed: tuple[str, ...]
    parameters: tuple[Varied, ...]
    design: Design
    options: RunOptions
    measures: tuple[Measure, ...]
    maps: MapOptions
    limits: Limits | None
    card: Card | None

    def rows(self) -> list[Row]:
        """Values of the parameters of every run."""
        return self.design.make(self.parameters)

    def settings(self, row: Row) -> list[str]:
        """Settings of a run, without the card that its folder may give it."""
        own = [f"{p.name}={exact(row[p.name])}" for p in self.parameters if p.own is not None]
        return [*self.fixed, *own]

    def card_values(self, row: Row) -> list[tuple[str, float, bool]]:
        """Values of the card that are a run's own: key, number, whether it is a factor."""
        return [(p.key, row[p.name], p.relative) for p in self.parameters if p.own is None]
