"""Rigid bodies that fall asleep, by the public face; rust_core/rigid/src/tests/sleep.rs has when they do and wake."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc

DOWN = pc.Gravity((0.0, -9.81))
FLOOR = pc.Floor(0.0, restitution=0.0, friction=0.5)
DT = 1 / 120
PILE = pc.ContactSolver(sequential=4)
"""Numerics that sweep even small groups."""


def heap(sleep=0.05, **options):
    """Discs that fall into a heap, in columns that lean."""
    places = [(0.24 * (k % 4) + 0.01 * (k // 4), 0.15 + 0.21 * (k // 4)) for k in range(16)]
    walls = [pc.Plane((-0.15, 0.0), (1.0, 0.0), friction=0.5), pc.Plane((0.87, 0.0), (-1.0, 0.0), friction=0.5)]
    discs = pc.RigidBodies(pc.Disc(0.1), places, friction=0.5, name="discs", sleep=sleep)
    return pc.Scene(discs, *walls, FLOOR, DOWN, **options)


def stack(**options):
    """A box on another one, at rest."""
    boxes = pc.RigidBodies(
        pc.Rectangle(0.4, 0.2), [(0.0, 0.1), (0.0, 0.3)], name="boxes", **({"sleep": 0.05} | options)
    )
    return pc.Scene(boxes, FLOOR, DOWN)


def asleep(scene, duration=1.0, **numerics):
    """A run of a scene in which all bodies have fallen asleep."""
    run = pc.Simulation(scene, dt=DT, **numerics)
    run.run(duration)
    assert run[0].asleep.all()
    return run


@pytest.mark.parametrize("contacts", [None, PILE])
def test_what_sleep_discards_is_dissipated(contacts):
    """Up to the step in which discs fall asleep the run has the bits of one that never sleeps. This step ends with the
    same balance, to the rounding of the sum of its terms. Nothing changes once all discs sleep.
    """
    run, other = (pc.Simulation(heap(sleep), dt=DT, contacts=contacts or "auto") for sleep in (0.05, None))
    while not run["discs"].asleep.any():
        assert run.time < 10.0
        np.testing.assert_array_equal(run["discs"].positions, other["discs"].positions)
        run.step()
        other.step()
    budget, wanted = run.energy(), other.energy()
    np.testing.assert_array_equal(run["discs"].positions, other["discs"].positions)
    rounding = 100 * np.finfo(float).eps * (wanted.potential + wanted.dissipated)
    assert abs(budget.balance - wanted.balance) <= rounding
    if run["discs"].asleep.all():
        assert budget.kinetic == 0.0
        assert abs(budget.dissipated_by["sleep"] - wanted.kinetic) <= rounding
    run.run(10.0)
    assert run["discs"].asleep.all()
    places, budget = run["discs"].positions, run.energy()
    run.run(1.0)
    np.testing.assert_array_equal(run["discs"].positions, places)
    assert vars(run.energy()) == {**vars(budget), "time": run.time}


def test_a_heap_that_wakes_rests_as_before():
    """Its contacts have the loads with which it fell asleep: it rests on, to the tolerance of a closed contact."""
    run = asleep(heap(), 6.0, contacts=PILE)
    places = run["discs"].positions
    run["discs"].set(positions=places)
    assert not run["discs"].asleep.any()
    run.step(12)
    assert np.abs(run["discs"].positions - places).max() < 1e-6 * 0.1
    run.run(1.0)
    assert run["discs"].asleep.all()


def test_bodies_never_sleep_without_being_asked():
    run = pc.Simulation(stack(sleep=None), dt=DT)
    run.run(2.0)
    assert "sleep" not in run.energy().dissipated_by
    assert "may sleep" not in str(run.plan)
    with pytest.raises(pc.SceneError, match="asleep: only rigid bodies with sleep= have them"):
        _ = run["boxes"].asleep


def test_recordings_and_the_plan_tell_who_sleeps():
    scene = stack()
    recording = pc.simulate(scene, 1.0, fps=20, dt=DT)
    mask = recording["boxes"].asleep
    assert mask.shape == (21, 2)
    assert mask.dtype == bool
    assert (mask[:, 0] == mask[:, 1]).all()
    assert not mask[:10].any()
    assert mask[11:].all()  # half a second, and the steps until the boxes rest on each other
    assert "2 of them may sleep" in str(recording.plan)


@pytest.mark.parametrize(
    "change",
    [
        pytest.param(lambda run: run["boxes"].set(velocities=[(0.0, 0.0), (0.5, 0.0)]), id="velocities"),
        pytest.param(lambda run: run["boxes"].set(angles=(0.0, 0.1)), id="angles"),
        pytest.param(lambda run: run.replace(pc.Scene(run.scene.bodies[0], DOWN)), id="floor"),
    ],
)
def test_what_the_user_changes_wakes(change):
    """A state that is set, or a scene without the floor."""
    run = asleep(stack())
    change(run)
    assert not run["boxes"].asleep.any()
    start = run["boxes"].positions
    run.step(12)
    assert np.abs(run["boxes"].positions - start).max() > 1e-3


def test_a_moving_platform_keeps_its_load_awake():
    belt = pc.RigidBody(pc.Rectangle(9.0, 0.2), (0.0, -0.1), fixed=True, velocity=(0.02, 0.0))
    box = pc.RigidBody(pc.Rectangle(0.2, 0.2), (0.0, 0.1), velocity=(0.02, 0.0), sleep=0.05, name="box")
    run = pc.Simulation(pc.Scene(belt, box, DOWN), dt=DT)
    run.run(2.0)
    assert not run["box"].asleep.any()
    assert abs(run["box"].positions[0, 0] - 0.04) < 1e-6


def test_particles_keep_bodies_awake():
    """A bead that lies on a box, and a flag that is tied to a pole."""
    bead = pc.Particles([(0.0, 0.25)], radius=0.05, mass=0.1)
    box = pc.RigidBody(pc.Rectangle(0.4, 0.2), (0.0, 0.1), sleep=0.05, name="box")
    pole = pc.RigidBody(pc.Rectangle(0.2, 0.2), (2.0, 0.1), sleep=0.05, name="pole")
    tied = pc.Particles([(2.0, 0.3)], mass=0.1)
    scene = pc.Scene(bead, box, pole, tied, pc.Anchor(tied, 0, pole), FLOOR, DOWN)
    run = pc.Simulation(scene, dt=DT)
    run.run(2.0)
    assert not run["box"].asleep.any()
    assert not run["pole"].asleep.any()
    assert "1 of them may sleep" in str(run.plan)


def test_a_force_that_changes_wakes():
    """Wind that rises: by less than sleep / sleep_after = 0.1 m/s² it lets the boxes sleep, by more it does not."""
    boxes = stack().bodies[0]

    def push(time, positions, velocities):
        return np.where(time < 1.0, 0.0, np.where(time < 1.5, 0.05, 0.15)) * boxes.mass[:, None] * np.array([1.0, 0.0])

    scene = pc.Scene(boxes, FLOOR, DOWN, pc.CustomForce(push))
    recording = pc.simulate(scene, 2.0, fps=100, dt=1 / 100)
    mask = recording["boxes"].asleep.all(axis=1)
    assert mask[100:150].all()
    assert not recording["boxes"].asleep[155:190].any()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"sleep": 0.0}, r"RigidBodies.sleep\[0\]: must be > 0"),
        ({"sleep": (0.1, -1.0)}, r"RigidBodies.sleep\[1\]: must be > 0"),
        ({"sleep": (0.1, 0.1, 0.1)}, r"RigidBodies.sleep: must broadcast to the shape \(2,\)"),
        ({"sleep": np.nan}, "RigidBodies.sleep"),
        ({"sleep_after": 0.0}, r"RigidBodies.sleep_after\[0\]: must be > 0"),
    ],
)
def test_wrong_speeds_are_refused(options, message):
    with pytest.raises(pc.SceneError, match=message):
        stack(**options)


def test_steps_of_order_4_are_refused():
    body = pc.RigidBody(pc.Cuboid(0.1, 0.2, 0.3), (0.0, 0.0, 0.0), sleep=0.05)
    with pytest.raises(pc.SceneError, match="order=2 for rigid bodies that may sleep"):
        pc.Simulation(pc.Scene(body), integrator=pc.RATTLE(4))


def test_the_time_is_to_be_given_in_other_units():
    body = pc.RigidBodies(pc.Disc(0.1), [(0.0, 0.0)], density=1.0, sleep=0.05)
    with pytest.raises(pc.SceneError, match="sleep_after=500"):
        pc.Scene(body, units=pc.units.system(time="ms"))
