"""What a card says of each specimen's own test, beside what was measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from warpdrape.calibration.compaction import CompactionFit
from warpdrape.calibration.fits import SHEAR, Fits
from warpdrape.calibration.hysteresis import first_loading
from warpdrape.calibration.kinds import FAMILIES
from warpdrape.calibration.preparation import in_bins, loading_curve
from warpdrape.calibration.shear import ShearFit
from warpdrape.calibration.tension import free_strip
from warpdrape.calibration.tests_file import Plan, Test
from warpdrape.coupons.closed_forms import bias_force, couple_per_area, frame_force, yarn_tensions
from warpdrape.materials.bending import Bending, BendingCurve
from warpdrape.materials.compaction import Compaction
from warpdrape.materials.fabric import Fabric
from warpdrape.materials.laws import CrimpInterchange, LinearTension


@dataclass(frozen=True, eq=False)
class Prediction:
    """One specimen's test by the card, point by point.

    Attributes:
        test: name of the test.
        specimen: name of the specimen.
        at: where, in SI, shape [n].
        measured: in SI, shape [n].
        predicted: by the card, shape [n].
        what: quantity and unit of the values, such as "force [N]".
        over: quantity and unit of ``at``.
        end: value of ``at`` up to which the card has data; beyond it is extrapolated.
    """

    test: str
    specimen: str
    at: np.ndarray
    measured: np.ndarray
    predicted: np.ndarray
    what: str
    over: str
    end: float = np.inf

    @property
    def errors(self) -> np.ndarray:
        """Predicted less measured, over the largest measured [-], within the card's data."""
        inside = self.at <= self.end * (1.0 + 1e-9)
        largest = float(np.abs(self.measured).max())
        if largest == 0.0 or not inside.any():
            return np.zeros(0)
        return (self.predicted - self.measured)[inside] / largest


def predictions(plan: Plan, fits: Fits, fabric: Fabric) -> list[Prediction]:
    """Predict every specimen of every test with the card as it was read back.

    Args:
        plan: the tests.
        fits: for what no card holds: friction, and where data end.
        fabric: of the new card.
    """
    found: list[Prediction] = []
    for test in plan.tests:
        if test.kind in SHEAR:
            found += _shear(test, fits, fabric)
        elif test.kind == "uniaxial_tension":
            found += _strips(test, fits, fabric)
        elif test.kind == "biaxial_tension":
            found += _biaxial(test, fits, fabric)
        elif test.kind == "cantilever":
            found += _cantilever(test, fits, fabric)
        elif test.kind == "bending_loop":
            found += _loops(test, fits, fabric)
        elif test.kind == "compaction":
            found += _compaction(test, fits, fabric)
        else:
            found += _friction(test, fits)
    return found


def shear_force(test: Test, fabric: Fabric, angle: np.ndarray) -> np.ndarray:
    """Force [N] (of Kawabata's shear per width [N/m]) of a shear test in closed form."""
    values = test.values
    if test.kind == "picture_frame":
        return frame_force(fabric, values["side"], angle, values.get("sample"))
    if test.kind == "bias_extension":
        return bias_force(fabric, values["width"], values["height"], angle)
    pulled = values.get("tension", 0.0)
    return (couple_per_area(fabric, angle) + pulled * np.sin(angle)) / np.cos(angle)


def _shear(test: Test, fits: Fits, fabric: Fabric) -> list[Prediction]:
    found = []
    for specimen in test.specimens:
        if test.kind == "shear_loop":
            at, force = in_bins(*first_loading(specimen, "angle", "line_force"))
            what = "shear force per width [N/m]"
        else:
            curve = loading_curve(test, specimen)
            at, force, what = curve.at, curve.force, "force [N]"
        said = shear_force(test, fabric, at)
        end = cast(ShearFit, fits.shear).basis.end  # as there is a test of it
        found.append(
            Prediction(test.name, specimen.name, at, force, said, what, "shear angle [rad]", end)
        )
    return found


def _strips(test: Test, fits: Fits, fabric: Fabric) -> list[Prediction]:
    """Strips whose other family is free; linear yarns from where the strips' line begins."""
    found, law = [], fabric.tension
    for curve in (c for c in fits.strips if c.test == test.name):
        number = FAMILIES.index(curve.family)
        if isinstance(law, CrimpInterchange):
            parameters = np.array(
                [law.crimp_warp, law.crimp_weft, law.stiffness_warp, law.stiffness_weft]
            )
            said = free_strip(parameters, number, curve.strain)
        elif isinstance(law, LinearTension) and curve.family in fits.linear:
            start = float(fits.linear[curve.family].start.value[0])
            said = getattr(law, curve.family) * np.maximum(curve.strain - start, 0.0)
        else:  # a table knows no free family: the other one is held
            strains = np.zeros((len(curve.strain), 2))
            strains[:, number] = curve.strain
            said = yarn_tensions(fabric, strains)[:, number]
        found.append(
            Prediction(
                test.name,
                curve.name,
                curve.strain,
                curve.tension,
                said,
                "tension per yarn [N]",
                "strain [-]",
            )
        )
    return found


def _biaxial(test: Test, fits: Fits, fabric: Fabric) -> list[Prediction]:
    found = []
    for points in (b for b in fits.biaxial if b.test == test.name):
        said = yarn_tensions(fabric, points.strains)
        for number, family in enumerate(FAMILIES):
            found.append(
                Prediction(
                    test.name,
                    f"{points.name}, {family}",
                    points.strains[:, number],
                    points.tensions[:, number],
                    said[:, number],
                    "tension per yarn [N]",
                    f"{family} strain [-]",
                )
            )
    return found


def _cantilever(test: Test, fits: Fits, fabric: Fabric) -> list[Prediction]:
    if not isinstance(fabric.bending, Bending):
        return []  # a curve's stiffness at a strip's curvatures is no one number
    family = test.values["family"]
    readings = fits.cantilevers[family].readings[test.name]
    said = np.full(len(readings), getattr(fabric.bending, family))
    strips = np.arange(1.0, len(readings) + 1)
    what = "bending stiffness [N·m]"
    return [Prediction(test.name, "all strips", strips, readings, said, what, "strip")]


def _loops(test: Test, fits: Fits, fabric: Fabric) -> list[Prediction]:
    family = test.values["family"]
    loop, found = fits.loops[family], []
    for specimen in test.specimens:
        at, moment = specimen.columns["curvature"], specimen.columns["moment"]
        if isinstance(fabric.bending, BendingCurve):
            said = loop.moment(at)
        else:
            said = getattr(fabric.bending, family) * at
        found.append(
            Prediction(
                test.name,
                specimen.name,
                at,
                moment,
                said,
                "moment per width [N]",
                "curvature [1/m]",
                float(loop.curvatures[-1]),
            )
        )
    return found


def _compaction(test: Test, fits: Fits, fabric: Fabric) -> list[Prediction]:
    fit, law = cast(CompactionFit, fits.compaction), cast(Compaction, fabric.compaction)
    contact, last = float(fit.pressures[0]), float(fit.pressures[-1])
    found = []
    for specimen in (s for s in fit.specimens if s.test == test.name):
        inside = specimen.pressure >= contact * (1.0 - 1e-9)
        at = specimen.pressure[inside]
        said = law.thickness_at(np.maximum(at - contact, 0.0))
        found.append(
            Prediction(
                test.name,
                specimen.name,
                at,
                specimen.thickness[inside],
                said,
                "thickness of a ply [m]",
                "pressure [Pa]",
                last,
            )
        )
    return found


def _friction(test: Test, fits: Fits) -> list[Prediction]:
    fit = fits.friction[test.values["against"]]
    law = fit.law("")
    own: Sequence = [r for r in fit.readings if r.test == test.name]
    said = [
        law(pressure=r.pressure, speed=r.speed, angle_deg=0.0 if r.yarns is None else r.yarns)
        for r in own
    ]
    measured = np.array([r.kinetic for r in own])
    return [
        Prediction(
            test.name,
            "all readings",
            np.array([r.pressure for r in own]),
            measured,
            np.array(said),
            "friction coefficient [-]",
            "pressure [Pa]",
        )
    ]
