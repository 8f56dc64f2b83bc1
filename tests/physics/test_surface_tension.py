"""Surface tension: its force is that of its energy, it keeps momentum, and draws drops round and together."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import EPSILON, Array


def still(sound_speed: float, **changes: object) -> pc.WeaklyCompressible:
    """A method that dissipates nothing."""
    return pc.WeaklyCompressible(
        **{"sound_speed": sound_speed, "artificial_viscosity": 0.0, "density_diffusion": 0.0, **changes}
    )


STILL = still(20.0)


def heap(dimension: int) -> Array:
    """Some fluid, out of order and compressed, in units of its spacing: the local density is up to 1.9."""
    cells = 0.93 * pc.ball((0.0,) * dimension, 4.2, 1.0)
    return cells + 0.1 * np.random.default_rng(7).standard_normal(cells.shape)


def scenes(name: str, positions: Array) -> pc.Scene:
    """A fluid whose density is that at rest, so that nothing pushes but tension."""

    def fluid(part: slice | Array, tension: float) -> pc.Fluid:
        return pc.Fluid(positions[part], 1.0, density=1.0, viscosity=0.0, surface_tension=tension)

    if name == "two fluids":
        left = positions[:, 0] < 0.0
        return pc.Scene(fluid(left, 1.0), fluid(~left, 0.5))
    if name == "a corner":
        return pc.Scene(fluid(slice(None), 1.0), pc.Box((-3.7,) * 2, (9.0,) * 2))
    if name == "periodic":
        return pc.Scene(fluid(slice(None), 1.0), pc.Periodic((-4.5, -20.0), (4.5, 20.0)))
    if name == "obstacle":
        post = pc.Particles(np.stack([np.arange(-5.0, 6.0), np.full(11, -4.3)], axis=1), fixed=True)
        return pc.Scene(fluid(slice(None), 1.0), post)
    return pc.Scene(fluid(slice(None), 1.0))


CASES = [
    ("a drop", 2),
    ("a drop", 3),
    ("two fluids", 2),
    ("two fluids", 3),
    ("a corner", 2),
    ("periodic", 2),
    ("obstacle", 2),
]


def energy(name: str, positions: Array) -> float:
    run = pc.Simulation(scenes(name, positions), dt=1e-6, precision="f64", fluids=STILL)
    return float(run.energy().by_term["surface tension"])


@pytest.mark.parametrize(("name", "dimension"), CASES)
def test_its_force_is_that_of_its_energy(name, dimension):
    """By central differences over 1e-4: their error is 1e-8/6 of a third derivative, some 100 σ/Δ², and ε E/1e-4.

    The second derivative of the kernel is good to 1e-6 over u, 1e-5 of it. The force is read from one short step.
    """
    positions, dt, shift = heap(dimension), 1e-6, 1e-4
    run = pc.Simulation(scenes(name, positions), dt=dt, precision="f64", fluids=STILL)
    run.step(1)
    count = len(positions)
    order = np.argsort(~(positions[:, 0] < 0.0), kind="stable") if name == "two fluids" else np.arange(count)
    forces = np.empty_like(positions)
    forces[order] = run.velocities[:count] / dt
    largest = np.abs(forces).max()
    assert largest > 0.5
    # Some anywhere, and those next to the interface, the walls and the obstacle.
    near = [np.abs(positions[:, 0]).argmin(), positions[:, 1].argmin(), positions.sum(axis=1).argmin()]
    for index in (0, count // 3, count // 2, count - 1, *near):
        for axis in range(dimension):
            step = np.zeros_like(positions)
            step[index, axis] = shift
            slope = (energy(name, positions + step) - energy(name, positions - step)) / (2.0 * shift)
            assert forces[index, axis] == pytest.approx(-slope, abs=3e-5 * largest)


@pytest.mark.parametrize("dimension", [2, 3])
def test_it_keeps_momentum_and_angular_momentum(dimension):
    """To the rounding of the sums over N particles: ε √N of the sum of what each has."""
    positions = heap(dimension)
    run = pc.Simulation(scenes("a drop", positions), dt=0.02, precision="f64", fluids=STILL)
    run.step(50)
    sizes = np.abs(run.velocities).sum()
    turns = np.abs(np.linalg.norm(run.positions, axis=1) * np.linalg.norm(run.velocities, axis=1)).sum()
    assert sizes > 1.0
    assert np.abs(run.momentum()).max() <= 100.0 * EPSILON * sizes
    assert np.abs(run.angular_momentum()).max() <= 100.0 * EPSILON * turns


def test_without_it_there_is_none_of_it():
    """Not in the audit, and not in the bits."""
    cells = heap(2)
    none, zero = (
        pc.Simulation(pc.Scene(pc.Fluid(cells, 1.0, **given)), dt=0.01, fluids=pc.WeaklyCompressible(5.0))
        for given in ({}, {"surface_tension": 0.0})
    )
    none.step(20)
    zero.step(20)
    assert none.state_hash() == zero.state_hash()
    assert "surface tension" not in none.energy().by_term


@pytest.mark.parametrize("kernel", [pc.WendlandC2(), pc.WendlandC4(), pc.CubicSpline()], ids=lambda k: type(k).__name__)
def test_a_lattice_without_a_surface_feels_nothing(kernel):
    """In a closed box each particle has all of its neighbors: forces are what rounding leaves of σ/Δ²."""
    water = pc.Fluid(
        pc.block((0.0, 0.0), (12.0, 12.0), 1.0),
        1.0,
        density=1.0,
        viscosity=0.0,
        surface_tension=1.0,
    )
    scene = pc.Scene(water, pc.Box((0.0, 0.0), (12.0, 12.0)))
    run = pc.Simulation(scene, dt=1e-3, precision="f64", fluids=still(20.0, kernel=kernel))
    assert run.energy().by_term["surface tension"] < 1e-12
    run.step(1)
    assert np.abs(run.velocities).max() / 1e-3 < 1e-10


@pytest.mark.parametrize(("dimension", "settled"), [(2, 0.75), (3, 0.80)])
def test_a_flat_surface_of_a_lattice_has_more_energy_than_it_settles_to(dimension, settled):
    """σ over the share that is left of it once particles have settled, for each of the two surfaces of a slab."""
    across = (8.0,) * (dimension - 1)
    cells = pc.block((0.0,) * dimension, (*across, 10.0), 1.0)
    water = pc.Fluid(cells, 1.0, density=1.0, viscosity=0.0, surface_tension=2.0)
    endless = pc.Periodic((*(0.0,) * (dimension - 1), -math.inf), (*across, math.inf))
    energy = pc.Simulation(pc.Scene(water, endless), dt=1e-6, precision="f64", fluids=STILL).energy()
    assert energy.by_term["surface tension"] == pytest.approx(2.0 * 2.0 / settled * 8.0 ** (dimension - 1), rel=1e-12)


def test_the_sum_of_energies_is_kept_the_better_the_shorter_the_step():
    """A leapfrog is of second order: half the step, a quarter of the error; half of it, not to ask for too much."""
    drifts = []
    for dt in (0.04, 0.02, 0.01):
        run = pc.Simulation(scenes("a drop", heap(2)), dt=dt, precision="f64", fluids=STILL)
        start, most = run.energy(), 0.0
        for _ in range(40):
            run.run(0.08)
            most = max(most, abs(run.energy().balance - start.balance))
        drifts.append(most / start.by_term["surface tension"])
    assert drifts[0] < 0.02
    assert drifts[2] < 0.5 * drifts[1] < 0.25 * drifts[0]


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_the_time_step_scales_as_the_period_of_a_drop(scale):
    """√(ρL³/σ) for all lengths L times `scale`, with the speed of sound √(σ/ρL): no other length is hidden in it."""
    limits = []
    for length in (1.0, scale):
        sound = 3.0 / np.sqrt(length)
        drop = pc.Fluid(length * heap(2), length, surface_tension=1000.0, viscosity=0.0)
        method = pc.WeaklyCompressible(sound)
        limits.append(pc.stability_limit(pc.Scene(drop), pc.VelocityVerlet(), fluids=method))
    # In single precision, of which the forces make nothing in the first moment but the height of the surface.
    assert limits[1] == pytest.approx(limits[0] * scale**1.5, rel=1e-6)


def test_the_time_step_knows_it():
    """√(ρh³/2πσ) for ripples."""
    water = pc.Fluid(heap(2), 1.0, density=2.0, surface_tension=3.0)
    plan = pc.Simulation(pc.Scene(water), dt=1e-3, fluids=pc.WeaklyCompressible(0.1)).plan
    assert plan.limit_term == "surface tension"
    assert plan.dt_limit <= math.sqrt(2.0 * 1.5**3 / (2.0 * math.pi * 3.0)) * (1.0 + 1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_crowded_particles_are_stable_within_the_limit(dimension):
    """At 0.95 spacings from each other, with a local density of 1.2: the limit is between half of 2/√λ and 2/√λ.

    λ is the largest eigenvalue of the stiffness per mass, from below by 40 power iterations with central differences
    over 1e-5. Sound is too slow to count.
    """
    cells = 0.95 * pc.ball((0.0,) * dimension, 5.0 if dimension == 2 else 3.5, 1.0)
    slow = still(1e-3)

    def scene(positions: Array) -> pc.Scene:
        return pc.Scene(pc.Fluid(positions, 1.0, density=1.0, viscosity=0.0, surface_tension=1.0))

    def accelerations(positions: Array) -> Array:
        run = pc.Simulation(scene(positions), dt=1e-6, precision="f64", fluids=slow)
        run.step(1)
        return np.asarray(run.velocities) / 1e-6

    direction, square = np.random.default_rng(5).standard_normal(cells.shape), 0.0
    for _ in range(40):
        direction /= np.linalg.norm(direction)
        shift = 1e-5 * direction
        direction = (accelerations(cells - shift) - accelerations(cells + shift)) / 2e-5
        square = float(np.linalg.norm(direction))
    limit = pc.stability_limit(scene(cells), pc.VelocityVerlet(), fluids=slow)
    assert 0.5 * 2.0 / math.sqrt(square) < limit <= 2.0 / math.sqrt(square)


@pytest.mark.filterwarnings("ignore::physcore.MachWarning")
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_time_step_knows_how_tension_and_friction_accelerate_together(dimension):
    """√(h/|a|) for the largest |a|, which is read from one short step.

    At 1e3 m/s the way of a step is 1e-5 of a spacing, and rounding 1e-6 of what a velocity changes by. Friction is
    so weak that tension makes a difference of 2 % and more.
    """
    cells, dt = heap(dimension), 1e-8
    velocities = 1e3 * np.random.default_rng(3).standard_normal(cells.shape)
    drop = pc.Fluid(cells, 1.0, density=2.0, viscosity=0.01, velocities=velocities, surface_tension=1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pc.SceneWarning)  # of too slow a sound, as is meant
        run = pc.Simulation(pc.Scene(drop), dt=dt, precision="f64", fluids=still(0.1))
    plan = run.plan
    assert plan.limit_term == "acceleration"
    run.step(1)
    largest = np.linalg.norm(run.velocities - velocities, axis=1).max() / dt
    assert plan.dt_limit == pytest.approx(math.sqrt(1.5 / largest), rel=1e-4)


def test_sound_follows_from_it():
    water = pc.Fluid(heap(3), 1.0, density=2.0, surface_tension=3.0)
    assert "sound at 7.7460 m/s" in str(pc.Simulation(pc.Scene(water)).plan)  # √(40 · 3/2)


@pytest.mark.long
def test_two_drops_that_touch_become_one_round_one():
    """The mean of x² over that of y² is 1 for a circle, 5 for two that touch: R²/4 + R² over R²/4."""
    one = pc.ball((0.0, 0.0), 8.0, 1.0)
    cells = np.concatenate([one - np.array([8.0, 0.0]), one + np.array([8.0, 0.0])])
    water = pc.Fluid(cells, 1.0, density=1.0, surface_tension=1.0, viscosity=0.1)
    run = pc.Simulation(pc.Scene(water))
    radius = math.sqrt(len(cells) / math.pi)
    period = 2.0 * math.pi / math.sqrt(6.0 / radius**3)
    run.run(6.0 * period)
    places = run.positions - run.positions.mean(axis=0)
    square = (places**2).mean(axis=0)
    assert square[0] / square[1] == pytest.approx(1.0, abs=0.1)
    assert np.linalg.norm(places, axis=1).max() < radius + 1.0


@pytest.mark.parametrize("integrator", [pc.VelocityVerlet(), pc.SemiImplicitEuler(), pc.McLachlan2()], ids=str)
def test_its_energy_is_that_of_the_state_however_that_came_about(integrator, tmp_path):
    """A state that was loaded or set, or reached with an integrator that ends its steps with a drift.

    Over other lists, and relative to another origin, sums are rounded otherwise: some hundred terms each.
    """
    scene = scenes("a drop", heap(2))
    first = pc.Simulation(scene, integrator, 1e-3, precision="f64", fluids=STILL)
    first.step(20)
    afresh = energy("a drop", first.positions)
    first.save(tmp_path / "drop.npz")
    loaded = pc.load(tmp_path / "drop.npz")
    placed = pc.Simulation(scene, integrator, 1e-3, precision="f64", fluids=STILL)
    before = placed.energy()
    placed.set(positions=first.positions)
    after = placed.energy()
    for found in (first.energy(), loaded.energy(), after):
        assert found.by_term["surface tension"] == pytest.approx(afresh, rel=1e4 * EPSILON)
    gain = after.total - before.total
    assert abs(gain) > 1e-4 * before.total
    assert after.work - before.work == pytest.approx(gain, rel=1e-9)


def test_small_drops_in_single_precision():
    """Drops of micrometers, whose kernels have derivatives near the end of f32."""
    spacing = 1e-6
    drop = pc.Fluid(pc.ball((0.0, 0.0, 0.0), 4e-6, spacing), spacing, surface_tension=0.072)
    run = pc.Simulation(pc.Scene(drop), precision="f32", fluids=pc.WeaklyCompressible(200.0))
    run.step(20)
    assert np.isfinite(run.positions).all()
    assert 0.0 < run.energy().by_term["surface tension"] < np.inf
