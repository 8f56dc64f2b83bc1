"""The limit of stability that real runs find is that of theory where theory is exact, and above it elsewhere."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc
from physcore.studies.stability import MAX_ENERGY_GROWTH, STEPS
from physics.laboratory import ALL, LONG, amplification, largest_step, line, name, network

STABLE = [integrator for integrator in ALL if not isinstance(integrator, pc.ExplicitEuler)]
RESONANT = ("BlanesMoan4", "BlanesMoan6")
"""Theory ends their stable interval at a resonance near ωh = π, five and one thousandths wide, in which little grows:
runs may step over it."""

WELL = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0))


def growing_step(integrator: pc.Integrator, gain: float) -> float:
    """The ω dt from which an oscillation's energy grows by `gain` (ω dt)² in the steps of a trial, as a multiple of the
    limit of theory: (ω dt)² times that of the motion is the energy of the first kick, against which a trial judges.

    Just above the limit BogackiShampine3 grows slowly, by 3δ/4 at 1 + δ of it, and DormandPrince5 by 4.9e-4 δ, so that
    a trial finds them 3e-3 and 0.4 above it.
    """
    multiples = 1.0 + 1e-4 * np.arange(10_000)
    steps = multiples * largest_step(integrator)
    radii = np.abs(np.linalg.eigvals(amplification(integrator, steps))).max(axis=-1)
    return float(multiples[np.flatnonzero(2.0 * STEPS * np.log(radii) > np.log(gain * steps**2))[0]])


@pytest.mark.parametrize("integrator", STABLE, ids=name)
def test_a_lone_oscillator_has_the_limit_of_theory(integrator):
    """Within the resolution of the bisection, 1e-3, to either side of what a trial can tell."""
    found = pc.stability_limit(WELL, integrator, measured=True)
    assert found.theory == pc.stability_limit(WELL, integrator)
    assert found.margin >= -2e-3
    if name(integrator) not in RESONANT:
        assert found.measured == pytest.approx(found.theory * growing_step(integrator, MAX_ENERGY_GROWTH), rel=2e-3)
    assert f"{found.theory:.4g} s" in str(found)


@pytest.mark.parametrize("integrator", STABLE, ids=name)
def test_a_chain_has_the_limit_of_its_highest_mode(integrator):
    """n free masses on a line: ω = 2 √(k/m) cos(π/2n). Its mode has a thousandth of the nudge's energy, or more."""
    count = 6
    pairs = np.stack([np.arange(count - 1), np.arange(1, count)], axis=1)
    scene = pc.Scene(pc.SpringNetwork(line(np.arange(count)), pairs, 100.0))
    found = pc.stability_limit(scene, integrator, measured=True)
    highest = 20.0 * math.cos(0.5 * math.pi / count)
    ratio = found.measured * highest / pc.stability_limit(WELL, integrator)
    assert ratio >= 1.0 - 3e-3
    assert name(integrator) in RESONANT or ratio <= growing_step(integrator, 1000.0 * MAX_ENERGY_GROWTH) * (1.0 + 3e-3)


@pytest.mark.parametrize("seed", range(50 if LONG else 5))
def test_the_limit_of_a_network_is_right_while_it_moves(seed, record_property):
    """Springs that begin 5 % too long or too short swing as far to the other side: 10 % of a spring's stiffness across
    it, 5 % of the limit, to either side. Without motion the limit is 0.962 to 1.001 of the true one.
    """
    scene = network(seed, dimension=2 + seed % 2, count=10, motion=1e-6).scene()
    found = pc.stability_limit(scene, pc.VelocityVerlet(), measured=True)
    record_property("margin", found.margin)
    assert -0.055 <= found.margin <= 0.1


def test_where_nothing_or_everything_is_stable_nothing_is_run():
    free = pc.stability_limit(pc.Scene(pc.Particles([[0.0, 0.0]])), pc.VelocityVerlet(), measured=True)
    assert math.isinf(free.measured)
    assert "nothing limits" in str(free)
    euler = pc.stability_limit(WELL, pc.ExplicitEuler(), measured=True)
    assert euler.measured == euler.theory == euler.margin == 0.0
    assert "theory promises no stable step" in str(euler)


def test_what_is_no_scene_is_named():
    with pytest.raises(pc.SceneError, match="scene: must be a Scene"):
        pc.stability_limit(WELL.bodies[0], pc.VelocityVerlet(), measured=True)  # type: ignore[call-overload]
