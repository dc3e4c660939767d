"""A run that was cut off goes on from its checkpoint to the same result, to the last bit."""


import numpy as np
import pytest
from resume_checks import SCENES, assert_same_folder, cut_off, timeless

FRAMES = 8


@pytest.mark.parametrize("name", SCENES)
def test_a_run_that_was_cut_off_ends_as_one_that_was_not(name, tmp_path, monkeypatch):
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    expected = SCENES[name]().run(whole, frames=FRAMES, checkpoint=2)
    cut_off(SCENES[name](), cut, 5, monkeypatch)
    assert (cut / "checkpoint.npz").exists() and not (cut / "summary.json").exists()
    result = SCENES[name]().run(resume=cut)
    assert expected.completed and expected.summary["steps"] > 200
    assert_same_folder(cut, whole)
    assert timeless(result.summary) == timeless(expected.summary)
    for one, other in zip(result.plies, expected.plies, strict=True):
        assert np.abs(one.points - one.rest_points).max() > 1e-3
        np.testing.assert_array_equal(one.points, other.points)
