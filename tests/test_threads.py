"""Parts on threads: the same to the bit as alone, rounding from one thread, and what may fail."""

import threading

import numpy as np
import pytest
import warp as wp
from test_engine import small_press

from warpdrape import Pressure, Spring
from warpdrape.blanks.ply import Ply
from warpdrape.cli import main
from warpdrape.dynamics import crew, stepping
from warpdrape.dynamics.crew import Crew, choose_threads
from warpdrape.dynamics.model import build_model, initial_state
from warpdrape.dynamics.partition import LARGEST, MOST_RUNS, split
from warpdrape.errors import InputError
from warpdrape.kernels.contact.ply_contact import add_ply_forces
from warpdrape.numerics import Numerics
from warpdrape.scene import Scene
from warpdrape.state import Across, all_arrays, with_own


class Always:
    """A pace that does not look at the clock."""

    def __init__(self, together):
        self.together = together

    def took(self, seconds):
        pass


def state_after(threads, together, scene=None, blocks=150):
    """Arrays after some blocks, and the number of steps."""
    model = build_model(scene or small_press(), "cpu", frames=1)
    assert model.timing.steps_per_frame >= blocks * model.timing.search_every
    state = initial_state(model)
    stepper = stepping.Stepper(model, state, threads)
    stepper._pace = Always(together)
    stepper.begin_frame(1)
    for _ in range(blocks):
        stepper.block()
    stepper.close()
    steps = blocks * model.timing.search_every
    assert int(state.step.numpy()[0]) == steps
    return {name: array.numpy() for name, array, _ in all_arrays(state)}, steps


def assert_same_bits(one, other):
    for name, values in one.items():
        np.testing.assert_array_equal(values, other[name], err_msg=name)


@pytest.mark.parametrize("threads", [2, 3])
@pytest.mark.parametrize("averaging", ["pairs", "plain"])
def test_threads_compute_what_one_part_after_another_does(threads, averaging):
    scene = small_press(numerics=Numerics(averaging=averaging))
    together, _ = state_after(threads, True, scene)
    alone, _ = state_after(threads, False, scene)
    assert_same_bits(together, alone)
    assert_same_bits(together, state_after(threads, True, scene)[0])


def test_loads_that_change_with_time_are_the_same_on_threads():
    """A pressure that rises, springs that slip: read once part 0 has counted a step."""
    scene = small_press(
        pressures=[Pressure(name="air", ply="high", pressure=[(0.0, 0.0), (1.0, 1e5)])],
        springs=[
            Spring(
                name="grip",
                ply="low",
                where=lambda p: p[:, 0] < 0.0,
                to=(0.0, 0.0, 0.1),
                stiffness=1e4,
                slip_force=1e-3,
            )
        ],
    )
    together, _ = state_after(2, True, scene)
    alone, _ = state_after(2, False, scene)
    assert_same_bits(together, alone)
    done = [v for name, v in together.items() if name.startswith("memory") and "work" in name]
    assert len(done) == 2 and all(work.any() for work in done)


def test_waiting_without_spinning_gives_the_same(monkeypatch):
    spun, _ = state_after(2, True)
    monkeypatch.setattr(crew, "SPINS", 0)
    assert_same_bits(spun, state_after(2, True)[0])
    monkeypatch.setattr(crew, "_address_of_yield", lambda: 0)
    assert_same_bits(spun, state_after(2, True)[0])


@pytest.mark.parametrize("threads", [1, 2])
def test_eager_parts_are_captured_parts(threads):
    slide = (
        2.85e-4  # 19 steps to a search: two times a graph of nine, and one of the step left over
    )
    eager, captured = (
        small_press(numerics=Numerics(graph=graph, search_slide=slide)) for graph in (False, True)
    )
    every = build_model(eager, "cpu", frames=1).timing.search_every
    few = stepping.steps_per_graph(every)
    assert every >= 2 * few and every % few > 0
    one, other = (state_after(threads, True, scene, 12)[0] for scene in (eager, captured))
    assert np.abs(one["memory.2.stored"]).max() > 0.0
    assert_same_bits(one, other)


def test_a_graph_holds_few_steps():
    for steps in range(1, 257):
        few = stepping.steps_per_graph(steps)
        assert few == steps if steps <= 12 else 6 <= few <= 12


@pytest.mark.parametrize("threads", [2, 3, 5])
def test_parts_add_up_to_the_whole_within_rounding(threads):
    one, steps = state_after(1, False)
    several, _ = state_after(threads, True)
    assert steps >= 200
    x, stored = one["plies.x"], one["memory.2.stored"]
    assert np.abs(x - x.mean(axis=0)).max() > 0.02
    assert np.abs(stored).max() > 0.0 and np.abs(one["tools.impulse"]).max() > 0.0
    # Rounding grows through contacts that stick or slip; measured: 1e-15 m, 2e-11 of the speed.
    np.testing.assert_allclose(several["plies.x"], x, atol=1e-12)
    sums = ("plies.v", "plies.lost", "tools.impulse", "clamps.force", "tools.work", "tools.shift")
    for name in sums:
        scale = np.abs(one[name]).max()
        assert scale > 0.0, name
        np.testing.assert_allclose(several[name], one[name], atol=1e-8 * scale, err_msg=name)
    for name in ("memory.3.deepest", "memory.2.deepest", "memory.2.jump", "plies.runaway"):
        np.testing.assert_allclose(several[name], one[name], atol=1e-12, err_msg=name)


def test_a_runaway_vertex_of_any_part_is_seen():
    model = build_model(small_press(), "cpu", frames=1)
    last = model.mass.shape[0] - 1
    for together in (False, True):
        state = initial_state(model)
        v = np.zeros((last + 1, 3))
        v[last] = 1e6
        state.plies.v.assign(v)
        stepper = stepping.Stepper(model, state, 2)
        stepper._pace = Always(together)
        stepper.begin_frame(1)
        stepper.block()
        stepper.close()
        assert state.plies.runaway.numpy()[0] >= 0


def test_a_run_on_two_threads_repeats_itself(tmp_path):
    one, two = (small_press().run(tmp_path / str(k), frames=2, threads=2) for k in range(2))
    for first, second in zip(one.plies, two.plies, strict=True):
        np.testing.assert_array_equal(first.points, second.points)
        np.testing.assert_array_equal(first.strain, second.strain)
    for name, column in one.history.items():
        np.testing.assert_array_equal(column, two.history[name], err_msg=name)
    assert '"threads": 2' in (tmp_path / "0" / "run.json").read_text(encoding="utf-8")


@pytest.mark.parametrize("count", [1, 2, 3, 7])
@pytest.mark.parametrize("mesh", ["grid", "random"])
def test_parts_cover_everything_once(count, mesh):
    plies = [
        Ply.rectangle(name, "carbon_interlock", 0.1, cells=9, mesh=mesh, z=z)
        for name, z in (("low", 0.0), ("high", 0.01))
    ]
    model = build_model(Scene(name="two", plies=plies, duration=1e-3), "cpu", frames=1)
    parts = split(model, initial_state(model), count)

    def counted(runs, size):
        times = np.zeros(size, int)
        for first, n in runs:
            times[first : first + n] += 1
        return times

    vertices = model.mass.shape[0]
    assert (counted([r for p in parts for r in p.vertices], vertices) == 1).all()
    launched = [launch for part in parts for launch in part.launches.scatter]
    looked = [tuple(of.run) for of in launched if of.kernel is add_ply_forces]
    assert (counted(looked, vertices) == 1).all()
    loads = [load[:3] for m in model.forces[0].plies for load in m.loads]
    for kernel, total, inputs in loads:
        of_it = [
            (of.inputs[0], of.count)
            for of in launched
            if of.kernel is kernel and of.inputs[1] is inputs[1]
        ]
        assert (counted([(first - inputs[0], n) for first, n in of_it], total) == 1).all()
    surfaces = model.contacts[0]
    refitted = [mesh for part in parts for mesh in part.launches.refit]
    assert sorted(map(id, refitted)) == sorted(map(id, surfaces.meshes))
    for part in parts:
        assert len(part.vertices) <= 2 * MOST_RUNS * count
        share = sum(n for _, n in part.vertices) * count / vertices
        assert 0.7 < share < LARGEST + 0.01


def test_parts_have_apart_what_several_of_them_write():
    state = initial_state(build_model(small_press(), "cpu", frames=1))
    held = {name: across for name, _, across in all_arrays(state) if across is not Across.SHARED}
    assert held == {
        "plies.f": Across.SCATTERED,
        "plies.runaway": Across.FIRST,
        "tools.reaction": Across.SUMMED,
        "tools.moment": Across.SUMMED,
        "clamps.force": Across.SUMMED,
        "memory.2.deepest": Across.LARGEST,
        "memory.2.jump": Across.LARGEST,
        "memory.3.deepest": Across.LARGEST,
        "memory.3.jump": Across.LARGEST,
        "memory.4.deepest": Across.LARGEST,
        "memory.4.fastest": Across.LARGEST,
    }
    theirs = {name: array for name, array, _ in all_arrays(with_own(state))}
    for name, array, across in all_arrays(state):
        assert (theirs[name] is array) == (across is Across.SHARED), name


def test_vertices_of_a_part_lie_beside_its_elements():
    ply = Ply.rectangle("sheet", "carbon_interlock", 0.1, cells=20)
    model = build_model(Scene(name="one", plies=[ply], duration=1e-3), "cpu", frames=1)
    low, high = split(model, initial_state(model), 2)
    x = model.rest.numpy()
    heights = [np.concatenate([x[a : a + n, 1] for a, n in p.vertices]) for p in (low, high)]
    assert heights[0].max() < heights[1].min() + 1.01 * 0.1 / 20


def test_a_job_that_fails_frees_the_others_and_is_reported():
    free, done = threading.Event(), []

    def wait():
        assert free.wait(20.0)
        done.append(True)

    def fail():
        raise RuntimeError("no graph")

    crew = Crew([wait, fail], free.set)
    with pytest.raises(RuntimeError, match="no graph"):
        crew.run()
    assert done
    crew.close()
    assert not any(thread.is_alive() for thread in crew._threads)


def test_an_interrupt_frees_the_parts_that_wait():
    model = build_model(small_press(), "cpu", frames=1)
    stepper = stepping.Stepper(model, initial_state(model), 3)
    stepper._pace = Always(True)
    stepper.begin_frame(1)
    stepper.block()
    jobs, threads = stepper._crew._jobs, stepper._crew._threads

    def interrupt():
        raise KeyboardInterrupt

    stepper._crew._jobs = [interrupt, *jobs[1:]]
    with pytest.raises(KeyboardInterrupt):
        stepper.block()
    stepper.close()
    assert not any(thread.is_alive() for thread in threads)


def test_threads_by_default_are_for_large_models(monkeypatch):
    monkeypatch.setattr(crew, "physical_cores", lambda: 4)
    least = crew.LEAST_TRIANGLES
    assert choose_threads(None, "cpu", 1600) == 1
    assert choose_threads(None, "cpu", 2 * least) == 2
    assert choose_threads(None, "cpu", 100 * least) == 4
    assert choose_threads(None, "cuda:0", 100 * least) == 1
    assert choose_threads(3, "cpu", 100) == 3


@pytest.mark.parametrize("threads", [0, -2, 1.5, True, "two", 1000])
def test_bad_threads_are_refused(threads):
    with pytest.raises(InputError, match=r"threads = .*"):
        small_press().run(threads=threads)


def test_threads_on_a_graphics_card_are_refused():
    with pytest.raises(InputError, match="threads = 2 are for device 'cpu'"):
        choose_threads(2, "cuda:0", 100)


@pytest.mark.parametrize("text", ["0", "two", "1.5", "1000"])
def test_bad_threads_on_the_command_line_are_refused(text, capsys, tmp_path):
    out = tmp_path / "run"
    assert main(["run", "hemisphere", "--threads", text, "--out", str(out), "--quiet"]) == 2
    assert "threads" in capsys.readouterr().err
    assert not (out / "summary.json").exists()


def test_barrier_counters_lie_a_cache_line_apart():
    barrier = crew.Barrier(3)
    barrier.release()
    for part in range(3):
        barrier.launch(part)
    counters = barrier._arrived.numpy()
    assert counters[:: crew.LINE].tolist() == [1, 1, 1, 1] and crew.LINE * 4 >= 64
    assert barrier._arrived.dtype == wp.int32
