"""Wind on rigid bodies against closed forms: drag, torque, damping of rotation, and the energy budget."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc

G = 9.81
AIR, NORMAL = 1.2, 1.17
SPEED = 7.0


def wind(*velocity, **options):
    return pc.Wind(velocity, **{"density": AIR, "normal": NORMAL, "tangential": 0.0, **options})


CROSS = [(0.0, 0.0), (0.2, 0.0), (-0.2, 0.0), (0.0, 0.2), (0.0, -0.2)]
"""Centers of squares that touch."""
BARS = [pc.Rectangle(0.6, 0.2), pc.Rectangle(0.2, 0.6)]
SHAPES = {
    "ball": (pc.Ball(0.3), 0.5 * math.pi * 0.09),
    "cuboid": (pc.Cuboid(0.3, 0.4, 0.5), 0.4 * 0.5),
    "capsule along the wind": (pc.Capsule(0.5, 0.2), None),
    "disc": (pc.Disc(0.3), 2.0 / 3.0 * 0.6),
    "rectangle": (pc.Rectangle(0.3, 0.4), 0.4),
    "cross": (pc.Compound([(pc.Rectangle(0.2, 0.2), place, 0.0) for place in CROSS]), 0.6),
    "bars that cross": (pc.Compound([(bar, (0.0, 0.0), 0.0) for bar in BARS]), 0.6),
    "squares that overlap": (pc.Compound([(pc.Rectangle(0.2, 0.2), (0.0, y), 0.0) for y in (0.0, 0.13)]), 0.33),
}
"""Shapes with their areas across the wind along x, weighted by the integral of |q| q n over the surface."""


@pytest.mark.parametrize("name", [name for name, (_, area) in SHAPES.items() if area is not None])
def test_the_first_force_is_that_of_the_surface(name):
    """Half of the law on each face. Over a ball of radius r the mean of |cos|³ gives π r²/2, over a disc 4 r/3.

    The quadrature of a ball of 96 points is off by up to 0.5 %, that of flat faces by rounding. Faces that are partly
    within another part are cut to a sixteenth of a patch, here of 0.15: four cuts of 0.6 are off by up to 3 %.
    """
    shape, area = SHAPES[name]
    flow = (SPEED, 0.0, 0.0)[: shape.dimensions[0]]
    body = pc.RigidBody(shape, np.zeros(len(flow)), mass=1e6)
    simulation = pc.Simulation(pc.Scene(body, wind(*flow)), dt=1.0)
    simulation.step(1)
    expected = np.zeros(len(flow))
    expected[0] = 0.5 * AIR * NORMAL * area * SPEED**2
    tolerance = {"ball": 5e-3, "bars that cross": 0.03, "squares that overlap": 0.03}.get(name, 1e-4)
    assert simulation.momentum() == pytest.approx(expected, rel=tolerance, abs=1e-6 * expected[0])


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.1])
def test_a_thin_plate_feels_the_force_of_a_face(angle):
    """The edges, of 1e-5 of the force, are left out of the expected one."""
    plate = pc.RigidBody(
        pc.Cuboid(1.0, 2e-6, 1.0),
        (0.0, 0.0, 0.0),
        orientation=(math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)),
        mass=1e6,
    )
    simulation = pc.Simulation(pc.Scene(plate, wind(3.0, 4.0, 1.0, tangential=0.2)), dt=1.0)
    simulation.step(1)
    normal = np.array([-math.sin(angle), math.cos(angle), 0.0])
    flow = np.array([3.0, 4.0, 1.0])
    across = normal @ flow
    along = flow - across * normal
    expected = 0.5 * AIR * (NORMAL * abs(across) * across * normal + 0.2 * np.linalg.norm(along) * along)
    assert simulation.momentum() == pytest.approx(expected, rel=1e-4)
    spin = simulation.angular_momentum()
    assert np.abs(spin).max() < 1e-4 * np.linalg.norm(expected)


def test_a_falling_cuboid_reaches_its_terminal_speed():
    """v = v∞ tanh(g t/v∞) with v∞² = 2 m g/(ρ c A)."""
    box = pc.RigidBody(pc.Cuboid(0.4, 0.5, 0.3), (0.0, 0.0, 0.0), mass=2.0)
    run = pc.simulate(pc.Scene(box, wind(0.0, 0.0, 0.0), pc.Gravity((0.0, 0.0, -G))), 6.0, dt=1 / 400, fps=20)
    terminal = math.sqrt(2.0 * 2.0 * G / (AIR * NORMAL * 0.2))
    expected = -terminal * np.tanh(G * run.times / terminal)
    assert run[box].velocities[:, 0, 2] == pytest.approx(expected, abs=1e-4 * terminal)
    assert np.abs(run.energy.drift).max() < 1e-5
    assert run.energy.dissipated_by["drag"][-1] > 0.0


def test_a_pole_bears_the_moment_of_the_wind():
    """The wind presses on the height h with the force F; a weld at the foot bears F and F h/2.

    The pole would move at a fiftieth of the wind within a step if the weld did not hold it.
    """
    height = 3.0
    pole = pc.RigidBody(pc.Rectangle(0.1, height), (0.0, height / 2), mass=50.0)
    foot = pc.Weld(pole, None, (0.0, 0.0))
    run = pc.simulate(pc.Scene(pole, foot, wind(SPEED, 0.0)), 0.1, dt=1 / 100, fps=100)
    force = 0.5 * AIR * NORMAL * height * SPEED**2
    assert run[foot].force[-1] == pytest.approx([-force, 0.0], rel=1e-6, abs=1e-9 * force)
    assert run[foot].torque[-1] == pytest.approx(0.5 * force * height, rel=1e-6)


@pytest.mark.parametrize("dimension", [2, 3])
def test_still_air_slows_a_spinning_paddle(dimension):
    """I dω/dt = −k ω² with k = ½ ρ c H L⁴/32 for a thin paddle of length L and height H, so that ω = ω₀/(1 + k ω₀ t/I).

    The quadrature of |x|³ over the faces in space is off by 1 %.
    """
    length, height, mass, start = 1.0, 0.5 if dimension == 3 else 1.0, 0.3, 20.0
    if dimension == 2:
        paddle = pc.RigidBody(pc.Rectangle(length, 1e-3), (0.0, 0.0), angular_velocity=start, mass=mass)
    else:
        shape = pc.Cuboid(length, 1e-3, height)
        paddle = pc.RigidBody(shape, (0.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, start), mass=mass)
    run = pc.simulate(pc.Scene(paddle, wind(*[0.0] * dimension)), 1.0, dt=1 / 2000, fps=10)
    rate = 0.5 * AIR * NORMAL * height * length**4 / 32.0 / (mass * (length**2 + 1e-6) / 12.0)
    expected = start / (1.0 + rate * start * run.times)
    assert expected[-1] < 0.5 * start
    turning = run[paddle].angular_velocities[:, 0].reshape(len(run.times), -1)[:, -1]
    assert turning == pytest.approx(expected, rel=1e-4 if dimension == 2 else 1e-2)
    assert np.abs(run.energy.drift).max() < 5e-5


def tumbling():
    """A body without symmetry that tumbles in the wind."""
    shard = pc.Hull([(0.0, 0.0, 0.0), (0.4, 0.0, 0.0), (0.1, 0.3, 0.0), (0.1, 0.1, 0.25)])
    body = pc.RigidBody(shard, (0.0, 0.0, 0.0), velocity=(1.0, 0.0, 0.5), angular_velocity=(3.0, -4.0, 2.0), mass=0.2)
    return body, pc.Scene(body, wind(4.0, -2.0, 1.0, tangential=0.1), pc.Gravity((0.0, 0.0, -G)))


def test_steps_in_the_wind_are_of_order_two():
    body, scene = tumbling()

    def end(dt):
        run = pc.simulate(scene, 0.5, dt=dt, fps=2)
        return np.concatenate([run[body].positions[-1, 0], run[body].orientations[-1, 0]]), run.energy.drift[-1]

    (coarse, drift), (middle, half), (fine, _) = (end(dt) for dt in (0.01, 0.005, 0.0025))
    ratio = np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine)
    assert 3.4 < ratio < 4.6
    assert 3.0 < abs(drift / half) < 5.0
    assert abs(half) < 1e-3


def test_a_function_has_the_points_of_the_surface():
    """In a shear flow about the center, a disc feels a torque and no force, by symmetry."""
    disc = pc.RigidBody(pc.Disc(0.5), (1.0, 2.0), mass=10.0)
    seen = []

    def shear(time, positions):
        seen.append(positions)
        return np.column_stack([3.0 * (positions[:, 1] - 2.0), 0.0 * positions[:, 0]])

    simulation = pc.Simulation(pc.Scene(disc, wind_of(shear)), dt=1e-3)
    simulation.step(5)
    assert np.hypot(*(seen[0] - (1.0, 2.0)).T) == pytest.approx(0.5)
    assert np.abs(simulation.momentum()).max() < 1e-12
    assert simulation[disc].angular_velocities[0] < 0.0


def wind_of(function):
    return pc.Wind(function, density=AIR, tangential=0.3)


def test_wind_blows_on_all_that_has_a_surface():
    """By default on cloth and on rigid bodies; fixed bodies feel none."""
    cloth = pc.cloth((3, 3), 0.1, 50.0, mass=0.01, origin=(0.0, 0.0, 0.0), axes=((0, 1, 0), (0, 0, 1)))
    box = pc.RigidBodies(pc.Cuboid(0.2, 0.2, 0.2), [(3.0, 0.0, 0.0), (6.0, 0.0, 0.0)], fixed=[False, True])
    simulation = pc.Simulation(pc.Scene(cloth, box, wind(1.0, 0.0, 0.0)), dt=1e-3)
    simulation.step(5)
    assert (simulation.velocities[:, 0] > 0.0).all()
    assert (simulation[box].velocities[:, 0] > 0.0).tolist() == [True, False]


@pytest.mark.parametrize(
    ("items", "message"),
    [
        ((pc.Particles([[0.0, 0.0]]), pc.Wind((1.0, 0.0))), r"forces\[0\]: must act on faces or on rigid bodies"),
        (
            (pc.RigidBody(pc.Disc(1.0), (0.0, 0.0)), pc.Wind((1.0, 0.0, 0.0))),
            r"forces\[0\].velocity: Wind must have 2 components in this 2D scene, got 3",
        ),
    ],
)
def test_what_no_wind_can_blow_on_is_refused(items, message):
    with pytest.raises(pc.SceneError, match=message):
        pc.Scene(*items)
