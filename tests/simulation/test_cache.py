"""The cache of recordings: what is read back is what was computed, and nothing else."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import physcore as pc

BALL = pc.Particles([[0.0, 2.0]], velocities=[[0.3, 0.0]], name="ball")
SCENE = pc.Scene(BALL, pc.Gravity(), pc.Drag(linear=0.1))


def pull(time, positions, velocities):
    return -positions


def same(one: pc.Recording, other: pc.Recording) -> bool:
    """Whether two recordings have the same bits, budgets, plan, provenance and events."""
    return (
        all(np.array_equal(one.channels[name], other.channels[name]) for name in (*one.channels, *other.channels))
        and np.array_equal(one.times, other.times)
        and np.array_equal(one.energy.balance, other.energy.balance)
        and np.array_equal(one.momentum, other.momentum)
        and (one.plan, one.provenance) == (other.plan, other.provenance)
    )


@pytest.fixture
def computed(monkeypatch):
    """The scenes that were simulated."""
    from physcore.studies import accuracy

    found = []

    class Counted(pc.Simulation):
        def __init__(self, scene, *arguments, **options):
            found.append(scene)
            super().__init__(scene, *arguments, **options)

    monkeypatch.setattr(accuracy, "Simulation", Counted)
    return found


def test_the_second_run_is_read_to_the_bit(tmp_path, computed):
    plain = pc.simulate(SCENE, 0.5)
    first, second = (pc.simulate(SCENE, 0.5, cache=tmp_path / "new" / "folder") for _ in range(2))
    assert len(computed) == 2
    assert same(first, plain)
    assert same(second, first)
    assert second.scene is SCENE
    np.testing.assert_array_equal(second[BALL].positions, first["ball"].positions)


def test_an_equal_scene_is_the_same_one_and_its_own_bodies_are_keys(tmp_path, computed):
    pc.simulate(SCENE, 0.5, cache=tmp_path)
    ball = pc.Particles([[0.0, 2.0]], velocities=[[0.3, 0.0]], name="ball")
    found = pc.simulate(pc.Scene(ball, pc.Gravity(), pc.Drag(linear=0.1)), 0.5, cache=str(tmp_path))
    assert len(computed) == 1
    assert found[ball].positions.shape == (16, 1, 2)


def test_what_changes_the_result_is_another_entry(tmp_path, computed):
    """Each of the calls is computed once, though all share a folder."""
    low = pc.Event.crossing("ball", "y", 1.5)
    calls = [
        {},
        {"fps": 20.0},
        {"dt": 1e-3},
        {"integrator": pc.PEFRL()},
        {"precision": "f32"},
        {"max_energy_growth": 10.0},
        {"on_divergence": "substep"},
        {"channels": ("positions",)},
        {"events": [low]},
        {"events": [pc.Event.crossing("ball", "y", 1.6)]},
        {"events": [pc.Event(lambda state: state["ball"].positions[0, 1] - 1.5)]},
        {"events": [pc.Event(lambda state: state["ball"].positions[0, 1] - 1.6)]},
        {"key": "a name"},
    ]
    found = [pc.simulate(SCENE, 0.5, **{"cache": tmp_path, **call}) for call in calls]
    found += [pc.simulate(SCENE, 0.6, cache=tmp_path)]
    found += [pc.simulate(pc.Scene(BALL, pc.Gravity(), pc.Drag(linear=0.2)), 0.5, cache=tmp_path)]
    assert len(computed) == len(found) == len(list(tmp_path.glob("*.npz")))
    for call, before in zip(calls, found, strict=False):
        assert same(pc.simulate(SCENE, 0.5, **{"cache": tmp_path, **call}), before)
    assert len(computed) == len(found)


def test_the_number_of_threads_is_no_other_entry(tmp_path, computed):
    pc.simulate(SCENE, 0.5, cache=tmp_path, threads=1)
    pc.simulate(SCENE, 0.5, cache=tmp_path, threads=2)
    assert len(computed) == 1


def test_another_version_is_another_entry(tmp_path, computed, monkeypatch):
    pc.simulate(SCENE, 0.5, cache=tmp_path)
    monkeypatch.setattr("physcore.simulation.cache.version", lambda: "99.0.0")
    pc.simulate(SCENE, 0.5, cache=tmp_path)
    assert len(computed) == 2


def test_events_are_keys_of_what_is_read(tmp_path):
    low = pc.Event.crossing(BALL, "y", 1.5, name="low")
    first, second = (pc.simulate(SCENE, 0.5, cache=tmp_path, events=[low]).events[low] for _ in range(2))
    np.testing.assert_array_equal(first.times, second.times)
    assert len(first) == 1


def test_accuracy_is_part_of_the_entry(tmp_path, computed, capsys):
    runs = [pc.simulate(SCENE, 0.2, accuracy=1e-3, cache=tmp_path) for _ in range(2)]
    assert same(*runs)
    assert not computed  # A search does not go through Simulation.
    assert capsys.readouterr().out.count("keeps within") == 1
    assert not same(pc.simulate(SCENE, 0.2, cache=tmp_path), runs[0])


def test_a_damaged_file_is_computed_anew_with_a_warning(tmp_path, computed):
    first = pc.simulate(SCENE, 0.5, cache=tmp_path)
    (path,) = tmp_path.glob("*.npz")
    whole = path.read_bytes()
    for damaged in (whole[:-40], b"", whole[:1000] + b"\xff" * 64 + whole[1064:]):
        path.write_bytes(damaged)
        with pytest.warns(pc.FileWarning, match=r"^cache: .*computed anew"):
            again = pc.simulate(SCENE, 0.5, cache=tmp_path)
        assert same(again, first)
        assert path.read_bytes() == whole
    assert len(computed) == 4


def test_a_file_under_the_name_of_another_is_not_taken(tmp_path):
    pc.simulate(SCENE, 0.5, cache=tmp_path)
    (path,) = tmp_path.glob("*.npz")
    other = pc.simulate(SCENE, 0.6, cache=tmp_path)
    (second,) = set(tmp_path.glob("*.npz")) - {path}
    second.write_bytes(path.read_bytes())
    with pytest.warns(pc.FileWarning, match="another recording"):
        assert same(pc.simulate(SCENE, 0.6, cache=tmp_path), other)


def test_functions_of_a_scene_have_to_be_named(tmp_path, computed):
    scene = pc.Scene(BALL, pc.CustomForce(pull))
    with pytest.raises(pc.SceneError, match=r"^key: must name the functions of this scene.*forces\[0\]\.function"):
        pc.simulate(scene, 0.5, cache=tmp_path)
    first, second = (pc.simulate(scene, 0.5, cache=tmp_path, key="pull to the origin") for _ in range(2))
    assert same(first, second)
    pc.simulate(scene, 0.5, cache=tmp_path, key="pull, second version")
    assert len(computed) == 2
    with pytest.raises(pc.SceneError, match=r"^key: .*give a folder too"):
        pc.simulate(scene, 0.5, key="pull")
    with pytest.raises(pc.SceneError, match=r"^key: must be a string"):
        pc.simulate(scene, 0.5, cache=tmp_path, key=3)


def test_a_folder_that_cannot_be_written_is_refused_before_the_run(tmp_path, computed):
    file = tmp_path / "file"
    file.write_bytes(b"")
    with pytest.raises(pc.FileError, match=r"^cache: .*file cannot be used as a folder"):
        pc.simulate(SCENE, 0.5, cache=file)
    with pytest.raises(pc.SceneError, match=r"^cache: must be the name of a file"):
        pc.simulate(SCENE, 0.5, cache=3)
    assert not computed


def test_a_full_disk_after_the_run_loses_nothing(tmp_path, monkeypatch):
    def full(*arguments):
        raise pc.FileError(f"{tmp_path}: cannot be written: No space left on device")

    monkeypatch.setattr("physcore.storage.archive.write", full)
    with pytest.warns(pc.FileWarning, match="No space left.*not kept"):
        recording = pc.simulate(SCENE, 0.5, cache=tmp_path)
    assert same(recording, pc.simulate(SCENE, 0.5))


def test_misspelt_numerics_are_refused_though_the_rest_is_there(tmp_path):
    pc.simulate(SCENE, 0.5, cache=tmp_path)
    with pytest.raises(TypeError, match="did you mean 'integrator'"):
        pc.simulate(SCENE, 0.5, cache=tmp_path, integrater="PEFRL")


def test_a_run_that_diverges_leaves_no_file(tmp_path):
    spring = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], 1e8, velocities=[[0, 0], [1, 0]])
    with pytest.warns(pc.StabilityWarning), pytest.raises(pc.SimulationDiverged):
        pc.simulate(pc.Scene(spring), 50.0, dt=1.0, cache=tmp_path)
    assert not list(Path(tmp_path).iterdir())


SCENES = {
    "a fluid": lambda: pc.Scene(
        pc.Fluid(pc.block((0.0, 0.0), (0.3, 0.3), 0.1), 0.1, name="water"), pc.Gravity(), pc.Floor(-0.05)
    ),
    "a wave": lambda: pc.Scene(pc.Wave(pc.Grid((12, 12), 0.1), 1.0, displacement=lambda x, y: x * y, name="pond")),
    "rigid bodies": lambda: pc.Scene(pc.RigidBodies(pc.Disc(0.1), [[0.0, 1.0], [0.5, 1.0]]), pc.Gravity(), pc.Floor()),
    "tracers": lambda: pc.Scene(pc.Tracers([[1.0, 1.0, 1.0]], pc.Lorenz())),
    "units": lambda: pc.Scene(
        pc.Particles([[1.0, 0.0]], velocities=[[0.0, 6.28]], mass=1.0),
        pc.CentralForce((0.0, 0.0), 39.5, exponent=-2),
        units=pc.units.system(length="AU", time="year", mass="solar_mass"),
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_every_kind_of_scene_is_read_back(name, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        first = pc.simulate(SCENES[name](), 0.1, fps=50.0, cache=tmp_path)
        second = pc.simulate(SCENES[name](), 0.1, fps=50.0, cache=tmp_path)
    assert len(list(tmp_path.glob("*.npz"))) == 1
    assert same(first, second)
    assert first.budgets.keys() == second.budgets.keys()
