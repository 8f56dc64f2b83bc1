"""Several recordings: in rows of panels or one after the other, with bars for their parameters."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from PIL import Image

import physcore as pc
from physcore.film import DARK, Window
from physcore.film.film_renderer import FilmRenderer
from physcore.film.labels.heading import check_heading
from physcore.film.labels.parameters import parameter_bars, scale_of
from physcore.film.layout import Layout, columns_for
from physcore.simulation.sources import sources

SIZE = (480, 360)
WHITE = pc.styles.Points(size=9.0, color="#ffffff")
VIEW = Window((-1.0, -1.0), (1.0, 1.0))


def moving(speed: float, duration: float = 0.2, y: float = 0.0) -> pc.Recording:
    """A particle that moves to the right from the middle, in frames of a tenth of a second."""
    body = pc.Particles([[0.0, y]], velocities=[[speed, 0.0]])
    return pc.simulate(pc.Scene(body), duration, fps=10.0)


def pictures(items: list[pc.Recording], parameters: Any = None, **options: Any) -> list[np.ndarray]:
    found = sources(items, None, None, {})
    heading = check_heading(options.pop("title", None), options.pop("titles", None), None, len(items), parameters)
    with FilmRenderer(found, SIZE, WHITE, VIEW, DARK, heading, False, **{"labels": (), **options}) as made:
        return [canvas.pixels() for canvas in made.frames()]


def centers(picture: np.ndarray, layout: Layout) -> list[tuple[float, float] | None]:
    """The center of what is white in each panel, in fractions of its free area."""
    found = []
    for index in range(layout.panels):
        left, top, right, bottom = layout.area(index)
        rows, columns = np.nonzero((picture[top:bottom, left:right] > 200).all(axis=2))
        middle = ((columns.mean() + 0.5) / (right - left), (rows.mean() + 0.5) / (bottom - top)) if len(rows) else None
        found.append(middle)
    return found


def test_panels_are_in_rows_and_each_shows_its_recording():
    """In the area of a panel a particle at x is at (1 + x)/2 of the shorter side about the middle."""
    picture = pictures([moving(float(speed)) for speed in range(5)], columns=2)[1]
    found = centers(picture, Layout(SIZE, 5, check_heading(None, None, None, 5), 2))
    for speed, place in enumerate(found):
        assert place is not None
        assert place[1] == pytest.approx(0.5, abs=0.02)
        # A panel of 240 × 120 pixels shows two meters in its height, less the margin of 3 % on both sides.
        assert place[0] == pytest.approx(0.5 + 0.1 * speed * (120 * 0.94 / 2) / 240, abs=0.02)


@pytest.mark.parametrize(
    ("panels", "given", "columns"),
    [(1, None, 1), (4, None, 4), (5, None, 3), (9, None, 3), (12, None, 4), (3, 2, 2), (3, 9, 3)],
)
def test_columns_are_as_many_as_rows_or_one_more(panels, given, columns):
    assert columns_for(given, panels) == columns


@pytest.mark.parametrize("columns", [1, 2, 3, 5])
@pytest.mark.parametrize("titles", [None, ["a", "b", "c", "d", "e"]])
def test_panels_fill_the_picture_without_overlap(columns, titles):
    layout = Layout((481, 363), 5, check_heading(None, titles, "below", 5), columns, 20)
    covered = np.zeros((363, 481), dtype=int)
    for index in range(5):
        left, top, right, bottom = layout.panel(index)
        covered[top:bottom, left:right] += 1
        inner = layout.area(index)
        assert left == inner[0] < inner[2] == right
        assert top <= inner[1] < inner[3] <= bottom
    assert covered.max() == 1
    if layout.rows > 1:
        heights = {layout.panel(index)[3] - layout.panel(index)[1] for index in range(5)}
        assert max(heights) - min(heights) <= 1
        assert layout.panel(4)[3] == 363 - 20


def test_a_sequence_shows_one_recording_after_the_other_in_the_whole_picture():
    fast, slow = moving(2.0, 0.3), moving(1.0, 0.1, y=0.5)
    found = pictures([fast, slow], in_turn=True)
    alone = [*pictures([fast]), *pictures([slow])]
    assert len(found) == len(alone) == 6
    for one, other in zip(found, alone, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_sequence_has_the_labels_of_each_recording():
    """Energy errors begin anew, and so do times."""
    scene = pc.Scene(pc.Particles([[0.0, 0.0]], velocities=[[1.0, 0.0]]), pc.Gravity((0.0, -0.1)))
    runs = [pc.simulate(scene, 0.2, fps=10.0, integrator=kind, dt=0.01) for kind in ("PEFRL", "ExplicitEuler")]
    found = pictures(runs, in_turn=True, labels=("time", "integrator", "energy"))
    for index, run in enumerate(runs):
        alone = pictures([run], labels=("time", "integrator", "energy"))
        for one, other in zip(found[3 * index : 3 * index + 3], alone, strict=True):
            np.testing.assert_array_equal(one, other)


def test_a_film_of_a_sequence_has_all_frames(tmp_path):
    film = pc.film([moving(1.0), moving(2.0)], tmp_path / "film.gif", arrangement="sequence", size=(160, 120))
    assert film.frames == 6
    with Image.open(tmp_path / "film.gif") as image:
        assert image.n_frames == 6
    scene = pc.Scene(pc.Particles([[0.0, 0.0]], velocities=[[1.0, 0.0]]))
    film = pc.film(
        [scene, scene], tmp_path / "film.apng", arrangement="sequence", size=(160, 120), duration=0.1, fps=10.0
    )
    assert film.frames == 4


def marks(picture: np.ndarray, top: int) -> list[int]:
    """The middles of what is white in a row of pixels: the mark of the value, and the digits on its right."""
    white = np.flatnonzero((picture[top] > 200).all(axis=1))
    groups = np.split(white, np.flatnonzero(np.diff(white) > 1) + 1)
    return [int(group.mean()) for group in groups]


@pytest.mark.parametrize(
    ("values", "places"),
    [([1.0, 2.0, 4.0, 5.0], [0.0, 0.25, 0.75, 1.0]), ([1.0, 10.0, 100.0], [0.0, 0.5, 1.0]), (["a", "b"], [0.0, 1.0])],
)
def test_the_mark_of_a_bar_is_where_its_value_is(values, places):
    runs, given = [moving(0.0, 0.0, y=-0.5) for _ in values], [{"size": value} for value in values]
    found = pictures(runs, given, in_turn=True)
    heading = check_heading(None, None, None, len(values), given)
    layout = Layout(SIZE, len(values), heading, 1, in_turn=True)
    ((_, (_, top, _)),) = layout.bars(0)
    row = top + round(0.54 * layout.bar_text)
    at = [marks(picture, row)[0] for picture in found]
    first, last = at[0], at[-1]
    assert last - first > 200
    assert [(each - first) / (last - first) for each in at] == pytest.approx(places, abs=0.01)


def test_bars_are_those_of_parameters_with_several_values():
    given = [{"stiffness": 1.0, "dt": 0.1, "kind": "soft"}, {"stiffness": 2.0, "dt": 0.1, "kind": "hard"}]
    bars = parameter_bars(given, 2)
    assert [[(bar.name, bar.text) for bar in each] for each in bars] == [
        [("stiffness", "1"), ("kind", "soft")],
        [("stiffness", "2"), ("kind", "hard")],
    ]
    assert parameter_bars([given[0]], 1) == ((),)
    assert parameter_bars(None, 3) == ()
    assert scale_of([1.0, 2.0, 3.0]) == "linear"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"arrangement": "grid"}, r"^arrangement: must be 'panels' or 'sequence', got 'grid'"),
        ({"columns": 0}, r"^columns: must be ≥ 1, got 0"),
        ({"columns": 1, "labels": ("time", "energy")}, r"^labels: of several rows of panels, must be \('time',\)"),
        ({"parameters": [{"a": 1}]}, r"^parameters: must be a list of mappings .* one for each of the 2 recordings"),
        ({"parameters": [{"a": 1}, {"b": 1}]}, r"^parameters: must be a list of mappings"),
        ({"parameters": {"a": [1, 2]}}, r"^parameters: must be a list of mappings"),
    ],
)
def test_what_is_wrong_is_named(options, message, tmp_path):
    with pytest.raises(pc.SceneError, match=message):
        pc.film([moving(1.0), moving(2.0)], tmp_path / "film.png", **options)


def test_films_of_a_sweep(tmp_path):
    def build(speed, y):
        if speed < 0.0:
            raise ValueError("backward")
        return pc.Scene(pc.Particles([[0.0, y]], velocities=[[speed, 0.0]]))

    table = pc.sweep(build, {"speed": [1.0, 2.0], "y": [0.0, 0.5, 1.0]}, 0.2, fps=10.0, keep=True, progress=False)
    recordings, parameters = [row.recording for row in table], [row.parameters for row in table]
    table.film(tmp_path / "sweep.png", size=SIZE)
    pc.film(recordings, tmp_path / "plain.png", size=SIZE, parameters=parameters, columns=3)
    assert (tmp_path / "sweep.png").read_bytes() == (tmp_path / "plain.png").read_bytes()
    assert table.film(tmp_path / "turn.gif", where={"y": 0.5}, arrangement="sequence", size=(160, 120)).frames == 6
    with pytest.raises(pc.SceneError, match=r"^where\['y'\]: must be one of 0, 0.5, 1, got 0.7"):
        table.film(tmp_path / "no.png", where={"y": 0.7})
    with pytest.raises(pc.SceneError, match=r"^where: must be 'speed' or 'y', got 'x'"):
        table.film(tmp_path / "no.png", where={"x": 0.7})
    partly = pc.sweep(build, {"speed": [1.0, -1.0], "y": [0.0]}, 0.2, keep=True, progress=False)
    partly.film(tmp_path / "partly.png", size=SIZE)
    with pytest.raises(pc.SceneError, match=r"^film: every point failed, the first one with backward"):
        partly.film(tmp_path / "no.png", where={"speed": -1.0})
    with pytest.raises(pc.SceneError, match="recordings are kept by"):
        pc.sweep(build, {"speed": [1.0], "y": [0.0]}, 0.2, measure=len, progress=False).film(tmp_path / "no.png")
