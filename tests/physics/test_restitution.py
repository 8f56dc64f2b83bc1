"""Soft spheres with a coefficient of restitution: the damping that follows from it, for each pair of masses."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import physcore as pc
from physics.laboratory import simulation

STIFFNESS = 1e4
MASSES = (0.3, 1.7)


def impact(law: pc.SoftSpheres, speed: float, steps: int, masses: tuple[float, float] = MASSES, **options: object):
    """A head-on impact of two spheres of radius 1, with some steps in its duration; it begins a half step in."""
    reduced = 1.0 / (1.0 / masses[0] + 1.0 / masses[1])
    power = law.exponent
    # π √(m/k), and 3.2 times (m²/(k² v))^(1/5) for Hertz (Landau and Lifshitz, Theory of elasticity, § 9).
    lasts = np.pi * (reduced / STIFFNESS) ** 0.5 if power == 1.0 else 3.2 * (reduced**2 / STIFFNESS**2 / speed) ** 0.2
    dt = lasts / steps
    pair = pc.Particles(
        [[0.0, 0.0], [2.0 + 0.5 * speed * dt, 0.0]], [[speed, 0.0], [0.0, 0.0]], masses, radius=1.0, **options
    )
    run = simulation(pc.Scene(pair, law), pc.RungeKutta4(), dt)
    run.step(4 * steps)
    return run


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize("restitution", [0.1, 0.3, 0.5, 0.8, 0.95, 1.0])
def test_spheres_part_at_that_part_of_the_speed_at_which_they_met(exponent, restitution):
    """At three speeds. A damped force begins with a jump, which a step sees up to half a step late or early: of the
    order of 1/steps in the change of the velocity, (1 + e)/1000. The loss is ½ m v² (1 − e²).
    """
    law = pc.SoftSpheres(STIFFNESS, exponent=exponent, restitution=restitution)
    reduced = 1.0 / (1.0 / MASSES[0] + 1.0 / MASSES[1])
    for speed in (0.1, 1.0, 5.0):
        run = impact(law, speed, 1000)
        first, second = run.velocities[:, 0]
        assert (second - first) / speed == pytest.approx(restitution, abs=1e-3)
        assert MASSES[0] * first + MASSES[1] * second == pytest.approx(MASSES[0] * speed, rel=1e-12)
        lost = 0.5 * reduced * speed**2 * (1.0 - restitution**2)
        assert run.energy().dissipated == pytest.approx(lost, rel=5e-3, abs=1e-12)


def test_a_fixed_sphere_counts_as_infinitely_heavy():
    law = pc.SoftSpheres(STIFFNESS, restitution=0.4)
    run = impact(law, 1.0, 1000, fixed=[1])
    # The duration that steps are counted in is that of the reduced mass.
    assert run.velocities[0, 0] == pytest.approx(-0.4, abs=2e-3)
    heavy = impact(law, 1.0, 1000, (0.3, 1e12))
    assert heavy.velocities[0, 0] == pytest.approx(-0.4, abs=2e-3)
    still = pc.Scene(pc.Particles([[0.0, 0.0], [1.5, 0.0]], radius=1.0, fixed=True), law, pc.Gravity())
    both = pc.Simulation(still, dt=1e-3)
    both.step(3)
    assert not both.velocities.any()
    assert both.energy().dissipated == 0.0


@settings(max_examples=25)
@given(e=st.floats(0.15, 1.0), ratio=st.floats(0.01, 100.0), exponent=st.sampled_from([1.0, 1.5]))
def test_restitution_does_not_depend_on_masses(e, ratio, exponent):
    law = pc.SoftSpheres(STIFFNESS, exponent=exponent, restitution=e)
    run = impact(law, 1.0, 200, (1.0, ratio))
    assert np.diff(run.velocities[:, 0]).item() == pytest.approx(e, abs=1e-2)


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_dissipation_never_falls(precision, exponent):
    """A gas of unequal grains with friction cools; the budget closes to 3 % at 20 steps in an impact."""
    rng = np.random.default_rng(0)
    x = pc.block((0.0, 0.0), (1.0, 1.0), 0.12)
    grains = pc.Particles(x, rng.normal(size=x.shape), rng.uniform(0.1, 1.0, len(x)), radius=0.055)
    law = pc.SoftSpheres(STIFFNESS, friction=0.3, exponent=exponent, restitution=0.7)
    run = pc.Simulation(pc.Scene(grains, law, pc.Box((-0.1, -0.1), (1.1, 1.1))), precision=precision)
    start, lost = run.energy(), [0.0]
    for _ in range(40):
        run.run(0.01)
        lost.append(run.energy().dissipated)
    assert (np.diff(lost) >= 0.0).all()
    assert lost[-1] > 0.3 * start.total
    assert abs(run.energy().balance - start.balance) < 0.03 * start.total


@pytest.mark.parametrize("integrator", [pc.SemiImplicitEuler(), pc.VelocityVerlet()], ids=repr)
@pytest.mark.parametrize(
    "law", [{"restitution": 0.3}, {"restitution": 0.3, "exponent": 1.5}, {"damping": 100.0}], ids=str
)
def test_steps_below_the_limit_cool(integrator, law):
    """Crowded grains in motion: at 0.95 of the limit the kinetic energy falls as at a tenth of it, to a hundredth."""
    rng = np.random.default_rng(0)
    x = pc.block((0.0, 0.0), (0.6, 0.6), 0.1)
    grains = pc.Particles(x, 2.0 * rng.normal(size=x.shape), rng.uniform(0.1, 1.0, len(x)), radius=0.055)
    scene = pc.Scene(grains, pc.SoftSpheres(STIFFNESS, **law), pc.Box((-0.1, -0.1), (0.7, 0.7)))
    limit = pc.Simulation(scene, integrator, dt=1e-5).plan.dt_limit
    left = []
    for part in (0.1, 0.95):
        run = pc.Simulation(scene, integrator, dt=part * limit)
        start = run.energy().total
        run.run(0.4)
        left.append(run.energy().total / start)
    assert max(left) < 0.05
    assert left[1] < 2.0 * left[0] + 0.01


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: pc.SoftSpheres(1.0, 0.1, restitution=0.5), r"SoftSpheres\.restitution: gives the damping; leave out"),
        (lambda: pc.SoftSpheres(1.0, restitution=0.0), r"SoftSpheres\.restitution: must be > 0"),
        (lambda: pc.SoftSpheres(1.0, restitution=1.1), r"SoftSpheres\.restitution: must be .*1"),
        (lambda: pc.SoftSpheres(1.0, friction=0.1, restitution=1.0), r"tangential_damping: must be > 0 where there is"),
    ],
)
def test_mistakes_are_named(build, message):
    with pytest.raises(pc.SceneError, match=message):
        build()
