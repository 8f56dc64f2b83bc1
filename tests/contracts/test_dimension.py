"""Two dimensions are three with one left out."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from contracts import rigid
from contracts.comparison import difference, plain, state, tolerance
from contracts.scenes import SCENES
from contracts.transforms import Transform, moved, transformed

LIFT = Transform(np.array([[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]]))
"""(x, y) → (x, 0, y): up is the last axis in both."""


def flat(name: str) -> bool:
    """Fluids are other in the plane: their kernel is, and what they weigh; point vortices are there alone. Of rigid
    bodies only polygons are: a prism turns about the normal as they do.
    """
    scene = SCENES[name].shared
    if name == "paddle":
        return False  # Both ends of an edge strike at once, one after the other: which is first, rounding decides.
    if not all(isinstance(body.shape, (pc.Rectangle, pc.Polygon)) for body in scene.bodies if body.is_rigid):
        return False
    vortices = any(isinstance(system, pc.PointVortices) for system in scene.systems)
    return scene.dimension == 2 and not scene.fluids and not vortices


@pytest.mark.parametrize("name", [name for name in SCENES if flat(name)])
def test_a_motion_in_a_plane_is_the_same_in_space(name):
    """Nothing leaves the plane; the limit of the time step is the same but for the other direction of springs."""
    case = SCENES[name]
    scene = case.shared
    lifted = case.advance(case.simulation(transformed(scene, LIFT)))
    there = rigid.material(lifted, axes=1) if scene.has_rigid_bodies else state(lifted)
    if scene.bodies and not scene.has_rigid_bodies:  # whose contacts and joints are solved to rounding
        assert not there[0][:, 1].any()
        assert not there[1][:, 1].any()
    expected = moved(LIFT, scene, state(plain(name)))
    assert difference(lifted.scene, expected, there) <= tolerance(name, plain(name))
