"""Wires: beads stay on their curves, energy is conserved, and friction removes its work alone."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc

CARRIERS = (
    pc.VelocityVerlet(),
    pc.RATTLE(),
    pc.RATTLE(4),
    pc.BackwardEuler(),
    pc.BDF2(),
    pc.XPBD(),
    pc.ProjectiveDynamics(),
)
REFUSING = (pc.RungeKutta4(), pc.PEFRL(), pc.ImplicitMidpoint(), pc.SemiImplicitEuler(), pc.GaussRadau15())
DOWN = pc.Gravity((0.0, -9.81))


def circle(count: int = 256, radius: float = 1.0) -> np.ndarray:
    """Points of a circle, from the lowest one on."""
    turn = 2.0 * np.pi * np.arange(count) / count
    return radius * np.column_stack([np.sin(turn), -np.cos(turn)])


def pendulum(angle: float = 1.0, speed: float = 0.0, **options: float) -> tuple[pc.Scene, pc.Wire]:
    """A bead on a ring, released at an angle from the lowest point."""
    place, direction = [[math.sin(angle), -math.cos(angle)]], np.array([[math.cos(angle), math.sin(angle)]])
    bead = pc.Particles(place, velocities=speed * direction, mass=0.5)
    wire = pc.Wire(circle(), on=bead, closed=True, **options)
    return pc.Scene(bead, wire, DOWN), wire


@pytest.mark.parametrize("integrator", CARRIERS, ids=str)
def test_beads_stay_on_the_wire_and_move_along_it_under_every_method_that_carries_it(integrator: pc.Integrator) -> None:
    scene, _ = pendulum()
    simulation = pc.Simulation(scene, integrator=integrator, dt=0.002)
    for _ in range(5):
        simulation.step(100)
        [x], [v] = simulation.positions, simulation.velocities
        # The spline through n points of a circle is off by (2π/n)⁴/384 = 1e-9 at most.
        assert abs(np.hypot(*x) - 1.0) < 2e-9
        # Its direction is off by about the cube of the angle between points over 72√3·(1/3).
        assert abs(np.dot(x, v)) < 1e-6 * np.hypot(*v) + 1e-12


@pytest.mark.parametrize("integrator", REFUSING, ids=str)
def test_other_methods_refuse_wires_by_name(integrator: pc.Integrator) -> None:
    scene, _ = pendulum()
    with pytest.raises(pc.SceneError, match=r"integrator: .*VelocityVerlet\(\).* for wires"):
        pc.Simulation(scene, integrator=integrator)


def test_a_bead_on_a_ring_is_a_pendulum_and_converges_with_order_two() -> None:
    """The angle after 1.5 s, by rods of the same length with steps so small that their error is below 1e-9."""
    angle = 2.5
    rod = pc.SpringNetwork([[0.0, 0.0], [math.sin(angle), -math.cos(angle)]], [[0, 1]], np.inf, fixed=[0], mass=0.5)
    reference = pc.Simulation(pc.Scene(rod, DOWN), integrator=pc.RATTLE(4), dt=0.0005)
    reference.run(1.5)
    errors = []
    for dt in (0.01, 0.005, 0.0025):
        simulation = pc.Simulation(pendulum(angle)[0], dt=dt)
        simulation.run(1.5)
        errors.append(np.linalg.norm(simulation.positions[0] - reference.positions[1]))
    # Halved steps leave a quarter of the error; terms of order 4 change that by less than a tenth here.
    assert all(3.6 < coarse / fine < 4.4 for coarse, fine in pairwise(errors)), errors


def test_motion_is_reversible() -> None:
    """The step is symmetric: with reversed velocities the bead returns, up to rounding that each step leaves."""
    scene, _ = pendulum(2.0, 1.0)
    simulation = pc.Simulation(scene, dt=0.01)
    start = simulation.positions.copy()
    simulation.step(300)
    simulation.set(velocities=-simulation.velocities)
    simulation.step(300)
    # 600 steps, each off by the tolerance of 16 ulp of the position, and times the separation of neighbors, below 100.
    assert np.abs(simulation.positions - start).max() < 600 * 16 * 2.3e-16 * 100


def test_the_force_of_the_wire_is_that_of_a_rod() -> None:
    """m (v²/R − a_n) toward the center: the tension of a rod in the same state."""
    scene, wire = pendulum(0.7, 2.0)
    simulation = pc.Simulation(scene, dt=0.001)
    for _ in range(4):
        [x], [v], [force] = simulation.positions, simulation.velocities, simulation[wire].force
        expected = 0.5 * (v @ v + 9.81 * -x[1])  # the radius is 1
        # The curvature of the spline is off by the square of the angle between points over 12: 5e-5.
        assert np.abs(force + expected * x).max() < 1e-4 * abs(expected)
        simulation.step(150)


def test_a_wire_does_no_work_on_its_beads() -> None:
    """The energy error of a symplectic step of order 2 does not grow, and is a quarter for half the step."""
    drifts = []
    for dt in (0.004, 0.002):
        energy = pc.simulate(pendulum(2.0)[0], 20.0, fps=100, dt=dt).energy
        assert not energy.dissipated.any()
        assert not energy.work.any()
        early, late = np.array_split(np.abs(energy.drift), 2)
        # Both halves have four swings; frames hit the largest error of a swing within their distance, 4 % of a swing.
        assert late.max() < 1.05 * early.max()
        drifts.append(early.max())
    assert 3.8 < drifts[0] / drifts[1] < 4.2


def test_friction_stops_a_bead_on_a_slope_below_its_angle_and_not_above() -> None:
    """Coulomb's law on an inclined straight wire: rest for tan α ≤ μ, else the acceleration g (sin α − μ cos α)."""
    for friction, slides in ((0.6, False), (0.4, True)):
        bead = pc.Particles([[0.0, 0.0]], mass=0.3)
        slope = np.array([2.0, -1.0]) / math.sqrt(5.0)  # tan α = 1/2
        scene = pc.Scene(bead, pc.Wire([-slope, 5.0 * slope], on=bead, friction=friction), DOWN)
        recording = pc.simulate(scene, 1.0, dt=0.001)
        travelled = recording.positions[-1, 0] @ slope
        if slides:
            expected = 0.5 * 9.81 * (1.0 - 2.0 * friction) / math.sqrt(5.0)
            # A step from rest is the only one with an error: at most a step's displacement.
            assert abs(travelled - expected) < expected * 0.003
            lost = friction * 0.3 * 9.81 * 2.0 / math.sqrt(5.0) * expected
            assert recording.energy.dissipated[-1] == pytest.approx(lost, rel=0.003)
            assert np.abs(recording.energy.drift).max() < 1e-3
        else:
            # Rounding of the position in each of 1000 steps.
            assert abs(travelled) < 1e-12
            assert abs(recording.energy.dissipated[-1]) < 1e-15


def test_friction_on_a_ring_without_weight_decays_exponentially_with_the_angle() -> None:
    """The normal force is m v²/R: dv/dφ = −μ v, so that v = v₀ exp(−μ φ)."""
    bead = pc.Particles([[0.0, -1.0]], velocities=[[3.0, 0.0]])
    scene = pc.Scene(bead, pc.Wire(circle(512), on=bead, closed=True, friction=0.25))
    speeds = []
    for dt in (0.004, 0.002, 0.001):
        simulation = pc.Simulation(scene, dt=dt)
        simulation.run(2.0)
        speeds.append(float(np.hypot(*simulation.velocities[0])))
    exact = 3.0 / (1.0 + 0.25 * 3.0 * 2.0)  # dv/dt = −μ v²
    errors = [abs(speed - exact) for speed in speeds]
    # Friction has the impulse of the wire at the start of each half of a step: the method is of order 1. Each half
    # loses μ v² h/2 instead of μ v² h/2 (1 − μ v h/2): the sum over 2 s is 0.3 h, below h.
    assert errors[0] < 0.004, errors
    assert all(1.9 < one / other < 2.1 for one, other in pairwise(errors)), errors


@given(shift=st.tuples(*[st.integers(-8, 8)] * 2), power=st.integers(-3, 3))
def test_shifted_and_rescaled_wires_move_alike(shift: tuple[int, int], power: int) -> None:
    """Lengths times a power of two, with accelerations alike, change no bit; a shift changes the rounding alone."""
    scale = 2.0**power
    angle = 1.25
    start = np.array([[math.sin(angle), -math.cos(angle)]])

    def end(points: np.ndarray, position: np.ndarray, gravity: float) -> np.ndarray:
        bead = pc.Particles(position)
        scene = pc.Scene(bead, pc.Wire(points, on=bead, closed=True), pc.Gravity((0.0, -gravity)))
        simulation = pc.Simulation(scene, dt=1 / 128)
        simulation.step(64)
        return simulation.positions

    here = end(circle(32), start, 8.0)
    assert np.array_equal(end(scale * circle(32), scale * start, 8.0 * scale), scale * here)
    moved = end(circle(32) + shift, start + shift, 8.0)
    # Coordinates up to 10 m, off by 1e-15 m, in the points and in each of 64 steps of 16 ulp.
    assert np.abs(moved - shift - here).max() < 64 * 16 * 2e-15 * 10


def test_what_a_wire_cannot_hold_is_refused_by_name() -> None:
    ring = circle()
    beside = pc.Particles([[0.0, -0.5]])
    with pytest.raises(pc.SceneError, match=r"constraints\[0\]\.on: .*particle 0, 0\.5 m beside it"):
        pc.Simulation(pc.Scene(beside, pc.Wire(ring, on=beside, closed=True)))
    bead = pc.Particles([[0.0, -1.0]], radius=0.1)
    wire = pc.Wire(ring, on=bead, closed=True)
    run = pc.Simulation(pc.Scene(bead, wire))
    before = run.state_hash()
    with pytest.raises(pc.SceneError, match=r"^set\.positions: expected particles on the wire, .* 0\.8 m beside it$"):
        run.set(positions=[[0.0, -0.2]])
    assert run.state_hash() == before
    with pytest.raises(pc.SceneError, match="on which a boundary acts too"):
        pc.Simulation(pc.Scene(bead, wire, pc.Floor(-3.0)))
    with pytest.raises(pc.SceneError, match="one wire for each particle"):
        pc.Simulation(pc.Scene(bead, wire, pc.Wire(ring, on=bead, closed=True)))
    rod = pc.SpringNetwork([[0.0, -1.0], [0.0, -2.0]], [[0, 1]], np.inf)
    with pytest.raises(pc.SceneError, match="on which a rod acts too"):
        pc.Simulation(pc.Scene(rod, pc.Wire(ring, on=(rod, 0), closed=True)), integrator=pc.RATTLE())
    held = pc.Particles([[0.0, -1.0]], fixed=[0])
    with pytest.raises(pc.SceneError, match="particles that move"):
        pc.Simulation(pc.Scene(held, pc.Wire(ring, on=held, closed=True)))
    for points in ([[0.0, 0.0]], [[0.0, 0.0], [0.0, 0.0]], [0.0, 1.0], [[0.0, 0.0], [np.nan, 1.0]]):
        with pytest.raises(pc.SceneError, match=r"Wire\.points"):
            pc.Wire(points)


def test_a_bead_that_leaves_an_open_wire_stops_the_simulation_with_the_reason() -> None:
    bead = pc.Particles([[0.0, 0.0]], velocities=[[1.0, 0.0]])
    simulation = pc.Simulation(pc.Scene(bead, pc.Wire([[-1.0, 0.0], [1.0, 0.0]], on=bead)), dt=0.01)
    with pytest.raises(pc.SimulationDiverged, match="leaves it at an end"):
        simulation.run(2.0)
    assert simulation.positions[0, 0] <= 1.0


def test_a_bead_keeps_its_branch_where_the_wire_crosses_itself() -> None:
    """The figure eight (sin u, sin 2u / 2): a bead passes the crossing straight on, also from a checkpoint there."""
    turn = 2.0 * np.pi * np.arange(64) / 64.0
    eight = np.column_stack([np.sin(turn), 0.5 * np.sin(2.0 * turn)])
    bead = pc.Particles(eight[[8]], velocities=[[-1.0, 0.0]])
    recording = pc.simulate(pc.Scene(bead, pc.Wire(eight, on=bead, closed=True)), 6.0, dt=0.01)
    speeds = np.hypot(*recording.velocities[:, 0].T)
    assert np.abs(speeds - speeds[0]).max() < 1e-3 * speeds[0]
    assert recording.positions[:, 0, 0].min() < -0.9
    assert recording.positions[:, 0, 1].min() < -0.4


def test_rods_of_other_bodies_move_beside_wires() -> None:
    rod = pc.SpringNetwork([[3.0, 0.0], [4.0, 0.0]], [[0, 1]], np.inf, fixed=[0])
    scene, wire = pendulum()
    both = pc.Scene(*scene.bodies, rod, wire, DOWN)
    simulation = pc.Simulation(both, dt=0.002)
    alone = pc.Simulation(scene, dt=0.002)
    simulation.step(200)
    alone.step(200)
    assert np.array_equal(simulation.positions[:1], alone.positions)
    assert abs(np.hypot(*(simulation.positions[2] - simulation.positions[1])) - 1.0) < 1e-12


def test_the_force_of_the_wire_is_that_at_the_time_of_the_state() -> None:
    """A charge on a straight wire in the field E(t) of a trap: the wire cancels it at each time."""
    charge = pc.Particles([[0.0, 0.0, 1.0]], charge=1.0)
    wire = pc.Wire([[-5.0, 0.0, 1.0], [5.0, 0.0, 1.0]], on=charge)
    trap = pc.ElectromagneticField(electric=pc.PaulTrap(0.0, 10.0, 1.0))
    recording = pc.simulate(pc.Scene(charge, wire, trap), 1.0, fps=8, dt=0.005)
    size = np.abs(recording[wire].force[:, 0, 2])
    assert size == pytest.approx(size[0] * np.abs(np.cos(2.0 * np.pi * recording.times)), abs=1e-9 * size[0])


def test_the_force_of_the_wire_has_that_of_springs_under_every_method() -> None:
    """A bead with a weight on a spring at rest below it bears both weights."""
    pair = pc.SpringNetwork([[0.0, 0.0], [0.0, -1.0 - 9.81 / 50.0]], [[0, 1]], 50.0, rest_length=1.0)
    wire = pc.Wire([[-1.0, 0.0], [1.0, 0.0]], on=(pair, 0))
    for integrator in CARRIERS:
        simulation = pc.Simulation(pc.Scene(pair, wire, DOWN), integrator=integrator, dt=0.001)
        assert simulation[wire].force[0] == pytest.approx([0.0, 2.0 * 9.81], abs=1e-9), integrator


def test_friction_is_refused_where_a_step_goes_back_in_time() -> None:
    with pytest.raises(pc.SceneError, match=r"friction: .*0 with RATTLE\(order=4\)"):
        pc.Simulation(pendulum(friction=0.1)[0], integrator=pc.RATTLE(4))


def test_friction_holds_a_bead_at_an_end_of_its_wire() -> None:
    slope = np.array([2.0, -1.0]) / math.sqrt(5.0)
    bead = pc.Particles([3.0 * slope])
    scene = pc.Scene(bead, pc.Wire([0.0 * slope, 3.0 * slope], on=bead, friction=0.9), DOWN)
    for integrator in (pc.VelocityVerlet(), pc.BackwardEuler(), pc.XPBD()):
        simulation = pc.Simulation(scene, integrator=integrator, dt=0.001)
        simulation.step(50)
        assert simulation.positions == pytest.approx(bead.positions, abs=1e-12)
        # At rest friction bears the weight along the wire, so that the whole force is upward.
        assert simulation[scene.constraints[0]].force[0] == pytest.approx([0.0, 9.81], abs=1e-9)


@pytest.mark.parametrize("count", [16, 64, 256])
def test_beads_are_found_on_both_sides_of_the_seam_of_a_closed_wire(count: int) -> None:
    points = circle(count)
    curve = pc.Wire(points, closed=True).curve(40)
    for place in (*curve[:3], *curve[-4:-1]):
        bead = pc.Particles([place])
        simulation = pc.Simulation(pc.Scene(bead, pc.Wire(points, on=bead, closed=True)))
        assert np.abs(simulation.positions - place).max() < 1e-14


def test_a_bead_at_a_crossing_keeps_its_branch_when_velocities_are_set() -> None:
    turn = 2.0 * np.pi * np.arange(64) / 64.0
    eight = np.column_stack([np.sin(turn), 0.5 * np.sin(2.0 * turn)])
    bead = pc.Particles(eight[[8]], velocities=[[-1.0, 0.0]])
    simulation = pc.Simulation(pc.Scene(bead, pc.Wire(eight, on=bead, closed=True)), dt=0.002)
    for _ in range(800):
        simulation.step()
        before = simulation.positions.copy()
        simulation.set(velocities=simulation.velocities)
        assert np.array_equal(simulation.positions, before)
    assert simulation.positions[0, 0] < 0.0


def test_a_step_does_not_leap_over_a_loop() -> None:
    """A straight wire with a loop of radius 0.05 m: a step of more than its length does not take the bead across."""
    turn = np.linspace(0.0, 2.0 * np.pi, 33)[1:-1]
    loop = np.column_stack([1.0 + 0.05 * np.sin(turn), 0.05 * (1.0 - np.cos(turn))])
    points = (
        [[x, 0.0] for x in np.linspace(0.0, 0.99, 12)] + loop.tolist() + [[x, 0.0] for x in np.linspace(1.01, 2, 12)]
    )
    bead = pc.Particles([[0.5, 0.0]], velocities=[[20.0, 0.0]])
    scene = pc.Scene(bead, pc.Wire(points, on=bead))
    with pytest.raises(pc.SimulationDiverged, match="passes a bend within a step"):
        pc.Simulation(scene, dt=0.02).run(0.06)
    # By default steps are short before the bend, and the way along the loop is travelled at the same speed.
    simulation = pc.Simulation(scene)
    simulation.run(0.05)
    assert np.hypot(*simulation.velocities[0]) == pytest.approx(20.0, rel=1e-3)
    assert simulation.positions[0, 0] < 1.5 - 0.2


def test_strain_limits_and_repeated_points_are_refused() -> None:
    net = pc.SpringNetwork([[0.0, -1.0], [0.0, -2.0]], [[0, 1]], 10.0, strain_limit=0.1)
    with pytest.raises(pc.SceneError, match="on which a strain limit acts too"):
        pc.Simulation(pc.Scene(net, pc.Wire(circle(), on=(net, 0), closed=True)), integrator=pc.VelocityVerlet())
    turn = np.linspace(0.0, 2.0 * np.pi, 101)
    with pytest.raises(pc.SceneError, match="returns to its first point by itself"):
        pc.Wire(np.column_stack([np.cos(turn), np.sin(turn)]), closed=True)


def test_the_default_method_in_a_magnetic_field_carries_wires() -> None:
    bead = pc.Particles([[0.0, -1.0]], velocities=[[1.0, 0.0]], charge=1.0)
    scene = pc.Scene(bead, pc.Wire(circle(), on=bead, closed=True), pc.ElectromagneticField(magnetic=2.0))
    simulation = pc.Simulation(scene, dt=0.01)
    simulation.step(10)
    assert np.hypot(*simulation.velocities[0]) == pytest.approx(1.0, rel=1e-6)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_a_bead_at_rest_stays_at_rest_without_a_warning(precision: pc.Precision) -> None:
    """Held by friction on a slope: rounding is no motion whose energy could be off."""
    slope = np.array([2.0, -1.0]) / math.sqrt(5.0)
    bead = pc.Particles([0.0 * slope])
    scene = pc.Scene(bead, pc.Wire([-slope, slope], on=bead, friction=0.6), DOWN)
    recording = pc.simulate(scene, 0.5, dt=0.001, precision=precision)
    assert np.abs(recording.positions[-1]).max() < 1e-9
