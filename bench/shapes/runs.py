"""Runs of bundled scenes, kept in folders and done once."""

from __future__ import annotations

import re
import sys
import time
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from warpdrape import Result, Scene, read_run
from warpdrape.commands.finished import holds_results, what_differs
from warpdrape.commands.scene_library import find_script

FRAMES = 60


@dataclass(frozen=True)
class Run:
    """A finished run.

    Attributes:
        folder: where it is.
        scene: what was run.
    """

    folder: Path
    scene: Scene

    @cached_property
    def result(self) -> Result:
        """The last frame, with summary and history."""
        return read_run(self.folder)

    def at(self, frame: int) -> Result:
        """Another frame, with the same summary and history."""
        return self.result if frame == FRAMES else read_run(self.folder, frame=frame)

    @property
    def summary(self) -> dict[str, Any]:
        """As in ``summary.json``."""
        return self.result.summary


class Runs:
    """Runs by scene and settings.

    Args:
        folder: of all of them.
        again: whether to run what is there.
    """

    def __init__(self, folder: Path, *, again: bool = False) -> None:
        self._folder, self._again, self._done = folder, again, set()

    def run(self, name: str, **settings: str | float) -> Run:
        """Run a scene, as ``warpdrape run NAME --set …`` does, unless it has been run.

        Args:
            name: of the scene.
            settings: its parameters.

        Raises:
            SystemExit: if the run fails.
        """
        texts = [f"{key}={value}" for key, value in settings.items()]
        label = re.sub(r"[^\w=.-]+", "_", " ".join([name, *texts]))
        folder = self._folder / label
        scene = find_script(name).make(texts)
        there = holds_results(folder)
        old = self._again and label not in self._done
        if not there or old or what_differs(folder, scene, frames=FRAMES, device="cpu"):
            started = time.process_time()
            result = scene.run(folder, frames=FRAMES, threads=1, quiet=True, overwrite=there)
            took = time.process_time() - started
            print(f"{label}: {took:.0f} s of processor time", file=sys.stderr, flush=True)
            if result.summary["status"] != "completed":
                raise SystemExit(f"{label} failed: {result.summary['message']}")
        self._done.add(label)
        return Run(folder, scene)
