"""The limit of the time step from a function of the user's: its gradients, found by calling it."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

import physcore as pc
from physcore.integrators import INTEGRATORS

MARGIN = 1.1
"""How much is added to a gradient's norm where it was not found whole: the limit is then lower by its root, 4.7 %."""
ROUNDING = 1e-4
"""How well it is found where all directions were tried."""

each_integrator = pytest.mark.parametrize(
    "integrator", [kind() for kind in INTEGRATORS if kind.advances("Wave")], ids=lambda i: type(i).__name__
)


def limit(scene: pc.Scene, integrator: pc.Integrator | None = None) -> float:
    return pc.stability_limit(scene, integrator or pc.VelocityVerlet())


def dust(count: int = 7, dimension: int = 2, **values: object) -> pc.Particles:
    return pc.Particles(np.random.default_rng(1).normal(size=(count, dimension)), **values)


@each_integrator
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_well_has_the_limit_of_the_central_force(integrator, dimension):
    body = dust(dimension=dimension)
    given = pc.CentralForce((0.0,) * dimension, 40.0, exponent=1.0)
    own = pc.CustomForce(lambda time, x, v: -40.0 * x)
    assert limit(pc.Scene(body, own), integrator) == pytest.approx(
        limit(pc.Scene(body, given), integrator), rel=ROUNDING
    )


@each_integrator
def test_damping_has_the_limit_of_drag(integrator):
    given, own = pc.Drag(linear=3.0), pc.CustomForce(lambda time, x, v: -3.0 * v)
    assert limit(pc.Scene(dust(), own), integrator) == pytest.approx(
        limit(pc.Scene(dust(), given), integrator), rel=ROUNDING
    )


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_stiffness_and_damping_are_told_apart(precision):
    """As for a well with drag, of which a VelocityVerlet needs h ≤ 2 (√(4ξ² + 1) − 2ξ)/ω, ξ = c/2√(km)."""
    own = pc.CustomForce(lambda time, x, v: -40.0 * x - 3.0 * v)
    run = pc.Simulation(pc.Scene(dust(mass=0.5), own), "VelocityVerlet", precision=precision)
    frequency = math.sqrt(40.0 / 0.5)
    ratio = 3.0 / 0.5 / (2.0 * frequency)
    assert run.plan.dt_limit == pytest.approx(2.0 / frequency * (math.hypot(1.0, 2.0 * ratio) - 2.0 * ratio), rel=1e-3)
    assert run.plan.limit_term == "custom"
    note = next(note for note in run.plan.notes if "stiffness per mass" in note)
    assert note.startswith("custom: stiffness per mass up to 8.000e1 1/s², damping per mass up to 6.000e0 1/s")


def chain(count: int, **values: object) -> pc.SpringNetwork:
    positions = np.stack([np.arange(count), np.zeros(count)], axis=1)
    pairs = np.stack([np.arange(count - 1), np.arange(1, count)], axis=1)
    return pc.SpringNetwork(positions, pairs, stiffness=25.0, **values)


def pull(time: float, x: np.ndarray, v: np.ndarray) -> np.ndarray:
    """What the springs of a chain do."""
    apart = np.diff(x, axis=0)
    length = np.linalg.norm(apart, axis=1, keepdims=True)
    tension = 25.0 * (length - 1.0) * apart / length
    return np.pad(tension, ((0, 1), (0, 0))) - np.pad(tension, ((1, 0), (0, 0)))


@pytest.mark.parametrize("count", [2, 5, 40, 2000])
@pytest.mark.parametrize("fixed", [None, [0]], ids=["free", "pinned"])
def test_a_chain_of_springs_has_the_limit_of_the_network(count, fixed):
    """The true limit is 2/ω with the largest eigenvalue ω² of M⁻¹K: never above it, and below by the margin at most."""
    mass = 1.0 + np.arange(count) % 2
    given = chain(count, mass=mass, fixed=fixed)
    own = pc.Particles(given.positions, mass=mass, fixed=fixed)
    inverse = 1.0 / mass
    inverse[[] if fixed is None else fixed] = 0.0
    ends = np.diff(np.eye(min(count, 200)), axis=0)  # A longer chain's largest eigenvalue is the same within 1e-4.
    root = np.sqrt(inverse[: ends.shape[1]])
    exact = 2.0 / math.sqrt(25.0 * np.linalg.eigvalsh(root[:, None] * (ends.T @ ends) * root)[-1])
    found = limit(pc.Scene(own, pc.CustomForce(pull)))
    assert exact / math.sqrt(MARGIN) * (1.0 - ROUNDING) <= found <= exact * (1.0 + ROUNDING)
    assert found == pytest.approx(limit(pc.Scene(given)), rel=0.06)


@pytest.mark.parametrize("count", [3, 300])
def test_one_stiff_particle_among_many_is_found(count):
    """A floor that one of them touches, and one that is lighter than all others."""
    body = dust(count)
    lowest = np.sort(body.positions[:, 1])[:2].mean()

    def floor(time, x, v):
        return np.stack([np.zeros(len(x)), 1e4 * np.maximum(lowest - x[:, 1], 0.0)], axis=1)

    assert limit(pc.Scene(body, pc.CustomForce(floor))) == pytest.approx(0.02, rel=0.05)
    mass = np.ones(count)
    mass[1] = 1e-4
    light = limit(pc.Scene(dust(count, mass=mass), pc.CustomForce(lambda time, x, v: -x)))
    assert 0.02 * 0.95 <= light <= 0.02 * (1.0 + ROUNDING)


@pytest.mark.parametrize("mask", [[True, False], [True, True]], ids=["one fixed", "all fixed"])
def test_what_is_fixed_limits_nothing(mask):
    body = pc.Particles([[0.0, 0.0], [1.0, 0.0]], fixed=mask)
    stiff = pc.CustomForce(lambda time, x, v: -np.array([[1e6], [1.0]]) * x)
    assert limit(pc.Scene(body, stiff)) == (math.inf if all(mask) else pytest.approx(2.0, rel=ROUNDING))


@each_integrator
def test_a_force_that_does_not_change_limits_nothing(integrator):
    body = dust(velocities=1.0)
    for force in (lambda time, x, v: 0.0 * x, lambda time, x, v: np.broadcast_to([0.0, -9.81 + time], x.shape)):
        assert limit(pc.Scene(body, pc.CustomForce(force)), integrator) == math.inf


@pytest.mark.parametrize("count", [1, 2, 30])
@pytest.mark.parametrize("shift", [1e-6, 1.0, 1e3, 1e6])
def test_the_limit_does_not_depend_on_where_the_scene_stands(count, shift):
    """Coordinates of 1e6 m are rounded to 1e-10 m, and displaced by 4e-5 m or more: slopes are off by 1e-5."""
    body = dust(count)
    moved = pc.Particles(body.positions + shift)
    here = limit(pc.Scene(body, pc.CustomForce(lambda time, x, v: -25.0 * x - x**3)))
    there = limit(pc.Scene(moved, pc.CustomForce(lambda time, x, v: -25.0 * (x - shift) - (x - shift) ** 3)))
    assert there == pytest.approx(here, rel=1e-3)
    assert here < 2.0 / 5.0


@pytest.mark.parametrize("size", [1e-9, 1e-6, 1.0, 1e9])
def test_the_limit_does_not_depend_on_the_units(size):
    body = dust()
    scaled = pc.Particles(size * body.positions)
    hardening = pc.CustomForce(lambda time, x, v: -25.0 * x * (1.0 + (x / size) ** 2))
    whole = pc.CustomForce(lambda time, x, v: -25.0 * x * (1.0 + x**2))
    expected = limit(pc.Scene(body, whole))
    assert limit(pc.Scene(scaled, hardening)) == pytest.approx(expected, rel=ROUNDING)
    assert expected < 2.0 / 5.0


def test_a_kink_counts_with_its_steeper_side():
    """A penalty floor that is just touched: on one side there is nothing, on the other k."""
    floor = pc.CustomForce(lambda time, x, v: np.stack([0.0 * x[:, 0], -1e4 * np.minimum(x[:, 1], 0.0)], axis=1))
    assert limit(pc.Scene(pc.Particles([[0.0, 0.0]]), floor)) == pytest.approx(0.02, rel=ROUNDING)
    assert limit(pc.Scene(pc.Particles([[0.0, 1e-3]]), floor)) == math.inf


def test_a_jump_has_no_slope():
    """Dry friction jumps at rest, and a step is stable whatever its size; the spring beside it counts as ever."""
    for speed in (0.0, 1.0):
        body = dust(velocities=[speed, 0.0])
        friction = pc.CustomForce(lambda time, x, v: -np.sign(v))
        assert limit(pc.Scene(body, friction)) == math.inf
        held = pc.CustomForce(lambda time, x, v: -np.sign(v) - 25.0 * x)
        assert limit(pc.Scene(body, held)) == pytest.approx(0.4, rel=ROUNDING)


def test_what_is_not_finite_beside_the_state_does_not_count():
    """√x at 0 has no value on one side, and no steady slope on the other."""

    def force(time, x, v):
        with np.errstate(invalid="ignore"):
            return -np.sqrt(x) - 25.0 * x[:, ::-1]

    run = pc.Simulation(pc.Scene(pc.Particles([[0.0, 0.0], [1.0, 4.0]]), pc.CustomForce(force)), dt=1e-3)
    assert math.isfinite(run.plan.dt_limit)


def test_noise_is_not_taken_for_stiffness():
    random = np.random.default_rng(1)
    noisy = pc.CustomForce(lambda time, x, v: random.normal(size=x.shape))
    assert limit(pc.Scene(dust(), noisy)) == math.inf


@pytest.mark.parametrize("integrator", [pc.VelocityVerlet(), pc.RungeKutta4()], ids=lambda i: type(i).__name__)
def test_velocities_that_are_turned_keep_their_size(integrator):
    """v × B: no damped mode, but a turn at ω = qB/m, which an automatic time step takes in two hundred steps.

    Velocity Verlet asks for the force at v + h a, with the a of the step before: the largest eigenvalue of a step is
    1 + (ωh)⁴/4 + … = 1 + 2.44e-7 at ωh = π/100, in 2000 steps 4.9e-4.
    """
    turn = 50.0
    scene = pc.Scene(
        pc.Particles([[0.0, 0.0]], velocities=[[1.0, 0.0]]),
        pc.CustomForce(lambda time, x, v: turn * np.stack([v[:, 1], -v[:, 0]], axis=1)),
    )
    run = pc.Simulation(scene, integrator)
    assert run.plan.dt_limit == pytest.approx(2.0 * math.pi / turn / 100.0, rel=ROUNDING)
    assert run.plan.limit_term == "custom"
    run.step(2000)
    assert np.linalg.norm(run.velocities) == pytest.approx(1.0, abs=5e-4)


def stiff(strength: float) -> pc.Scene:
    return pc.Scene(
        pc.Particles([[1.0, 0.0]]),
        pc.CustomForce(lambda time, x, v: -strength * x, lambda x: 0.5 * strength * float((x**2).sum())),
    )


def test_an_automatic_time_step_conserves_the_energy_of_a_stiff_force():
    """Verlet keeps v² + (1 − (ωh)²/4) ω²x²: at ωh ≤ 1 the energy swings by a third, and does not grow."""
    run = pc.Simulation(stiff(1e5), "VelocityVerlet", pc.AutoStep())
    energies = []
    for _ in range(50):
        run.run(0.1)
        energies.append(run.energy().total)
    assert run.dt * math.sqrt(1e5) <= 1.0 + ROUNDING
    assert max(energies) / min(energies) <= 4.0 / 3.0 + ROUNDING


def test_a_time_step_above_the_limit_is_warned_of():
    with pytest.warns(pc.StabilityWarning, match=r"VelocityVerlet in this scene, 0\.02 s \(custom\): .* may blow up"):
        pc.Simulation(stiff(1e4), dt=0.021)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pc.Simulation(stiff(1e4), dt=0.0199)


def growing() -> pc.Scene:
    return pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(lambda time, x, v: -1e4 * (1.0 + time / 4.0) ** 2 * x))


def test_a_stiffness_that_grows_in_time_is_looked_at_again():
    """ω = 100 (1 + t/4) /s grows fourfold in 12 s, and less than √2 times in 256 steps: no step is above the limit."""
    run = pc.Simulation(growing(), "VelocityVerlet", pc.AutoStep())
    assert run.plan.dt_limit == pytest.approx(0.02, rel=ROUNDING)
    first = run.dt
    for end in range(1, 13):
        run.run(1.0)
        assert run.dt <= 2.0 / (100.0 * (1.0 + end / 4.0))
    assert run.dt <= 0.5 * first
    # Of a slow change the action E/ω is an invariant, so that the amplitude falls like 1/√ω: by half. Verlet's ellipse
    # is elongated by 1/√(1 − (ωh)²/4), at ωh ≤ √2 by √2.
    assert np.abs(run.positions).max() <= 0.5 * math.sqrt(2.0) * 1.05


def test_adaptive_steps_follow_a_force_that_stiffens():
    """F = −1000 x³: the limit at x is 2/√(3000 x²), so that steps are small where the swing is wide."""
    scene = pc.Scene(
        pc.Particles([[1.0, 0.0]]),
        pc.CustomForce(lambda time, x, v: -1000.0 * x**3, lambda x: 250.0 * float((x**4).sum())),
    )
    run = pc.Simulation(scene, dt=pc.AdaptiveStep(safety=0.5))
    before = run.energy().total
    run.run(1.0)
    _, _, smallest, largest = run._world.adaptation()
    assert smallest <= 0.5 * 2.0 / math.sqrt(3000.0) < largest
    assert run.energy().total == pytest.approx(before, rel=1.0 / 3.0)


def test_the_limit_follows_the_same_steps_however_they_are_asked_for():
    whole, pieces = pc.Simulation(growing()), pc.Simulation(growing())
    whole.step(600)
    for _ in range(60):
        pieces.step(10)
    assert whole.state_hash() == pieces.state_hash()


@pytest.mark.parametrize(
    "ask",
    [
        lambda scene: pc.stability_limit(scene, pc.VelocityVerlet()),
        lambda scene: pc.Simulation(scene),
        lambda scene: pc.Simulation(scene, dt=0.1),
        lambda scene: pc.Simulation(scene, dt=pc.AdaptiveStep()),
    ],
    ids=["stability_limit", "auto", "fixed", "adaptive"],
)
@pytest.mark.parametrize("error", [ValueError("off the map"), SystemExit(3)], ids=["ValueError", "SystemExit"])
def test_an_error_in_a_look_at_the_limit_is_raised(ask, error):
    def force(time, x, v):
        if x[0, 1] != 0.0:
            raise error
        return -x

    scene = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(force))
    expected = pc.SceneError if isinstance(error, ValueError) else SystemExit
    with pytest.raises(expected) as caught:
        ask(scene)
    assert error in (caught.value, caught.value.__cause__)


def test_the_calls_of_a_look_are_as_many_as_the_plan_says():
    """Twice at the state, and two for the one product that a single particle needs for each of both gradients."""
    times = []

    def force(time, x, v):
        times.append(time)
        return -x

    run = pc.Simulation(pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(force)), "VelocityVerlet")
    begun = len(times)
    assert run.plan.dt_limit == pytest.approx(2.0, rel=ROUNDING)
    assert begun <= 1 + 2 + 2 + 2
    assert any("up to 130 times" in note for note in run.plan.notes)
