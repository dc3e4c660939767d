"""Weaves: their matrices, and what is none."""

import numpy as np
import pytest
from cell_checks import weaves

from warpdrape.errors import InputError
from warpdrape.unit_cell.weave import Weave, plain, satin, twill, weave_of


def test_weaves_are_those_of_the_textbook():
    assert plain().matrix() == [[1, 0], [0, 1]]
    assert twill(2, 2).matrix() == [[1, 1, 0, 0], [0, 1, 1, 0], [0, 0, 1, 1], [1, 0, 0, 1]]
    five = np.array(satin(5, 2).matrix())
    assert (five.sum(axis=0) == 1).all() and (five.sum(axis=1) == 1).all()
    bound = {(i, int(np.argmax(row))) for i, row in enumerate(five)}
    beside = {(i, (j + d) % 5) for i, j in bound for d in (-1, 1)}
    beside |= {((i + d) % 5, j) for i, j in bound for d in (-1, 1)}
    assert not bound & beside


@weaves()
def test_weft_yarns_are_moved_on_from_the_first_one(weave):
    over, n = weave.matrix(), weave.repeat
    for j in range(n):
        own = weave.weft_signs()
        for i in range(n):
            seen = own[(i - weave.weft_offset(j)) % n]
            assert seen == (-1 if over[i][j] else 1)


@pytest.mark.parametrize(
    ("make", "words", "mended"),
    [
        (lambda: satin(4), "twill 1/3", lambda: twill(1, 3)),
        (lambda: satin(5, 4), "2 … 3", lambda: satin(5, 3)),
        (lambda: satin(6, 2), "common factor", lambda: satin(7, 2)),
        (lambda: Weave((True, True), 1), "not woven in", lambda: Weave((True, False), 1)),
        (lambda: weave_of("plain", over=2), "leave it out", lambda: weave_of("plain")),
        (lambda: weave_of("twil"), "did you mean 'twill'", lambda: weave_of("twill")),
        (lambda: weave_of("twill", over=0), "1 … 16", lambda: weave_of("twill", over=1)),
        (lambda: twill(20, 1), "2 to 16", lambda: twill(15, 1)),
    ],
)
def test_what_is_no_weave_is_refused(make, words, mended):
    with pytest.raises(InputError, match=words):
        make()
    assert mended()
