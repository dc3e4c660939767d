"""The command line; what is heavy to import is imported by the command that needs it."""

from __future__ import annotations

import argparse
import io
import os
import sys
import warnings
from collections.abc import Sequence
from contextlib import redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from warpdrape.commands.arguments import build_parser, whole

if TYPE_CHECKING:
    from warpdrape.results.result import Result

DONE, FAILED, UNUSABLE, UNFIT = 0, 1, 2, 3
"""Exit status: all went well; the run failed; the input cannot be used; the part is unfit."""
READERS = ("judge", "report", "picture", "export")
"""Commands that do nothing but read a run's files."""
ODD = (KeyError, TypeError, IndexError, AttributeError, ValueError, OverflowError)
"""What code meets where a file holds another value than it takes for granted."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status: 0 done, 1 failed, 2 unusable input.

    Args:
        argv: the arguments; those of the process if None.
    """
    _never_fail_to_print()
    with warnings.catch_warnings():
        warnings.showwarning = _show_warning
        try:
            return _dispatch(list(sys.argv[1:] if argv is None else argv))
        except KeyboardInterrupt:
            return _complain("interrupted", FAILED)
        except BrokenPipeError:  # as in "warpdrape fabrics | head"
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return FAILED
        except MemoryError:
            return _complain("out of memory: take fewer cells or larger facets", FAILED)
        except Exception as error:
            return _explain(error, list(sys.argv[1:] if argv is None else argv))


def run_script(path: str | os.PathLike[str]) -> NoReturn:
    """Run the scene script at ``path`` as ``warpdrape run`` does, and end the process.

    For the end of a script, below ``if __name__ == "__main__":``; imported there, so that who only
    builds the scene has no command line with it.
    """
    raise SystemExit(main(["run", os.fspath(path), *sys.argv[1:]]))


def _dispatch(argv: list[str]) -> int:
    parser = build_parser()
    if argv and not argv[0].startswith("-") and argv[0] not in _COMMANDS:
        from warpdrape.errors import one_of

        one_of("command", argv[0], _COMMANDS)
    try:
        arguments = parser.parse_args(argv)
    except SystemExit as end:  # --help and --version have said what they had to
        return int(end.code or DONE)
    if arguments.command is None:
        parser.print_help()
        return DONE
    command = _COMMANDS[arguments.command]
    if arguments.quiet and command not in (_run, _resume, _compare):
        with redirect_stdout(io.StringIO()):
            return command(arguments)
    return command(arguments)


def _run(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.running import run

    return _ended(run(arguments))


def _resume(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.running import resume

    result = resume(arguments)
    if result is None:
        print(f"{arguments.run} is complete: extend it with --extend, or look at its summary.json")
        return DONE
    return _ended(result)


def _compare(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.comparing import compare

    failed = [run for run in compare(arguments) if run.failure]
    if not failed:
        return DONE
    return _complain("; ".join(f"{run.approach}: {run.failure}" for run in failed), FAILED)


def _ended(result: Result) -> int:
    if result.completed:
        return DONE
    return _complain(result.summary["message"], FAILED)


def _scenes(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.scene_library import bundled_scenes, describe_scene, find_typed

    if arguments.scene is None:
        _print_list(bundled_scenes())
    else:
        print(describe_scene(find_typed(arguments.scene)))
    return DONE


def _fabrics(arguments: argparse.Namespace) -> int:
    from warpdrape.errors import InputError
    from warpdrape.materials.fabric_library import fabric_names, load_fabric

    if arguments.fabric is None:
        if arguments.plot is not None:
            raise InputError("--plot needs a fabric: warpdrape fabrics NAME --plot FILE")
        _print_list({name: load_fabric(name).description for name in fabric_names()})
        return DONE
    from warpdrape.materials.fabric_card import card, plot_card
    from warpdrape.warp_start import start_warp

    fabric = load_fabric(arguments.fabric)
    start_warp()
    print(card(fabric))
    if arguments.plot is None:
        name = arguments.fabric
        print(f"\nCurves of tension and shear: warpdrape fabrics {name} --plot FILE.png")
    else:
        try:
            plot_card(fabric, arguments.plot)
        except (OSError, ValueError) as error:
            raise InputError(
                f"--plot {arguments.plot} cannot be written ({error}): give a place in a folder "
                "that exists, ending in .png"
            ) from error
        print(f"\nCurves in {arguments.plot}")
    return DONE


def _picture(arguments: argparse.Namespace) -> int:
    from warpdrape.errors import InputError
    from warpdrape.results.picture import draw_ply, draw_stack

    options = {"out": arguments.out, "tools": arguments.tools, "arrows": arguments.arrows}
    options |= {"field": arguments.field}
    if arguments.stack and arguments.ply is not None:
        raise InputError("give --ply NAME for one ply or --stack for all, not both")
    if arguments.video:
        print(_film(arguments, options))
        return DONE
    options["frame"] = whole("--frame", "-1" if arguments.frame is None else arguments.frame)
    if arguments.stack:
        print(draw_stack(arguments.run, **options))
    else:
        print(draw_ply(arguments.run, arguments.ply, **options))
    return DONE


def _film(arguments: argparse.Namespace, options: dict[str, Any]) -> Path:
    from warpdrape.errors import InputError
    from warpdrape.results.video import draw_video

    if arguments.frame is not None:
        raise InputError("give --frame K for one moment or --video for all, not both")
    if not arguments.quiet:
        print("Drawing every frame: that takes a second or more for each.", file=sys.stderr)
    return draw_video(arguments.run, arguments.ply, stack=arguments.stack, **options)


def _export(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.exporting import read_options
    from warpdrape.exports.export import ALL, export

    frame = arguments.frame
    if frame is not None and frame != ALL:
        frame = whole("--frame", frame)
    options = {"frame": frame, "overwrite": arguments.overwrite}
    options |= read_options(arguments.settings, trim=arguments.trim, onto=arguments.onto)
    print(export(arguments.run, arguments.to, arguments.out, **options))
    return DONE


def _judge(arguments: argparse.Namespace) -> int:
    from warpdrape.defects.limits import limits_of, read_limits
    from warpdrape.results.judgement import judge, not_judged, verdict
    from warpdrape.results.judgement_picture import draw_judgement
    from warpdrape.results.run_folder import JUDGEMENT
    from warpdrape.results.run_tables import read_history, read_summary

    given = None if arguments.limits is None else read_limits(arguments.limits)
    folder = Path(arguments.run)
    summary = read_summary(folder)
    limits = limits_of(summary) if given is None else given
    if summary["status"] != "completed":
        return _complain(f"the run failed, nothing to judge: {summary['message']}", FAILED)
    faults = judge(summary, read_history(folder), limits)
    print(verdict(faults, not_judged(summary, limits)))
    out = folder / JUDGEMENT if arguments.out is None else Path(arguments.out)
    print(f"Marked in {draw_judgement(folder, summary, faults, out)}")
    return UNFIT if faults else DONE


def _report(arguments: argparse.Namespace) -> int:
    from warpdrape.report.report import write_report

    frames = arguments.frames
    if frames is not None:
        frames = whole("--frames", frames, least=1)
    print(write_report(arguments.runs, arguments.out, frames=frames))
    return DONE


def _calibrate(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.interrupts import interrupt_kept

    draws = whole("--draws", arguments.draws)
    with interrupt_kept():
        from warpdrape.calibration.calibrate import run_calibration
        from warpdrape.warp_start import start_warp

    start_warp()
    print(
        run_calibration(
            arguments.tests,
            arguments.out,
            dry=arguments.dry,
            coupons=not arguments.no_coupons,
            draws=draws,
            overwrite=arguments.overwrite,
            say=(lambda _: None) if arguments.quiet else _say,
        )
    )
    return DONE


def _unit_cell(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.interrupts import interrupt_kept

    with interrupt_kept():
        from warpdrape.unit_cell.command import run_unit_cell
    print(
        run_unit_cell(
            arguments.weave,
            arguments.out,
            arguments.settings,
            dry=arguments.dry,
            overwrite=arguments.overwrite,
            say=(lambda _: None) if arguments.quiet else _say,
        )
    )
    return DONE


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def _new(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.writing import new

    new(arguments)
    return DONE


def _check(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.checking import check

    check(arguments)
    return DONE


def _study(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.interrupts import interrupt_kept

    with interrupt_kept():
        from warpdrape.studies.command import study

    why = study(arguments)
    return _complain(why, FAILED) if why else DONE


def _optimise(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.interrupts import interrupt_kept

    with interrupt_kept():
        from warpdrape.optimisation.command import optimise

    why = optimise(arguments)
    return _complain(why, FAILED) if why else DONE


def _verify(arguments: argparse.Namespace) -> int:
    from warpdrape.commands.interrupts import interrupt_kept

    with interrupt_kept():
        from warpdrape.verification.verify import main as verify_main
        from warpdrape.warp_start import start_warp

    start_warp()
    return verify_main(arguments.quick, arguments.out)


def _info(_: argparse.Namespace) -> int:
    import platform

    import warp as wp

    from warpdrape.results.run_record import versions
    from warpdrape.warp_start import start_warp

    start_warp()
    for name, version in versions().items():
        print(f"{name:12} {version}")
    print(f"{'system':12} {platform.platform()}, {os.cpu_count()} logical cores")
    for device in wp.get_devices():
        memory = f", {device.total_memory / 2**30:.0f} GiB" if device.is_cuda else ""
        print(f"{'device':12} {device.alias} ({device.name}{memory})")
    if not wp.is_cuda_available():
        print(f"{'':12} no CUDA device: a run uses the processor")
    print(f"{'kernel cache':12} {wp.config.kernel_cache_dir}")
    return DONE


_COMMANDS = {
    "new": _new,
    "check": _check,
    "run": _run,
    "resume": _resume,
    "compare": _compare,
    "scenes": _scenes,
    "fabrics": _fabrics,
    "picture": _picture,
    "export": _export,
    "judge": _judge,
    "report": _report,
    "calibrate": _calibrate,
    "unit_cell": _unit_cell,
    "study": _study,
    "optimise": _optimise,
    "verify": _verify,
    "info": _info,
}


def _print_list(lines: dict[str, str]) -> None:
    width = max(map(len, lines))
    for name, text in lines.items():
        print(f"{name:{width}}  {text}")


def _explain(error: Exception, argv: Sequence[str]) -> int:
    from warpdrape.errors import InputError, RunFailed

    if isinstance(error, InputError):
        return _complain(error, UNUSABLE)
    if isinstance(error, RunFailed):
        return _complain(error, FAILED)
    step = error.__traceback__
    while step is not None and step.tb_next is not None:
        step = step.tb_next
    where = ""
    if step is not None:
        where = f" in {Path(step.tb_frame.f_code.co_filename).name}, line {step.tb_lineno}"
    what = f"{type(error).__name__}{where}: {error}"
    if argv and argv[0] in READERS and isinstance(error, ODD):
        return _complain(
            f"the run cannot be used ({what}): its files hold a value that no run writes, as after "
            "damage or a change by hand: run the scene again; if that is no cure, please report it",
            UNUSABLE,
        )
    return _complain(f"unexpected {what}; please report it", FAILED)


def _complain(message: object, status: int) -> int:
    """Say what is wrong in one line on standard error."""
    sys.stdout.flush()
    print("warpdrape: error:", " ".join(str(message).split()), file=sys.stderr)
    return status


def _show_warning(message: Warning | str, *_: object, **__: object) -> None:
    print("warpdrape: warning:", " ".join(str(message).split()), file=sys.stderr)


def _never_fail_to_print() -> None:
    """Let a terminal that lacks a character, such as γ, show a question mark instead."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
