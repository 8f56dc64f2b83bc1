"""How obstacles are drawn."""

from __future__ import annotations

import math
import tracemalloc

import numpy as np
import pytest

import physcore as pc
from physcore.film import Orbit
from physcore.film.camera.view import View
from physcore.film.looks.solid import FINEST, MOST_PARTS, SAGITTA, SolidLook


@pytest.mark.parametrize("scale", [1.0, 30.0, 300.0])
@pytest.mark.parametrize("slenderness", [0.0, 2.0, 300.0])
def test_a_capsule_is_round_and_has_as_many_triangles_as_its_pixels_ask_for(slenderness: float, scale: float) -> None:
    """1 − cos x ≤ x²/2: the sagitta is within its bound where the number of segments is not at its own. Each ring along
    a side is 8 pixels or more long, and the caps have at most 8 q² facets each.
    """
    radius = 0.1
    look = SolidLook(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, slenderness * radius]]), radius)
    view = View(Orbit().axes, np.zeros(3), scale / radius, (320.0, 240.0), math.inf, 1.0)
    corners, normals = look._rounded(view)
    axis = np.clip(corners[..., 2], 0.0, slenderness * radius)
    away = np.linalg.norm(corners - axis[..., np.newaxis] * (0.0, 0.0, 1.0), axis=2)
    np.testing.assert_allclose(away, radius, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=2), 1.0, rtol=1e-12)
    quarter = len(np.unique(np.arctan2(*corners[np.isclose(corners[..., 2], 0.0)].T[:2]).round(9))) / 4
    sagitta = scale * (1.0 - math.cos(math.pi / (4.0 * quarter)))
    assert quarter >= FINEST or sagitta <= SAGITTA
    caps, rings = 16 * FINEST**2, slenderness * scale / 8.0 + 1.0
    assert len(corners) <= caps + rings * 8 * FINEST


def test_a_slender_capsule_takes_less_time_than_its_pixels() -> None:
    """A pole of 480 × 3 pixels: each of its triangles covers a pixel or more."""
    look = SolidLook.capsule(pc.Capsule((0.0, 0.0, 0.0), (0.0, 0.0, 2.0), 0.006))
    view = View(Orbit(elevation=0.0).axes, np.zeros(3), 240.0, (320.0, 240.0), math.inf, 1.0)
    assert len(look._rounded(view)[0]) < 480 * 3


BALLS = {dimension: pc.Particles([[0.0] * (dimension - 1) + [1.0]]) for dimension in (2, 3)}
FAR = {
    "long capsule": lambda size, on: pc.Capsule(-size * on(0, 1.0) - on(-1, 1.0), size * on(0, 1.0), 0.5),
    "thick capsule": lambda size, on: pc.Capsule(-on(-1, size + 1.0), size * on(0, 1.0) - on(-1, size), size),
    "ball": lambda size, on: pc.Sphere(-on(-1, size), size),
    "bowl": lambda size, on: pc.Sphere(on(0, 0.0), size, inside=True),
    "box": lambda size, on: pc.Box(-size * (on(-1, 0.0) + 1.0), size * (on(-1, 0.0) + 1.0)),
    "plane": lambda size, on: pc.Plane(-on(-1, size), on(-1, 1.0)),
    "small capsule": lambda size, on: pc.Capsule(on(0, 3.0), on(0, 3.0) + on(-1, 1.0 / size), 1.0 / size),
    "small ball": lambda size, on: pc.Sphere(on(0, 3.0), 1.0 / size),
}
"""Boundaries by their size, far larger or smaller than the ball beside them; `on` gives a vector along one axis."""


@pytest.mark.parametrize("size", [1e16, 1e90])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("name", FAR)
def test_shapes_of_any_size_are_drawn_in_bounded_memory(name, dimension, size, tmp_path):
    def along(axis: int, length: float) -> np.ndarray:
        return length * np.eye(dimension)[axis]

    scene = pc.Scene(BALLS[dimension], FAR[name](size, along))
    tracemalloc.start()
    try:
        pc.film(scene, tmp_path / "far.png", duration=0.1, fps=10, size=(160, 120))
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 50e6
    assert (tmp_path / "far.png").stat().st_size > 100


def test_a_capsule_has_no_more_parts_than_a_picture_can_show():
    look = SolidLook(np.array([[-1e16, 0.0, 0.0], [1e16, 0.0, 0.0]]), 0.5)
    view = View(Orbit().axes, np.zeros(3), 50.0, (320.0, 240.0), math.inf, 1.0)
    assert len(look._rounded(view)[0]) <= 2 * 4 * FINEST * (MOST_PARTS + 2 * FINEST)
