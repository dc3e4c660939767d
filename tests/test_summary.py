"""The summary of runs made up by hand: verdicts, warnings, numbers per ply and interface."""

from dataclasses import replace

import numpy as np
import pytest
from interaction_checks import of_kind

from warpdrape.blanks.flat_mesh import FlatMesh
from warpdrape.blanks.ply import Ply, lay_up
from warpdrape.blanks.triangles import area_percentile
from warpdrape.contact.ply_contact import PlyContact
from warpdrape.dynamics.energy import measure
from warpdrape.dynamics.loading import Loading
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.interaction import Measured, bodies_of
from warpdrape.materials.fabric_library import with_bending
from warpdrape.results.complaints import of_loads
from warpdrape.results.quasi_static import mean_while_loaded, quasi_static
from warpdrape.results.result import FormedPly
from warpdrape.results.soundness import energy_error, soundness_of
from warpdrape.results.summary import _ply_entry, summarise
from warpdrape.scene import Scene

THICKNESS = 6e-4  # of carbon_interlock
ENERGIES = ("kinetic", "internal", "friction", "damping", "external_work", "unbalanced")


def history(**columns):
    """A history of four frames; what is not given is zero, but for the internal energy."""
    rows = {f"{name}_j": np.zeros(4) for name in ENERGIES}
    rows |= {"internal_j": np.array([0.0, 0.5, 1.0, 2.0]), "time_s": np.linspace(0.0, 0.03, 4)}
    rows |= {"yarn_j": np.zeros(4), "added_mass_kinetic_j": np.zeros(4)}
    return rows | {f"{name}_j": np.array(values) for name, values in columns.items()}


@pytest.fixture(scope="module")
def stack():
    """Two plies, the upper one with fewer vertices."""
    cloth = with_bending("carbon_interlock", "none")
    lower = Ply.rectangle("lower", cloth, 0.1, cells=2, mesh="grid")
    upper = Ply.rectangle("upper", cloth, 0.1, cells=1, mesh="grid")
    return build_model(Scene(name="s", plies=lay_up([lower, upper]), duration=0.03), "cpu", 3)


def formed(ply, shear_deg=None, strain=None):
    m = len(ply.mesh.triangles)
    directions = np.broadcast_to((1.0, 0.0, 0.0), (m, 3))
    return FormedPly(
        name=ply.name,
        rest_points=ply.rest_points,
        points=ply.rest_points,
        triangles=np.asarray(ply.mesh.triangles),
        warp=directions,
        weft=directions,
        shear_angle=np.radians(np.zeros(m) if shear_deg is None else shear_deg),
        strain=np.zeros((m, 2)) if strain is None else strain,
        line_tension=np.zeros((m, 2)),
    )


def shown(*plies):
    """What the membrane shows of formed plies."""
    return Measured(
        fields=tuple({"strain": p.strain, "line_tension": p.line_tension} for p in plies)
    )


def summary_of(model, contacts=None, plies=None, **columns):
    plies = plies or [formed(ply) for ply in model.scene.plies]
    return summarise(
        model,
        [shown(*plies), *(contacts or [measure(model, initial_state(model))[1]])],
        history(**columns),
        plies,
        Loading(model.scene, model.timing),
        failure="",
        steps=100,
        wall=2.0,
    )


def test_energy_error_is_the_largest_of_the_run_over_the_largest_energy():
    columns = history(unbalanced=[0.0, -0.3, 0.1, 0.02], external_work=[0.0, 1.0, 2.0, 3.0])
    assert energy_error(columns) == pytest.approx(0.1)


def test_what_loaded_nothing_says_so_but_where_a_ply_lay_free(stack):
    columns = history(internal=[0.0] * 4, contact=[0.0] * 4)
    sound = soundness_of(stack, columns, "", 0.0)
    (said,) = of_loads(sound, columns, [])
    assert said.startswith("nothing was loaded")
    assert of_loads(sound, columns, ["lower"]) == []  # of which another warning tells


@pytest.mark.parametrize(("grown", "share"), [(0.0, 0.05), (0.3, 0.3), (np.inf, 0.05)])
def test_what_came_from_nowhere_after_the_last_frame_counts_where_it_is_a_number(
    stack, grown, share
):
    sound = soundness_of(stack, history(unbalanced=[0.0, 0.0, 0.0, 0.1]), "", grown)
    assert sound.energy_error == pytest.approx(share)
    assert ("30.0 % of the energy is unbalanced" in sound.failure) == (share > 0.1)


@pytest.mark.parametrize(
    ("kinetic", "end", "mean", "calm"),
    [
        ([0.0, 0.01, 0.02, 0.04], 0.02, 0.07 / 3.5, True),
        ([0.0, 0.01, 0.02, 0.2], 0.1, 0.23 / 3.5, False),  # still moving at the end
        ([0.0, 0.5, 0.5, 0.04], 0.02, 1.04 / 3.5, False),  # hurried on the way
        ([9.0, 0.01, 0.02, 0.04], 0.02, 0.07 / 3.5, True),  # not loaded yet when it was fast
    ],
)
def test_quasi_static_asks_for_the_end_and_for_the_way(kinetic, end, mean, calm):
    found = quasi_static(history(kinetic=kinetic))
    assert found == (pytest.approx(end), pytest.approx(mean), calm)


def test_a_ply_that_never_stored_anything_is_not_quasi_static():
    assert quasi_static(history(internal=[0.0] * 4))[2] is False
    assert mean_while_loaded(history(internal=[0.0] * 4), "kinetic_j") == 0.0


@pytest.mark.parametrize(
    ("unbalanced", "status", "words"),
    [
        (0.03, "completed", []),
        (0.1, "completed", ["5.0 % of the energy is unbalanced"]),
        (0.3, "failed", []),
    ],
)
def test_unbalanced_energy_warns_and_then_fails(stack, unbalanced, status, words):
    summary = summary_of(stack, unbalanced=[0.0, 0.0, unbalanced, 0.0])
    assert summary["status"] == status
    assert [w[: len(t)] for w, t in zip(summary["warnings"], words, strict=True)] == words
    assert ("15.0 % of the energy" in summary["message"]) == (status == "failed")


def test_deep_penetration_warns_wherever_it_is(stack):
    assert summary_of(stack)["warnings"] == []
    shallow, deep = (
        {"max_penetration_m": d * THICKNESS, "ply": "upper", "vertices_of": "upper", "on": "lower"}
        for d in (0.4, 0.6)
    )
    for contacts in (
        {"interfaces": [shallow, deep]},
        {"self_contact": [shallow], "interfaces": [deep]},
        {"self_contact": [deep]},
        {"edge_contact": [deep | {"edges_of": "upper"}]},
    ):
        summary = summary_of(stack, [Measured(entries=contacts)])
        assert summary["max_penetration_m"] == pytest.approx(0.6 * THICKNESS)
        assert ["lay 0.36 mm in each other" in w for w in summary["warnings"]] == [True]


def test_a_hurried_run_says_so(stack):
    summary = summary_of(stack, kinetic=[0.0, 0.0, 0.0, 1.0])
    assert summary["quasi_static"] is False and "not quasi-static" in summary["message"]


def test_numbers_of_a_ply(stack):
    lower, upper = stack.scene.plies
    shear = np.linspace(-10.0, 5.0, len(lower.mesh.triangles))
    strain = np.column_stack([np.linspace(-1e-3, 2e-3, len(shear)), np.full(len(shear), 5e-4)])
    summary = summary_of(stack, plies=[formed(lower, shear, strain), formed(upper)])
    entry = summary["plies"][0]
    assert entry["max_shear_deg"] == pytest.approx(10.0)
    assert entry["mean_abs_shear_deg"] == pytest.approx(np.abs(shear).mean())
    size = np.sort(np.abs(shear))
    place = 0.95 * len(size) - 0.5  # 14.7 of 16, all of one area
    below, above = size[int(place)], size[int(place) + 1]
    assert entry["p95_shear_deg"] == pytest.approx(below + (place % 1.0) * (above - below))
    assert entry["max_strain_warp"] == pytest.approx(2e-3)
    assert entry["max_strain_weft"] == pytest.approx(5e-4)


def test_large_triangles_count_for_more():
    corners = [(0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1), (0.09, 0.05)]
    triangles = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    share = np.array([0.25, 0.05, 0.25, 0.45])  # of the area, each
    shear = np.array([10.0, 38.0, 20.0, 12.0])
    mesh = FlatMesh(np.array(corners), np.array(triangles))
    cloth = with_bending("carbon_interlock", "none")
    ply = replace(Ply.rectangle("ply", cloth, 0.1, cells=2), mesh=mesh)
    model = build_model(Scene(name="one", plies=[ply], duration=0.03), "cpu", 3)
    entry = _ply_entry(model, 0, [shown(formed(ply, shear))], formed(ply, shear), [])
    assert entry["mean_abs_shear_deg"] == pytest.approx((share * shear).sum())
    assert entry["p95_shear_deg"] == pytest.approx(area_percentile(shear, share, 0.95))
    assert entry["p95_shear_deg"] < area_percentile(shear, np.ones(4), 0.95) - 1.0


def test_a_percentile_is_of_the_area_and_not_of_the_count():
    # Splitting a triangle into equal ones of the same value changes nothing to speak of.
    rng = np.random.default_rng(3)
    values, areas = rng.uniform(0.0, 40.0, 4000), rng.uniform(0.5, 1.5, 4000)
    whole = area_percentile(values, areas, 0.95)
    parts = rng.integers(1, 30, 4000)
    split = area_percentile(np.repeat(values, parts), np.repeat(areas / parts, parts), 0.95)
    assert split == pytest.approx(whole, abs=0.02)
    counted = np.percentile(np.repeat(values, np.where(values > 30.0, 30, 1)), 95)
    assert abs(counted - whole) > 0.5


def test_interfaces_name_whose_vertices_slip_on_what(stack):
    counts = [len(ply.mesh.vertices) for ply in stack.scene.plies]
    slip = np.repeat([1e-3, 2e-3], counts)  # those of the lower ply's vertices come first
    slip[0] = 5e-3
    deepest = np.array([0.0, 1e-5, 2e-5, 0.0])  # of the lower into the upper, and back
    state = initial_state(stack)
    contact, memory = of_kind(stack, state, PlyContact)
    for array, values in zip(
        (memory.slip, memory.deepest, memory.jump), (slip, deepest, 2.0 * deepest), strict=True
    ):
        array.assign(values)
    seen = memory.seen.numpy()
    seen["ply"] = np.repeat([2, 1], counts)  # counted from one
    memory.seen.assign(seen)
    measured = contact.measure(bodies_of(state), memory)
    first, second = summary_of(stack, [measured])["interfaces"]
    assert (first["vertices_of"], first["on"]) == ("lower", "upper")
    assert (second["vertices_of"], second["on"]) == ("upper", "lower")
    assert first["max_slip_m"] == 5e-3
    assert first["mean_slip_m"] == pytest.approx(1e-3 + 4e-3 / counts[0])
    assert second["max_slip_m"] == pytest.approx(2e-3)
    assert second["max_penetration_m"] == 2e-5 and second["max_gap_jump_m"] == 4e-5


def test_steps_and_speed(stack):
    summary = summary_of(stack)
    triangles = sum(len(ply.mesh.triangles) for ply in stack.scene.plies)
    assert summary["triangle_steps_per_s"] == triangles * 100 / 2.0
    assert summary["simulated_s"] == pytest.approx(0.03)


def test_what_lay_too_deep_in_each_other_is_named(stack):
    def met(name, **entry):
        return Measured(entries={name: [{"max_penetration_m": 0.7 * THICKNESS, **entry}]})

    for contacts, words in (
        (
            met("interfaces", vertices_of="upper", on="lower"),
            "plies 'upper' and 'lower' lay 0.42 mm",
        ),
        (met("self_contact", ply="lower"), "folds of ply 'lower' lay 0.42 mm in each other"),
        (met("edge_contact", edges_of="lower", on="lower"), "edges of folds of ply 'lower' lay"),
        (met("edge_contact", edges_of="lower", on="upper"), "edges of plies 'lower' and 'upper'"),
    ):
        (said,) = [w for w in summary_of(stack, [contacts])["warnings"] if "passed" in w]
        assert said.startswith(words)
    shallow = Measured(
        entries={"self_contact": [{"max_penetration_m": 0.4 * THICKNESS, "ply": "lower"}]}
    )
    assert not any("passed" in words for words in summary_of(stack, [shallow])["warnings"])
