"""Threads are tried where cores stand idle, and judged by the clock: by fake clocks and cores."""

import os

import pytest

from warpdrape.dynamics import cores
from warpdrape.dynamics.cores import ENOUGH, WINDOW, Look, SpareCores
from warpdrape.dynamics.pace import Pace


class Spare:
    """What is seen of other programs, by the number of the block."""

    def __init__(self, seen):
        self.seen, self.block, self.restarts = seen, 0, 0

    def enough(self):
        return self.seen(self.block)

    def restart(self):
        self.restarts += 1


def pace_of(alone, together, blocks, seen=lambda _: True):
    """Whether each block was for threads, where these are the times of the two ways."""
    spare, chosen = Spare(seen), []
    pace = Pace(spare)
    for block in range(blocks):
        spare.block = block
        chosen.append(pace.together)
        pace.took(together(block) if chosen[-1] else alone(block))
    return chosen


@pytest.mark.parametrize("seen", [True, None])
def test_threads_are_used_while_they_pay(seen):
    chosen = pace_of(lambda _: 1.0, lambda _: 0.55, 300, lambda _: seen)
    assert sum(chosen) >= 290 and not any(chosen[:3]) and chosen[3]
    assert 3 <= 297 - sum(chosen) <= 6  # a block alone now and then, to compare


def test_threads_are_not_tried_while_other_programs_have_the_cores():
    assert not any(pace_of(lambda _: 1.0, lambda _: 0.1, 300, lambda _: False))


def test_threads_are_tried_as_soon_as_a_core_is_free():
    chosen = pace_of(lambda _: 1.0, lambda _: 0.55, 120, lambda block: block >= 40)
    assert not any(chosen[:41]) and chosen[41]
    assert sum(chosen[41:]) >= 77


@pytest.mark.parametrize("seen", [True, None])
def test_threads_that_do_not_pay_are_tried_rarely(seen):
    chosen = pace_of(lambda _: 1.0, lambda _: 1.3, 300, lambda _: seen)
    spent = sum(1.3 if together else 1.0 for together in chosen)
    assert 3 <= sum(chosen) and spent < 1.01 * 300
    assert sum(chosen[:60]) <= 4
    assert pace_of(lambda _: 1.0, lambda _: 5.0, 300, lambda _: seen) == chosen


def test_a_slow_first_block_does_not_count():
    chosen = pace_of(lambda block: 9.0 if block == 0 else 1.0, lambda _: 2.0, 60)
    assert sum(chosen) <= 4


def test_one_slow_trial_does_not_keep_threads_away_for_long():
    chosen = pace_of(lambda _: 1.0, lambda block: 9.0 if block < 10 else 0.55, 100)
    assert sum(chosen[20:]) >= 78


def test_threads_are_left_at_once_when_a_core_is_taken_and_taken_up_at_once_when_it_is_free():
    taken = range(50, 160)
    chosen = pace_of(
        lambda _: 1.0,
        lambda block: 3.0 if block in taken else 0.55,
        500,
        lambda block: block not in taken,
    )
    assert sum(chosen[20:50]) >= 29
    assert sum(chosen[50:160]) == 1
    assert chosen[162] and sum(chosen[162:]) >= 330


def test_trials_that_failed_are_forgotten_once_threads_have_paid():
    taken = range(200, 205)
    chosen = pace_of(
        lambda _: 1.0,
        lambda block: 3.0 if block < 100 or block in taken else 0.55,
        240,
        lambda block: block not in taken,
    )
    assert 4 <= sum(chosen[:100]) <= 6 and sum(chosen[140:200]) >= 58
    assert sum(chosen[205:]) >= 33


def test_where_nothing_is_seen_freed_cores_are_found_by_trials():
    taken = range(50, 160)
    chosen = pace_of(
        lambda _: 1.0, lambda block: 3.0 if block in taken else 0.55, 500, lambda _: None
    )
    assert 3 <= sum(chosen[50:160]) <= 7
    assert sum(chosen[-100:]) >= 95


def test_a_block_alone_that_is_slow_is_no_reason_for_threads():
    alone = [1.0] * 10 + [4.0] * 30  # a trial at block 3 took 1.3; then all becomes slow
    chosen = pace_of(lambda b: alone[b], lambda _: 1.3, 40, lambda block: block < 5)
    assert sum(chosen) == 1 and chosen[3]


def test_what_was_seen_is_forgotten_when_threads_stop_paying():
    spare = Spare(lambda _: True)
    pace = Pace(spare)
    for seconds in (1.0, 1.0, 1.0, 0.5, 0.5):
        pace.took(seconds)
    assert pace.together and spare.restarts == 0
    pace.took(5.0)
    assert spare.restarts == 1


class Machine:
    """Two cores or more, ours busy with us alone; what others take is told for each span."""

    def __init__(self, logical=2, physical=2, believed=True):
        self.now = self.idle = self.counted = self.own = 0.0
        self.looks, self.logical, self.believed = 0, logical, believed
        self.counts = (physical, logical)

    def spare(self, threads):
        return SpareCores(threads, self.look, lambda: self.now, self.counts)

    def pass_time(self, seconds, *, own=1.0, others=0.0):
        self.now += seconds
        self.own += own * seconds
        self.idle += (self.logical - own - others) * seconds
        self.counted += self.logical * seconds * self.believed

    def look(self):
        self.looks += 1
        return Look(self.now, self.idle, self.counted, self.own)


def test_idle_cores_are_seen_after_a_window():
    machine = Machine()
    spare = machine.spare(2)
    machine.pass_time(0.9 * WINDOW)
    assert spare.enough() is False
    machine.pass_time(0.2 * WINDOW)
    assert spare.enough() is True
    spare.restart()
    assert spare.enough() is False


@pytest.mark.parametrize(
    "own, others, enough",
    [(1.0, 1.0, False), (0.6, 1.4, False), (1.0, 0.5, False), (1.0, 0.3, True), (2.0, 0.0, True)],
)
def test_what_others_take_counts_and_what_we_take_does_not(own, others, enough):
    machine = Machine()
    spare = machine.spare(2)
    machine.pass_time(WINDOW, own=own, others=others)
    assert spare.enough() is enough


def test_waiting_for_a_disk_makes_no_core_spare():
    machine = Machine()
    spare = machine.spare(2)
    machine.pass_time(WINDOW, own=0.1, others=1.0)
    assert machine.idle == pytest.approx(0.9 * WINDOW) and ENOUGH < 0.9
    assert spare.enough() is False


def test_cores_that_share_their_hardware_are_counted_once():
    machine = Machine(logical=8, physical=4)
    spare = machine.spare(4)
    machine.pass_time(WINDOW, others=1.0)
    assert spare.enough() is True  # two of the three wanted
    machine.pass_time(WINDOW, others=2.0)
    assert spare.enough() is False  # though five of eight stand idle


def test_short_blocks_do_not_look_each_time():
    machine = Machine()
    spare = machine.spare(2)
    for _ in range(1000):
        machine.pass_time(WINDOW / 100)
        spare.enough()
    assert 8 <= machine.looks <= 11


def test_each_window_is_judged_by_itself():
    machine = Machine()
    spare = machine.spare(2)
    seen = []
    for others in (1.0, 1.0, 0.0, 1.0):
        machine.pass_time(WINDOW, others=others)
        seen.append(spare.enough())
    assert seen == [False, False, True, False]


def test_a_system_that_counts_nothing_is_not_believed():
    machine = Machine(believed=False)
    spare = machine.spare(2)
    machine.pass_time(WINDOW)
    assert spare.enough() is None
    assert SpareCores(2, lambda: None, lambda: 0.0, (2, 2)).enough() is None


@pytest.mark.parametrize("fault", [OSError, cores.psutil.Error, AttributeError])
def test_a_system_without_counters_is_no_error(fault, monkeypatch):
    def refuse(*_, **__):
        raise fault("no counters")

    monkeypatch.setattr(cores.psutil, "cpu_times", refuse)
    assert cores.look_at([0]) is None
    assert SpareCores(2).enough() is None


def test_a_core_that_is_not_listed_is_no_error():
    assert cores.look_at([10**6]) is None


def test_counters_of_this_machine_are_read():
    allowed = cores.allowed_cores()
    first = cores.look_at(allowed)
    assert first is None or 0.0 <= first.idle <= first.counted
    assert 1 <= cores.physical_cores() <= len(allowed) <= os.cpu_count()
    assert 1 <= cores.cores_there() <= os.cpu_count()
