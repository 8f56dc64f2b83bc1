"""The periodic domain: what users see is inside, and nothing is torn on the way across a face."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc

BOX = pc.Periodic((0.0, -1.0), (1.0, 2.0))
STRIP = pc.Periodic((0.0, -math.inf), (1.0, math.inf))
REACH = st.floats(-1e6, 1e6)


@given(x=REACH, y=REACH)
def test_wrapped_positions_are_inside_and_differ_by_whole_periods(x, y):
    point = np.array([[x, y]])
    for domain in (BOX, STRIP):
        inside = domain.wrap(point)
        assert (inside >= domain.lower).all()
        assert (inside < domain.upper).all()
        with np.errstate(invalid="ignore"):
            periods = (point - inside) / domain.lengths
        # Rounding: an ulp of the coordinate, at most 1.2e-10, over a period of at least 1.
        assert np.abs(periods - np.rint(periods)).max() <= 2e-10
        np.testing.assert_array_equal(domain.wrap(inside), inside)


def test_what_is_inside_keeps_its_bits_and_the_upper_face_is_the_lower_one():
    points = np.array([[0.1, -0.3], [np.nextafter(1.0, 0.0), -1.0], [1.0, 2.0], [-1e-300, 0.0], [-0.0, 5.0]])
    expected = [[0.1, -0.3], [np.nextafter(1.0, 0.0), -1.0], [0.0, -1.0], [0.0, 0.0], [0.0, -1.0]]
    assert BOX.wrap(points).tolist() == expected


def test_the_nearest_image_is_at_most_half_a_period_away():
    np.testing.assert_allclose(
        BOX.nearest(np.array([[0.6, 1.4], [-0.6, -1.6], [3.1, 0.2]])), [[-0.4, 1.4], [0.4, 1.4], [0.1, 0.2]], atol=1e-15
    )
    assert STRIP.nearest(np.array([[0.0, 1e9]])).tolist() == [[0.0, 1e9]]


FLYER = pc.Particles([[0.5, 0.0]], velocities=[[3.0, 7.0]], name="flyer")


@pytest.mark.parametrize("dt", ["auto", 0.01, 0.07])
def test_frames_between_steps_go_straight_across_a_face(dt):
    """Free flight is exact: interpolating wrapped positions would put frames in the middle of the box instead."""
    recording = pc.simulate(pc.Scene(FLYER, BOX), duration=2.0, fps=23.0, dt=dt)
    flown = np.array([0.5, 0.0]) + recording.times[:, None] * [3.0, 7.0]
    # At most 50 additions of steps, each an ulp of 16 m.
    distance = BOX.nearest(recording.positions[:, 0] - flown)
    assert np.abs(distance).max() <= 50 * 2.0**-49
    for part in (recording.positions, recording["flyer"].positions):
        assert ((part >= BOX.lower) & (part < BOX.upper)).all()


def test_a_simulation_shows_positions_inside_and_keeps_them_outside():
    simulation = pc.Simulation(pc.Scene(FLYER, STRIP), dt=0.25)
    simulation.step(3)
    assert simulation.positions.tolist() == [[0.75, 5.25]]
    assert simulation[FLYER].positions.tolist() == [[0.75, 5.25]]
    assert [frame.positions.tolist() for frame in simulation.frames(0.25, fps=4.0)] == [[[0.75, 5.25]], [[0.5, 7.0]]]
    simulation.set(positions=[[-0.25, 1.0]])
    assert simulation.positions.tolist() == [[0.75, 1.0]]


def test_springs_reach_where_particles_have_gone():
    """A pair that flies through a face is not torn: its energy stays zero."""
    pair = pc.rope(2, length=0.3, stiffness=100.0, start=(0.5, 0.0), velocities=(4.0, 0.0))
    simulation = pc.Simulation(pc.Scene(pair, BOX), dt=0.01)
    for _ in range(50):
        simulation.step()
        assert simulation.energy().by_term["springs"] < 1e-25
    assert abs(BOX.nearest(np.diff(simulation.positions, axis=0))[0, 0] - 0.3) < 1e-12


def test_the_last_good_state_is_inside_too():
    scene = pc.Scene(pc.Particles([[0.5, 0.0]]), pc.CentralForce((0.0, 0.0), 100.0, exponent=1.0), BOX)
    with pytest.warns(pc.StabilityWarning):
        simulation = pc.Simulation(scene, dt=1.0)
    with pytest.raises(pc.SimulationDiverged) as caught:
        simulation.step(100)
    last = caught.value.last_good
    assert last is not None
    assert ((last.positions >= BOX.lower) & (last.positions < BOX.upper)).all()


def test_a_domain_is_a_value_of_the_scene():
    scene = pc.Scene(FLYER, BOX)
    assert scene.periodic is BOX
    assert pc.Scene(FLYER).periodic is None
    assert pc.Periodic([0, -1], np.array([1, 2])) == BOX
    assert "Periodic(lower=(0.0, -1.0)" in repr(scene)
    assert BOX.lengths.tolist() == [1.0, 3.0]


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: pc.Periodic((0, 0), (1, 1, 1)), "Periodic.upper: must have 2 components"),
        (lambda: pc.Periodic((0, 0), (1, 0)), r"Periodic.upper\[1\]: must be above the lower end 0, got 0"),
        (lambda: pc.Periodic((0, 0), (1, math.inf)), r"Periodic.upper\[1\]: .*or \(−inf, inf\)"),
        (lambda: pc.Periodic((-math.inf,) * 2, (math.inf,) * 2), "Periodic.lower: no axis is periodic"),
        (lambda: pc.Periodic((0, math.nan), (1, 1)), r"Periodic.lower\[1\]: must be a number, got nan"),
        (lambda: pc.Periodic(0, 1), "Periodic.lower: must be 2 or 3 numbers"),
        (lambda: pc.Periodic("ab", (1, 1)), "Periodic.lower: must be an array of real numbers"),
        (
            lambda: pc.Periodic((-1.7e308, 0), (1.7e308, 1)),
            r"Periodic.upper\[0\]: the length .* not a finite",
        ),
        (lambda: pc.Scene(FLYER, BOX, STRIP), "periodic: there must be at most one Periodic domain, got 2"),
        (lambda: pc.Scene(FLYER, pc.Periodic((0,) * 3, (1,) * 3)), "periodic.lower: Periodic must have 2 components"),
    ],
)
def test_bad_input_is_refused_with_its_path(build, message):
    with pytest.raises(pc.SceneError, match=message):
        build()
