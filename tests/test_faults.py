"""Disks that fail, folders that vanish or are damaged or hostile: a sentence, and nothing lost."""

import json
import os
import pickle
import random
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fault_checks import assert_whole_files
from resume_checks import assert_same_folder, cut_off, press
from run_damage import spoil

from warpdrape import cli
from warpdrape.errors import InputError, RunFailed
from warpdrape.results.run_folder import RunFolder
from warpdrape.results.usd_reader import read_scene
from warpdrape.simulation import Stepper

ROOT = Path(__file__).parents[1]
FULL, READ_ONLY, BROKEN = 28, 30, 5
"""ENOSPC, EROFS, EIO."""
COARSE = ["hemisphere", "--set=cells=4", "--set=duration=0.005", "--frames=2"]
QUICK = ["hemisphere", "--set=cells=4", "--set=duration=0.01", "--frames=3", "--quiet"]


def fail_at(server, whole, folder, number, kind):
    """Let the disk fail from one call on, and look at what is left; then go on."""
    shutil.rmtree(folder, ignore_errors=True)
    done = server.run(folder, at=number, kind=kind)
    lines = done["said"].strip().splitlines()
    assert done["status"] in (0, 1, 2) and lines == lines[-1:], done
    if done["status"]:
        assert done["said"].startswith("warpdrape: error: ") and "unexpected" not in done["said"]
    assert_whole_files(folder)
    assert server.resume(folder)["status"] == 0
    assert_same_folder(folder, whole)


@pytest.mark.parametrize(("kind", "share"), [(FULL, 0.95), (BROKEN, 0.6)])
def test_a_disk_that_fails(kind, share, server, whole, tmp_path):
    folder, done = whole
    fail_at(server, folder, tmp_path / "run", int(share * done["calls"]), kind)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [FULL, READ_ONLY, BROKEN])
def test_a_disk_that_fails_at_every_write(kind, server, whole, tmp_path):
    folder, done = whole
    for number in range(1, done["calls"] + 1):
        fail_at(server, folder, tmp_path / "run", number, kind)


def test_a_folder_that_vanishes(tmp_path, monkeypatch, capsys):
    block, out = Stepper.block, tmp_path / "run"

    def vanishing(self):
        block(self)
        if self.blocks > 10:
            shutil.rmtree(out, ignore_errors=True)

    monkeypatch.setattr(Stepper, "block", vanishing)
    assert cli.main(["run", *QUICK, "--out", str(out), "--checkpoint=1"]) == 1
    said = capsys.readouterr().err
    assert said.startswith("warpdrape: error: ") and len(said.splitlines()) == 1
    assert "unexpected" not in said and str(out) in said


def test_two_runs_into_one_folder(tmp_path, capsys):
    first = RunFolder(tmp_path / "run")
    first.take()
    for argv in (["run", *QUICK, "--out"], ["run", *QUICK, "--overwrite", "--out"]):
        assert cli.main([*argv, str(tmp_path / "run")]) == 2
        assert "is being written by another run: wait for its end" in capsys.readouterr().err
    assert [f.name for f in (tmp_path / "run").iterdir()] == [".lock"]
    first.write_json("run.json", {})
    assert cli.main(["resume", str(tmp_path / "run")]) == 2
    first.close()
    assert [f.name for f in (tmp_path / "run").iterdir()] == ["run.json"]
    with pytest.raises(InputError, match=r"holds run\.json of another run"):
        RunFolder(tmp_path / "run").take()


def test_a_folder_that_filled_between_look_and_run(tmp_path):
    late = RunFolder(tmp_path)
    RunFolder(tmp_path).write_json("run.json", {})
    with pytest.raises(InputError, match="of another run"):
        late.take()


@pytest.mark.slow
def test_no_home_folder(tmp_path):
    env = {k: v for k, v in os.environ.items() if k not in ("WARP_CACHE_PATH", "XDG_CACHE_HOME")}
    run = [sys.executable, "-m", "warpdrape", "info"]
    env |= {"HOME": "/dev/null", "TMPDIR": str(tmp_path)}
    done = subprocess.run(run, capture_output=True, text=True, env=env, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    assert "no place for the kernel cache" in done.stderr and len(done.stderr.splitlines()) == 1
    assert f"{tmp_path}/warpdrape-kernels-" in done.stdout
    assert list(tmp_path.iterdir()) == []  # it was for this process alone


@pytest.mark.slow
def test_a_damaged_kernel_cache(tmp_path):
    import warp as wp

    wp.init()
    shutil.copytree(wp.config.kernel_cache_dir, tmp_path / "cache" / wp.config.version)
    for file in (tmp_path / "cache").rglob("*.o"):
        os.truncate(file, 1000)
    run = [sys.executable, "-m", "warpdrape", "run", *QUICK, "--out", str(tmp_path / "run")]
    env = os.environ | {"WARP_CACHE_PATH": str(tmp_path / "cache")}
    done = subprocess.run(run, capture_output=True, text=True, env=env, cwd=ROOT)
    assert done.returncode == 1
    assert "is damaged (Failed to load CPU module" in done.stderr.splitlines()[-1]
    assert "remove that folder; kernels are compiled anew" in done.stderr


@pytest.fixture(scope="module")
def cut(tmp_path_factory):
    """A run folder as a kill leaves it, of a bundled scene, and its frames."""
    folder = tmp_path_factory.mktemp("cut") / "run"
    with pytest.MonkeyPatch.context() as patch:
        from warpdrape.commands.scene_library import find_script

        scene = find_script("hemisphere").make(["cells=4", "duration=0.005"])
        cut_off(scene, folder, 2, patch, frames=3)
    return folder


def damaged_copies(whole, folder, count, chance):
    """Copies of a run folder, one after the other, in each of which a file is damaged; its name."""
    files = sorted(f.name for f in whole.iterdir())
    for _ in range(count):
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(whole, folder)
        path = folder / chance.choice(files)
        content = bytearray(path.read_bytes())
        if chance.random() < 0.3:
            content = content[: chance.randrange(len(content))]
        else:
            for _ in range(chance.randrange(1, 20)):
                content[chance.randrange(len(content))] = chance.randrange(256)
        path.write_bytes(content)
        yield path


def read_damaged(cut, folder, count, capsys):
    """Damage one file of a run folder at a time, and feed it to what reads one."""
    ends = []
    for path in damaged_copies(cut, folder, count, random.Random(2)):
        try:
            read_scene(folder / ".scene.partial.usdc", None, -1)
        except InputError as error:
            ends.append(("picture", type(error)))
        status = cli.main(["resume", str(folder), "-q"])
        said = capsys.readouterr().err
        assert status in (0, 2) and "unexpected" not in said, (path.name, said)
        assert len(said.splitlines()) == (1 if status else 0), (path.name, said)
        ends.append(("resume", status))
    return ends


def test_damaged_run_folders(cut, tmp_path, capsys):
    ends = read_damaged(cut, tmp_path / "run", 5, capsys)
    assert {("resume", 2), ("resume", 0)} <= set(ends)


@pytest.mark.slow
def test_many_damaged_run_folders(cut, tmp_path, capsys):
    read_damaged(cut, tmp_path / "run", 1000, capsys)


READERS = [
    ["judge", "RUN"],
    ["judge", "RUN", "--out", "OUT/mark.png"],
    ["report", "RUN", "--frames", "2"],
    ["picture", "RUN", "--field", "wrinkle"],
    ["picture", "RUN", "--stack", "--tools", "--field", "tool-distance"],
    ["export", "RUN", "--to", "csv"],
    ["export", "RUN", "--to", "inp"],
    ["export", "RUN", "--to", "vtk"],
    ["export", "RUN", "--to", "svg"],
    ["export", "RUN", "--to", "svg", "--trim", "z<-1mm", "--out", "OUT/t.svg", "--overwrite"],
    ["export", "RUN", "--to", "permeability", "--set", "fibre_diameter=7um"],
    ["export", "RUN", "--to", "dyna"],
    ["export", "RUN", "--to", "nastran"],
    ["compare", *COARSE, "--approaches", "semi_discrete", "--out", "OUT"],
    ["resume", "RUN"],
]


def feed(run, what, readers, capsys):
    """Feed a damaged run to commands: each says one sentence at most, and loses nothing."""
    before, ends = {f.name: f.read_bytes() for f in run.iterdir() if f.is_file()}, []
    for reader in readers:
        argv = [word.replace("OUT", str(run.parent)).replace("RUN", str(run)) for word in reader]
        status = cli.main([*argv, "-q"])
        said = [line for line in capsys.readouterr().err.splitlines() if "warning: " not in line]
        assert status in (0, 1, 2, 3) and "unexpected" not in "".join(said), (what, reader, said)
        assert len(said) == (1 if status in (1, 2) else 0), (what, reader, said)
        if reader[0] != "resume":  # which mends what it can
            assert all((run / name).read_bytes() == was for name, was in before.items())
        ends.append((reader[0], status))
    return ends


def feed_readers(whole, folder, count, capsys, readers=READERS):
    """Damage the bytes of one file of a finished run at a time."""
    chance, run = random.Random(4), folder / "semi_discrete"
    copies = damaged_copies(whole, run, count, chance)
    return [end for path in copies for end in feed(run, path, readers, capsys)]


def feed_spoiled(whole, folder, count, capsys):
    """Give one value in a finished run's files another at a time; a few commands for each."""
    chance, run, ends = random.Random(7), folder / "semi_discrete", []
    for _ in range(count):
        shutil.rmtree(run, ignore_errors=True)
        shutil.copytree(whole, run)
        what = spoil(run, chance)
        ends += feed(run, what, chance.sample(READERS, 4), capsys)
    return ends


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A finished run of a bundled scene."""
    folder = tmp_path_factory.mktemp("finished") / "run"
    assert cli.main(["run", *COARSE, "--out", str(folder), "-q"]) == 0
    return folder


def test_damaged_runs_fed_to_every_command(finished, tmp_path, capsys):
    ends = feed_readers(finished, tmp_path, 1, capsys, READERS[::2])
    assert {status for _, status in ends} >= {0, 2}


@pytest.mark.slow
def test_many_damaged_runs_fed_to_every_command(finished, tmp_path, capsys):
    feed_readers(finished, tmp_path, 100, capsys)


@pytest.mark.parametrize(
    ("entry", "value", "named"),
    [
        ("wrinkles", 0.5, "wrinkles"),
        ("wrinkles", {}, "wrinkles.number, "),
        ("shear", ["x"], "shear"),
        ("yarns", {"warp": None, "weft": 1}, "yarns.warp, plies[0].defects.yarns.weft"),
        ("bridging", {"number": 2}, "bridging.max_gap_m, "),
        ("misalignment", [{"name": "rib"}], "misalignment[0].family, "),
    ],
)
def test_an_odd_value_is_told_by_its_name(entry, value, named, finished, tmp_path, capsys):
    run = shutil.copytree(finished, tmp_path / "run")
    summary = json.loads((run / "summary.json").read_text("utf-8"))
    summary["plies"][0]["defects"][entry] = value
    (run / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    assert feed(run, entry, [["judge", "RUN"]], capsys) == [("judge", 2)]
    assert cli.main(["judge", str(run), "-q"]) == 2
    said = capsys.readouterr().err
    assert f"has no usable plies[0].defects.{named}" in said and "run the scene again" in said


@pytest.mark.parametrize("error", [ZeroDivisionError("by zero"), KeyError("odd"), TypeError("x")])
def test_a_fault_of_ours_is_not_blamed_on_a_run(error, finished, monkeypatch, capsys, tmp_path):
    """It is told as one, with a file that says where, whatever kind of error it is."""

    def fail(*_):
        raise error

    monkeypatch.setattr("warpdrape.results.judgement.judge", fail)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert cli.main(["judge", str(finished)]) == 1
    said = capsys.readouterr().err
    assert f"unexpected {type(error).__name__} in test_faults.py, line" in said
    (kept,) = tmp_path.iterdir()
    assert said.strip().endswith(f"please report it as a fault of warpdrape, with the file {kept}")
    words = kept.read_text("utf-8")
    assert words.startswith(f"warpdrape judge {finished}\n") and "numpy " in words
    assert "Traceback (most recent call last)" in words and "in judged" in words
    kept.unlink()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "nowhere"))
    assert cli.main(["judge", str(finished)]) == 1
    assert capsys.readouterr().err.strip().endswith("please report it as a fault of warpdrape")


@pytest.mark.filterwarnings("ignore")
def test_odd_values_in_runs_fed_to_some_commands(finished, tmp_path, capsys):
    assert feed_spoiled(finished, tmp_path, 3, capsys)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_odd_values_in_many_runs(finished, tmp_path, capsys):
    feed_spoiled(finished, tmp_path, 500, capsys)


def test_nothing_is_executed_that_a_checkpoint_holds(tmp_path):
    """A pickled array, in which anything could run, is refused unread."""

    class Trap:
        def __reduce__(self):
            return (Path(tmp_path / "sprung").touch, ())

    run = tmp_path / "run"
    run.mkdir()
    trapped = np.array([Trap()], dtype=object)
    np.savez(run / "checkpoint.npz", trapped, allow_pickle=True)
    with zipfile.ZipFile(run / "checkpoint.npz", "a") as members:
        members.writestr("record.json", json.dumps({"form": 1}))
    with pytest.raises(InputError, match="is damaged"):
        press().run(resume=run)
    (run / "checkpoint.npz").write_bytes(pickle.dumps(Trap()))
    with pytest.raises(InputError, match="is damaged"):
        press().run(resume=run)
    assert not (tmp_path / "sprung").exists()


TRAP = "from pathlib import Path\nPath({!r}).touch()\n"


def test_a_name_runs_no_code_of_the_working_folder(tmp_path):
    trap = TRAP.format(str(tmp_path / "sprung"))
    for name in ("hemisphere", "numpy", "trimesh", "networkx", "scenes", "sitecustomize_x"):
        (tmp_path / f"{name}.py").write_text(trap)
    run = [sys.executable, "-m", "warpdrape", "scenes", "hemisphere"]
    env = os.environ | {
        "PYTHONPATH": os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    }
    env.pop("PYTHONSAFEPATH", None)
    done = subprocess.run(run, capture_output=True, text=True, cwd=tmp_path, env=env)
    assert done.returncode == 0 and "Parameters" in done.stdout, done.stderr
    assert not (tmp_path / "sprung").exists()


@pytest.mark.parametrize("name", ["../out.csv", "/tmp/out.csv", "a/b.csv", "..", "", "a\\b", "c:d"])
def test_names_do_not_lead_out_of_the_folder(name, tmp_path):
    folder = RunFolder(tmp_path / "run")
    for write in (folder.write_json, folder.write_table, folder.write_figure):
        with pytest.raises(InputError, match="must be a plain name"):
            write(name, {})
    assert not (tmp_path / "out.csv").exists()


def test_a_link_in_a_run_folder_is_not_followed(cut, tmp_path):
    shutil.copytree(cut, tmp_path / "run")
    precious = tmp_path / "precious"
    precious.write_text("precious")
    for name in ("checkpoint.npz", ".history.partial.csv", ".summary.partial.json"):
        shutil.rmtree(tmp_path / "run")
        shutil.copytree(cut, tmp_path / "run")
        (tmp_path / "run" / name).unlink(missing_ok=True)
        (tmp_path / "run" / name).symlink_to(precious)
        with pytest.raises(InputError, match="is a link"):
            press().run(resume=tmp_path / "run")
        RunFolder(tmp_path / "run", overwrite=True).begin()
        assert not (tmp_path / "run" / name).is_symlink()
    assert precious.read_text() == "precious"


SCRIPT = """
from pathlib import Path
from warpdrape.scenes import hemisphere
Path(__file__).with_name("ran").touch()
def build(*, cells: int = 4):
    \"\"\"A hemisphere.\"\"\"
    return hemisphere.build(cells=cells, duration=0.005)
"""


def test_scripts_go_on_unless_they_changed_or_came_with_the_folder(tmp_path, capsys, monkeypatch):
    script, out = tmp_path / "mine.py", tmp_path / "run"
    script.write_text(SCRIPT)
    monkeypatch.chdir(tmp_path)

    def stop(self):
        if self.blocks > 100:
            raise KeyboardInterrupt
        block(self)

    block = Stepper.block
    with monkeypatch.context() as patch:
        patch.setattr(Stepper, "block", stop)
        argv = ["run", "mine.py", "--out", "run", "--frames=3", "--quiet", "--checkpoint=1"]
        assert cli.main(argv) == 1
    (tmp_path / "ran").unlink()

    def refused(words):
        before = {f.name: f.read_bytes() for f in out.iterdir()}
        assert cli.main(["resume", str(out), "--quiet"]) == 2
        assert words in capsys.readouterr().err
        assert not (tmp_path / "ran").exists() and not (out / "ran").exists()
        assert {f.name: f.read_bytes() for f in out.iterdir()} == before

    capsys.readouterr()
    script.write_text(SCRIPT + "\n")
    refused("has changed since: look at it, and name it yourself")
    script.rename(out / "mine.py")
    refused("mine.py is not there: look at it")
    shutil.move(out / "mine.py", script)
    script.write_text(SCRIPT)
    folder = tmp_path / "all"
    folder.mkdir()
    monkeypatch.chdir("/")
    assert cli.main(["resume", str(out), "--quiet"]) == 0
    assert (tmp_path / "ran").exists()
    assert json.loads((out / "summary.json").read_text())["status"] == "completed"


def test_a_run_from_python_says_how_it_goes_on(tmp_path, capsys, monkeypatch):
    cut_off(press(), tmp_path / "run", 2, monkeypatch, frames=4)
    assert cli.main(["resume", str(tmp_path / "run")]) == 2
    assert "is of a scene from Python: go on there, with scene.run(resume=" in (
        capsys.readouterr().err
    )


def test_a_checkpoint_that_cannot_be_written_ends_the_run_in_order(tmp_path, monkeypatch):
    from warpdrape.results import checkpoint_file

    write = checkpoint_file.write_whole

    def refuse(final, _):
        if (tmp_path / "run" / "checkpoint.npz").exists():
            raise RunFailed(f"{final} could not be written (No space left on device)")
        write(final, _)

    monkeypatch.setattr(checkpoint_file, "write_whole", refuse)
    result = press().run(tmp_path / "run", frames=4, checkpoint=1)
    assert (
        not result.completed and "checkpoint.npz could not be written" in result.summary["message"]
    )
    monkeypatch.undo()
    press().run(tmp_path / "whole", frames=4)
    press().run(resume=tmp_path / "run")
    assert_same_folder(tmp_path / "run", tmp_path / "whole")
