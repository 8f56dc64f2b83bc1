"""Grids: geometry, fields, masks and edges, whatever they are given as."""

from __future__ import annotations

import copy
import pickle
from functools import partial

import numpy as np
import pytest

import physcore as pc
from physcore.scene.by_value import ByValue

WORDS = ("fixed", "free", "absorbing")


def test_values_lie_at_the_centers_of_cells():
    grid = pc.Grid((3, 2), 0.5, origin=(1.0, -1.0))
    assert grid.centers.shape == (3, 2, 2)
    np.testing.assert_array_equal(grid.centers[2, 1], (2.25, -0.25))
    x, y = grid.coordinates
    assert x.shape == y.shape == (3, 2)
    assert (grid.upper, grid.size, grid.dimension) == ((2.5, 0.0), 6, 2)
    line = pc.Grid(4, 0.25)
    assert line == pc.Grid((4,), 0.25, origin=0.0, periodic=False)
    np.testing.assert_array_equal(line.centers, [[0.125], [0.375], [0.625], [0.875]])


def test_a_grid_covers_a_box():
    grid = pc.Grid.over((-1.0, 0.0, 2.0), (1.0, 0.74, 3.0), 0.25, periodic=(True, False, False))
    assert grid == pc.Grid((8, 3, 4), 0.25, (-1.0, 0.0, 2.0), (True, False, False))
    assert pc.Grid.over(0.0, 1.0, 0.1) == pc.Grid(10, 0.1)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: pc.Grid((3, 2, 1, 1), 1.0), r"Grid\.cells: must be 1, 2 or 3 numbers"),
        (lambda: pc.Grid((3, 0), 1.0), r"Grid\.cells\[1\]: must be ≥ 1, got 0"),
        (lambda: pc.Grid((3.5,), 1.0), r"Grid\.cells\[0\]: must be a whole number"),
        (lambda: pc.Grid((3, 2), 0.0), r"Grid\.spacing: must be > 0"),
        (lambda: pc.Grid((3, 2), 1.0, origin=(0.0,)), r"Grid\.origin: must be one value, or 2, one for each axis"),
        (lambda: pc.Grid((3, 2), 1.0, periodic=(True, 1)), r"Grid\.periodic\[1\]: must be True or False"),
        (lambda: pc.Grid((10**6, 10**6), 1.0), r"Grid\.cells: .* cells take .* GB"),
        (lambda: pc.Grid.over((0.0, 0.0), (1.0,), 0.1), r"Grid\.upper: must have as many numbers"),
        (lambda: pc.Grid.over((0.0, 0.0), (1.0, 0.04), 0.1), r"Grid\.upper\[1\]: must be 1 to"),
    ],
)
def test_what_is_no_grid_is_refused_with_its_path(call, message):
    with pytest.raises(pc.SceneError, match=message):
        call()


def test_a_field_is_a_number_an_array_or_a_function():
    grid = pc.Grid((3, 2), 1.0)
    x, y = grid.coordinates
    expected = x + 10.0 * y
    np.testing.assert_array_equal(grid.field(2, "f"), np.full((3, 2), 2.0))
    np.testing.assert_array_equal(grid.field(expected.tolist(), "f"), expected)
    np.testing.assert_array_equal(grid.field(lambda x, y: x + 10.0 * y, "f"), expected)
    np.testing.assert_array_equal(grid.field(lambda x, y: 3, "f"), np.full((3, 2), 3.0))
    np.testing.assert_array_equal(grid.field(lambda x, y: y[:1], "f"), y)
    mask = grid.mask(lambda x, y: x > 1.0, "m")
    assert mask.tolist() == [[False, False], [True, True], [True, True]]
    assert isinstance(grid.uniform_or_field(2, "f"), float)
    given = np.zeros((3, 2))
    field = grid.uniform_or_field(given, "f")
    given[0, 0] = 1.0
    assert isinstance(field, np.ndarray)
    assert not field.any(), "an array is copied"
    with pytest.raises(ValueError, match="read-only"):
        field[0, 0] = 1.0


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (np.zeros((2, 3)), r"f: must be a number, a function or an array of the shape \(3, 2\) .* \(2, 3\)"),
        (np.zeros((3, 1)), r"f: must be a number, a function or an array of the shape \(3, 2\)"),
        (lambda x, y: np.zeros(2), r"f: the function must give an array of the shape \(3, 2\)"),
        (lambda x: x, r"f: the function raised TypeError"),
        (lambda x, y: 1j * x, r"f: must be an array of real numbers, .* complex"),
        (lambda x, y: np.log(x - 0.5), r"f\[0, 0\]: must be finite, got -inf"),
        ("high", r"f: must be an array of real numbers"),
    ],
)
@pytest.mark.filterwarnings("ignore:divide by zero")
def test_what_is_no_field_is_refused_with_its_path(value, message):
    with pytest.raises(pc.SceneError, match=message):
        pc.Grid((3, 2), 1.0).field(value, "f")


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("free", ("free",) * 4),
        ({}, ("fixed",) * 4),
        ({"y": "free", "y+": "absorbing"}, ("fixed", "fixed", "free", "absorbing")),
        ({"y+": "absorbing", "y": "free"}, ("fixed", "fixed", "free", "absorbing")),
        (("free", "fixed", "fixed", "free"), ("free", "fixed", "fixed", "free")),
        (pc.Absorbing(), ("absorbing",) * 4),
    ],
)
def test_edges_become_a_word_for_each_side(value, expected):
    assert pc.Grid((3, 2), 1.0).edges(value, "edges", WORDS, "fixed")[0] == expected


def test_a_periodic_axis_has_no_edge():
    grid = pc.Grid((3, 2), 1.0, periodic=(False, True))
    assert grid.edges("free", "edges", WORDS, "fixed")[0] == ("free", "free", "periodic", "periodic")
    with pytest.raises(pc.SceneError, match=r"edges\['y'\]: the grid is periodic there"):
        grid.edges({"y": "free"}, "edges", WORDS, "fixed")
    sides = ("free", "fixed", "periodic", "periodic")
    assert grid.edges(sides, "edges", WORDS, "fixed")[0] == sides
    with pytest.raises(pc.SceneError, match=r"edges\['y\+'\]: the grid is periodic there"):
        grid.edges(("free", "free", "periodic", pc.Dirichlet(1.0)), "edges", WORDS, "fixed", valued=True)
    with pytest.raises(pc.SceneError, match=r"all absorbing edges must have one kind of layer"):
        grid.edges({"x-": pc.Absorbing(10), "x+": pc.Absorbing(20)}, "edges", WORDS, "fixed")


@pytest.mark.parametrize(
    ("condition", "kept"),
    [
        (pc.Dirichlet(1.0), pc.Dirichlet(1.0)),
        (pc.Neumann(0.5), pc.Neumann(0.5)),
        (pc.Absorbing(8), "absorbing"),
        ("absorbing", "absorbing"),
    ],
)
def test_a_condition_at_edges_needs_an_edge(condition, kept):
    """On an axis that is not periodic it is kept; on a grid without edges it would be dropped."""
    partly, closed = (pc.Grid((3, 2), 1.0, periodic=axes) for axes in ((True, False), True))
    assert pc.Wave(partly, 1.0, edges=condition).edges == ("periodic", "periodic", kept, kept)
    assert pc.Wave(closed, 1.0, edges="free").edges == ("periodic",) * 4
    with pytest.raises(pc.SceneError, match=r"^Wave\.edges: the grid is periodic along all axes"):
        pc.Wave(closed, 1.0, edges=condition)
    with pytest.raises(pc.SceneError, match=r"^Wave\.edges\['x-'\]: the grid is periodic there"):
        pc.Wave(pc.Grid(50, 0.02, periodic=True), 1.0, edges=(condition, condition))


@pytest.mark.parametrize("kind", [pc.Wave, pc.Schrodinger])
def test_an_absorbing_layer_needs_an_absorbing_edge(kind):
    system, layer = partial(kind, pc.Grid((3, 2), 1.0), 1.0), pc.Absorbing(12)
    assert system(edges={"x": "absorbing"}, absorbing=layer).absorbing == layer
    assert system(edges={"x": layer}).absorbing == layer
    with pytest.raises(pc.SceneError, match=r'absorbing: no edge is absorbing; give edges="absorbing"'):
        system(absorbing=layer)
    with pytest.raises(pc.SceneError, match=r"absorbing: edges have Absorbing\(cells=12"):
        system(edges=layer, absorbing=pc.Absorbing(13))
    with pytest.raises(pc.SceneError, match=r"absorbing: must be Absorbing\(…\), got 12"):
        system(absorbing=12)


def test_items_with_arrays_are_short_as_text():
    """Of every class that is compared by value, also of those to come."""
    field = np.full((20, 20), 0.5)

    def classes(base):
        return [base, *(each for child in base.__subclasses__() for each in classes(child))]

    assert all(each.__repr__ is ByValue.__repr__ for each in classes(ByValue))
    assert repr(pc.GrayScott(feed=field, kill=0.06)) == "GrayScott(feed=array (20, 20), kill=0.06)"
    assert repr(pc.Dirichlet(np.ones(300))) == "Dirichlet(value=array (300,))"
    assert repr(pc.Neumann(2.0)) == "Neumann(gradient=2.0)"
    assert repr(pc.Brusselator(1.0, field)) == "Brusselator(a=1.0, b=array (20, 20))"


def test_a_wave_is_the_same_after_files_copies_and_pickles(tmp_path):
    """And its arrays are still read-only, because it stays a key."""
    wave = pc.Wave(
        pc.Grid((6, 5), 0.2, periodic=(True, False)),
        lambda x, y: 1.0 + x,
        rate=np.ones((6, 5)),
        edges={"y-": pc.Absorbing(7, 1e-3), "y+": "free"},
        walls=lambda x, y: x > 1.1,
        sources=[pc.Source((0.3, 0.4), 1.0, signal=pc.Ricker(1.0)), pc.Source(np.eye(6, 5), 2.0, 1.0, stop=3.0)],
        name="pond",
    )
    scene = pc.Scene(wave)
    run = pc.Simulation(scene, dt=0.01)
    run.save(tmp_path / "run")
    loaded = pc.load(tmp_path / "run").scene
    for other in (loaded, pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene)):
        assert other.hash() == scene.hash()
        assert not other.systems[0].speed.flags.writeable
    assert loaded.systems[0].absorbing == pc.Absorbing(7, 1e-3)
    with pytest.raises(
        pc.FileError, match=r"systems\[0\]\.sources\[0\]\.signal: a Wave cannot be saved, because this function"
    ):
        pc.Scene(pc.Wave(wave.grid, 1.0, sources=pc.Source((0.3, 0.4), 1.0, signal=lambda t: 0.0))).hash()


def test_systems_on_equal_grids_are_told_apart():
    """They are keys of results, as bodies are."""
    grid = pc.Grid(8, 0.1)
    one, other = (pc.Wave(grid, 1.0, displacement=height) for height in (0.1, 0.2))
    assert one != other
    assert len({one, other}) == 2
    run = pc.Simulation(pc.Scene(one, other), dt=0.01)
    assert (run[one].displacement == 0.1).all()
    assert (run[other].displacement == 0.2).all()
