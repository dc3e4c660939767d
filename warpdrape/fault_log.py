"""A fault of the program itself: what is needed to find it, in a file that a user can send."""

from __future__ import annotations

import platform
import shlex
import tempfile
import traceback
from collections.abc import Sequence
from pathlib import Path


def keep_fault(error: Exception, argv: Sequence[str]) -> Path | None:
    """Write traceback, command and versions to a file of the temporary folder.

    Args:
        error: that nobody foresaw.
        argv: arguments of the command line.

    Returns:
        The file; None where none can be written.
    """
    lines = [f"warpdrape {shlex.join(argv)}", platform.platform(), *_versions(), ""]
    lines += traceback.format_exception(error)
    try:
        with tempfile.NamedTemporaryFile(
            "w", encoding="utf-8", prefix="warpdrape-fault-", suffix=".txt", delete=False
        ) as file:
            file.write("\n".join(lines))
    except (OSError, ValueError):
        return None
    return Path(file.name)


def where(error: BaseException) -> str:
    """File and line that an error came from, in words; empty where that is not known."""
    steps = traceback.extract_tb(error.__traceback__)
    return f" in {Path(steps[-1].filename).name}, line {steps[-1].lineno}" if steps else ""


def _versions() -> list[str]:
    try:
        from warpdrape.results.run_record import versions

        return [f"{name} {version}" for name, version in versions().items()]
    except Exception:  # whatever is broken must not hide the fault itself
        return []
