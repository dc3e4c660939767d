"""The command line; what is heavy to import is imported by the command that needs it."""

from __future__ import annotations

import argparse
import io
import os
import re
import sys
import warnings
from collections.abc import Sequence
from contextlib import nullcontext, redirect_stdout
from typing import NoReturn

from warpdrape.command_line import (
    calibrate,
    check,
    compare,
    export,
    fabrics,
    info,
    judge,
    new,
    optimise,
    picture,
    report,
    resume,
    run,
    scenes,
    study,
    unit_cell,
    verify,
)
from warpdrape.command_line.command import DONE, FAILED, UNUSABLE, Command, complain

COMMANDS: dict[str, Command] = {
    module.COMMAND.name: module.COMMAND
    for module in (
        new,
        check,
        run,
        resume,
        compare,
        scenes,
        fabrics,
        picture,
        export,
        judge,
        report,
        calibrate,
        unit_cell,
        study,
        optimise,
        verify,
        info,
    )
}
"""By name, in the order of the help."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status: 0 done, 1 failed, 2 unusable input.

    Args:
        argv: the arguments; those of the process if None.
    """
    _never_fail_to_print()
    with warnings.catch_warnings():
        warnings.showwarning = _show_warning
        try:
            return _dispatch(list(sys.argv[1:] if argv is None else argv))
        except KeyboardInterrupt:
            return complain("interrupted", FAILED)
        except BrokenPipeError:  # as in "warpdrape fabrics | head"
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return FAILED
        except MemoryError:
            return complain("out of memory: take fewer cells or larger facets", FAILED)
        except Exception as error:
            return _explain(error, list(sys.argv[1:] if argv is None else argv))


def run_script(path: str | os.PathLike[str]) -> NoReturn:
    """Run the scene script at ``path`` as ``warpdrape run`` does, and end the process.

    For the end of a script, below ``if __name__ == "__main__":``; imported there, so that who only
    builds the scene has no command line with it.
    """
    raise SystemExit(main(["run", os.fspath(path), *sys.argv[1:]]))


class _Parser(argparse.ArgumentParser):
    """A parser that says what is wrong in one line."""

    def error(self, message: str) -> NoReturn:
        from warpdrape.errors import InputError

        raise InputError(f"{message} (see {self.prog} --help)")


def build_parser() -> argparse.ArgumentParser:
    """The parser of the whole command line."""
    parser = _Parser(
        prog="warpdrape",
        allow_abbrev=False,
        description="Forming simulation of woven plies: shear, wrinkles, draw-in, forces.",
        epilog="Start with:  warpdrape run hemisphere",
    )
    parser.add_argument("--version", action="version", version=f"warpdrape {_version()}")
    parsers = parser.add_subparsers(dest="command", metavar="COMMAND", title="commands")
    for command in COMMANDS.values():
        words = command.words
        one = parsers.add_parser(
            command.name,
            help=words,
            description=f"{words[0].upper()}{words[1:]}.",
            epilog=command.epilog,
            allow_abbrev=False,
        )
        hidden = "show no progress" if command.shows_progress else "print nothing but what is wrong"
        one.add_argument("-q", "--quiet", action="store_true", help=hidden)
        command.add_arguments(one)
    return parser


_SIGNED = re.compile(r"-(\.?\d|[xyzXYZ](?![A-Za-z]))")


def joined(argv: Sequence[str]) -> list[str]:
    """Arguments where ``--up -z``, ``--angles -45,45`` or ``--trim -x+z>2mm`` is one.

    argparse sees an option in all that begins with a dash.
    """
    out: list[str] = []
    for word in argv:
        before = out[-1] if out else ""
        if _SIGNED.match(word) and before.startswith("--") and "=" not in before:
            out[-1] = f"{before}={word}"
        else:
            out.append(word)
    return out


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("warpdrape")
    except PackageNotFoundError:
        return "(not installed)"


def _dispatch(argv: list[str]) -> int:
    parser = build_parser()
    if argv and not argv[0].startswith("-") and argv[0] not in COMMANDS:
        from warpdrape.errors import one_of

        one_of("command", argv[0], COMMANDS)
    try:
        arguments = parser.parse_args(joined(argv))
    except SystemExit as end:  # --help and --version have said what they had to
        return int(end.code or DONE)
    if arguments.command is None:
        parser.print_help()
        return DONE
    command = COMMANDS[arguments.command]
    silent = arguments.quiet and not command.shows_progress
    with redirect_stdout(io.StringIO()) if silent else nullcontext():
        return command.act(arguments)


def _explain(error: Exception, argv: Sequence[str]) -> int:
    from warpdrape.errors import InputError, RunFailed

    if isinstance(error, InputError):
        return complain(error, UNUSABLE)
    if isinstance(error, RunFailed):
        return complain(error, FAILED)
    from warpdrape.fault_log import keep_fault, where

    kept = keep_fault(error, argv)
    return complain(
        f"unexpected {type(error).__name__}{where(error)}: {error}; please report it as a fault of "
        + (f"warpdrape, with the file {kept}" if kept else "warpdrape"),
        FAILED,
    )


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    print("warpdrape: warning:", " ".join(str(message).split()), file=sys.stderr)


def _never_fail_to_print() -> None:
    """Let a terminal that lacks a character, such as γ, show a question mark instead."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
