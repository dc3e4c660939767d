"""Ctrl-C at moments at which libraries would swallow it."""

import gc
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from warpdrape.commands.interrupts import interrupt_kept

ROOT = Path(__file__).parents[1]


@pytest.fixture(autouse=True)
def interruptible():
    """Ctrl-C as on a terminal: a shell lets what it starts in the background ignore it.

    No garbage is collected meanwhile: what libraries do then would swallow it.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    gc.disable()
    yield
    gc.enable()
    signal.signal(signal.SIGINT, before)


def press_ctrl_c():
    signal.raise_signal(signal.SIGINT)


def test_an_interrupt_waits_for_the_end_of_the_block():
    reached = []
    with pytest.raises(KeyboardInterrupt), interrupt_kept():
        try:
            press_ctrl_c()
        except BaseException:  # as trimesh does
            reached.append("swallowed")
        reached.append("end")
    assert reached == ["end"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_second_one_does_not_wait_and_is_not_lost_either():
    reached = []
    with pytest.raises(KeyboardInterrupt), interrupt_kept():
        press_ctrl_c()
        press_ctrl_c()
        reached.append("end")
    assert reached == []
    with pytest.raises(KeyboardInterrupt), interrupt_kept():
        press_ctrl_c()
        with pytest.raises(KeyboardInterrupt):
            press_ctrl_c()


def test_another_handler_is_left_alone():
    seen = []
    before = signal.signal(signal.SIGINT, lambda *_: seen.append("theirs"))
    try:
        with interrupt_kept():
            press_ctrl_c()
    finally:
        signal.signal(signal.SIGINT, before)
    assert seen == ["theirs"]


SCRIPT = """
import signal, sys
from warpdrape.cli import main

class Finger:
    def find_spec(self, name, *_):
        if name == {module!r}:
            signal.raise_signal(signal.SIGINT)

sys.meta_path.insert(0, Finger())
sys.exit(main(["run", "hemisphere", "--set=cells=4", "--frames=1", "--out", {out!r}]))
"""


@pytest.mark.parametrize("module", ["networkx", "pxr.Sdf"])
def test_a_run_that_is_stopped_while_it_imports(module, tmp_path):
    out = tmp_path / "out"
    code = SCRIPT.format(module=module, out=str(out))
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert (ended.returncode, ended.stderr) == (1, "warpdrape: error: interrupted\n")
    assert not out.exists()
