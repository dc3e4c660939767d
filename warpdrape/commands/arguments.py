"""The arguments of the command line: commands, options, and the words of their help."""

from __future__ import annotations

import argparse
from typing import Any, NoReturn

from warpdrape.exports.formats import FORMATS

OUT = "runs"
"""Folder, in the current one, that takes a run's folder where ``--out`` is not given."""
VERIFICATION = f"{OUT}/verification"
"""… and the one that takes table and figures of ``warpdrape verify``."""


class _Parser(argparse.ArgumentParser):
    """A parser that says what is wrong in one line."""

    def error(self, message: str) -> NoReturn:
        from warpdrape.errors import InputError

        raise InputError(f"{message} (see {self.prog} --help)")


def build_parser() -> argparse.ArgumentParser:
    """The parser of the whole command line."""
    parser = _Parser(
        prog="warpdrape",
        allow_abbrev=False,
        description="Forming simulation of woven plies: shear, wrinkles, draw-in, forces.",
        epilog="Start with:  warpdrape run hemisphere",
    )
    parser.add_argument("--version", action="version", version=f"warpdrape {_version()}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", title="commands")
    _add_new(commands)
    _add_check(commands)
    _add_run(commands)
    _add_resume(commands)
    _add_compare(commands)
    scenes = _add(commands, "scenes", "list the bundled scenes, or one scene's parameters")
    scenes.add_argument("scene", metavar="SCENE", nargs="?", help="a bundled name, or a script")
    fabrics = _add(commands, "fabrics", "list the fabrics, or show one with its sources")
    fabrics.add_argument("fabric", metavar="NAME", nargs="?", help="a name, or a .toml file")
    fabrics.add_argument("--plot", metavar="FILE", help="draw its curves to a .png, .pdf or .svg")
    _add_picture(commands)
    _add_export(commands)
    _add_judge(commands)
    _add_report(commands)
    _add_calibrate(commands)
    _add_unit_cell(commands)
    _add_study(commands)
    _add_optimise(commands)
    verify = _add(commands, "verify", "check results against closed forms, and print a table")
    verify.add_argument("--quick", action="store_true", help="coarse meshes: less than a minute")
    verify.add_argument(
        "--out",
        metavar="DIR",
        default=VERIFICATION,
        help=f"folder for table and figures; {VERIFICATION} if not given",
    )
    _add(commands, "info", "show versions, devices and the kernel cache")
    return parser


def _add(commands: Any, name: str, words: str, epilog: str = "") -> argparse.ArgumentParser:
    command = commands.add_parser(
        name,
        help=words,
        description=f"{words[0].upper()}{words[1:]}.",
        epilog=epilog,
        allow_abbrev=False,
    )
    quiet = (
        "show no progress"
        if name in ("run", "resume", "compare")
        else "print nothing but what is wrong"
    )
    command.add_argument("-q", "--quiet", action="store_true", help=quiet)
    return command


def _add_new(commands: Any) -> None:
    new = _add(
        commands,
        "new",
        "write a commented scene script for your own part",
        "What is not given is asked for on a terminal, and elsewhere taken by default. "
        "Then: warpdrape check NAME.py, warpdrape run NAME.py.",
    )
    new.add_argument("name", metavar="NAME", help="of the scene; NAME.py is written")
    new.add_argument(
        "--mould", metavar="FILE", help="STEP or IGES, or STL, OBJ, PLY, OFF, GLB with --units"
    )
    new.add_argument("--units", metavar="UNIT", help="of files that state none: mm, cm, m or inch")
    new.add_argument(
        "--up", metavar="AXIS", default="z", help="the file's direction that is up: z, -z, x, …"
    )
    new.add_argument(
        "--kind", metavar="KIND", help="female or male; if not given, what the mould looks like"
    )
    new.add_argument(
        "--blank",
        metavar="BLANK",
        help="a .dxf, or a size such as 300x200mm; if not given, as large as the mould",
    )
    new.add_argument(
        "--layer", metavar="LAYER", help="of the .dxf that holds the blank, if it has several"
    )
    new.add_argument(
        "--angles", metavar="A,B,…", help="of the warp of each ply, from the bottom up [deg]"
    )
    new.add_argument("--fabric", metavar="NAME", help="a name, or a .toml file")
    new.add_argument(
        "--holder", metavar="FORCE", help="of the blank holder, such as 200N; 0 for no holder"
    )


def _add_check(commands: Any) -> None:
    check = _add(
        commands,
        "check",
        "say what a scene will do, and draw it, without running it",
        "Makes the checks of a run's start. Exit status: 0 it would run, 2 the input cannot be "
        "used.",
    )
    _add_scene(check)
    check.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        dest="settings",
        help="a parameter of the scene, in SI units; may be repeated",
    )
    check.add_argument("--out", metavar="FILE", help="the picture; SCENE_check.png if not given")
    check.add_argument("--device", default="cpu", help="cpu (the default) or cuda:0")
    check.add_argument("--frames", metavar="N", default="60", help="as for run; 60 if not given")


def _add_run(commands: Any) -> None:
    run = _add(
        commands,
        "run",
        "run a scene and write its results to a folder",
        "Exit status: 0 done, 1 the run failed, 2 the input cannot be used. "
        "Ctrl-C stops a run and keeps the frames it has; warpdrape resume goes on.",
    )
    _add_scene(run)
    run.add_argument(
        "--out", metavar="DIR", help=f"folder for the results; {OUT}/SCENE if not given"
    )
    _add_settings(run)
    _add_how(run)
    run.add_argument("--overwrite", action="store_true", help="replace the results in the folder")


def _add_scene(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "scene",
        metavar="SCENE",
        help="a bundled name (see warpdrape scenes), or the "
        "path of a script with a function build()",
    )


def _add_settings(command: argparse.ArgumentParser) -> None:
    """Options of what runs a scene from its start."""
    command.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        dest="settings",
        help="a parameter of the scene, in SI units; may be repeated",
    )
    command.add_argument("--device", default="cpu", help="cpu (the default) or cuda:0")
    command.add_argument(
        "--frames",
        metavar="N",
        default="60",
        help="frames of the animation and rows of the history; 60 if not given",
    )
    command.add_argument(
        "--threads",
        metavar="N",
        help="threads of the CPU; if not given, the physical cores for a large model, "
        "one for a small one",
    )


def _add_compare(commands: Any) -> None:
    compare = _add(
        commands,
        "compare",
        "run a scene by several approaches and put them side by side",
        "Writes a run folder for each, comparison.csv and comparison.png, and prints the figures. "
        "Runs that are there already, finished and of the same scene, are taken as they are. "
        "Exit status: 0 done, 1 an approach failed, 2 the input cannot be used.",
    )
    _add_scene(compare)
    compare.add_argument(
        "--approaches",
        metavar="A,B,…",
        help="their names, differences being from the first; all of them if not given",
    )
    compare.add_argument(
        "--out",
        metavar="DIR",
        help=f"folder for the runs and the comparison; {OUT}/SCENE_approaches if not given",
    )
    _add_settings(compare)
    compare.add_argument(
        "--ply", metavar="NAME", help="the ply that is drawn and printed; the first if not given"
    )
    compare.add_argument(
        "--report", action="store_true", help="write comparison.html too, as warpdrape report does"
    )
    compare.add_argument(
        "--overwrite",
        action="store_true",
        help="replace runs in the folder that are unfinished or of another scene",
    )


def _add_how(command: argparse.ArgumentParser) -> None:
    """Options of whatever computes."""
    command.add_argument("--profile", action="store_true", help="show where the time went")
    command.add_argument(
        "--report", action="store_true", help="write report.html too, as warpdrape report does"
    )
    command.add_argument(
        "--checkpoint",
        metavar="EVERY",
        default="auto",
        help="keep one every so many frames (5) or seconds (60s), or none; if not given, as often "
        "as it takes less than a hundredth of the time; another when a signal ends the run",
    )


def _add_resume(commands: Any) -> None:
    resume = _add(
        commands,
        "resume",
        "go on with a run from its last checkpoint",
        "The result is that of a run that was never cut off. Exit status as of run.",
    )
    resume.add_argument("run", metavar="RUN", help="the folder of a run")
    resume.add_argument(
        "--extend",
        metavar="BY",
        help="go on beyond its end: strokes by a way (10mm), all by a time (8ms) or 12frames",
    )
    resume.add_argument(
        "--scene",
        metavar="SCENE",
        help="the scene that was run, where its script has been moved or changed",
    )
    _add_how(resume)


def _add_picture(commands: Any) -> None:
    picture = _add(commands, "picture", "draw a formed ply, coloured by shear or another field")
    picture.add_argument("run", metavar="RUN", help="the folder of a run")
    picture.add_argument("--ply", metavar="NAME", help="which ply; the middle one if not given")
    picture.add_argument(
        "--field",
        metavar="FIELD",
        default="shear",
        help="shear if not given; warp- or weft-strain, -tension, -curvature; slip, "
        "contact-pressure, tool-pressure, thickness, fibre-volume, wrinkle, tool-distance",
    )
    picture.add_argument("--stack", action="store_true", help="draw all plies side by side")
    picture.add_argument("--frame", metavar="K", help="which frame; -1, the last one, if not given")
    picture.add_argument("--tools", action="store_true", help="draw the tools too, translucent")
    picture.add_argument(
        "--arrows", action="store_true", help="arrows along warp and weft in place of lines"
    )
    picture.add_argument(
        "--video", action="store_true", help="draw all frames, as a .mp4 or, with --out, a .gif"
    )
    picture.add_argument(
        "--out", metavar="FILE", help="the .png or .pdf, .mp4 or .gif; in RUN if not given"
    )


def _add_judge(commands: Any) -> None:
    judge = _add(
        commands,
        "judge",
        "say whether a run's defects are within limits, and mark where not",
        "Exit status: 0 fit, 3 unfit, 1 the run failed, 2 the input cannot be used.",
    )
    judge.add_argument("run", metavar="RUN", help="the folder of a run")
    judge.add_argument(
        "limits",
        metavar="LIMITS",
        nargs="?",
        help="a .toml file with limits; if not given those of the scene, and where it has none: no "
        "wrinkle, no bridge, nothing past locking or failure. With a table [thresholds] defects "
        "are measured again by these, without running",
    )
    judge.add_argument(
        "--scene",
        metavar="SCRIPT",
        help="the scene for other thresholds, where the run's own script is gone or has changed",
    )
    judge.add_argument("--out", metavar="FILE", help="the .png or .pdf; in RUN if not given")


def _add_report(commands: Any) -> None:
    report = _add(
        commands,
        "report",
        "write a run, or several beside each other, as one HTML file",
        "The file needs no network: 3-D view over time, curves, the result in words, and how the "
        "run was made. Of several runs it shows differences from the first.",
    )
    report.add_argument("runs", metavar="RUN", nargs="+", help="the folder of a run")
    report.add_argument(
        "--out",
        metavar="FILE",
        help="the .html; if not given RUN/report.html, and for several runs comparison.html in the "
        "current folder",
    )
    report.add_argument(
        "--frames",
        metavar="N",
        help="frames of each run in the 3-D view at most; if not given, as many as keep the file "
        "small",
    )


def _add_calibrate(commands: Any) -> None:
    calibrate = _add(
        commands,
        "calibrate",
        "make a fabric's card from raw tests, and lay its coupons over them",
        "Exit status: 0 done, 2 the input cannot be used.",
    )
    calibrate.add_argument("tests", metavar="TESTS", help="a .toml file that names the raw tables")
    calibrate.add_argument(
        "--out",
        metavar="FABRIC",
        help="the card's .toml; pictures, residuals and report go to FABRIC_calibration beside it",
    )
    calibrate.add_argument("--dry", action="store_true", help="say what was understood, and stop")
    calibrate.add_argument(
        "--no-coupons", action="store_true", help="do not simulate the tests with the new card"
    )
    calibrate.add_argument(
        "--draws", metavar="N", default="400", help="samples of the bootstrap; 400 if not given"
    )
    calibrate.add_argument("--overwrite", action="store_true", help="replace the card")


def _add_unit_cell(commands: Any) -> None:
    cell = _add(
        commands,
        "unit_cell",
        "make a fabric's card from its weave: a unit cell of yarns in contact, pulled and sheared",
        "Exit status: 0 done, 1 the cell finds no rest, 2 the input cannot be used.",
    )
    cell.add_argument(
        "weave",
        metavar="WEAVE",
        help="plain, twill or satin, or a .toml file with the cell's values",
    )
    cell.add_argument(
        "--out",
        metavar="FABRIC",
        help="the card's .toml; pictures, curves and record go to FABRIC_unit_cell beside it",
    )
    cell.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        dest="settings",
        help='a value of the cell with its unit, as width="4.2 mm"; may be repeated',
    )
    cell.add_argument("--dry", action="store_true", help="say what was understood, and stop")
    cell.add_argument("--overwrite", action="store_true", help="replace the card")


def _add_export(commands: Any) -> None:
    known = "; ".join(f"{name}: {each.words}" for name, each in FORMATS.items())
    export = _add(commands, "export", "write a run in the format of another program", known)
    export.add_argument("run", metavar="RUN", help="the folder of a run")
    export.add_argument("--to", metavar="FORMAT", required=True, help=", ".join(FORMATS))
    export.add_argument("--out", metavar="PATH", help="the file; in RUN/export if not given")
    export.add_argument(
        "--frame",
        metavar="N",
        help="which frame, negative ones from the end, or all; if not given all for vtk and "
        "vtkhdf, and the last one for others",
    )
    export.add_argument(
        "--trim",
        metavar="WHERE",
        help="dxf and svg: where the part ends: a side, z<-20mm or x+0.5*z>10mm; tool:NAME for "
        "that tool's border; or a .dxf, .csv or .json with closed curves",
    )
    export.add_argument(
        "--onto", metavar="MESH", help="mapped and mapped-vtk: the mesh, in the run's coordinates"
    )
    export.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        dest="settings",
        help="what a format wants to know, may be repeated; permeability: fibre_diameter=7um, "
        "packing=hexagonal or quadratic, or kozeny_along and kozeny_across, warp_share=0.5; "
        "mapped: unit=1mm, farthest=10mm; --trim with a curve: along=z",
    )
    export.add_argument("--overwrite", action="store_true", help="replace the file")


def _add_study(commands: Any) -> None:
    study = _add(
        commands,
        "study",
        "run a scene many times, with parameters that vary, and report what they do",
        "Started again, it runs only what is missing. Exit status: 0 all runs have ended, failed "
        "ones among them too; 1 it was interrupted, or none completed; 2 the input cannot be used.",
    )
    _add_study_options(study)


def _add_optimise(commands: Any) -> None:
    optimise = _add(
        commands,
        "optimise",
        "look for the settings of a scene that are best, beside random ones of equal cost",
        "Started again, it runs only what is missing. Exit status: 0 all runs have ended, failed "
        "ones among them too; 1 it was interrupted, or none completed; 2 the input cannot be used.",
    )
    _add_study_options(optimise)
    optimise.add_argument(
        "--slopes",
        action="store_true",
        help="show how what is aimed at goes with each parameter at the start, and whether a "
        "gradient may be trusted; search nothing",
    )
    optimise.add_argument(
        "--seed", metavar="N", help="of what is random, in place of the file's; give --out too"
    )


def _add_study_options(study: argparse.ArgumentParser) -> None:
    study.add_argument("study", metavar="STUDY", help="a .toml file")
    study.add_argument("--out", metavar="DIR", help=f"folder; {OUT}/NAME if not given")
    study.add_argument("--workers", metavar="N", help="processes here; one a core if not given")
    study.add_argument(
        "--scheduler", metavar="ADDRESS", help="a Dask scheduler whose workers do the runs"
    )
    study.add_argument(
        "--retry-failed", action="store_true", help="run again what did not complete"
    )
    study.add_argument(
        "--plan", action="store_true", help="show what would be run, and run nothing"
    )


def whole(option: str, text: str, least: int | None = None) -> int:
    """Read a whole number; raise `InputError` if it is none, or too small."""
    from warpdrape.errors import InputError

    try:
        number = int(text)
    except ValueError:
        raise InputError(f"{option} {text} must be a whole number") from None
    if least is not None and number < least:
        raise InputError(f"{option} {number} must be {least} or more")
    return number


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("warpdrape")
    except PackageNotFoundError:
        return "(not installed)"
