"""Rigid bodies, particles and boundaries that overlap at the start: refused or warned of, with path, depth and cure."""

from __future__ import annotations

import re

import numpy as np
import pytest

import physcore as pc

RADIUS = 0.2
HEIGHT = 1.0
GRAVITY = pc.Gravity((0.0, -9.81))


def disc(x: float, *, fixed: bool = False) -> pc.RigidBody:
    return pc.RigidBody(pc.Disc(RADIUS), (x, HEIGHT), fixed=fixed, name=f"disc at {x:g}")


def particles(depth: float, radius: float = 0.0) -> pc.Particles:
    """Two particles far away, and one that reaches into a disc."""
    return pc.Particles(
        [(5.0, HEIGHT), (6.0, HEIGHT), (RADIUS + radius - depth, HEIGHT)], radius=radius, mass=0.1, name="dust"
    )


def rope(depth: float) -> pc.SpringNetwork:
    return pc.rope(5, 0.25, 1e3, start=(RADIUS - depth, HEIGHT), direction=(1.0, 0.0), name="rope")


@pytest.mark.parametrize("fixed", [False, True])
@pytest.mark.parametrize(
    ("other", "path"),
    [
        (lambda depth: particles(depth), "bodies['dust'].positions[2]"),
        (lambda depth: particles(depth, 0.05), "bodies['dust'].positions[2]"),
        (lambda depth: rope(depth), "bodies['rope'].positions[0]"),
    ],
)
def test_particles_within_rigid_bodies_are_refused_and_just_within_warned_of(other, path, fixed):
    body = disc(0.0, fixed=fixed)
    deep = pc.Scene(body, other(0.1), GRAVITY)
    message = f"{path}: expected a particle outside of rigid bodies, got one that is 1.000e-1 m within {body_path(0.0)}"
    with pytest.raises(pc.SceneError, match=re.escape(message)):
        pc.Simulation(deep)
    shallow = pc.Scene(body, other(1e-4), GRAVITY)
    message = f"{path}: overlaps {body_path(0.0)} at the start by 1.00e-4 m"
    with pytest.warns(pc.SceneWarning, match=re.escape(message)) as warned:
        plan = pc.Simulation(shallow).plan
    assert len(warned) == 1
    assert "place them 1.00e-4 m farther apart" in str(warned[0].message)
    assert str(warned[0].message) in plan.notes
    for apart in (0.0, -0.01):
        pc.Simulation(pc.Scene(body, other(apart), GRAVITY)).step()


def body_path(x: float) -> str:
    return f"bodies['disc at {x:g}']"


def test_bodies_within_each_other_or_boundaries_are_refused_and_just_within_warned_of():
    floor = pc.Floor(HEIGHT - RADIUS, restitution=0.0)
    for low in (0.1, 1e-4):
        below = pc.Floor(HEIGHT - RADIUS + low, restitution=0.0)
        pairs = {
            f"{body_path(2.0 * RADIUS - low)}: overlaps {body_path(0.0)}": (disc(0.0), disc(2.0 * RADIUS - low), floor),
            f"boundaries[0]: overlaps {body_path(0.0)}": (disc(0.0), below),
        }
        for message, items in pairs.items():
            scene = pc.Scene(*items, GRAVITY)
            if low == 0.1:
                with pytest.raises(pc.SceneError, match=r"which overlap by 1\.000e-1 m .*they may touch"):
                    pc.Simulation(scene)
            else:
                with pytest.warns(pc.SceneWarning, match=re.escape(f"{message} at the start by 1.00e-4 m")):
                    pc.Simulation(scene)
    pc.Simulation(pc.Scene(disc(0.0), disc(2.0 * RADIUS), floor, GRAVITY)).step()


def test_particles_that_are_tied_or_joined_may_be_within_bodies():
    body, within = disc(0.0), rope(0.05)
    pc.Simulation(pc.Scene(body, within, pc.Anchor(within, [0], body), GRAVITY)).step()
    bead = pc.Particles([(0.1, HEIGHT)], mass=0.1)
    pc.Simulation(pc.Scene(body, bead, pc.Rod(body, bead), GRAVITY)).step()


def test_fluids_within_rigid_bodies_are_refused():
    grid = np.stack(np.meshgrid(*[np.arange(0.025, 1.0, 0.05)] * 2), axis=-1).reshape(-1, 2)
    body = pc.RigidBody(pc.Disc(RADIUS), (0.5, 0.5))
    scene = pc.Scene(body, pc.Fluid(grid, 0.05), pc.Box((0.0, 0.0), (1.0, 1.0)), GRAVITY)
    with pytest.raises(pc.SceneError, match=r"bodies\[1\].positions: expected fluid outside of rigid bodies"):
        pc.Simulation(scene)
