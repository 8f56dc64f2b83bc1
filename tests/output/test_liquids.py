"""Surfaces of liquids: closed meshes around the particles."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physcore.output.surfaces import liquid_surface


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
    """Edges and corners are round: the kernel reaches two spacings, and smoothing adds one.

    A radius r takes (1 − π/4) r² off the section of each edge.
    """
    pytest.importorskip("pysplashsurf", reason="pysplashsurf is not installed")
    block = pc.block((1.0, 2.0, 3.0), (1.8, 2.4, 3.6), spacing)
    points, faces, normals = liquid_surface(block, spacing)
    assert is_closed(faces)
    np.testing.assert_allclose(points.min(axis=0), (1.0, 2.0, 3.0), atol=0.12 * spacing)
    np.testing.assert_allclose(points.max(axis=0), (1.8, 2.4, 3.6), atol=0.12 * spacing)
    whole, edges = 0.8 * 0.4 * 0.6, 4 * (0.8 + 0.4 + 0.6)
    assert whole - (1.0 - np.pi / 4.0) * 9.0 * spacing * spacing * edges < volume(points, faces) < whole
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=0.0, atol=1e-6)


def test_nothing_has_no_surface() -> None:
    assert [len(part) for part in liquid_surface(np.empty((0, 3)), 0.1)] == [0, 0, 0]
