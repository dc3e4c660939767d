"""Rows of an array that differ, against numpy's own way."""

import numpy as np
import pytest

from warpdrape.distinct import distinct_rows


@pytest.mark.parametrize("kind", [np.float32, np.float64, np.int64])
def test_rows_are_those_that_numpy_finds(kind):
    rows = np.random.default_rng(3).integers(-3, 4, (500, 3)).astype(kind)
    first, which = distinct_rows(rows)
    values, at, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    assert len(values) < len(rows)
    assert (rows[first] == values).all()
    assert (first == at).all()
    assert (which == inverse.ravel()).all()


def test_one_row_is_its_own_kind():
    first, which = distinct_rows(np.zeros((1, 2)))
    assert first.tolist() == which.tolist() == [0]
