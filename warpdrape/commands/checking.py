"""The command ``check``: what a scene will do, before it is run."""

from __future__ import annotations

import argparse
from pathlib import Path

from warpdrape.commands.interrupts import interrupt_kept
from warpdrape.commands.running import announce_compiling, start_for_runs
from warpdrape.commands.values import whole


def check(arguments: argparse.Namespace) -> None:
    """Say what a scene will do, draw it, and make the checks of a run's start."""
    from warpdrape.commands.scene_library import find_typed

    frames = whole("--frames", arguments.frames, least=1)
    with interrupt_kept():
        script = find_typed(arguments.scene)
        script.read_settings(arguments.settings)
    start_for_runs(arguments.device)
    announce_compiling(arguments.quiet)
    scene = script.make(arguments.settings)
    with interrupt_kept():
        from warpdrape.checks.check import check_scene
    out = Path(f"{script.name}_check.png" if arguments.out is None else arguments.out)
    check_scene(scene, out, device=arguments.device, frames=frames, say=print)
