"""The list of primvars on the usage page is that of the file."""

import re
from pathlib import Path

from warpdrape.results.fields import FIELDS

PAGE = Path(__file__).parents[1].joinpath("docs/usage.md").read_text("utf-8")


def test_every_primvar_is_on_the_page_with_its_place():
    table = PAGE.partition("| primvar | per | is |")[2].partition("\n\n")[0]
    rows = re.findall(r"^\| (`[^|]+) \| (\w+) \|", table, re.MULTILINE)
    shown = {name: place for names, place in rows for name in re.findall(r"`(\w+)`", names)}
    expected = {f.primvar: "vertex" if f.at_vertices else "triangle" for f in FIELDS}
    assert shown == expected | {"displayColor": "triangle", "restPoints": "vertex"}
