"""The edge of stability: where theory puts it for each integrator, within 1 %, and inside of it what is certified."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

import physcore as pc
from physics.laboratory import ALL, LONG, amplification, growing_step, largest_step, name, networks, simulation

RATIOS = [0.0, 0.1, 1.0, 10.0]
STEPS = 10_000
START = 1e-6
"""The first elongation [m] of a spring of 1 m: it may grow a thousandfold, and the force stays linear in it."""


def oscillator(ratio: float) -> pc.Scene:
    """One spring along x with ω = 1/s and damping ratio ξ: x'' = −x − 2ξx' for the elongation x, exactly in 1D."""
    spring = pc.SpringNetwork(
        [[0.0, 0.0], [1.0 + START, 0.0]], [[0, 1]], stiffness=1.0, damping=2.0 * ratio, rest_length=1.0, fixed=[0]
    )
    return pc.Scene(spring)


def elongation(run: pc.Simulation) -> float:
    """Of the spring and its speed, as multiples of the first one."""
    return float(np.hypot(run.positions[1, 0] - 1.0, run.velocities[1, 0])) / START


def largest(ratio: float, integrator: pc.Integrator, dt: float, steps: int, ceiling: float) -> float:
    """The largest elongation seen in so many steps, or the first one above `ceiling`; looked at every third step, or at
    as many places as in 30,000 of them.
    """
    run = simulation(oscillator(ratio), integrator, dt, on_divergence="ignore")
    peak, stride = 1.0, max(3, steps // STEPS)
    while run.steps < steps and peak <= ceiling:
        run.step(stride)
        peak = max(peak, elongation(run))
    return peak


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_a_step_just_below_the_limit_is_bounded_and_one_just_above_grows(integrator, ratio, record_property):
    """At 0.99 of the theoretical limit nothing grows; up to 1 % above, there is a step that grows beyond that bound.

    The largest that a stable one becomes: explicit Euler at ξ = 1 has the double factor g = 1 − 0.99·2 = −0.98, and
    so reaches n·1.98·0.98ⁿ⁻¹ ≤ 38 in x and in v, 53 together. Undamped, Verlet's ellipse is elongated by 1/√(1 −
    0.99²) = 7.1. What is unstable grows a hundredfold in ln 100/(|g| − 1) steps, and has twice as many: up to 1.9e6
    for DormandPrince5, which grows by 4.9e-6 in each. At ξ = 0 explicit Euler's limit is 0 and it grows at any step:
    0.01 stands for 1.01 · 0, where it grows by (1 + 1e-4)^5000 = 1.6 in 1e4 steps.
    """
    if isinstance(integrator, pc.ExplicitEuler) and ratio == 0.0:
        run = simulation(oscillator(ratio), integrator, 0.01)
        run.step(STEPS)
        assert elongation(run) == pytest.approx((1.0 + 1e-4) ** (STEPS / 2), rel=1e-6)
        assert pc.stability_limit(oscillator(ratio), integrator) == 0.0
        return
    limit = largest_step(integrator, ratio)
    record_property("limit", f"ω dt = {limit:.6f}")
    assert largest(ratio, integrator, 0.99 * limit, STEPS, ceiling=54.0) <= 54.0
    growing = growing_step(integrator, ratio)
    growth = np.abs(np.linalg.eigvals(amplification(integrator, growing, ratio))).max() - 1.0
    steps = 3 * STEPS + round(2.0 * np.log(100.0) / growth)
    assert largest(ratio, integrator, growing, steps, ceiling=100.0) > 100.0


@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_without_damping_the_certified_limit_of_one_spring_is_the_theoretical_one(integrator):
    """ω² ≤ k/m is exact for one spring on a wall, so that the certificate is the edge itself."""
    certified = pc.stability_limit(oscillator(0.0), integrator)
    if isinstance(integrator, pc.ExplicitEuler):
        assert certified == 0.0
    else:
        # The margin of 1e-10 in |g| over its least slope, that of DormandPrince5: 4.9e-4 per fraction of the limit.
        assert certified == pytest.approx(largest_step(integrator), rel=2.1e-7)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_the_certified_limit_is_on_the_safe_side(integrator, ratio):
    """It holds for all modes that the bounds on stiffness and on damping allow together, so it may be smaller."""
    assert pc.stability_limit(oscillator(ratio), integrator) <= largest_step(integrator, ratio) * (1.0 + 1e-6)


@pytest.mark.parametrize("ratio", [0.1, 0.5, 1.0, 10.0])
@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_the_limit_of_a_well_with_drag_is_exact(integrator, ratio):
    """Every particle is an oscillator with one ω and one γ, so that the limit is that of the integrator: real runs hold
    at 0.99 of it and grow up to 1.01 of it, where the amplification is largest. The limits agree to what the walk
    leaves open, 1e-6 in |g| over its slope in ω dt: 0.1 for ExplicitEuler at ξ = 0.1, and more for the others.
    """
    well, drag = pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0), pc.Drag(linear=2.0 * ratio)
    scene = pc.Scene(pc.Particles([[1.0, 0.0], [0.5, 0.5]]), well, drag)
    limit = pc.stability_limit(scene, integrator)
    assert limit == pytest.approx(largest_step(integrator, ratio), rel=1e-4)
    below = simulation(scene, integrator, 0.99 * limit)
    below.step(STEPS)
    # As in the test of the edge above: what is stable reaches at most 38 in x.
    assert np.abs(below.positions).max() < 38.0
    growing = growing_step(integrator, ratio)
    growth = np.abs(np.linalg.eigvals(amplification(integrator, growing, ratio))).max() - 1.0
    above = simulation(scene, integrator, growing, on_divergence="ignore")
    # The mode that grows has a share of at least 1e-3 in x, the less the more it is damped.
    above.step(100 + round(np.log(1e6) / growth))
    assert np.abs(above.positions).max() > 100.0


@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_a_well_too_weak_to_feel_leaves_the_limit_to_drag(integrator):
    """The fast one of the rates γ/2 ± √(γ²/4 − ω²) is less than that of drag alone by ω²/γ² of it, at most 2.5e-14."""
    body, drag = pc.Particles([[1.0, 0.0]]), pc.Drag(linear=2.0)
    limit = pc.stability_limit(pc.Scene(body, drag), integrator)
    assert 0.0 < limit < np.inf
    for strength in (1e-13, 1e-20):
        well = pc.CentralForce((0.0, 0.0), strength, exponent=1.0)
        assert pc.stability_limit(pc.Scene(body, drag, well), integrator) == pytest.approx(limit, rel=1e-9)


def test_explicit_euler_is_held_by_the_least_damped_of_stiff_modes():
    """|g|² = 1 − 2ξy + y² for y = ωh asks for h ≤ γ/ω²: a damped spring elsewhere does not help the stiff one."""
    net = pc.SpringNetwork(
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]], [[0, 1], [2, 3]], stiffness=[100.0, 1.0], damping=[0.0, 3.0]
    )
    limit = pc.stability_limit(pc.Scene(net, pc.Drag(linear=1.0)), pc.ExplicitEuler())
    # Two free unit masses on a spring of 100 N/m: ω² = 200/s², and both feel a drag of 1 N·s/m.
    assert limit == pytest.approx(1.0 / 200.0, rel=1e-6)


@pytest.mark.parametrize("integrator", ALL[1:], ids=name)
@given(net=networks())
def test_any_network_is_stable_just_below_its_certified_limit(integrator, net):
    """Strains of 1e-9 stay linear: their energy stays within what the fastest mode allows at 0.99 of its limit.

    Half the swing of Verlet's energy at that step is 0.98 of it over 1 − 0.98: fifty times. RungeKutta4 only loses.
    """
    still = net.scene(rest_length=None, velocities=1e-9 * net.velocities)
    run = simulation(still, integrator, 0.99 * pc.stability_limit(still, integrator), on_divergence="ignore")
    before = run.energy().total
    run.step(STEPS if LONG else 1000)
    assert run.energy().total <= 100.0 * before


@pytest.mark.parametrize("integrator", ALL[1:], ids=name)
@given(net=networks(damping=10.0))
def test_any_damped_network_is_stable_just_below_its_certified_limit(integrator, net):
    """With damping nothing can grow for long; what a non-normal step does at first is within the same bound."""
    still = net.scene(rest_length=None, velocities=1e-9 * net.velocities)
    run = simulation(still, integrator, 0.99 * pc.stability_limit(still, integrator), on_divergence="ignore")
    before = run.energy().total
    run.step(STEPS if LONG else 1000)
    assert run.energy().total <= 100.0 * before


@pytest.mark.parametrize("integrator", ALL, ids=name)
@pytest.mark.parametrize("ratio", RATIOS)
def test_a_step_is_what_its_published_formula_says(integrator, ratio):
    """Ten steps of a spring without a rest length, in 3D at once, against the matrix of the formulas.

    The numbers are at most 1e3 for these steps, and each step rounds them a few times: 1e-12 relative to that.
    """
    dt = 0.3 / max(1.0, ratio)
    start = np.array([[1.0, -0.5, 0.25]])
    well, drag = pc.CentralForce((0.0, 0.0, 0.0), 1.0, exponent=1.0), pc.Drag(linear=2.0 * ratio)
    run = simulation(pc.Scene(pc.Particles(start, 2.0 * start), well, drag), integrator, dt)
    run.step(10)
    first = np.array([1.0, 2.0, -1.0 - 2.0 * ratio * 2.0])
    x, v, _ = np.linalg.matrix_power(amplification(integrator, dt, ratio), 10) @ first
    np.testing.assert_allclose(run.positions, x * start, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(run.velocities, v * start, rtol=1e-12, atol=1e-12)
