import io
import os

import pytest

from warpdrape.results.progress import Progress


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def clock():
    return Clock()


def test_plain_lines_every_five_seconds(clock):
    stream = io.StringIO()
    with Progress(0.08, stream, clock=clock) as progress:
        for second in range(1, 21):
            clock.now += 1.0
            progress.update(0.002 * second, "shear 12.0°", steps=500 * second)
    lines = stream.getvalue().splitlines()
    assert lines[0] == " 12 % 10.0 of 80.0 ms, 500 steps/s, 35 s left, shear 12.0°"
    assert lines[3] == " 50 % 40.0 of 80.0 ms, 500 steps/s, 20 s left, shear 12.0°"
    assert lines[4:] == [" 50 % 40.0 of 80.0 ms in 20 s, shear 12.0°"]


def test_time_left_follows_the_recent_speed(clock):
    stream = io.StringIO()
    progress = Progress(1.0, stream, clock=clock)
    simulated = 0.0
    for second in range(200):  # fast at first, then contact slows it down tenfold
        clock.now += 1.0
        simulated += 0.01 if second < 50 else 0.001
        progress.update(simulated)
    last = stream.getvalue().splitlines()[-1]
    assert last == " 65 % 650.0 of 1000.0 ms, 5 min 50 s left"  # 0.35 at 0.001 a second


def test_bar_on_a_terminal(clock, monkeypatch):
    monkeypatch.setattr("shutil.get_terminal_size", lambda: os.terminal_size((70, 24)))
    stream = Terminal()
    with Progress(0.08, stream, clock=clock) as progress:
        progress.update(0.001)  # too soon to draw
        assert stream.getvalue() == ""
        clock.now += 3600.0
        progress.update(0.02, "a text that is far too long for the width of this terminal")
        clock.now += 1.0
        progress.update(0.04)
    drawn = stream.getvalue()
    assert drawn.endswith("\n") and drawn.count("\n") == 1
    first, second, last = drawn.strip("\r\n").split("\r")
    assert first.startswith("[######..................]  25 % 20.0 of 80.0 ms, 3 h 09 min left")
    assert len(first) == 69  # cut: a line that wraps could not be drawn over
    assert len(second) == 69 and second.startswith("[############............]  50 %")
    assert last.startswith("[############............]  50 % 40.0 of 80.0 ms in 1 h 00 min")


def test_quiet_and_closed_write_nothing(clock):
    stream = io.StringIO()
    with Progress(1.0, stream, quiet=True, clock=clock) as progress:
        clock.now += 60.0
        progress.update(0.5)
    assert stream.getvalue() == ""
    progress = Progress(1.0, stream, clock=clock)
    progress.close()
    progress.close()
    clock.now += 60.0
    progress.update(0.5)
    assert stream.getvalue() == "  0 % 0.0 of 1000.0 ms in 0 s\n"


def test_standard_error_is_the_default(clock, capsys):
    Progress(0.0, clock=clock).close()
    assert capsys.readouterr().err == "100 % 0.0 of 0.0 ms in 0 s\n"


def test_no_rate_before_anything_moved(clock):
    stream = io.StringIO()
    progress = Progress(1.0, stream, clock=clock)
    clock.now += 6.0
    progress.update(0.0, "waiting")
    assert stream.getvalue() == "  0 % 0.0 of 1000.0 ms, waiting\n"
