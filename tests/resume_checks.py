"""What the tests of checkpoints share: scenes that use all that remembers, cuts, comparisons."""

import dataclasses
import json
import math
import shutil
from pathlib import Path

import numpy as np
from law_checks import fabric
from pxr import Sdf

from warpdrape import Crossover, Friction, Pressure, Spring, Turn, WantedDirection, restart
from warpdrape.blanks.ply import Ply, lay_up, stack_top
from warpdrape.materials.bending import Bending, BendingCurve
from warpdrape.materials.laws import LinearTension, ShearPolynomial
from warpdrape.numerics import Numerics
from warpdrape.scene import Scene
from warpdrape.scenes import picture_frame
from warpdrape.setup import Clamp
from warpdrape.tools.floating import Float
from warpdrape.tools.motion import Stroke
from warpdrape.tools.tool import Tool

ELASTIC = fabric(LinearTension(300.0, 350.0), ShearPolynomial((2e-4,)))
STIFF = dataclasses.replace(ELASTIC, bending=Bending(warp=2e-4, weft=3e-4))
CURVED = dataclasses.replace(
    ELASTIC,
    bending=BendingCurve(
        curvatures=(0.0, 20.0, 200.0),
        moments_warp=(0.0, 4e-3, 2e-2),
        moments_weft=(0.0, 4e-3, 2e-2),
        friction=(1e-3, 1e-3),
        friction_curvature=5.0,
    ),
)
FASTER = {"yarn_softening": 4.0, "search_slide": 1e-4, "contact_share": 0.1}
TIMES = ("wall_s", "triangle_steps_per_s", "phases_s")
"""Entries of the summary that differ from run to run."""


def press(material=STIFF, clamped=False, **numerics):
    """Two plies on a ring, a ball that floats on them, a blade that slides: all that remembers."""
    plies = lay_up(
        [
            Ply.rectangle(name, material, 0.06, cells=5, warp_angle=angle)
            for name, angle in (("low", 0.0), ("high", 0.7))
        ]
    )
    top = stack_top(plies)
    ball = Tool.sphere("ball", radius=0.02).turned((1.0, 0.0, 0.0), math.pi).moved((0, 0, top))
    ball = dataclasses.replace(ball, motion=Stroke(travel=(0.002, 0.0, -0.006), duration=4e-3))
    plate = Tool.plate("plate", width=0.01, height=0.01, facing="down").moved((0.02, 0.02, top))
    plate = dataclasses.replace(plate, motion=Float(force=2.0, mass=0.05, ramp=1e-3))
    ring = Tool.die("ring", hole_radius=0.025, edge_radius=4e-3, outer_radius=0.06)
    edge = Clamp(name="edge", ply="low", where=lambda p: p[:, 0] < -0.0299)
    return Scene(
        name="press",
        plies=plies,
        tools=[ring, ball, plate],
        clamps=[edge] if clamped else [],
        duration=4e-3,
        numerics=Numerics(**numerics),
    )


def bars():
    """The same with yarns along the sides, each a chain of bars."""
    plies = lay_up([Ply.rectangle(name, STIFF, 0.06, cells=5) for name in ("low", "high")])
    return dataclasses.replace(press(**FASTER), plies=plies, approach="yarns")


def sliding():
    """The same with yarns that slide through each other."""
    scene, loose = bars(), {"slip_force_warp": 1e-3, "slip_force_weft": 2e-3}
    law = Crossover(**loose, stiffness_warp=50.0, stiffness_weft=80.0, friction=0.2)
    material = dataclasses.replace(STIFF, crossover=law)
    plies = [dataclasses.replace(ply, fabric=material) for ply in scene.plies]
    return dataclasses.replace(scene, plies=plies, approach="sliding_yarns")


def loaded():
    """With a gripper that slips, a pressure over time, friction that varies, and a wanted angle."""
    return dataclasses.replace(
        press(),
        friction=Friction(coefficient=0.2, by_speed=((0.0, 0.3), (1e-3, 0.1))),
        ply_friction=Friction(coefficient=0.3, by_angle=((0.0, 0.3), (90.0, 0.2))),
        process_duration=4.0,
        springs=[
            Spring(
                name="grip",
                ply="low",
                where=lambda p: p[:, 0] < -0.0299,
                to=(-0.05, 0.0, 0.0),
                stiffness=2e3,
                slip_force=0.5,
            )
        ],
        pressures=[Pressure(name="air", ply="high", pressure=[(1e-3, 0.0), (4e-3, 300.0)])],
        wanted=[WantedDirection(name="rib", ply="low", direction=(1.0, 0.0, 0.0))],
    )


def turning():
    """A plate that turns while it floats, and a ball that rolls down as it goes."""
    scene = press(contact="fast")
    ring, ball, plate = scene.tools
    roll = Turn(axis=(0.0, 1.0, 0.0), point=(0.0, 0.0, 0.02), angle=1.0, duration=4e-3)
    twist = Turn(axis=(0.0, 0.0, 1.0), point=(0.02, 0.02, 0.0), angle=[(1e-3, 0.1), (4e-3, 0.9)])
    tools = [ring, dataclasses.replace(ball, turn=roll), dataclasses.replace(plate, turn=twist)]
    return dataclasses.replace(scene, tools=tools)


def coupon():
    """A picture frame: clamps that follow functions, a report, files of its own."""
    return picture_frame.build(edge=0.02, duration=0.002, shear_angle_deg=20.0)


SCENES = {
    "fast": lambda: press(clamped=True, **FASTER),
    "paced": lambda: press(kinetic_limit=0.3),
    "selective": lambda: press(mass_scaling="selective", minimum_time_step=1.2e-5),
    "friction between fibres": lambda: press(CURVED),
    "membranes, exact": lambda: press(ELASTIC, contact="exact"),
    "coupon": coupon,
    "stress as a state": lambda: dataclasses.replace(press(**FASTER), approach="green_naghdi"),
    "chains of bars": bars,
    "yarns that slide": sliding,
    "loaded": loaded,
    "turning": turning,
}


class Cut(Exception):
    """In place of a kill."""


def cut_off(scene, folder: Path, frame, monkeypatch, *, frames=8, every=2, threads=1, resume=None):
    """Leave a folder as a run leaves it that is killed just before a frame's checkpoint."""
    at_frame = restart.Keeper.at_frame
    whole = folder.with_name(folder.name + " whole") if resume is None else resume

    def stop(self, now):
        if now == frame:
            self._recorder._files.usd.save()
            shutil.copytree(whole, folder, ignore=shutil.ignore_patterns(".lock"))
            raise Cut
        at_frame(self, now)

    with monkeypatch.context() as patch:
        patch.setattr(restart.Keeper, "at_frame", stop)
        try:
            if resume is None:
                scene.run(whole, frames=frames, checkpoint=every, threads=threads)
            else:
                scene.run(resume=whole, checkpoint=every)
        except Cut:
            shutil.rmtree(whole)
            return
    raise AssertionError("it came to its end")


def cut_between(scene, folder: Path, when, monkeypatch, *, frames=3, **options):
    """Leave a folder as a run leaves it that is killed just after a checkpoint between frames.

    Args:
        scene: to be run.
        folder: to be left.
        when: function of the last frame and the run's loading: whether it may be then; it is the
            third time.
        monkeypatch: pytest's.
        frames: of the run.
        options: of it.
    """
    whole, moments = folder.with_name(folder.name + " whole"), []

    def stop(self, frame, *, stopping):
        moments.extend([frame] if when(frame, self._loading) else [])
        if len(moments) == 3:
            self.take(frame)
            shutil.copytree(whole, folder, ignore=shutil.ignore_patterns(".lock"))
            raise Cut

    with monkeypatch.context() as patch:
        patch.setattr(restart.Keeper, "between", stop)
        try:
            scene.run(whole, frames=frames, checkpoint=frames, **options)
        except Cut:
            shutil.rmtree(whole)
            return
    raise AssertionError("it came to its end")


def timeless(summary):
    """A summary without what differs from run to run."""
    return {name: value for name, value in summary.items() if name not in TIMES}


def samples(path: Path) -> dict:
    """Every value of a USD file, those of all frames too."""
    layer, found = Sdf.Layer.OpenAsAnonymous(str(path)), {}

    def look(at):
        spec = layer.GetObjectAtPath(at)
        if isinstance(spec, Sdf.AttributeSpec):
            found[str(at)] = spec.default
            for time in layer.ListTimeSamplesForPath(at):
                found[str(at), time] = layer.QueryTimeSample(at, time)

    layer.Traverse(Sdf.Path.absoluteRootPath, look)
    found["times"] = (layer.startTimeCode, layer.endTimeCode)
    return found


def assert_same_folder(one: Path, other: Path) -> None:
    """Same files; same frames, rows, summary to the last bit."""
    names = [sorted(f.name for f in folder.iterdir()) for folder in (one, other)]
    assert names[0] == names[1], names
    for name in ("history.csv", "run.json", "coupon.csv"):
        if (one / name).exists():
            assert (one / name).read_bytes() == (other / name).read_bytes(), name
    mine, theirs = (json.loads((f / "summary.json").read_text("utf-8")) for f in (one, other))
    assert timeless(mine) == timeless(theirs)
    mine, theirs = samples(one / "scene.usdc"), samples(other / "scene.usdc")
    assert mine.keys() == theirs.keys() and len(mine) > 50
    for name, value in mine.items():
        assert np.array_equal(np.asarray(value), np.asarray(theirs[name])), name
