"""Sweeps: the same numbers on any executor, files that survive a kill, failures as rows."""

from __future__ import annotations

import importlib.util
import os
import pickle
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import physcore as pc
import swept
from physcore.film.labels.parameters import scale_of
from physcore.studies.sweep import workers
from swept import GRID, rope, sag

sweep = partial(pc.sweep, progress=False)
TESTS = Path(swept.__file__).parent


def rows(table: pc.Sweep) -> list[tuple[object, ...]]:
    """Parameters, values and messages of a table."""
    return [(row.parameters, row.value, str(row.error)) for row in table]


@pytest.fixture(scope="module")
def table() -> pc.Sweep:
    return sweep(rope, GRID, 0.1, measure=sag)


def test_rows_are_those_of_single_runs_in_the_order_of_the_grid(table):
    points = [(stiffness, dt) for stiffness in GRID["stiffness"] for dt in GRID["dt"]]
    assert [tuple(row.parameters.values()) for row in table] == points
    for row, (stiffness, dt) in zip(table, points, strict=True):
        if stiffness > 0.0:
            assert row.value == sag(pc.simulate(rope(stiffness), 0.1, dt=dt))
            assert row.error is None
            assert row.seconds > 0.0
        else:
            assert row.value is None
            assert isinstance(row.error, pc.SceneError)
            assert "stiffness" in str(row.error)
    assert len(table) == 6
    assert table.failed == tuple(table)[4:]


def test_the_best_is_the_least_or_the_largest_number(table):
    values = [row.value for row in table if row.error is None]
    assert table.best().value == min(values)
    assert table.best(maximize=True).value == max(values)
    assert table.best(maximize=True).parameters["stiffness"] == 50.0
    with pytest.warns(pc.SceneWarning, match=r"every point failed.*stiffness"):
        failed = sweep(rope, {"stiffness": [-1.0, -2.0]}, 0.1, measure=sag)
    with pytest.raises(pc.PhyscoreError, match=r"best: no point has a value: stiffness = -1: SceneError"):
        failed.best()
    words = sweep(rope, {"stiffness": [1.0]}, 0.1, measure=lambda recording: "long")
    with pytest.raises(pc.SceneError, match="measure: must give one number"):
        words.best()


def test_tables_show_parameters_values_and_errors(table):
    text = str(table)
    assert text.splitlines()[0] == "Sweep: 6 points of a duration of 0.1, 2 failed"
    assert text.splitlines()[1].split() == ["stiffness", "dt", "value", "seconds", "error"]
    assert len(text.splitlines()) == 8
    assert text.count("SceneError") == 2
    assert "<td" in table._repr_html_()
    many = sweep(rope, {"stiffness": np.linspace(10.0, 20.0, 8)}, 0.01, measure=sag)
    assert repr(many).splitlines()[-1] == "6 of 8 rows; print shows all"
    frame = table.to_dataframe()
    assert list(frame.columns) == ["stiffness", "dt", "value", "seconds", "error"]
    assert frame.value.notna().sum() == 4
    assert rows(pickle.loads(pickle.dumps(table))) == rows(table)


def test_values_are_numbers_arrays_texts_lists_and_mappings(tmp_path):
    for folder in (None, tmp_path, tmp_path):
        (row,) = sweep(rope, {"stiffness": [50.0]}, 0.1, measure=swept.several, folder=folder)
        assert row.value["sag"] == float(np.float32(sag(pc.simulate(rope(50.0), 0.1))))
        np.testing.assert_array_equal(row.value["times"], [0.0, 1 / 30, 2 / 30])
        assert row.value["name"] == ["rope", True, None]
    with pytest.warns(pc.SceneWarning):
        (row,) = sweep(rope, {"stiffness": [50.0]}, 0.1, measure=lambda recording: recording)
    assert "measure: must return numbers" in str(row.error)


def test_lambdas_and_closures_need_no_names():
    pulls = [1.0, 2.0]
    table = sweep(lambda pull: pc.Scene(pc.Particles([[0.0, 0.0]]), pc.Gravity((0.0, -pull))), {"pull": pulls}, 0.5,
                  measure=lambda recording: recording.velocities[-1, 0, 1])  # fmt: skip
    assert [row.value for row in table] == pytest.approx([-0.5, -1.0], rel=1e-12)


def test_numerics_are_axes_and_may_be_objects():
    integrators = ["VelocityVerlet", pc.PEFRL()]
    table = sweep(rope, {"integrator": integrators}, 0.1, measure=sag, dt=1e-3, fps=60.0)
    expected = [sag(pc.simulate(rope(), 0.1, fps=60.0, integrator=each, dt=1e-3)) for each in integrators]
    assert [row.value for row in table] == expected
    assert expected[0] != expected[1]


# Executors.


def dask_pool():
    distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed")
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    client = distributed.Client(cluster)
    return client.get_executor(), lambda: (client.close(), cluster.close())


def loky_pool():
    loky = pytest.importorskip("loky", reason="loky is not installed")
    pool = loky.ProcessPoolExecutor(2)
    return pool, lambda: pool.shutdown(kill_workers=True)


def plain_pool(kind):
    pool = kind(2)
    return pool, pool.shutdown


POOLS = {
    "processes": partial(plain_pool, ProcessPoolExecutor),
    "threads": partial(plain_pool, ThreadPoolExecutor),
    "loky": loky_pool,
    "dask": dask_pool,
}


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning", "ignore::UserWarning")
@pytest.mark.parametrize("name", POOLS)
def test_the_numbers_are_the_same_on_any_executor(name, table, tmp_path):
    pool, end = POOLS[name]()
    try:
        found = sweep(rope, GRID, 0.1, measure=sag, executor=pool)
        kept = sweep(rope, GRID, 0.1, measure=sag, executor=pool, folder=tmp_path, keep=True)
    finally:
        end()
    assert rows(found) == rows(table) == rows(kept)
    assert kept[0].recording.scene.hash() == rope(50.0).hash()


MPI = """
from mpi4py.futures import MPIPoolExecutor
import physcore as pc
from swept import GRID, rope, sag

if __name__ == "__main__":
    with MPIPoolExecutor(2) as executor:
        for row in pc.sweep(rope, GRID, 0.1, measure=sag, executor=executor, progress=False):
            print(row.value)
"""


def test_the_numbers_are_the_same_over_mpi(table, tmp_path):
    """The script runs as users run it: under mpiexec, whose first process is the caller and whose others work."""
    if importlib.util.find_spec("mpi4py") is None:
        pytest.skip("mpi4py is not installed")
    beside = Path(sys.executable).parent / "mpiexec"
    launcher = str(beside) if beside.exists() else shutil.which("mpiexec")
    if launcher is None:
        pytest.skip("there is no mpiexec")
    (tmp_path / "script.py").write_text(MPI, encoding="utf-8")
    command = [launcher, "-n", "3", sys.executable, "-m", "mpi4py.futures", tmp_path / "script.py"]
    done = subprocess.run(command, env=environment(), capture_output=True, text=True, timeout=600, check=False)
    if "libmpi" in done.stderr:
        pytest.skip("there is no MPI library")
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [str(row.value) for row in table]


def environment() -> dict[str, str]:
    """The environment of a script that imports this package and the module with the scenes."""
    package = Path(pc.__file__).parents[1]
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(package), str(TESTS)]), "PYTHONWARNINGS": "ignore"}


def test_processes_that_are_spawned_give_the_same_numbers(table, monkeypatch):
    """As on macOS and Windows."""
    for module in ("workers", "team"):
        monkeypatch.setattr(f"physcore.studies.sweep.{module}.forks", lambda: False)
    assert rows(sweep(rope, GRID, 0.1, measure=sag)) == rows(table)
    with pytest.raises(pc.WorkerError, match=r"^executor: .*pickle.*define them with def at the top level"):
        sweep(lambda stiffness: rope(stiffness), {"stiffness": [1.0]}, 0.1, measure=sag)


def test_a_function_that_cannot_be_sent_is_named():
    with ProcessPoolExecutor(1) as pool, pytest.raises(pc.WorkerError, match="define them with def at the top level"):
        sweep(lambda stiffness: rope(stiffness), {"stiffness": [1.0]}, 0.1, measure=sag, executor=pool)


# Folders.


def test_a_second_call_computes_nothing(table, tmp_path):
    for _ in range(2):
        assert rows(sweep(rope, GRID, 0.1, measure=sag, folder=tmp_path / "new" / "folder")) == rows(table)
        files = sorted((tmp_path / "new" / "folder").iterdir())
        assert len(files) == 7
        times = [file.stat().st_mtime_ns for file in files]
    assert rows(sweep(rope, GRID, 0.1, measure=sag, folder=tmp_path / "new" / "folder")) == rows(table)
    assert times == [file.stat().st_mtime_ns for file in files]


@pytest.mark.parametrize(
    ("change", "difference"),
    [
        ({"duration": 0.2}, "duration is 0.1, and here it is 0.2"),
        ({"fps": 20.0}, "fps is 30.0, and here it is 20.0"),
        ({"channels": ("positions",)}, "channels is None"),
        ({"keep": True}, "keep is False"),
        ({"precision": "f32"}, "numerics"),
        ({"key": "a name"}, "key is None"),
        ({"measure": swept.several}, "in its measure"),
        ({"parameters": {**GRID, "dt": [1e-3, 3e-3]}}, "in its parameters, dt is"),
        ({"parameters": dict(reversed(GRID.items()))}, "order"),
    ],
)
def test_the_folder_of_another_sweep_is_refused_and_stays(change, difference, tmp_path):
    call = {"parameters": GRID, "duration": 0.1, "measure": sag, "folder": tmp_path}
    sweep(rope, **call)
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(pc.SceneError, match=rf"^folder: .* belongs to another sweep: .*{difference}"):
        sweep(rope, **{**call, **change})
    assert before == {path: path.read_bytes() for path in tmp_path.iterdir()}


def test_another_scene_at_a_point_is_refused_before_anything_is_computed(tmp_path):
    sweep(rope, GRID, 0.1, measure=sag, folder=tmp_path)
    (tmp_path / "point-1.npz").unlink()
    with pytest.raises(pc.SceneError, match=r"^folder: .*point-0.npz belongs to another sweep: build gives another sc"):
        sweep(partial(rope, damping=0.02), GRID, 0.1, measure=sag, folder=tmp_path)
    assert not (tmp_path / "point-1.npz").exists()
    with pytest.raises(pc.SceneError, match=r"build gives an error: .*damping"):
        sweep(partial(rope, damping=-1.0), GRID, 0.1, measure=sag, folder=tmp_path)


def test_damaged_files_are_computed_anew_with_a_warning(table, tmp_path):
    call = partial(sweep, rope, GRID, 0.1, measure=sag, folder=tmp_path)
    call()
    for name, damage in [("point-0.npz", b"\xff" * 64), ("point-3.npz", b""), ("sweep.json", b"{")]:
        (tmp_path / name).write_bytes(damage)
        with pytest.warns(pc.FileWarning, match=rf"^folder: .*{name}"):
            assert rows(call()) == rows(table)
        assert (tmp_path / name).stat().st_size > 100
    (tmp_path / "sweep.json").unlink()
    with pytest.raises(pc.SceneError, match=r"point-0.npz belongs to another sweep"):
        sweep(rope, GRID, 0.2, measure=sag, folder=tmp_path)


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
def test_what_diverged_is_kept_and_other_failures_are_tried_again(tmp_path):
    call = partial(sweep, rope, {"stiffness": [50.0, 1e9]}, 1.0, dt=1e-2, folder=tmp_path)
    table = call(measure=swept.sag)
    error = table[1].error
    assert isinstance(error, pc.SimulationDiverged)
    assert error.step > 0
    assert "dt" in error.hint
    before = (tmp_path / "point-1.npz").stat().st_mtime_ns
    again = call(measure=swept.sag)
    assert (tmp_path / "point-1.npz").stat().st_mtime_ns == before
    assert rows(again) == rows(table)
    assert vars(again[1].error) == vars(error)

    folder = tmp_path / "failing"
    for _ in range(2):
        with pytest.warns(pc.SceneWarning, match="every point failed"):
            (row,) = sweep(rope, {"stiffness": [1e3]}, 0.1, measure=swept.failing, folder=folder)
        assert isinstance(row.error, RuntimeError)
        assert "swept.py" in row.error.__notes__[0]
        times = [(folder / "point-0.npz").stat().st_mtime_ns]
    assert times[0] > before


def test_errors_of_build_are_rows(tmp_path):
    table = sweep(swept.fragile, {"number": range(4)}, 0.1, measure=sag, folder=tmp_path)
    assert isinstance(table[1].error, ZeroDivisionError)
    assert str(table[1].error) == "one is not allowed"
    assert str(table[2].error) == "build: must return a Scene, returned 'no scene' for number=2"
    assert [row.error is None for row in table] == [True, False, False, True]


def test_functions_in_scenes_have_to_be_named_in_folders_only(tmp_path):
    def build(strength):
        return pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(lambda time, x, v: -strength * x))

    call = partial(sweep, build, {"strength": [1.0, 2.0]}, 0.1, measure=lambda recording: recording.positions[-1, 0, 0])
    assert call()[0].error is None
    with pytest.raises(pc.SceneError, match=r"^key: must name the functions .*forces\[0\]\.function"):
        call(folder=tmp_path)
    kept = call(folder=tmp_path, key="linear", keep=True)
    assert rows(kept) == rows(call())
    assert kept[1].recording.positions[-1, 0, 0] == kept[1].value


# Deaths.


def test_a_process_that_dies_is_a_row_and_is_replaced():
    table = sweep(swept.deadly, {"number": range(4)}, 0.1, measure=sag)
    assert isinstance(table[1].error, pc.WorkerError)
    assert "was killed by signal 9" in str(table[1].error)
    assert [row.error for row in table if row.parameters["number"] != 1] == [None] * 3


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_an_executor_that_dies_is_an_error_with_the_rows_so_far(tmp_path):
    with (
        ProcessPoolExecutor(1) as pool,
        pytest.raises(pc.WorkerError, match=r"^executor: BrokenProcessPool.*1 of 3") as caught,
    ):
        sweep(swept.deadly, {"number": range(3)}, 0.1, measure=sag, executor=pool, folder=tmp_path)
    assert [row.parameters for row in caught.value.table] == [{"number": 0}]
    assert (tmp_path / "point-0.npz").exists()


class Unwilling(ThreadPoolExecutor):
    def submit(self, function, *arguments):
        future = Future()
        future.set_exception(ConnectionError("the scheduler is gone"))
        return future


def test_errors_of_an_executor_are_told():
    with pytest.raises(
        pc.WorkerError, match=r"^executor: ConnectionError: the scheduler is gone; 0 of 6 points"
    ) as caught:
        sweep(rope, GRID, 0.1, measure=sag, executor=Unwilling(1))
    assert caught.value.table is None


LONG = """
import sys
import physcore as pc
from swept import sag, slow

if __name__ == "__main__":
    pc.sweep(slow, {"number": range(8), "folder": [sys.argv[1]]}, 0.1, measure=sag, folder=sys.argv[2], progress=False)
"""


@pytest.fixture
def running(tmp_path):
    """A script with a sweep of eight points of a second each, its processes, and its folder."""
    begun, points = tmp_path / "begun", tmp_path / "points"
    begun.mkdir()
    (tmp_path / "script.py").write_text(LONG, encoding="utf-8")
    process = subprocess.Popen(
        [sys.executable, tmp_path / "script.py", begun, points],
        env={**environment(), "PHYSCORE_NUM_THREADS": "2"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    while not list(points.glob("point-*.npz")):
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.01)
    yield process, begun, points
    process.kill()
    process.communicate()


def alive(identifier: int) -> bool:
    """Whether a process exists and is not a zombie."""
    try:
        return Path(f"/proc/{identifier}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_processes_end_with_their_caller_and_the_next_call_goes_on(sent, running, tmp_path):
    process, begun, points = running
    if sent == signal.SIGINT:
        os.killpg(process.pid, sent)  # A terminal sends it to all processes.
    else:
        process.send_signal(sent)
    _, errors = process.communicate(timeout=60)
    if sent == signal.SIGINT:
        assert errors.count("KeyboardInterrupt") == 1
        assert "points are finished, and the next call goes on from" in errors
    workers = {int(path.name.split("-")[2]) for path in begun.iterdir()}
    assert len(workers) == 2
    deadline = time.monotonic() + 60.0
    while any(map(alive, workers)):
        assert time.monotonic() < deadline, "workers go on without their caller"
        time.sleep(0.01)

    finished = {path.name: path.read_bytes() for path in points.glob("point-*.npz")}
    assert 0 < len(finished) < 8
    table = sweep(swept.slow, {"number": range(8), "folder": [str(begun)]}, 0.1, measure=sag, folder=points)
    assert [row.error for row in table] == [None] * 8
    assert all((points / name).read_bytes() == content for name, content in finished.items())
    assert not list(points.glob(".*"))


def test_a_sweep_in_memory_ends_its_processes_after_an_error(monkeypatch):
    """An error while a row is taken."""
    started = []
    start = workers_process = __import__("multiprocessing").get_context("fork").Process.start

    def counted(self):
        workers_process(self)
        started.append(self)

    monkeypatch.setattr(__import__("multiprocessing").get_context("fork").Process, "start", counted)
    monkeypatch.setattr("physcore.progress.Progress.update", lambda self, done: 1 / (done == 0))
    with pytest.raises(ZeroDivisionError):
        sweep(rope, GRID, 0.1, measure=sag)
    assert started
    assert not any(each.is_alive() for each in started)
    del start


# What is wrong.


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"build": 3}, r"^build: must be a function that returns a Scene, got 3"),
        ({"parameters": [1.0]}, r"^parameters: must be a mapping"),
        ({"parameters": {}}, r"^parameters: must not be empty"),
        ({"parameters": {"stiffness": 3.0}}, r"^parameters\['stiffness'\]: must be a list of values"),
        ({"parameters": {"stiffness": []}}, r"^parameters\['stiffness'\]: must have at least one value"),
        ({"parameters": {"stiffness": [1.0, 1.0]}}, r"^parameters\['stiffness'\]: has the value 1.0 twice"),
        ({"parameters": {"stifness": [1.0]}}, r"^parameters\['stifness'\]: is neither .*did you mean 'stiffness'"),
        ({"build": swept.deadly}, r"^build: needs the argument 'number'"),
        ({"parameters": {"dt": [0.1]}, "dt": 0.1}, r"^dt: is a parameter of the sweep too"),
        ({"build": lambda stiffness, dt=1: rope(), "dt": 0.1}, r"^dt: is an argument of build"),
        ({"measure": None}, r"^measure: give a function of the recording, or keep=True"),
        ({"measure": 3}, r"^measure: must be a function of a recording, got 3"),
        ({"executor": 3}, r"^executor: must be a concurrent.futures.Executor, got 3"),
        ({"duration": -1.0}, r"^duration: must be"),
        ({"fps": 0.0}, r"^fps: must be"),
        ({"keep": "yes"}, r"^keep: must be True or False"),
        ({"key": "name"}, r"^key: .*give a folder too"),
        ({"folder": 3}, r"^folder: must be the name of a file"),
    ],
)
def test_bad_arguments_are_named(arguments, message):
    with pytest.raises(pc.SceneError, match=message):
        sweep(**{"build": rope, "parameters": {"stiffness": [1.0]}, "duration": 0.1, "measure": sag, **arguments})


def test_misspelt_keywords_are_suggested():
    with pytest.raises(TypeError, match="did you mean 'integrator'"):
        sweep(rope, GRID, 0.1, measure=sag, integrater="PEFRL")


def test_a_client_of_dask_is_told_from_its_executor():
    client = type("Client", (), {"get_executor": lambda self: None})()
    with pytest.raises(pc.SceneError, match=r"write executor=client.get_executor\(\)"):
        workers.check_executor(client)


def test_a_folder_that_is_a_file_is_refused(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(pc.FileError, match=r"^folder: .*file cannot be used as a folder"):
        sweep(rope, GRID, 0.1, measure=sag, folder=tmp_path / "file")


# Recordings and plots.


def test_recordings_are_kept_in_memory_and_in_folders(tmp_path):
    plain = pc.simulate(rope(100.0), 0.1, dt=1e-3)
    for folder in (None, tmp_path):
        table = sweep(rope, GRID, 0.1, keep=True, folder=folder)
        recording = table[2].recording
        np.testing.assert_array_equal(recording.positions, plain.positions)
        np.testing.assert_array_equal(recording.energy.balance, plain.energy.balance)
        assert table[2].value is None
        with pytest.raises(pc.SceneError, match=r"^recording: there is none of stiffness = -1.*it failed"):
            _ = table[5].recording
    again = sweep(rope, GRID, 0.1, keep=True, folder=tmp_path)
    np.testing.assert_array_equal(again[2].recording.positions, plain.positions)
    (tmp_path / "point-2.npz").unlink()
    with pytest.raises(pc.PhyscoreError, match=r"point-2.npz is gone or damaged"):
        _ = again[2].recording


def test_without_keep_there_are_no_recordings(table):
    with pytest.raises(pc.SceneError, match="recordings are kept by"):
        _ = table[0].recording


def test_plots_have_a_line_for_each_value_of_the_other_parameters(table, tmp_path):
    axes = table.plot(tmp_path / "plot.png")
    assert (tmp_path / "plot.png").read_bytes().startswith(b"\x89PNG")
    assert axes.get_xlabel() == "stiffness"
    lines = {line.get_label(): line for line in axes.lines}
    assert set(lines) == {"dt = 0.001", "dt = 0.002", "failed"}
    np.testing.assert_array_equal(lines["dt = 0.001"].get_xdata(), [50.0, 100.0])
    np.testing.assert_array_equal(lines["dt = 0.001"].get_ydata(), [table[0].value, table[2].value])
    np.testing.assert_array_equal(lines["failed"].get_xdata(), [-1.0, -1.0])
    assert table.plot(x="dt").get_xlabel() == "dt"
    with pytest.raises(pc.SceneError, match=r"^x: must be .*did you mean 'stiffness'"):
        table.plot(x="stifness")


def test_scales_follow_the_values():
    assert scale_of([1.0, 2.0, 3.0]) == "linear"
    assert scale_of([1.0, 10.0, 100.0]) == "log"
    assert scale_of([-1.0, 10.0, 100.0]) == "linear"
    assert scale_of([1.0, 2.0]) == "linear"
    assert scale_of(["a", "b"]) == scale_of([True, False]) == scale_of([pc.PEFRL(), 1.0]) == "words"
    words = sweep(rope, {"integrator": ["PEFRL", "VelocityVerlet"]}, 0.1, measure=sag, dt=1e-3).plot()
    assert [label.get_text() for label in words.get_xticklabels()] == ["PEFRL", "VelocityVerlet"]


def test_a_build_with_random_numbers_has_no_recordings():
    """The scene that is built again is another one."""
    random = np.random.default_rng(1)
    (row,) = sweep(lambda n: pc.Scene(pc.Particles(random.random((n, 2)))), {"n": [3]}, 0.1, keep=True)
    # Processes are forks, in which the generator begins as here.
    assert row.task.hash(row.task.scene()) == row.kept.scene
    with pytest.raises(pc.SceneError, match="gives another scene for n = 3 than before; if it takes random numbers"):
        _ = row.recording


def test_values_that_are_nearly_equal_are_told_apart():
    table = sweep(rope, {"stiffness": [1.0, 1.00000001]}, 0.1, measure=sag)
    assert len(table.plot(x="stiffness").lines[0].get_xdata()) == 2
    assert "1.00000001" in str(table)
