"""Presses of prepregs that were cut off, or run on threads, to the bit; others are refused."""

from dataclasses import replace

import numpy as np
import pytest
from prepreg_checks import CARD, coarse, frame
from resume_checks import assert_same_folder, cut_off, timeless
from test_threads import assert_same_bits, state_after

from warpdrape import InputError
from warpdrape.materials.fabric_library import load_fabric


def test_a_press_resumes_to_the_bit(tmp_path, monkeypatch):
    scene = coarse(closing_time=1.0, duration=0.004, travel=0.02)
    whole = scene.run(tmp_path / "whole", frames=8)
    cut_off(scene, tmp_path / "cut", 4, monkeypatch, every=3)
    again = coarse(closing_time=1.0, duration=0.004, travel=0.02).run(resume=tmp_path / "cut")
    assert timeless(again.summary) == timeless(whole.summary)
    for name in ("points", "temperature"):
        np.testing.assert_array_equal(
            getattr(again.plies[0], name), getattr(whole.plies[0], name), err_msg=name
        )
    assert_same_folder(tmp_path / "whole", tmp_path / "cut")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"tool_celsius": 199.0}, "temperature of tool"),
        ({"blank_celsius": 259.0}, "temperature of ply"),
        ({"closing_time": 1.1}, "process_duration over duration"),
    ],
)
def test_a_press_of_another_process_cannot_go_on(tmp_path, monkeypatch, changes, words):
    given = {"closing_time": 1.0, "duration": 0.002, "travel": 0.005}
    cut_off(coarse(**given), tmp_path / "cut", 2, monkeypatch, every=1)
    with pytest.raises(InputError, match=words):
        coarse(**(given | changes)).run(resume=tmp_path / "cut")


def test_a_matrix_of_other_values_cannot_go_on(tmp_path, monkeypatch):
    cloth = load_fabric(CARD)
    cut_off(frame(fabric=cloth, duration=0.004), tmp_path / "cut", 2, monkeypatch, every=1)
    thicker = replace(cloth.matrix, viscosity=replace(cloth.matrix.viscosity, viscosity=1.1e6))
    other = frame(fabric=replace(cloth, matrix=thicker), duration=0.004)
    with pytest.raises(InputError, match="matrix of the fabric"):
        other.run(resume=tmp_path / "cut")


def test_threads_compute_what_one_part_after_another_does():
    scene = coarse(closing_time=1.0, duration=0.01, travel=0.02)
    together, _ = state_after(2, True, scene, blocks=40)
    alone, _ = state_after(2, False, scene, blocks=40)
    assert_same_bits(together, alone)
    assert "heat.temperature" in together
    assert np.ptp(together["heat.temperature"]) > 1e-3
