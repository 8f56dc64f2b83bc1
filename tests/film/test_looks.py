"""How obstacles are drawn."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc
from physcore.film import Orbit
from physcore.film.camera.view import View
from physcore.film.looks.solid import FINEST, SAGITTA, SolidLook


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
