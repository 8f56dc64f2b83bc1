"""The motion of rigid bodies through the public face: flight, budgets, joints, and what is set, saved and replaced."""

from __future__ import annotations

import copy
import math

import numpy as np
import pytest

import physcore as pc

G = 9.81
DOWN = pc.Gravity((0.0, -G))


def thrown(dimension, **options):
    """Two bodies far apart that fly and turn."""
    if dimension == 2:
        return pc.RigidBodies(
            pc.Rectangle(0.2, 0.1),
            [(0.0, 0.0), (9.0, 0.0)],
            angles=(0.5, -1.0),
            velocities=[(1.0, 2.0), (-0.5, 3.0)],
            angular_velocities=(4.0, -2.0),
            **options,
        )
    return pc.RigidBodies(
        pc.Ball(0.1),
        [(0.0, 0.0, 0.0), (9.0, 0.0, 0.0)],
        orientations=[(1.0, 0.0, 0.0, 0.0), (1.0, 1.0, 0.0, 0.0)],
        velocities=[(1.0, 2.0, 3.0), (-0.5, 3.0, 0.0)],
        angular_velocities=[(1.0, 2.0, -2.0), (0.0, 0.0, 5.0)],
        **options,
    )


def across(places, velocities):
    """Cross products (B, 1) or (B, 3) of vectors in the plane (B, 2) or in space."""
    if places.shape[1] == 3:
        return np.cross(places, velocities)
    return (places[:, :1] * velocities[:, 1:] - places[:, 1:] * velocities[:, :1]).reshape(-1, 1)


def turned(start, spin, times):
    """Orientations (F, B, 4) of bodies that turn at constant angular velocities (B, 3), from (B, 4)."""
    rate = np.linalg.norm(spin, axis=1)
    half = 0.5 * times[:, np.newaxis] * rate
    w, x = np.cos(half), np.sin(half)[..., np.newaxis] * (spin / rate[:, np.newaxis])
    v, axis = start[:, 0], start[:, 1:]
    first = w * v - (x * axis).sum(axis=2)
    return np.concatenate(
        [first[..., np.newaxis], w[..., np.newaxis] * axis + v[:, np.newaxis] * x + np.cross(x, axis)], 2
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_bodies_fly_on_parabolas_and_turn_steadily(dimension):
    """Verlet's method is exact for both, up to the rounding of 100 steps: 100 ε of 10 m."""
    bodies = thrown(dimension)
    gravity = np.append(np.zeros(dimension - 1), -G)
    recording = pc.simulate(pc.Scene(bodies, pc.Gravity(tuple(gravity))), 1.0, fps=50, dt=1e-2)
    part, times = recording[bodies], recording.times
    assert part.positions.shape == (51, 2, dimension)
    t = times[:, np.newaxis, np.newaxis]
    flight = bodies.positions + bodies.velocities * t + 0.5 * gravity * t**2
    np.testing.assert_allclose(part.positions, flight, atol=3e-13)
    np.testing.assert_allclose(part.velocities, bodies.velocities + gravity * t, atol=3e-13)
    np.testing.assert_allclose(part.angular_velocities, [bodies.angular_velocities] * 51, atol=1e-13)
    if dimension == 2:
        angles = bodies.angles + bodies.angular_velocities * times[:, np.newaxis]
        np.testing.assert_allclose(part.angles, angles, atol=3e-13)
    else:
        expected = turned(bodies.orientations, bodies.angular_velocities, times)
        np.testing.assert_allclose(part.orientations, expected, atol=3e-13)
        np.testing.assert_allclose(np.linalg.norm(part.orientations, axis=2), 1.0, atol=1e-14)
    assert recording.positions.shape == (51, 0, dimension)


@pytest.mark.parametrize("dimension", [2, 3])
def test_momentum_and_energy_count_rigid_bodies_and_their_rotation(dimension):
    bodies, mass = thrown(dimension, mass=(2.0, 3.0)), np.array([2.0, 3.0])
    dust = pc.Particles(np.full((1, dimension), 5.0), velocities=1.0, mass=0.5)
    recording = pc.simulate(pc.Scene(dust, bodies), 0.5, fps=20, dt=1e-2)
    size = bodies.shape.properties(dimension).size
    moment = np.trace(bodies.shape.moment) / 3.0 if dimension == 3 else bodies.shape.moment
    inertia = mass * moment / size
    spins = bodies.angular_velocities.reshape(2, -1)
    momentum = mass @ bodies.velocities + 0.5 * dust.velocities[0]
    orbits = mass @ across(bodies.positions, bodies.velocities) + 0.5 * across(dust.positions, dust.velocities)[0]
    turning = orbits + inertia @ spins
    kinetic = 0.5 * (mass @ (bodies.velocities**2).sum(axis=1) + inertia @ (spins**2).sum(axis=1) + 0.5 * dimension)
    np.testing.assert_allclose(recording.momentum, [momentum] * 11, atol=1e-13)
    np.testing.assert_allclose(recording.angular_momentum, [turning] * 11, atol=1e-12)
    np.testing.assert_allclose(recording.energy.kinetic, kinetic, rtol=1e-13)


def test_a_fixed_body_keeps_its_velocity_and_its_rotation():
    held = thrown(2, fixed=[0], mass=1.0)
    recording = pc.simulate(pc.Scene(held, DOWN), 1.0, fps=10, dt=1e-2)
    np.testing.assert_allclose(recording[held].velocities[-1], [(1.0, 2.0), (-0.5, 3.0 - G)], atol=1e-12)
    np.testing.assert_allclose(recording[held].angles[-1], (4.5, -3.0), atol=1e-12)


def test_a_force_on_some_bodies_leaves_the_others_alone():
    bodies = thrown(2)
    recording = pc.simulate(pc.Scene(bodies, pc.Gravity((0.0, -G), on=(bodies, [1]))), 0.5, fps=10, dt=1e-2)
    np.testing.assert_allclose(recording[bodies].velocities[-1, :, 1], (2.0, 3.0 - 0.5 * G), atol=1e-12)


def test_charged_bodies_move_as_charged_particles():
    """Their force acts at their centers. Particles and rigid bodies take steps of one method."""
    places, charge = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.5)], (1e-6, 2e-6, -1e-6)
    grains = pc.Particles(places, mass=0.1, charge=charge)
    discs = pc.RigidBodies(pc.Disc(1e-3), places, mass=0.1, charge=charge)
    one, other = (pc.simulate(pc.Scene(each, pc.Coulomb()), 0.3, fps=20, dt=1e-3)[each] for each in (grains, discs))
    np.testing.assert_allclose(one.positions, other.positions, rtol=1e-12, atol=1e-14)
    assert (other.angles == 0.0).all()


def test_frames_between_steps_are_those_of_the_motion():
    """Cubic interpolation is exact for parabolas and steady angles."""
    bodies = thrown(2)
    recording = pc.simulate(pc.Scene(bodies, DOWN), 0.5, fps=31, dt=1e-2)
    angles = bodies.angles + bodies.angular_velocities * recording.times[:, np.newaxis]
    np.testing.assert_allclose(recording[bodies].angles, angles, atol=1e-12)


def test_the_channel_of_positions_has_those_of_rigid_bodies():
    bodies, dust = thrown(2), pc.Particles([[0.0, 5.0]])
    recording = pc.simulate(pc.Scene(bodies, dust), 0.1, channels=("positions",))
    assert list(recording[bodies].channels) == ["positions"]
    assert recording.positions.shape[1:] == (1, 2)
    assert recording[dust].positions.shape == recording.positions.shape
    with pytest.raises(pc.SceneError, match="channels: angles were not recorded"):
        _ = recording[bodies].angles


def test_the_state_of_rigid_bodies_is_set_and_counts_as_work():
    bodies, dust = thrown(2, mass=2.0), pc.Particles([[0.0, 5.0]])
    simulation = pc.Simulation(pc.Scene(dust, bodies), dt=1e-2)
    before = simulation.energy().kinetic
    simulation[bodies].set(positions=[(0.0, 0.0), (3.0, 0.0)], angles=0.25, angular_velocities=(1.0, 2.0))
    simulation.set(velocities={dust: (1.0, 0.0), bodies: 0.0}, positions={dust: (7.0, 7.0)})
    part, energy = simulation[bodies], simulation.energy()
    assert part.positions.tolist() == [[0.0, 0.0], [3.0, 0.0]]
    assert (part.angles.tolist(), part.angular_velocities.tolist()) == ([0.25, 0.25], [1.0, 2.0])
    assert simulation.positions.tolist() == [[7.0, 7.0]]
    inertia = 2.0 * bodies.shape.moment / bodies.shape.area
    assert energy.kinetic == pytest.approx(0.5 + 0.5 * inertia * 5.0, rel=1e-13)
    assert energy.work == pytest.approx(energy.kinetic - before, rel=1e-12)
    simulation.step(10)
    np.testing.assert_allclose(simulation[bodies].angles, (0.35, 0.45), atol=1e-14)
    top = pc.Simulation(pc.Scene(ball := pc.RigidBody(pc.Ball(0.1), (0.0, 0.0, 0.0))), dt=1e-2)
    top[ball].set(orientations=(0.0, 0.0, 0.0, 5.0))
    assert top[ball].orientations.tolist() == [[0.0, 0.0, 0.0, 1.0]]
    with pytest.raises(pc.SceneError, match=r"set.orientations\[.*: must not be zero"):
        top[ball].set(orientations=(0.0, 0.0, 0.0, 0.0))
    with pytest.raises(pc.SceneError, match=r"set.angles: must be one of positions, velocities, orientations, angular"):
        top[ball].set(angles=1.0)


def test_runs_are_saved_loaded_and_copied(tmp_path):
    bodies = pc.RigidBodies(
        pc.Cuboid(0.3, 0.2, 0.1), np.eye(3) * 5.0, angular_velocities=(1.0, 5.0, 0.5), name="blocks"
    )
    simulation = pc.Simulation(pc.Scene(bodies, pc.Gravity()), dt=1e-2)
    simulation.step(20)
    simulation.save(tmp_path / "state")
    runs = [simulation, pc.load(tmp_path / "state"), copy.copy(simulation)]
    for run in runs:
        run.step(20)
    assert len({run.state_hash() for run in runs}) == 1
    assert runs[1]["blocks"].orientations.tobytes() == simulation[bodies].orientations.tobytes()
    recording = pc.simulate(pc.Scene(bodies), 0.2, fps=20, dt=1e-2)
    recording.save(tmp_path / "run")
    loaded = pc.load(tmp_path / "run")["blocks"]
    for name, values in recording[bodies].channels.items():
        np.testing.assert_array_equal(loaded[name], values)


def test_a_changed_scene_keeps_the_state_of_rigid_bodies():
    bodies = thrown(2, name="boxes")
    simulation = pc.Simulation(pc.Scene(bodies), dt=1e-2)
    simulation.step(10)
    before = {name: values.copy() for name, values in simulation["boxes"].fields.items()}
    held = pc.RigidBodies(pc.Disc(0.1), bodies.positions, fixed=[0], name="boxes")
    simulation.replace(pc.Scene(held, DOWN))
    after = simulation["boxes"].fields
    for name in ("positions", "angles"):
        np.testing.assert_array_equal(after[name], before[name])
    assert after["velocities"].tolist() == [[0.0, 0.0], before["velocities"][1].tolist()]
    assert after["angular_velocities"].tolist() == [0.0, before["angular_velocities"][1]]
    with pytest.raises(pc.SceneError, match=r"bodies\['boxes'\]: is a Particles, and was a RigidBodies"):
        simulation.replace(pc.Scene(pc.Particles(bodies.positions, name="boxes")))


def test_events_find_rigid_bodies():
    """The second body is at x = 8 after 2 s, up to the rounding of 200 steps."""
    bodies = thrown(2)
    crossing = pc.Event.crossing((bodies, 1), "x", 8.0)
    events = pc.simulate(pc.Scene(bodies), 3.0, dt=1e-2, events=[crossing]).events
    assert events[crossing].times == pytest.approx([2.0], abs=1e-10)
    assert events[crossing][bodies].angles.shape == (1, 2)


def test_a_recording_of_rigid_bodies_has_a_table():
    pytest.importorskip("pandas")
    body = pc.RigidBody(pc.Ball(0.1), (0.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 1.0), name="ball")
    recording = pc.simulate(pc.Scene(body, pc.Particles([[5.0, 0.0, 0.0]])), 0.1, fps=20, dt=1e-2)
    table = recording["ball"].to_dataframe()
    assert [name for name in table.columns if name.startswith("orientations")] == [f"orientations_{c}" for c in "wxyz"]
    assert len(recording.to_dataframe()) == 3


SWING = 2e-3
"""Relative error of forces that are means over a step, and of motions over a few hundred steps of 1/240 s."""


def test_a_hinge_bears_the_weight_of_what_hangs_on_it():
    bar = pc.RigidBody(pc.Rectangle(0.1, 0.6), (0.0, -0.3), mass=2.0)
    hinge = pc.Hinge(bar, None, (0.0, 0.0))
    recording = pc.simulate(pc.Scene(bar, hinge, DOWN), 1.0, fps=20, dt=1 / 240)
    np.testing.assert_allclose(recording[hinge].force[1:], [(0.0, 2.0 * G)] * 20, rtol=SWING, atol=SWING)
    assert recording[hinge].torque.shape == (21,)
    assert np.abs(recording[bar].angles).max() < 1e-6


def test_a_weld_bears_weight_and_torque():
    """About its anchor, the middle of the wall, the weight acts at 0.5 m: the weld turns the plank back up."""
    plank = pc.RigidBody(pc.Rectangle(1.0, 0.1), (0.5, 0.0), mass=3.0)
    weld = pc.Weld(plank, None, (0.0, 0.0))
    recording = pc.simulate(pc.Scene(plank, weld, DOWN), 1.0, fps=20, dt=1 / 240)
    np.testing.assert_allclose(recording[weld].force[1:], [(0.0, 3.0 * G)] * 20, rtol=SWING, atol=SWING)
    np.testing.assert_allclose(recording[weld].torque[1:], 3.0 * G * 0.5, rtol=SWING)
    assert np.abs(recording[plank].angles).max() < 1e-3


def test_forces_of_joints_are_opposite_on_their_ends():
    planks = pc.RigidBodies(pc.Rectangle(1.0, 0.1), [(0.5, 0.0), (1.7, 0.0)], mass=(3.0, 2.0))
    wall = pc.Weld((planks, 0), None, (0.0, 0.0))
    for joint, sign in (
        (pc.Weld((planks, 0), (planks, 1), (1.1, 0.0)), -1),
        (pc.Weld((planks, 1), (planks, 0), (1.1, 0.0)), 1),
    ):
        recording = pc.simulate(pc.Scene(planks, wall, joint, DOWN), 0.5, fps=20, dt=1 / 240)
        np.testing.assert_allclose(recording[joint].force[1:, 1], sign * 2.0 * G, rtol=5 * SWING)
        np.testing.assert_allclose(recording[joint].torque[1:], sign * 2.0 * G * 0.6, rtol=5 * SWING)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_pendulum_swings_with_the_period_of_its_moment(dimension):
    """At 0.01 rad; ω² = m g d/(I + m d²). The angle crosses zero at a quarter period."""
    start = 0.01
    if dimension == 2:
        at = (0.3 * math.sin(start), -0.3 * math.cos(start))
        bar = pc.RigidBody(pc.Rectangle(0.1, 0.6), at, angle=start, mass=2.0)
        items = pc.Hinge(bar, None, (0.0, 0.0)), DOWN
        inertia = 2.0 * (0.01 + 0.36) / 12.0
    else:
        at = (0.3 * math.sin(start), 0.0, -0.3 * math.cos(start))
        turn = (math.cos(0.5 * start), 0.0, -math.sin(0.5 * start), 0.0)
        bar = pc.RigidBody(pc.Cuboid(0.1, 0.2, 0.6), at, orientation=turn, mass=2.0)
        items = pc.Hinge(bar, None, (0.0, 0.0, 0.0), axis=(0.0, -1.0, 0.0)), pc.Gravity((0.0, 0.0, -G))
        inertia = 2.0 * (0.01 + 0.36) / 12.0
    quarter = 0.5 * math.pi / math.sqrt(2.0 * G * 0.3 / (inertia + 2.0 * 0.09))
    middle = pc.Event.crossing(bar, "x", 0.0)
    events = pc.simulate(pc.Scene(bar, *items), 2.0 * quarter, dt=quarter / 400, events=[middle]).events
    assert events[middle].times == pytest.approx([quarter], rel=1e-4)


def test_a_motor_brings_its_hinge_to_speed_with_its_torque():
    """From rest at τ/I, then at the speed; the work is that of the motor, and all of it is kinetic."""
    wheel = pc.RigidBody(pc.Disc(0.2), (0.0, 0.0), mass=5.0)
    axle = pc.Hinge(wheel, None, (0.0, 0.0))
    scene = pc.Scene(wheel, axle, pc.Motor(axle, 3.0, 0.5))
    recording = pc.simulate(scene, 2.0, fps=60, dt=1 / 240)
    expected = np.minimum(0.5 / (0.5 * 5.0 * 0.04) * recording.times, 3.0)
    np.testing.assert_allclose(recording[wheel].angular_velocities[:, 0], expected, atol=0.03)
    assert recording[wheel].angular_velocities[-1, 0] == pytest.approx(3.0, rel=1e-3)
    assert recording.energy.work[-1] == pytest.approx(0.5 * 0.1 * 9.0, rel=5e-3)


def test_a_motor_pushes_a_slider_up_to_its_limit():
    piston = pc.RigidBody(pc.Rectangle(0.2, 0.1), (0.0, 0.0), mass=1.0)
    slider = pc.Prismatic(piston, None, (2.0, 0.0), lower=-0.1, upper=0.3)
    scene = pc.Scene(piston, slider, pc.Motor(slider, 0.5, 20.0), DOWN)
    recording = pc.simulate(scene, 1.0, fps=60, dt=1 / 240)
    x, y = recording[piston].positions[:, 0].T
    np.testing.assert_allclose(x[12:30], 0.5 * recording.times[12:30], atol=0.02)
    assert x.max() == pytest.approx(0.3, abs=2e-3)
    assert np.abs(y).max() < 1e-3
    assert np.abs(recording[piston].angles).max() < 1e-3


def test_a_hinge_stops_at_its_limit():
    bar = pc.RigidBody(pc.Rectangle(0.6, 0.1), (0.3, 0.0), mass=2.0)
    recording = pc.simulate(pc.Scene(bar, pc.Hinge(bar, None, (0.0, 0.0), lower=-0.5), DOWN), 3.0, fps=30, dt=1 / 240)
    assert recording[bar].angles.min() > -0.51
    assert recording[bar].angles[-1, 0] == pytest.approx(-0.5, abs=5e-3)


def test_a_rod_keeps_its_length_and_breaks_under_too_much_weight():
    ball = pc.RigidBody(pc.Disc(0.1), (1.0, 0.0), mass=1.0)
    ends = [(1.0, 0.0), (0.0, 0.0)]
    rod = pc.Rod(ball, None, ends)
    recording = pc.simulate(pc.Scene(ball, rod, DOWN), 1.0, fps=60, dt=1 / 240)
    np.testing.assert_allclose(np.linalg.norm(recording[ball].positions[:, 0], axis=1), 1.0, atol=1e-4)
    # The tension grows to 3 m g at the lowest point, and passes 2 m g where the rod has turned by asin(2/3).
    weak = pc.Rod(ball, None, ends, breaking_force=2.0 * G)
    recording = pc.simulate(pc.Scene(ball, weak, DOWN), 1.0, fps=240, dt=1 / 960)
    away = np.linalg.norm(recording[ball].positions[:, 0], axis=1) > 1.0005
    first = recording[ball].positions[np.argmax(away), 0]
    assert math.atan2(-first[1], first[0]) == pytest.approx(math.asin(2.0 / 3.0), abs=0.06)
    assert (recording[weak].force[-5:] == 0.0).all()


def test_a_spring_between_bodies_swings_with_the_period_of_their_reduced_mass():
    """ω² = k (1/m₁ + 1/m₂). The length is back at l₀ after a quarter of the period."""
    bodies = pc.RigidBodies(pc.Disc(0.01), [(0.0, 0.0), (1.1, 0.0)], mass=(1.0, 3.0))
    spring = pc.SpringJoint((bodies, 0), (bodies, 1), None, 40.0, rest_length=1.0)
    quarter = 0.5 * math.pi / math.sqrt(40.0 * (1.0 + 1.0 / 3.0))
    back = pc.Event(lambda state: state[bodies].positions[1, 0] - state[bodies].positions[0, 0] - 1.0, direction=-1)
    recording = pc.simulate(pc.Scene(bodies, spring), 1.5 * quarter, dt=quarter / 400, events=[back])
    assert recording.events[back].times == pytest.approx([quarter], rel=1e-3)
    assert np.abs(recording.momentum).max() < 1e-13
    assert np.abs(recording.energy.drift).max() < 1e-3
    assert recording[spring].force[1, 0] == pytest.approx(4.0, rel=0.05)


def test_a_particle_hangs_on_a_body():
    """Both accelerate together, and the joint pulls the bead along."""
    box = pc.RigidBody(pc.Rectangle(0.2, 0.2), (0.0, 0.0), velocity=(1.0, 0.0), mass=3.0)
    bead = pc.Particles([[0.3, 0.1]], velocities=[(1.0, 0.0)], mass=1.0)
    joint = pc.BallJoint(box, (bead, 0), (0.3, 0.1))
    recording = pc.simulate(pc.Scene(box, bead, joint), 1.0, fps=20, dt=1 / 240)
    np.testing.assert_allclose(recording.momentum, [(4.0, 0.0)] * 21, atol=1e-12)
    np.testing.assert_allclose(recording[bead].positions[-1, 0], (1.3, 0.1), atol=1e-6)


@pytest.mark.parametrize("dimension", [2, 3])
def test_angles_and_speeds_are_those_of_one_relative_to_other(dimension):
    """Both ends of a motor, and both orders of the items: the wheel turns at +3, or the world against it."""
    axis = None if dimension == 2 else (0.0, 0.0, 2.0)
    center = (0.0,) * dimension
    for world_first in (False, True):
        wheel = pc.RigidBody(pc.Disc(0.2) if dimension == 2 else pc.Ball(0.2), center, mass=5.0)
        ends = (None, wheel) if world_first else (wheel, None)
        axle = pc.Hinge(*ends, center, axis)
        motor = pc.Motor(axle, 3.0, 5.0)
        for items in ((axle, motor), (motor, axle)):
            spin = pc.simulate(pc.Scene(wheel, *items), 0.5, dt=1 / 240)[wheel].angular_velocities[-1].ravel()[-1]
            assert spin == pytest.approx(-3.0 if world_first else 3.0, rel=1e-9)


def test_the_way_of_a_slider_is_that_of_one_relative_to_other():
    """The axis turns with the second end: a slider on a turned block goes up, up to its upper limit."""
    blocks = pc.RigidBodies(pc.Rectangle(0.2, 0.1), [(0.0, 0.0), (0.0, 1.0)], fixed=[0], mass=1.0)
    slider = pc.Prismatic((blocks, 1), (blocks, 0), (0.0, 3.0), lower=-0.5, upper=0.25)
    scene = pc.Scene(blocks, slider, pc.Motor(slider, 1.0, 50.0), DOWN)
    y = pc.simulate(scene, 1.0, dt=1 / 240)[blocks].positions[-1, 1, 1]
    assert y == pytest.approx(1.25, abs=1e-6)


def test_the_budget_of_damped_springs_is_that_of_the_decay():
    """A disc on a spring at m = 1: x = exp(−γ t/2) (…); the energy is in by_term, what it loses in dissipated_by."""
    disc = pc.RigidBody(pc.Disc(0.1), (1.2, 0.0), mass=1.0)
    spring = pc.SpringJoint(disc, None, [(1.2, 0.0), (0.0, 0.0)], 40.0, 0.5, 1.0)
    recording = pc.simulate(pc.Scene(disc, spring), 2.0, fps=60, dt=1 / 960)
    energy, t = recording.energy, recording.times
    rate = math.sqrt(40.0 - 0.0625)
    x = 0.2 * np.exp(-0.25 * t) * (np.cos(rate * t) + 0.25 / rate * np.sin(rate * t))
    np.testing.assert_allclose(recording[disc].positions[:, 0, 0], 1.0 + x, atol=1e-4)
    np.testing.assert_allclose(energy.by_term["joints"], 20.0 * x**2, atol=1e-3)
    assert energy.dissipated_by["damping"][-1] == pytest.approx(0.8 * (1.0 - math.exp(-1.0)), rel=0.1)
    assert np.abs(energy.drift).max() < 1e-3


def test_a_spring_that_is_too_stiff_for_the_step_is_refused():
    """The bound counts the rotation: ω² = k (1/m + r²/I) = 50 (0.5 + 1.49) of this bar, so dt < 2/ω = 0.2 s."""
    bar = pc.RigidBody(pc.Rectangle(1.0, 0.1), (0.0, 0.0), mass=2.0)
    spring = pc.SpringJoint(bar, None, [(0.5, 0.0), (0.5, 1.0)], 50.0)
    limit = pc.Simulation(pc.Scene(bar, spring)).plan.dt_limit
    assert limit == pytest.approx(2.0 / math.sqrt(50.0 * (0.5 + 0.25 / (2.0 * 1.01 / 12.0))), rel=1e-9)


def test_a_particle_swings_on_a_spring_at_a_body():
    """The body is fixed: ω² = k/m of the bead, which moves as on a spring of a network."""
    box = pc.RigidBody(pc.Rectangle(0.2, 0.2), (0.0, 0.0), fixed=True)
    bead = pc.Particles([[1.1, 0.1]], mass=0.5)
    spring = pc.SpringJoint((bead, 0), box, [(1.1, 0.1), (0.1, 0.1)], 20.0, rest_length=0.9)
    quarter = 0.5 * math.pi / math.sqrt(40.0)
    recording = pc.simulate(pc.Scene(box, bead, spring), quarter, dt=quarter / 400, fps=1.0 / quarter)
    assert recording[bead].positions[-1, 0] == pytest.approx((1.0, 0.1), abs=1e-5)
    assert np.abs(recording.energy.drift).max() < 1e-4


def test_broken_joints_exert_no_force_and_saved_ones_stay_broken(tmp_path):
    planks = pc.RigidBodies(pc.Rectangle(1.0, 0.1), [(0.5, 0.0), (1.5, 0.0)], mass=(1.0, 20.0), name="planks")
    welds = [pc.Weld(("planks", 0), None, (0.0, 0.0)), pc.Weld(("planks", 0), ("planks", 1), (1.0, 0.0), 100.0)]
    simulation = pc.Simulation(pc.Scene(planks, *welds, DOWN), dt=1 / 240)
    simulation.step(20)
    simulation.save(tmp_path / "state")
    runs = [simulation, pc.load(tmp_path / "state")]
    for run in runs:
        run.step(20)
        np.testing.assert_allclose(run["planks"].velocities[1], (0.0, -G * 40 / 240), rtol=0.05, atol=1e-3)
        np.testing.assert_array_equal(run[welds[1]].force, 0.0)
        assert run[welds[0]].force[1] == pytest.approx(G, rel=0.05)
    assert len({run.state_hash() for run in runs}) == 1


@pytest.mark.parametrize("joint", [pc.Rod, pc.Hinge])
@pytest.mark.parametrize("gap", [0.0, 1e-3])
@pytest.mark.parametrize("dt", [1 / 480, 1 / 2000])
def test_a_cradle_of_pendulums_passes_one_impact_on(joint, gap, dt):
    """With e = 1 the last disc rises to the height of the first, and the others stay.

    The disc struck last is at most two gaps from its lowest point, where the rods are askew by 2 gap/l.
    """
    row, angles = (0.2 + gap) * np.arange(3), np.array([-0.6, 0.0, 0.0])
    places = np.column_stack([row + np.sin(angles), -np.cos(angles)])
    discs = pc.RigidBodies(pc.Disc(0.1), places, friction=0.0, restitution=1.0, mass=1.0)
    if joint is pc.Rod:
        joints = [pc.Rod((discs, k), None, [places[k], (row[k], 0.0)]) for k in range(3)]
    else:
        joints = [pc.Hinge((discs, k), None, (row[k], 0.0)) for k in range(3)]
    recording = pc.simulate(pc.Scene(discs, *joints, pc.Gravity((0.0, -G))), 1.0, fps=60, dt=dt)
    heights = recording[discs].positions[..., 1] + 1.0
    highest = np.argmax(heights[:, 2])
    assert heights[highest, 2] == pytest.approx(1.0 - math.cos(0.6), rel=0.01)
    assert heights[highest, :2].max() < 1e-4
    assert recording.energy.dissipated[-1] < 1e-9


@pytest.mark.parametrize("letter", "sgzy")
def test_a_letter_that_tumbles_down_steps_gains_no_energy(letter):
    """Parts of a concave polygon touch a step beside the vertex that bears it; only the surface of the whole counts."""
    shape = pc.polygon_from_mask(letter, 0.8)
    words = pc.RigidBody(shape, (-0.2, 0.4), velocity=(1.2, 0.0), friction=0.3, restitution=0.3)
    steps = pc.RigidBodies(
        pc.Rectangle(0.75, 3.0), [(0.75 * k - 0.375, -1.5 - 0.4 * k) for k in range(5)], fixed=range(5), friction=0.4
    )
    floor = pc.Floor(-2.0, restitution=0.2, friction=0.5)
    recording = pc.simulate(pc.Scene(words, steps, floor, pc.Gravity((0.0, -G))), 2.0, fps=120, dt=1 / 480)
    assert np.abs(recording.energy.drift).max() < 1e-3
