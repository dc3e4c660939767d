"""The loading clock: as given without a limit, held back by kinetic energy with one."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from law_checks import fabric
from test_coupons import read

from warpdrape import simulation
from warpdrape.blanks.ply import Ply
from warpdrape.dynamics.loading import HASTENING, SLOWEST_PACE, SLOWING, Loading, reference_energy
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.errors import InputError
from warpdrape.materials.laws import IsotropicMembrane, LinearTension, NoShear, ShearPolynomial
from warpdrape.numerics import Numerics
from warpdrape.results.summary_text import summary_text
from warpdrape.scene import Scene
from warpdrape.scenes import biaxial_tension, circular_table, hemisphere, picture_frame
from warpdrape.timing import Timing, frame_times

TIMING = Timing(
    time_step=1e-5,
    stable_step=1.1e-5,
    search_every=3,
    frames=5,
    steps_per_frame=300,
    steps_ahead=6,
)
COUPLE = 2e-4


def clock(limit=0.05, timing=TIMING):
    cloth = fabric(LinearTension(46e3, 48e3), ShearPolynomial((COUPLE,)))
    scene = Scene(
        name="still",
        plies=[Ply.rectangle("ply", cloth, 0.1, cells=2)],
        duration=timing.steps * timing.time_step,
        numerics=Numerics(kinetic_limit=limit),
    )
    return Loading(scene, timing)


def run(clock, kinetic):
    """Stretches of a whole run, where kinetic energy over the allowed one follows the pace."""
    stretches, seen = [], []
    for frame in range(1, TIMING.frames + 1):
        while not clock.come_to(frame):
            stretches.append(clock.stretch(frame))
            if clock.limited:
                clock.adapt(kinetic(clock) * 0.05 * clock._reference, 0.0)
        seen.append(clock.time)
    return stretches, np.array(seen)


def test_without_a_limit_the_motions_are_as_given():
    free = clock(limit=None)
    stretches, _ = run(free, None)
    assert not free.limited and len(stretches) == TIMING.frames
    for frame, times in enumerate(stretches, 1):
        np.testing.assert_array_equal(times, frame_times(TIMING, frame))
    assert free.steps == TIMING.steps and free.entries() == {} and free.warnings() == []


def test_a_limit_that_is_never_reached_changes_no_time():
    held = clock()
    stretches, seen = run(held, lambda c: 0.1)
    assert held.steps == TIMING.steps
    times = np.concatenate([stretches[0][:1], *(s[1:] for s in stretches)])
    np.testing.assert_allclose(times, np.arange(TIMING.steps + 1) * TIMING.time_step, atol=1e-15)
    assert held.entries()["slowest_pace"] == 1.0 and held.warnings() == []
    np.testing.assert_allclose(seen, frame_times(TIMING, 1)[-1] * np.arange(1, 6))


def test_pace_follows_the_energy_without_a_jump():
    """Kinetic energy goes with the square of the pace; it is nine times too high in the middle."""
    held = clock()
    middle = TIMING.steps * TIMING.time_step * np.array([0.3, 0.6])

    def kinetic(c):
        return c.pace**2 * (9.0 if middle[0] < c.time < middle[1] else 0.5)

    stretches, seen = run(held, kinetic)
    for before, after in pairwise(stretches):
        assert before[-1] == after[0]
    times = np.concatenate([stretches[0][:1], *(s[1:] for s in stretches)])
    pace = np.diff(times) / TIMING.time_step
    end = times[-1]
    # Motions go on to the end of a block: cut off before it, tools and clamps would stop dead.
    assert 0.0 <= end - TIMING.steps * TIMING.time_step < 3.01 * TIMING.time_step
    assert np.abs(np.diff(pace)).max() < 2.0 * (1.0 - SLOWING) / TIMING.steps_ahead
    inside = (times[1:] > middle[0] + 0.4 * np.diff(middle)) & (times[1:] < middle[1])
    np.testing.assert_allclose(pace[inside], 1.0 / 3.0, rtol=1e-6)
    assert pace[-10] == pytest.approx(1.0) and pace[0] == 1.0
    assert held.entries()["slowest_pace"] == pytest.approx(1.0 / 3.0, rel=0.01)
    assert held.entries()["kinetic_over_limit"] == pytest.approx(9.0, rel=0.01)
    assert held.simulated == pytest.approx(held.steps * TIMING.time_step)
    # Frames stay where they are in loading time, to a block.
    even = TIMING.steps * TIMING.time_step * np.arange(1, 6) / 5
    assert ((seen >= even * (1.0 - 1e-9)) & (seen <= even + 3.01 * TIMING.time_step)).all()


def test_frames_are_met_to_a_block_also_while_the_pace_falls():
    held = clock(timing=replace(TIMING, steps_ahead=120))
    _, seen = run(held, lambda _: 100.0)
    frame = TIMING.steps_per_frame * TIMING.time_step
    assert held.time == seen[-1] and held.entries()["slowest_pace"] < 0.3
    beyond = seen - frame * np.arange(1, 6)
    assert (beyond >= -1e-9 * frame).all() and (beyond <= 3.01 * TIMING.time_step).all()


def test_numbers_that_are_not_finite_leave_the_pace_alone():
    """The steps after will fail, and say where."""
    held = clock()
    for kinetic, internal in ((math.nan, 1.0), (1.0, math.nan), (math.inf, 1.0)):
        held.adapt(kinetic, internal)
    held.adapt(0.0, -1.0)  # rounding, or a table of tensions that no energy belongs to
    assert len(held.stretch(1)) == TIMING.steps_ahead + 1 and held.pace == 1.0


@pytest.mark.parametrize(
    ("frames", "limit", "looks"), [(1, 0.05, 240), (60, 0.05, 240), (1000, 0.05, 1000), (1, 0.0, 1)]
)
def test_motions_are_known_up_to_the_next_look(frames, limit, looks):
    model = build_model(hemisphere.build(cells=4, kinetic_limit=limit), "cpu", frames)
    timing = model.timing
    assert timing.steps_ahead % timing.search_every == 0
    assert looks <= timing.steps / timing.steps_ahead < 1.2 * looks
    assert initial_state(model).tools.path.shape[1] == timing.steps_ahead + 1


def test_pace_is_bounded_and_a_limit_that_cannot_be_kept_is_said():
    held = clock()
    held.stretch(1)
    held.adapt(100.0 * held._reference, 0.0)
    held.stretch(1)
    assert held.pace == pytest.approx(SLOWING)
    held.adapt(0.0, 0.0)
    held.stretch(1)
    assert held.pace == pytest.approx(SLOWING * HASTENING)
    stretches, _ = run(held, lambda c: 100.0)
    assert min(np.diff(s).min() for s in stretches[:-1]) > 0.999 * SLOWEST_PACE * TIMING.time_step
    assert held.entries()["slowest_pace"] == SLOWEST_PACE
    assert held.steps < 1.01 * TIMING.steps / SLOWEST_PACE
    (warning,) = held.warnings()
    assert "kinetic_limit = 0.05" in warning and "lengthen the duration" in warning


def test_the_reference_is_what_plies_store_at_five_degrees_and_little_strain():
    angle, strain = math.radians(5.0), 2e-5
    cloth = fabric(LinearTension(46e3, 48e3), ShearPolynomial((COUPLE,)))
    ply = Ply.rectangle("ply", cloth, 0.1, cells=2)
    along = 46e3 / cloth.yarn_width[0] + 48e3 / cloth.yarn_width[1]
    expected = 0.5 * (COUPLE / cloth.cell_area * angle**2 + along * strain**2) * 0.01
    assert reference_energy((ply, ply)) == pytest.approx(2.0 * expected)
    sheet = fabric(IsotropicMembrane(1e4, 0.25), NoShear())
    shear = 1e4 / (2.0 * 1.25)
    ply = Ply.rectangle("ply", sheet, 0.1, cells=2)
    along = 2.0 * 1e4 / (1.0 - 0.25)
    expected = 0.5 * (shear * angle**2 + along * strain**2) * 0.01
    assert reference_energy((ply,)) == pytest.approx(expected)


@pytest.mark.parametrize("limit", [0.0, -0.1, 1.0, 5.0, math.nan, "much"])
def test_a_bad_limit_is_refused(limit):
    with pytest.raises(InputError, match="kinetic_limit"):
        Numerics(kinetic_limit=limit)


def test_a_limit_where_nothing_moves_is_refused():
    """A drape would fall for ten times its duration."""
    scene = circular_table.build(cells=4, duration=1e-3)
    with pytest.raises(
        InputError, match=r"kinetic_limit = 0.05 .* none of them moves: leave it out"
    ):
        limited(scene, 0.05).run(frames=1)


def test_the_summary_says_how_well_the_limit_was_kept():
    summary = coarse(frames=1, travel=0.005).summary | {"kinetic_limit": 0.05}
    kept = summary_text(summary | {"slowest_pace": 1.0, "kinetic_over_limit": 0.123})
    assert "motions not slowed: kinetic energy at most 0.12 times what kinetic_limit (5 %" in kept
    passed = summary_text(summary | {"slowest_pace": 0.3, "kinetic_over_limit": 4.0})
    assert "motions slowed to 0.3 of their speed: kinetic energy at most 4 times" in passed


def limited(scene, limit):
    """The scene, held back."""
    return replace(scene, numerics=replace(scene.numerics, kinetic_limit=limit))


def coarse(frames=10, device="cpu", **options):
    """A hemisphere pressed in 20 ms, where inertia spoils it."""
    return hemisphere.build(cells=8, duration=0.02, **options).run(frames=frames, device=device)


def test_a_hasty_press_is_slowed_down_and_comes_out_like_a_slow_one(device):
    slow = hemisphere.build(cells=8, duration=0.16).run(frames=10)
    hasty, held = coarse(), coarse(device=device, kinetic_limit=0.05)
    assert held.completed and held.summary["quasi_static"] and not hasty.summary["quasi_static"]
    assert 2.0 < held.summary["simulated_s"] / hasty.summary["simulated_s"] < 1.0 / SLOWEST_PACE
    drawn = [r.summary["plies"][0]["draw_in_m"]["warp"] for r in (slow, hasty, held)]
    assert abs(drawn[2] - drawn[0]) < 0.5 * abs(drawn[1] - drawn[0])
    history = held.history
    assert len(history["time_s"]) == 11
    assert history["punch_displacement_m"][-1] == pytest.approx(0.075, abs=1e-12)
    even = 0.024 * np.arange(11) / 10
    np.testing.assert_allclose(history["loading_time_s"], even, atol=5e-5)
    assert history["time_s"][-1] == held.summary["simulated_s"]
    assert (np.diff(history["time_s"]) >= np.diff(history["loading_time_s"]) - 1e-12).all()
    loaded = history["internal_j"] > 0.1 * history["internal_j"].max()
    assert (history["kinetic_j"] / history["internal_j"])[loaded].max() < 0.15
    assert held.summary["energy_error"] < 0.01
    assert "motions slowed to" in summary_text(held.summary)
    assert "motions slowed to" not in summary_text(hasty.summary)


def test_the_number_of_frames_does_not_matter():
    """Beyond what half a per cent of the duration does: 5 % of the time, 1° of this coarse ply."""
    few, many = (coarse(frames=n, kinetic_limit=0.05).summary for n in (5, 60))
    assert few["simulated_s"] == pytest.approx(many["simulated_s"], rel=0.08)
    drawn = [s["plies"][0]["draw_in_m"]["warp"] for s in (few, many)]
    assert drawn[0] == pytest.approx(drawn[1], abs=2e-4)


def test_a_profile_and_threads_work_with_a_limit():
    scene = hemisphere.build(cells=8, duration=0.01, travel=0.01, kinetic_limit=0.02)
    one = scene.run(frames=3, profile=True)
    assert one.summary["phases_s"]["membrane"] > 0.0
    two, again = (scene.run(frames=3, threads=2) for _ in range(2))
    np.testing.assert_array_equal(two.plies[0].points, again.plies[0].points)
    assert two.summary["simulated_s"] == pytest.approx(one.summary["simulated_s"], rel=0.02)
    # Rounding grows where a thin sheet is thrown about.
    np.testing.assert_allclose(two.plies[0].points, one.plies[0].points, atol=1e-3)


def test_a_coupon_that_is_held_back_is_nearer_to_its_closed_form():
    """Its clamps pull on beyond the end: motions cut off there would spoil the last force."""
    scene = picture_frame.build(edge=0.05, shear_angle_deg=30.0, duration=0.01)
    hasty, held = (s.run(frames=10).summary for s in (scene, limited(scene, 0.05)))
    assert held["simulated_s"] > 1.2 * hasty["simulated_s"]
    errors = [abs(s["coupon"]["force_error"]) for s in (hasty, held)]
    assert errors[1] < 0.6 * errors[0] < 0.6 * 0.06
    assert held["coupon"]["shear_angle_deg"] == pytest.approx(30.0, rel=0.01)


def test_a_coupon_is_read_in_loading_time(tmp_path):
    scene = limited(biaxial_tension.build(edge=0.05, duration=5e-3), 5e-4)
    scene.run(tmp_path, frames=10)
    curve, summary = read(tmp_path)
    assert summary["simulated_s"] > 1.1 * scene.duration
    exact = curve["closed_form_warp_force_n"]
    np.testing.assert_allclose(curve["warp_force_n"], exact, atol=0.02 * exact.max())


def test_looks_see_the_energies_of_the_history(monkeypatch):
    seen = []

    class Watched(Loading):
        def adapt(self, kinetic, internal):
            seen.append((self.time, kinetic, internal))
            super().adapt(kinetic, internal)

    monkeypatch.setattr(simulation, "Loading", Watched)
    history = coarse(frames=3, travel=0.03, kinetic_limit=0.05).history
    at_frames = [look for look in seen if look[0] in history["loading_time_s"]]
    columns = (history[name][1:] for name in ("loading_time_s", "kinetic_j", "internal_j"))
    np.testing.assert_allclose(at_frames, np.column_stack(list(columns)), rtol=1e-12)
