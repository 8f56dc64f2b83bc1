"""In the corotating frame of a pair nothing that turns with it moves, and Jacobi's integral is kept."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from physcore.film import DARK, Corotating, Orbit, Window
from physcore.film.film_renderer import FilmRenderer
from physcore.simulation.sources import Source, sources

MASSES = np.array([3.0, 1.0, 0.5, 0.25])


def turning(rate: float, drift: float, dimension: int, count: int = 9) -> Any:
    """A recording of four particles that turn rigidly about a moving axis."""
    start = np.random.default_rng(7).uniform(-1.0, 1.0, (4, dimension))
    times = np.arange(count) / 10.0
    positions, velocities = np.empty((count, 4, dimension)), np.empty((count, 4, dimension))
    for index, angle in enumerate(rate * times):
        turn = np.eye(dimension)
        turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        turned = start @ turn.T
        positions[index] = turned + drift * times[index]
        velocities[index] = drift
        velocities[index, :, :2] += rate * np.column_stack([-turned[:, 1], turned[:, 0]])
    scene = pc.Scene(pc.Particles(start, mass=MASSES, name="all"))
    channels = {"positions": positions, "velocities": velocities}
    return SimpleNamespace(scene=scene, times=times, positions=positions, fps=10.0, channels=channels)


def seen(recording: Any, frame: Corotating) -> Source:
    """A recording in a corotating frame."""
    return frame.seen(sources(recording, None, None, {})[0])


@pytest.mark.parametrize("dimension", [2, 3])
@given(rate=st.floats(-3.0, 3.0), drift=st.floats(-2.0, 2.0))
def test_a_rigid_rotation_is_at_rest(dimension: int, rate: float, drift: float) -> None:
    """Positions and speeds are below 10 in size: some tens of roundings are below 1e-13."""
    frames = list(seen(turning(rate, drift, dimension), Corotating(("all", 0), ("all", 1))).frames())
    for frame in frames:
        np.testing.assert_allclose(frame.positions, frames[0].positions, atol=1e-13)
        np.testing.assert_allclose(frame.fields["velocities"], 0.0, atol=1e-12)
        one, other = frame.positions[:2]
        np.testing.assert_allclose([one[1], other[1]], 0.0, atol=1e-14)
        assert one[0] < 0.0 < other[0]
        np.testing.assert_allclose(MASSES[:2] @ frame.positions[:2], 0.0, atol=1e-14)


def test_velocities_are_the_changes_of_positions() -> None:
    """By central differences, whose error is h²/6 of the third derivative: below 1e-4 · 3³/6 of positions below 3."""
    pair = pc.Particles([[-1.0, 0.0], [1.0, 0.1]], [[0.1, -0.5], [0.0, 0.6]], mass=[1.0, 0.9], name="pair")
    scene = pc.Scene(pair, pc.Particles([[0.3, 1.2]], [[1.0, 0.2]], mass=0.1), pc.Gravitation(1.0, softening=0.3))
    recording = pc.simulate(scene, 1.0, fps=100.0, dt=0.01)
    frames = list(seen(recording, Corotating(("pair", 0), ("pair", -1))).frames())
    for before, now, after in zip(frames, frames[1:], frames[2:], strict=False):
        change = (after.positions - before.positions) / 0.02
        np.testing.assert_allclose(now.fields["velocities"], change, atol=1.5e-3)


def test_jacobis_integral_is_kept() -> None:
    """½v² − ½ω²r² + Φ of a body without weight in the frame of two that go around on circles (Szebehely 1967, section
    1.5), as far as a method of order 6 at 400 steps a turn keeps it: (2π/400)⁶ = 1.5e-11, with a constant below 1e3.
    """
    share, start = 0.02, np.array([[-0.02, 0.0], [0.98, 0.0]])
    velocities = np.column_stack([0.0 * start[:, 0], start[:, 0]])
    pair = pc.Particles(start, velocities, mass=[1.0 - share, share], name="pair")
    light = pc.Particles([[0.3, 0.8]], [[-0.75, 0.4]], name="light")
    scene = pc.Scene(pair, light, pc.Gravitation(1.0, sources=[pair]))
    recording = pc.simulate(scene, 4.0 * np.pi, fps=30 / np.pi, integrator=pc.BlanesMoan6(), dt=np.pi / 210)
    integrals = []
    for frame in seen(recording, Corotating(("pair", 0), ("pair", 1))).frames():
        one, other, third = frame.positions
        assert np.abs(one - start[0]).max() < 1e-7
        potential = -(1.0 - share) / np.linalg.norm(third - one) - share / np.linalg.norm(third - other)
        velocity = frame.fields["velocities"][2]
        integrals.append(0.5 * velocity @ velocity - 0.5 * third @ third + potential)
    assert np.ptp(integrals) < 1.5e-8
    assert np.ptp(np.linalg.norm(recording["light"].velocities[:, 0], axis=1)) > 0.1  # it does move


def test_a_film_in_the_frame_of_what_turns_stands_still() -> None:
    recording = turning(2.0, 0.5, 2)
    style = pc.styles.Points(color="body", size=6.0, trail=0.0)

    def pictures(camera: Corotating) -> list[np.ndarray]:
        found = sources(recording, None, None, {})
        options: dict[str, Any] = {"labels": (), "color_bar": False}
        with FilmRenderer(found, (120, 90), style, camera, DARK, None, False, **options) as renderer:
            return [canvas.pixels().astype(int) for canvas in renderer.frames()]

    for inner in (None, Window((-2.0, -2.0), (2.0, 2.0))):
        found = pictures(Corotating(("all", 0), ("all", 1), inner))
        assert np.ptp(found[0]) > 50
        for picture in found[1:]:
            assert np.abs(picture - found[0]).max() <= 2  # edges of discs, by a rounding of their places


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Corotating([1], 0), r"Corotating\.first: must be a body or \(body, index\), got"),
        (lambda: Corotating(0, True), r"Corotating\.second: must be a body or \(body, index\)"),
        (lambda: Corotating(0, (1, 0.5)), r"Corotating\.second\[1\]"),
        (lambda: Corotating(0, 1, Orbit), r"Corotating\.camera: must be a Window"),
    ],
)
def test_a_pair_that_cannot_be_is_refused(make: Any, message: str) -> None:
    with pytest.raises(pc.SceneError, match=message):
        make()


@pytest.mark.parametrize(
    ("scene", "frame", "message"),
    [
        ((), Corotating("nobody", 0), r"Corotating\.first: no body 'nobody'"),
        ((), Corotating(0, (0, 4)), r"Corotating\.second\[1\]: must be from -4 to 3, got 4"),
        ((), Corotating((0, 1), (0, -3)), r"the pair must be apart, got both at"),
        ((pc.Plane((0.0, 1.0), (0.0, -9.0)),), Corotating((0, 0), (0, 1)), r"got one with boundaries; film it with"),
        ((pc.Periodic((-5.0, -5.0), (5.0, 5.0)),), Corotating((0, 0), (0, 1)), "got one with a periodic domain"),
    ],
)
def test_a_scene_without_the_frame_is_refused(scene: tuple[Any, ...], frame: Corotating, message: str) -> None:
    recording = turning(1.0, 0.0, 2)
    recording.scene = pc.Scene(*recording.scene.bodies, *scene)
    with pytest.raises(pc.SceneError, match=message):
        list(seen(recording, frame).frames())
