"""Cameras show what they say, wherever they go, and lose nothing that they are to find by themselves."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from physcore.film import DARK, Follow, Keyframes, Orbit, Window
from physcore.film.camera.track import middle, smooth
from physcore.film.camera.view import fit
from physcore.film.film_renderer import FilmRenderer
from physcore.simulation.sources import sources

SIZE = (160, 120)
SHARP = {"labels": (), "color_bar": False}
fractions = st.floats(0.0, 1.0)


def recorded(
    body: pc.bodies.Body, motion: Callable[[np.ndarray, float], np.ndarray], *items: Any, count: int = 16
) -> Any:
    """A recording in which each particle goes where `motion` says from its initial position."""
    times = np.arange(count) / 15.0
    positions = np.stack([motion(body.positions, time) for time in times])
    channels = {"positions": positions}
    scene = pc.Scene(body, *items)
    return SimpleNamespace(scene=scene, times=times, positions=positions, fps=15.0, channels=channels)


def pictures(recording: Any, camera: Any, size: tuple[int, int] = SIZE, **options: Any) -> list[np.ndarray]:
    """Every frame of a film without text."""
    style = pc.styles.Points(color="body", size=4.0, trail=0.0)
    with FilmRenderer(
        sources(recording, None, None, {}), size, style, camera, DARK, None, False, **SHARP, **options
    ) as renderer:
        return [canvas.pixels().astype(int) for canvas in renderer.frames()]


def ink(picture: np.ndarray) -> np.ndarray:
    """Which pixels have the color of the first body, or a mixture with it."""
    return picture[:, :, 2] - np.array(DARK.background)[2] > 60


def cloud(dimension: int, count: int = 60) -> pc.Particles:
    return pc.Particles(np.random.default_rng(4).uniform(-1.0, 1.0, (count, dimension)) * (3.0, 0.5, 1.0)[:dimension])


def swing(start: np.ndarray, time: float) -> np.ndarray:
    """All goes around a point outside, and grows."""
    angle = 4.0 * time
    turned = start.copy()
    turned[:, 0] = math.cos(angle) * start[:, 0] - math.sin(angle) * start[:, 1]
    turned[:, 1] = math.sin(angle) * start[:, 0] + math.cos(angle) * start[:, 1]
    return (1.0 + 0.5 * time) * turned + 2.0 * time


MOVING = {
    "orbit": lambda time: Orbit(azimuth=200.0 * time, elevation=-60.0 + 120.0 * time),
    "keys": Keyframes({0.0: Orbit(field_of_view=10.0), 1.0: Orbit(azimuth=90.0, field_of_view=100.0)}),
    "looking": Keyframes({0.0: Orbit(target=(0.0, 0.0, 0.0)), 1.0: Orbit(target=(5.0, 1.0, 2.0))}),
    "orthographic": lambda time: Orbit(azimuth=200.0 * time, field_of_view=0.0),
}


@pytest.mark.parametrize("name", MOVING)
@pytest.mark.parametrize("size", [SIZE, (60, 160)])
def test_nothing_leaves_the_picture_while_the_camera_moves(name: str, size: tuple[int, int]) -> None:
    """And somewhere on the way the margin is used up: the framing is no larger than it has to be."""
    recording = recorded(cloud(3), swing)
    free = []
    for picture in pictures(recording, MOVING[name], size):
        rows, columns = np.nonzero(ink(picture))
        edges = (rows.min(), size[1] - 1 - rows.max(), columns.min(), size[0] - 1 - columns.max())
        free.append(min(edges))
        assert free[-1] >= 1
    # What has to stay free: 3 % of the shorter side, and a radius. A box that is not full leaves some more.
    assert min(free) < 0.25 * min(size)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("smoothing", [0.0, 0.5])
def test_a_followed_body_stays_in_the_picture_and_near_its_middle(dimension: int, smoothing: float) -> None:
    body = pc.Particles(0.1 * cloud(dimension).positions)
    for picture in pictures(recorded(body, swing), Follow(body, smoothing=smoothing)):
        drawn = ink(picture)
        assert not drawn[[0, -1]].any()
        assert not drawn[:, [0, -1]].any()
        rows, columns = np.nonzero(drawn)
        off = max(abs(rows.mean() - 59.5), abs(columns.mean() - 79.5))
        # Unsmoothed it is the middle, up to the weight of overlapping discs; else within the half that it may fill.
        assert off < (12.0 if smoothing == 0.0 else 45.0)


def test_a_panel_that_ended_stays_in_the_picture_while_the_camera_moves_on() -> None:
    """A rod along the view at the end of the short panel lies across it later, when the camera has gone around."""
    rod = pc.Particles(np.linspace(-1.0, 1.0, 30)[:, np.newaxis] * np.array([1.0, 0.0, 0.0]))
    short = recorded(rod, lambda start, time: start, count=4)
    long = recorded(rod, lambda start, time: 0.2 * start, count=16)
    found = pictures([short, long], lambda time: Orbit(azimuth=90.0 * time, elevation=0.0), (320, 120))
    for picture in found:
        columns = np.nonzero(ink(picture)[:, :160])[1]
        assert columns.min() > 1
        assert columns.max() < 158
    assert columns.max() - columns.min() > 100


def test_a_follower_is_as_slow_in_seconds_at_any_frame_rate() -> None:
    """Where it looks, half a second before a body sets off: the tail of the bell, of 0.5 s whatever the frames are."""
    body = pc.Particles([[0.0, 0.0]])
    looked = []
    for fps in (10.0, 40.0):
        recording = recorded(body, lambda start, time: start + max(time - 2.0, 0.0), count=1)
        recording.fps, recording.times = fps, np.arange(round(4 * fps) + 1) / fps
        recording.positions = np.stack([body.positions + max(time - 2.0, 0.0) for time in recording.times])
        recording.channels["positions"] = recording.positions
        with FilmRenderer(sources(recording, None, None, {}), SIZE, None, Follow(0), DARK, None, False) as renderer:
            looked.append(renderer._panels[0].view.at(round(1.5 * fps)).center[0])
    # ∫ (t − 2) of a bell of 0.5 s about 1.5 s: 0.5 (φ(1) − Φ(−1)) = 0.0417 m; sampled five times per deviation.
    np.testing.assert_allclose(looked, 0.5 * (0.2420 - 0.1587), atol=2e-3)


def test_a_followed_body_does_not_jump_at_a_face_of_the_domain() -> None:
    domain = pc.Periodic((0.0, 0.0), (1.0, 1.0))
    body = pc.Particles([[0.85, 0.5], [0.9, 0.5]], name="pair")
    recording = recorded(body, lambda start, time: domain.wrap(start + np.array([2.2, -1.3]) * time), domain)
    assert (np.abs(np.diff(recording.positions, axis=0)) > 0.5).any()  # it crosses faces, and is parted by one
    found = pictures(recording, Follow("pair", Window((0.0, 0.0), (0.5, 0.5)), smoothing=0.1))
    centers = [np.argwhere(ink(picture)).mean(axis=0) for picture in found]
    np.testing.assert_allclose(centers, np.tile([59.5, 79.5], (len(found), 1)), atol=0.6)


def test_each_frame_of_a_moving_window_is_that_of_a_window_that_stands() -> None:
    """The scenery is then drawn anew in each frame; drawn once and kept it has the same pixels."""
    recording = recorded(cloud(2), swing, pc.Floor(-1.0), pc.Sphere((1.0, 0.0), 0.5), pc.Box((-4.0,) * 2, (4.0,) * 2))
    camera = Keyframes({0.0: Window((-5.0, -4.0), (5.0, 4.0)), 1.0: Window((0.0, 0.0), (2.0, 1.5))})
    moving = pictures(recording, camera)
    for index in (0, 7, 15):
        standing = pictures(recording, camera(index / 15.0))
        np.testing.assert_array_equal(moving[index], standing[index])
    assert (moving[0] != moving[15]).mean() > 0.05


def test_a_function_that_always_says_the_same_is_a_camera_that_stands() -> None:
    recording = recorded(cloud(3), swing)
    for one, other in zip(pictures(recording, Orbit()), pictures(recording, lambda time: Orbit()), strict=True):
        np.testing.assert_array_equal(one, other)


@given(first=st.floats(0.1, 10.0), second=st.floats(0.1, 10.0), fraction=fractions)
def test_a_zoom_grows_by_equal_factors_and_keeps_its_goal_in_place(
    first: float, second: float, fraction: float
) -> None:
    """Between windows there is a point that stays where it is in the picture; so between targets with extents."""
    zoom = Keyframes(
        {0.0: Orbit(target=(0, 0, 0), extent=first), 1.0: Orbit(target=(1, 2, 3), extent=second)}, "linear"
    )
    now = zoom(fraction)
    assert isinstance(now, Orbit)
    assert now.extent == pytest.approx(first ** (1 - fraction) * second**fraction)
    windows = Keyframes({0.0: Window((0, 0), (first, first)), 1.0: Window((1, 2), (1 + second, 2 + second))}, "linear")
    one, other, seen = windows(0.0), windows(1.0), windows(fraction)
    assert seen.upper[0] - seen.lower[0] == pytest.approx(first ** (1 - fraction) * second**fraction)
    if abs(second / first - 1.0) > 0.05:
        # p with (p − lower)/size the same at both ends; rounding is amplified by one over the change of size.
        goal = [(a * second - b * first) / (second - first) for a, b in zip(one.lower, other.lower, strict=True)]
        places = [[(p - low) / (view.upper[0] - view.lower[0]) for p, low in zip(goal, view.lower, strict=True)]
                  for view in (one, seen)]  # fmt: skip
        np.testing.assert_allclose(places[0], places[1], rtol=1e-9, atol=1e-9)


def test_keyframes_are_met_and_left_at_rest() -> None:
    keys = {2.0: Orbit(azimuth=350.0, elevation=80.0), 1.0: Orbit(azimuth=-20.0), 4.0: Orbit(azimuth=0.0)}
    camera = Keyframes(keys)
    for time, key in keys.items():
        assert camera(time) == key
        for side in (-1e-4, 1e-4):  # at rest: a change of the second order, 3 (h / interval)² times 370 degrees
            assert abs(camera(time + side).azimuth - key.azimuth) < 3.0 * 1e-8 * 370.0 * 1.01
    assert camera(-9.0) == keys[1.0]
    assert camera(9.0) == keys[4.0]
    assert camera(1.5).azimuth == pytest.approx(165.0)  # the long way round, as the angles say
    assert Keyframes(keys, "linear")(1.25).azimuth == pytest.approx(72.5)


@given(speed=st.floats(-5.0, 5.0), width=st.floats(0.0, 30.0), count=st.integers(1, 60))
def test_an_even_motion_is_followed_without_a_lag(speed: float, width: float, count: int) -> None:
    path = np.stack([speed * np.arange(count), np.ones(count)], axis=1)
    np.testing.assert_allclose(smooth(path, width), path, atol=1e-12 * (1.0 + 300.0))


@given(start=st.integers(1, 40), width=st.floats(0.1, 20.0))
def test_a_follower_turns_without_overshoot_or_a_jump(start: int, width: float) -> None:
    """A step becomes an S: between its ends, never back, and at most as steep as the bell is high."""
    path = (np.arange(60) >= start).astype(float)[:, np.newaxis]
    found = smooth(path, width)[:, 0]
    assert (found >= -1e-12).all()
    assert (found <= 1.0 + 1e-12).all()
    assert (np.diff(found) >= -1e-12).all()
    bell = np.exp(-0.5 * (np.arange(-59, 60) / width) ** 2)
    cut = bell[abs(np.arange(-59, 60)) <= math.ceil(4.0 * width)]
    assert np.diff(found).max() <= 2.0 * cut.max() / cut.sum() + 1e-12  # twice: at an end, with its mirror image


def test_smoothing_does_not_depend_on_the_frame_rate() -> None:
    """Sums of a bell sampled five times and more per standard deviation agree to below what its cut leaves, 6e-5."""
    paths = []
    for fps in (10, 20, 40):
        time = np.arange(4 * fps + 1) / fps
        path = np.stack([np.sin(3.0 * time), np.abs(time - 2.0)], axis=1)
        paths.append(smooth(path, 0.5 * fps)[:: fps // 10])
    # The kink of |t − 2| is sampled to second order: 0.1²/12 of its change of slope, 2, at the most, times the bell's
    # height of 0.8.
    np.testing.assert_allclose(paths[0], paths[2], atol=0.8 * 2.0 * 0.1**2 / 12 + 6e-5 * 2.0)
    np.testing.assert_allclose(paths[1], paths[2], atol=0.8 * 2.0 * 0.05**2 / 12 + 6e-5 * 2.0)


@given(shift=st.floats(-3.0, 3.0))
def test_the_center_of_mass_knows_that_the_domain_goes_round(shift: float) -> None:
    domain = pc.Periodic((-1.0, -np.inf), (1.0, np.inf))
    points, mass = np.array([[0.0, 0.0], [0.3, 1.0], [0.1, 5.0]]), np.array([1.0, 2.0, 1.0])
    found = middle(domain.wrap(points + np.array([shift, 0.0])), mass, domain)
    apart = domain.nearest(found - (mass @ points / 4.0 + np.array([shift, 0.0])))
    np.testing.assert_allclose(apart, 0.0, atol=1e-12)


@given(depth=st.floats(-0.9, 50.0), aperture=st.floats(0.001, 1.0))
def test_what_is_out_of_focus_is_as_blurred_as_a_lens_makes_it(depth: float, aperture: float) -> None:
    """Rays from both rims of the lens to a point cross the plane in focus as far apart as the circle is wide."""
    camera = Orbit(azimuth=0.0, elevation=0.0, aperture=aperture, target=(0.0, 0.0, 0.0), extent=1.0)
    view = fit(camera, np.full(3, -1.0), np.full(3, 1.0), (0.0, 0.0, 100.0, 100.0), 0.0)
    distance, behind = view.distance, depth * view.distance
    rim = aperture * distance / 2  # the eye is at +distance, the point at −behind, the focus at 0
    crossing = [height + (0.0 - height) * distance / (distance + behind) for height in (rim, -rim)]
    expected = abs(crossing[0] - crossing[1]) * view.scale
    found = 2.0 * view.blur * abs(behind) / (1.0 + behind / view.distance)  # as the canvas has it
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)
    for sharp in (replace(camera, aperture=0.0), replace(camera, field_of_view=0.0)):
        view = fit(sharp, np.full(3, -1.0), np.full(3, 1.0), (0.0, 0.0, 100.0, 100.0), 0.0)
        assert view.blur == 0.0


@pytest.mark.parametrize(
    ("camera", "message"),
    [
        (lambda: Keyframes({}), r"Keyframes\.cameras: must be like"),
        (lambda: Keyframes({"a": Orbit()}), r"Keyframes\.cameras: must be a number"),
        (
            lambda: Keyframes({0: Orbit(), 1: Window((0, 0), (1, 1))}),
            r"Keyframes\.cameras\[1\]: must be like the first",
        ),
        (lambda: Keyframes({0: Orbit(), 1: Orbit(extent=1.0)}), r"Keyframes\.cameras\[1\]\.extent: give it in all"),
        (lambda: Keyframes({0: Orbit()}, easing="slow"), "easing"),
        (lambda: Follow([]), r"Follow\.bodies: must be a body"),
        (lambda: Follow(0, smoothing=-1.0), r"Follow\.smoothing: must be ≥ 0"),
        (lambda: Follow(0, camera=Orbit), r"Follow\.camera: must be a Window"),
        (lambda: Orbit(aperture=2.0), r"Orbit\.aperture: must be ≤ 1"),
        (lambda: Follow("nobody"), r"Follow\.bodies: no body 'nobody'"),
        (lambda: Follow(7), r"Follow\.bodies: "),
        (lambda: Follow(0, Orbit(target=(0, 0, 0))), "must have no target"),
        (lambda: Orbit, "camera: must be an Orbit in 3D, got"),
        (lambda: lambda time: Window((0, 0), (1, 1)), "camera: must be an Orbit in 3D at 0 s, got Window"),
        (lambda: Keyframes({0: Window((0, 0), (1, 1))}), "camera: must be an Orbit in 3D at 0 s, got Window"),
    ],
)
def test_a_camera_that_cannot_be_is_refused(camera: Callable[[], Any], message: str) -> None:
    with pytest.raises(pc.SceneError, match=message):
        pictures(recorded(cloud(3), swing), camera())
