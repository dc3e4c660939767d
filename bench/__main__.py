"""Time warpdrape against a plain C loop on the same machine: ``python bench [CASE ...]``.

Every figure is triangle-steps per second of processor time, and also its ratio to `calib.c` (double
precision, with shear) measured just before, so that it survives a noisy machine. The table is
printed, and written with the machine's particulars to ``bench.json`` (``--out``).
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
from pathlib import Path

from cases import CASES, Measurement
from yardstick import Yardstick


def table(rows: list[Measurement]) -> str:
    """Rows for a terminal."""
    lines = [f"{'case':32} {'triangles':>10} {'Mtri-steps/s':>13} {'ratio':>6} {'peak MB':>8}"]
    for row in rows:
        lines.append(
            f"{row.case:32} {row.triangles:10,} {row.rate / 1e6:13.2f} {row.ratio:6.3f} "
            f"{row.peak_mb:8.0f}"
        )
        lines += [f"    {name:28} {100 * share:6.1f} %" for name, share in row.phases.items()]
    return "\n".join(lines)


def main() -> int:
    """Run the chosen cases."""
    parser = argparse.ArgumentParser(prog="python bench", description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", help=f"of: {', '.join(CASES)}; all if none is named")
    parser.add_argument("--out", type=Path, default=Path("bench.json"), help="file for the figures")
    parser.add_argument("--repeat", type=int, default=3, help="medians over so many")
    chosen = parser.parse_args()
    unknown = sorted(set(chosen.cases) - set(CASES))
    if unknown:
        parser.error(f"unknown case {unknown[0]!r}; known: {', '.join(CASES)}")
    yardstick = Yardstick.build()
    rows = []
    for name in chosen.cases or CASES:
        rows.append(CASES[name](name, yardstick, chosen.repeat))
        print(table(rows[-1:]), flush=True)
    record = {
        "machine": platform.machine(),
        "python": platform.python_version(),
        "rows": [row.__dict__ for row in rows],
    }
    chosen.out.write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
