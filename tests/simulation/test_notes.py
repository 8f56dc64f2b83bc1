"""What a plan notes beforehand and afterwards: scenes that were hardly meant so, and balances that do not hold."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physcore.simulation.effort import MOST_STEPS

UPRIGHT = ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))


def sheet(axes=UPRIGHT, **options):
    return pc.cloth((5, 4), 0.1, 100.0, damping=0.02, mass=0.01, origin=(0.0, 0.0, 0.3), axes=axes, **options)


def edge_on(*items):
    return any("edge-on" in note for note in pc.Simulation(pc.Scene(*items, pc.Gravity())).plan.notes)


def test_a_cloth_that_falls_edge_on_is_noted_and_does_stay_flat():
    scene = pc.Scene(sheet(), pc.Gravity(), pc.Floor(restitution=0.5))
    assert edge_on(sheet(), pc.Floor())
    assert edge_on(sheet(), pc.Drag(0.1), pc.Sphere((0.2, 0.0, 0.0), 0.1))
    assert edge_on(pc.rope(5, 0.4, 10.0, start=(0.0, 0.1), direction=(0.0, 1.0)), pc.Floor())
    assert np.ptp(pc.simulate(scene, 0.5).positions[..., 1]) == 0.0


@pytest.mark.parametrize(
    "items",
    [
        (sheet(),),  # It falls for ever.
        (sheet(pinned="top"), pc.Floor()),
        (sheet(axes=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))), pc.Floor()),
        (sheet(axes=((1.0, 0.0, 0.0), (0.0, 0.1, 1.0))), pc.Floor()),
        (sheet(), pc.Floor(), pc.Drag(0.1, wind=(0.0, 1.0, 0.0))),
        (sheet(), pc.Sphere((0.2, 0.01, 0.0), 0.1)),
        (sheet(), pc.Plane((0.0, 0.0, 0.0), (0.0, 0.1, 1.0))),
    ],
)
def test_where_the_balance_is_broken_nothing_is_noted(items):
    assert not edge_on(*items)


def test_a_plane_that_nothing_touches_is_noted():
    ball = pc.Particles([[0.0, 1.0]], radius=0.1)
    far, near = pc.Plane((5.0, 0.0), (-1.0, 0.0)), pc.Floor(restitution=0.9)
    notes = pc.simulate(pc.Scene(ball, pc.Gravity(), far, near), 1.0).plan.notes
    assert [note for note in notes if "touched" in note] == [
        "boundaries[0]: nothing touched this Plane, the nearest was 4.9 m away"
    ]


def test_a_bounce_between_two_frames_is_a_touch():
    ball = pc.Particles([[0.0, 0.2]], velocities=[[0.0, -9.0]], radius=0.1)
    recording = pc.simulate(pc.Scene(ball, pc.Floor()), 0.2, fps=10)
    assert recording.positions[..., 1].min() > 0.15
    assert not any("touched" in note for note in recording.plan.notes)


def spring():
    return pc.Scene(
        pc.Particles([[0.1, 0.0]]), pc.CustomForce(lambda time, x, v: -1e4 * x, lambda x: 5e3 * (x**2).sum())
    )


def test_a_balance_that_does_not_hold_is_noted_and_warned_of():
    with pytest.warns(pc.StabilityWarning, match=r"the energy balance drifted by 0\.\d+ .*AutoStep\(safety=0.1\)"):
        recording = pc.simulate(spring(), 1.0, dt=pc.AutoStep())
    assert "look at dt" in recording.plan.notes[-1]
    given = pc.simulate(spring(), 1.0, dt=0.4 * 0.02)
    assert "look at dt" in given.plan.notes[-1]  # It was given: a drift of 0.16 is noted without a warning.
    with pytest.warns(pc.StabilityWarning, match=r"drifted by 0\.8\d* .*take dt=0\.002, and"):
        pc.simulate(spring(), 3.0, dt=0.95 * 0.02)
    fine = pc.simulate(spring(), 1.0)
    assert not any("look at dt" in note for note in fine.plan.notes)


class Stopped(Exception):
    """Raised in the first step of a run that would never end."""


def test_a_run_of_too_many_steps_is_warned_of_before():
    dt = 1e-9

    def force(time, x, v):
        if time > 10 * dt:
            raise Stopped
        return 0.0 * x

    scene = pc.Scene(pc.Particles([[0.0, 0.0]]), pc.CustomForce(force))
    for run in (lambda simulation: simulation.run(1.0), lambda simulation: simulation.record(1.0)):
        simulation = pc.Simulation(scene, dt=dt)
        message = r"duration: 1 s are 1\.0e\+09 steps of 1e-09 s: leave dt to"
        with pytest.warns(pc.SceneWarning, match=message), pytest.raises(pc.SceneError):
            run(simulation)
    atoms = pc.Scene(pc.Particles([[0.0, 0.0], [0.1, 0.0]]), pc.LennardJones(1.0, 1.0, 2.5))
    with pytest.warns(pc.SceneWarning, match="because of Lennard-Jones: move apart"):
        next(pc.Simulation(atoms).frames(1.0))


def test_a_run_of_many_steps_is_not(recwarn):
    simulation = pc.Simulation(pc.Scene(pc.Particles([[0.0, 0.0]])), dt=1.0 / MOST_STEPS)
    next(simulation.frames(0.99))
    assert not recwarn.list


def pendulum():
    """A double pendulum of rods from the horizontal, whose rods turn ever faster."""
    chain = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], pairs=[[0, 1], [1, 2]], stiffness=np.inf, fixed=[0])
    return pc.Scene(chain, pc.Gravity((0.0, -9.81)))


def test_a_given_step_near_a_limit_that_varies_is_noted():
    limit = pc.Simulation(pendulum(), integrator="RATTLE").plan.dt_limit
    for share, expected in ((0.98, True), (0.4, False)):
        plan = pc.Simulation(pendulum(), integrator="RATTLE", dt=share * limit).plan
        assert plan.limit_kind == "accuracy"
        assert any("limit of 0.16 s (rods) is that of the present state" in note for note in plan.notes) == expected
    constant = pc.Scene(pc.rope(5, 1.0, 100.0, pinned="start"))
    spring = pc.Simulation(constant, dt=0.9 * pc.Simulation(constant, integrator="VelocityVerlet").plan.dt_limit)
    assert not any("present state" in note for note in spring.plan.notes)


def test_bodies_at_rest_over_a_floor_without_gravity_are_noted():
    def noted(*items):
        notes = pc.Simulation(pc.Scene(*items)).plan.notes
        return any("nothing moves" in note and "this Floor: add" in note for note in notes)

    assert noted(pc.Particles([[0.0, 1.0]]), pc.Floor(0.0))
    assert not noted(pc.Particles([[0.0, 1.0]]), pc.Floor(0.0), pc.Gravity())
    assert not noted(pc.Particles([[0.0, 1.0]], velocities=[[0.0, -1.0]]), pc.Floor(0.0))
    assert not noted(pc.rope(3, 1.0, 10.0), pc.Floor(-1.0))
