"""Tests of a laboratory made up for calibration: tables as its machine would write them."""

import numpy as np

from warpdrape.calibration.raw_table import Specimen
from warpdrape.calibration.tests_file import Test


def pulled(kind, columns, **options):
    values = options.pop("values")
    specimen = Specimen("s", "s.csv", {k: np.asarray(v, float) for k, v in columns.items()})
    return Test("t", kind, values, (specimen,), **options)
