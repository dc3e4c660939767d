"""One run of a study, as a worker does it: begin, or go on, or find it done; say how it ended.

It is the run that ``warpdrape run`` does, in a folder like any other. It is done in the worker's
own process, so that libraries and kernels are loaded once for many runs.
"""

from __future__ import annotations

import os
import platform
import threading
import time
import traceback
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from warpdrape.errors import InputError, RunFailed

COMPLETED, FAILED, REFUSED, LOST = "completed", "failed", "refused", "lost"
"""How a run ends: done; it failed; its input cannot be used; its worker died again and again."""
BUSY, UNFIT = "busy", "unfit"
"""No ends of a run: another process is at it; the worker cannot do any."""
_ONE_AT_A_TIME = threading.Lock()
"""A worker with several threads still does one run at a time: Warp and scene scripts are the
process's."""


@dataclass(frozen=True)
class Job:
    """All that a worker needs to know.

    Attributes:
        number: of the run.
        study: the study folder.
        scene: bundled name, or path of the script.
        digest: of the script's text as the study knows it.
        settings: of the scene, ``NAME=VALUE``.
        options: frames, device, threads and checkpoint of the run.
        versions: of what computes, as the study's machine has them.
        card: all of the run's own fabric card; None without.
        maps: whether what maps need is kept.
    """

    number: int
    study: str
    scene: str
    digest: str
    settings: tuple[str, ...]
    options: Mapping[str, Any]
    versions: Mapping[str, str]
    card: Mapping[str, Any] | None = field(default=None, repr=False)
    maps: bool = True


@cache
def our_versions() -> dict[str, str]:
    """Versions on which results depend."""
    from warpdrape.results.run_record import versions

    return {name: found for name, found in versions().items() if name in _SAME}


_SAME = ("warpdrape", "warp-lang")


def do_run(job: Job, pause: float = 0.0) -> dict[str, Any]:
    """Do a run, or what is left of it, and return how it ended; that is on the disk by then.

    What goes wrong with a run is how it ended, and others go on; only a disk that takes nothing
    raises.

    Args:
        job: the run.
        pause: time to wait before [s].

    Raises:
        RunFailed: if how it ended could not be written.
    """
    time.sleep(pause)
    with _ONE_AT_A_TIME, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # they are in the summary
        from warpdrape.studies.folder import StudyFolder, write_json

        folder = StudyFolder(job.study)
        unfit = _unfit(job, folder.path / "outcomes")
        if unfit:
            return ended(job, UNFIT, unfit)
        done = _known(folder.outcome(job.number), job)
        if done is not None:
            return done
        begun = (time.perf_counter(), _cpu(), _watch())
        try:
            status, message, more = _compute(job, folder)
        except _Busy as error:
            return ended(job, BUSY, str(error))
        except InputError as error:
            status, message, more = REFUSED, str(error), {}
        except (RunFailed, MemoryError) as error:
            status, message, more = FAILED, str(error) or "out of memory", {}
        except Exception as error:
            status, message, more = FAILED, _unexpected(error), {}
        watch = _watch() - begun[2]
        wall, cpu = time.perf_counter() - begun[0], _cpu() - begun[1] - watch
        more |= {"wall_s": wall, "cpu_s": cpu, "watch_s": watch, "worker_cpu_s": _cpu()}
        outcome = ended(job, status, message, **more)
        write_json(folder.outcome(job.number), outcome)
        return outcome


class _Busy(Exception):
    """Another process is at the run."""


def _unfit(job: Job, outcomes: Path) -> str:
    """Why this worker can do no run of the study; empty if it can."""
    host = platform.node()
    if not outcomes.is_dir():
        return (
            f"the worker on {host} does not see {job.study}: put the study's --out on a file "
            "system that all machines share under one path"
        )
    odd = [f"{n} {v}" for n, v in our_versions().items() if v != job.versions.get(n)]
    if odd:
        return (
            f"the worker on {host} has {', '.join(odd)} and the study's machine "
            f"{', '.join(f'{n} {v}' for n, v in job.versions.items())}: install the same there"
        )
    return ""


def _compute(job: Job, study: Any) -> tuple[str, str, dict[str, Any]]:
    from warpdrape.commands.scene_library import find_script
    from warpdrape.results.run_folder import RUN, SUMMARY
    from warpdrape.studies.cards import write_card
    from warpdrape.studies.fields import keep_fields
    from warpdrape.warp_start import start_warp

    start_warp()
    script = find_script(job.scene)
    if script.digest != job.digest:
        raise InputError(
            f"the worker on {platform.node()} has another {job.scene} than the study: give all "
            "machines the same script"
        )
    settings = list(job.settings)
    if job.card is not None:
        card = study.card(job.number)
        if not card.exists():
            write_card(card, job.card)
        settings.append(f"fabric={card}")
    folder = study.run(job.number)
    before = _summary(folder / SUMMARY)
    if before is not None and before["status"] == FAILED and (folder / RUN).exists():
        return FAILED, before["message"], {"steps": before["steps"]}
    if before is not None:
        keep_fields(folder, study.fields(job.number), wanted=job.maps)
        return COMPLETED, before["message"], {"steps": before["steps"]}
    result, resumed = _go_on_or_begin(script.make(settings), folder, job.options)
    more = {"steps": result.summary["steps"], "resumed": resumed}
    if not result.completed:
        return FAILED, result.summary["message"], more
    keep_fields(folder, study.fields(job.number), wanted=job.maps)
    return COMPLETED, result.summary["message"], more


def _go_on_or_begin(scene: Any, folder: Path, options: Mapping[str, Any]) -> tuple[Any, bool]:
    """Go on from a checkpoint where there is one that fits, else run from the start."""
    from warpdrape.restart import read_restart
    from warpdrape.results.folder_lock import FolderBusy

    how = {"checkpoint": options["checkpoint"], "quiet": True}
    try:
        try:
            if folder.is_dir() and read_restart(folder) is not None:
                return scene.run(resume=folder, **how), True
        except FolderBusy:
            raise
        except InputError:  # damaged, or of another version: its frames are of no use
            pass
        how |= {"frames": options["frames"], "device": options["device"]}
        return scene.run(folder, threads=options["threads"], overwrite=True, **how), False
    except FolderBusy as error:
        raise _Busy(str(error)) from error


def _summary(path: Path) -> dict[str, Any] | None:
    """A summary, None where there is none of a run that came to an end."""
    import json

    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        return found if found["status"] in (COMPLETED, FAILED) and "steps" in found else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _known(path: Path, job: Job) -> dict[str, Any] | None:
    """How a run ended, where that is known and of this job."""
    import json

    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        return found if found["settings"] == list(job.settings) else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def ended(job: Job, status: str, message: str, **more: Any) -> dict[str, Any]:
    """How a run ended, as it is kept."""
    words = " ".join(message.split())
    return {
        "run": job.number,
        "status": status,
        "message": words,
        "settings": list(job.settings),
        "host": platform.node(),
        "process": os.getpid(),
        **more,
    }


def _unexpected(error: Exception) -> str:
    step = traceback.extract_tb(error.__traceback__)[-1]
    where = f"{Path(step.filename).name}, line {step.lineno}"
    return f"unexpected {type(error).__name__} in {where}: {error}; please report it"


def _cpu() -> float:
    """Processor time of this process so far [s]."""
    return time.process_time()


def _watch() -> float:
    """Of that, what its main thread took, in which Dask answers the scheduler beside a run [s].

    Zero where the run is done in that thread, or the system does not say.
    """
    main = threading.main_thread()
    if threading.current_thread() is main or main.ident is None:
        return 0.0
    if not hasattr(time, "pthread_getcpuclockid"):
        return 0.0
    return time.clock_gettime(time.pthread_getcpuclockid(main.ident))
