"""What is written over the picture and below it: names of bodies, and a scale bar."""

from __future__ import annotations

import unicodedata
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

import physcore as pc
from physcore.film import DARK, Orbit, Window
from physcore.film.film_renderer import FilmRenderer
from physcore.film.labels.heading import Heading
from physcore.film.labels.scale_bar import UNITS, ScaleBar, rounded
from physcore.simulation.sources import sources

if TYPE_CHECKING:
    from physcore.film.labels.scale_bar import LengthUnit

SIZE = (320, 240)
BODY = pc.styles.Points("body")
COLORS = {"sun": (250, 200, 10), "earth": (20, 90, 250), "moon": (120, 220, 130)}


def renderer(scene: pc.Scene, **options: Any) -> FilmRenderer:
    """That of a film of a tenth of a second."""
    found = sources(pc.simulate(scene, 0.1, progress=False), None, None, {})
    style, camera = options.pop("style", BODY), options.pop("camera", None)
    return FilmRenderer(found, SIZE, style, camera, DARK, options.pop("heading", Heading()), False, **options)


def system(dimension: int = 2) -> pc.Scene:
    """Three bodies in a row, and one without a name."""
    places = np.eye(4, dimension) + np.arange(4)[:, np.newaxis]
    names = (*COLORS, None)
    return pc.Scene(*(pc.Particles([place], name=name) for place, name in zip(places, names, strict=True)))


def count(picture: np.ndarray, color: tuple[int, int, int]) -> int:
    """How many pixels of a picture have nearly a color."""
    return int((np.abs(picture.astype(int) - color).max(axis=2) < 12).sum())


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_legend_lists_the_named_bodies_in_their_colors(dimension: int) -> None:
    style = pc.styles.Points(dict(COLORS), size=1.0)
    for asked, listed in ((True, set(COLORS)), (("sun", "moon"), {"sun", "moon"}), (False, set())):
        with renderer(system(dimension), style=style, legend=asked, labels=()) as made:
            below = made._layout.size[1] - made._layout.footer
            picture = next(iter(made.frames())).pixels()[below:]
        assert {name for name, color in COLORS.items() if count(picture, color) > 20} == listed


def test_a_legend_of_several_panels_has_each_name_once() -> None:
    scene = system()
    found = [*sources(pc.simulate(scene, 0.1, progress=False), None, None, {})] * 2
    with FilmRenderer(found, (640, 240), BODY, None, DARK, Heading(), False, legend=True) as made:
        assert [name for name, _ in made._footer._legend] == list(COLORS)


def tracers(*places: tuple[float, float, float], name: str | None = None) -> pc.Tracers:
    return pc.Tracers(places, pc.Lorenz(), name=name)


def test_a_legend_lists_systems_that_are_drawn_in_one_color() -> None:
    one, other, cloud = tracers((1, 1, 20), name="one"), tracers((2, 1, 20), name="other"), ((1, 2, 9), (2, 3, 9))
    colors = DARK.bodies
    for systems, style, listed in (
        ((one,), None, {"one": colors[0]}),
        ((one, other), None, {"one": colors[0], "other": colors[1]}),
        ((one, tracers(*cloud, name="cloud")), None, {"one": colors[0], "cloud": colors[1]}),
        ((tracers(*cloud, name="cloud"),), None, {}),  # each tracer has its own
        ((tracers(*cloud, name="cloud"),), pc.styles.Trails(color="#0a1420"), {"cloud": (10, 20, 32)}),
        ((tracers((1, 1, 20)),), None, {}),  # it has no name
        ((pc.Wave(pc.Grid.over(0.0, 1.0, 0.1), speed=1.0, name="string"),), None, {"string": colors[0]}),
    ):
        for asked in (True, tuple(listed)):
            with renderer(pc.Scene(*systems), style=style, legend=asked) as made:
                assert dict(made._footer._legend) == listed
    with (
        pytest.raises(pc.SceneError, match=r"legend: Tracers\('cloud'.*is not drawn in one color.*Trails\(color="),
        renderer(pc.Scene(tracers(*cloud, name="cloud")), style=None, legend="cloud"),
    ):
        pass


@pytest.mark.parametrize("size", [(640, 360), (360, 240)])
@pytest.mark.parametrize("panels", [2, 3, 4])
def test_labels_of_a_panel_stay_below_it(panels: int, size: tuple[int, int]) -> None:
    recording = pc.simulate(pc.Scene(pc.Particles([[0.0, 0.0]])), 0.1, integrator=pc.ImplicitMidpoint(), progress=False)
    found, labels = [*sources(recording, None, None, {})] * panels, ("dt", "integrator", "energy")
    with FilmRenderer(found, size, BODY, None, DARK, Heading(), False, labels=labels, color_bar=False) as made:  # type: ignore[arg-type]
        below, margin = made._layout.size[1] - made._layout.footer, made._layout.text // 2
        picture = next(iter(made.frames())).pixels()[below:]
    for panel in range(1, panels + 1):
        end = size[0] * panel // panels
        assert count(picture[:, end - size[0] // panels : end], DARK.label) > 50
        assert (picture[:, end - margin + 1 : end] == DARK.background).all()


def test_a_legend_of_many_names_has_as_many_lines_as_it_needs() -> None:
    heights = []
    for bodies in (2, 20, 40):
        each = [pc.Particles([[0.1 * index, 0.0]], name=f"body {index}") for index in range(bodies)]
        with renderer(pc.Scene(*each), legend=True) as made:
            heights.append(made._layout.footer)
    assert heights == sorted(set(heights))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"legend": True, "style": pc.styles.Points("speed")}, "legend: Particles.*is not drawn in one color"),
        ({"legend": "pluto"}, "legend: nothing is called 'pluto'"),
        ({"name_tags": ("sun", "earht")}, "name_tags: nothing is called 'earht'.*did you mean 'earth'"),
        ({"name_tags": 3}, "name_tags: must be a body, its name, or several"),
        ({"name_tags": pc.Particles([[0.0, 0.0]], name="sun")}, "name_tags: .* is not in what is filmed"),
    ],
)
def test_names_of_what_is_not_there_are_refused(options: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(pc.SceneError, match=message):
        pc.film(system(), tmp_path / "film.png", duration=0.1, **{"style": BODY, **options})


def test_a_body_without_a_name_has_none_to_write(tmp_path: Path) -> None:
    scene = system()
    with pytest.raises(pc.SceneError, match=r"name_tags: .* has no name"):
        pc.film(scene, tmp_path / "film.png", duration=0.1, name_tags=scene.bodies[-1])


@pytest.mark.parametrize("option", ["legend", "name_tags"])
def test_a_name_with_a_sign_that_no_face_has_is_warned_of(option: str, tmp_path: Path) -> None:
    scene = pc.Scene(pc.Particles([[0.0, 0.0]], name="🪐"))
    with pytest.warns(pc.SceneWarning, match=rf"{option}: no face has 🪐"):
        pc.film(scene, tmp_path / "film.png", duration=0.1, style=BODY, **{option: True})


def rectangles(made: FilmRenderer) -> list[tuple[float, float, float, float]]:
    """Those that the names take in the first frame: left, top, right and bottom [pixels]."""
    panel = made._panels[0]
    frame = next(iter(panel.source.frames()))
    height = panel.tags._height
    placed = panel.tags.placed(frame, panel.view.at(0), panel.pixels)
    return [(x, y, x + pc._core.text_width(name, height), y + height) for x, y, name in placed]


@given(st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)), min_size=1, max_size=12), st.sampled_from([2, 3]))
def test_no_name_lies_over_another_or_outside_the_picture(places: list[tuple[float, float]], dimension: int) -> None:
    points = [[*place, 0.5][:dimension] for place in places]
    scene = pc.Scene(*(pc.Particles([point], name=f"body {index}") for index, point in enumerate(points)))
    camera: Any = Window((0.0, 0.0), (1.0, 1.0)) if dimension == 2 else Orbit(target=(0.5, 0.5, 0.5), extent=1.5)
    with renderer(scene, camera=camera, name_tags=True) as made:
        taken, (left, top, right, bottom) = rectangles(made), made._panels[0].free
    assert all(x >= left and y >= top and far <= right and low <= bottom for x, y, far, low in taken)
    for index, one in enumerate(taken):
        for other in taken[:index]:
            assert one[0] >= other[2] or other[0] >= one[2] or one[1] >= other[3] or other[1] >= one[3]


def test_a_name_is_beside_its_body_and_not_over_any(tmp_path: Path) -> None:
    scene = pc.Scene(*(pc.Particles([[x, 0.0]], name=name, radius=0.04) for name, x in (("a", -0.1), ("b", 0.1))))
    camera = Window((-0.5, -0.4), (0.5, 0.4))
    with renderer(scene, camera=camera, name_tags=True) as made:
        taken = rectangles(made)
        view, radius = made._panels[0].view.at(0), 0.04 * made._panels[0].view.at(0).scale
        centers = view.project(np.array([[-0.1, 0.0], [0.1, 0.0]]))[0]
    assert len(taken) == 2
    for own, (left, top, right, bottom) in enumerate(taken):
        nearest = np.clip(centers, [left, top], [right, bottom])
        distance = np.linalg.norm(centers - nearest, axis=1)
        assert (distance > radius).all()
        assert distance[own] < radius + 10.0


def test_a_name_stays_on_its_side_as_long_as_it_can() -> None:
    """The moon passes the sun on the right, where its name is: the name changes its side once, and not back."""
    times = np.linspace(0.0, 1.0, 31)
    sun, moon = pc.Particles([[0.0, 0.0]], name="sun"), pc.Particles([[0.0, 0.0]], name="moon")
    scene = pc.Scene(sun, moon)
    recording = pc.simulate(scene, 1.0, progress=False)
    recording.channels["positions"].setflags(write=True)
    recording.channels["positions"][:, 1] = np.stack([np.full(31, 0.06), 1.2 * (times - 0.5)], axis=1)
    found = sources(recording, None, None, {})
    camera = Window((-0.5, -0.4), (0.5, 0.4))
    with FilmRenderer(found, SIZE, BODY, camera, DARK, Heading(), False, name_tags=sun) as made:
        panel = made._panels[0]
        sides = []
        for frame in found[0].frames():
            placed = list(panel.tags.placed(frame, panel.view.at(0), panel.pixels))
            sides += [x > SIZE[0] / 2 for x, _, _ in placed]
    assert len(sides) == 31
    assert sum(one != other for one, other in pairwise(sides)) <= 1


def test_names_are_drawn_over_the_picture(tmp_path: Path) -> None:
    options: dict[str, Any] = {"camera": Window((0.0, 0.0), (5.0, 4.0)), "labels": (), "color_bar": False, "size": SIZE}
    seen = []
    for tags in (False, "sun", True):
        pc.film(system(), tmp_path / "film.png", duration=0.1, style=BODY, name_tags=tags, **options)
        with Image.open(tmp_path / "film.png") as image:
            seen.append(np.asarray(image.convert("RGB")).astype(int))
    lighter = [int((picture.sum(axis=2) > seen[0].sum(axis=2) + 200).sum()) for picture in seen]
    assert lighter[0] < lighter[1] < lighter[2]


# The scale bar.


@given(st.floats(1e-14, 1e22), st.sampled_from([None, *UNITS]))
def test_a_scale_bar_is_as_long_as_it_says_and_as_there_is_room(most: float, unit: Any) -> None:
    length, words = rounded(most, unit)
    assert most / 2.5 - 1e-9 * most <= length <= most * (1.0 + 1e-6)
    number, sign = words.rsplit(" ", 1)
    factor, _, power = number.rpartition("10") if any(digit in number for digit in "⁻⁰¹²³⁴⁵⁶⁷⁸⁹") else (number, "", "")
    value = float(factor.strip(" ·") or 1.0) * (
        10.0 ** int(unicodedata.normalize("NFKC", power).replace("−", "-")) if power else 1.0
    )
    assert value * UNITS[cast("LengthUnit", sign)] == pytest.approx(length)
    assert f"{value:e}"[0] in "125"
    assert unit in (None, sign)


@pytest.mark.parametrize(
    ("most", "words"),
    [(0.13, "10 cm"), (7.0, "5 m"), (2.4e-9, "2 nm"), (9.9e3, "5 km"), (pc.units.AU, "1 AU"), (1e-20, "10⁻⁵ fm")],
)
def test_the_unit_suits_the_length(most: float, words: str) -> None:
    assert rounded(most, None)[1] == words


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_scale_bar_is_drawn_to_scale(dimension: int) -> None:
    """Of all rows the one of the bar has the most pixels that are like the text."""
    camera: Any = Window((0.0, 0.0), (5.0, 4.0)) if dimension == 2 else Orbit(target=(2.0, 2.0, 2.0), extent=3.0)
    bare, barred = [], []
    for shown, pictures in ((False, bare), (True, barred)):
        with renderer(system(dimension), camera=camera, scale_bar=shown, labels=(), color_bar=False) as made:
            pictures.append(next(iter(made.frames())).pixels().astype(int))
            panel = made._panels[0]
            view, free = panel.view.at(0), panel.free
    length, _ = rounded(0.25 * (free[2] - free[0]) / view.scale, None)
    changed = np.abs(barred[0] - bare[0]).sum(axis=2)
    light = np.abs(barred[0] - DARK.text).max(axis=2) < 40
    assert light.sum(axis=1).max() == pytest.approx(
        length * view.scale, abs=2.5
    )  # half of the line's width at each end
    rows, columns = np.nonzero(changed)
    assert columns.max() < SIZE[0] / 2
    assert rows.min() > SIZE[1] / 2


def test_a_scale_bar_leaves_room_for_what_is_there() -> None:
    bar = ScaleBar(True, (0.0, 0.0, 320.0, 200.0), 16, DARK)
    with renderer(system()) as made:
        view = made._panels[0].view.at(0)
    left, right = (bar.placed(view, taken)[0] for taken in ((), [(8.0, 120.0, 150.0, 192.0)]))
    assert left[2] < 150.0 < right[0]
    assert right[2] < 320.0


@pytest.mark.parametrize("given_unit", ["parsec", 3, None, "ma"])
def test_what_is_no_unit_of_length_is_refused(given_unit: Any, tmp_path: Path) -> None:
    with pytest.raises(pc.SceneError, match=r"scale_bar: must be 'fm', 'pm'"):
        pc.film(system(), tmp_path / "film.png", duration=0.1, scale_bar=given_unit)


@pytest.mark.parametrize("labels", [(), ("time",)])
def test_what_is_near_in_space_goes_on_under_the_text(labels: tuple[str, ...]) -> None:
    """A ball wider than the picture: the rows of the text have its color, but for the text with its outline."""
    near = Orbit(azimuth=0.0, elevation=0.0, target=(0.0, 0.0, 0.0), extent=0.2, field_of_view=0.0)
    ball, style = pc.Particles([[0.0, 0.0, 0.0]], radius=1.0), pc.styles.Points("#ff0000", shading=False)
    with renderer(pc.Scene(ball), style=style, camera=near, labels=labels, heading=Heading("A ball")) as made:
        picture = next(iter(made.frames())).pixels()
    covered = (picture == (255, 0, 0)).all(axis=2)
    assert covered[:, : SIZE[0] // 60].all()
    assert covered[:, SIZE[0] // 2 :][-20:].all()
    assert (count(picture[-20:], DARK.label) > 20) == bool(labels)
    assert (count(picture[-20:], DARK.background) > 20) == bool(labels)
