"""Trajectories for other tools: each file is opened by a reader that shares no code with its writer."""

from __future__ import annotations

import io
import os
import re
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest

import physcore as pc
from forks import Forks
from physcore.output import FORMATS

SUFFIXES = [suffix for kind in FORMATS if kind.holds_particles for suffix in kind.suffixes]

CLOTH = pc.cloth((4, 3), spacing=0.1, stiffness=50.0, mass=0.01, pinned="top", name="cloth")
WATER = pc.Fluid(pc.block((0.6, 0.0), (1.0, 0.4), 0.1), 0.1)
GRAINS = pc.Particles([[0.1, 0.1], [0.9, 0.7]], velocities=[[0.3, 0.1], [5.0, 1.0 / 3.0]], radius=0.02, charge=1e-9)
SPACE = pc.Particles(
    np.random.default_rng(1).normal(size=(5, 3)) * 1e-5, velocities=[0.0, 0.0, 1e-7], mass=[1, 2, 3, 4, 5]
)
NET = pc.rope(3, length=0.2, stiffness=10.0, mass=0.1, start=(0.85, 0.5))
FIELD = pc.ElectromagneticField((0.0, 0.1))

SCENES = {
    "springs": pc.Scene(CLOTH, GRAINS, pc.Gravity((0.0, -9.81)), FIELD),
    "water": pc.Scene(WATER, GRAINS, pc.Gravity((0.0, -1.0)), FIELD, pc.Box((0.0, -0.05), (2.0, 1.0))),
    "3D": pc.Scene(SPACE),
    "strip": pc.Scene(GRAINS, NET, FIELD, pc.Periodic((0.0, -np.inf), (1.0, np.inf))),
    "periodic": pc.Scene(pc.Particles(SPACE.positions, [1.0, 0.0, 0.5]), pc.Periodic((-1e-5,) * 3, (2e-5, 3e-5, 4e-5))),
    "nothing": pc.Scene(pc.Particles(np.empty((0, 2)))),
}
CHANNELS = ("positions", "velocities", "densities", "pressures")


class Read(NamedTuple):
    """What a reader found, over all frames."""

    times: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray
    mass: np.ndarray
    more: dict[str, np.ndarray]


def read_xyz(path: Path) -> Read:
    """With ASE."""
    ase_io = pytest.importorskip("ase.io")
    frames = ase_io.read(path, index=":", format="extxyz")
    names = ("body", "density", "pressure", "radius", "charge")
    return Read(
        np.array([frame.info["Time"] for frame in frames]),
        np.stack([frame.positions for frame in frames]),
        np.stack([frame.arrays["velo"] for frame in frames]),
        frames[0].arrays["mass"],
        {name: np.stack([frame.arrays[name] for frame in frames]) for name in names if name in frames[0].arrays},
    )


def poly_data(path: Path) -> Any:
    """A frame, read by VTK itself."""
    io = pytest.importorskip("vtkmodules.vtkIOXML")
    reader = io.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetErrorCode() == 0
    return reader.GetOutput()


def listed(path: Path) -> list[tuple[float, Path]]:
    """The frames that a .pvd lists."""
    from xml.etree import ElementTree

    entries = ElementTree.parse(path).getroot().iter("DataSet")
    return [(float(entry.attrib["timestep"]), path.parent / entry.attrib["file"]) for entry in entries]


def read_pvd(path: Path) -> Read:
    numpy_support = pytest.importorskip("vtkmodules.util.numpy_support")
    to_numpy: Callable[[Any], np.ndarray] = numpy_support.vtk_to_numpy
    times, files = zip(*listed(path), strict=True)
    frames = [poly_data(file) for file in files]
    arrays = [
        {
            frame.GetPointData().GetArrayName(index): to_numpy(frame.GetPointData().GetArray(index))
            for index in range(frame.GetPointData().GetNumberOfArrays())
        }
        for frame in frames
    ]
    for time_value, frame in zip(times, frames, strict=True):
        assert frame.GetFieldData().GetArray("TimeValue").GetValue(0) == time_value
    more = {name: np.stack([each[name] for each in arrays]) for name in arrays[0]}
    positions = np.stack([to_numpy(frame.GetPoints().GetData()) for frame in frames])
    return Read(np.array(times), positions, more.pop("velocity"), more.pop("mass")[0], more)


def read_h5md(path: Path) -> Read:
    """With pyh5md."""
    pyh5md = pytest.importorskip("pyh5md")
    with pyh5md.File(path, "r") as file:
        group = file.particles_group("all")
        element = pyh5md.element(group, "position")
        more = {
            name: pyh5md.element(group, name).value[:] for name in ("density", "pressure", "radius") if name in group
        }
        more["body"] = pyh5md.element(group, "species").value[:]
        velocity = pyh5md.element(group, "velocity")
        mass = pyh5md.element(group, "mass").value[:]
        return Read(element.time[:], element.value[:], velocity.value[:], mass, more)


READERS = {".xyz": read_xyz, ".extxyz": read_xyz, ".pvd": read_pvd, ".h5md": read_h5md}


def content(path: Path) -> dict[str, bytes]:
    """Every file below a folder."""
    return {str(each.relative_to(path)): each.read_bytes() for each in sorted(path.rglob("*")) if each.is_file()}


def simulated(name: str) -> pc.Recording:
    channels = CHANNELS if SCENES[name].fluids else CHANNELS[:2]
    return pc.simulate(SCENES[name], 0.3, fps=10, channels=channels)  # type: ignore[arg-type]


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("name", [name for name in SCENES if name != "nothing"])
def test_every_number_comes_back_to_the_bit(name: str, suffix: str, tmp_path: Path) -> None:
    recording = simulated(name)
    path = tmp_path / f"run{suffix}"
    pc.export(recording, path)
    found = READERS[suffix](path)
    flat = recording.scene.dimension
    np.testing.assert_array_equal(found.times, recording.times)
    np.testing.assert_array_equal(found.positions[..., :flat], recording.positions)
    np.testing.assert_array_equal(found.velocities[..., :flat], recording.velocities)
    assert not found.positions[..., flat:].any()
    np.testing.assert_array_equal(found.mass, np.concatenate([body.mass for body in recording.scene.bodies]))
    bodies = np.repeat(np.arange(len(recording.scene.bodies)), [len(body) for body in recording.scene.bodies])
    np.testing.assert_array_equal(np.broadcast_to(found.more["body"], (4, len(bodies)))[0], bodies)
    if recording.scene.fluids:
        np.testing.assert_array_equal(found.more["density"], recording.densities)
        np.testing.assert_array_equal(found.more["pressure"], recording.pressures)
    else:
        assert "density" not in found.more


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_scene_gives_the_bytes_of_its_recording_for_any_number_of_threads(suffix: str, tmp_path: Path) -> None:
    """Written while it is simulated, one frame at a time."""
    scene = SCENES["springs"]
    folders = [tmp_path / name for name in ("recorded", "streamed", "threads")]
    for folder in folders:
        folder.mkdir()
    pc.export(pc.simulate(scene, 0.3, fps=10), folders[0] / f"run{suffix}")
    pc.export(scene, folders[1] / f"run{suffix}", duration=0.3, fps=10)
    pc.export(scene, folders[2] / f"run{suffix}", duration=0.3, fps=10, threads=2)
    assert content(folders[0]) == content(folders[1]) == content(folders[2])
    assert len(content(folders[0])) == (5 if suffix == ".pvd" else 1)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_scene_without_particles_is_written_too(suffix: str, tmp_path: Path) -> None:
    pc.export(simulated("nothing"), tmp_path / f"run{suffix}")
    if suffix == ".pvd":
        assert poly_data(listed(tmp_path / "run.pvd")[0][1]).GetNumberOfPoints() == 0


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_positions_alone_are_enough(suffix: str, tmp_path: Path) -> None:
    recording = pc.simulate(SCENES["springs"], 0.1, channels=("positions",))
    pc.export(recording, tmp_path / f"run{suffix}")
    if suffix == ".h5md":
        with pytest.importorskip("h5py").File(tmp_path / "run.h5md") as file:
            assert "velocity" not in file["particles/all"]
            return
    assert b"velo" not in b"".join(content(tmp_path).values())


def test_xyz_says_where_space_repeats_itself(tmp_path: Path) -> None:
    ase_io = pytest.importorskip("ase.io")
    for name, flags, lengths in [
        ("periodic", [True, True, True], [3e-5, 4e-5, 5e-5]),
        ("strip", [True, False, False], [1.0, 1.0, 1.0]),
        ("springs", [False, False, False], [0.0, 0.0, 0.0]),
    ]:
        pc.export(simulated(name), tmp_path / "run.xyz")
        atoms = ase_io.read(tmp_path / "run.xyz", format="extxyz")
        assert atoms.pbc.tolist() == flags
        # The length of a domain is a difference, and so off by one rounding of the larger end at most.
        np.testing.assert_allclose(atoms.cell.lengths(), lengths, rtol=3e-16)
    assert 'Origin="-1e-05 -1e-05 -1e-05"' in _exported("periodic", tmp_path / "run.xyz")


def _exported(name: str, path: Path) -> str:
    pc.export(simulated(name), path)
    return path.read_text()


def test_h5md_has_a_box_and_the_energies(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    recording = simulated("periodic")
    pc.export(recording, tmp_path / "run.h5md")
    with h5py.File(tmp_path / "run.h5md") as file:
        assert file["h5md"].attrs["version"].tolist() == [1, 1]
        assert file["particles/all/box"].attrs["boundary"].tolist() == ["periodic"] * 3
        lengths = recording.scene.periodic.lengths  # type: ignore[union-attr]
        np.testing.assert_array_equal(file["particles/all/box/edges/value"], np.tile(lengths, (4, 1)))
        for name in ("kinetic", "potential", "internal", "total", "dissipated", "work"):
            observable = file[f"observables/{name}_energy"]
            np.testing.assert_array_equal(observable["value"], getattr(recording.energy, name))
            np.testing.assert_array_equal(observable["time"], recording.energy.times)
        np.testing.assert_array_equal(file["particles/all/position/step"], np.arange(4))
        assert dict(file["parameters/units"].attrs)["position"] == "m"
    pc.export(simulated("strip"), tmp_path / "run.h5md")
    with h5py.File(tmp_path / "run.h5md") as file:
        assert file["particles/all/box"].attrs["boundary"].tolist() == ["periodic", "none", "none"]


def test_vtk_has_the_springs_and_their_strain(tmp_path: Path) -> None:
    """From the definition, spring by spring; in the strip one goes across a face."""
    numpy_support = pytest.importorskip("vtkmodules.util.numpy_support")
    for name, body in [("springs", CLOTH), ("strip", NET)]:
        recording = simulated(name)
        pc.export(recording, tmp_path / "run.pvd")
        frame = poly_data(listed(tmp_path / "run.pvd")[-1][1])
        assert (frame.GetNumberOfVerts(), frame.GetNumberOfLines()) == (recording.scene.particles, len(body.pairs))
        strain = numpy_support.vtk_to_numpy(frame.GetCellData().GetArray("strain"))
        assert np.isnan(strain[: recording.scene.particles]).all()
        points = recording[body].positions[-1]
        start = recording.scene.slice(body).start
        ids = pytest.importorskip("vtkmodules.vtkCommonCore").vtkIdList()
        for spring, (first, second) in enumerate(body.pairs.tolist()):
            frame.GetCellPoints(recording.scene.particles + spring, ids)
            assert [ids.GetId(0), ids.GetId(1)] == [start + first, start + second]
            apart = points[second] - points[first]
            if recording.scene.periodic is not None:
                apart = recording.scene.periodic.nearest(apart)
            expected = np.hypot(*apart) / body.rest_length[spring] - 1.0
            # Two roundings of a length ratio near one, and one of the difference.
            assert strain[recording.scene.particles + spring] == pytest.approx(expected, abs=8 * 2.0**-53)


@pytest.mark.parametrize("cells", [(5,), (5, 3), (4, 3, 2)])
def test_vtk_has_fields_in_their_cells(tmp_path: Path, cells: tuple[int, ...]) -> None:
    """Each value where VTK says that the center of its cell is; beside particles in files of their own."""
    io, numpy_support = pytest.importorskip("vtkmodules.vtkIOXML"), pytest.importorskip("vtkmodules.util.numpy_support")
    axes = len(cells)
    grid = pc.Grid(cells, 0.5, origin=tuple(range(1, axes + 1)))
    wave = pc.Wave(grid, 1.0, np.arange(grid.size, dtype=float).reshape(cells), rate=1.0, name="p & q")
    bodies = [pc.Particles(np.zeros((2, axes)))] if axes > 1 else []
    recording = pc.simulate(pc.Scene(*bodies, wave), 0.2, 10.0)
    pc.export(recording, tmp_path / "run.pvd")
    files = [file for _, file in listed(tmp_path / "run.pvd")]
    assert [file.suffix for file in files] == [*[".vtp"] * bool(bodies), ".vti"] * 3
    reader = io.vtkXMLImageDataReader()
    reader.SetFileName(str(files[-1]))
    reader.Update()
    assert reader.GetErrorCode() == 0
    image = reader.GetOutput()
    assert image.GetNumberOfCells() == grid.size
    for name in ("displacement", "rate"):
        values = numpy_support.vtk_to_numpy(image.GetCellData().GetArray(name))
        expected = getattr(recording[wave], name)[-1]
        for index, value in enumerate(values):
            low, high = np.array(image.GetCell(index).GetBounds()).reshape(3, 2).T
            at = np.rint(((low + high)[:axes] / 2 - grid.origin) / grid.spacing - 0.5).astype(int)
            assert value == expected[tuple(at)]
    if not bodies:
        with pytest.raises(
            pc.SceneError, match=r"path: \.xyz holds particles, and there are only fields .* write \.pvd"
        ):
            pc.export(recording, tmp_path / "run.xyz")


def test_a_new_export_takes_the_place_of_the_old_frames_and_of_nothing_else(tmp_path: Path) -> None:
    path, mine = tmp_path / "run.pvd", tmp_path / "run" / "notes.txt"
    pc.export(simulated("springs"), path)
    mine.write_text("keep")
    (old,) = {file.parent for _, file in listed(path)}
    pc.export(simulated("3D"), path)
    (new,) = {file.parent for _, file in listed(path)}
    assert new != old
    assert sorted(mine.parent.iterdir()) == sorted([mine, new])
    pc.export(simulated("3D"), path)  # the same once more
    assert sorted(mine.parent.iterdir()) == sorted([mine, new])
    assert all(file.is_file() for _, file in listed(path))


def never(time: float, x: np.ndarray, v: np.ndarray) -> np.ndarray:
    raise AssertionError("it was simulated")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_what_cannot_be_exported_is_refused_before_it_is_simulated(suffix: str, tmp_path: Path) -> None:
    scene, path = pc.Scene(GRAINS, pc.CustomForce(never)), tmp_path / f"run{suffix}"
    with pytest.raises(pc.SceneError, match=r"path: must end in \.xyz, \.extxyz, \.pvd, \.h5md, \.glb or \.usda, got"):
        pc.export(scene, tmp_path / "run.vtk", duration=1.0)
    with pytest.raises(pc.FileError, match="no such folder"):
        pc.export(scene, tmp_path / "none" / path.name, duration=1.0)
    with pytest.raises(pc.SceneError, match="duration: "):
        pc.export(scene, path)
    with pytest.raises(TypeError, match="unexpected keyword argument 'colour'"):
        pc.export(scene, path, duration=1.0, colour="red")  # type: ignore[call-arg]
    with pytest.raises(pc.SceneError, match="recording: must be a Recording"):
        pc.export([scene], path, duration=1.0)  # type: ignore[arg-type]
    with pytest.raises(pc.SceneError, match="dt: is for a scene, and this is a recording"):
        pc.export(simulated("3D"), path, dt=0.1)
    with pytest.raises(pc.SimulationDiverged, match=r"where forces\[0\]\.function returns"):  # in the middle of it
        pc.export(
            pc.Scene(GRAINS, pc.CustomForce(lambda t, x, v: x * (np.nan if t > 0.5 else 1.0))), path, duration=1.0
        )
    with pytest.raises(pc.SceneError, match="positions were not recorded"):
        pc.export(pc.simulate(SCENES["3D"], 0.1, channels=("velocities",)), path)
    bare = SimpleNamespace(scene=scene, times=np.zeros(1), positions=np.zeros((1, 3, 3)), fps=1.0, channels={})
    with pytest.raises(pc.SceneError, match=r"recording: must be a Scene or what simulate\(…\) gives"):
        pc.export(bare, path)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_an_absent_library_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(pc.PhyscoreError, match=re.escape("pip install 'physcore[hdf5]'")):
        pc.export(pc.Scene(GRAINS, pc.CustomForce(never)), tmp_path / "run.h5md", duration=1.0)


EXPORTING = """
import resource, sys
import numpy as np
import physcore as pc
path, limit, duration = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
if limit:
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
dust = pc.Particles(np.random.default_rng(1).normal(size=(2000, 3)))
try:
    pc.export(pc.Scene(dust), path, duration=duration, dt=1.0 / 30.0)
except pc.FileError as error:
    sys.exit(str(error))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""
"""Exports dust for some seconds; it may write so many bytes into a file, if any number is given."""


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_full_disk_leaves_the_old_file(suffix: str, tmp_path: Path, forks: Forks) -> None:
    path = tmp_path / f"run{suffix}"
    pc.export(simulated("springs"), path)
    before = content(tmp_path)
    for limit in (20_000, 150_000):
        status, _, error = forks.run(EXPORTING, path, limit, 1.0)
        if suffix == ".pvd" and limit == 150_000:
            continue  # Each of its files is smaller than that.
        assert status == 1, error
        assert re.search(rf"run{re.escape(suffix)}: cannot be written: .*File too large", error), error
        assert content(tmp_path) == before
        assert not list(tmp_path.rglob("*.tmp"))


def test_a_failure_that_hdf5_does_not_mention_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One write in the middle fails, as on a disk where somebody else makes room in time."""

    class Flaky(io.BytesIO):
        writes = 0

        def write(self, content: Any) -> int:
            self.writes += 1
            if self.writes == 20:
                raise OSError(28, "No space left on device")
            return super().write(content)

    @contextmanager
    def replacing(path: Path) -> Iterator[Flaky]:
        yield Flaky()

    monkeypatch.setattr("physcore.output.h5md.replacing", replacing)
    with pytest.raises(OSError, match="No space left on device"):
        pc.export(simulated("springs"), tmp_path / "run.h5md")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_kill_in_the_middle_leaves_the_old_file(suffix: str, tmp_path: Path, forks: Forks) -> None:
    path = tmp_path / f"run{suffix}"
    pc.export(simulated("springs"), path)
    before = content(tmp_path)
    process = forks.start(EXPORTING, path, 0, 1000.0)
    while not any(
        entry.is_file() and entry.stat().st_size > 0 for entry in set(tmp_path.rglob("*")) if ".tmp" in str(entry)
    ):
        os.kill(process, 0)  # It is there.
        time.sleep(0.02)
    os.kill(process, signal.SIGKILL)
    assert forks.end().returncode == -signal.SIGKILL
    # What the other process has begun is left alone: of HDF5 it has the size of all frames.
    assert {name: (tmp_path / name).read_bytes() for name in before} == before
    READERS[suffix](path)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_memory_does_not_grow_with_the_number_of_frames(suffix: str, tmp_path: Path, forks: Forks) -> None:
    """150 more frames of 2000 particles, 48 bytes each and more as text, take 14 MB where they are kept."""
    most = []
    for duration in (1.0, 6.0):
        _, output, error = forks.run(EXPORTING, tmp_path / f"run{suffix}", 0, duration)
        most.append(int(output or pytest.fail(error)))
    assert most[1] - most[0] < 10_000  # [kB]


@pytest.mark.parametrize("dimension", [2, 3])
def test_rigid_bodies_are_points_with_orientations(dimension, tmp_path):
    """In the order of the scene's bodies; a particle is not turned."""
    spin = 3.0 if dimension == 2 else (0.0, 0.0, 3.0)
    shape = pc.Disc(0.1) if dimension == 2 else pc.Ball(0.1)
    ball = pc.RigidBody(shape, np.full(dimension, 2.0), velocity=1.0, angular_velocity=spin, mass=5.0)
    dust = pc.Particles(np.zeros((1, dimension)), velocities=0.5)
    recording = pc.simulate(pc.Scene(ball, dust), 0.2, fps=10, dt=1e-2)
    half = 0.5 * 3.0 * recording.times
    turned = np.column_stack([np.cos(half), 0.0 * half, 0.0 * half, np.sin(half)])
    pc.export(recording, tmp_path / "run.xyz")
    frames = pytest.importorskip("ase.io").read(tmp_path / "run.xyz", index=":", format="extxyz")
    for frame, quaternion, t in zip(frames, turned, recording.times, strict=True):
        np.testing.assert_allclose(frame.positions[:, :dimension], [[2.0 + t] * dimension, [0.5 * t] * dimension])
        np.testing.assert_allclose(frame.arrays["orientation"], [quaternion[[1, 2, 3, 0]], (0, 0, 0, 1)], atol=1e-14)
        np.testing.assert_allclose(frame.arrays["angular_velocity"], [(0.0, 0.0, 3.0), (0.0, 0.0, 0.0)])
        assert frame.arrays["mass"].tolist() == [5.0, 1.0]
        assert frame.arrays["body"].tolist() == [0, 1]
    pc.export(recording, tmp_path / "run.pvd")
    arrays = poly_data(listed(tmp_path / "run.pvd")[-1][1]).GetPointData()
    assert arrays.GetArray("orientation").GetTuple(0) == pytest.approx(turned[-1], abs=1e-14)
    assert arrays.GetArray("angular_velocity").GetTuple(0) == (0.0, 0.0, 3.0)
    pc.export(recording, tmp_path / "run.h5md")
    with pytest.importorskip("h5py").File(tmp_path / "run.h5md") as file:
        values = file["particles/all/orientation/value"][:]
        assert file["parameters/units"].attrs["angular_velocity"] == "rad s-1"
    np.testing.assert_allclose(values, [[quaternion, (1, 0, 0, 0)] for quaternion in turned], atol=1e-14)
    places = pc.simulate(pc.Scene(ball, dust), 0.2, fps=10, dt=1e-2, channels=("positions",))
    pc.export(places, tmp_path / "places.xyz")
    assert "orientation" not in (tmp_path / "places.xyz").read_text()
