"""Pictures between steps, of a simulation that advances piece by piece."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physcore.simulation.passage import Course


def thrown(**numerics):
    ball = pc.Particles([[0.0, 1.0]], velocities=[[2.0, 3.0]], name="ball")
    return pc.Simulation(pc.Scene(ball, pc.Gravity((0.0, -9.81))), **numerics)


def test_a_parabola_is_interpolated_exactly():
    """Verlet's steps are exact under constant acceleration, and so is a cubic for a parabola."""
    simulation = thrown(dt=0.05)
    course = Course(simulation)
    for _ in range(7):
        passage = course.advance(0.05, audited=False)
        for time in np.linspace(passage.before.time, passage.after.time, 5):
            state = passage.at(time, simulation.scene)
            expected = [2.0 * time, 1.0 + 3.0 * time - 0.5 * 9.81 * time**2]
            np.testing.assert_allclose(state.positions[0], expected, rtol=0.0, atol=1e-14)
            np.testing.assert_allclose(state.velocities[0], [2.0, 3.0 - 9.81 * time], rtol=0.0, atol=1e-13)
            assert state.time == pytest.approx(time, abs=1e-15)


@pytest.mark.parametrize(("duration", "steps"), [(0.001, 1), (0.05, 1), (0.09, 1), (0.1, 2), (0.3, 6), (0.6, 12)])
def test_the_steps_are_those_that_fit_and_at_least_one(duration, steps):
    simulation = thrown(dt=0.05)
    course = Course(simulation)
    course.advance(0.05, audited=False)
    passage = course.advance(duration, audited=True)
    assert simulation.steps == 1 + steps
    assert passage.after.time == simulation.time
    assert passage.energy.total == simulation.energy().total
    # What is finer than a quarter of the way between two pictures is not interpolated in.
    length = passage.after.time - passage.before.time
    assert length == pytest.approx(0.05 if duration < 0.2 else 0.0, abs=1e-15)


def test_times_beyond_the_step_are_its_ends():
    simulation = thrown(dt=0.05)
    passage = Course(simulation).advance(0.05, audited=False)
    np.testing.assert_array_equal(passage.at(-1.0, simulation.scene).positions, passage.before.positions)
    np.testing.assert_array_equal(passage.at(9.0, simulation.scene).positions, passage.after.positions)


@pytest.mark.parametrize("numerics", [{"dt": 0.01}, {}, {"dt": pc.AdaptiveStep()}], ids=["fixed", "auto", "adaptive"])
def test_pieces_change_no_bit(numerics):
    simulation, alone = thrown(**numerics), thrown(**numerics)
    course = Course(simulation)
    for duration in (0.02, 0.005, 0.1, 0.3):
        course.advance(duration, audited=True)
        course.present(audited=False)
    if numerics.get("dt") == pc.AdaptiveStep():
        for duration in (0.02, 0.005, 0.1, 0.3):
            alone.run(duration)
    else:
        alone.step(simulation.steps)
    assert simulation.state_hash() == alone.state_hash()


def test_a_state_that_was_set_is_not_interpolated_from_the_one_before():
    simulation = thrown(dt=0.05)
    course = Course(simulation)
    course.advance(0.05, audited=False)
    simulation["ball"].set(positions=(5.0, 5.0))
    course.begin()
    passage = course.advance(0.05, audited=False)
    np.testing.assert_array_equal(passage.before.positions, [[5.0, 5.0]])


def test_particles_are_shown_within_their_domain():
    """A particle that crosses a face is between both its images of the step, and then wrapped."""
    ball = pc.Particles([[0.9, 0.5]], velocities=[[1.0, 0.0]])
    simulation = pc.Simulation(pc.Scene(ball, pc.Periodic((0.0, 0.0), (1.0, 1.0))), dt=0.2)
    passage = Course(simulation).advance(0.2, audited=False)
    for part, expected in ((0.25, 0.95), (0.75, 0.05)):
        state = passage.at(0.2 * part, simulation.scene)
        assert state.positions[0, 0] == pytest.approx(expected, abs=1e-12)
