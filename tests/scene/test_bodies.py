"""Bodies: what broadcasts, what is refused, and that nothing can change them."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from fractions import Fraction

import numpy as np
import pytest

import physcore as pc

TRIANGLE = [[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]]
SIDES = [[0, 1], [1, 2], [2, 0]]


def test_scalars_broadcast_to_every_particle():
    body = pc.Particles(TRIANGLE, velocities=2, mass=3, charge=-1, radius=0.5)
    assert body.velocities.shape == (3, 2)
    assert (body.velocities == 2.0).all()
    assert body.mass.tolist() == [3.0] * 3
    assert body.charge.tolist() == [-1.0] * 3
    assert body.radius.tolist() == [0.5] * 3
    assert not body.fixed.any()
    assert len(body) == 3
    assert body.dimension == 2


def test_one_velocity_is_repeated_for_every_particle():
    assert pc.Particles(TRIANGLE, velocities=[1, 2]).velocities.tolist() == [[1.0, 2.0]] * 3


def test_a_body_has_its_own_read_only_arrays():
    given = np.array(TRIANGLE)
    body = pc.SpringNetwork(given, SIDES, stiffness=1.0)
    given[:] = 7.0
    assert body.positions.tolist() == TRIANGLE
    for field in dataclasses.fields(body):
        value = getattr(body, field.name)
        if isinstance(value, np.ndarray):
            with pytest.raises(ValueError, match="read-only"):
                value[:] = 0
    with pytest.raises(dataclasses.FrozenInstanceError):
        body.mass = np.ones(3)


def test_any_real_numbers_in_any_layout_will_do():
    """Integers, fractions, read-only and strided arrays, and masked ones without a masked entry."""
    wanted = [[0.0, 1.0], [2.0, 3.0]]
    strided = np.asfortranarray(np.arange(16.0).reshape(4, 4))[::2, :2] // 4 * 2 + [0, 1]
    strided[1] = [2, 3]
    strided.flags.writeable = False
    for given in (
        np.array(wanted, dtype=np.int8),
        [[Fraction(0), 1], [2, Fraction(3)]],
        strided.T.copy().T,
        np.ma.array(wanted),
    ):
        assert pc.Particles(given).positions.tolist() == wanted


def test_a_message_is_short_however_much_was_passed():
    with pytest.raises(pc.SceneError) as caught:
        pc.Gravity(list(range(100_000)))
    assert len(str(caught.value)) < 200


@pytest.mark.parametrize("twin", [copy.copy, copy.deepcopy, lambda body: pickle.loads(pickle.dumps(body))])
def test_a_copied_body_is_read_only_too(twin):
    body = twin(pc.SpringNetwork(TRIANGLE, SIDES, stiffness=1.0, name="triangle"))
    assert (body.name, body.positions.tolist(), body.pairs.tolist()) == ("triangle", TRIANGLE, SIDES)
    assert not body.positions.flags.writeable
    assert not body.pairs.flags.writeable


def test_bodies_are_keys_by_identity():
    one, other = pc.Particles(TRIANGLE), pc.Particles(TRIANGLE)
    assert one != other
    assert {one: 1, other: 2}[one] == 1


@pytest.mark.parametrize(
    ("fixed", "expected"),
    [
        (None, [False, False, False]),
        (True, [True, True, True]),
        ([False, True, False], [False, True, False]),
        ([0, 2], [True, False, True]),
        ([-1], [False, False, True]),
        (1, [False, True, False]),
        ([], [False, False, False]),
        (np.array([0, 1, 1]), [True, True, False]),
    ],
)
def test_fixed_is_a_mask_or_indices(fixed, expected):
    assert pc.Particles(TRIANGLE, fixed=fixed).fixed.tolist() == expected


def test_no_particle_is_a_body_too():
    body = pc.SpringNetwork(np.empty((0, 3)), [], stiffness=1.0)
    assert len(body) == 0
    assert body.dimension == 3
    assert body.pairs.shape == (0, 2)


def test_springs_are_at_rest_by_default():
    assert pc.SpringNetwork(TRIANGLE, SIDES, stiffness=1.0).rest_length.tolist() == [3.0, 5.0, 4.0]


def test_springs_take_one_value_or_one_each():
    network = pc.SpringNetwork(TRIANGLE, SIDES, stiffness=[1, 2, 3], damping=0.5, rest_length=[1, 1, 2])
    assert network.stiffness.tolist() == [1.0, 2.0, 3.0]
    assert network.damping.tolist() == [0.5] * 3
    assert network.rest_length.tolist() == [1.0, 1.0, 2.0]


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (
            lambda: pc.Particles([0.0, 0.0]),
            r"Particles.positions: must have the shape \(N, 2\) or \(N, 3\), got \(2,\)",
        ),
        (lambda: pc.Particles([[0.0, 0.0, 0.0, 0.0]]), "Particles.positions: must have the shape"),
        (lambda: pc.Particles([[0.0, 0.0], [0.0]]), "Particles.positions: must be a regular array"),
        (lambda: pc.Particles([["a", "b"]]), "Particles.positions: must be an array of real numbers"),
        (lambda: pc.Particles([[0.0, 1j]]), "Particles.positions: must be an array of real numbers"),
        (
            lambda: pc.Particles([*TRIANGLE, [0.0, None]]),
            r"Particles.positions\[3, 1\]: must be a number, got None",
        ),
        (
            lambda: pc.Particles(np.ma.masked_greater(TRIANGLE, 3.5)),
            "Particles.positions: must not have masked entries",
        ),
        (lambda: pc.Particles(TRIANGLE, fixed=[[0], [1, 2]]), "Particles.fixed: must be a regular array"),
        (
            lambda: pc.Particles(TRIANGLE, fixed=np.ma.array([0, 1], mask=[0, 1])),
            "Particles.fixed: must not have masked entries",
        ),
        (lambda: pc.SpringNetwork(TRIANGLE, [[0], [1, 2]], 1.0), "SpringNetwork.pairs: must be a regular array"),
        (lambda: pc.Particles([[0.0, float("nan")]]), r"Particles.positions\[0, 1\]: must be finite, got nan"),
        (lambda: pc.Particles(TRIANGLE, velocities=[1, 2, 3]), r"Particles.velocities: must broadcast to .*\(3, 2\)"),
        (lambda: pc.Particles(TRIANGLE, velocities=float("inf")), "Particles.velocities: must be finite"),
        (lambda: pc.Particles(TRIANGLE, mass=0.0), r"Particles.mass\[0\]: must be > 0"),
        (lambda: pc.Particles(TRIANGLE, mass=[1, -2, 1]), r"Particles.mass\[1\]: must be > 0 .*, got -2"),
        (lambda: pc.Particles(TRIANGLE, mass=[1, 2]), r"Particles.mass: must broadcast to the shape \(3,\)"),
        (lambda: pc.Particles(TRIANGLE, radius=-1), r"Particles.radius\[0\]: must be ≥ 0"),
        (lambda: pc.Particles(TRIANGLE, fixed=[3]), "Particles.fixed: index 3 is outside of the 3 particles"),
        (lambda: pc.Particles(TRIANGLE, fixed=[True]), "Particles.fixed: a mask must have 3 entries"),
        (lambda: pc.Particles(TRIANGLE, fixed=[0.5]), "Particles.fixed: must be a bool mask or integer indices"),
        (lambda: pc.Particles(TRIANGLE, name=3), "Particles.name: must be a string"),
        (lambda: pc.SpringNetwork(TRIANGLE, [[0, 3]], 1.0), r"SpringNetwork.pairs\[0, 1\]: index 3 is outside"),
        (lambda: pc.SpringNetwork(TRIANGLE, [[0, 1], [2, 2]], 1.0), r"SpringNetwork.pairs\[1\]: connects particle 2"),
        (lambda: pc.SpringNetwork(TRIANGLE, [[0.0, 1.0]], 1.0), "SpringNetwork.pairs: must be integers"),
        (lambda: pc.SpringNetwork(TRIANGLE, [0, 1], 1.0), r"SpringNetwork.pairs: must be integers of shape \(M, 2\)"),
        (lambda: pc.SpringNetwork(TRIANGLE, SIDES, [1, -1, 1]), r"SpringNetwork.stiffness\[1\]: must be ≥ 0, got -1"),
        (lambda: pc.SpringNetwork(TRIANGLE, SIDES, 1.0, damping=-1), r"SpringNetwork.damping\[0\]: must be ≥ 0"),
        (
            lambda: pc.SpringNetwork(TRIANGLE, SIDES, 1.0, rest_length=-1),
            r"SpringNetwork.rest_length\[0\]: must be ≥ 0",
        ),
    ],
)
def test_bad_input_is_refused_with_its_path(build, message):
    with pytest.raises(pc.SceneError, match=message) as caught:
        build()
    assert isinstance(caught.value, ValueError)
