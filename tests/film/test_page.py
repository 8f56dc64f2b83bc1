"""Pages in headless Chromium: they show what the renderer draws, offline, and do what hands and keys ask for."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import physcore as pc
from chromium import Browser, Page, executable
from physcore.film.colors.themes import resolve
from physcore.film.film_renderer import FilmRenderer
from physcore.film.page import tape
from physcore.simulation.sources import sources

pytest.importorskip("websockets", reason="the extra physcore[live] is not installed")
pytestmark = pytest.mark.skipif(executable() is None, reason="there is no Chromium: apt-get install chromium")

RANDOM = np.random.default_rng(3)
SHOT = """(frame => {
  fit = () => {};
  for (const canvas of [picture, texts]) { canvas.width = player.film.size[0]; canvas.height = player.film.size[1]; }
  player.drawing.draw(frame);
  return picture.toDataURL();
})"""
"""Draws a frame in the size of the film, and gives its picture."""


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    opened = Browser(tmp_path_factory.mktemp("profile"))
    yield opened
    opened.close()


@pytest.fixture
def show(browser: Browser, tmp_path: Path) -> Iterator[Callable[..., Page]]:
    """Films a recording as a page and opens it at a frame, paused."""
    pages: list[Page] = []

    def showing(recording: object, at: str = "#frame=0", width: int = 700, **options: Any) -> Page:
        path = tmp_path / "film.html"
        pc.film(recording, path, **options)  # type: ignore[arg-type]
        pages.append(browser.page(path.as_uri() + at, width, 900))
        pages[-1].until("film.dataset.state != 'loading' && (film.dataset.drawn || film.dataset.state == 'gif')")
        return pages[-1]

    yield showing
    for page in pages:
        page.close()


def pixels(page: Page, frame: float) -> np.ndarray:
    url = str(page.evaluate(f"{SHOT}({frame})"))
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(url.split(",")[1]))).convert("RGB")).astype(int)


def drawn(
    recording: pc.Recording, frames: tuple[int, ...], style: object = None, **options: Any
) -> list[np.ndarray]:  # fmt: skip
    """The same frames by the renderer."""
    found, dark = sources(recording, None, None, {}), resolve("dark")
    with FilmRenderer(found, (320, 240), style, None, dark, None, False, captioned=False, **options) as renderer:  # type: ignore[arg-type]
        kept = {index: canvas.pixels().astype(int) for index, canvas in enumerate(renderer.frames()) if index in frames}
    return [kept[index] for index in frames]


def gas() -> pc.Recording:
    balls = pc.Particles(RANDOM.random((60, 2)), RANDOM.normal(0, 0.5, (60, 2)), radius=0.02)
    return pc.simulate(pc.Scene(balls, pc.Gravity(), pc.Box((0.0, 0.0), (1.0, 1.0))), 0.6)


def cloth() -> pc.Recording:
    options: Any = {"origin": (0.0, 0.0, 1.0), "axes": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), "pinned": "top corners"}
    net = pc.cloth((12, 9), 0.05, stiffness=400.0, damping=0.05, mass=2e-3, **options)
    return pc.simulate(pc.Scene(net, pc.Gravity()), 0.6)


def bricks() -> pc.Recording:
    where = [(0.05 * k, 0.2 + 0.3 * k) for k in range(4)]
    bodies = pc.RigidBodies(pc.Rectangle(0.4, 0.2), where, angles=[0.3, 0.1, 0.5, 0.2], density=500.0)
    discs = pc.RigidBodies(pc.Disc(0.12), [(0.7, 0.4), (0.7, 0.8)], angular_velocities=[5.0, -3.0])
    return pc.simulate(pc.Scene(bodies, discs, pc.Floor(), pc.Gravity()), 0.6)


def dice() -> pc.Recording:
    shapes = [pc.Cuboid(0.3, 0.2, 0.25), pc.Ball(0.15)]
    bodies = [
        pc.RigidBodies(shape, [(0.5 * k, 0.0, 0.6)], angular_velocities=[(3.0, 2.0, 4.0)])
        for k, shape in enumerate(shapes)
    ]
    return pc.simulate(pc.Scene(*bodies, pc.Gravity()), 0.6)


def waves() -> pc.Recording:
    grid = pc.Grid((60, 45), 0.04)
    wave = pc.Wave(grid, 1.0, lambda x, y: np.exp(-40.0 * ((x - 0.6) ** 2 + (y - 1.0) ** 2)), walls=lambda x, y: x > 2)
    return pc.simulate(pc.Scene(wave), 0.6)


def water() -> pc.Recording:
    block = pc.Fluid(pc.block((0.0, 0.0), (0.5, 0.5), 0.04), 0.04)
    return pc.simulate(pc.Scene(block, pc.Gravity(), pc.Box((0.0, 0.0), (1.0, 0.8))), 0.6)


def sea() -> pc.Recording:
    block = pc.Fluid(pc.block((0.0, 0.0, 0.0), (0.5, 0.4, 0.4), 0.08), 0.08)
    ball = pc.RigidBody(pc.Ball(0.1), (0.8, 0.2, 0.1), density=3000.0)
    return pc.simulate(pc.Scene(block, ball, pc.Gravity(), pc.Box((0.0, 0.0, 0.0), (1.2, 0.4, 0.8))), 0.6)


@pytest.mark.parametrize(
    ("make", "style", "shade"),
    [
        (gas, None, 0.0),
        (gas, pc.styles.Points("tomato", glow=0.9), 0.0),
        (cloth, None, 0.0),
        (cloth, pc.styles.Strain(), 0.0),
        (bricks, None, 0.0),
        (dice, None, 0.0),
        (waves, None, 0.0),
        (waves, pc.styles.Field(contours=4, relief=0.3), 0.0),
        (water, None, 0.2),
        (sea, None, 0.2),
    ],
    ids=["points", "halos", "surface", "network", "rigid 2D", "rigid 3D", "wave", "contours", "fluid", "fluid 3D"],
)
def test_a_page_shows_what_the_renderer_draws(
    show: Callable[..., Page], make: Callable[[], pc.Recording], style: object, shade: float
) -> None:
    """Where the picture is smooth, colors agree within the rounding of colors to 128 and of fields to 255 values, which
    is 5 of 255 where a scale is steepest. A liquid is darker inside by up to `shade`, which the page finds from a
    coarser mean, and a part of its rim is wider by a fraction of a drop, up to half of `shade`. In 3D its colors and
    its thickness are smoothed otherwise. At edges, the coverage of a pixel comes from 4 samples in place of the
    distance; but the light of all edges is the same, within 1 % in 2D. In 3D the renderer makes triangles half a pixel
    larger, 5 % of these.
    """
    recording = make()
    page, frames = show(recording, size=(320, 240), style=style), (0, 6, 17)
    exact, found = drawn(recording, frames, style), [pixels(page, frame) for frame in frames]
    for one, other in zip(exact, found, strict=True):
        assert other.shape == one.shape
        steps = [np.abs(np.diff(one, axis=axis, append=one.take([-1], axis=axis))).max(axis=2) for axis in (0, 1)]
        around = [np.roll(np.maximum(*steps), (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1)]
        smooth = np.max(around, axis=0) < 12
        assert smooth.mean() > 0.5
        assert (np.abs(other - one)[smooth] > 5 + 255 * shade).mean() < 0.01
        light = [np.abs(each - each[0, 0]).sum() for each in (one, other)]
        least = 0.95 if recording.scene.dimension == 3 else 0.99
        assert least - shade < light[1] / light[0] < 1.01 + 0.5 * shade
    errors = np.array([[np.abs(one - other).mean() for other in found] for one in exact])
    assert (errors.argmin(axis=1) == np.arange(3)).all()  # each is like this frame, and like no other


def test_diagrams_beside_the_picture_are_on_a_page(show: Callable[..., Page]) -> None:
    """The curve of the kinetic energy has as many pixels of its color, but for those of its name, which is a text."""
    recording, options = gas(), {"style": pc.styles.Points("white"), "inset": "energy"}
    page = show(recording, size=(320, 240), **options)
    color = np.array(resolve("dark").bodies[0])
    exact, found = (
        (np.abs(each - color).max(axis=2) < 60).sum()
        for each in (*drawn(recording, (17,), **options), pixels(page, 17))
    )  # type: ignore[arg-type]
    assert 20 < 0.6 * exact < found < 1.2 * exact


def test_many_points_of_a_density_become_fewer_and_have_no_energy(
    show: Callable[..., Page], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nine in ten are left out, and the light of the others has ten times the area; tracers have no curve of energy."""
    monkeypatch.setattr(tape, "GRAINS", 200)
    flow = pc.Flow(lambda t, x: np.column_stack([-x[:, 1], x[:, 0]]))
    dust = pc.Tracers(RANDOM.normal(0.0, 0.3, (1800, 2)), flow)
    page = show(pc.simulate(pc.Scene(dust), 0.2), size=(320, 240), style=pc.styles.Density(spread=2.0))
    assert page.evaluate("at('.energy').hidden") is True
    track = "player.drawing.tracks.find(track => track.kind == 'density')"
    assert page.evaluate(f"{track}.streams.places.rows(0)") == 180
    assert page.evaluate(f"{track}.spread") == pytest.approx(2.0 * np.sqrt(10.0))
    assert page.evaluate("player.film.energy.length") == 0


def test_places_reach_the_page(show: Callable[..., Page]) -> None:
    """What the page unpacks is what was drawn, within half a step of 16 bits, also between frames with other rows."""
    recording = gas()
    page = show(recording, size=(320, 240))
    with FilmRenderer(
        sources(recording, None, None, {}), (320, 240), None, None, resolve("dark"), None, False, captioned=False
    ) as renderer:  # type: ignore[arg-type]
        exact = tape.Tape()
        list(renderer.record(exact))
    for index, track in enumerate(exact.tracks):
        for name in ("places", "sizes"):
            for frame, arrays in track.frames.items():
                stream = f"player.drawing.tracks[{index}].streams.{name}"
                back = np.array(page.evaluate(f"Array.from({stream}.real({frame}, 0))"))
                if name in arrays:
                    np.testing.assert_allclose(back, arrays[name].ravel(), atol=0.5 * 640 / 65535 + 1e-3, rtol=1e-5)


def test_hands_and_keys(show: Callable[..., Page]) -> None:
    page = show(cloth(), size=(320, 240))
    first = pixels(page, 0)
    page.evaluate("(scrub => { scrub.value = 9; scrub.dispatchEvent(new Event('input')); })(at('.scrub'))")
    page.until("film.dataset.frame == '9' && film.dataset.playing == 'false'")
    assert page.evaluate("at('.line').textContent") == "0.30 s"
    assert np.abs(pixels(page, 9) - first).max() > 50
    for key, code, frame in (("ArrowRight", 39, 10), ("ArrowLeft", 37, 9), ("Home", 36, 0), ("End", 35, 18)):
        page.call("Input.dispatchKeyEvent", type="keyDown", key=key, windowsVirtualKeyCode=code)
        page.call("Input.dispatchKeyEvent", type="keyUp", key=key, windowsVirtualKeyCode=code)
        page.until(f"film.dataset.frame == '{frame}'")
    page.evaluate("seek(0)")
    x, y = page.middle(".picture")
    page.mouse("mousePressed", x, y)
    page.mouse("mouseMoved", x + 90, y + 30)
    page.mouse("mouseReleased", x + 90, y + 30)
    page.until("!at('.home').hidden")
    assert np.abs(pixels(page, 0) - first).max() > 50  # it has turned
    page.call("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=-300)
    page.until("player.drawing.zoom[0] > 1.2")
    page.click(".home")
    page.until("at('.home').hidden")
    np.testing.assert_array_equal(pixels(page, 0), first)
    page.click(".play")
    page.until("film.dataset.playing == 'true' && Number(film.dataset.frame) > 2")
    page.call("Input.dispatchKeyEvent", type="keyDown", key=" ", windowsVirtualKeyCode=32, text=" ")
    page.click(".about")
    page.until("!at('.record').hidden")
    assert pc.__version__ in str(page.evaluate("at('.record').textContent"))
    assert page.evaluate("at('.energy').hidden") is False


def test_a_film_repeats_or_plays_backward(show: Callable[..., Page]) -> None:
    """The clock of the page is advanced by hand: 18 frames of 1/30 s each."""
    page = show(gas(), size=(160, 120))
    ends = """(seconds => {
      Object.assign(player, {position: 0, wait: 0, way: 1});
      for (const each of seconds) advance(each);
      return player.position;
    })"""
    assert page.evaluate(f"{ends}([0.1])") == pytest.approx(3.0)
    assert page.evaluate(f"{ends}([0.62])") == 18.0
    assert page.evaluate(f"{ends}([0.62, 0.04, 0.1])") == pytest.approx(3.0, abs=1.3)  # it began again
    page.evaluate("player.film.bounce = true")
    assert page.evaluate(f"{ends}([0.62, 0.1])") == pytest.approx(15.0)


def test_a_page_is_one_file_and_asks_for_nothing(show: Callable[..., Page]) -> None:
    """Nothing is loaded, texts are never taken for code, and it fits a phone."""
    title = "</script><script>window.bad = 1</script> \"'&<b>"
    scene = pc.Scene(pc.Particles(np.zeros((1, 2)), np.ones((1, 2)), name=title))
    texts: Any = {"title": title, "subtitle": title, "credit": title}
    page = show(scene, width=390, duration=0.2, legend=True, style=pc.styles.Points("body"), **texts)
    assert page.evaluate("film.dataset.state") == "ready"
    loaded = page.evaluate("performance.getEntriesByType('resource').map(each => each.name.slice(0, 5))")
    assert set(loaded) <= {"data:"}  # type: ignore[call-overload]
    assert page.evaluate("window.bad === undefined && document.scripts.length") == 3
    for selector in ("h1", "header p", ".credit", ".legend li"):
        assert page.evaluate(f"document.querySelector({selector!r}).textContent") == title
    assert page.evaluate("document.title") == title
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_without_webgl_there_is_a_gif(browser: Browser, tmp_path: Path) -> None:
    path = tmp_path / "film.html"
    pc.film(gas(), path, size=(320, 240))
    page = browser.page("about:blank")
    page.call("Page.addScriptToEvaluateOnNewDocument", source="HTMLCanvasElement.prototype.getContext = () => null")
    page.call("Page.navigate", url=path.as_uri())
    page.until("document.querySelector('#film').dataset.state == 'gif'")
    assert page.evaluate("document.querySelector('.gif').naturalWidth") == 240
    assert page.evaluate("getComputedStyle(document.querySelector('.gif')).visibility") == "visible"
    assert page.evaluate("document.querySelector('.trouble').textContent").startswith("This browser has no WebGL 2")
    page.close()


@pytest.mark.parametrize(("reduced", "plays"), [(False, "true"), (True, "false")])
def test_motion_is_not_forced_upon_anyone(browser: Browser, tmp_path: Path, *, reduced: bool, plays: str) -> None:
    path = tmp_path / "film.html"
    pc.film(gas(), path, size=(160, 120))
    page = browser.page("about:blank")
    feature = {"name": "prefers-reduced-motion", "value": "reduce" if reduced else "no-preference"}
    page.call("Emulation.setEmulatedMedia", features=[feature])
    page.call("Page.navigate", url=path.as_uri())
    page.until(f"film.dataset.playing == '{plays}' && film.dataset.state == 'ready'")
    page.close()
