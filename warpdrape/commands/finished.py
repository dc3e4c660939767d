"""Whether a folder holds a finished run of a scene as it stands, so that it need not run again."""

from __future__ import annotations

from pathlib import Path

from warpdrape.errors import InputError
from warpdrape.results.run_folder import RESULTS, partial_path
from warpdrape.results.run_tables import check_whole, read_record, read_summary
from warpdrape.results.same_scene import record_difference, record_of
from warpdrape.setup import Setup
from warpdrape.stops import asked_to_end

_OF_CALL = ("scene", "digest", "extensions")
_OF_RUN = ("call", "versions", "frames", "device")


def holds_results(folder: Path) -> bool:
    """Whether a folder holds results of a run, finished or not."""
    finals = [folder / name for name in RESULTS]
    return any(path.exists() for path in [*finals, *map(partial_path, finals)])


def what_differs(folder: Path, scene: Setup, *, frames: int, device: str) -> str:
    """Say why the run of a folder cannot stand for a scene; empty where it can.

    Args:
        folder: that holds results.
        scene: as it would be run.
        frames: after the first.
        device: of the run.
    """
    try:
        check_whole(folder)
        summary = read_summary(folder)
        record = read_record(folder, needed=_OF_RUN)
    except InputError as error:
        return f"no finished run ({error})"
    call, version = record["call"], record["versions"]["warpdrape"]
    there = record["frames"], record["device"]
    if summary["status"] != "completed":
        way = ", and warpdrape resume goes on with it" if asked_to_end(summary["message"]) else ""
        return f"a run that failed ({summary['message']}{way})"
    wanted = record_of(scene, frames)
    if other := record_difference(record, wanted):
        return other
    if any(call.get(name) != wanted["call"].get(name) for name in _OF_CALL):
        return "a run of another script, or of the script as it was before"
    if version != wanted["versions"]["warpdrape"]:
        return f"a run of version {version}"
    if "not_given" not in summary and there != (frames, device):
        return f"a run with frames = {there[0]} on {there[1]}"
    return ""
