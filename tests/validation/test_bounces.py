"""Validation, case L04: a bouncing ball."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array, simulation

pytestmark = pytest.mark.validation

# L04. Source: h_n = h e^(2n), T = √(2h/g) (1 + e)/(1 − e) (Zeno). h = 1, e = 0.8, g = 9.81, dt = 1/240.
HEIGHTS = (0.64, 0.4096, 0.262144, 0.1677721600, 0.1073741824)
FIRST_IMPACT, TOTAL_TIME, TOTAL_PATH = 0.4515236409857309044508, 4.063712768871578140057, 4.555555555555555555556


def bounces(radius: float) -> tuple[Array, Array, Array]:
    """Times, heights of the ball's lowest point, and speeds at every step of five seconds."""
    ball = pc.Particles([[0.0, 1.0 + radius]], radius=radius)
    scene = pc.Scene(ball, pc.Gravity((0.0, -9.81)), pc.Floor(0.0, restitution=0.8))
    run = simulation(scene, pc.VelocityVerlet(), 1.0 / 240.0)
    rows = [(0.0, 1.0, 0.0)]
    for _ in range(1200):
        run.step(1)
        rows.append((run.time, float(run.positions[0, 1]) - radius, float(run.velocities[0, 1])))
    times, heights, speeds = np.array(rows).T
    return times, heights, speeds


@pytest.mark.parametrize("radius", [0.0, 0.1])
def test_l04_the_heights_of_a_bouncing_ball(radius, record_property):
    """Excellent: 0.5 %. The impact is found within its step, so the parabolas are exact: 1e-12 for the heights and the
    first impact. A turning point lies between two steps, and follows from either: y + v²/2g.
    """
    times, heights, speeds = bounces(radius)
    turns = np.flatnonzero((speeds[:-1] > 0.0) & (speeds[1:] <= 0.0))[:5]
    found = heights[turns] + speeds[turns] ** 2 / (2.0 * 9.81)
    error = np.abs(found / HEIGHTS - 1.0).max()
    record_property("error", f"{error:.1e}")
    assert error <= 1e-12
    rise = int(np.flatnonzero(speeds > 0.0)[0])
    takeoff = 0.8 * np.sqrt(2.0 * 9.81)
    impact = times[rise] - (takeoff - speeds[rise]) / 9.81
    assert impact == pytest.approx(FIRST_IMPACT, rel=1e-12)


@pytest.mark.parametrize("radius", [0.0, 0.1])
def test_l04_the_ball_comes_to_rest_in_zenos_time(radius, record_property):
    """Excellent: 1 %. Where the time between two impacts falls below a step the ball comes to rest."""
    times, heights, speeds = bounces(radius)
    moving = np.flatnonzero((speeds != 0.0) | (heights > 1e-12))
    rest = times[moving[-1] + 1]
    record_property("rest", f"{rest:.4f} s")
    assert rest == pytest.approx(TOTAL_TIME, rel=0.01)
    # Of the path, what is below g dt²/8 per bounce is not seen in the steps; the rest within 0.5 %.
    turns = np.flatnonzero((speeds[:-1] > 0.0) & (speeds[1:] <= 0.0))
    path = 1.0 + 2.0 * float((heights[turns] + speeds[turns] ** 2 / (2.0 * 9.81)).sum())
    assert path == pytest.approx(TOTAL_PATH, rel=0.005)
