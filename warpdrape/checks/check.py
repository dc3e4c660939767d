"""``warpdrape check``: what will be run, in words and as a picture, without running it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from warpdrape.announcement import LONG, RATE, announcement
from warpdrape.checks.picture import draw_start
from warpdrape.checks.words import cautions, geometry_words
from warpdrape.contact.closing import closing_tools
from warpdrape.defects.limits import Limits
from warpdrape.fishnet_result import unseen
from warpdrape.results.progress import in_words
from warpdrape.setup import Setup
from warpdrape.simulation import prepare
from warpdrape.wording import brief


def check_scene(
    scene: Setup, out: Path, *, device: str, frames: int, say: Callable[[str], None]
) -> None:
    """Say what a scene will do and draw it, then make the checks that a run makes at its start.

    The picture comes before the checks: it shows what they refuse.

    Args:
        scene: what would be computed.
        out: the picture.
        device: "cpu" or "cuda:0".
        frames: after the first.
        say: takes each part of the words.

    Raises:
        InputError: if a run of it would be refused, or the picture cannot be written.
    """
    fishnet = scene.approach == "fishnet"
    process = (
        f" for {scene.process_duration:.4g} s of the process" if scene.process_duration else ""
    )
    say(f"{scene.name}: {1e3 * scene.duration:.4g} ms{process}, by the approach {scene.approach!r}")
    say(f"\n{geometry_words(scene)}")
    if scene.air is not None:
        say(f"\n{brief(scene.air)}")
    say(f"\nLimits: {_limit_words(scene.limits)}")
    say(f"\nPicture: {draw_start(scene, out)}")
    say(f"\nRun: {_net_words() if fishnet else _run_words(scene, device, frames)}")
    noted = [*map(str, closing_tools(scene)), *(unseen(scene) if fishnet else ()), *cautions(scene)]
    if noted:
        say("\n" + "\n".join(["Warnings:", *(f"  {words}" for words in noted)]))


def _net_words() -> str:
    return "a net of yarns on the closed tools, in seconds; without forces, clamps or friction"


def _run_words(scene: Setup, device: str, frames: int) -> str:
    """What a run announces, and a guess at the time of a short one."""
    model, state = prepare(scene, device, frames)
    words = announcement(model, state, 0, written=True)
    work = model.timing.steps * model.triangles
    if work <= LONG * RATE:
        words += f"; about {in_words(work / RATE)} on one thread"
    return f"{words}; {frames} frames"


def _limit_words(limits: Limits | None) -> str:
    if limits is None:
        return "those of warpdrape judge by default"
    given = brief(limits).partition(": ")[2]
    return f"{given}; others by default" if given else "those by default"
