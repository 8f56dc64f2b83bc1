"""Surfaces of liquids: closed meshes around the particles."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physcore.output.liquid import surface_of


def volume(points: np.ndarray, faces: np.ndarray) -> float:
    """By the divergence theorem, from faces that are counterclockwise from outside."""
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    return float((a * np.cross(b, c)).sum() / 6.0)


def is_closed(faces: np.ndarray) -> bool:
    """Whether each edge belongs to two triangles, in opposite directions."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    there, back = (np.sort(ends[:, 0] * (faces.max() + 1) + ends[:, 1]) for ends in (edges, edges[:, ::-1]))
    return bool((there == back).all() and (np.diff(there) > 0).all())


@pytest.mark.parametrize("spacing", [0.02, 0.05])
def test_the_surface_of_a_block_is_half_a_spacing_outside_its_particles(spacing: float) -> None:
    """A flat surface is there by the choice of the level, for a continuous liquid; on a lattice within a tenth of a
    spacing. Edges and corners are round, over about a spacing: the volume is less, by at most (1 − π/4) spacing² along
    each edge.
    """
    block = pc.block((1.0, 2.0, 3.0), (1.8, 2.4, 3.6), spacing)
    points, faces = surface_of(block, spacing)
    assert is_closed(faces)
    np.testing.assert_allclose(points.min(axis=0), (1.0, 2.0, 3.0), atol=0.12 * spacing)
    np.testing.assert_allclose(points.max(axis=0), (1.8, 2.4, 3.6), atol=0.12 * spacing)
    whole, area, edges = 0.8 * 0.4 * 0.6, 2 * (0.8 * 0.4 + 0.4 * 0.6 + 0.6 * 0.8), 4 * (0.8 + 0.4 + 0.6)
    least = whole - 0.12 * spacing * area - (1.0 - np.pi / 4.0) * spacing * spacing * edges
    assert least < volume(points, faces) < whole + 0.12 * spacing * area


def test_the_surface_moves_with_the_liquid() -> None:
    """By whole cells with the same triangles. Two drops far apart have two surfaces of one drop's volume."""
    ball = pc.ball((0.0, 0.0, 0.0), 0.2, 0.05)
    points, faces = surface_of(ball, 0.05)
    moved, same = surface_of(ball + np.array([0.05, -0.1, 0.15]) * 5.0, 0.05)
    np.testing.assert_array_equal(faces, same)
    np.testing.assert_allclose(moved, points + np.array([0.25, -0.5, 0.75]), atol=1e-12)
    both, ends = surface_of(np.concatenate([ball, ball + np.array([0.75, 0.0, 0.0])]), 0.05)
    assert is_closed(ends)
    assert volume(both, ends) == pytest.approx(2.0 * volume(points, faces), rel=1e-9)


def test_nothing_has_no_surface() -> None:
    for points in (np.empty((0, 3)), np.full((4, 3), np.nan)):
        places, faces = surface_of(points, 0.1)
        assert (places.shape, faces.shape) == ((0, 3), (0, 3))


def test_drops_too_far_apart_are_refused() -> None:
    with pytest.raises(pc.PhyscoreError, match="the surface of a liquid"):
        surface_of(np.array([[0.0, 0.0, 0.0], [1e6, 1e6, 1e6]]), 0.01)
