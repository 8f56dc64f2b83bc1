"""The order of convergence of every registered integrator is what the plan says, with and without dissipation."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physcore.numerics.integrators import INTEGRATORS
from physics.laboratory import ALL, Array, name, network, simulation, state
from work import counted

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


def path(scene: pc.Scene, integrator: pc.Integrator, dt: float, steps: int) -> Array:
    """The states at ten times: at a single one, errors of either sign may happen to cancel."""
    run = simulation(scene, integrator, dt)
    states = []
    for _ in range(10):
        run.step(steps // 10)
        states.append(state(run))
    return np.array(states)


def measured_order(scene: pc.Scene, integrator: pc.Integrator, duration: float, steps: int) -> float:
    """log₂ of the ratio of successive differences: p + O(dt)."""
    runs = [path(scene, integrator, duration / (steps * part), steps * part) for part in (1, 2, 4)]
    coarse, middle, fine = runs
    return float(np.log2(np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine)))


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_the_error_at_fixed_times_shrinks_with_the_order_of_the_plan(integrator, scene, record_property):
    """For these steps the measured order is within 0.1 of the plan's."""
    order = order_of(SCENES[scene], integrator)
    measured = measured_order(SCENES[scene], integrator, 0.5 if "springs" in scene else 2.0, STEPS[order])
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


DRAGS = {"without drag": [], "linear drag": [pc.Drag(linear=0.3)], "quadratic drag": [pc.Drag(quadratic=0.2)]}
RODS = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0], [1.7, 0.8]], [[0, 1], [1, 2]], np.inf, fixed=[0])
FREE = [kind() for kind in INTEGRATORS if kind.advances("bodies") and kind not in (pc.GaussRadau15, pc.RATTLE)]
"""All methods for bodies but two. That of order 15 is tested at steps at which rounding does not hide its order."""
DRAGGED = {
    **{name(integrator): ([ORBIT, pc.CentralForce((0.0, 0.0), 1.0, softening=0.2)], integrator) for integrator in FREE},
    **{f"RATTLE {order}": ([RODS, GRAVITY], pc.RATTLE(order=order)) for order in (2, 4)},
}


@pytest.mark.parametrize("drag", DRAGS)
@pytest.mark.parametrize("case", DRAGGED)
def test_the_plan_states_the_order_with_drag(case, drag):
    items, integrator = DRAGGED[case]
    scene = pc.Scene(*items, *DRAGS[drag])
    order = order_of(scene, integrator)
    lowered = drag != "without drag" and integrator.order > 2 and integrator.symplectic
    assert order == (2 if lowered else integrator.order)
    # Steps at which errors are above 1e-11, since rounding is about 1e-14.
    steps = {1: 800, 2: 200, 3: 100, 4: 80, 5: 60, 6: 20}[order]
    assert measured_order(scene, integrator, 2.0, steps) == pytest.approx(order, abs=0.25)


def test_a_trade_says_which_orders_the_scene_lowers():
    scene = pc.Scene(*DRAGGED["PEFRL"][0], pc.Drag(quadratic=0.2))
    with counted():
        trade = pc.tradeoff(scene, 1.0, integrators=["PEFRL", "RungeKutta4"], dts=[0.05, 0.02], precisions=["f64"])
    assert {row.label: row.order for row in trade.rows} == {"PEFRL": 2, "RungeKutta4": 4}
    for text in (str(trade), repr(trade), trade.explain()):
        assert "of lower order in this scene: PEFRL (2, not 4)" in text
