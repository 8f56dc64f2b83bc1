"""Joints of rigid bodies in films: where they are drawn, when they vanish, and the arrows of their forces."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import physcore as pc
from film.scripted import ABOVE, CENTERED, SIZE, at, covered, films, picture, recorded

PENDULUM = pc.RigidBody(pc.Rectangle(0.1, 0.5), (0.0, -0.25), name="bar")


def test_an_anchor_turns_with_a_body_that_is_turned_at_the_start() -> None:
    """A bar along y, whose shape lies along x, is turned back by a quarter: its end above the center comes to the
    right.
    """
    bar = pc.RigidBody(pc.Rectangle(0.5, 0.1), (0.0, -0.25), 0.5 * math.pi)
    scene = pc.Scene(bar, pc.Hinge(bar, None, (0.0, 0.0)))
    shot = films(recorded(scene, [{"angles": [0.0]}]), pc.styles.Solids("#800000", marks=False), CENTERED)[0]
    assert at(shot, 0.25, -0.25).min() > 200.0


def test_a_pin_is_at_the_hinge_and_moves_with_the_bodies() -> None:
    """The anchor turns with the body: at the end of the bar, above its center, then beside it."""
    hinge = pc.Hinge(PENDULUM, None, (0.0, 0.0))
    scene = pc.Scene(PENDULUM, hinge)
    style = pc.styles.Solids("#800000", marks=False)
    (shot,) = films(recorded(scene), style, CENTERED)
    assert at(shot, 0.0, 0.0).min() > 200.0
    (bare,) = films(recorded(scene), pc.styles.Solids("#800000", marks=False, joints=False), CENTERED)
    assert at(bare, 0.0, -0.03).min() < 60.0
    # Joined to another body, the pin is on that body too.
    other = pc.RigidBody(pc.Disc(0.1), (0.0, 0.1), name="disc")
    joint = pc.BallJoint(PENDULUM, other, (0.0, 0.0))
    turned = {"rigid_positions": [[0.35, 0.1], [0.0, 0.1]], "angles": [0.5 * math.pi, 0.0]}
    (moved,) = films(recorded(pc.Scene(PENDULUM, other, joint), [turned]), style, CENTERED)
    assert at(moved, 0.1, 0.1).min() > 200.0


@pytest.mark.parametrize("kind", ["rod", "spring"])
def test_rods_and_springs_join_their_anchors(kind: str) -> None:
    """There is a line, or a zigzag about the line, from one anchor to the other; a spring is wider than a rod."""
    ends = [(0.0, -0.25), (0.0, 0.5)]
    spring = pc.SpringJoint(PENDULUM, None, ends, stiffness=1.0)
    joint = pc.Rod(PENDULUM, None, ends) if kind == "rod" else spring
    scene = pc.Scene(PENDULUM, joint)
    shot, bare = (films(recorded(scene), pc.styles.Solids(joints=on), CENTERED)[0] for on in (True, False))
    rows, columns = np.argwhere((np.abs(shot - bare) > 20.0).any(axis=2)).T
    between = rows < 78  # above the bar
    assert set(rows[between]) >= set(range(32, 77))
    assert np.abs(columns[between] + 0.5 - 100.0).max() < (5.0 if kind == "rod" else 8.0)
    assert (np.ptp(columns[between]) > 5) == (kind == "spring") or kind == "rod"


def test_a_rail_is_as_long_as_the_limits_of_its_slider() -> None:
    """From 0.2 m below to 0.6 m above the start of the body, which has moved beyond the picture."""
    body = pc.RigidBody(pc.Rectangle(0.1, 0.1), (0.0, 0.0))
    scene = pc.Scene(body, pc.Prismatic(body, None, (1.0, 0.0), lower=-0.2, upper=0.6))
    shot = films(recorded(scene, [{"rigid_positions": [[0.0, 5.0]]}]), pc.styles.Solids(), CENTERED)[0]
    columns = np.argwhere(covered(shot)[80:90].any(axis=0)).ravel()
    assert columns.min() == pytest.approx(80, abs=4)
    assert columns.max() == pytest.approx(160, abs=4)


def test_broken_joints_vanish() -> None:
    """A joint that bore a force and bears none any more is broken, and one whose anchors have parted. A joint that
    cannot break stays.
    """
    for strength, force in itertools.product((100.0, math.inf), (True, False)):
        hinge = pc.Hinge(PENDULUM, None, (0.0, 0.0), breaking_force=strength)
        scene = pc.Scene(PENDULUM, hinge)
        later = {} if force else {"rigid_positions": [[0.0, -0.3]]}
        moves = [{"joint_forces": [[0.0, 50.0]]}, {**later, "joint_forces": [[0.0, 0.0 if force else 50.0]]}]
        first, last = films(recorded(scene, moves), pc.styles.Solids("#800000", marks=False), CENTERED)
        offset = 0.0 if force else -0.05
        assert at(first, 0.0, 0.0).min() > 200.0
        assert (at(last, 0.0, offset).min() > 200.0) == math.isinf(strength)


def test_arrows_show_the_forces_of_joints() -> None:
    """Half the given force makes half the arrow, in its direction, from the anchor."""
    scene = pc.Scene(PENDULUM, pc.Hinge(PENDULUM, None, (0.0, 0.0)))
    lengths = []
    for force in ([[0.0, 5.0]], [[0.0, 10.0]], [[10.0, 0.0]]):
        recording = recorded(scene, [{"joint_forces": force}])
        shot, bare = (films(recording, pc.styles.Solids(forces=each), CENTERED)[0] for each in (10.0, False))
        red = np.argwhere(shot[..., 0] - bare[..., 0] > 30.0)
        lengths.append((80.0 - red[:, 0].min(), red[:, 1].max() - 100.0))
    longest = 0.15 * math.sqrt(SIZE[0] * SIZE[1])
    assert lengths[0][0] == pytest.approx(0.5 * longest, abs=2.0)
    assert lengths[1][0] == pytest.approx(longest, abs=2.0)
    assert lengths[2][1] == pytest.approx(longest, abs=2.0)


def test_joints_in_space_are_drawn_where_they_are() -> None:
    """An axle ends in front of the body that it goes through; a ball joint outside of the body is seen."""
    door = pc.RigidBody(pc.Cuboid(0.6, 0.4, 0.1), (0.2, 0.0, 0.0), name="door")
    hinge = pc.Hinge(door, None, (0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0))
    joint = pc.BallJoint(door, None, (-0.5, 0.0, 0.0))
    style = pc.styles.Solids("#800000", marks=False)
    bare = picture(pc.Scene(door, hinge, joint), ABOVE, style=pc.styles.Solids("#800000", marks=False, joints=False))
    shot = picture(pc.Scene(door, hinge, joint), ABOVE, style=style)
    for x in (0.0, -0.5):
        assert at(shot, x, 0.0).min() > at(bare, x, 0.0).min() + 60.0
