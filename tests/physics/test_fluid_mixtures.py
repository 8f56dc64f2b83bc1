"""Fluids of different density, and fluids that meet solid bodies."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc

SPACING = 0.05
DOWN = pc.Gravity((0.0, -9.81))
SLOW = pc.WeaklyCompressible(sound_speed=20.0)


def layers(lower: float, upper: float, *, precision: str = "f64") -> pc.Simulation:
    """Two layers of fluid in a box, each 0.4 m deep."""
    bottom = pc.Fluid(pc.block((0.0, 0.0), (0.6, 0.4), SPACING), SPACING, lower, name="lower")
    top = pc.Fluid(pc.block((0.0, 0.4), (0.6, 0.8), SPACING), SPACING, upper, name="upper")
    return pc.Simulation(pc.Scene(bottom, top, pc.Box((0.0, 0.0), (0.6, 2.0)), DOWN), precision=precision)


def test_oil_rests_on_water():
    """The pressure is the weight of both layers, to the 3 % that a tank of one fluid is allowed, and nothing mixes."""
    run = layers(1000.0, 800.0)
    water, oil = run["lower"], run["upper"]
    start = run.energy()
    run.run(0.5)
    water, oil = run["lower"], run["upper"]
    weights = 9.81 * (800.0 * 0.4 + 1000.0 * (0.4 - water.positions[:, 1]))
    assert np.sqrt(((water.pressures - weights) ** 2).mean()) < 0.03 * weights.max()
    assert water.positions[:, 1].max() < 0.4 < oil.positions[:, 1].min()
    assert np.abs(run.velocities).max() < 0.01 * np.sqrt(9.81 * 0.8)
    # Nothing moves, so that what the integrator is off by is nothing beside the energy of compression.
    assert abs(run.energy().balance - start.balance) < 1e-3 * start.internal


def test_two_bodies_of_one_fluid_are_one():
    """Whether a fluid comes in one body or two changes not a bit, as long as the particles keep their order."""
    one = pc.Fluid(pc.block((0.0, 0.0), (0.6, 0.8), SPACING), SPACING)
    whole = pc.Simulation(pc.Scene(one, pc.Box((0.0, 0.0), (0.6, 2.0)), DOWN), precision="f64", dt=1e-4)
    half = len(one) // 2
    parts = [pc.Fluid(one.positions[part], SPACING) for part in (slice(None, half), slice(half, None))]
    split = pc.Simulation(pc.Scene(*parts, pc.Box((0.0, 0.0), (0.6, 2.0)), DOWN), precision="f64", dt=1e-4)
    whole.step(50)
    split.step(50)
    np.testing.assert_array_equal(whole.positions, split.positions)


def test_a_fluid_and_a_net_push_each_other():
    """Without walls and gravity their momentum is conserved to rounding: at most an ulp of the largest for each of the
    N·steps forces, which here is 1e-10 of what passes from one to the other.
    """
    net = pc.rope(25, length=0.96, stiffness=2e3, damping=1.0, mass=2.0, start=(0.0, -0.1), name="net")
    drop = pc.Fluid(pc.block((0.28, 0.0), (0.68, 0.4), SPACING), SPACING, velocities=(0.0, -1.0), name="drop")
    run = pc.Simulation(pc.Scene(net, drop), precision="f64", fluids=SLOW)
    before, start = run.momentum(), run.energy()
    run.run(0.2)
    passed = float(net.mass[0] * run["net"].velocities[:, 1].sum())
    assert passed < -0.1 * abs(before[1])
    np.testing.assert_allclose(run.momentum(), before, atol=1e-10 * abs(before[1]))
    # Nothing comes through: the lowest water is above the lowest part of the net.
    assert run["drop"].positions[:, 1].min() > run["net"].positions[:, 1].min()
    # Verlet's error is of order 2 in the step; a power that nobody meters would leave some hundredths of what moved.
    assert abs(run.energy().balance - start.balance) < 1e-3 * start.kinetic


HANGING = {
    "one": np.array([[0.01, -0.5 * SPACING]]),
    "row": pc.block((-0.2, -SPACING), (0.2, 0.0), SPACING),
    "lump": pc.block((-0.05, -2.0 * SPACING), (0.05, 0.0), SPACING) + np.array([0.013, -0.01]),
}
"""Particles of water beneath y = 0."""


@pytest.mark.parametrize("cells", HANGING.values(), ids=HANGING)
def test_nothing_hangs_from_a_ceiling_of_particles(cells):
    """After 0.35 s all water is out of the ceiling's reach, 0.15 m: twice what a free fall takes, √(0.3/g) = 0.17 s.

    Tension between it and the ceiling would hold it for ever. What it lacks of a free fall is dissipated, and metered;
    Verlet's error is of order 2 in the step.
    """
    ceiling = pc.Particles(pc.block((-1.0, 0.0), (1.0, 0.15), SPACING), fixed=True)
    water = pc.Fluid(cells, SPACING, name="water")
    scene = pc.Scene(ceiling, water, DOWN)
    run = pc.Simulation(scene, threads=1, fluids=pc.WeaklyCompressible(sound_speed=30.0))
    start = run.energy()
    run.run(0.35)
    assert run["water"].positions[:, 1].max() < -0.15
    energy = run.energy()
    assert abs(energy.balance - start.balance) < 1e-3 * energy.kinetic


def test_a_drop_that_leaves_a_net_pulls_it_but_for_the_parting_and_conserves_momentum():
    """It goes at 1 m/s. Tension, from ρ₀ on, would take it all: 50 g are held by a strain of (1/30)², or 0.1 %.

    Momentum is conserved to rounding as above, where particles are let go too.
    """
    net = pc.Particles(pc.block((-0.2, 0.0), (0.2, SPACING), SPACING), mass=2.5, name="net")
    drop = pc.Fluid(pc.block((-0.05, -SPACING), (0.05, 0.0), SPACING), SPACING, velocities=(0.0, -1.0), name="drop")
    method = pc.WeaklyCompressible(sound_speed=30.0, artificial_viscosity=0.0)
    run = pc.Simulation(pc.Scene(net, drop), precision="f64", threads=1, fluids=method)
    before = run.momentum()
    run.run(0.3)
    np.testing.assert_allclose(run.momentum(), before, atol=1e-10 * abs(before[1]))
    assert run["drop"].velocities[:, 1].max() < -0.9


def test_a_light_net_is_stepped_for_the_heaviest_fluid_that_may_push_it():
    """It is pushed as the fluid in its place would be.

    Oil of half the density pushes half as much. Here viscosity binds, sound counts by less than 1 %: a step is twice
    as long. Beside water oil asks for nothing.
    """
    net = pc.Particles(pc.block((2.0, 0.0), (2.4, SPACING), SPACING), mass=1e-3)
    water = pc.Fluid(pc.block((0.0, 0.0), (0.4, 0.4), SPACING), SPACING)
    oil = pc.Fluid(pc.block((1.0, 0.0), (1.4, 0.4), SPACING), SPACING, density=500.0)
    limits = [
        pc.stability_limit(pc.Scene(net, *fluids), pc.VelocityVerlet(), fluids=SLOW)
        for fluids in ([water], [water, oil], [oil])
    ]
    assert limits[1] == pytest.approx(limits[0], rel=1e-6)
    assert limits[2] == pytest.approx(2.0 * limits[0], rel=0.01)


def test_without_obstacles_they_pass_through_each_other():
    net = pc.rope(25, length=0.96, stiffness=2e3, mass=2.0, start=(0.0, -0.1), name="net")
    drop = pc.Fluid(pc.block((0.28, 0.0), (0.68, 0.4), SPACING), SPACING, obstacles=False)
    run = pc.Simulation(pc.Scene(net, drop), precision="f64", dt=1e-4, fluids=SLOW)
    run.step(20)
    np.testing.assert_array_equal(run["net"].velocities[:, 1], 0.0)


def test_obstacles_go_on_across_the_ends_of_a_periodic_domain():
    """A floor of particles pushes alike everywhere: where the domain ends nothing is different, but for rounding."""
    ground = pc.Particles(pc.block((0.0, -0.15), (0.8, 0.0), SPACING), fixed=True)
    water = pc.Fluid(pc.block((0.0, 0.0), (0.8, 0.3), SPACING), SPACING, name="water")
    domain = pc.Periodic((0.0, -np.inf), (0.8, np.inf))
    run = pc.Simulation(pc.Scene(ground, water, domain, DOWN, pc.Floor(-0.15)), precision="f64", dt=1e-4)
    run.step(20)
    rows = run["water"].velocities[:, 1].reshape(6, 16)
    assert np.abs(rows).max() > 1e-3
    np.testing.assert_allclose(rows, np.tile(rows[:, :1], 16), atol=1e-9)


def test_a_fourth_kind_of_fluid_and_other_numerics_are_refused():
    def pools(*fluids: pc.Fluid, **numerics: object) -> None:
        pc.Simulation(pc.Scene(*fluids, pc.Box((0.0, 0.0), (9.0, 2.0)), DOWN), **numerics)

    def pool(place: float, density: float) -> pc.Fluid:
        return pc.Fluid(pc.block((place, 0.0), (place + 0.2, 0.2), SPACING), SPACING, density)

    with pytest.raises(pc.SceneError, match="at most three kinds of fluid"):
        pools(*(pool(float(index), 1000.0 + index) for index in range(4)))
    with pytest.raises(pc.SceneError, match="may differ in density, viscosity and surface tension alone"):
        pools(pool(0.0, 1000.0), pool(1.0, 1000.0), fluids={1: pc.WeaklyCompressible(density_diffusion=0.2)})
