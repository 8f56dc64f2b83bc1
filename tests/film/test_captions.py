"""Headings and notes on one grid, and diagrams of curves that a function computes from a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from physcore._core import text_width
from physcore.film import DARK, Window
from physcore.film.film_renderer import FilmRenderer
from physcore.film.labels.curves import check_inset
from physcore.film.labels.heading import Heading, check_heading
from physcore.film.labels.text import broken
from physcore.film.layout import FORMATS, Layout
from physcore.simulation.sources import sources

AWAY = Window((50.0, 50.0), (51.0, 51.0))
"""A view without the bodies."""


@pytest.fixture(scope="module")
def stone() -> pc.Recording:
    """A falling stone for a second: its speed is g t."""
    return pc.simulate(pc.Scene(pc.Particles([[0.0, 0.0]]), pc.Gravity((0.0, -10.0))), 1.0, fps=10, progress=False)


def speed(recording: pc.Recording) -> Any:
    return np.linalg.norm(recording.velocities[:, 0], axis=1)


def film_of(recording: Any, size: tuple[int, int] = (640, 480), **options: Any) -> FilmRenderer:
    found = sources(recording, None, None, {})
    heading = options.pop("heading", Heading())
    return FilmRenderer(found, size, pc.styles.Points("body"), AWAY, DARK, heading, False, **options)


@given(st.text(alphabet="abc d", max_size=80), st.integers(60, 400))
def test_long_lines_are_broken_at_words_into_as_few_lines_as_fit(line: str, width: int) -> None:
    lines, greedy = broken(line, 16, width), list[str]()
    for word in line.split():
        longer = f"{greedy[-1]} {word}" if greedy else word
        greedy = [*greedy[:-1], longer] if greedy and text_width(longer, 16) <= width else [*greedy, word]
    assert " ".join(lines).split() == line.split()
    assert len(lines) <= len(greedy)  # which is the least number
    assert all(text_width(each, 16) <= width or " " not in each for each in lines)


@pytest.mark.parametrize("size", [*FORMATS.values(), (480, 360)])
@pytest.mark.parametrize("panels", [1, 2, 3])
def test_lines_of_a_heading_lie_below_one_another_on_two_edges(size: tuple[int, int], panels: int) -> None:
    """All lines begin at the left edge of the picture or of their panel, or end at the right one, and none overlap."""
    titles = ["one", "two", "three"][:panels] if panels > 1 else None
    heading = check_heading("Title", titles, "A line of what one sees in it, which is long", panels, formula="F = m a")
    layout = Layout(size, panels, heading, panels)
    margin, lines = layout.text // 2, layout.written(range(panels))
    edges = {layout.panel(index)[0] + margin for index in range(panels)}
    boxes = []
    for line in lines:
        width = text_width(line.text, line.height)
        left = line.left if line.align < 0 else line.left - width
        assert line.left in (edges if line.align < 0 else {size[0] - margin})
        assert 0 <= left <= left + width <= size[0]
        boxes.append((left, line.top, left + width, line.top + line.height))
    for index, one in enumerate(boxes):
        assert one[3] <= layout.area(0)[1]
        for other in boxes[:index]:
            assert one[0] >= other[2] or other[0] >= one[2] or one[1] >= other[3] or other[1] >= one[3]


def test_a_title_stands_above_the_titles_of_the_panels(stone: pc.Recording, tmp_path: Path) -> None:
    layout = Layout((640, 360), 2, check_heading("Both", ["one", "two"], None, 2), 2)
    tops = {line.text: line.top for line in layout.written([0, 1])}
    assert tops["Both"] < tops["one"] == tops["two"]
    pc.film([stone, stone], tmp_path / "film.png", size=(320, 240), title="Both", titles=["one", "two"])


def test_figure_and_credit_share_the_last_line_where_there_is_room(stone: pc.Recording) -> None:
    heights = []
    for figure, credit in (("", ""), ("g = 9.81", ""), ("g = 9.81", "by me"), (20 * "long ", "by me")):
        with film_of(stone, figure=figure, credit=credit) as made:
            heights.append(made._layout.footer)
            picture = next(iter(made.frames())).pixels()[-made._layout.text :]
        ink = (np.abs(picture.astype(int) - DARK.label).max(axis=2) < 12).any(axis=0)
        if figure and credit and len(figure) < 20:
            assert ink[: len(ink) // 3].any()
            assert ink[-len(ink) // 3 :].any()
            assert not ink[len(ink) // 3 : -len(ink) // 3].any()
    assert heights[0] < heights[1] == heights[2] < heights[3]


@pytest.mark.parametrize("size", [(320, 240), (640, 480)])
def test_a_curve_is_drawn_up_to_the_frame(stone: pc.Recording, size: tuple[int, int]) -> None:
    """v = g t is a straight line, exact but for the rounding of a sum of steps, 1e-13 of its height."""
    with film_of(stone, size, inset=pc.Curve(speed, "speed", unit="m/s")) as made:
        (diagram,) = made._panels[0].diagrams
        pictures = [canvas.pixels().astype(int) for canvas in made.frames()]
    line = diagram._lines[0]
    np.testing.assert_allclose(
        (line[0, 1] - line[:, 1]) / (line[0, 1] - line[-1, 1]), np.linspace(0.0, 1.0, 11), atol=1e-12
    )
    np.testing.assert_allclose(np.diff(line[:, 0]), (line[-1, 0] - line[0, 0]) / 10.0, rtol=1e-9)
    for frame, picture in enumerate(pictures):
        for index, (x, y) in enumerate(line):
            near = picture[int(y) - 1 : int(y) + 2, int(x) - 1 : int(x) + 2].reshape(-1, 3)
            if index <= frame or abs(x - line[frame, 0]) > 8.0:
                assert (np.abs(near - np.array(DARK.bodies[0])).sum(axis=1).min() < 90) == (index <= frame)


def test_a_spectrum_is_drawn_anew_in_each_frame(stone: pc.Recording) -> None:
    """Frame f shows x^f: its values at x = 1 are all 1, and at x = 1/2 halve from frame to frame."""
    places = np.linspace(0.0, 1.0, 21)
    curve = pc.Curve(
        lambda recording: [places**power for power in range(len(recording.times))], against=places, axis="x"
    )
    with film_of(stone, inset=curve) as made:
        lines = made._panels[0].diagrams[0]._lines
    assert len(lines) == len(stone.times)
    height = lines[1][0, 1] - lines[1][-1, 1]
    for power, line in enumerate(lines):
        risen = (lines[1][0, 1] - line[:, 1]) / height
        assert risen[-1] == pytest.approx(1.0)
        assert risen[10] == pytest.approx(0.5**power, abs=1e-12)


def test_a_logarithmic_axis_has_whole_decades_and_leaves_out_zero(stone: pc.Recording) -> None:
    """An exponential growth is a straight line; its first value is zero, and is not drawn."""

    def grown(recording: pc.Recording) -> np.ndarray:
        return np.where(recording.times > 0.0, 3.0 * 10.0 ** (-5.0 * recording.times), 0.0)

    with film_of(stone, inset=pc.Curve(grown, "δ", logarithmic=True)) as made:
        (diagram,) = made._panels[0].diagrams
        pictures = list(made.frames())
    assert len(pictures) == len(stone.times)
    assert diagram._graph.ends == ("10⁻⁵", "1")  # from 3 · 10⁻⁵ to 0.95
    line = diagram._lines[0]
    assert np.isnan(line[0, 1])
    np.testing.assert_allclose(np.diff(line[1:], 2, axis=0), 0.0, atol=1e-9)


def test_several_diagrams_do_not_overlap_and_panels_share_an_axis(stone: pc.Recording) -> None:
    fast = pc.simulate(pc.Scene(pc.Particles([[0.0, 0.0]]), pc.Gravity((0.0, -20.0))), 1.0, fps=10, progress=False)
    both = pc.Curve(lambda recording: {"v": speed(recording), "−v": -speed(recording)}, "speed")
    with film_of([stone, fast], (1600, 600), inset=[both, "energy"]) as made:
        for panel in made._panels:
            boxes = [diagram.box for diagram in panel.diagrams]
            assert len(boxes) == 2
            for index, one in enumerate(boxes):
                for other in boxes[:index]:
                    assert one[0] >= other[2] or other[0] >= one[2] or one[1] >= other[3] or other[1] >= one[3]
        ends = [panel.diagrams[0]._lines[0][-1, 1] for panel in made._panels]
        middle = made._panels[0].diagrams[0]._lines[0][0, 1]
    assert ends[1] - middle == pytest.approx(2.0 * (ends[0] - middle))


@pytest.mark.parametrize(
    ("inset", "message"),
    [
        (pc.Curve(lambda r: speed(r)[1:]), r"inset\.function: .*each frame, shape \(11,\), got \(10,\); np\.gradient"),
        (pc.Curve(lambda r: r.velocities[:, 0]), r"inset\.function: .*got \(11, 2\); take one column"),
        (pc.Curve(speed, against=[1.0, 2.0]), r"each abscissa of `against`, shape \(11, 2\), got \(11,\)"),
        (["energy", pc.Curve(lambda _: {"a": [1.0]})], r"inset\[1\]\.function\['a'\]: must return one value"),
        (pc.Curve(lambda _: {}), "got an empty mapping"),
        (pc.Curve(lambda r: r.nothing), r"inset\.function: the function raised AttributeError"),
        (pc.Curve(lambda r: np.full(len(r.times), np.nan)), r"inset\.function\[0\]: must be finite"),
        (pc.Curve(lambda r: 0.0 * r.times, logarithmic=True), "must return a positive value for a logarithmic axis"),
        (["energy"] * 5, "inset: must be at most 4 diagrams"),
        (["energy", 3], r"inset\[1\]: must be 'energy', a Curve"),
    ],
)
def test_curves_that_do_not_fit_are_refused(inset: Any, message: str, stone: pc.Recording, tmp_path: Path) -> None:
    with pytest.raises(pc.SceneError, match=message):
        pc.film(stone, tmp_path / "film.png", inset=inset)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"function": 3}, "Curve.function: must be a function of the recording"),
        ({"function": lambda: 1.0}, "Curve.function: a function of"),
        ({"function": speed, "against": [2.0, 1.0]}, "Curve.against: must be two or more ascending numbers"),
        ({"function": speed, "against": [1.0]}, "Curve.against: must be two or more ascending numbers"),
        ({"function": speed, "label": 3}, "Curve.label: must be a string"),
        ({"function": speed, "logarithmic": 1}, "Curve.logarithmic: must be"),
    ],
)
def test_curves_of_wrong_arguments_are_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(pc.SceneError, match=message):
        pc.Curve(**arguments)


def test_a_curve_needs_a_recording_and_a_panel_with_room(stone: pc.Recording, tmp_path: Path) -> None:
    curve = pc.Curve(speed)
    with pytest.raises(pc.SceneError, match=r"film what simulate\(…\) gives instead of a scene"):
        pc.film(stone.scene, tmp_path / "film.png", duration=0.1, inset=curve)
    with pytest.raises(pc.SceneError, match=r"film what simulate\(…\) gives instead of a scene"):
        pc.Renderer(stone.scene, inset=curve)
    with pytest.raises(pc.SceneError, match=r"size: a panel with 4 insets needs more than"):
        pc.film(stone, tmp_path / "film.png", size=(320, 180), inset=["energy"] * 4)
    assert len(check_inset([curve] * 4, sources(stone, None, None, {}))) == 4


@pytest.mark.parametrize(("size", "axis"), [((480, 320), 0), ((320, 480), 1)])
def test_the_picture_is_beside_a_curve_or_above_it(stone: pc.Recording, size: tuple[int, int], axis: int) -> None:
    for count in (1, 2 - axis):
        found = sources(stone, None, None, {})
        inset = [pc.Curve(speed, "v")] * count
        with FilmRenderer(
            found, size, pc.styles.Points("body"), None, DARK, Heading("A stone"), False, inset=inset
        ) as made:
            (panel,) = made._panels
            centers, _, _ = panel.view.at(0).project(stone.positions[:, 0])
            assert (centers >= panel.free[:2]).all()
            assert (centers <= panel.free[2:]).all()
            for diagram in panel.diagrams:
                assert diagram.box[axis] >= panel.free[axis + 2]
