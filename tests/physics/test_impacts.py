"""Impacts of soft spheres are resolved by the automatic time step, however many particles there are."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc

STIFFNESS, MASS = 1000.0, 1.0


def spectators(count: int) -> list[pc.Particles]:
    """Particles apart from all, which make a scene large."""
    places = np.stack([5.0 + 0.5 * np.arange(count), np.full(count, 5.0)], axis=1)
    return [pc.Particles(places, radius=0.1, mass=MASS)] if count else []


def restitution(damping: float, gap: float, others: int, exponent: float) -> float:
    """Relative speed after a head-on impact, over that before it, from a distance that is no multiple of a step."""
    pair = pc.Particles([[-0.1 - gap, 0.0], [0.1, 0.0]], [[1.0, 0.0], [-1.0, 0.0]], radius=0.1, mass=MASS)
    scene = pc.Scene(pair, *spectators(others), pc.SoftSpheres(STIFFNESS, damping, exponent=exponent))
    velocities = pc.simulate(scene, 0.5, fps=30.0).velocities[-1]
    return float(velocities[1, 0] - velocities[0, 0]) / 2.0


def never_attractive(ratio: float) -> float:
    """The restitution of a linear contact of the damping ratio ξ that never pulls.

    Source: T. Schwager, T. Pöschel, Granular Matter 9, 465 (2007), equation 21, for ξ² < 1/2.
    """
    slope = ratio / math.sqrt(1.0 - ratio * ratio)
    return math.exp(-slope * (math.pi - math.atan2(2.0 * slope, 1.0 - slope * slope)))


@pytest.mark.parametrize("others", [0, 1100], ids=["small", "large"])
@pytest.mark.parametrize("ratio", [0.0, 0.1, 0.3])
def test_an_impact_has_the_restitution_of_its_law(ratio, others):
    """The step is at most a twentieth of an impact, h ω ≤ π/20.

    Verlet then loses or gains at the first and the last touch at most the energy of an overlap of one step, (h ω)²/4 of
    the whole, and half of that in speed, 0.3 %. The damping of the first step acts from its middle on or not at all,
    wherever the spheres touch: an impulse of up to c v h/2, which is h ω ξ of their momentum μ v.
    """
    damping = 2.0 * ratio * math.sqrt(0.5 * STIFFNESS * MASS)
    for gap in np.linspace(0.0, 0.05, 7):
        found = restitution(damping, gap, others, 1.0)
        step = math.pi / 20.0
        assert found == pytest.approx(never_attractive(ratio), abs=step**2 / 8.0 + step * ratio)


def test_hertz_s_contact_conserves_energy():
    for gap in np.linspace(0.0, 0.05, 7):
        assert restitution(0.0, gap, 1100, 1.5) == pytest.approx(1.0, abs=2e-3)


def test_a_gas_of_soft_spheres_does_not_heat():
    rng = np.random.default_rng(3)
    places = np.concatenate([pc.block((2.0 * k, 0.0), (2.0 * k + 1.0, 1.0), 0.125) for k in range(20)])
    grains = pc.Particles(places, rng.normal(size=places.shape), radius=0.05, mass=1.0)
    scene = pc.Scene(grains, pc.SoftSpheres(2e4), pc.Box((0.0, 0.0), (40.0, 1.0)))
    recording = pc.simulate(scene, 4.0, fps=5.0)
    assert np.abs(recording.energy.drift).max() <= 0.01


@pytest.mark.parametrize("part", [0.5, 1.0])
def test_semi_implicit_euler_does_not_heat_damped_spheres_within_its_limit(part):
    rng = np.random.default_rng(3)
    places = pc.block((0.0, 0.0), (1.0, 1.0), 0.125)
    grains = pc.Particles(places, rng.normal(size=places.shape), radius=0.05, mass=1.0)
    scene = pc.Scene(grains, pc.SoftSpheres(2e4, damping=60.0), pc.Box((0.0, 0.0), (1.0, 1.0)))
    limit = pc.Simulation(scene, "SemiImplicitEuler").plan.dt_limit
    recording = pc.simulate(scene, 2.0, integrator="SemiImplicitEuler", dt=part * limit)
    assert recording.energy.total[-1] <= 0.02 * recording.energy.total[0]
