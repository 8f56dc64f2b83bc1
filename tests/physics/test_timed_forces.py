"""Gravity and wind that are functions of time."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc
from physcore.integrators import INTEGRATORS

METHODS = [kind for kind in INTEGRATORS if kind.advances("bodies") and kind.__name__ not in ("RATTLE", "GaussRadau15")]
RATE = 3.0


def lift(time: float) -> tuple[float, float]:
    return 0.0, -math.cos(RATE * time)


def gust(time: float) -> tuple[float, float]:
    return math.sin(RATE * time), 0.0


def fall(kind: type[pc.Integrator], steps: int) -> float:
    """Error of a fall from rest in a lift after 1 s: y = (cos(ωt) − 1)/ω²."""
    scene = pc.Scene(pc.Particles([[0.0, 0.0]], mass=2.0), pc.Gravity(lift))
    simulation = pc.Simulation(scene, kind(), dt=1.0 / steps)
    simulation.step(steps)
    return float(abs(simulation.positions[0, 1] - (math.cos(RATE) - 1.0) / RATE**2))


def drift(kind: type[pc.Integrator], steps: int) -> float:
    """Error of v' = −γ (v − sin ωt) with γ = 2 after 1 s: v = γ (γ sin ωt − ω cos ωt + ω exp(−γt))/(γ² + ω²)."""
    scene = pc.Scene(pc.Particles([[0.0, 0.0]], mass=1.0), pc.Drag(linear=2.0, wind=gust))
    simulation = pc.Simulation(scene, kind(), dt=1.0 / steps)
    simulation.step(steps)
    true = 2.0 * (2.0 * math.sin(RATE) - RATE * math.cos(RATE) + RATE * math.exp(-2.0)) / (4.0 + RATE**2)
    return float(abs(simulation.velocities[0, 0] - true))


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
@pytest.mark.parametrize("kind", METHODS, ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("error", [fall, drift], ids=["gravity", "wind"])
def test_every_method_takes_functions_of_time_with_its_order(error, kind):
    """Splittings above order 2 take forces that depend on velocity with order 2."""
    scene = pc.Scene(pc.Particles([[0.0, 0.0]]), pc.Drag(linear=2.0, wind=gust) if error is drift else pc.Gravity(lift))
    order = pc.Simulation(scene, kind(), dt=0.01).plan.order
    coarse, fine = error(kind, 20), error(kind, 40)
    if fine > 1e-12:
        assert math.log2(coarse / fine) >= order - 0.35
    assert coarse <= 0.2


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_a_constant_function_is_a_constant(precision):
    """Gravity and linear drag are fused only where they are constant, which changes roundings."""
    cloth = pc.cloth((8, 6), 0.05, 100.0, 0.05, mass=0.01, axes=((1, 0, 0), (0, 0, 1)), pinned="left")
    runs = []
    for air, pull in (((3.0, 1.0, 0.0), (0.0, 0.0, -9.81)), (lambda t: (3.0, 1.0, 0.0), lambda t: (0.0, 0.0, -9.81))):
        forces = (pc.Wind(air), pc.Drag(linear=1e-3, quadratic=1e-3, wind=air), pc.Gravity(pull))
        simulation = pc.Simulation(pc.Scene(cloth, *forces), dt=1e-3, precision=precision)
        simulation.step(200)
        runs.append(simulation.positions)
    assert np.abs(runs[0] - runs[1]).max() <= (1e-4 if precision == "f32" else 1e-11)


def test_the_budget_closes_with_their_work():
    cloth = pc.cloth((8, 6), 0.05, 100.0, 0.05, mass=0.01, axes=((1, 0, 0), (0, 0, 1)), pinned="left")
    air = pc.Wind(lambda t: (3.0 + math.sin(20.0 * t), math.sin(11.0 * t), 0.0))
    pull = pc.Gravity(lambda t: (0.0, math.sin(7.0 * t), -9.81))
    drifts = []
    for dt in (1e-3, 5e-4):
        recording = pc.simulate(pc.Scene(cloth, air, pull), 1.0, dt=dt)
        assert np.abs(recording.energy.work).max() > 0.0
        drifts.append(np.abs(recording.energy.drift).max())
    assert drifts[1] <= 0.3 * drifts[0] <= 1e-3


def test_what_is_no_vector_is_named():
    with pytest.raises(pc.SceneError, match=r"^Gravity\.acceleration: its value: must be 2 or 3 numbers"):
        pc.Gravity(lambda t: 1.0)
    with pytest.raises(pc.SceneError, match=r"^Drag\.wind: the function raised ZeroDivisionError"):
        pc.Drag(linear=1.0, wind=lambda t: (1.0 / t, 0.0))
    scene = pc.Scene(pc.Particles([[0.0, 0.0]]), pc.Gravity(lambda t: (0.0, 0.0, 1.0)))
    with pytest.raises(pc.SceneError, match=r"^forces\[0\]\.acceleration: expected one vector of shape \(2,\)"):
        pc.Simulation(scene)
    late = pc.Gravity(lambda t: (0.0, -1.0 if t < 0.5 else math.nan))
    simulation = pc.Simulation(pc.Scene(pc.Particles([[0.0, 0.0]]), late), dt=0.01)
    with pytest.raises(pc.SimulationDiverged, match=r"forces\[0\]\.acceleration returns \[0\.0, NaN\] at 0\.5"):
        simulation.step(100)
    assert simulation.time == pytest.approx(0.49, abs=0.011)
    with pytest.raises(pc.FileError, match="Gravity"):
        pc.Scene(pc.Particles([[0.0, 0.0]]), late).packed()


@pytest.mark.parametrize("kind", [pc.XPBD, pc.ProjectiveDynamics, pc.BackwardEuler, pc.RungeKutta4])
def test_fields_that_alternate_are_taken_at_their_time(kind):
    """A charge in a Paul trap of ω = 2π is driven at its first place while it hardly moves: x'' = s x₀/2 cos ωt."""
    trap = pc.ElectromagneticField(pc.PaulTrap(0.0, 1e-3, 1.0))
    scene = pc.Scene(pc.Particles([[1.0, 0.0, 0.0]], mass=1.0, charge=1.0), trap)
    if kind is pc.BackwardEuler:
        with pytest.raises(pc.SceneError, match="integrator"):
            pc.Simulation(scene, kind(), dt=1e-3)
        return
    simulation = pc.Simulation(scene, kind(), dt=1e-3)
    simulation.step(750)
    moved = 0.5e-3 * (1.0 - math.cos(math.tau * 0.75)) / math.tau**2
    assert simulation.positions[0, 0] - 1.0 == pytest.approx(moved, rel=0.02)
