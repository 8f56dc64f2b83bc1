"""Files: they hold what the next bits depend on, and no damage goes unnoticed."""

from __future__ import annotations

import dataclasses
import json
import os
import zipfile
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from physcore.film import provenance
from physcore.simulation.serial import unpack_scene
from physcore.storage import archive

WIND = pc.Drag(0.001, wind=(0.1, 0.0))
BODIES = (
    pc.cloth((6, 5), spacing=0.02, stiffness=300.0, damping=0.01, mass=1e-3, pinned="top", name="cloth"),
    pc.Particles([[0.0, 0.5], [0.1, 0.5]], velocities=[0.3, 0.0], mass=[1.0, 2.0], charge=1e-9, radius=0.01),
)
SCENE = pc.Scene(
    *BODIES,
    pc.Gravity((0.0, -9.81), on=BODIES[0]),
    pc.CentralForce((0.0, 0.0), 0.1, softening=0.5, on=[BODIES[1]]),
    WIND,
    pc.ElectromagneticField((0.0, 0.1)),
    pc.Floor(-1.0, restitution=0.5, friction=0.1),
)


def saved(simulation: pc.Simulation, path) -> bytes:
    simulation.save(path)
    return path.read_bytes()


def test_a_checkpoint_keeps_scene_and_numerics(tmp_path):
    numerics = {
        "integrator": pc.VelocityVerlet(),
        "dt": 1e-4,
        "precision": "f64",
        "threads": 1,
        "max_energy_growth": 1e5,
    }
    simulation = pc.Simulation(SCENE, **numerics)
    simulation.save(tmp_path / "state")
    loaded = pc.load(tmp_path / "state")
    assert isinstance(loaded, pc.Simulation)
    assert loaded.integrator == pc.VelocityVerlet()
    assert loaded.dt == 1e-4
    assert loaded.plan == simulation.plan
    assert len(loaded.scene.forces) == 4
    assert loaded.scene.forces[2] == WIND
    assert loaded.scene.forces[0].bodies() == (loaded.scene.bodies[0],)
    assert loaded.scene.boundaries == SCENE.boundaries
    for mine, theirs in zip(SCENE.bodies, loaded.scene.bodies, strict=True):
        assert mine.name == theirs.name
        for name in ("positions", "velocities", "mass", "charge", "radius", "fixed"):
            assert (getattr(mine, name) == getattr(theirs, name)).all()


def test_a_scene_of_pairs_and_fluids_comes_back_as_it_was():
    """The tree is what a file holds: JSON and arrays."""
    water = pc.Fluid(
        pc.block((0.0, 0.0), (0.4, 0.2), 0.1),
        0.1,
        900.0,
        0.01,
        velocities=(1.0, 0.0),
        name="water",
    )
    oil = pc.Fluid(pc.block((0.4, 0.0), (0.8, 0.2), 0.1), 0.1)
    grains = pc.Particles([[0.0, 0.5]], radius=0.01)
    pairs = (pc.SoftSpheres(1.0, 0.1, 0.5, 0.2, 1.5), pc.LennardJones(1.0, 0.1, on=[grains, water]))
    scene = pc.Scene(water, oil, grains, *pairs, pc.Periodic((-1.0, -np.inf), (1.0, np.inf)))
    content = json.loads(json.dumps(scene.packed(), default=lambda values: values.tolist()))
    loaded = unpack_scene(content)
    assert loaded.periodic == scene.periodic
    assert loaded.forces[0] == scene.forces[0]
    assert loaded.forces[1].bodies() == (loaded.bodies[2], loaded.bodies[0])
    for mine, theirs in zip(scene.bodies, loaded.bodies, strict=True):
        assert type(mine) is type(theirs)
        for field in dataclasses.fields(mine):
            value, copy = getattr(mine, field.name), getattr(theirs, field.name)
            assert (value == copy).all() if isinstance(value, np.ndarray) else value == copy


def test_the_same_state_gives_the_same_file(tmp_path):
    simulation = pc.Simulation(SCENE)
    assert saved(simulation, tmp_path / "one") == saved(simulation, tmp_path / "two")


def test_any_truncation_and_any_flipped_bit_is_noticed(tmp_path):
    path = tmp_path / "state"
    data = saved(pc.Simulation(pc.Scene(pc.Particles([[0.0, 0.0]]))), path)
    generator = np.random.default_rng(1)
    cuts = [data[:size] for size in (0, 1, 100, len(data) // 2, len(data) - 1)]
    longer = [data + b"\0", b"\0" + data, data + data]
    places = np.concatenate([generator.integers(len(data), size=300), np.arange(len(data) - 120, len(data))])
    flips = []
    for place in places.tolist():
        flipped = bytearray(data)
        flipped[place] ^= 1 << int(generator.integers(8))
        flips.append(bytes(flipped))
    for damaged in (*cuts, *longer, *flips):
        path.write_bytes(damaged)
        with pytest.raises(pc.FileError) as caught:
            pc.load(path)
        assert str(path) in str(caught.value)
        assert isinstance(caught.value, OSError)


def test_a_file_of_another_version_says_so(tmp_path, monkeypatch):
    path = tmp_path / "state"
    monkeypatch.setattr(archive, "VERSION", 2)
    pc.Simulation(SCENE).save(path)
    monkeypatch.undo()
    with pytest.raises(pc.FileError, match="format version '2'; this physcore reads version 1"):
        pc.load(path)


def test_a_file_without_the_history_of_its_steps_is_refused(tmp_path):
    """Segments of a checkpoint, and provenance of a recording, are entries that no file lacks."""
    simulation, path = pc.Simulation(SCENE, dt=1e-3), tmp_path / "state"
    simulation.step(10)
    simulation.save(path)
    kind, content = archive.read(path)
    assert content["stepper"].pop("segments") == [{"start": 0.0, "steps": 10, "dt": 1e-3}]
    archive.write(path, kind, content)
    with pytest.raises(pc.FileError, match=r"stepper\.segments: is missing"):
        pc.load(path)

    pc.simulate(SCENE, 0.1).save(path)
    kind, content = archive.read(path)
    del content["provenance"]
    archive.write(path, kind, content)
    with pytest.raises(pc.FileError, match=r"provenance: is missing"):
        pc.load(path)


def test_a_film_of_what_has_no_provenance_says_what_it_knows(tmp_path):
    """Films take whatever has a scene, times, positions and fps; the rest of their provenance is unknown then."""
    recording = pc.simulate(SCENE, 0.1)
    shown = SimpleNamespace(
        scene=SCENE,
        times=recording.times,
        positions=recording.positions,
        fps=recording.fps,
        channels=recording.channels,
    )
    pc.film(shown, tmp_path / "film.gif", size=(64, 48))
    (panel,) = provenance(tmp_path / "film.gif")
    assert panel["scene"] == SCENE.hash()
    assert panel["state"] is panel["segments"] is panel["numerics"] is None


def test_the_history_goes_on_where_a_checkpoint_was_loaded(tmp_path):
    straight, first = pc.Simulation(SCENE, dt=1e-3), pc.Simulation(SCENE, dt=1e-3)
    straight.step(30)
    first.step(20)
    first.save(tmp_path / "state")
    second = pc.load(tmp_path / "state")
    assert isinstance(second, pc.Simulation)
    second.step(10)
    assert second.provenance == straight.provenance
    recording = second.record(0.1)
    recording.save(tmp_path / "run")
    loaded = pc.load(tmp_path / "run")
    assert isinstance(loaded, pc.Recording)
    assert loaded.provenance == recording.provenance == second.provenance


@pytest.mark.parametrize(
    ("prepare", "message"),
    [
        (lambda path: None, "cannot be read: No such file"),
        (lambda path: path.mkdir(), "cannot be read: Is a directory"),
        (lambda path: path.write_bytes(b""), "is empty"),
        (lambda path: path.write_text("x = 1\n" * 100), "no file of physcore"),
        (lambda path: np.savez(path.open("wb"), x=np.zeros(1000)), "no file of physcore"),
    ],
)
@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_what_is_no_file_of_physcore_is_refused(tmp_path, prepare, message):
    path = tmp_path / "thing"
    prepare(path)
    with pytest.raises(pc.FileError, match=message):
        pc.load(path)


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "state"
    simulation = pc.Simulation(SCENE)
    before = saved(simulation, path)

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(pc.FileError, match="state: cannot be written: No space left on device"):
        simulation.save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_that_does_not_exist_is_a_file_error(tmp_path):
    with pytest.raises(pc.FileError, match="cannot be written: No such file or directory"):
        pc.Simulation(SCENE).save(tmp_path / "missing" / "state")


def test_a_custom_force_cannot_be_saved_and_the_message_says_why(tmp_path):
    scene = pc.Scene(BODIES[1], pc.CustomForce(lambda time, x, v: -x))
    with pytest.raises(pc.FileError, match=r"forces\[0\]\.function: a CustomForce cannot be saved"):
        pc.Simulation(scene, dt=1e-3).save(tmp_path / "state")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "item",
    [
        pc.Drag(1.0, wind=lambda time: (0.0, 0.0)),
        pc.ElectromagneticField(magnetic=lambda time, x: 0.0 * x[:, 0]),
        pc.Wave(pc.Grid((8, 8), 0.1), 1.0, edges={"y-": pc.Dirichlet(lambda time: 0.0)}),
        pc.Wave(pc.Grid((8, 8), 0.1), 1.0, sources=[pc.Source((0.3, 0.3), 1.0, signal=lambda time: 0.0)]),
        pc.ReactionDiffusion(
            pc.Grid((8, 8), 0.1),
            pc.GrayScott(0.035, 0.0625),
            {"u": 2e-5, "v": 1e-5},
            {"u": 1.0, "v": 0.25},
            edges={"v": {"x+": pc.Neumann(lambda time: 0.0)}},
        ),
    ],
    ids=lambda item: type(item).__name__,
)
def test_an_error_of_saving_names_the_function(item):
    scene = pc.Scene(pc.Particles([[0.5, 0.5]]), item)
    with pytest.raises(pc.FileError, match="cannot be saved") as caught:
        scene.packed()
    message = str(caught.value)
    assert callable(eval(message.partition(":")[0], {"forces": scene.forces, "systems": scene.systems}))
    assert ("express the force" in message) == isinstance(item, pc.Force)


def test_nothing_is_pickled(tmp_path):
    path = tmp_path / "state"
    pc.Simulation(SCENE).save(path)
    with zipfile.ZipFile(path) as zipped:
        names = zipped.namelist()
        for name in names:
            assert name == "header.json" or zipped.read(name).startswith(b"\x93NUMPY")
    with np.load(path, allow_pickle=False) as arrays:
        assert all(arrays[name].dtype != object for name in arrays.files if name != "header.json")


def test_a_loaded_run_does_not_warn_a_second_time(tmp_path):
    scene = pc.Scene(pc.rope(3, 1.0, 100.0))
    with pytest.warns(pc.StabilityWarning):
        pc.Simulation(scene, dt=1.0).save(tmp_path / "state")
    pc.load(tmp_path / "state")


LEAVES = st.none() | st.booleans() | st.integers(0, 2**64 - 1) | st.floats(allow_nan=False) | st.text() | st.binary()


@given(tree=st.dictionaries(st.text("abc", min_size=1), st.recursive(LEAVES, lambda t: st.lists(t, max_size=4))))
def test_a_tree_of_values_comes_back_as_it_was(tmp_path_factory, tree):
    path = tmp_path_factory.mktemp("tree") / "file"
    archive.write(path, "kind", tree)
    assert archive.read(path) == ("kind", tree)
