"""Tables of the benchmark shapes, from runs: ``python bench/shapes [TABLE ...] [--write]``.

Each table is on a page of ``docs``, between two lines that name it, and each of its rows is a run
of the command line's own scenes. Runs are kept in ``--runs`` and not done again while scene and
parameters are the same; ``--again`` does them anew. Tables are printed; ``--write`` puts them into
the pages.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from pages import written
from runs import Runs
from tables import TABLES


def main() -> int:
    """Make the tables that are asked for."""
    parser = argparse.ArgumentParser(
        prog="python bench/shapes", description=(__doc__ or "").partition("\n")[0]
    )
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=f"of: {', '.join(TABLES)}; all")
    parser.add_argument("--runs", type=Path, default=Path("runs/shapes"), help="folder of the runs")
    parser.add_argument("--again", action="store_true", help="run what is there already")
    parser.add_argument("--write", action="store_true", help="put the tables into the pages")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.tables if name not in TABLES]
    if unknown:
        parser.error(f"no table {unknown[0]!r}: there are {', '.join(TABLES)}")
    runs = Runs(arguments.runs, again=arguments.again)
    for name in arguments.tables or TABLES:
        page, make = TABLES[name]
        table = make(runs)
        print(f"\n{name} ({page})\n\n{table}", flush=True)
        if arguments.write:
            written(page, name, table)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
