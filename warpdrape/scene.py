"""A scene that runs: a setup, and the one call that computes it."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from warpdrape.approaches import solver_of
from warpdrape.setup import Setup

if TYPE_CHECKING:
    from warpdrape.results.result import Result


class Scene(Setup):
    """Everything that happens in a run, and the call that computes it.

    The solver reads the `Setup` in it and knows no `Scene`, so that imports make no circle.

    Attributes:
        name: of the scene.
        plies: from the bottom up; this order is kept.
        tools: rigid tools.
        clamps: held or led vertices.
        pressures: on sides of plies, over time.
        springs: and grippers, from vertices of plies to a frame.
        duration: simulated time [s].
        friction: between plies and tools that name none: a Coulomb coefficient [-], or a
            `Friction` that depends on pressure or speed.
        ply_friction: between plies, likewise; or one for each pair of their fabrics, such as
            ``{("carbon", "carbon"): 0.3, ("carbon", "glass"): 0.25}``.
        process_duration: time that the press takes for what is simulated in ``duration`` [s]; for
            friction that depends on speed, and plies with a viscous matrix: their clock is this.
        air: that takes heat from prepregs' open faces; None takes none.
        self_contact: whether the folds of plies that bend are held apart, with the friction of
            ``ply_friction``.
        gravity: acceleration [m/s²], shape [3].
        numerics: how it is computed.
        defects: from which size on something counts as a defect.
        limits: the most that the part may have of each, for ``warpdrape judge``; None for its own.
        wanted: directions that yarns should have, against which misalignment is reported.
        approach: by which it is computed: "semi_discrete"; with stress as a state in the frame
            "green_naghdi" or "fibre_frame"; "yarns" for chains of bars, "sliding_yarns" for such
            that are not pinned; or "fishnet" for a net on the closed tools.
        parameters: what the scene script was called with, for ``run.json``.
        script: path of the script that built it, likewise; empty for a bundled scene or none.
        call: how the command line began it, for ``warpdrape resume``; empty from Python.
        report: function of the finished result to further entries of ``summary.json``.
        write: function of the finished result and its run folder that adds files to it.
    """

    def run(
        self,
        out: str | os.PathLike | None = None,
        *,
        device: str = "cpu",
        frames: int | None = None,
        overwrite: bool = False,
        quiet: bool = True,
        profile: bool = False,
        threads: int | None = None,
        resume: str | os.PathLike | None = None,
        extend: bool = False,
        checkpoint: str | int = "auto",
    ) -> Result:
        """Compute the scene.

        Args:
            out: run folder to write; None writes nothing.
            device: "cpu" or "cuda:0".
            frames: frames of the animation and rows of the history; None takes 60, or those of the
                run that goes on.
            overwrite: replace results that the folder holds.
            quiet: show no progress.
            profile: time the phases now and then, for the entry ``phases_s`` of the summary.
            threads: of the CPU that share the steps; None takes the physical cores for a large
                model and one for a small one. Results differ by rounding from one number to
                another, and are the same to the bit for one.
            resume: folder of a run of this scene that was cut off: go on from its last checkpoint,
                to the same result.
            extend: go on beyond the end of that run, for the scene's longer ``duration`` or more
                ``frames``; motions must begin where the run has come to.
            checkpoint: how often to keep one: every so many frames, a time such as "60s", "auto"
                for as often as it takes less than a hundredth of the time, or "none".

        Returns:
            The finished run; ``result.summary["status"]`` says "completed" or "failed".

        Raises:
            InputError: unusable input, before any compute.
        """
        return solver_of(self.approach)(
            self,
            out,
            device=device,
            frames=frames,
            overwrite=overwrite,
            quiet=quiet,
            profile=profile,
            threads=threads,
            resume=resume,
            extend=extend,
            checkpoint=checkpoint,
        )
