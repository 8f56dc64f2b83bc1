"""Forces on rigid bodies that depend on velocity, under joints and contacts: orders of convergence, and booked work."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import physcore as pc

G = 9.81
DOWN = pc.Gravity((0.0, -G))


def vane():
    """A weather vane that turns into the wind."""
    plate = pc.RigidBody(pc.Rectangle(1.0, 0.02), (0.4, 0.0), mass=0.5)
    return plate, pc.Scene(plate, pc.Hinge(plate, None, (0.0, 0.0)), pc.Wind((3.0, 2.0), tangential=0.0))


def pinwheel():
    """Four blades, each turned by 0.4 rad about its own axis, that the wind along the axle sets in motion."""
    blades = []
    for turn in 0.5 * math.pi * np.arange(4):
        c, s, cos, sin = math.cos(0.2), math.sin(0.2), math.cos(0.5 * turn), math.sin(0.5 * turn)
        center = (0.25 * math.cos(turn), 0.25 * math.sin(turn), 0.0)
        blades.append((pc.Cuboid(0.4, 0.1, 0.005), center, (cos * c, cos * s, sin * s, sin * c)))
    wheel = pc.RigidBody(pc.Compound(blades), (0.0, 0.0, 0.0), mass=0.2)
    axle = pc.Hinge(wheel, None, (0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0))
    return wheel, pc.Scene(wheel, axle, pc.Wind((0.5, 0.0, 5.0), tangential=0.0))


def slider():
    """A disc that slides on a floor, in a wind that brakes and lifts it, and does not come to roll."""
    disc = pc.RigidBody(pc.Disc(0.1), (0.0, 0.1), velocity=(4.0, 0.0), mass=0.5, friction=0.1)
    floor = pc.Floor(0.0, restitution=0.0, friction=0.1)
    return disc, pc.Scene(disc, floor, pc.Wind((0.5, 0.3), density=2.0, tangential=0.2), DOWN)


def damped():
    """A bar on a hinge, with a damped spring at its end."""
    bar = pc.RigidBody(pc.Rectangle(0.6, 0.1), (0.3, 0.0), mass=2.0)
    spring = pc.SpringJoint(bar, None, [(0.6, 0.0), (0.9, 0.5)], 50.0, damping=3.0)
    return bar, pc.Scene(bar, pc.Hinge(bar, None, (0.0, 0.0)), spring, DOWN)


def tail(tie):
    """A bar on a hinge, with a damped rope at its end that drags through the air."""
    rope = pc.rope(5, 0.5, 200.0, damping=0.4, mass=0.02, start=(0.6, 0.0), direction=(1.0, 0.0))
    bar = pc.RigidBody(pc.Rectangle(0.6, 0.05), (0.3, 0.0), mass=0.3)
    end = pc.Anchor(rope, 0, bar) if tie else pc.BallJoint(bar, (rope, 0), (0.6, 0.0))
    return bar, pc.Scene(rope, bar, end, pc.Hinge(bar, None, (0.0, 0.0)), pc.Drag(linear=0.05), DOWN)


def tied():
    return tail(True)


def jointed():
    return tail(False)


@pytest.mark.parametrize(
    ("build", "rate"), [(vane, 200), (pinwheel, 200), (slider, 200), (damped, 200), (tied, 1000), (jointed, 1000)]
)
def test_steps_and_their_energies_are_of_order_two(build, rate):
    """For half the step, errors of the motion and of the energy balance are a quarter."""
    body, scene = build()
    ends, drifts = [], []
    for factor in (1, 2, 4):
        run = pc.simulate(scene, 0.5, dt=1 / (factor * rate), fps=20)
        part = run[body]
        turn = part.angles[-1] if scene.dimension == 2 else part.orientations[-1, 0]
        ends.append(np.concatenate([part.positions[-1, 0], turn]))
        drifts.append(np.abs(run.energy.drift).max())
        assert run.energy.dissipated[-1] > 0.01
    first, second = (np.linalg.norm(one - other) for one, other in pairwise(ends))
    assert 3.8 < first / second < 4.2
    assert 3.8 < drifts[0] / drifts[1] < 4.2
    assert 3.8 < drifts[1] / drifts[2] < 4.2


def test_changing_gravity_does_no_work_on_a_body_at_rest():
    """Its power is that of the velocity which the floor leaves: none."""
    box = pc.RigidBody(pc.Rectangle(0.4, 0.2), (0.0, 0.1), mass=2.0)
    gravity = pc.Gravity(lambda time: (0.0, -G - 3.0 * math.sin(time)))
    run = pc.simulate(pc.Scene(box, pc.Floor(0.0, restitution=0.0), gravity), 1.0, dt=1 / 100)
    assert np.abs(run.energy.work).max() < 1e-12


@pytest.mark.parametrize("sequential", [32, 0])
def test_bounces_under_drag_leave_the_energy_balance_without_bias(sequential):
    """A step of h with an impact after τ errs by γ v² (h − 2τ), of either sign.

    With the velocities before impacts, each would add γ v² h. The sum over n impacts at times without a rule is within
    3 γ v² h √(n/3) in 997 of 1000 cases. Sweeps take an impact at the end of a quarter of a step.
    """
    drag, dt, speed, span, count = 0.02, 1 / 100, 1.0, 0.8, 20
    disc = pc.RigidBody(
        pc.Disc(0.1),
        (0.0, 0.0),
        velocity=(speed, 0.0),
        mass=1.0,
        friction=0.0,
        restitution=1.0,
    )
    walls = [pc.Plane((0.5 * side, 0.0), (-side, 0.0), restitution=1.0, friction=0.0) for side in (-1.0, 1.0)]
    scene, solver = pc.Scene(disc, *walls, pc.Drag(linear=drag)), pc.ContactSolver(sequential=sequential)
    run = pc.simulate(scene, count * span / speed, dt=dt, fps=10, contacts=solver)
    assert np.abs(run.energy.drift).max() < 3.0 * drag * speed**2 * dt * math.sqrt(count / 3.0)
