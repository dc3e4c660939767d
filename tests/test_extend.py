"""Finished runs that are extended: longer strokes, more frames, nothing that jumps."""

import dataclasses
import json

import numpy as np
import pytest
from resume_checks import loaded, press, samples

from warpdrape.errors import InputError
from warpdrape.tools.motion import Path


def test_what_acts_goes_on_where_it_is_when_a_run_is_extended(tmp_path):
    """Pressures and forces may not jump; the press keeps its pace, however long its run."""
    loaded().run(tmp_path / "run", frames=2)

    def later(**changes):
        return dataclasses.replace(loaded(), duration=6e-3, **changes)

    air = loaded().pressures[0]
    jump = dataclasses.replace(air, pressure=[(1e-3, 0.0), (4e-3, 900.0)])
    plate = loaded().tools[2]
    harder = dataclasses.replace(plate, motion=dataclasses.replace(plate.motion, force=9.0))
    heavier = dataclasses.replace(plate, motion=dataclasses.replace(plate.motion, mass=0.5))
    for scene, words in (
        (later(pressures=[jump]), "pressure 'air' would go from -300 to -900 Pa at once"),
        (
            later(tools=[*loaded().tools[:2], harder]),
            "force of tool 'plate' would go from 2 to 9 N",
        ),
        (later(tools=[*loaded().tools[:2], heavier]), "floating of tool 'plate' = "),
        (later(process_duration=5.0), "process_duration over duration = "),
    ):
        with pytest.raises(InputError, match=words):
            scene.run(resume=tmp_path / "run", extend=True)
    longer = later().run(resume=tmp_path / "run", extend=True)
    record = json.loads((tmp_path / "run" / "run.json").read_text("utf-8"))
    assert longer.completed and record["duration_s"] == pytest.approx(6e-3)
    assert record["process_duration_s"] == pytest.approx(6.0)


@pytest.mark.slow
def test_more_frames_are_those_of_a_run_that_was_longer_from_the_start(tmp_path):
    """With the same steps, as here where both are planned alike, the same to the bit."""
    long = dataclasses.replace(press(), duration=8e-3)
    long.run(tmp_path / "whole", frames=8)
    press().run(tmp_path / "run", frames=4)
    press().run(resume=tmp_path / "run", extend=True, frames=8)
    mine, theirs = (samples(tmp_path / name / "scene.usdc") for name in ("run", "whole"))
    assert mine.keys() == theirs.keys()
    for name, value in mine.items():
        np.testing.assert_array_equal(np.asarray(value), np.asarray(theirs[name]), err_msg=name)
    assert mine["times"] == (0.0, 8.0)


def gone_on(way, start=4e-3, first=(0.002, 0.0, -0.006)):
    """The press with a ball that goes on from where it was."""
    scene, ball = press(), press().tools[1]
    path = Path(times=[start, start + 4e-3], positions=[first, np.add(first, way)])
    tools = [scene.tools[0], dataclasses.replace(ball, motion=path), scene.tools[2]]
    return dataclasses.replace(scene, tools=tools, duration=8e-3)


def test_a_stroke_goes_on_and_what_would_jump_is_refused(tmp_path):
    whole = press().run(tmp_path / "run", frames=4)
    before = {f.name: f.read_bytes() for f in (tmp_path / "run").iterdir()}
    for scene, words in (
        (gone_on((0, 0, -2e-3), first=(0, 0, -6e-3)), "'ball' would jump 2 mm from where it is"),
        (gone_on((0, 0, -0.02)), "cannot be extended at 7.5 m/s: its tools came to 2.2"),
        (press(), "has come to frame 4, 0.004 s: to extend it, give a longer duration"),
        (dataclasses.replace(gone_on((0, 0, -2e-3)), friction=0.1), "friction = 0.1"),
    ):
        with pytest.raises(InputError, match=words):
            scene.run(resume=tmp_path / "run", extend=True)
    after = {f.name: f.read_bytes() for f in (tmp_path / "run").iterdir()}
    assert after == before
    result = gone_on((0, 0, -2e-3)).run(resume=tmp_path / "run", extend=True)
    assert result.completed and len(result.history["time_s"]) == 9
    assert result.history["ball_displacement_m"][-1] == pytest.approx(8e-3, rel=1e-9)
    first = {name: column[:5] for name, column in result.history.items()}
    for name, column in whole.history.items():
        if name != "ball_displacement_m":  # along the way as a whole, which has turned
            np.testing.assert_array_equal(first[name], column)
