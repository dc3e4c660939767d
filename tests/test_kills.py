"""A run that is killed at any moment, at any write, goes on to the result it would have had."""

import signal
from collections import Counter

import pytest
from fault_checks import AT_BLOCKS, assert_whole_files, kill_and_resume, kill_at_random
from resume_checks import assert_same_folder

from warpdrape.restart import read_restart

BEFORE, MIDST = -1, -2
"""A kill before a call that changes the folder; and in its midst, a write done by half."""
PARTS = 20


def test_killed_at_some_writes(server, whole, tmp_path):
    folder, done = whole
    for number in (done["calls"] // 3, done["calls"] - 6):
        kill_and_resume(server, tmp_path / "run", folder, at=number, kind=MIDST)


@pytest.mark.parametrize(
    ("share", "kind"), [(1.4, MIDST), pytest.param(2.5, BEFORE, marks=pytest.mark.slow)]
)
def test_killed_between_frames(share, kind, server, whole, tmp_path):
    """With a checkpoint at every block of steps, the last one half written."""
    folder, done = whole
    at = int(share * done["calls"])
    killed = server.run(tmp_path / "run", AT_BLOCKS, at=at, kind=kind)
    assert killed["status"] == -signal.SIGKILL
    assert read_restart(tmp_path / "run").clock.left > 0
    assert_whole_files(tmp_path / "run")
    assert server.resume(tmp_path / "run")["status"] == 0
    assert_same_folder(tmp_path / "run", folder)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [BEFORE, MIDST])
def test_killed_at_every_write(kind, server, whole, tmp_path):
    folder, done = whole
    assert done["calls"] > 100
    for number in range(1, done["calls"] + 1):
        kill_and_resume(server, tmp_path / "run", folder, at=number, kind=kind)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [BEFORE, MIDST])
def test_killed_at_every_write_of_going_on(kind, server, whole, tmp_path):
    """The second life is as safe as the first."""
    folder, done = whole
    half = {"at": done["calls"] // 2, "kind": BEFORE}
    server.run(tmp_path / "run", **half)
    calls = server.resume(tmp_path / "run")["calls"]
    for number in range(1, calls + 1):
        server.run(tmp_path / "run", **half)
        killed = server.resume(tmp_path / "run", at=number, kind=kind)
        assert killed["status"] in (-signal.SIGKILL, 0), killed
        assert server.resume(tmp_path / "run")["status"] == 0
        assert_same_folder(tmp_path / "run", folder)


@pytest.mark.slow
@pytest.mark.parametrize("part", range(PARTS))
def test_killed_at_a_thousand_random_moments(part, server, whole, tmp_path):
    """In parts that run alone too; with ``-s`` they say what the kills left."""
    folder, _ = whole
    left = Counter(kill_at_random(server, tmp_path / "run", folder, 1000 // PARTS, seed=part))
    for (names, killed), count in sorted(left.items()):
        print(f"{part} {count:4} {'killed' if killed else 'ended'}: {names or 'nothing'}")
    assert len(left) > 4


@pytest.mark.parametrize(
    "number",
    [
        signal.SIGTERM,
        pytest.param(signal.SIGINT, marks=pytest.mark.slow),
        pytest.param(signal.SIGHUP, marks=pytest.mark.slow),
    ],
)
def test_signals_end_a_run_in_order(number, server, whole, tmp_path):
    folder, _ = whole
    begun = str(tmp_path / "run" / "checkpoint.npz")
    ended = server.run(tmp_path / "run", when=begun, after=0.01, signal=number)
    said = "interrupted by the user" if number == signal.SIGINT else signal.Signals(number).name
    assert ended["status"] == 1 and said in ended["said"], ended
    names = sorted(f.name for f in (tmp_path / "run").iterdir())
    assert names == ["checkpoint.npz", "history.csv", "run.json", "scene.usdc", "summary.json"]
    assert server.resume(tmp_path / "run")["status"] == 0
    assert_same_folder(tmp_path / "run", folder)
