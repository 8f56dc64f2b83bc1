"""Walls hold a fluid in and let it go: drops leave a ceiling, and a wall that moves does the work that is seen."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc

SPACING = 0.05


@pytest.mark.parametrize("speed", [2.0, 5.0])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_drop_that_hits_a_ceiling_falls_off_again(dimension, speed):
    """Nothing holds it: all of it is out of the reach of the ceiling at some time, 2h = 0.15 m.

    It is at the ceiling within 0.1 s, spreads there, and is let go from its rim on; those 15 cm take √(2 · 0.15/g) =
    0.17 s of fall. Twice that in all, and as long again for what has to wait, is 0.7 s: later it may have bounced.
    """
    center = (*(0.5,) * (dimension - 1), 0.7)
    up = (*(0.0,) * (dimension - 1), 1.0)
    drop = pc.Fluid(pc.ball(center, 0.15, SPACING), SPACING, velocities=speed * np.array(up), name="drop")
    box = pc.Box((0.0,) * dimension, (1.0,) * dimension)
    scene = pc.Scene(drop, box, pc.Gravity(-9.81 * np.array(up)))
    run = pc.Simulation(scene, threads=1, fluids=pc.WeaklyCompressible(sound_speed=100.0))
    highest = run.record(0.7, fps=20.0).positions[:, :, -1].max(axis=1)
    assert highest[highest.argmax() :].min() < 0.85


@pytest.mark.parametrize("low", [0.5, -2.0])
def test_the_speed_of_sound_is_ten_times_that_of_a_fall_into_the_wall_below(low):
    """From the highest particle to the bottom of a bowl, wherever that is; the limit on dt says how fast sound is.

    The lowest one is near the bottom, so that the jets of its impact are slower.
    """
    cells = pc.block((-5.5 * SPACING, 0.0), (5.5 * SPACING, 0.5), SPACING) + np.array([1.0, low + 0.1])
    bowl, down = pc.Sphere((1.0, low + 1.0), 1.0, inside=True), pc.Gravity((0.0, -9.81))
    scene = pc.Scene(pc.Fluid(cells, SPACING), bowl, down)
    limits = [
        pc.stability_limit(scene, pc.VelocityVerlet(), fluids=pc.WeaklyCompressible(sound_speed=sound))
        for sound in ("auto", 10.0 * np.sqrt(2.0 * 9.81 * (cells[:, 1].max() - low)))
    ]
    assert limits[0] == pytest.approx(limits[1], rel=1e-9)


def test_a_wall_in_which_nobody_is_seen_takes_no_memory():
    """A layer within the support 2h = 0.15 m of its floor, and out of that of its image: less than a byte for each."""
    layer = np.stack([SPACING * np.arange(1000.0), np.zeros(1000)], axis=1)
    water, method = pc.Fluid(layer, SPACING), pc.WeaklyCompressible(sound_speed=1.0)
    scenes = [pc.Scene(water, pc.Floor(-depth)) for depth in (0.125, 5.0)]
    near, far = (pc.Simulation(scene, dt=1e-6, fluids=method).plan.memory for scene in scenes)
    assert near - far < 1000


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_wall_acts_on_a_block_from_afar_as_on_one_that_begins_beside_it(dimension):
    """The block moves as a whole, so nothing but its distance says that a wall comes within reach.

    Its lowest row begins 0.125 m above the floor, and would be there after 62 ms; its own image acts on it from 0.06 m
    on, half of the support 2h. From afar it moves for 900 steps more, each of which rounds a coordinate of up to 2 m by
    2e-16 m at most: 2e-13 m in all, which compression enlarges by far less than the 1e5 that are allowed. Without
    images it would be 2 mm lower after 40 ms.
    """
    speed, dt, steps = 2.0, 1e-3, 900
    toward = np.array((*(0.0,) * (dimension - 1), -speed))
    cells = pc.block((0.0,) * dimension, (0.3,) * dimension, SPACING)
    floor = pc.Plane((0.0,) * dimension, tuple(-toward / speed))
    lowest = []
    for more in (0, steps):
        height = 0.1 + speed * dt * more
        block = pc.Fluid(cells - height * toward / speed, SPACING, velocities=toward)
        method = pc.WeaklyCompressible(sound_speed=50.0)
        run = pc.Simulation(pc.Scene(block, floor), dt=dt, threads=1, precision="f64", fluids=method)
        run.step(more)
        lowest.append([])
        for _ in range(60):
            run.step(1)
            lowest[-1].append(run.positions[:, -1].min())
    np.testing.assert_allclose(lowest[1], lowest[0], rtol=0.0, atol=2e-8)


def test_a_drop_slides_down_a_wall_as_fast_as_it_falls():
    """A wall without friction does not hold it: g t²/2 for its center, to the 1 % that compression may mean."""
    cells = pc.block((0.0, 1.0), (0.15, 1.15), SPACING)
    drop = pc.Fluid(cells, SPACING, velocities=(-1.0, 0.0))
    scene = pc.Scene(drop, pc.Plane((0.0, 0.0), (1.0, 0.0)), pc.Gravity((0.0, -9.81)))
    run = pc.Simulation(scene, threads=1, fluids=pc.WeaklyCompressible(sound_speed=50.0))
    run.run(0.4)
    fallen = (cells - run.positions)[:, 1].mean()
    assert fallen == pytest.approx(9.81 * run.time**2 / 2.0, rel=0.01)


@pytest.mark.parametrize("obstacle", [False, True])
@pytest.mark.parametrize("dimension", [2, 3])
def test_nothing_does_work_on_water_in_a_box_that_stands_still(dimension, obstacle):
    """Neither its walls nor a solid at rest: what their pressure takes or gives is dissipated, and the budget closes.

    Without that the budget would be off by it: at least ten times the rest, 1 % of what settling releases.
    """
    size, across = 0.4, (0.0,) * (dimension - 1)
    water = pc.Fluid(pc.block((0.0,) * dimension, (size,) * dimension, SPACING), SPACING)
    solid = pc.Particles(pc.block((0.15,) * dimension, (0.25,) * dimension, SPACING), fixed=True)
    inside = (np.abs(water.positions - 0.2) < 0.05 + SPACING / 2).all(axis=1)
    water = pc.Fluid(water.positions[~inside], SPACING) if obstacle else water
    box = pc.Box((0.0,) * dimension, (size,) * (dimension - 1) + (1.0,))
    items = (water, solid) if obstacle else (water,)
    run = pc.Simulation(pc.Scene(*items, box, pc.Gravity((*across, -9.81))), threads=1, precision="f64")
    before = run.energy()
    run.run(0.5)
    after = run.energy()
    assert after.work == 0.0
    taken = abs(after.dissipated_by["contacts"])
    assert taken > 0.0
    assert abs(after.balance - before.balance) < 0.1 * taken


def piston(speed: float) -> pc.Particles:
    """Four layers of fixed particles left of x = 0, which move to the right."""
    cells = pc.block((-4 * SPACING, 0.0), (0.0, 1.0), SPACING)
    return pc.Particles(cells, velocities=(speed, 0.0), fixed=True, name="piston")


def test_a_piston_lifts_the_water_that_it_displaces_and_its_work_is_all_there():
    """Pushed slowly, half a meter of water rises by what the piston takes of its tank, and nothing gets behind it.

    The work is that of lifting it. What sloshes and is compressed is on the balance as well, to the 1e-3 of it that a
    leapfrog may err by ((ω dt)²/8 of the energy in sound, a hundredth of the rest).
    """
    length, depth, speed = 1.5, 0.5, 0.2
    water = pc.Fluid(pc.block((0.0, 0.0), (length, depth), SPACING), SPACING, name="water")
    box = pc.Box((-1.0, 0.0), (length, 2.0))
    run = pc.Simulation(pc.Scene(water, piston(speed), box, pc.Gravity((0.0, -9.81))), threads=1)
    before = run.energy()
    run.run(2.0)
    after = run.energy()
    x = run["water"].positions
    face = run["piston"].positions[:, 0].max()
    assert face == pytest.approx(speed * 2.0 - SPACING / 2.0)
    assert x[:, 0].min() > face
    risen = depth * length / (length - 2.0 * speed)
    lifting = 0.5 * 1000.0 * 9.81 * depth * length * (risen - depth)
    assert after.potential - before.potential == pytest.approx(lifting, rel=0.05)
    assert after.work > after.potential - before.potential
    assert abs(after.balance - before.balance) < 1e-3 * after.work
