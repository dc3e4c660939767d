"""The result of a run in words and tables, from its summary."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from warpdrape.report.markup import Html, element, joined, table
from warpdrape.results import summary_text
from warpdrape.results.defect_text import defect_lines, judgement_lines
from warpdrape.results.numerical_error import numerical_error_text


def result_section(summary: Mapping[str, Any]) -> Html:
    """Everything that a summary says, in the order of the lines at the end of a run."""
    return joined(
        [
            *_warnings(summary),
            *_part("Plies", summary, _plies),
            *_part("Defects", summary, _defects),
            *_part("Tools", summary, _tools),
            *_part("Between plies", summary, _interfaces),
            *_part("How far to trust it", summary, _quality),
            *_part("What the scene reports", summary, _reported),
        ]
    )


def verdict_words(summary: Mapping[str, Any]) -> str:
    """How a run ended, in a line; of a failed one why."""
    ended = summary_text.verdict(summary)
    return ended if summary["status"] == "completed" else f"{ended}. {summary['message']}"


def _warnings(summary: Mapping[str, Any]) -> Iterator[Html]:
    if summary["warnings"]:
        yield element("h3", "Warnings")
        items = (element("li", warning) for warning in summary["warnings"])
        yield element("ul", *items, class_="warnings")


def _part(
    title: str, summary: Mapping[str, Any], write: Callable[[Mapping[str, Any]], Html | None]
) -> list[Html]:
    """A titled part; none where there is nothing to say."""
    inside = write(summary)
    return [] if inside is None else [element("h3", title), inside]


def _plies(summary: Mapping[str, Any]) -> Html:
    return table(summary_text.ply_rows(summary["plies"]), "Plies at the end", "numbers")


def _defects(summary: Mapping[str, Any]) -> Html | None:
    said = [line for text in defect_lines(summary["plies"]) for line in text.split("\n")]
    found: list[list[str]] = []
    for line in said:  # folded for a terminal: what is indented goes on
        if line.startswith("  ") and found:
            found[-1].append(line.strip())
        else:
            found.append([line])
    if not found:
        return None
    items = element("ul", *(element("li", " ".join(lines)) for lines in found))
    judged = [element("pre", text) for text in judgement_lines(summary)]
    return joined([items, *judged])


def _tools(summary: Mapping[str, Any]) -> Html | None:
    tools = summary["tools"]
    return table(summary_text.tool_rows(tools), "Tools", "numbers") if tools else None


def _interfaces(summary: Mapping[str, Any]) -> Html | None:
    pairs = summary["interfaces"]
    rows = summary_text.interface_rows(pairs)
    return table(rows, "Slip and pressure between plies", "numbers") if pairs else None


def _quality(summary: Mapping[str, Any]) -> Html:
    parts = [*summary_text.quality(summary).split("; "), numerical_error_text(summary)]
    return element("ul", *(element("li", part) for part in filter(None, parts)))


def _reported(summary: Mapping[str, Any]) -> Html | None:
    if not summary["reported"]:
        return None
    lines = (" ".join(line.split()) for line in summary_text.reported_lines(summary))
    return element("ul", *(element("li", line) for line in lines))


def side_by_side(names: Sequence[str], summaries: Sequence[Mapping[str, Any]]) -> Html:
    """Plies and tools of several runs beside each other."""
    return joined(
        [
            *_beside("Plies", names, summaries, "plies", summary_text.ply_rows),
            *_beside("Tools", names, summaries, "tools", summary_text.tool_rows),
            *_trust(names, summaries),
        ]
    )


def _beside(
    title: str,
    names: Sequence[str],
    summaries: Sequence[Mapping[str, Any]],
    entry: str,
    rows_of: Callable[[Any], list[tuple[str, ...]]],
) -> list[Html]:
    """A table with a row for each ply (or tool) of each run, those of one name together."""
    head: tuple[str, ...] = ()
    found: dict[str, list[tuple[str, ...]]] = {}
    for name, summary in zip(names, summaries, strict=True):
        head, *rows = rows_of(summary[entry])
        for row in rows:
            found.setdefault(row[0], []).append((f"{row[0]}: {name}", *row[1:]))
    body = [row for rows in found.values() for row in rows]
    return [element("h3", title), table([head, *body], title, "numbers")] if body else []


def _trust(names: Sequence[str], summaries: Sequence[Mapping[str, Any]]) -> list[Html]:
    items = []
    for name, summary in zip(names, summaries, strict=True):
        words = f"{verdict_words(summary)}; {summary_text.quality(summary)}"
        items.append(element("li", element("b", name), f": {words}"))
    return [element("h3", "How they ended, and how far to trust them"), element("ul", *items)]
