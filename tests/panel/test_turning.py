"""Rigid bodies that are turned by hand, and the work of it."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physcore.scene.rotations import planar_rotations, rotation_of, spatial_rotations

pytest.importorskip("websockets", reason="the extra physcore[live] is not installed")

BLOCKS = {
    "2D": pc.RigidBody(pc.Rectangle(0.4, 0.1), (0.0, 1.0), angle=0.3, mass=2.0, name="block"),
    "3D": pc.RigidBody(
        pc.Cuboid(0.4, 0.1, 0.2), (0.0, 1.0, 0.5), orientation=(0.9, 0.2, 0.3, 0.1), mass=2.0, name="block"
    ),
}


def attitude_of(panel):
    part = panel.simulation["block"]
    return planar_rotations(part.angles[0]) if part.positions.shape[1] == 2 else spatial_rotations(part.orientations[0])


@pytest.mark.parametrize("dimension", BLOCKS)
def test_what_is_turned_comes_to_rest_as_it_was_turned(dimension):
    """Motion along a line fades by half in 0.08 s; springs do not damp what circles around their ends."""
    block, vector = BLOCKS[dimension], np.array([0.7] if dimension == "2D" else [0.3, -0.2, 0.6])
    with pc.live(lambda: pc.Scene(block), dt=1 / 500, show=False) as panel:
        before = attitude_of(panel)
        panel.grab("block")
        panel.turn(vector)
        panel.step(2500)
        np.testing.assert_allclose(attitude_of(panel), rotation_of(vector) @ before, atol=0.02)
        np.testing.assert_allclose(panel.simulation["block"].positions, block.positions, atol=1e-3)


@pytest.mark.parametrize("dimension", BLOCKS)
def test_the_work_of_a_turn_is_the_energy_of_its_springs(dimension):
    """About an axis with the moment of inertia I the springs have the energy (k I / m) (1 − cos θ).

    They are fixed to points of the body with its moments of inertia. A point at the distance r from the axis of a turn
    by θ is 2 r sin(θ/2) from its place before.
    """
    block = BLOCKS[dimension]
    moment = block.shape.moment if dimension == "2D" else block.shape.moment[2, 2]
    axis = [1.0] if dimension == "2D" else spatial_rotations(block.orientations[0])[:, 2]
    size = block.shape.properties(block.dimension).size
    with pc.live(lambda: pc.Scene(block), dt=1e-3, show=False) as panel:
        panel.grab("block", stiffness=60.0)
        assert panel.simulation.energy().work == 0.0
        for angle in (0.4, 2.0, 0.4):
            panel.turn(angle * np.array(axis))
            expected = 60.0 * moment / size * (1.0 - np.cos(angle))
            assert panel.simulation.energy().work == pytest.approx(expected, rel=1e-9)
        panel.step(1000)
        held = panel.simulation.energy()
        panel.release()
        free = panel.simulation.energy()
        assert free.work - held.work == pytest.approx(free.total - held.total, rel=1e-9)
        # The method has order 2, and the springs have a frequency of √(60 / 2) rad/s.
        assert abs(free.balance) < 30.0 * 1e-6 * 10.0 * held.dissipated


def test_what_cannot_be_turned_is_told():
    with pc.live(lambda: pc.Scene(pc.rope(5, 1.0, 100.0, name="rope")), show=False) as ropes:
        with pytest.raises(pc.SceneError, match=r"^turn.rotation: nothing is held"):
            ropes.turn(0.1)
        ropes.grab(("rope", 4))
        with pytest.raises(
            pc.SceneError, match=r"^turn.rotation: only a rigid body turns, and a SpringNetwork is held"
        ):
            ropes.turn(0.1)
    with pc.live(lambda: pc.Scene(BLOCKS["3D"]), show=False) as blocks:
        blocks.grab("block")
        with pytest.raises(pc.SceneError, match=r"^turn.rotation: must be a rotation vector of 3 components"):
            blocks.turn(0.1)
