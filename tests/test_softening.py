"""Softer yarns: what is divided and what is kept, the step gained, and the error stated."""

import math
from dataclasses import replace

import numpy as np
import pytest
from law_checks import PLAIN, SPACING, crimp_table, fabric

from warpdrape import Numerics, Ply, Scene, Stroke
from warpdrape.dynamics.time_step import lump_masses
from warpdrape.errors import InputError
from warpdrape.forces.membrane_stiffness import stabiliser_stiffness
from warpdrape.materials.law_data import tension_stiffness
from warpdrape.materials.laws import IsotropicMembrane, LinearTension, ShearPolynomial
from warpdrape.materials.softening import STRAIN_WARNING, soften
from warpdrape.results.soundness import ENERGY_WARNING
from warpdrape.scenes import hemisphere
from warpdrape.setup import Clamp

INTERLOCK = ShearPolynomial((0.37044e-3, -0.84105e-3, 1.03113e-3))
LAWS = {
    "linear": fabric(LinearTension(46e3, 48e3), INTERLOCK),
    "crimp": fabric(PLAIN, INTERLOCK, cell=(SPACING, SPACING)),
    "tabulated": fabric(crimp_table(), INTERLOCK, cell=(SPACING, SPACING)),
}


@pytest.mark.parametrize("law", LAWS)
def test_tension_is_divided_and_compression_kept(law):
    true, soft = LAWS[law], soften(LAWS[law], 25.0)
    with_none = [replace(f, compressive_factor=0.0) for f in (true, soft)]
    stiff = [np.array(tension_stiffness(f)) for f in with_none]
    np.testing.assert_allclose(25.0 * stiff[1], stiff[0], rtol=1e-6)
    np.testing.assert_allclose(
        soft.compressive_factor * stiff[1], true.compressive_factor * stiff[0], rtol=1e-6
    )
    assert (soft.shear, soft.areal_density) == (true.shear, true.areal_density)


def test_nothing_changes_without_softening_or_yarns():
    linear = LAWS["linear"]
    assert soften(linear, 1.0) is linear
    sheet = fabric(IsotropicMembrane(2e4, 0.3))
    assert soften(sheet, 25.0) is sheet


def test_the_step_grows_with_the_root_and_no_mass_is_added():
    ply = Ply.rectangle("ply", "carbon_interlock", 0.1, cells=4)
    masses = [
        lump_masses(Scene(name="s", plies=[ply], duration=1.0, numerics=numerics))
        for numerics in (Numerics(), Numerics(yarn_softening=25.0))
    ]
    # Shear stiffness up to 75° shares the step, so a little less than 5 is gained.
    assert 4.5 < masses[1].stable_step / masses[0].stable_step < 5.0
    np.testing.assert_array_equal(masses[0].mass, masses[1].mass)
    assert not masses[1].added.any()


def test_the_stabiliser_keeps_its_floor():
    weak = fabric(LinearTension(46e3, 48e3), ShearPolynomial((1e-9,)))
    stiffness = [stabiliser_stiffness(weak, Numerics(yarn_softening=s)) for s in (1.0, 25.0)]
    assert stiffness[0] == stiffness[1] > 0.0


def test_softening_is_refused_where_it_makes_no_sense():
    with pytest.raises(InputError, match=r"yarn_softening = 0\.5 must be 1 or more"):
        Numerics(yarn_softening=0.5)
    scene = hemisphere.build(cells=4)
    scene = replace(scene, numerics=Numerics(yarn_softening=200.0))
    with pytest.raises(InputError, match="above 100, where the yarns of 'carbon_interlock'"):
        scene.run()


def pulled(softening, stretch=2e-3):
    """A strip pulled along its warp by a strain, with little friction to reach rest."""
    ply = Ply.rectangle("ply", "carbon_interlock", 0.1, 0.05, cells=4)
    led = {"ply": "ply", "name": "right", "where": lambda p: p[:, 0] > 0.0499}
    held = Clamp(name="left", ply="ply", where=lambda p: p[:, 0] < -0.0499)
    pull = Stroke(travel=(0.1 * stretch, 0.0, 0.0), duration=4e-3)
    return Scene(
        name="strip",
        plies=[ply],
        clamps=[held, Clamp(**led, motion=pull)],
        duration=6e-3,
        gravity=(0.0, 0.0, 0.0),
        numerics=Numerics(yarn_softening=softening, damping=500.0),
    ).run(frames=6)


def test_a_run_states_the_strain_it_owes_and_warns():
    true, soft, softer = pulled(1.0), pulled(10.0), pulled(10.0, stretch=4e-3)
    assert true.summary["yarn_softening"] == 1.0
    assert true.summary["softening_strain"] == 0.0
    strain = max(ply.strain.max() for ply in soft.plies)
    assert soft.summary["softening_strain"] == pytest.approx(0.9 * strain)
    assert soft.summary["yarn_energy_ratio"] == pytest.approx(1.0, abs=1e-3)
    tension = [r.plies[0].line_tension[:, 0].mean() for r in (true, soft)]
    assert tension[1] == pytest.approx(tension[0] / 10.0, rel=0.02)
    assert not [w for w in soft.summary["warnings"] if "softened" in w]
    assert [w for w in softer.summary["warnings"] if "softened yarns stretch" in w]
    assert soft.summary["steps"] < 0.4 * true.summary["steps"]
    assert soft.summary["energy_error"] < ENERGY_WARNING


def test_a_fast_coarse_hemisphere_is_near_the_accurate_one():
    """At its full duration: in 30 ms, where inertia carries 10 %, the two differ by 0.6°.

    With 14 cells they differ by 0.26°, with 10 by 0.53°, with the usual 20 by 0.12°.
    """
    accurate, fast = (
        hemisphere.build(cells=14, accuracy=accuracy).run(frames=10).summary
        for accuracy in ("reference", "standard")
    )
    assert fast["status"] == "completed"
    assert fast["steps"] < 0.25 * accurate["steps"]
    near = [s["plies"][0]["p95_shear_deg"] for s in (accurate, fast)]
    assert abs(near[1] - near[0]) < 0.5
    assert 0.0 < fast["softening_strain"] < STRAIN_WARNING
    assert fast["energy_error"] < ENERGY_WARNING


@pytest.mark.slow
@pytest.mark.parametrize("angle_deg", [0.0, 45.0])
def test_a_fast_hemisphere_is_within_half_a_degree(angle_deg):
    accurate, fast = (
        hemisphere.build(angle_deg=angle_deg, accuracy=accuracy).run(frames=20).summary
        for accuracy in ("reference", "standard")
    )
    assert fast["quasi_static"] and fast["steps"] < 0.25 * accurate["steps"]
    for name, limit in (("p95_shear_deg", 0.5), ("mean_abs_shear_deg", 0.5)):
        assert abs(fast["plies"][0][name] - accurate["plies"][0][name]) < limit
    drawn = [s["plies"][0]["draw_in_m"]["warp"] for s in (accurate, fast)]
    assert abs(drawn[1] - drawn[0]) < 1e-3
    assert math.isclose(fast["mass_kg"], accurate["mass_kg"])
