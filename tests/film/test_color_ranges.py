"""The ends of color scales: typical of the whole film, or exactly those that were given."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from physcore.film import DARK
from physcore.film.film_renderer import FilmRenderer
from physcore.film.styles.typical import RARE, TYPICAL, Typical
from physcore.simulation.sources import sources

ENOUGH = 1000
"""Particles, or frames, of which a share of less than a percent is some."""
SPEEDS = np.linspace(0.5, 1.0, ENOUGH)
"""Of the particles [m/s]."""


def end(frames: np.ndarray, **options: Any) -> float:
    """What is typical of values (F, N)."""
    typical = Typical(**options)
    return [typical.add(frame) for frame in frames][-1]


def moving(speeds: np.ndarray) -> Any:
    """A recording of particles with speeds (F, N) [m/s], and what else styles can show of them."""
    count, particles = speeds.shape
    velocities = np.stack([speeds, np.zeros_like(speeds)], axis=2)
    places = np.stack([np.arange(particles, dtype=float), np.zeros(particles)], axis=1)
    scene = pc.Scene(pc.Particles(places, name="dust"))
    positions = np.tile(places, (count, 1, 1))
    channels = {"positions": positions, "velocities": velocities}
    return SimpleNamespace(scene=scene, times=np.arange(count) / 10.0, fps=10.0, positions=positions, channels=channels)


def top(recording: Any, style: Any) -> float:
    """The end of the scale of a style in a film."""
    found = sources(recording, None, None, {})
    with FilmRenderer(found, (160, 120), style, None, DARK, None, False) as made:
        return made._painters[0][0].top


STYLES = [
    pc.styles.Points("speed"),
    pc.styles.Points(lambda time, positions, velocities: np.linalg.norm(velocities, axis=1)),
]


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("frame", [0, 11, 29])
def test_one_frame_does_not_take_all_color(style: Any, frame: int) -> None:
    """Half of all particles are a thousand times faster in one of thirty frames."""
    calm = np.tile(SPEEDS, (30, 1))
    wild = calm.copy()
    wild[frame, ::2] *= 1000.0
    assert top(moving(wild), style) == pytest.approx(top(moving(calm), style), rel=0.01)


@pytest.mark.parametrize("style", STYLES)
def test_a_stray_particle_does_not_take_all_color(style: Any) -> None:
    """Two of a thousand are a thousand times faster in every frame, which is less than 0.5 %."""
    calm = np.tile(SPEEDS, (30, 1))
    wild = calm.copy()
    wild[:, 500:502] *= 1000.0
    assert top(moving(wild), style) == pytest.approx(top(moving(calm), style), rel=0.01)


@pytest.mark.parametrize("style", STYLES)
def test_what_moves_for_a_part_of_the_film_has_all_colors(style: Any) -> None:
    """An impact of three in thirty frames, in which one particle in a hundred takes part, is within the scale."""
    speeds = np.tile(0.001 * SPEEDS, (30, 1))
    speeds[10:13, :10] = 2.0
    assert top(moving(speeds), style) == pytest.approx(2.0)


@pytest.mark.parametrize("given_top", [1e-3, 0.7, 50.0])
@pytest.mark.parametrize("color", ["speed", "energy", lambda time, positions, velocities: velocities[:, 0]])
def test_a_given_end_is_kept_exactly(color: Any, given_top: float) -> None:
    assert top(moving(np.tile(SPEEDS, (30, 1))), pc.styles.Points(color, top=given_top)) == given_top


@given(st.integers(1, 120), st.integers(0, 2**32 - 1))
def test_few_values_are_beyond_the_end(count: int, seed: int) -> None:
    """At most one value in 200 of a frame, in all frames but 2 %, and at least one frame where there are ten."""
    frames = np.random.default_rng(seed).lognormal(0.0, 2.0, (count, 400))
    beyond = (frames > end(frames)).mean(axis=1) > 1.0 - TYPICAL / 100.0
    assert beyond.sum() <= max(RARE * count, count >= 10)


@given(st.integers(2, 60), st.floats(1.0, 1e3))
def test_an_end_goes_with_its_values(count: int, factor: float) -> None:
    frames = np.random.default_rng(count).uniform(0.0, 1.0, (count, 50))
    assert end(factor * frames) == pytest.approx(factor * end(frames))
    assert end(frames[::-1]) == end(frames)


def test_what_is_not_a_number_counts_for_nothing() -> None:
    frames = np.tile(SPEEDS, (5, 1))
    frames[2] = np.nan
    assert end(frames) == end(np.tile(SPEEDS, (5, 1)))
    assert end(np.full((3, 4), np.inf)) == 0.0
    assert end(np.empty((3, 0))) == 0.0


@pytest.mark.parametrize(
    ("low", "high", "ends"),
    [(0.2, 0.9, (0.2, 0.9)), (-3.0, -1.0, (-3.0, -1.0)), (-0.5, 2.0, (-2.0, 2.0)), (4.0, 4.0, (4.0, 8.0))],
)
def test_a_reaction_of_ones_own_is_drawn_from_its_smallest_to_its_largest_value(
    low: float, high: float, ends: tuple[float, float]
) -> None:
    """About zero if it has both signs. The values, a ramp, stay as they are; a constant has a scale of some length."""
    grid = pc.Grid((60, 40), 0.1)
    reaction = pc.Reaction(("n",), lambda n: (0.0 * n,))
    values = low + (high - low) * np.linspace(0.0, 1.0, 60)[:, np.newaxis] + np.zeros((60, 40))
    scene = pc.Scene(pc.ReactionDiffusion(grid, reaction, {"n": 0.0}, {"n": values}))
    recording = pc.simulate(scene, 0.1, 20.0, dt=0.05, progress=False)
    found = sources(recording, None, None, {})
    with FilmRenderer(found, (160, 120), None, None, DARK, None, False) as made:
        scale = made._painters[0][0].scale
    assert scale is not None
    # The ends are 99.5th percentiles, which are within one of the 60 columns.
    assert scale.ends == pytest.approx(ends, abs=(high - low) / 59 + 1e-12)
