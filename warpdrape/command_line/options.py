"""Arguments that several commands take."""

from __future__ import annotations

import argparse

from warpdrape.commands.values import OUT


def add_scene(parser: argparse.ArgumentParser) -> None:
    """Add the scene that a command is about."""
    parser.add_argument(
        "scene",
        metavar="SCENE",
        help="a bundled name (see warpdrape scenes), or the "
        "path of a script with a function build()",
    )


def add_set(parser: argparse.ArgumentParser, words: str) -> None:
    """Add ``--set``, which may be repeated."""
    parser.add_argument(
        "--set", metavar="NAME=VALUE", action="append", default=[], dest="settings", help=words
    )


SCENE_VALUE = "a parameter of the scene, in SI units; may be repeated"


def add_settings(parser: argparse.ArgumentParser) -> None:
    """Add the options of what runs a scene from its start."""
    add_set(parser, SCENE_VALUE)
    add_device(parser)
    parser.add_argument(
        "--frames",
        metavar="N",
        default="60",
        help="frames of the animation and rows of the history; 60 if not given",
    )
    parser.add_argument(
        "--threads",
        metavar="N",
        help="threads of the CPU; if not given, the physical cores for a large model, "
        "one for a small one",
    )


def add_device(parser: argparse.ArgumentParser) -> None:
    """Add the processor that computes."""
    parser.add_argument("--device", default="cpu", help="cpu (the default) or cuda:0")


def add_how(parser: argparse.ArgumentParser) -> None:
    """Add the options of whatever computes a run."""
    parser.add_argument("--profile", action="store_true", help="show where the time went")
    parser.add_argument(
        "--report", action="store_true", help="write report.html too, as warpdrape report does"
    )
    parser.add_argument(
        "--checkpoint",
        metavar="EVERY",
        default="auto",
        help="keep one every so many frames (5) or seconds (60s), or none; if not given, as often "
        "as it takes less than a hundredth of the time; another when a signal ends the run",
    )


def add_study_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of what runs a scene many times."""
    parser.add_argument("study", metavar="STUDY", help="a .toml file")
    parser.add_argument("--out", metavar="DIR", help=f"folder; {OUT}/NAME if not given")
    parser.add_argument("--workers", metavar="N", help="processes here; one a core if not given")
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="a Dask scheduler whose workers do the runs"
    )
    parser.add_argument(
        "--retry-failed", action="store_true", help="run again what did not complete"
    )
    parser.add_argument(
        "--plan", action="store_true", help="show what would be run, and run nothing"
    )
