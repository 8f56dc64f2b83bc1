"""Extremes: ratios, offsets, degenerate geometry and numbers at the end of their range."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from physics.laboratory import ALL, EPSILON, LONG, SYMMETRIC, discrete_stiffness, name, network, simulation, state

OSCILLATING = [integrator for integrator in ALL if not isinstance(integrator, pc.ExplicitEuler)]


def chain(stiffness: list[float], masses: list[float], start: float = 0.0) -> pc.SpringNetwork:
    """A chain along x with spacing 1 whose first particle is a wall, each other one shifted by 0.01 to the right."""
    count = len(stiffness) + 1
    x = np.arange(count, dtype=float)
    positions = np.stack([start + x + 0.01 * (x > 0), np.zeros(count)], axis=1)
    pairs = [[i, i + 1] for i in range(count - 1)]
    return pc.SpringNetwork(positions, pairs, stiffness, rest_length=1.0, mass=[1.0, *masses], fixed=[0])


def modes(stiffness: list[float], masses: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies squared and mass-normalized shapes of the chain, from its own 1D matrix."""
    k = np.array(stiffness)
    matrix = np.diag(k + np.append(k[1:], 0.0)) - np.diag(k[1:], 1) - np.diag(k[1:], -1)
    root = np.sqrt(masses)
    squares, shapes = np.linalg.eigh(matrix / np.outer(root, root))
    return squares, shapes / root[:, None]


@pytest.mark.parametrize("integrator", OSCILLATING, ids=name)
@pytest.mark.parametrize(
    ("stiffness", "masses"),
    [
        pytest.param([1.0, 1e4], [1.0, 1.0], id="stiffness 1e4"),
        pytest.param([1.0, 1e8], [1.0, 1.0], id="stiffness 1e8"),
        pytest.param([1.0, 1.0], [1e6, 1.0], id="mass 1e6"),
        pytest.param([1.0, 1.0], [1.0, 1e6], id="mass 1e-6"),
    ],
)
def test_a_slow_mode_is_right_beside_a_fast_one(integrator, stiffness, masses):
    """At half the limit the slow mode follows cos Ωt with its discrete frequency Ω, however fast the other one is.

    Projected on the slow mode, the fast one drops out. Ωdt/ωdt = 1 + O((ω dt)²), so the error of the phase is
    (ω dt)² ωt (order 1 and 2: /24; semi-implicit Euler moreover starts off by ω dt/2). The stiff spring rounds its
    force by k ε L: 1e8 · 2e-16 N · 1 m on 1 kg, 2e-8 m/s² at random in every step.
    """
    squares, shapes = modes(stiffness, masses)
    slow = np.sqrt(squares[0])
    scene = pc.Scene(chain(stiffness, masses))
    dt = 0.5 * pc.stability_limit(scene, integrator)
    steps = min(int(1.0 / (slow * dt)), 200_000 if LONG else 20_000)
    run = simulation(scene, integrator, dt)
    weights = shapes[:, 0] * masses

    def amplitude() -> float:
        return float(weights @ (run.positions[1:, 0] - np.arange(1, len(masses) + 1)))

    first = amplitude()
    run.step(steps)
    phase = slow * steps * dt
    order = integrator.order
    truncation = 0.5 * slow * dt if order == 1 else (slow * dt) ** 2 * phase
    noise = 10.0 * max(stiffness) * EPSILON * steps**0.5 * dt * max(steps * dt, 1.0)
    assert amplitude() == pytest.approx(first * np.cos(phase), abs=abs(first) * truncation * 2.0 + noise)
    assert np.abs(run.positions[:, 1]).max() == 0.0


@pytest.mark.parametrize("integrator", OSCILLATING, ids=name)
def test_the_limit_follows_the_stiffest_spring_and_the_lightest_mass(integrator):
    """ω² ≤ d_i/m_i + d_j/m_j, and the true largest frequency lies within a factor √2 of it for these chains."""
    for stiffness, masses in (([1.0, 1e8], [1.0, 1.0]), ([1.0, 1.0], [1e6, 1.0]), ([1.0, 1.0], [1.0, 1e6])):
        scene = pc.Scene(chain(stiffness, masses))
        edge = pc.stability_limit(pc.Scene(chain([1.0], [1.0])), integrator)
        exact = edge / np.sqrt(modes(stiffness, masses)[0][-1])
        assert exact / np.sqrt(2.0) <= pc.stability_limit(scene, integrator) <= exact * (1.0 + 1e-12)


@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_far_from_the_origin_double_precision_is_right(integrator):
    """Offset by 1e7 m, positions are rounded to 1e-9 m: that times 20 N/m per kg, 300 steps of 5 ms, and nothing more.

    An error of ε 1e7 per step in x grows at most linearly to 300 · 1.9e-9 m = 6e-7 m, and the same times ω ≤ 28/s in v.
    """
    net, offset = network(seed=5, dimension=2, count=9), 1e7
    near = simulation(net.scene(positions=(net.positions + offset) - offset), integrator, 0.005)
    far = simulation(net.scene(positions=net.positions + offset), integrator, 0.005)
    near.step(300)
    far.step(300)
    assert np.abs(far.positions - offset - near.positions).max() < 6e-7
    assert np.abs(far.velocities - near.velocities).max() < 28 * 6e-7


def test_single_precision_is_relative_to_the_middle_of_the_scene():
    """A small scene far away has the bits of f32 near the origin: rounded to 1e-9 m as input, and to ε of its size."""
    net, offset = network(seed=5, dimension=2, count=9), 1e7
    near = simulation(net.scene(), pc.VelocityVerlet(), 0.005, precision="f32")
    far = simulation(net.scene(positions=net.positions + offset), pc.VelocityVerlet(), 0.005, precision="f32")
    near.step(300)
    far.step(300)
    # f32 rounds 3 m to 2.4e-7 m in each of 300 steps.
    assert np.abs(far.positions - offset - near.positions).max() < 300 * 2.4e-7


def test_where_single_precision_is_too_coarse_it_is_refused_with_the_reason():
    """Two small networks 1e7 m apart: f32 resolves 1 m there, and the springs are 1 m long."""
    net = network(seed=5, dimension=2, count=4)
    scene = pc.Scene(net.body(), net.body(positions=net.positions + 1e7))
    with pytest.raises(pc.SceneError, match=r"precision: .*f64.*too far apart"):
        pc.Simulation(scene, dt=0.005, precision="f32")
    assert pc.Simulation(scene, dt=0.005).plan.precision == "f64"


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_coincident_particles_stay_finite_and_symmetric(integrator, precision):
    """A hundred particles in one place, joined by springs: no direction, no force, wherever the spring's length is."""
    count = 100
    pairs = [[i, (i + 1) % count] for i in range(count)]
    knot = pc.SpringNetwork(np.full((count, 3), 0.3), pairs, 10.0, damping=0.5, rest_length=1.0)
    heap = pc.Particles(np.full((count, 3), 0.3))
    run = simulation(pc.Scene(knot, heap, pc.CentralForce((0.3, 0.3, 0.3), 1.0)), integrator, 0.01, precision=precision)
    run.step(100)
    assert (run.positions == run.positions[0]).all()
    assert (run.velocities == 0.0).all()
    assert np.isfinite(run.energy().kinetic)


@pytest.mark.parametrize("integrator", OSCILLATING, ids=name)
def test_a_spring_without_a_rest_length_is_linear_through_the_middle(integrator):
    """Two particles on such a spring swing through each other harmonically: ω² = 2k/m, x and y alike."""
    spring = pc.SpringNetwork([[-1.0, 0.5], [1.0, -0.5]], [[0, 1]], 2.0, rest_length=0.0)
    steps = {1: 40_000, 2: 4000, 3: 1000, 4: 400, 5: 200, 6: 40}[integrator.order]
    run = simulation(pc.Scene(spring), integrator, np.pi / 2.0 / steps)
    run.step(steps)
    # Half a turn at ω = 2/s. The errors: ω dt/2 = 4e-5 in v of order 1, (ω dt)² π/24 = 8e-8, (ω dt)³ π/24 = 4e-9,
    # (ω dt)⁴ π/120 = 2e-9, (ω dt)⁵ π/3600 = 8e-13, and less than (ω dt)⁶/100 = 2e-9.
    tolerance = {1: 2e-4, 2: 4e-7, 3: 1e-8, 4: 1e-8, 5: 1e-8, 6: 1e-8}[integrator.order]
    np.testing.assert_allclose(run.positions, [[1.0, -0.5], [-1.0, 0.5]], atol=tolerance)
    np.testing.assert_allclose(run.velocities, 0.0, atol=tolerance)


@pytest.mark.parametrize("integrator", ALL, ids=name)
@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_denormal_numbers_are_numbers(integrator, precision):
    """Elongations, speeds and masses at the end of the range give no NaN and leave the rest of the scene alone."""
    tiny = 1e-40 if precision == "f32" else 5e-324
    rest = pc.SpringNetwork([[0.0, 0.0], [1.0, tiny]], [[0, 1]], 1.0, velocities=[[tiny, 0.0], [0.0, -tiny]])
    point = pc.SpringNetwork([[0.0, 0.0], [tiny, tiny]], [[0, 1]], 1.0, rest_length=0.0, damping=1.0)
    slow = pc.Particles([[tiny, 0.0]], [[0.0, tiny]])
    scene = pc.Scene(rest, point, slow, pc.Drag(tiny, tiny), pc.Gravity((0.0, -tiny)))
    run = simulation(scene, integrator, 0.01, precision=precision)
    run.step(1000)
    assert np.isfinite(state(run)).all()
    assert np.abs(run[rest].positions - [[0.0, 0.0], [1.0, 0.0]]).max() < 1e-30


EXTREME = st.floats(min_value=5e-324, max_value=1.7e308, exclude_min=False) | st.integers(-323, 308).map(
    lambda exponent: float(f"1e{exponent}")
)
"""Any positive number, small ones as often as large ones."""


@given(
    numbers=st.lists(EXTREME, min_size=7, max_size=7),
    pinned=st.lists(st.integers(0, 2), max_size=2),
    integrator=st.sampled_from(ALL),
    precision=st.sampled_from(["f64", "f32"]),
)
def test_any_finite_numbers_make_a_scene_or_are_refused(numbers, pinned, integrator, precision):
    """Never a crash, and never a limit that is not a number, whatever overflows on the way."""
    length, stiffness, damping, mass, well, drag, rest = numbers
    try:
        rope = pc.rope(3, 1.0, stiffness, damping, mass, pinned=pinned or None)
        body = pc.SpringNetwork(
            [[0.0, 0.0], [length, 0.0], [length, length]],
            rope.pairs,
            stiffness,
            damping=damping,
            rest_length=rest,
            mass=mass,
            fixed=pinned or None,
        )
        for springs in (rope, body):
            scene = pc.Scene(springs, pc.CentralForce((0.0, 0.0), well, exponent=1.0), pc.Drag(drag, drag))
            assert pc.stability_limit(scene, integrator) >= 0.0
            run = simulation(scene, integrator, 1e-3, precision=precision)
            assert run.plan.dt_limit >= 0.0
            run.step(2)
    except (pc.SceneError, pc.SimulationDiverged):
        pass


def test_what_holds_a_fixed_particle_may_be_of_any_stiffness():
    run = pc.Simulation(pc.Scene(pc.rope(3, 1.0, 1e308, pinned=[1])))
    # ω² = k/m for both ends, 2/ω for Verlet.
    assert run.plan.dt_limit == pytest.approx(2.0 / np.sqrt(1e308), rel=1e-12)


@pytest.mark.parametrize(
    ("items", "path"),
    [
        ([pc.rope(3, 1.0, 1e39, pinned=[1])], r"bodies\[0\].stiffness"),
        ([pc.rope(3, 1.0, 1.0, damping=1e39)], r"bodies\[0\].damping"),
        ([pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], 1.0, rest_length=1e39)], r"bodies\[0\].rest_length"),
        ([pc.Particles([[0.0, 0.0]], velocities=(1e39, 0.0))], r"bodies\[0\].velocities"),
        ([pc.Particles([[0.0, 0.0], [1e39, 0.0]])], r"bodies\[0\].positions"),
        ([pc.Particles([[0.0, 0.0]], mass=1e-39)], r"bodies\[0\].mass"),
        ([pc.Particles([[0.0, 0.0]], mass=1e46)], r"bodies\[0\].mass"),
        ([pc.Particles([[0.0, 0.0]]), pc.Gravity((0.0, 1e39))], r"forces\[0\].acceleration"),
        ([pc.Particles([[0.0, 0.0]]), pc.Drag(1.0), pc.Drag(0.0, 1e39)], r"forces\[1\].quadratic"),
        ([pc.Particles([[0.0, 0.0]]), pc.CentralForce((0.0, 0.0), 1e39)], r"forces\[0\].strength"),
    ],
)
def test_what_single_precision_cannot_hold_is_refused_with_its_path(items, path):
    scene = pc.Scene(*items)
    with pytest.raises(pc.SceneError, match=path):
        pc.Simulation(scene, dt=1e-3, precision="f32")
    simulation(scene, pc.VelocityVerlet(), 1e-3, precision="f64")


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_nobody_in_the_scene_is_no_error(integrator, precision, dimension):
    empty = pc.Particles(np.empty((0, dimension)))
    springless = pc.SpringNetwork(np.empty((0, dimension)), np.empty((0, 2), dtype=int), 1.0)
    down = tuple(-np.eye(dimension)[-1])
    scene = pc.Scene(empty, springless, pc.Gravity(down), pc.Drag(1.0), pc.Floor(0.0))
    run = pc.Simulation(scene, integrator, 0.1, precision)
    run.step(10)
    assert run.positions.shape == (0, dimension)
    assert run.time == pytest.approx(1.0)
    energy = run.energy()
    assert (energy.total, energy.dissipated, energy.work) == (0.0, 0.0, 0.0)
    assert len(pc.simulate(scene, 0.5, fps=10.0)) == 6
    assert pc.stability_limit(scene, integrator) > 0.0


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_one_particle_moves_freely_and_exactly(integrator, precision, dimension):
    """With a binary dt and speed x = v t without a bit of error, but for weights that are no binary fractions: those of
    RungeKutta4 (1/6) and of the splittings round each of up to eleven additions a step by half an ε of 5 m.
    """
    velocity = np.array([[0.5, -0.25, 0.125][:dimension]])
    run = pc.Simulation(pc.Scene(pc.Particles(np.zeros((1, dimension)), velocity)), integrator, 1.0 / 64.0, precision)
    run.step(640)
    exact = isinstance(integrator, pc.ExplicitEuler | pc.SemiImplicitEuler | pc.VelocityVerlet)
    rounding = 0.0 if exact else 640 * 11 * 0.5 * float(np.finfo(precision.replace("f", "float")).eps) * 5.0
    assert np.abs(run.positions - 10.0 * velocity).max() <= rounding
    assert np.array_equal(run.velocities, velocity)


@pytest.mark.parametrize("integrator", SYMMETRIC, ids=name)
def test_ten_million_steps_have_no_trend(integrator, record_property):
    """The energy that the discrete motion of an oscillator keeps changes by rounding alone: an ε per stage with random
    signs, and five standard deviations of it; a trend of one ε per step would be 2e-9 J in 1e7.
    """
    steps = 10_000_000 if LONG else 250_000
    well = pc.CentralForce((0.0, 0.0, 0.0), 1.0, exponent=1.0)
    run = simulation(pc.Scene(pc.Particles([[1.0, 0.0, 0.0]]), well), integrator, 0.125)

    def kept() -> float:
        """The energy that the discrete motion keeps exactly."""
        x, v = run.positions[0, 0], run.velocities[0, 0]
        return float(v**2 + discrete_stiffness(integrator, 0.125) * x**2) / 2.0

    before = kept()
    run.step(steps)
    error = abs(kept() - before)
    record_property("error", f"{error:.1e} in {steps} steps")
    assert error <= 5.0 * 4.0 * np.sqrt(steps) * EPSILON


@given(count=st.integers(1, 40), factor=st.sampled_from([0.99, 1.01]))
def test_around_the_limit_of_a_chain_the_run_holds_or_says_that_it_does_not(count, factor):
    """Above the limit the fastest mode grows until the run is stopped with the reason; below, it stays."""
    scene = pc.Scene(chain([1.0] * count, [1.0] * count))
    # The exact edge of this chain; the certificate is a little below it.
    edge = 2.0 / np.sqrt(modes([1.0] * count, [1.0] * count)[0][-1])
    assert edge / np.sqrt(2.0) - 1e-12 <= pc.stability_limit(scene, pc.VelocityVerlet()) <= edge * (1.0 + 1e-12)
    run = simulation(scene, pc.VelocityVerlet(), factor * edge)
    if factor < 1.0:
        before = run.energy().total
        run.step(2000)
        assert run.energy().total <= 60.0 * before
    else:
        with pytest.raises(pc.SimulationDiverged, match="beyond the limit"):
            run.step(20_000)
