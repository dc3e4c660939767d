"""Tables in the pages of the documentation, between two lines that name them."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"


def marks(name: str) -> tuple[str, str]:
    """The lines before and after a table."""
    return f"<!-- table {name}: python bench/shapes {name} --write -->", f"<!-- end of {name} -->"


def written(page: str, name: str, table: str, docs: Path = DOCS) -> Path:
    """Put a table into its page, in the place of the one that is there.

    Args:
        page: the page, from the folder of the documentation.
        name: of the table.
        table: in Markdown.
        docs: the folder.

    Raises:
        SystemExit: if the page has no place for it.
    """
    path = docs / page
    start, end = marks(name)
    text = path.read_text("utf-8")
    place = re.compile(f"{re.escape(start)}\n.*?{re.escape(end)}", re.DOTALL)
    if len(place.findall(text)) != 1:
        raise SystemExit(f"{path} must have one place for table {name}: {start} … {end}")
    new = place.sub(lambda _: f"{start}\n\n{table}\n\n{end}", text)
    partial = path.with_name(path.name + ".partial")
    partial.write_text(new, "utf-8")
    os.replace(partial, path)
    return path


def markdown(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [headings, ["---"] * len(headings), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
