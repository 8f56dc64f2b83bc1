"""Scenes that cannot be what was meant are refused, or warned of, by name."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import physcore as pc

PAIR = [[0.0, 0.0], [1.0, 0.0]]


def test_coulomb_s_force_without_charges_is_warned_of():
    with pytest.warns(pc.SceneWarning, match=r"forces\[0\]: no body has a charge"):
        pc.Scene(pc.Particles(PAIR), pc.Coulomb())
    pc.Scene(pc.Particles(PAIR, charge=[1.0, 0.0]), pc.Coulomb())


def test_a_spring_that_never_breaks_is_refused():
    with pytest.raises(pc.SceneError, match=r"strain_limit\[0\]: must be at least the breaking_strain of 0\.5"):
        pc.SpringNetwork(PAIR, [[0, 1]], 10.0, breaking_strain=0.5, strain_limit=0.1)
    pc.SpringNetwork(PAIR, [[0, 1]], 10.0, breaking_strain=0.1, strain_limit=0.5)


def test_trees_have_an_angle_and_an_error_that_mean_something():
    for force in (pc.Gravitation, pc.Coulomb):
        with pytest.raises(pc.SceneError, match=r"opening_angle: must be ≤ 2"):
            force(opening_angle=2.5)
        with pytest.raises(pc.SceneError, match=r"force_error: must be ≤ 0\.02"):
            force(opening_angle="auto", force_error=0.1)


def test_a_large_particle_in_a_fluid_is_refused():
    water = pc.Fluid.block((0.0, 0.0), (1.0, 0.5), 0.05)
    stone = pc.Particles([[0.5, 0.75]], radius=0.1, fixed=[0], name="stone")
    with pytest.raises(
        pc.SceneError, match=r"bodies\['stone'\]\.radius: .* spacing of 0\.05 m, and its radius is 0\.1 m"
    ):
        pc.Scene(water, stone)
    pc.Scene(pc.Fluid.block((0.0, 0.0), (1.0, 0.5), 0.05, obstacles=False), stone)


def test_a_source_in_the_walls_is_refused():
    grid = pc.Grid((40, 40), 0.1)
    with pytest.raises(pc.SceneError, match=r"Wave\.sources\[0\]\.where: is in the walls"):
        pc.Wave(grid, 1.0, walls=lambda x, y: x < 1.0, sources=pc.Source((0.5, 2.0), 1.0, frequency=0.5))


def test_a_method_of_smooth_motion_refuses_soft_spheres():
    grains = pc.Particles(PAIR, radius=0.4)
    with pytest.raises(pc.SceneError, match=r"integrator: .* SoftSpheres, got GaussRadau15"):
        pc.Simulation(pc.Scene(grains, pc.SoftSpheres(1000.0)), "GaussRadau15")


def test_a_flow_may_carry_no_tracers():
    dust = pc.Tracers(np.zeros((0, 3)), pc.Lorenz())
    assert pc.simulate(pc.Scene(dust), 1.0)[dust].positions.shape == (31, 0, 3)


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
def test_no_steps_change_nothing_even_after_a_rescued_one():
    well = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 100.0, exponent=1.0))
    simulation = pc.Simulation(well, dt=1.0, on_divergence="substep")
    simulation.step()
    state = simulation.state_hash()
    simulation.step(0)
    assert simulation.state_hash() == state


def test_a_part_is_pickled_without_its_simulation():
    part = pc.Simulation(pc.Scene(pc.Particles(PAIR, name="pair")))["pair"]
    copy = pickle.loads(pickle.dumps(part))
    assert np.array_equal(copy.positions, part.positions)
    with pytest.raises(pc.SceneError, match="belongs to no simulation"):
        copy.set(positions=(0.0, 0.0))


def test_a_given_step_of_many_turns_is_warned_of():
    pair = pc.Scene(pc.PointVortices(PAIR, [math.tau, math.tau]))
    with pytest.warns(pc.StabilityWarning, match=r"times the limit of accuracy in this scene, .* \(flow\)"):
        pc.Simulation(pair, dt=10.0 * math.pi)
    charge = pc.Particles([[0.0, 0.0]], [[1.0, 0.0]], charge=1.0)
    with pytest.warns(pc.StabilityWarning, match=r"\(gyration\): the motion is not resolved"):
        pc.Simulation(pc.Scene(charge, pc.ElectromagneticField(magnetic=2.0)), dt=30.0)


def test_contacts_never_give_energy_back():
    """The impulses of rods on a circle act at different times within a step; what that gains is drift."""
    rods = pc.SpringNetwork(
        [[0.1 * k - 0.3, 0.0] for k in range(7)], [[k, k + 1] for k in range(6)], math.inf, mass=0.1
    )
    bowl = pc.Sphere((0.0, 0.2), 0.5, inside=True, restitution=0.0)
    recording = pc.simulate(pc.Scene(rods, pc.Gravity((0.0, -9.81)), bowl), 3.0)
    assert np.diff(recording.energy.dissipated).min() >= 0.0


def test_fluid_within_a_body_is_warned_of():
    water = pc.block((0.0, 0.0), (1.0, 0.5), 0.05)
    raft = pc.Particles(pc.block((0.3, 0.2), (0.5, 0.3), 0.05), name="raft")
    with pytest.warns(pc.SceneWarning, match=r"bodies\['raft'\]: 8 particles of bodies\[0\] start within half"):
        pc.Scene(pc.Fluid(water, 0.05), raft)
    outside = ~((np.abs(water - (0.4, 0.25)) < (0.1, 0.05)).all(axis=1))
    pc.Scene(pc.Fluid(water[outside], 0.05), raft)
    pc.Scene(pc.Fluid(water, 0.05, obstacles=False), raft)


def test_masses_that_contacts_do_not_resolve_are_warned_of():
    """A light box that bears a heavy one stays where it is up to this ratio, and is thrown about beyond it."""
    places = [(0.0, 0.1), (0.0, 0.3)]
    with pytest.warns(pc.SceneWarning, match=r"bodies\['boxes'\]\.mass: one is 1.0e\+12 times .* 1 kg .* fixed="):
        pc.Scene(pc.RigidBodies(pc.Rectangle(0.2, 0.2), places, mass=(1.0, 1e12), name="boxes"))
    pc.Scene(pc.RigidBodies(pc.Rectangle(0.2, 0.2), places, mass=(1.0, 1e12), fixed=[1]))
    boxes = pc.RigidBodies(pc.Rectangle(0.2, 0.2), places, mass=(1.0, 1e9))
    floor = pc.Floor(restitution=0.0, friction=0.5)
    recording = pc.simulate(pc.Scene(boxes, floor, pc.Gravity((0.0, -9.81))), 0.5, dt=1 / 240)
    assert np.abs(recording[boxes].positions - places).max() < 1e-6
