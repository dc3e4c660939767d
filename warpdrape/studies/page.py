"""A page of a report: one HTML file that needs no other."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Sequence
from pathlib import Path

from warpdrape.results.figures import Figure
from warpdrape.results.run_folder import write_whole

_STYLE = """body{font:15px/1.45 system-ui,sans-serif;color:#1a1d21;max-width:70rem;margin:2rem auto;
padding:0 1rem}table{border-collapse:collapse}td,th{padding:.15rem .8rem .15rem 0;text-align:left;
font-variant-numeric:tabular-nums}th{color:#5b6470;font-weight:600}img{max-width:100%}"""


def write_page(out: Path, title: str, parts: Sequence[str]) -> None:
    """Write a page in one move.

    Args:
        out: the file.
        title: in plain text.
        parts: of its body, as HTML.

    Raises:
        RunFailed: when the disk refuses.
    """
    text = (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{html.escape(title)}</title>'
        f"<style>{_STYLE}</style>\n" + "\n".join(parts) + "\n</html>\n"
    )
    write_whole(out, lambda p: p.write_text(text, "utf-8", newline="\n"))


def picture(out: Path, figure: Figure, words: str) -> str:
    """Write a figure as a file, and return it as an image within a page."""
    held = io.BytesIO()
    figure.savefig(held, format="png", facecolor="white")
    write_whole(out, lambda p: p.write_bytes(held.getvalue()))
    text = base64.b64encode(held.getvalue()).decode("ascii")
    return f'<p><img alt="{html.escape(words)}" src="data:image/png;base64,{text}"></p>'


def list_of(names: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table with a line of names."""
    head = "".join(f"<th>{html.escape(n)}</th>" for n in names)
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    return f"<table><tr>{head}</tr>{body}</table>"
