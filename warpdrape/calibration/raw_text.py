"""The text of a laboratory's table: encoding, what separates columns, and the decimal mark."""

from __future__ import annotations

import csv
import re
from collections import Counter
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

from warpdrape.errors import InputError

DELIMITERS = (";", "\t", ",", "|")
"""In the order in which they are preferred; runs of spaces after all of them."""
COMMENTS = ("#", "%", "//", "!")
ONE_COLUMN = 0.3
"""Share of lines that must be cut alike, else the table has one column."""
LARGEST = 200_000_000
"""Bytes of a file beyond which it is no table of a test."""
_BOMS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))
_POINT = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_COMMA = re.compile(r"[-+]?(?:\d+,?\d*|,\d+)(?:[eE][-+]?\d+)?")
_THOUSANDS = {
    ".": re.compile(r"[-+]?\d{1,3}(?:,\d{3})+(?:\.\d*)?"),
    ",": re.compile(r"[-+]?\d{1,3}(?:[.' ]\d{3})+(?:,\d*)?"),
}
_HUNDREDS = re.compile(r"[-+]?[1-9]\d\d")
_GROUPED = {mark: re.compile(rf"[-+]?[1-9]\d{{0,2}}[{mark}]\d{{3}}") for mark in ",."}


@dataclass(frozen=True)
class RawText:
    """Cells of a file.

    Attributes:
        name: of the file.
        encoding: as it was read.
        delimiter: what separates columns, " " for runs of spaces, a line's end for one column.
        decimal: "." or ",".
        rows: cells of each line that is neither empty nor a comment.
        lines: number of each of these lines in the file, from 1.
    """

    name: str
    encoding: str
    delimiter: str
    decimal: str
    rows: list[list[str]]
    lines: list[int]

    def number(self, cell: str) -> float | None:
        """A cell as a number, None where it is none."""
        return read_number(cell, self.decimal)


def read_text(path: Path, delimiter: str = "", decimal: str = "") -> RawText:
    """Read a table's cells, finding out how they are written.

    Args:
        path: the file.
        delimiter: what separates columns; found out if "".
        decimal: "." or ","; found out if "".

    Raises:
        InputError: it cannot be read, is empty, or could be read in two ways.
    """
    try:
        if path.stat().st_size > LARGEST:
            raise InputError(f"{path.name} is larger than {LARGEST / 1e6:g} MB: cut it to the test")
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"raw data {path} cannot be read: {error.strerror}") from error
    text, encoding = _decoded(content, path.name)
    numbered = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith(COMMENTS)
    ]
    if not numbered:
        raise InputError(f"{path.name} holds no line of data: give the table of a test")
    lines = [line for _, line in numbered]
    if not delimiter:
        delimiter, numbered, lines = _announced(numbered, lines)
    delimiter = delimiter or _delimiter(lines)
    rows = [_cells(line, delimiter) for line in lines]
    decimal = decimal or _decimal(path.name, rows, delimiter)
    return RawText(path.name, encoding, delimiter, decimal, rows, [n for n, _ in numbered])


def read_number(cell: str, decimal: str) -> float | None:
    """A cell as a number under a decimal mark, None where it is none."""
    cell = cell.strip().replace("\u2212", "-").replace("\u00a0", "").replace("\u202f", "")
    if _THOUSANDS[decimal].fullmatch(cell):
        cell = re.sub(r"[.' ]" if decimal == "," else ",", "", cell)
    if decimal == ",":
        if not _COMMA.fullmatch(cell):
            return None
        return float(cell.replace(",", "."))
    return float(cell) if _POINT.fullmatch(cell) else None


def _decoded(content: bytes, name: str) -> tuple[str, str]:
    for mark, encoding in _BOMS:
        if content.startswith(mark):
            try:
                return content.decode(encoding), encoding
            except UnicodeDecodeError as error:
                raise InputError(f"{name}: damaged {encoding}: export the table again") from error
    if b"\x00" in content:
        raise InputError(f"{name} is no text (a workbook?): export the table as CSV")
    try:
        return content.decode("utf-8"), "utf-8"
    except UnicodeDecodeError:
        return content.decode("cp1252", errors="replace"), "cp1252"


def _announced(
    numbered: list[tuple[int, str]], lines: list[str]
) -> tuple[str, list[tuple[int, str]], list[str]]:
    """A spreadsheet's own first line ``sep=;``, taken off."""
    first = lines[0].strip().strip('"')
    if first.lower().startswith("sep=") and len(first) == 5:
        return first[4], numbered[1:], lines[1:]
    return "", numbered, lines


def _delimiter(lines: list[str]) -> str:
    """The one that cuts most lines into one and the same number of cells, most of them numbers."""
    sample = lines[-400:]
    best, score = "\n", ONE_COLUMN
    digits = any(ch.isdigit() for line in sample for ch in line)
    for delimiter in (*DELIMITERS, " "):
        cut = [_cells(line, delimiter) for line in sample]
        counts = Counter(len(cells) for cells in cut if len(cells) > 1)
        if not counts:
            continue
        cells = [cell for each in cut for cell in each if cell]
        numbers = sum(any(read_number(c, d) is not None for d in ".,") for c in cells)
        rank = counts.most_common(1)[0][1] / len(sample)
        if digits:
            rank *= numbers / max(len(cells), 1)
        if rank > score + 1e-9:
            best, score = delimiter, rank
    return best


def _cells(line: str, delimiter: str) -> list[str]:
    if delimiter == " ":
        return line.split()
    if delimiter == "\n":
        return [line.strip()]
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter))]


def _looks_like_data(row: list[str]) -> bool:
    """Whether all cells are numbers, or all but the name of a specimen beside two or more."""
    given = [cell for cell in row if cell]
    numbers = sum(any(read_number(cell, d) is not None for d in ".,") for cell in given)
    return numbers == len(given) > 0 or (numbers >= 2 and numbers == len(given) - 1)


def _decimal(name: str, rows: list[list[str]], delimiter: str) -> str:
    """The decimal mark that all cells of data agree on; a preamble's version number has no say."""
    data = [row for row in rows if _looks_like_data(row)] or rows
    cells = [cell for row in data for cell in row if any(ch.isdigit() for ch in cell)]
    commas = [c for c in cells if "," in c and read_number(c, ",") is not None]
    points = [c for c in cells if "." in c and read_number(c, ".") is not None]
    if not commas:
        _refuse_grouped(name, data, points, ".")
        return "."
    if not points:
        if delimiter == "," and all(_THOUSANDS["."].fullmatch(c) for c in commas):
            return "."
        _refuse_grouped(name, data, commas, ",")
        return ","
    only_comma = [c for c in commas if read_number(c, ".") is None]
    only_point = [c for c in points if read_number(c, ",") is None]
    if only_comma and not only_point:
        return ","
    if only_point and not only_comma:
        return "."
    raise InputError(
        f"{name} has numbers with decimal commas ({(only_comma or commas)[0]}) and with decimal "
        f"points ({(only_point or points)[0]}): export it with one, or say decimal = "
        '"," of the test'
    )


def _refuse_grouped(name: str, data: list[list[str]], marked: list[str], mark: str) -> None:
    """Raise `InputError` for a column such as 998, 1,002: a thousand and two, or one and a bit.

    Where every mark of the table stands before three digits, and whole numbers of three digits are
    above or below one, it marks thousands most likely: taken for the decimal mark the curve would
    fall to a thousandth where it passes 1000.
    """
    if not marked or not all(_GROUPED[mark].fullmatch(cell) for cell in marked):
        return
    for column in zip_longest(*data, fillvalue=""):
        whole = [c for c in column if _HUNDREDS.fullmatch(c)]
        beside = [c for c in column if mark in c]
        if whole and beside:
            other = "," if mark == "." else "."
            raise InputError(
                f"{name} has {whole[0]} and {beside[0]} in one column: say decimal = "
                f'"{other}" of the test if that is {beside[0].replace(mark, "")}, decimal = '
                f'"{mark}" if it is {beside[0].replace(mark, ".")}'
            )
