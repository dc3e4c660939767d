"""A ply's sliding yarns by themselves, without a run: one step from any state."""

import dataclasses

import numpy as np
import warp as wp
from element_checks import whole
from law_checks import fabric
from scipy.optimize import minimize_scalar

import warpdrape as wd
from warpdrape.blanks.ply import Ply
from warpdrape.forces.sliding_yarns import build_ply_sliding
from warpdrape.interaction import Bodies, Run, Share
from warpdrape.kernels.forces.yarn_chains import Slide
from warpdrape.materials.laws import LinearTension, ShearPolynomial
from warpdrape.numerics import Numerics
from warpdrape.state import start_plies

YARNS = LinearTension(46e3, 48e3)
COUPLE = ShearPolynomial((4e-4, -8e-4, 1e-3))
HOLD = {"slip_force_warp": 0.1, "slip_force_weft": 0.2, "stiffness_warp": 2e4}
HOLD["stiffness_weft"] = 3e4
FREE = {"slip_force_warp": 100.0, "slip_force_weft": 100.0, "stiffness_warp": 1e5}
FREE["stiffness_weft"] = 1e5
"""Crossovers that do not slip where they are only led a little."""


def cloth(tension=YARNS, shear=COUPLE, factor=1.0, **hold):
    """A fabric whose crossovers are as of `HOLD` but for what is given."""
    crossover = wd.Crossover(**HOLD | hold)
    return dataclasses.replace(fabric(tension, shear, factor=factor), crossover=crossover)


def blank(material=None, cells=3, mesh="diagonal", warp_angle=0.0):
    material = material or cloth()
    return Ply.rectangle("p", material, 0.03, cells=cells, mesh=mesh, warp_angle=warp_angle)


def scene_of(ply, **changes):
    changes = {"numerics": Numerics(yarn_viscosity=0.0)} | changes
    return wd.Scene(name="p", plies=[ply], duration=1.0, approach="sliding_yarns", **changes)


class Led:
    """One ply, led by hand."""

    def __init__(self, ply, device="cpu", **changes):
        self.scene = scene_of(ply, **changes)
        self.of = build_ply_sliding(self.scene, ply, whole(ply), device)
        self.device, self.count = device, len(self.of.chains.vertices)

    def slides(self, **values):
        """State of the crossovers: what is given, else zero."""
        found = np.zeros(self.count, dtype=Slide.numpy_dtype())
        for name, value in values.items():
            found[name] = value
        return found

    def step(self, x, slides, memory=None):
        """Forces [N], and the crossovers after a step; from what bars remember, if it is given."""
        memory, plies = memory or self.of.start(), start_plies(x, self.device)
        memory.slides.assign(slides)
        run = Run(0, len(x))
        share = Share(0, 1, (run,), ((run,),))
        bodies = Bodies(plies, None, None, None, None, None)
        launches = self.of.launches(share, bodies, memory)
        for launch in launches.scatter + launches.push:
            launch(self.device)
        return plies.f.numpy(), memory.slides.numpy()

    def measure(self, x, slides):
        """Energies stored and lost [J], and fields, by name."""
        memory = self.of.start()
        memory.slides.assign(slides)
        return self.of.measure(wp.array(x, dtype=wp.vec3d, device=self.device), memory)

    def energy(self, x, slides):
        """Of bars, couples and ties [J]."""
        stored = self.measure(x, slides)[0]
        return stored["yarn"] + stored["shear"] + stored["stabiliser"]

    def pulls(self, x, slides):
        """Q of the crossovers [N], shape [crossover, 2]: what moves them from rest."""
        of = self.of.crossovers
        left = self.of.chains.left(slides["s"])
        rate = self.step(x, slides)[1]["rate"]
        return rate * (of.inertia.numpy() + left * of.stiffness.numpy())


def saw_tooth_yarns(law, stretched, longer):
    """Forces of the yarns of warp and weft [N], and how high they climb [m], by brute force.

    They climb h1 + h2, as high as woven; energy ½ EA l e² of either, e its strain, least over h1.
    ``stretched``: the cell over its length as woven; ``longer``: yarn in it over that.
    """
    spacing = np.array([law.spacing_warp, law.spacing_weft]) * stretched
    length = np.array(law.lengths) * longer
    stiff, total = np.array([law.stiffness_warp, law.stiffness_weft]), sum(law.heights)

    def strains(first):
        heights = np.array([first, total - first])
        return np.maximum(np.hypot(spacing, heights) / length - 1.0, 0.0)

    found = minimize_scalar(
        lambda h: (0.5 * stiff * length * strains(h) ** 2).sum(),
        bounds=(0.0, total),
        method="bounded",
        options={"xatol": 1e-15},
    )
    return stiff * strains(found.x), np.array([found.x, total - found.x])
