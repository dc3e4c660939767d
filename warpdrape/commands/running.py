"""The commands that compute: ``run`` and ``resume``."""

from __future__ import annotations

import argparse
import gc
import sys
import warnings
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from warpdrape.commands.interrupts import interrupt_kept
from warpdrape.commands.values import OUT, whole

if TYPE_CHECKING:
    from warpdrape.results.result import Result
    from warpdrape.scene import Scene


def run(arguments: argparse.Namespace) -> Result:
    """Run a scene from its start."""
    from warpdrape.cadence import read_cadence
    from warpdrape.commands.scene_library import find_typed
    from warpdrape.results.run_folder import RunFolder

    frames = whole("--frames", arguments.frames, least=1)
    threads = None
    if arguments.threads is not None:
        threads = whole("--threads", arguments.threads, least=1)
    read_cadence(arguments.checkpoint)
    with interrupt_kept(), _garbage_left():
        script = find_typed(arguments.scene)
        script.read_settings(arguments.settings)  # a slip of the pen need not wait for Warp
    folder = Path(arguments.out) if arguments.out is not None else Path(OUT, script.name)
    RunFolder(folder, arguments.overwrite)
    start_for_runs(arguments.device)
    scene = script.make(arguments.settings)
    options = {"device": arguments.device, "frames": frames, "threads": threads}
    return _compute(scene, arguments, folder, out=folder, overwrite=arguments.overwrite, **options)


def resume(arguments: argparse.Namespace) -> Result | None:
    """Go on with a run from its last checkpoint; None for one that is complete."""
    from warpdrape.cadence import read_cadence
    from warpdrape.commands.extending import extended, read_extension
    from warpdrape.commands.resuming import begun, complete, scene_of
    from warpdrape.results.run_folder import RunFolder

    folder, extension = Path(arguments.run), None
    read_cadence(arguments.checkpoint)
    if arguments.extend is not None:
        extension = read_extension(arguments.extend)
    run = begun(folder)
    if extension is None and complete(folder):
        with closing(RunFolder.of_run(folder)) as left:  # by a run that was killed at its very end
            left.take()
        if arguments.report:
            _write_report(folder)
        return None
    with interrupt_kept(), _garbage_left():
        script = scene_of(folder, run, arguments.scene)
    start_for_runs(run.device)
    scene = extended(script.make(run.settings), run, extension)
    options: dict[str, Any] = {"device": run.device, "extend": extension is not None}
    if not run.started:
        options |= {"frames": run.frames, "threads": run.threads}
    return _compute(scene, arguments, folder, resume=folder, **options)


def start_for_runs(device: str) -> None:
    """Import all that a run does, and start Warp."""
    with interrupt_kept(), _garbage_left():
        import warpdrape.simulation  # noqa: F401
        from warpdrape.warp_start import check_device, start_warp

    start_warp()
    check_device(device)


@contextmanager
def _garbage_left() -> Iterator[None]:
    """Look for no garbage while modules are imported, nor among them later.

    There is none, and each look goes through all of them: a sixth of the time of the imports.
    """
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def announce_compiling(quiet: bool) -> None:
    """Say that kernels will be compiled, unless they are or nobody wants to know."""
    from warpdrape.warp_start import kernels_are_compiled

    if not quiet and not kernels_are_compiled():
        print("Compiling kernels: once per machine, half a minute or so.", file=sys.stderr)


def _compute(scene: Scene, arguments: argparse.Namespace, folder: Path, **options: Any) -> Result:
    """Compute a scene, and say how it went."""
    from warpdrape.results.summary_text import summary_text

    announce_compiling(arguments.quiet)
    result = scene.run(
        quiet=arguments.quiet,
        profile=arguments.profile,
        checkpoint=arguments.checkpoint,
        **options,
    )
    print(summary_text(result.summary, folder))
    if arguments.report:
        _write_report(folder)
    if arguments.profile and "phases_s" in result.summary:
        from warpdrape.dynamics.phases import phase_table

        print(f"\n{phase_table(result.summary['phases_s'])}")
    return result


def _write_report(folder: Path) -> None:
    """Write the run's report; what is wrong with it is a warning, as the run itself is safe."""
    from warpdrape.errors import InputError
    from warpdrape.report.report import write_report

    try:
        print(f"  {write_report([folder]).name:13} all of it as one page, for a browser")
    except InputError as error:
        warnings.warn(f"no report: {error}", stacklevel=2)
