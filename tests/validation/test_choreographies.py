"""Validation, area C: bodies that attract each other, on orbits with figures from outside."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import Array, simulation

pytestmark = pytest.mark.validation

# C05. Source: ω² = ¼ Σ 1/sin(πk/N), with G = m = R = 1.
POLYGONS = {
    3: 0.7598356856515925473312,
    4: 0.9783183434785159564221,
    6: 1.351795202384453561761,
    8: 1.674773371596623229717,
}


def polygon(corners: int) -> pc.Scene:
    """Equal masses on a circle, which turn as one."""
    angles = 2.0 * np.pi * np.arange(corners) / corners
    places = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    velocities = POLYGONS[corners] * np.stack([-np.sin(angles), np.cos(angles)], axis=1)
    return pc.Scene(pc.Particles(places, velocities), pc.Gravitation(1.0))


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
@pytest.mark.parametrize("corners", POLYGONS)
def test_c05_the_accelerations_of_a_polygon(corners, record_property):
    """Good: 1e-14, of sums of N − 1 terms whose components are rounded with the places of the corners, 1.1e-16 each.
    Excellent, 4e-16, is two ulp of a number: less than the places alone let the sum be known to.
    """
    scene = polygon(corners)
    run = pc.Simulation(scene, pc.SemiImplicitEuler(), dt=1.0)
    start = scene.bodies[0]
    run.step(1)
    pull = np.asarray(run.velocities) - start.velocities
    found = np.linalg.norm(pull, axis=1)
    worst = float(np.abs(found / POLYGONS[corners] ** 2 - 1.0).max())
    record_property("relative error", f"{worst:.1e}")
    # The difference of velocities adds an ulp of ω + ω².
    assert worst < 2e-15


def test_c05_a_triangle_after_one_turn(record_property):
    """Excellent: the angle within 1e-8, RungeKutta4 with dt = 0.01: its phase error is ω (ω dt)⁴/120 t = 2e-10."""
    turn = 2.0 * np.pi / POLYGONS[3]
    steps = round(turn / 0.01)
    run = simulation(polygon(3), pc.RungeKutta4(), turn / steps)
    run.step(steps)
    angles = np.arctan2(*run.positions.T[::-1])
    missed = float(np.abs(np.angle(np.exp(1j * (angles - 2.0 * np.pi * np.arange(3) / 3)))).max())
    record_property("angle", f"{missed:.1e}")
    assert missed < 1e-8


# C07. Source: A. Chenciner, R. Montgomery, Ann. Math. 152 (2000) 881; refined by Newton's method to 45 digits.
START, VELOCITY = (0.97000436, -0.24308753), (0.4662036840695393534032714, 0.4323657309174768500529278)
PERIOD, ENERGY = 6.3259140097821385504247, -1.287141991988917329874088
TEXTBOOK_EIGHT = {
    pc.SemiImplicitEuler(): (1.9741e-2, 1.0036e-2, 5.0612e-3),
    pc.VelocityVerlet(): (2.5544e-4, 6.4002e-5, 1.6009e-5),
    pc.RungeKutta4(): (1.0679e-7, 5.5866e-9, 3.1511e-10),
}


def eight() -> pc.Scene:
    """Three equal masses on one curve."""
    places = np.array([START, [-coordinate for coordinate in START], (0.0, 0.0)])
    velocities = np.array([VELOCITY, VELOCITY, [-2.0 * each for each in VELOCITY]])
    return pc.Scene(pc.Particles(places, velocities), pc.Gravitation(1.0))


def closure(integrator: pc.Integrator, steps: int) -> Array:
    """How far each is from its start after a period."""
    scene = eight()
    run = simulation(scene, integrator, PERIOD / steps)
    run.step(steps)
    return np.abs(np.asarray(run.positions) - scene.bodies[0].positions)


@pytest.mark.parametrize("integrator", TEXTBOOK_EIGHT, ids=lambda i: type(i).__name__)
def test_c07_the_error_is_that_of_the_textbook_scheme(integrator, record_property):
    """Excellent: within 0.5 %."""
    errors = [closure(integrator, steps).max() for steps in (500, 1000, 2000)]
    ratios = np.array(errors) / TEXTBOOK_EIGHT[integrator]
    record_property("ratio to the textbook's error", np.round(ratios, 5).tolist())
    np.testing.assert_allclose(ratios, 1.0, rtol=0.0, atol=0.005)


def test_c07_a_figure_of_eight_closes(record_property):
    """Excellent: 5.6e-12, RungeKutta4 in 6326 steps."""
    missed = float(closure(pc.RungeKutta4(), 6326).max())
    record_property("closure", f"{missed:.2e}")
    assert missed < 5.6e-12


def test_c07_a_million_steps_keep_the_energy(record_property):
    """Good: within 1e-4 and without a trend, Verlet with dt = 0.005. Excellent, 1e-5, is less than the swing of
    Verlet's own energy about that which it keeps, of order dt²: with half of the step it is a quarter.
    """

    def changes(dt: float, samples: int) -> Array:
        run = simulation(eight(), pc.VelocityVerlet(), dt)
        assert run.energy().total == pytest.approx(ENERGY, rel=1e-14)
        totals = []
        for _ in range(samples):
            run.step(1000)
            totals.append(run.energy().total)
        return np.array(totals) / ENERGY - 1.0

    whole, half = changes(0.005, 1000), changes(0.0025, 1000)
    early, late = whole[:500].mean(), whole[500:].mean()
    record_property("largest, early mean, late mean", f"{np.abs(whole).max():.1e}, {early:.2e}, {late:.2e}")
    assert np.abs(whole).max() < 1e-4
    assert np.abs(whole).max() / np.abs(half).max() == pytest.approx(4.0, rel=0.05)
    # Means of 500 samples of a swing of 5e-6 each.
    assert abs(late - early) < 4 * np.sqrt(2 / 500) * whole.std()
