"""Files whose checksum is right say nothing about who wrote them: any wrong content is an error that names it."""

from __future__ import annotations

import errno
import io
import json
import os
import signal
import zipfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import physcore as pc
from physcore.film import provenance
from physcore.film.writers import WRITERS
from physcore.storage import archive, files

LONG = os.environ.get("PHYSCORE_TESTS") == "long"
SCENE = pc.Scene(
    pc.cloth((3, 3), 0.1, 10.0, 0.1, pinned="top", name="cloth"),
    pc.Fluid(pc.block((0.0, -1.0), (0.3, -0.7), 0.1), 0.1),
    pc.Gravity((0.0, -9.81)),
    pc.Floor(-1.1),
    pc.Periodic((-5.0, -np.inf), (5.0, np.inf)),
)


def contents(tmp: Path) -> dict[str, dict[str, Any]]:
    """What a checkpoint and a recording hold."""
    simulation = pc.Simulation(SCENE)
    simulation.step(3)
    simulation.save(tmp / "simulation")
    pc.simulate(SCENE, 0.1, channels=("positions", "densities")).save(tmp / "recording")
    return {kind: archive.read(tmp / kind)[1] for kind in ("simulation", "recording")}


@pytest.fixture(scope="module")
def held(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, dict[str, Any]]]:
    folder = tmp_path_factory.mktemp("files")
    return folder / "changed", contents(folder)


def entries(tree: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The paths of all entries of a tree."""
    children = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    return [path] * bool(path) + [found for key, child in children for found in entries(child, (*path, key))]


def changed(tree: Any, path: tuple[Any, ...], value: Any) -> Any:
    """The same tree with one entry replaced, or left out where the value is ..."""
    if not path:
        return value
    key, *rest = path
    items = dict(tree) if isinstance(tree, dict) else dict(enumerate(tree))
    if not rest and value is ...:
        del items[key]
    else:
        items[key] = changed(items[key], tuple(rest), value)
    return items if isinstance(tree, dict) else list(items.values())


WRONG: list[Any] = [
    ...,
    None,
    -1,
    2**70,
    float("nan"),
    float("inf"),
    "wrong",
    [],
    {},
    [[]],
    {"kind": "Fluid", "fields": {}},
    {"kind": [], "fields": []},
    np.full((2, 2), np.nan),
    np.zeros(0),
    np.zeros((5, 4, 3), dtype=np.int64),
]


@pytest.mark.filterwarnings("ignore::physcore.SceneWarning")
@pytest.mark.filterwarnings("ignore::physcore.MachWarning")
@pytest.mark.parametrize("kind", ["simulation", "recording"])
@pytest.mark.parametrize(
    ("number", "value"),
    [pytest.param(number, value, id=f"{type(value).__name__} {number}") for number, value in enumerate(WRONG)],
)
def test_a_file_with_a_wrong_entry_is_a_file_error_or_another_right_file(held, kind, number, value, monkeypatch):
    """In short, all entries are left out and replaced by None, and every third one by each other value."""
    monkeypatch.setattr(os, "fsync", lambda descriptor: None)  # It takes most of the time.
    path, trees = held
    told: list[str] = []
    share = 1 if LONG or number < 2 else 3
    for place in entries(trees[kind])[number % share :: share]:
        archive.write(path, kind, changed(trees[kind], place, value))
        try:
            loaded = pc.load(path)
        except pc.FileError as error:
            told.append(str(error))
        except Exception as error:
            pytest.fail(f"{place}: {type(error).__name__}: {error}")
        else:
            assert isinstance(loaded, pc.Simulation if kind == "simulation" else pc.Recording)
            assert np.isfinite(loaded.positions).all()
            assert np.isfinite(loaded.time if kind == "simulation" else loaded.times).all(), place
    assert told
    assert all(str(path) in message for message in told)


def audited(loaded: pc.Simulation | pc.Recording) -> list[Any]:
    """Clock, steps, momenta and energies of what was loaded."""
    steps = [(each.start, np.max(each.dt), each.steps * np.max(each.dt)) for each in loaded.provenance.segments]
    if isinstance(loaded, pc.Simulation):
        energy = loaded.energy()
        return [loaded.time, loaded.dt, steps, loaded.momentum(), energy.balance]
    return [loaded.times, loaded.energy.times, steps, loaded.momentum, loaded.energy.balance, loaded.energy.drift]


def test_a_run_that_went_on_in_spite_of_its_divergence_is_read_back(tmp_path):
    """Its energies, some 1e154², are beyond the range of numbers; those of a file without this choice may not be."""
    hill = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), -1e8, exponent=1.0))
    run = pc.Simulation(hill, "ExplicitEuler", 0.01, on_divergence="ignore")
    with pytest.warns(pc.StabilityWarning, match="beyond the range of numbers"), np.errstate(all="ignore"):
        recording = run.record(0.9, 10)
    assert not np.isfinite(recording.energy.kinetic).all()
    recording.save(tmp_path / "wild")
    np.testing.assert_array_equal(pc.load(tmp_path / "wild").energy.kinetic, recording.energy.kinetic)


FORGED = (1e308, -1e308, np.inf, np.nan)


@pytest.mark.filterwarnings("ignore::physcore.SceneWarning")
@pytest.mark.filterwarnings("ignore::physcore.MachWarning")
@pytest.mark.parametrize("kind", ["simulation", "recording"])
@pytest.mark.parametrize("number", FORGED)
def test_a_forged_number_does_not_load_as_an_infinity(held, kind, number, monkeypatch):
    """Every single number, and the first entry of every array."""
    monkeypatch.setattr(os, "fsync", lambda descriptor: None)
    path, trees = held
    for place in entries(trees[kind]):
        before = trees[kind]
        for key in place:
            before = before[key]
        if place[0] == "scene" or isinstance(before, (bool, str, dict, list)) or before is None:
            continue  # A scene is checked as one that is declared.
        after: Any = number
        if isinstance(before, np.ndarray):
            if before.size == 0 or before.dtype.kind != "f":
                continue
            after = before.copy()
            after.flat[0] = number
        archive.write(path, kind, changed(trees[kind], place, after))
        with suppress(pc.FileError):
            assert all(np.isfinite(each).all() for each in audited(pc.load(path))), place


@pytest.mark.parametrize(
    ("kind", "place", "value", "message"),
    [
        ("recording", ("times",), np.full(4, np.nan), "times: must be finite"),
        ("recording", ("times",), np.zeros(7), r"must be an array of the shape \(7"),
        ("recording", ("positions",), ..., "positions: is missing"),
        ("recording", ("fps",), 0.0, "fps: must be a finite number > 0, got 0"),
        ("recording", ("plan", "stages"), "all", "plan.stages: must be a list, got 'all'"),
        ("recording", ("plan", "dt_limit"), "none", "plan.dt_limit: must be a number, got 'none'"),
        ("recording", ("energy", "by_term", "springs"), 3, "energy.by_term.springs: must be an array"),
        ("simulation", ("world", "clock"), np.array([np.nan, 1.0]), "world.clock: must be finite"),
        ("recording", ("times",), np.full(4, 1.0), "times: must be ascending"),
        ("recording", ("energy", "work"), np.array([0.0, 0.0, 0.0, np.inf]), "energy.work: must be finite"),
        ("recording", ("energy", "times"), np.array([0.0, 0.0, 0.0, np.nan]), "energy.times: must be finite"),
        ("recording", ("momentum",), np.full((4, 2), np.inf), "momentum: must be finite"),
        (
            "recording",
            ("provenance", "segments", 0, "start"),
            np.inf,
            r"provenance.segments\[0\].start: must be a finite",
        ),
        ("recording", ("provenance", "segments", 0, "dt"), 1e308, r"provenance.segments\[0\]: must end at a finite"),
        ("simulation", ("world", "clock"), np.array([1e308, 1e308]), "world.clock: must be a time that is finite"),
        ("simulation", ("stepper", "limits", 1, "dt"), -1e308, r"stepper.limits\[1\].dt: must be a number ≥ 0"),
        ("simulation", ("stepper", "limits"), [{}], "stepper.limits: must be a list of 0 or 2"),
        (
            "simulation",
            ("scene", "bodies", 0, "kind"),
            "Gravity",
            r"scene.bodies\[0\].kind: must be one of 'Particles'",
        ),
        ("simulation", ("scene", "bodies", 0, "fields", "mass"), -1.0, r"scene.bodies\[0\]: SpringNetwork.mass"),
        ("simulation", ("scene", "forces", 0, "fields", "on"), [9], r"scene.forces\[0\].on\[0\]: must be a whole"),
        ("simulation", ("numerics", "dt"), "fast", "dt: must be a number of seconds"),
    ],
)
def test_a_wrong_entry_is_named(held, kind, place, value, message):
    path, trees = held
    archive.write(path, kind, changed(trees[kind], place, value))
    with pytest.raises(pc.FileError, match=message):
        pc.load(path)


def test_a_state_of_another_scene_or_version_is_refused_by_the_name_of_an_array(held):
    """Every array of a system is asked for, and none is passed over."""
    path, trees = held
    world = trees["simulation"]["world"]
    names = [name for name in world if "/" in name]
    assert {"matter/positions", "matter/velocities", "matter/tallies"} < set(names)
    assert {"matter/forces/fluid[0]/densities", "matter/forces/fluid[0]/anchors"} < set(names)

    def refused(changes: dict[str, Any]) -> str:
        new = {name: values for name, values in {**world, **changes}.items() if values is not None}
        archive.write(path, "simulation", changed(trees["simulation"], ("world",), new))
        with pytest.raises(pc.FileError) as caught:
            pc.load(path)
        return str(caught.value)

    for name in names:
        assert f"state: {name} is missing; it is of another scene" in refused({name: None})
        longer = np.append(world[name], 0.0)
        assert f"state: {name} has {len(longer)} numbers instead of {len(longer) - 1}" in refused({name: longer})
    assert "state: matter/forces/wind[0]/anchors is unknown" in refused({"matter/forces/wind[0]/anchors": np.zeros(3)})
    old = {"system": np.concatenate([world[name] for name in names]), "tallies": world["matter/tallies"]}
    assert "state: matter/positions is missing" in refused({**dict.fromkeys(names), **old})


def test_a_state_that_the_precision_of_its_run_cannot_hold_is_refused(tmp_path):
    dust = pc.Particles([[0.0, 0.0], [1.0, 1.0]])
    pc.Simulation(pc.Scene(dust), dt=1e-3, precision="f32").save(tmp_path / "state")
    kind, tree = archive.read(tmp_path / "state")
    far = changed(tree, ("scene", "bodies", 0, "fields", "positions"), 1e300 * (1.0 + dust.positions))
    archive.write(tmp_path / "state", kind, far)
    with pytest.raises(pc.FileError, match="state: "):
        pc.load(tmp_path / "state")


def signed(content: bytes) -> bytes:
    """An archive with the trailer that `archive` would have written; it has to have a comment of that length."""
    size = len(content) - archive._TRAILER_SIZE
    return content[:size] + archive._trailer(archive._digest(io.BytesIO(content), size))


def packed(members: dict[str, bytes], compression: int = zipfile.ZIP_STORED) -> bytes:
    """An archive of some members with a right checksum."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", compression) as zipped:
        for name, content in members.items():
            zipped.writestr(name, content)
        zipped.comment = archive._trailer("0" * 64)
    return signed(buffer.getvalue())


@pytest.mark.parametrize(
    ("members", "message"),
    [
        ({}, "header.json"),
        ({"header.json": b"[]"}, "must have a kind and a content"),
        ({"header.json": b'{"kind": 1, "content": {}}'}, "must have a kind and a content"),
        ({"header.json": b'{"kind": "film", "content": {}}'}, "kind: must be one of 'simulation', 'recording'"),
        ({"header.json": b"[" * 100_000 + b"]" * 100_000}, "nested too deeply"),
        ({"header.json": b'{"kind": "recording", "content": {"x": ' + b"[" * 990 + b"]" * 990 + b"}}"}, "damaged|wn"),
        ({"header.json": b"\xff\xfe"}, "is damaged"),
        ({"header.json": b'{"kind": "recording", "content": {"x": {"$array": ["y"]}}}'}, "has no array"),
        ({"header.json": b'{"kind": "recording", "content": {"x": {"$array": "y"}}}'}, "has no array 'y'"),
    ],
)  # fmt: skip
def test_an_archive_that_physcore_did_not_write_is_refused(tmp_path, members, message):
    (tmp_path / "file").write_bytes(packed(members))
    with pytest.raises(pc.FileError, match=message):
        pc.load(tmp_path / "file")


@pytest.mark.parametrize(
    ("header", "data"),
    [
        ("{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }", b""),
        ("{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }", b"\0" * 8),
        ("{'descr': '|O', 'fortran_order': False, 'shape': (1,), }", b"\0" * 8),
        ("{'descr': '<f8', 'fortran_order': False, 'shape': ((((1)))), }", b"\0" * 8),
        ("{'descr': '<f8', 'fortran_order': False, 'shape': (" + "0," * 90 + "), }", b""),
        ("__import__('os')", b""),
    ],
)
def test_an_array_that_is_not_what_its_header_says_is_refused(tmp_path, header, data):
    text = header.encode() + b"\n"
    array = b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + data
    tree = b'{"kind": "recording", "content": {"times": {"$array": "times"}}}'
    (tmp_path / "file").write_bytes(packed({"header.json": tree, "times.npy": array}))
    with pytest.raises(pc.FileError, match="is damaged: 'times'"):
        pc.load(tmp_path / "file")


def test_compressed_members_are_refused_before_they_are_read(tmp_path):
    """A hundred megabytes of blanks, in a hundred kilobytes: reading them would take seconds and all that memory."""
    import tracemalloc

    (tmp_path / "file").write_bytes(packed({"header.json": b" " * 10**8}, zipfile.ZIP_DEFLATED))
    tracemalloc.start()
    with pytest.raises(pc.FileError, match=r"'header\.json' is compressed"):
        pc.load(tmp_path / "file")
    assert tracemalloc.get_traced_memory()[1] < 10**7
    tracemalloc.stop()


@given(data=st.data())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_bytes_with_a_right_checksum_are_a_file_error_or_a_valid_object(held, data):
    """Some bytes of a right file changed: in its arrays, its header or its directory."""
    path, trees = held
    kind = data.draw(st.sampled_from(sorted(trees)))
    archive.write(path, kind, trees[kind])
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 8))):
        where = data.draw(st.integers(0, 3000)) - 3000 * data.draw(st.booleans())
        content[where % len(content)] = data.draw(st.integers(0, 255))
    with zipfile.ZipFile(path):
        pass
    path.write_bytes(signed(bytes(content)))
    with suppress(pc.FileError):
        assert np.isfinite(pc.load(path).positions).all()


LEAVES = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5)
NAMES = st.sampled_from(["kind", "fields", "scene", "world", "bodies", "times", "channels"])


@given(
    tree=st.recursive(LEAVES, lambda t: st.lists(t, max_size=3) | st.dictionaries(NAMES, t, max_size=4), max_leaves=10)
)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_tree_is_a_file_error(held, tree):
    path, _ = held
    for kind in ("simulation", "recording"):
        path.write_bytes(packed({"header.json": json.dumps({"kind": kind, "content": tree}).encode()}))
        with pytest.raises(pc.FileError):
            pc.load(path)


@pytest.mark.parametrize("value", [1, 0, None, b"name", True, 3.0, "a\0b", "\ud800", ["name"]], ids=ascii)
def test_only_names_of_files_are_loaded(value):
    """A number would be taken for an open file, and closed."""
    with pytest.raises(pc.SceneError, match="path: must be"):
        pc.load(value)
    os.fstat(1)


def test_names_that_are_no_text_of_unicode_are_names_of_files(tmp_path):
    name = os.fsdecode(os.fsencode(tmp_path) + b"/\xff")
    pc.Simulation(SCENE).save(name)
    assert isinstance(pc.load(name), pc.Simulation)


@pytest.mark.parametrize("kind", [each for each in WRITERS if each.missing() is None])
def test_a_damaged_film_says_nothing_but_a_file_error(kind, tmp_path):
    path = tmp_path / f"film{kind.suffixes[0]}"
    pc.film(pc.simulate(SCENE, 0.1), path, size=(64, 48), sidecar=False)
    whole, generator = path.read_bytes(), np.random.default_rng(1)
    assert provenance(path)
    for _ in range(60):
        content = bytearray(whole)
        for place in generator.integers(len(whole), size=30).tolist():
            content[place] = int(generator.integers(256))
        path.write_bytes(bytes(content[: int(generator.integers(len(whole)))]))
        with suppress(pc.FileError):
            provenance(path)


@pytest.mark.parametrize("text", ["[" * 100_000, "3", "[3]", '{"a": 1}', "nothing", "\xff"])
def test_provenance_that_is_none_is_refused(text, tmp_path):
    path = tmp_path / "film.gif.json"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(pc.FileError, match=r"film\.gif\.json"):
        provenance(path)


@pytest.mark.parametrize(
    "content", [b"", b"GIF89a", b"\x89PNG\r\n\x1a\n" + b"\0" * 40, b"P6 100000 100000 255\n", b"BM" + b"\xff" * 60]
)
def test_a_texture_that_is_no_picture_is_a_file_error(content, tmp_path):
    (tmp_path / "picture.png").write_bytes(content)
    with pytest.raises(pc.FileError, match=r"Surface\.texture: .*picture\.png"):
        pc.styles.Surface(texture=tmp_path / "picture.png")


KILLED = """
import os, signal, sys
import physcore as pc
from physcore.film import Window
from physcore.storage.files import replacing

def end(time, x, v):
    if time > 0.4:
        os.kill(os.getpid(), signal.SIGKILL)
    return 0.0 * x

scene = pc.Scene(pc.Particles([[0.0, 0.0], [1.0, 1.0]]), pc.CustomForce(end))
action, path = sys.argv[1:]
if action == "save":
    with replacing(path) as file:
        file.write(b"half")
        os.kill(os.getpid(), signal.SIGKILL)
elif action == "film":
    camera, style = Window((0.0, 0.0), (1.0, 1.0)), pc.styles.Points(color="body")
    pc.film(scene, path, duration=0.5, dt=0.01, size=(64, 48), camera=camera, style=style)
else:
    pc.export(scene, path, duration=0.5, dt=0.01)
"""


TARGETS = [("save", "state"), ("film", "film.gif"), ("film", "film.webp"), ("export", "run.xyz"), ("export", "run.pvd")]


@pytest.mark.parametrize(("action", "name"), TARGETS)
def test_what_a_killed_writer_left_is_swept_by_the_next_one(action, name, tmp_path, forks):
    path = tmp_path / name
    done = forks.run(KILLED, action, path)
    assert done.returncode == -signal.SIGKILL, done.stderr
    assert any(".tmp" in str(left) for left in tmp_path.rglob("*"))
    recording = pc.simulate(pc.Scene(pc.Particles([[0.0, 0.0]])), 0.1)
    match action:
        case "save":
            recording.save(path)
        case "film":
            pc.film(recording, path, size=(64, 48), sidecar=False)
        case _:
            pc.export(recording, path)
    assert not [left for left in tmp_path.rglob("*") if ".tmp" in str(left)]


def test_what_a_living_writer_writes_is_left_alone(tmp_path):
    path = tmp_path / "state"
    with files.replacing(path) as first:
        first.write(b"first")
        with files.replacing(path) as second:
            second.write(b"second")
        assert path.read_bytes() == b"second"
        (tmp_path / ".state.notes.tmp").write_text("of somebody else")
        (tmp_path / ".other.01234567.tmp").write_text("of another target")
    assert path.read_bytes() == b"first"
    assert len(list(tmp_path.iterdir())) == 3


def test_a_link_to_itself_is_refused(tmp_path):
    link = tmp_path / "link.gif"
    link.symlink_to(link)
    recording = pc.simulate(SCENE, 0.0)
    for action in (recording.save, lambda path: pc.film(recording, path), files.require_writable):
        with pytest.raises(pc.FileError, match="cannot be written: a link that leads to itself"):
            action(link)
    assert link.is_symlink()
    with pytest.raises(pc.FileError, match="cannot be read"):
        pc.load(link)


def test_a_target_that_cannot_be_written_is_refused_before_the_work(tmp_path, monkeypatch):
    monkeypatch.setattr(pc.Simulation, "__init__", lambda *arguments, **options: pytest.fail("simulated"))
    (tmp_path / "folder.gif").mkdir()
    (tmp_path / "film.gif.json").mkdir()
    (tmp_path / "folder.xyz").mkdir()
    for target in ("folder.gif", "missing/film.gif", "film.gif", "n" * 300 + ".gif"):
        with pytest.raises(pc.FileError, match="cannot be written"):
            pc.film(SCENE, tmp_path / target, duration=1.0, sidecar=True)
    for target in ("folder.xyz", "missing/run.xyz"):
        with pytest.raises(pc.FileError, match="cannot be written"):
            pc.export(SCENE, tmp_path / target, duration=1.0)
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["film.gif.json", "folder.gif", "folder.xyz"]


def test_a_disk_that_says_no_is_found_before_the_work(tmp_path, monkeypatch):
    real = os.open

    def refuse(path: Any, *arguments: Any, **options: Any) -> int:
        if ".tmp" in str(path):
            raise OSError(errno.EROFS, "Read-only file system")
        return real(path, *arguments, **options)

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(pc.FileError, match=r"film\.gif: cannot be written: Read-only file system"):
        pc.film(SCENE, tmp_path / "film.gif", duration=1e9)
