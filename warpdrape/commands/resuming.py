"""What a run folder says of the run that is to go on: its scene, and whether to trust a script."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from warpdrape.commands.scene_library import SceneScript, bundled_scenes, digest_of, find_script
from warpdrape.errors import InputError
from warpdrape.restart import read_restart
from warpdrape.results.run_folder import RUN, SUMMARY, RunFolder


@dataclass(frozen=True)
class Begun:
    """A run that was begun.

    Attributes:
        scene: a bundled name, or the path of a script; empty for a scene from Python.
        digest: of the script as it was run.
        settings: as the command line gave them.
        extensions: likewise, one after the other.
        device: of the run.
        frames: of the run.
        threads: of the run.
        started: whether it has a checkpoint.
        at_end: whether that is at the end.
        duration: of the run [s].
    """

    scene: str
    digest: str
    settings: Sequence[str]
    extensions: Sequence[str]
    device: str
    frames: int
    threads: int
    started: bool
    at_end: bool
    duration: float


def begun(folder: Path) -> Begun:
    """Read what a run folder says of its run.

    Raises:
        InputError: if it is no run's, or what it says cannot be read.
    """
    RunFolder.of_run(folder)
    restart = read_restart(folder)
    if restart is not None:
        parts: Mapping[str, Any] = restart.parts
        call: Mapping[str, Any] | None = restart.call
        at_end = restart.frame == restart.timing.frames
        frames: Any = restart.timing.frames
    else:
        if not (folder / RUN).exists():
            raise InputError(
                f"run folder {folder} holds no checkpoint, and no {RUN}, as its run was cut off "
                "before its first frame: run the scene anew, with --overwrite"
            )
        parts = record(folder / RUN)
        if parts.get("approach") == "fishnet":
            raise InputError(
                f"run folder {folder} is a fishnet's, which has no checkpoints: run the scene "
                "again with --overwrite, which takes seconds"
            )
        call, at_end, frames = parts.get("call"), False, parts.get("frames")
    from_python = {"scene": "", "digest": "", "settings": [], "extensions": []}
    try:
        call = call or from_python
        return Begun(
            scene=_text(call["scene"]),
            digest=_text(call["digest"]),
            settings=[_text(each) for each in call["settings"]],
            extensions=[_text(each) for each in call["extensions"]],
            device=_text(parts["device"]),
            frames=int(frames),
            threads=int(parts["threads"]),
            started=restart is not None,
            at_end=at_end,
            duration=float(parts["duration"] if restart else parts["duration_s"]),
        )
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise InputError(
            f"run folder {folder} does not say how its run began ({error}): run the scene anew "
            "with --overwrite"
        ) from error


def record(path: Path) -> Mapping[str, Any]:
    """Read a JSON file of a run folder; raise `InputError` where it is damaged."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{path} cannot be read ({error}): run the scene anew") from error
    if not isinstance(found, Mapping):
        raise InputError(f"{path} is damaged: it holds no entries; run the scene anew")
    return found


def complete(folder: Path) -> bool:
    """Whether a run has come to its end, and all its results are there."""
    path = folder / SUMMARY
    return path.is_file() and record(path).get("status") == "completed"


def scene_of(
    folder: Path, run: Begun, given: str | None, command: str = "resume {run} --scene SCRIPT"
) -> SceneScript:
    """Return the run's scene.

    A run folder may come from elsewhere, so that it alone never says which code is run: a script
    must lie outside of it, and be the one that was run, or be named by the user.

    Args:
        folder: of the run.
        run: what it says.
        given: the scene as the user gives it, None to take the run's.
        command: how to give one, for messages.

    Raises:
        InputError: if it is from Python, gone, or another.
    """
    if given is not None:
        return find_script(given)
    if not run.scene:
        raise InputError(
            f"run folder {folder} is of a scene from Python: go on there, with "
            f"scene.run(resume={str(folder)!r})"
        )
    if run.scene in bundled_scenes():
        return find_script(run.scene)
    path = Path(run.scene)
    remedy = f"look at it, and name it yourself: warpdrape {command.format(run=folder)}"
    if not path.is_absolute() or not path.is_file():
        raise InputError(f"the run's script {path} is not there: {remedy}")
    if path.resolve().is_relative_to(folder.resolve()):
        raise InputError(f"the run's script {path} lies in the run folder: {remedy}")
    if digest_of(path) != run.digest:
        raise InputError(f"the run's script {path} has changed since: {remedy}")
    return find_script(path)


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r} is no text")
    return value
