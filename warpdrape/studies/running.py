"""A study from start to end: what is missing runs, how each run ends is kept, the rest goes on."""

from __future__ import annotations

import os
import time
import uuid
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import closing
from dataclasses import asdict, dataclass, field
from typing import Any

from warpdrape.cadence import read_cadence
from warpdrape.errors import InputError, RunFailed
from warpdrape.optional import needed
from warpdrape.studies.cluster import connected
from warpdrape.studies.design import Row
from warpdrape.studies.folder import StudyFolder, write_json
from warpdrape.studies.one_run import (
    BUSY,
    COMPLETED,
    LOST,
    UNFIT,
    Job,
    do_run,
    ended,
    our_versions,
)
from warpdrape.studies.progress import StudyProgress
from warpdrape.studies.study import Study

BUSY_S = 2.0
"""How long a run waits that another process is at, before it is tried again [s]."""


@dataclass(eq=False)
class Cost:
    """Processor time of a study: that of its runs, and beyond them.

    Attributes:
        runs_s: in runs [s].
        own_start_s: of this process until workers were there [s].
        own_s: of this process in all [s].
        workers: processor time of each worker's process when its last run ended [s].
        starts: likewise when its first one began: Python and libraries are loaded by then. Kernels
            are loaded in a worker's first run, as in any run that is done by itself.
        children_s: of workers made here and of what keeps them, to their end [s]; 0 where others
            made them, or the system does not say.
    """

    runs_s: float = 0.0
    own_start_s: float = 0.0
    own_s: float = 0.0
    workers: dict[tuple[str, int], float] = field(default_factory=dict)
    starts: dict[tuple[str, int], float] = field(default_factory=dict)
    children_s: float = 0.0

    def add(self, outcome: Mapping[str, Any]) -> None:
        """Take note of a run."""
        if "cpu_s" not in outcome:
            return
        self.runs_s += outcome["cpu_s"]
        who = (outcome["host"], outcome["process"])
        ended = outcome["worker_cpu_s"]
        begun = ended - outcome["cpu_s"] - outcome["watch_s"]
        self.workers[who] = max(self.workers.get(who, 0.0), ended)
        self.starts[who] = min(self.starts.get(who, begun), begun)

    @property
    def start_s(self) -> float:
        """Processor time until runs could begin, once for each worker and this process [s]."""
        return sum(self.starts.values()) + self.own_start_s

    @property
    def order_s(self) -> float:
        """Processor time beside the runs that no start took [s]: what grows with their number."""
        workers = self.children_s or sum(self.workers.values())
        beside = workers - sum(self.starts.values()) - self.runs_s
        return max(beside, 0.0) + self.own_s - self.own_start_s


def jobs_of(study: Study, folder: StudyFolder, rows: Sequence[Row]) -> list[Job]:
    """The runs of a study as workers take them.

    Raises:
        InputError: where the scene does not take a run's settings.
    """
    if rows:
        study.script.read_settings(study.settings(rows[0]))
    return [job_of(study, folder, k, study.settings(row), row) for k, row in enumerate(rows)]


def job_of(
    study: Study,
    folder: StudyFolder,
    number: int,
    settings: Sequence[str],
    row: Row,
    *,
    maps: bool = True,
) -> Job:
    """A run as a worker takes it.

    Args:
        study: of which it is.
        folder: of the study.
        number: of the run.
        settings: of its scene, ``NAME=VALUE``, without a card of its own.
        row: values of the parameters, those of the card among them.
        maps: whether what maps need is kept.
    """
    script = study.script
    values = study.card_values(row)
    return Job(
        number=number,
        study=os.fspath(folder.path.resolve()),
        scene=script.name if script.bundled else os.fspath(script.path.resolve()),
        digest=script.digest,
        settings=tuple(settings),
        options=asdict(study.options),
        versions=our_versions(),
        card=study.card.with_values(values, study.name) if study.card and values else None,
        maps=maps,
    )


def run_study(
    study: Study,
    folder: StudyFolder,
    *,
    rows: Sequence[Row],
    scheduler: str | None = None,
    workers: int | None = None,
    retry: bool = False,
    quiet: bool = False,
) -> tuple[list[Row], dict[int, dict[str, Any]], Cost]:
    """Run what is missing of a study.

    Args:
        study: the study.
        folder: its folder, which is taken; see `StudyFolder.take`.
        rows: parameters of every run, as `StudyFolder.plan` gives them.
        scheduler: address of a Dask scheduler; None for processes of this machine.
        workers: processes of this machine, None for one a core.
        retry: run again what has failed.
        quiet: show no progress.

    Returns:
        The runs' parameters, how each ended (those that have), and the cost of this time.

    Raises:
        InputError: if the study cannot be run so; what has ended is kept, as it is after
        RunFailed: when the scheduler is gone, or the disk refuses, and
        KeyboardInterrupt.
    """
    read_cadence(study.options.checkpoint)
    outcomes = folder.ended(range(len(rows)))
    if retry:
        outcomes = without_failed(folder, outcomes)
    jobs = [job for job in jobs_of(study, folder, rows) if job.number not in outcomes]
    failed = sum(each["status"] != COMPLETED for each in outcomes.values())
    progress = StudyProgress(len(rows), len(outcomes), failed, quiet=quiet)
    cost = Cost()
    if not jobs:
        return list(rows), outcomes, cost
    if outcomes:
        progress.say(f"{len(outcomes)} of {len(rows)} runs have ended before, {len(jobs)} to go.")
    before, children = time.process_time(), _children_s()
    with closing(progress), connected(scheduler, workers, progress.say) as client:
        cost.own_start_s = time.process_time() - before
        for outcome in as_they_end(client, jobs, folder, progress.say):
            outcomes[outcome["run"]] = outcome
            cost.add(outcome)
            well = outcome["status"] == COMPLETED
            why = f"run {outcome['run']} {outcome['status']}: {outcome['message']}"
            progress.ended(well=well, why="" if well else why)
    cost.own_s = time.process_time() - before
    if scheduler is None:
        cost.children_s = _children_s() - children
    return list(rows), outcomes, cost


def _children_s() -> float:
    """Processor time of all processes that this one has made, and that have ended [s]."""
    times = os.times()
    return times.children_user + times.children_system


def as_they_end(
    client: Any, jobs: Sequence[Job], folder: StudyFolder, say: Callable[[str], None]
) -> Iterator[dict[str, Any]]:
    """How runs end, one after the other.

    Args:
        client: of the Dask scheduler whose workers do them.
        jobs: the runs.
        folder: of the study.
        say: takes a line of what is waited for.

    Raises:
        InputError: if a worker can do no run of the study.
        RunFailed: when the scheduler is gone, or the disk refuses.
    """
    distributed = needed("distributed", "studies")
    session = uuid.uuid4().hex[:8]  # two studies at one scheduler share no names
    by_key = {f"warpdrape-{session}-{job.number}": job for job in jobs}
    if not client.scheduler_info(n_workers=0).get("total_threads", 1):
        say("The scheduler has no workers yet: runs begin when they come.")
    futures = client.map(do_run, jobs, key=list(by_key), pure=False)
    coming = distributed.as_completed(futures, loop=client.loop)
    del futures
    for future in coming:
        job = by_key[future.key]
        outcome = _outcome(future, job, folder, distributed)
        if outcome["status"] == UNFIT:
            raise InputError(outcome["message"])
        if outcome["status"] == BUSY:
            key = f"{future.key}-again"
            by_key[key] = job
            coming.add(client.submit(do_run, job, BUSY_S, key=key, pure=False))
            continue
        yield outcome


def _outcome(future: Any, job: Job, folder: StudyFolder, distributed: Any) -> dict[str, Any]:
    """How a run ended, where its worker could say so or not."""
    try:
        return future.result()
    except distributed.KilledWorker as error:
        words = (
            f"its worker died {error.allowed_failures + 1} times over it, the last on "
            f"{error.last_worker.address}: most likely for want of memory, or by a fault of the "
            "system; take fewer workers, or a coarser mesh"
        )
        outcome = ended(job, LOST, words)
        write_json(folder.outcome(job.number), outcome)
        return outcome
    except CancelledError as error:
        raise RunFailed("the scheduler is gone") from error
    except ImportError as error:
        raise InputError(
            f"the scheduler's workers cannot load warpdrape ({error}): install the same version "
            "of it there"
        ) from error


def without_failed(
    folder: StudyFolder, outcomes: Mapping[int, dict[str, Any]]
) -> dict[int, dict[str, Any]]:
    """Outcomes but those of runs that failed, which are forgotten."""
    kept = {}
    for number, outcome in outcomes.items():
        if outcome["status"] == COMPLETED:
            kept[number] = outcome
            continue
        for path in (folder.run(number) / "summary.json", folder.outcome(number)):
            path.unlink(missing_ok=True)
        (folder.run(number) / "checkpoint.npz").unlink(missing_ok=True)
    return kept
