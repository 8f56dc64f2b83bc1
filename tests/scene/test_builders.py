"""Builders: where particles and springs are, in which order, and what is pinned."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc


def lengths(network: pc.SpringNetwork) -> np.ndarray:
    ends = network.positions[network.pairs]
    return np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)


def test_a_rope_runs_along_x_from_the_origin():
    rope = pc.rope(5, length=2.0, stiffness=10.0, damping=0.1, mass=0.3, pinned="start")
    assert rope.positions.tolist() == [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.5, 0.0], [2.0, 0.0]]
    assert rope.pairs.tolist() == [[0, 1], [1, 2], [2, 3], [3, 4]]
    assert rope.rest_length.tolist() == [0.5] * 4
    assert rope.stiffness.tolist() == [10.0] * 4
    assert rope.damping.tolist() == [0.1] * 4
    assert rope.mass.tolist() == [0.3] * 5
    assert rope.fixed.tolist() == [True, False, False, False, False]


def test_a_rope_has_a_start_and_a_direction():
    rope = pc.rope(3, 2.0, 1.0, start=(1.0, 2.0, 3.0), direction=(0.0, 0.0, -5.0), pinned="both")
    assert rope.positions.tolist() == [[1.0, 2.0, 3.0], [1.0, 2.0, 2.0], [1.0, 2.0, 1.0]]
    assert rope.fixed.tolist() == [True, False, True]


def test_a_direction_alone_makes_a_rope_3d():
    assert pc.rope(2, 1.0, 1.0, direction=(0.0, 0.0, 1.0)).dimension == 3


def test_a_cloth_is_row_by_row_from_the_lower_left():
    cloth = pc.cloth((3, 2), spacing=0.5, stiffness=1.0, origin=(1.0, 2.0))
    assert cloth.positions.tolist() == [[1.0, 2.0], [1.5, 2.0], [2.0, 2.0], [1.0, 2.5], [1.5, 2.5], [2.0, 2.5]]


def test_the_springs_of_a_cloth_are_listed_kind_by_kind_and_row_by_row():
    cloth = pc.cloth((3, 2), spacing=0.5, stiffness=1.0)
    structural = [[0, 1], [1, 2], [3, 4], [4, 5], [0, 3], [1, 4], [2, 5]]
    shear = [[0, 4], [1, 5], [1, 3], [2, 4]]
    bend = [[0, 2], [3, 5]]
    assert cloth.pairs.tolist() == structural + shear + bend


@given(columns=st.integers(2, 9), rows=st.integers(2, 9), spacing=st.floats(1e-3, 1e3))
def test_a_cloth_has_the_springs_that_a_count_gives_at_exact_uniform_lengths(columns, rows, spacing):
    cloth = pc.cloth((columns, rows), spacing, stiffness=1.0)
    structural = (columns - 1) * rows + columns * (rows - 1)
    shear = 2 * (columns - 1) * (rows - 1)
    bend = (columns - 2) * rows + columns * (rows - 2)
    expected = np.repeat([spacing, spacing * math.sqrt(2.0), 2.0 * spacing], [structural, shear, bend])
    assert (cloth.rest_length == expected).all()
    assert len({tuple(sorted(pair)) for pair in cloth.pairs.tolist()}) == len(cloth.pairs)
    # Coordinates are products of one rounding each, below 9 spacings: lengths are good to a few ulp of that.
    np.testing.assert_allclose(lengths(cloth), expected, rtol=1e-14)


def test_shear_and_bend_springs_have_their_own_strength_or_are_left_out():
    cloth = pc.cloth((3, 3), 1.0, 5.0, damping=0.5, shear_stiffness=0.0, bend_stiffness=2.0, bend_damping=0.1)
    assert cloth.stiffness.tolist() == [5.0] * 12 + [2.0] * 6
    assert cloth.damping.tolist() == [0.5] * 12 + [0.1] * 6


def test_springs_without_stiffness_stay_where_their_damping_was_asked_for():
    cloth = pc.cloth((3, 3), 1.0, 5.0, damping=0.5, shear_stiffness=0.0, shear_damping=0.1, bend_stiffness=0.0)
    assert cloth.stiffness.tolist() == [5.0] * 12 + [0.0] * 8
    assert cloth.damping.tolist() == [0.5] * 12 + [0.1] * 8
    assert pc.rope(3, 1.0, stiffness=0.0, damping=2.0).damping.tolist() == [2.0, 2.0]


def test_axes_put_a_cloth_into_space():
    cloth = pc.cloth((2, 2), 2.0, 1.0, origin=(0.0, 0.0, 1.0), axes=((0.0, 3.0, 0.0), (0.0, 0.0, 0.5)))
    assert cloth.positions.tolist() == [[0.0, 0.0, 1.0], [0.0, 2.0, 1.0], [0.0, 0.0, 3.0], [0.0, 2.0, 3.0]]


@pytest.mark.parametrize(
    ("pinned", "expected"),
    [
        (None, []),
        ("top", [6, 7, 8]),
        ("bottom", [0, 1, 2]),
        ("left", [0, 3, 6]),
        ("right", [2, 5, 8]),
        ("corners", [0, 2, 6, 8]),
        ("top corners", [6, 8]),
        ("bottom corners", [0, 2]),
        (("left", "top"), [0, 3, 6, 7, 8]),
        ([4], [4]),
        (np.arange(9) == 5, [5]),
    ],
)
def test_a_cloth_is_pinned_by_edge_corners_mask_or_indices(pinned, expected):
    assert np.flatnonzero(pc.cloth((3, 3), 1.0, 1.0, pinned=pinned).fixed).tolist() == expected


def test_a_soft_body_in_the_plane_has_axial_springs_and_both_diagonals():
    jelly = pc.soft_body((2, 2), 1.0, 3.0, shear_stiffness=4.0)
    assert {tuple(pair) for pair in jelly.pairs.tolist()} == {(0, 1), (2, 3), (0, 2), (1, 3), (0, 3), (1, 2)}
    assert jelly.stiffness.tolist() == [3.0] * 4 + [4.0] * 2


@given(shape=st.tuples(st.integers(2, 5), st.integers(2, 5), st.integers(2, 5)))
def test_a_soft_body_in_space_joins_neighbors_along_axes_and_face_diagonals(shape):
    x, y, z = shape
    jelly = pc.soft_body(shape, spacing=0.5, stiffness=1.0)
    axial = (x - 1) * y * z + x * (y - 1) * z + x * y * (z - 1)
    diagonal = 2 * ((x - 1) * (y - 1) * z + (x - 1) * y * (z - 1) + x * (y - 1) * (z - 1))
    assert (jelly.rest_length == np.repeat([0.5, 0.5 * math.sqrt(2.0)], [axial, diagonal])).all()
    assert len({tuple(sorted(pair)) for pair in jelly.pairs.tolist()}) == len(jelly.pairs)
    np.testing.assert_allclose(lengths(jelly), jelly.rest_length, rtol=1e-14)


def test_the_sides_of_a_soft_body_have_names():
    jelly = pc.soft_body((2, 3, 4), 1.0, 1.0, pinned=("bottom", "left"))
    expected = (jelly.positions[:, 2] == 0.0) | (jelly.positions[:, 0] == 0.0)
    assert (jelly.fixed == expected).all()
    front = pc.soft_body((2, 3, 4), 1.0, 1.0, pinned="front")
    assert (front.fixed == (front.positions[:, 1] == 0.0)).all()


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: pc.rope(1, 1.0, 1.0), "rope.particles: must be ≥ 2, got 1"),
        (lambda: pc.rope(2.5, 1.0, 1.0), "rope.particles: must be a whole number"),
        (lambda: pc.rope(3, 0.0, 1.0), "rope.length: must be > 0"),
        (lambda: pc.rope(3, 1.0, -1.0), "rope.stiffness: must be ≥ 0, got -1"),
        (lambda: pc.rope(3, 1.0, 1.0, direction=(0.0, 0.0)), "rope.direction: a direction must not be zero"),
        (lambda: pc.rope(3, 1.0, 1.0, start=(0, 0, 0), direction=(1, 0)), "rope.direction: must be 1 × 3 numbers"),
        (lambda: pc.rope(3, 1.0, 1.0, pinned="top"), "rope.pinned: must be one of 'start', 'end', 'both'"),
        (lambda: pc.cloth((1, 2), 1.0, 1.0), r"cloth.shape\[0\]: must be ≥ 2, got 1"),
        (lambda: pc.cloth(3, 1.0, 1.0), r"cloth.shape: must be 2 whole numbers, got 3; write \(columns, rows\)"),
        (lambda: pc.cloth((2, 2), 1.0), "cloth.stiffness: must be a number where there is no material=, got None"),
        (lambda: pc.cloth((2, 2), 1.0, material="silk"), "cloth.material: must be one of physcore.materials, .*'silk'"),
        (lambda: pc.cloth((2, 2), 1.0, 1.0, axes=1.0), "cloth.axes: must be a list of 2 directions, got 1.0"),
        (lambda: pc.cloth((2, 2), 1.0, 1.0, axes=(1, 0)), r"cloth.axes\[0\]: must be 2 or 3 numbers"),
        (lambda: pc.cloth((2, 2), 1.0, 1.0, bend_stiffness=-1.0), "cloth.bend_stiffness: must be ≥ 0"),
        (lambda: pc.cloth((2, 2), 1.0, 1.0, shear_damping=-1.0), "cloth.shear_damping: must be ≥ 0"),
        (lambda: pc.cloth((2, 2), 1.0, 1.0, axes=((1, 0), (1, 1))), "cloth.axes: must be perpendicular"),
        (lambda: pc.cloth((2, 2), 1.0, 1.0, pinned="tpo"), "cloth.pinned: must be one of .*, got 'tpo'"),
        (lambda: pc.soft_body((2, 2, 2, 2), 1.0, 1.0), "soft_body.shape: must be 2 or 3 whole numbers"),
        (lambda: pc.soft_body((2, 2, 2), 1.0, 1.0, origin=(0, 0)), "soft_body.origin: must have 3 components"),
    ],
)
def test_bad_input_is_refused_with_its_path(build, message):
    with pytest.raises(pc.SceneError, match=message):
        build()
