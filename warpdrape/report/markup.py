"""HTML in which nothing that a user or a run folder says can be more than text."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from html import escape
from typing import Any


class Html(str):
    """Text that is markup already; every other string is escaped where it is put in."""

    __slots__ = ()


def element(name: str, *inside: Any, **attributes: Any) -> Html:
    """Return an element.

    Args:
        name: of the element.
        inside: its content; what is not `Html` is text.
        attributes: by name, ``class_`` for class and ``data_x`` for data-x; None leaves one out.
    """
    given = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{escape(str(value))}"'
        for key, value in attributes.items()
        if value is not None
    )
    return Html(f"<{name}{given}>{joined(inside)}</{name}>")


def joined(parts: Iterable[Any], between: str = "") -> Html:
    """Put parts after each other."""
    texts = (part if isinstance(part, Html) else escape(str(part)) for part in parts)
    return Html(between.join(texts))


def table(rows: Sequence[Sequence[Any]], label: str, kind: str = "") -> Html:
    """Return a table whose first row is its head, and whose first column names the rows.

    Args:
        rows: cells, the head first.
        label: what the table is of, for who hears it.
        kind: its class.
    """
    head, *body = rows
    top = (element("th", cell, scope="col") for cell in head)
    parts = [element("thead", element("tr", *top))]
    lines = (
        element("tr", element("th", row[0], scope="row"), *(element("td", c) for c in row[1:]))
        for row in body
    )
    parts.append(element("tbody", *lines))
    whole = element("table", *parts, class_=kind or None)
    return element("div", whole, class_="wide", tabindex="0", role="group", aria_label=label)


def json_block(name: str, data: Any) -> Html:
    """Return data for the page's scripts, in which no text can end the block.

    Args:
        name: id of the block.
        data: what JSON knows; numbers must be finite.
    """
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    for sign in "<>&\u2028\u2029":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Html(f'<script type="application/json" id="{escape(name)}">{text}</script>')
