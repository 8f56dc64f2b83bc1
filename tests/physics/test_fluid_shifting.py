"""Shifting: particles go where there is room, by the formula, through no wall, and for a price that is metered."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import EPSILON, Array

SPACING, SOUND, A = 0.05, 10.0, 6.0
DT = 5e-4
FASTEST = SOUND / 10.0
H = 1.5 * SPACING
MOST = FASTEST * DT / 2.0
"""The longest shift of a step."""


def jumble(lower: tuple[float, ...], upper: tuple[float, ...], size: float = 0.2, seed: int = 5) -> Array:
    """A lattice whose particles are off their sites by up to `size` spacings."""
    cells = pc.block(lower, upper, SPACING)
    return cells + size * SPACING * np.random.default_rng(seed).uniform(-1.0, 1.0, cells.shape)


def swirl(cells: Array) -> Array:
    """Two vortices of 0.5 m/s, which part and approach particles."""
    flow = np.zeros_like(cells)
    flow[:, :2] = 0.5 * np.sin(2.0 * np.pi * cells[:, 1::-1])
    return flow


def water(cells: Array, **changes: object) -> pc.Fluid:
    return pc.Fluid(cells, SPACING, **{"velocities": swirl(cells), "name": "water", **changes})


def method(shifting: float = A, sound_speed: float = SOUND) -> pc.WeaklyCompressible:
    return pc.WeaklyCompressible(sound_speed, shifting=shifting)


def run(
    cells: Array, *items: object, dt: float = DT, shifting: float = A, sound_speed: float = SOUND, **changes: object
) -> pc.Simulation:
    scene = pc.Scene(water(cells, **changes), *items)
    return pc.Simulation(scene, dt=dt, precision="f64", threads=1, fluids=method(shifting, sound_speed))


def shifts(cells: Array, *items: object, **changes: object) -> Array:
    """Where a first step moves particles beside their velocity: what it does without shifting is the same."""
    moved = []
    for coefficient in (A, 0.0):
        one = run(cells, *items, shifting=coefficient, **changes)
        one.step()
        moved.append(one.positions)
    return moved[0] - moved[1]


def lattice_moment(dimension: int) -> float:
    """−Σ Δ^D F x² of the kernel's own slope over a lattice, by which the engine divides it."""
    reach = np.stack(np.meshgrid(*[SPACING * np.arange(-3, 4)] * dimension), axis=-1).reshape(-1, dimension)
    distance = np.linalg.norm(reach, axis=1)
    inside = distance > 0.0
    return float(-(SPACING**dimension * slope(distance[inside], dimension) * reach[inside, 0] ** 2).sum())


def height(dimension: int) -> float:
    return {2: 7.0 / (4.0 * np.pi * H**2), 3: 21.0 / (16.0 * np.pi * H**3)}[dimension]


def slope(distance: Array, dimension: int) -> Array:
    """W′/r of Wendland's kernel."""
    return -5.0 * height(dimension) / H**2 * np.clip(1.0 - distance / (2.0 * H), 0.0, None) ** 3


def value(distance: Array, dimension: int) -> Array:
    return height(dimension) * np.clip(1.0 - distance / (2.0 * H), 0.0, None) ** 4 * (1.0 + 2.0 * distance / H)


def by_the_formula(places: Array, velocities: Array) -> tuple[Array, Array]:
    """δx of all particles, and whether they are at the surface, all pairs being summed."""
    dimension = places.shape[1]
    apart, parting = (values[:, None] - values[None] for values in (places, velocities))
    distance = np.linalg.norm(apart, axis=2)
    weight = np.where(distance > 0.0, SPACING**dimension * slope(distance, dimension), 0.0) / lattice_moment(dimension)
    near = value(distance, dimension) / value(np.array(SPACING), dimension)
    gradient = ((weight * (1.0 + 0.2 * near**4))[:, :, None] * apart).sum(axis=1)
    surface = -(weight * distance**2).sum(axis=1) < 0.85 * dimension
    strain = np.sqrt(-(weight * (apart * parting).sum(axis=2) ** 2 / (distance**2 + 0.01 * H**2)).sum(axis=1))
    diffusion = np.minimum(A * H * np.minimum(8.0 * H * strain, FASTEST) * DT, H**2 / 2.0)
    shift = -diffusion[:, None] * gradient
    length = np.maximum(np.linalg.norm(shift, axis=1, keepdims=True), 1e-300)
    return np.where(surface[:, None], 0.0, shift * np.minimum(1.0, MOST / length)), surface


@pytest.mark.parametrize("sides", [(1.0, 0.6), (0.5, 0.4, 0.4)], ids=["2D", "3D"])
def test_a_step_shifts_by_the_formula_and_not_at_the_surface(sides):
    """Crowding is that in the middle of the first drift, of particles that start with the density at rest. The
    difference of two positions of 1 m is rounded to 2 ε, and a sum over a hundred neighbors to some ε of the shift.
    """
    cells = jumble((0.0,) * len(sides), sides)
    without = run(cells, shifting=0.0)
    without.step()
    way = without.positions - cells
    expected, surface = by_the_formula(cells + way / 2.0, way / DT)
    assert 0.1 < surface.mean() < 0.9
    found = shifts(cells)
    # Velocities are found here from ways, which are rounded to ε of places: to ε/dt.
    np.testing.assert_allclose(found, expected, atol=1e-9 * MOST)
    assert (found[surface] == 0.0).all()
    assert np.abs(expected).max() > 0.05 * MOST


def test_a_perfect_lattice_that_moves_is_not_shifted():
    """A lattice in a periodic box has no gradient but the rounding of 36 neighbors, wherever it goes as a whole."""
    cells = pc.block((0.0, 0.0), (1.0, 1.0), SPACING)
    one = run(cells, pc.Periodic((0.0, 0.0), (1.0, 1.0)), velocities=(0.7, -0.4))
    one.step(200)
    drifted = cells + 200 * DT * np.array([0.7, -0.4])
    apart = one.positions - drifted
    np.testing.assert_allclose(apart - np.rint(apart), 0.0, atol=200 * 36 * EPSILON)


def test_who_moves_along_sees_the_same_shifts():
    """In a box that is periodic, a wind changes no shift but by the rounding of places, to some ε of 1 m."""
    cells = jumble((0.0, 0.0), (1.0, 1.0))
    domain = pc.Periodic((0.0, 0.0), (1.0, 1.0))
    windy = shifts(cells, domain, velocities=swirl(cells) + np.array([0.3, 0.2]))
    np.testing.assert_allclose(windy, shifts(cells, domain), atol=1e-9 * MOST)


def test_who_turns_along_sees_no_shifts():
    """An uneven disc that turns as a whole: over half a step a turn by Ω parts particles at the rate Ω² dt/2 alone, so
    that ε² is at most D times the square of that, and a gradient is at most 1/h.
    """
    cells = pc.ball((0.0, 0.0), 0.5, SPACING)
    cells = cells + 0.2 * SPACING * np.random.default_rng(2).uniform(-1.0, 1.0, cells.shape)
    turning = cells[:, ::-1] * [-1.0, 1.0]
    found = shifts(cells, velocities=turning, viscosity=0.0)
    assert 0.0 < np.abs(found).max() < A * 8.0 * H * np.sqrt(2.2) * DT / 2.0 * DT
    assert np.abs(shifts(cells)).max() > 100.0 * np.abs(found).max()


def test_crowds_are_spread():
    """In vortices particles stand more evenly after a while than without shifting."""
    cells = jumble((0.0, 0.0), (1.0, 1.0), 0.24)
    closest = {}
    for coefficient in (0.0, A):
        one = run(cells, pc.Periodic((0.0, 0.0), (1.0, 1.0)), shifting=coefficient)
        one.step(1000)
        apart = one.positions[:, None] - one.positions[None]
        apart -= np.rint(apart)
        closest[coefficient] = (np.linalg.norm(apart, axis=2) + np.eye(len(cells))).min(axis=1) / SPACING
    assert closest[A].min() > 0.8 > closest[0.0].min()
    assert closest[A].std() < 0.5 * closest[0.0].std()


def test_momentum_and_the_energies_of_motion_and_compression_are_kept():
    """Velocities are not touched: momentum changes by the rounding of forces, as without shifting."""
    cells = jumble((0.0, 0.0), (1.0, 1.0), 0.1)
    one = run(cells, pc.Periodic((0.0, 0.0), (1.0, 1.0)), velocities=swirl(cells) + 0.1)
    before, start = one.momentum(), one.energy()
    one.step(1000)
    force = SOUND**2 * 1000.0 * 0.01 * SPACING
    mass = 1000.0 * SPACING**2
    motion = (mass * np.abs(one.velocities)).sum()
    assert np.abs(one.momentum() - before).max() <= 1000 * EPSILON * (36 * len(cells) * force * DT + motion)
    end = one.energy()
    assert end.work == 0.0
    assert abs(end.balance - start.balance) < 1e-3 * start.kinetic


def test_a_shift_turns_and_mirrors_with_the_fluid():
    """By a right angle and in a mirror, to the rounding of sums."""
    cells = jumble((-0.5, -0.4), (0.5, 0.4))
    plain = shifts(cells)
    for turn in (np.array([[0.0, -1.0], [1.0, 0.0]]), np.array([[-1.0, 0.0], [0.0, 1.0]])):
        turned = shifts(cells @ turn.T, velocities=swirl(cells) @ turn.T)
        np.testing.assert_allclose(turned, plain @ turn.T, atol=1e-9 * MOST)


def test_a_wall_is_a_mirror():
    """A box that is filled, and a periodic one with the three images of that filling beside it: the same shifts.

    The last of them is rounded in another order, and moved by forces that are so.
    """
    cells = jumble((0.0, 0.0), (0.5, 0.5))
    signs = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]])[:, None]
    images, flow = (signs * cells).reshape(-1, 2), (signs * swirl(cells)).reshape(-1, 2)
    whole = shifts(images, pc.Periodic((-0.5, -0.5), (0.5, 0.5)), velocities=flow)[: len(cells)]
    assert np.linalg.norm(whole, axis=1).max() > 0.05 * MOST
    np.testing.assert_allclose(shifts(cells, pc.Box((0.0, 0.0), (0.5, 0.5))), whole, atol=1e-9 * MOST)


def test_nothing_is_shifted_through_a_wall_or_an_obstacle():
    """In a drum with a post in it, which vortices beat on, from a start that is as uneven as it can be."""
    post = pc.Particles(pc.ball((0.0, 0.0), 0.15, SPACING), fixed=True, mass=1.0)
    cells = pc.ball((0.0, 0.0), 0.5, SPACING)
    cells = cells[np.linalg.norm(cells, axis=1) > 0.2]
    cells = cells + 0.24 * SPACING * np.random.default_rng(1).uniform(-1.0, 1.0, cells.shape)
    cells *= np.minimum(1.0, 0.499 / np.linalg.norm(cells, axis=1))[:, None]
    for precision in ("f32", "f64"):
        scene = pc.Scene(water(cells), post, pc.Sphere((0.0, 0.0), 0.5, inside=True))
        one = pc.Simulation(scene, precision=precision, dt=DT, fluids=method())
        for _ in range(20):
            one.step(50)
            radius = np.linalg.norm(one["water"].positions, axis=1)
            assert radius.max() <= 0.5 + 4.0 * np.finfo(precision.replace("f", "float")).eps
            assert radius.min() > 0.15


def falling(dt: float, *fields: object) -> pc.Simulation:
    """An uneven column that falls over in a box."""
    cells = jumble((0.01, 0.01), (0.5, 0.8))
    return run(cells, pc.Box((0.0, 0.0), (1.5, 1.5)), *fields, dt=dt, sound_speed=40.0, velocities=0.0)


def test_what_a_shift_lifts_is_metered_and_the_budget_closes():
    """A shorter step leaves less of a hole, and shifts no less: the work is much more than what is missing."""
    holes = []
    for dt in (5e-4, 1.25e-4):
        one = falling(dt, pc.Gravity((0.0, -9.81)))
        start = one.energy()
        one.run(0.3)
        end = one.energy()
        holes.append(abs(end.balance - start.balance))
        assert end.work != 0.0
        assert end.dissipated > 0.0
    assert holes[1] < 0.5 * holes[0]
    assert holes[1] < 0.02 * abs(end.work)


def test_a_field_of_the_user_s_is_metered_as_gravity_is():
    """The same field, as gravity and as a function: but for rounding, the same work."""
    mass = 1000.0 * SPACING**2

    def weight(time: float, positions: Array, velocities: Array) -> Array:
        return np.tile([0.0, -9.81 * mass], (len(positions), 1))

    field = pc.CustomForce(weight, potential=lambda positions: float(9.81 * mass * positions[:, 1].sum()))
    cells = jumble((0.0, 0.0), (1.0, 1.0))
    domain = pc.Periodic((0.0, 0.0), (1.0, 1.0))
    works = []
    for force in (pc.Gravity((0.0, -9.81)), field):
        one = run(cells, domain, force)
        one.step(10)
        works.append(one.energy().work)
    assert works[0] != 0.0
    # Of 400 particles of a few J each, differences are left that are rounded once per step.
    assert works[1] == pytest.approx(works[0], abs=10 * 400 * EPSILON * 9.81 * mass * 10.0)


def test_forces_between_pairs_and_other_numerics_are_refused():
    cells = pc.block((0.0, 0.0), (0.5, 0.5), SPACING)
    wet = water(cells)
    with pytest.raises(pc.SceneError, match=r"forces\[0\]\.on: expected no fluid that is shifted"):
        pc.Simulation(pc.Scene(wet, pc.LennardJones(1.0, SPACING, on=wet)), fluids=method())
    scene = pc.Scene(wet, water(cells + np.array([1.0, 0.0]), name="other"))
    with pytest.raises(pc.SceneError, match=r"bodies\['other'\].*numerics as those of bodies\['water'\]"):
        pc.Simulation(scene, fluids={"water": method(), "other": method(0.0)})
    assert "shifted by A = 6" in str(run(cells).plan)
