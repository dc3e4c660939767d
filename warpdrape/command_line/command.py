"""What a command is, how it ends, and how it says so."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from warpdrape.results.result import Result

DONE, FAILED, UNUSABLE, UNFIT = 0, 1, 2, 3
"""Exit status: all went well; the run failed; the input cannot be used; the part is unfit."""


@dataclass(frozen=True)
class Command:
    """A command: its words, the arguments it takes, and what it does with them.

    Attributes:
        name: as it is typed.
        words: what it does, for the list of commands.
        act: does it and returns the exit status; imports what is heavy itself.
        add_arguments: adds its arguments to a parser; it takes none if not given.
        epilog: what its help says at the end.
        shows_progress: with ``--quiet`` it hides that alone; other commands print nothing but
            what is wrong.
    """

    name: str
    words: str
    act: Callable[[argparse.Namespace], int]
    add_arguments: Callable[[argparse.ArgumentParser], None] = lambda parser: None
    epilog: str = ""
    shows_progress: bool = False


def complain(message: object, status: int) -> int:
    """Say what is wrong in one line on standard error, and return ``status``."""
    sys.stdout.flush()
    print("warpdrape: error:", " ".join(str(message).split()), file=sys.stderr)
    return status


def teller(quiet: bool) -> Callable[[str], None]:
    """What prints a line of progress on standard error, or swallows it."""
    if quiet:
        return lambda line: None
    return lambda line: print(line, file=sys.stderr, flush=True)


def print_list(lines: dict[str, str]) -> None:
    """Print names and what they stand for in two columns."""
    width = max(map(len, lines))
    for name, text in lines.items():
        print(f"{name:{width}}  {text}")


def ended(result: Result) -> int:
    """The exit status of a run, and its message where it failed."""
    return DONE if result.completed else complain(result.summary["message"], FAILED)
