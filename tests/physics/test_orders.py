"""The order of convergence of every registered integrator is what the plan says, with and without dissipation."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import ALL, Array, name, network, simulation, state

NETWORK = network(seed=1, dimension=2, count=6)
GRAVITY = pc.Gravity((0.3, -1.0))
AIR = pc.Drag(linear=0.3, quadratic=0.2, wind=(0.4, 0.1))
ORBIT = pc.Particles([[1.0, 0.0], [0.0, 1.3]], [[0.1, 0.9], [-0.8, 0.2]], mass=[1.0, 1.5])

SCENES = {
    "springs": pc.Scene(NETWORK.body(fixed=[0]), GRAVITY),
    "damped springs": pc.Scene(NETWORK.body(fixed=[0], damping=0.5), GRAVITY),
    "springs in wind": pc.Scene(NETWORK.body(fixed=[0], damping=0.5), GRAVITY, AIR),
    "orbit": pc.Scene(ORBIT, pc.CentralForce((0.0, 0.0), 1.0, softening=0.2)),
    "orbit with drag": pc.Scene(ORBIT, pc.CentralForce((0.0, 0.0), 1.0, softening=0.2), AIR),
    "folded": pc.Scene(ORBIT, pc.CentralForce((0.1, 0.0), 4.0, exponent=1.0), GRAVITY),
    "folded with drag": pc.Scene(ORBIT, pc.CentralForce((0.1, 0.0), 4.0, exponent=1.0), GRAVITY, pc.Drag(0.4)),
}
STEPS = {1: 2000, 2: 400, 3: 300, 4: 200, 5: 100, 6: 20}
"""Enough for the leading term: springs of 100 N/m on 0.5 kg have ω ≤ 20/s and run for 0.5 s, the others ω ≈ 2/s and run
for 2 s, so that ω dt is 0.005, 0.025, 0.033, 0.05, 0.1 and 0.5."""


def path(scene: str, integrator: pc.Integrator, steps: int) -> Array:
    """The states at ten times: at a single one, errors of either sign may happen to cancel."""
    duration = 0.5 if "springs" in scene else 2.0
    run = simulation(SCENES[scene], integrator, duration / steps)
    states = []
    for _ in range(10):
        run.step(steps // 10)
        states.append(state(run))
    return np.array(states)


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_the_error_at_fixed_times_shrinks_with_the_order_of_the_plan(integrator, scene, record_property):
    """log₂ of the ratio of successive differences is p + O(dt): for these steps within 0.1 of the plan's order."""
    order = order_of(SCENES[scene], integrator)
    steps = STEPS[order]
    coarse, middle, fine = (path(scene, integrator, steps * halving) for halving in (1, 2, 4))
    measured = np.log2(np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine))
    record_property("order", f"{measured:.3f}")
    assert measured == pytest.approx(order, abs=0.1)


def order_of(scene: pc.Scene, integrator: pc.Integrator) -> int:
    return simulation(scene, integrator, 1e-4).plan.order


@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_a_conservative_scene_has_the_nominal_order(integrator):
    assert order_of(SCENES["springs"], integrator) == integrator.order
    assert order_of(SCENES["orbit"], integrator) == integrator.order


def test_dissipation_brings_a_splitting_down_to_order_two_and_leaves_the_others():
    orders = [order_of(SCENES["springs in wind"], integrator) for integrator in ALL]
    assert orders == [1, 1, 2, 2, 4, 2, 2, 2, 3, 5]
