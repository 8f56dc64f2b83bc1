"""Lyapunov exponents of the motion of bodies; those of flows are in tests/physics/test_tracers.py."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc

G = 9.81
DOWN = pc.Gravity((0.0, -G))


def upright(links: int) -> pc.Scene:
    """A pendulum of rods of one meter and one kilogram each that stands on its end."""
    nodes = [[0.0, float(at)] for at in range(links + 1)]
    rods = [[at, at + 1] for at in range(links)]
    return pc.Scene(pc.SpringNetwork(nodes, rods, math.inf, fixed=[0]), DOWN)


def rate(unstable: float, dt: float) -> float:
    """The rate at which Verlet's method leaves an equilibrium at which a motion grows with `unstable` [1/s]:
    cosh(λ dt) = 1 + (ω dt)²/2.
    """
    return 2.0 / dt * math.asinh(0.5 * unstable * dt)


def test_a_rod_that_stands_falls_at_the_rate_of_its_equation():
    """±√(g/l), of Verlet's method; the offsets of 1e-7 make errors of 1e-7 of a growth."""
    found = pc.lyapunov(upright(1), 4.0, transient=4.0, exponents=2, dt=0.01)
    expected = rate(math.sqrt(G), 0.01)
    np.testing.assert_allclose(found.exponents, [expected, -expected], rtol=1e-6)
    assert found.directions == 2
    assert found.duration == pytest.approx(4.0)
    np.testing.assert_allclose(found.each[0], found.exponents)


def test_two_rods_that_stand_have_the_four_rates_of_their_matrix():
    """ω² = (2 ± √2) g/l; what other directions are left after the transient is e^(−3.4 · 4) = 1e-6."""
    found = pc.lyapunov(upright(2), 4.0, transient=4.0, exponents=4, dt=0.01)
    fast, slow = (rate(math.sqrt((2.0 + sign * math.sqrt(2.0)) * G), 0.01) for sign in (1.0, -1.0))
    np.testing.assert_allclose(found.exponents, [fast, slow, -slow, -fast], rtol=1e-5)
    assert found.sum == pytest.approx(0.0, abs=1e-5)
    assert found.directions == 4


def test_a_particle_on_a_hill_leaves_it_at_the_rate_of_its_force():
    """λ = √(k/m) in each direction, by any method; RungeKutta4's error is (λ dt)⁴/120 of it."""
    scene = pc.Scene(pc.Particles([[0.0, 0.0]], mass=2.0), pc.CentralForce((0.0, 0.0), -8.0, exponent=1.0))
    found = pc.lyapunov(scene, 3.0, transient=6.0, exponents=2, dt=0.02, integrator=pc.RungeKutta4())
    np.testing.assert_allclose(found.exponents, [2.0, 2.0], rtol=1e-5)


@pytest.mark.parametrize("integrator", [pc.VelocityVerlet(), pc.DormandPrince5(), pc.BDF2()])
def test_drag_takes_volume_from_phase_space_at_its_rate(integrator):
    """Σ λ = −D γ/m, whatever the springs do: of methods of order 2 to (ω dt)² = 1e-3 of it, with ω = 7/s."""
    bob = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], 50.0, mass=1.0, fixed=[0])
    scene = pc.Scene(bob, pc.Gravity((0.0, -1.0)), pc.Drag(linear=0.5))
    found = pc.lyapunov(scene, 4.0, interval=0.5, exponents=4, dt=0.005, integrator=integrator)
    assert found.sum == pytest.approx(-1.0, rel=5e-3)


def test_regular_motion_has_an_exponent_that_falls_to_zero():
    """Orbits of other periods part in proportion to time, so that λ is about log(t)/t."""
    planet = pc.Particles([[1.0, 0.0]], velocities=[[0.0, 1.2]])
    scene = pc.Scene(planet, pc.CentralForce((0.0, 0.0), 1.0, exponent=-2.0))
    for duration in (100.0, 400.0):
        found = pc.lyapunov(scene, duration, dt=0.02, integrator=pc.BlanesMoan4())
        assert 0.0 < found.exponents[0] < 2.0 * math.log(duration) / duration


def test_chaos_in_the_potential_of_henon_and_heiles():
    """Beside the equations of motion with their linearization, integrated in NumPy. Both follow the same orbit, for
    its twelve Lyapunov times, to 1e-9 · e¹²; their norms differ by a factor of two at most, log(2)/100 of the rate.

    Source of the potential: M. Hénon, C. Heiles, Astron. J. 69, 73 (1964).
    """

    def field(time: float, at: np.ndarray, velocities: np.ndarray) -> np.ndarray:
        x, y = at.T
        return np.stack([-x - 2.0 * x * y, -y - x * x + y * y], axis=1)

    energy, height, before, duration = 0.15, -0.1, 20.0, 100.0
    speed = math.sqrt(2.0 * (energy - 0.5 * height**2 + height**3 / 3.0))
    scene = pc.Scene(pc.Particles([[0.0, height]], velocities=[[speed, 0.0]]), pc.CustomForce(field))
    found = pc.lyapunov(scene, duration, before, interval=0.5, dt=0.05, integrator=pc.BlanesMoan6())
    expected = henon_heiles(np.array([0.0, height, speed, 0.0]), before, duration, 0.02)
    assert expected > 0.1
    assert found.exponents[0] == pytest.approx(expected, abs=math.log(2.0) / duration)


def henon_heiles(state: np.ndarray, before: float, duration: float, dt: float) -> float:
    """The rate of growth of a tangent vector, by the Runge–Kutta method of order 4."""

    def slope(z: np.ndarray) -> np.ndarray:
        x, y, u, v, a, b, c, d = z
        forces = -x - 2.0 * x * y, -y - x * x + y * y
        return np.array([u, v, *forces, c, d, -a - 2.0 * (x * b + y * a), -b - 2.0 * x * a + 2.0 * y * b])

    z = np.concatenate([state, [1.0, 0.0, 0.0, 0.0]])
    growth = 0.0
    for step in range(round((before + duration) / dt)):
        one = slope(z)
        two = slope(z + 0.5 * dt * one)
        three = slope(z + 0.5 * dt * two)
        z = z + dt / 6.0 * (one + 2.0 * two + 2.0 * three + slope(z + dt * three))
        length = float(np.linalg.norm(z[4:]))
        z[4:] /= length
        growth += math.log(length) * (step >= round(before / dt))
    return growth / duration


def test_exponents_of_a_double_pendulum_come_in_pairs():
    """Its flow is symplectic: λ₁ = −λ₄ and λ₂ = −λ₃, and along the motion and across its energy there is no growth.
    Volumes of positions and velocities are those of phase space times a function of the state, within e² of each other.
    """
    pendulum = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], [[0, 1], [1, 2]], math.inf, fixed=[0])
    found = pc.lyapunov(pc.Scene(pendulum, DOWN), 30.0, transient=5.0, exponents=4, dt=0.004)
    assert found.exponents[0] > 0.5
    assert found.sum == pytest.approx(0.0, abs=2.0 / 30.0)
    assert found.exponents[0] + found.exponents[3] == pytest.approx(0.0, abs=4.0 * found.errors[0])
    np.testing.assert_allclose(found.exponents[1:3], 0.0, atol=0.25)


def test_a_loop_of_rods_has_the_directions_that_it_can_move_in():
    """A square that hangs from a corner, with its diagonals: a pendulum, of which the second one forbids nothing."""
    corners = [[0.0, 0.0], [1.0, 0.0], [1.0, -1.0], [0.0, -1.0]]
    pairs = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [1, 3]]
    scene = pc.Scene(pc.SpringNetwork(corners, pairs, math.inf, fixed=[0]), DOWN)
    found = pc.lyapunov(scene, 2.0, exponents=2, dt=0.01)
    assert found.directions == 2
    with pytest.raises(pc.SceneError, match=r"lyapunov.exponents: must be at most 2 in this scene, got 3"):
        pc.lyapunov(scene, 2.0, exponents=3, dt=0.01)


def test_steps_that_follow_the_motion_are_made_equal():
    """Neighbors in other steps would part by the difference of their errors."""
    pendulum = pc.SpringNetwork([[0.0, 0.0], [0.6, -0.8]], [[0, 1]], math.inf, fixed=[0])
    found = pc.lyapunov(pc.Scene(pendulum, DOWN), 40.0)
    assert 0.0 <= found.exponents[0] < 2.0 * math.log(40.0) / 40.0


def test_three_bodies_are_chaotic():
    """Equal masses at rest, whose encounters part neighbors within a few crossing times."""
    bodies = pc.Particles([[1.0, 3.0], [-2.0, -1.0], [1.0, -1.0]], mass=[3.0, 4.0, 5.0])
    scene = pc.Scene(bodies, pc.Gravitation(constant=1.0, softening=0.3))
    found = pc.lyapunov(scene, 60.0, dt=0.01, integrator=pc.BlanesMoan6())
    assert found.exponents[0] > 3.0 * found.errors[0] > 0.0
    assert found.directions == 12


@pytest.mark.parametrize(
    ("scene", "found"),
    [
        (pc.Scene(pc.Wave(pc.Grid((8,), 0.1), 1.0, edges="absorbing")), "a field with absorbing edges"),
        (pc.Scene(pc.Fluid(pc.block((0.0, 0.0), (0.2, 0.2), 0.1), 0.1)), "a Fluid"),
        (pc.Scene(pc.rope(3, 1.0, 10.0, breaking_strain=0.1)), "springs that can break"),
        (pc.Scene(pc.rope(3, 0.4, 10.0), pc.Periodic((0.0, 0.0), (1.0, 1.0))), "springs in a periodic domain"),
    ],
)
def test_a_state_of_more_than_places_velocities_and_fields_is_refused(scene, found):
    with pytest.raises(pc.SceneError, match=rf"lyapunov.scene: must be Tracers, or a scene .* got {found}"):
        pc.lyapunov(scene, 1.0)


FREE = pc.Scene(pc.Particles([[0.0, 0.0]], [[1.0, 0.3]]))
SPRING = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0))
PLANET = pc.Scene(pc.Particles([[1.0, 0.0]], [[0.0, 1.1]]), pc.CentralForce((0.0, 0.0), 1.0, exponent=-2.0))


@pytest.mark.parametrize("duration", [1.0, 10.0, 100.0])
@pytest.mark.parametrize("scene", [FREE, SPRING, PLANET], ids=["free", "spring", "planet"])
def test_regular_motion_has_an_exponent_that_is_consistent_with_zero(scene, duration):
    """Neighbors of a free particle and of a planet part in proportion to time, those of an oscillator not at all."""
    found = pc.lyapunov(scene, duration)
    assert not found.exponential[0]
    assert abs(found.exponents[0]) <= found.errors[0]
    assert "not told from zero" in repr(found)


def test_growth_is_told_to_be_exponential_from_a_few_foldings_on():
    """On a hill of λ = 2/s neighbors part by e^(λ t). The two means differ by 3/8 λ T, not by log 2."""
    hill = pc.Scene(pc.Particles([[1e-3, 0.0]], [[2e-3, 0.0]]), pc.CentralForce((0.0, 0.0), -4.0, exponent=1.0))
    short, long = (pc.lyapunov(hill, duration) for duration in (0.5, 4.0))
    assert not short.exponential[0]
    assert long.exponential[0]
    assert long.exponents[0] == pytest.approx(2.0, abs=0.3)


def test_an_attractor_is_told_from_regular_motion():
    cloud = pc.Tracers(np.random.default_rng(0).normal(size=(20, 3)) + np.array([0.0, 0.0, 25.0]), pc.Lorenz())
    found = pc.lyapunov(cloud, 20.0, transient=5.0, dt=0.01)
    np.testing.assert_array_equal(found.exponential, [True, False, True])
    assert found.exponents[0] == pytest.approx(0.906, abs=4.0 * found.errors[0])
    assert found.errors[0] < 0.05


def test_the_second_item_of_a_scene_counts():
    """A free particle, of six directions, beside the chaos of dust in Lorenz's flow, 0.906, of three directions."""
    particle = pc.Particles([[0.0, 0.0, 0.0]], [[1.0, 0.0, 0.0]])
    dust = pc.Tracers([[1.0, 1.0, 20.0]], pc.Lorenz())
    found = pc.lyapunov(pc.Scene(particle, dust), 100.0, transient=10.0, dt=0.01)
    assert found.exponents[0] == pytest.approx(0.906, abs=0.1)
    assert found.directions == 9


def test_fields_on_grids_have_the_rates_of_their_modes():
    """u' = −k u + D ∇²u: the uniform mode decays by k, and the first wave of a periodic row by k + D (2 sin(π/n)/h)²
    too. The three largest exponents are these and that of its partner, up to the errors of Runge and Kutta's method.
    """
    k, diffusion, n, h = 0.4, 0.2, 6, 0.5
    row = pc.Grid((n,), h, periodic=True)
    decay = pc.Reaction(("u",), lambda u: (-k * u,))
    scene = pc.Scene(pc.ReactionDiffusion(row, decay, {"u": diffusion}, {"u": 1.0 + 0.1 * np.arange(n)}))
    found = pc.lyapunov(scene, 20.0, transient=20.0, interval=0.5, exponents=3, dt=0.05)
    first = k + diffusion * (2.0 * math.sin(math.pi / n) / h) ** 2
    assert found.exponents == pytest.approx([-k, -first, -first], abs=2e-3)
    assert found.directions == n


def test_solid_cells_have_no_directions():
    grid = pc.Grid((4, 4), 0.25)
    walls = np.zeros((4, 4), dtype=bool)
    walls[1, 1] = True
    pond = pc.Wave(grid, 1.0, lambda x, y: 0.01 * x * y, walls=walls)
    found = pc.lyapunov(pc.Scene(pond), 2.0, dt=0.02)
    assert found.directions == 2 * 15
    assert not found.exponential[0]


def test_wave_functions_count_as_pairs_of_numbers():
    line = pc.Grid((8,), 0.5)
    electron = pc.Schrodinger(line, pc.wave_packet(line, 2.0, 0.5, 0.6))
    found = pc.lyapunov(pc.Scene(electron), 2.0, dt=0.01)
    assert found.directions == 16
    assert found.exponents[0] == pytest.approx(0.0, abs=1e-3)  # unitary: no distance grows
