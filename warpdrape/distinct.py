"""Which rows of an array differ."""

from __future__ import annotations

import numpy as np


def distinct_rows(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The different rows of an array in sorted order, as of ``numpy.unique`` with an axis.

    That sorts rows as records, which takes ten times as long as to sort column after column.

    Args:
        rows: shape [n, k], n above zero.

    Returns:
        Number of the first row of each kind, and the kind of each row, shape [n].
    """
    order = np.lexsort(rows.T[::-1])
    arranged = rows[order]
    new = np.append(True, (arranged[1:] != arranged[:-1]).any(axis=1))
    kind = np.empty(len(rows), dtype=np.intp)
    kind[order] = np.cumsum(new) - 1
    return order[new], kind
