"""Unit cells for tests: yarns that differ between the families, and a state near the woven one."""

import numpy as np
import pytest

from warpdrape.unit_cell.cell import UnitCell
from warpdrape.unit_cell.compaction import YarnCompaction
from warpdrape.unit_cell.weave import plain, satin, twill

SOFT = YarnCompaction(5e3, 8.0)


WEAVES = {"plain": plain(), "twill": twill(2, 1), "satin": satin(5, 3)}


def cell_of(weave=WEAVES["plain"], **changes):
    """Yarns that differ between the families."""
    values = {
        "weave": weave,
        "spacing": (5.2e-3, 4.8e-3),
        "width": (4.1e-3, 3.9e-3),
        "height": (0.6e-3, 0.5e-3),
        "stiffness": (44e3, 38e3),
        "bending": (1e-7, 2e-7),
        "compaction": SOFT,
        "friction": 0.25,
    }
    return UnitCell(**{**values, **changes})


def balanced(**changes):
    both = {"spacing": (5.2e-3,) * 2, "width": (4.1e-3,) * 2, "height": (0.6e-3,) * 2}
    return cell_of(**{**both, "stiffness": (44e3,) * 2, "bending": (1e-7,) * 2, **changes})


def weaves():
    return pytest.mark.parametrize("weave", WEAVES.values(), ids=WEAVES.keys())


def shaken(model, seed=0):
    """Paths near the woven ones, all contacts in play."""
    rng = np.random.default_rng(seed)
    return 0.93 * model.woven * (1.0 + 0.01 * rng.normal(size=model.woven.size))
