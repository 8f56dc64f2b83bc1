"""Particles that are tied to rigid bodies: places, momenta, reaction forces, work and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc

G = 9.81


def rotations(orientations):
    """Matrices (…, 3, 3) of quaternions (…, 4), (w, x, y, z)."""
    w, x, y, z = np.moveaxis(orientations, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array([[np.broadcast_to(e, w.shape) for e in row] for row in rows]), (0, 1), (-2, -1))


def hammock():
    """A cloth whose ends are tied to two boxes that fly and turn, too far away to be touched."""
    cloth = pc.cloth((7, 4), 0.1, 60.0, damping=0.02, mass=0.01, origin=(0.0, 0.0, 0.0), axes=((1, 0, 0), (0, 1, 0)))
    boxes = pc.RigidBodies(
        pc.Cuboid(0.1, 0.2, 0.15),
        [(-0.25, 0.15, 0.03), (0.85, 0.15, 0.0)],
        velocities=[(-0.5, 0.2, 0.0), (0.3, 0.0, 0.4)],
        angular_velocities=[(0.5, 1.0, -1.0), (0.0, -2.0, 0.3)],
        mass=(0.3, 0.2),
    )
    columns = np.arange(28) % 7
    anchors = [pc.Anchor(cloth, columns == 0, (boxes, 0)), pc.Anchor(cloth, columns == 6, (boxes, 1))]
    return cloth, boxes, anchors


def test_tied_particles_keep_their_places_and_all_momenta():
    """Both to the rounding of 600 steps"""
    cloth, boxes, anchors = hammock()
    run = pc.simulate(pc.Scene(cloth, boxes, *anchors), 0.6, dt=1e-3, fps=50)
    assert run.energy.dissipated_by["contacts"][-1] == 0.0
    turns = rotations(run[boxes].orientations)
    for index, anchor in enumerate(anchors):
        tied = cloth.positions[anchor.indices] - boxes.positions[index]
        places = run[boxes].positions[:, index, np.newaxis] + np.einsum("fij,nj->fni", turns[:, index], tied)
        assert np.abs(run.positions[:, anchor.indices] - places).max() < 1e-13
    assert np.abs(run.momentum - run.momentum[0]).max() < 1e-13
    assert np.abs(run.angular_momentum - run.angular_momentum[0]).max() < 1e-13
    assert np.abs(run.energy.drift).max() < 2e-3
    moved = np.abs(run[boxes].velocities[-1] - boxes.velocities).max()
    assert moved > 0.3


def test_reactions_are_the_change_of_momentum_of_the_body():
    """Nothing but the cloth acts on the boxes: in every step m Δv = h F and ΔL = h T, with the mean force and torque.

    The torque is that with the arms at the end of the step. Arms turn by O(h), and forces of neighbors are larger than
    their sum.
    """
    cloth, boxes, anchors = hammock()
    dt = 1e-3
    run = pc.simulate(pc.Scene(cloth, boxes, *anchors), 0.2, dt=dt, fps=1 / dt)
    for index, anchor in enumerate(anchors):
        force = run[anchor].force
        assert force.shape == (201, 4, 3)
        change = boxes.mass[index] * np.diff(run[boxes].velocities[:, index], axis=0)
        assert change == pytest.approx(dt * force[1:].sum(axis=1), abs=1e-14)
        turns = rotations(run[boxes].orientations[:, index])
        inertia = boxes.mass[index] / 12.0 * np.diag([0.2**2 + 0.15**2, 0.1**2 + 0.15**2, 0.1**2 + 0.2**2])
        spin = np.einsum("fij,jk,flk,fl->fi", turns, inertia, turns, run[boxes].angular_velocities[:, index])
        turned = np.diff(spin, axis=0)
        assert np.abs(turned - dt * run[anchor].torque[1:].sum(axis=1)).max() < 0.05 * np.abs(turned).max()


def test_a_box_swings_on_a_spring_with_the_mass_of_its_particle():
    """ω² = k/(M + m). The reaction is what accelerates the box, M (a + g)."""
    stiffness, box_mass, mass = 80.0, 1.5, 0.5
    spring = pc.rope(2, 1.0, stiffness, mass=mass, direction=(0.0, -1.0), pinned="start")
    box = pc.RigidBody(pc.Rectangle(0.4, 0.2), (0.0, -1.1), mass=box_mass)
    anchor = pc.Anchor(spring, 1, box)
    dt = 1 / 2000
    run = pc.simulate(pc.Scene(spring, box, anchor, pc.Gravity((0.0, -G))), 2.0, dt=dt, fps=100)
    total = box_mass + mass
    rate, sag = math.sqrt(stiffness / total), total * G / stiffness
    assert run[box].positions[:, 0, 1] == pytest.approx(-1.1 - sag * (1.0 - np.cos(rate * run.times)), abs=1e-5)
    load = box_mass * (G - G * np.cos(rate * (run.times[1:] - 0.5 * dt)))
    assert run[anchor].force[1:, 0, 1] == pytest.approx(load, abs=1e-4 * box_mass * G)
    assert np.abs(run[anchor].torque).max() < 1e-12


def test_a_body_with_a_tied_particle_turns_about_their_common_center():
    """The center of a disc runs around at the radius m d/(M + m), with the angular velocity of both."""
    spin = 3.0
    disc = pc.RigidBody(pc.Disc(0.5), (0.0, 0.0), mass=2.0, angular_velocity=spin)
    weight = pc.Particles([[0.8, 0.0]], mass=0.5)
    run = pc.simulate(pc.Scene(disc, weight, pc.Anchor(weight, 0, disc)), 2.0, dt=0.01, fps=50)
    # The particle starts with ω × d, and the disc at rest: the common center drifts.
    center = np.array([0.8 * 0.5 / 2.5, 0.0]) + np.outer(run.times, [0.0, 0.5 * spin * 0.8 / 2.5])
    around = run[disc].positions[:, 0] - center
    angle = spin * run.times
    assert around == pytest.approx(-0.16 * np.column_stack([np.cos(angle), np.sin(angle)]), abs=1e-13)
    assert run[disc].angles[:, 0] == pytest.approx(angle, abs=1e-13)
    assert np.abs(run.energy.drift).max() < 1e-14


def test_a_driven_body_does_work_on_its_particles():
    """A chain on a rotor that turns as prescribed is thrown outward. What it gains is the work of the rotor."""
    speeds = 4.0 * np.linspace(0.4, 1.2, 5)
    chain = pc.rope(
        5,
        0.8,
        200.0,
        damping=0.2,
        mass=0.05,
        start=(0.4, 0.0),
        velocities=np.column_stack([0.0 * speeds, speeds]),
    )
    rotor = pc.RigidBody(pc.Rectangle(0.4, 0.1), (0.0, 0.0), fixed=True, angular_velocity=4.0)
    anchor = pc.Anchor(chain, 0, rotor)
    drifts = []
    for dt in (1 / 500, 1 / 1000):
        run = pc.simulate(pc.Scene(chain, rotor, anchor), 2.0, dt=dt, fps=50)
        drifts.append(np.abs(run.energy.drift).max())
        assert np.abs(run.energy.work).max() > 0.02
    assert drifts[1] < 1e-3
    assert 3.0 < drifts[0] / drifts[1] < 5.0


def test_a_chain_that_goes_around_with_its_rotor_pulls_by_its_centrifugal_force():
    """k (rᵢ − rᵢ₋₁ − l) = ω² Σ m rⱼ over all further out. The rotor bears ω² Σ m rⱼ, and does no work."""
    stiffness, mass, length, turning, inner, count = 40.0, 0.05, 0.2, 4.0, 0.4, 5
    loads = np.triu(np.ones((count, count)))[1:] * mass * turning**2
    stretch = stiffness * (np.eye(count)[1:] - np.eye(count, k=-1)[1:])
    free = (stretch - loads)[:, 1:]
    radii = np.linalg.solve(free, stiffness * length - (stretch - loads)[:, 0] * inner)
    places = np.column_stack([[inner, *radii], np.zeros(count)])
    pairs = np.column_stack([np.arange(count - 1), np.arange(1, count)])
    chain = pc.SpringNetwork(
        places, pairs, stiffness, rest_length=length, mass=mass, velocities=turning * places[:, ::-1]
    )
    rotor = pc.RigidBody(pc.Rectangle(0.4, 0.1), (0.0, 0.0), fixed=True, angular_velocity=turning)
    anchor = pc.Anchor(chain, 0, rotor)
    run = pc.simulate(pc.Scene(chain, rotor, anchor), 1.0, dt=1 / 2000, fps=20)
    outward = run.positions[1:, 0] / inner
    pull = (run[anchor].force[1:, 0] * outward).sum(axis=1)
    assert pull == pytest.approx(turning**2 * mass * places[:, 0].sum(), rel=1e-4)
    assert np.abs(run.energy.work).max() < 1e-4
    assert np.hypot(*run.positions[-1].T) == pytest.approx(places[:, 0], rel=1e-5)


def test_an_anchor_is_many_ball_joints():
    """The difference of both methods falls with the square of the step."""

    def end(dt, tie):
        velocities = np.outer(np.arange(6) == 5, (1.0, 0.0))
        rope = pc.rope(6, 0.5, 300.0, mass=0.02, direction=(0.0, -1.0), pinned="start", velocities=velocities)
        box = pc.RigidBody(pc.Rectangle(0.2, 0.1), (0.05, -0.55), velocity=(1.0, 0.0), mass=0.3)
        item = pc.Anchor(rope, -1, box) if tie else pc.BallJoint(box, (rope, 5), (0.0, -0.5))
        run = pc.simulate(pc.Scene(rope, box, item, pc.Gravity((0.0, -G))), 0.3, dt=dt, fps=10)
        return run[box].positions[-1, 0]

    coarse, fine = (np.linalg.norm(end(dt, True) - end(dt, False)) for dt in (1 / 1000, 1 / 2000))
    assert fine < 1e-4
    assert fine < 0.5 * coarse


def test_a_body_with_particles_meets_others_as_one():
    """A disc with a tied particle hits a wall head on: the impact turns the velocity of both around, e = 1."""
    disc = pc.RigidBody(pc.Disc(0.5), (0.0, 0.0), velocity=(2.0, 0.0), mass=2.0, friction=0.0, restitution=1.0)
    weight = pc.Particles([[-0.3, 0.0]], mass=1.0, velocities=[[2.0, 0.0]])
    wall = pc.Plane((1.0, 0.0), (-1.0, 0.0), restitution=1.0)
    run = pc.simulate(pc.Scene(disc, weight, pc.Anchor(weight, 0, disc), wall), 0.6, dt=1 / 100, fps=100)
    assert run[disc].velocities[-1, 0] == pytest.approx([-2.0, 0.0], abs=1e-9)
    assert run.velocities[-1, 0] == pytest.approx([-2.0, 0.0], abs=1e-9)
    assert np.abs(run.energy.drift).max() < 1e-9


def test_anchors_are_given_by_names_and_saved(tmp_path):
    cloth, *_ = hammock()
    named = pc.SpringNetwork(cloth.positions, cloth.pairs, 60.0, cloth.rest_length, mass=0.01, name="cloth")
    box = pc.RigidBody(pc.Cuboid(0.1, 0.1, 0.1), (-0.06, 0.0, 0.0), name="box")
    scene = pc.Scene(named, box, pc.Anchor("cloth", [0, 7], "box"))
    other = pc.Scene(named, box, pc.Anchor(named, [7, 0], box))
    assert scene.hash() == other.hash()
    run = pc.simulate(scene, 0.01, dt=1e-3, fps=1000)
    run.save(tmp_path / "run.pcr")
    loaded = pc.load(tmp_path / "run.pcr")
    assert (loaded[loaded.scene.constraints[0]].force == run[scene.constraints[0]].force).all()


ROPE = pc.rope(4, 0.3, 100.0, mass=0.01, pinned="start")
BOX = pc.RigidBody(pc.Rectangle(0.1, 0.1), (0.4, 0.0))
BOXES = pc.RigidBodies(pc.Rectangle(0.1, 0.1), [(0.4, 0.0), (0.4, 1.0)])
ROD = pc.SpringNetwork([[0.0, 0.0], [0.3, 0.0]], [[0, 1]], math.inf, mass=0.01)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: pc.Anchor(ROPE, 4, BOX), "Anchor.indices: index 4 is outside of"),
        (lambda: pc.Anchor(ROPE, [], BOX), "Anchor.indices: must select at least one particle"),
        (lambda: pc.Anchor((ROPE, [1]), 1, BOX), "Anchor.network: must be a whole network"),
        (lambda: pc.Anchor(BOX, 0, BOX), "Anchor.network: must be a SpringNetwork or Particles"),
        (lambda: pc.Anchor(ROPE, 1, BOXES), "Anchor.body: must be a RigidBody, or one of several as"),
        (lambda: pc.Anchor(ROPE, 1, ROPE), "Anchor.body: must be a RigidBody, or one of several as"),
        (
            lambda: pc.Anchor(ROPE, 1, pc.RigidBody(pc.Ball(0.1), (0.0, 0.0, 0.0))),
            "Anchor.body: must be in 2D like the network",
        ),
        (
            lambda: pc.Simulation(pc.Scene(ROPE, BOX, pc.Anchor(ROPE, 0, BOX))),
            r"Anchor|constraints\[0\].indices: .*fixed",
        ),
        (
            lambda: pc.Simulation(
                pc.Scene(ROPE, BOXES, pc.Anchor(ROPE, 3, (BOXES, 0)), pc.Anchor(ROPE, 3, (BOXES, 1)))
            ),
            r"constraints\[1\].indices: .*tied already",
        ),
        (
            lambda: pc.Simulation(
                pc.Scene(ROPE, BOX, pc.Anchor(ROPE, 3, BOX), pc.BallJoint(BOX, (ROPE, 3), (0.3, 0.0)))
            ),
            r"constraints\[0\].indices: .*which a joint holds too",
        ),
        (
            lambda: pc.Simulation(pc.Scene(ROD, BOX, pc.Anchor(ROD, 1, BOX)), "RATTLE"),
            r"constraints\[0\].indices: .*a rod acts too",
        ),
    ],
)
def test_what_cannot_be_tied_is_refused(build, message):
    with pytest.raises(pc.SceneError, match=message):
        build()
