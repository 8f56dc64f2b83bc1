"""Springs with a strain limit: rods at their longest, springs or strings below it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import EPSILON

METHODS: list[pc.Integrator] = [
    pc.VelocityVerlet(),
    pc.BackwardEuler(),
    pc.BDF2(),
    pc.XPBD(1, 8),
    pc.ProjectiveDynamics(8),
]
IDS = [type(method).__name__ for method in METHODS]
LIMIT, SPEED = 0.1, 4.0


def longest_strain(simulation: pc.Simulation, body: pc.SpringNetwork) -> float:
    ends = simulation[body].positions[body.pairs]
    return float((np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / body.rest_length - 1.0).max())


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("integrator", METHODS, ids=IDS)
def test_at_its_limit_a_spring_loses_the_relative_motion(integrator: pc.Integrator, precision: str):
    """Two masses that fly apart lose ½ μ v² at the limit, with μ = 2/3 kg and v² = SPEED² − k (s L)²/μ; their momentum
    stays. The step that reaches the limit has lost up to k s L h/μ of the speed v: 2 · 30 · 0.1 · 1e-3/(2/3 · 3.8) =
    0.25 % of the energy, and implicit methods damp the motion until then by ω² h t/2 = 0.06 % of it.
    """
    stiffness, reduced = 30.0, 2.0 / 3.0
    velocities = [[-2.0 / 3.0 * SPEED, 0.0], [SPEED / 3.0, 0.0]]
    body = pc.SpringNetwork(
        [[0.0, 0.0], [1.0, 0.0]], [[0, 1]], stiffness, mass=[1.0, 2.0], velocities=velocities, strain_limit=LIMIT
    )
    options: Any = {"dt": 1e-3, "integrator": integrator, "precision": precision}
    simulation = pc.Simulation(pc.Scene(body), **options)
    simulation.run(0.05)
    lost = 0.5 * (reduced * SPEED**2 - stiffness * LIMIT**2)
    assert simulation.energy().dissipated == pytest.approx(lost, rel=0.01)
    assert longest_strain(simulation, body) <= LIMIT + 2e-4
    momentum = np.array([1.0, 2.0]) @ simulation.velocities
    rounding = EPSILON if precision == "f64" else 1e-7
    assert np.abs(momentum).max() < 100 * rounding * SPEED
    simulation.run(0.5)
    assert longest_strain(simulation, body) < 0.5 * LIMIT  # the spring pulls it back from there


@pytest.mark.parametrize("integrator", METHODS, ids=IDS)
def test_a_slack_string_does_nothing(integrator: pc.Integrator):
    """A ball thrown within the length of its string flies as without it, to the bit."""

    def flown(**string: Any) -> np.ndarray:
        ball = pc.SpringNetwork(
            [[0.0, 0.0], [0.2, -0.1]], [[0, 1]], 0.0, velocities=[[0.0, 0.0], [1.0, 3.0]], fixed=[0], **string
        )
        simulation = pc.Simulation(pc.Scene(ball, pc.Gravity((0.0, -9.81))), dt=1e-3, integrator=integrator)
        simulation.run(0.5)
        return np.array(simulation.positions)

    np.testing.assert_array_equal(flown(rest_length=1.0, strain_limit=0.0), flown(rest_length=1.0))


def test_a_taut_string_swings_as_a_rod():
    """A pendulum on a string moves as one on a rod, but for terms of order h, and keeps its energy: what the string
    takes from the velocity across it is that of SHAKE, whose energy has an error of order (ω h)² and no trend.
    """
    angle, h = 1.2, 1e-3
    start = [math.sin(angle), -math.cos(angle)]

    def swung(stiffness: float, integrator: pc.Integrator, **string: Any) -> pc.Recording:
        bob = pc.SpringNetwork([[0.0, 0.0], start], [[0, 1]], stiffness, fixed=[0], **string)
        scene = pc.Scene(bob, pc.Gravity((0.0, -9.81)))
        return pc.simulate(scene, duration=10.0, fps=20, integrator=integrator, dt=h)

    string = swung(0.0, pc.VelocityVerlet(), strain_limit=0.0)
    rod = swung(math.inf, pc.RATTLE())
    apart = np.abs(string.positions - rod.positions).max()
    assert apart < 3.0 * 9.81 * h
    energy = string.energy
    assert np.abs(energy.total - energy.total[0]).max() < 3e-3 * 9.81
    lengths = np.linalg.norm(string.positions[:, 1] - string.positions[:, 0], axis=1)
    assert lengths.max() <= 1.0 + 2e-4


@pytest.mark.parametrize("integrator", METHODS, ids=IDS)
def test_a_soft_cloth_stretches_no_further_than_its_limit(integrator: pc.Integrator):
    """Springs of 5 N/m would stretch by half under the weight of ten rows; all of a hanging sheet are at their limits
    together, which leaves less converged: within 1 % of the length.
    """
    cloth = pc.cloth((8, 11), 0.05, 5.0, 0.02, mass=0.003, pinned="top", strain_limit=0.04)
    simulation = pc.Simulation(pc.Scene(cloth, pc.Gravity((0.0, -9.81))), dt=2e-3, integrator=integrator)
    worst = 0.0
    for _ in range(30):
        simulation.run(0.05)
        worst = max(worst, longest_strain(simulation, cloth))
    assert 0.03 < worst < 0.05
    assert np.isfinite(simulation.positions).all()


def test_a_knot_of_strings_and_contacts_holds_both():
    """A net that catches a cloth of one and a half times its weight: nothing passes through, and it stretches by at
    most twice its limit where the load of all hangs on the springs of its corners; the plan says by how much.
    """
    level = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    net = pc.cloth(
        (9, 9), 0.05, 20.0, 0.01, mass=0.002, origin=(0.0, 0.0, 0.0), axes=level, pinned="corners", strain_limit=0.05
    )
    patch = pc.cloth((5, 5), 0.045, 100.0, 0.02, mass=0.01, origin=(0.11, 0.11, 0.03), axes=level)
    touch = pc.SelfContact(net, 0.01, on=patch)
    scene = pc.Scene(net, patch, touch, pc.Gravity((0.0, 0.0, -9.81)))
    simulation = pc.Simulation(scene, dt=2e-3)
    for _ in range(20):
        simulation.run(0.02)
        assert longest_strain(simulation, net) < 0.1
    assert "longer than its longest length" in str(simulation.plan)
    # Above the net everywhere: the lowest of the patch is no lower than the lowest of the net.
    assert simulation[patch].positions[:, 2].min() > simulation[net].positions[:, 2].min()


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: pc.SpringNetwork([[0, 0], [1, 0]], [[0, 1]], np.inf, strain_limit=0.1), "for a rod, which has no"),
        (lambda: pc.SpringNetwork([[0, 0], [1, 0]], [[0, 1]], 1.0, rest_length=0.0, strain_limit=0.1), "length 0"),
        (
            lambda: pc.SpringNetwork([[0, 0], [2, 0]], [[0, 1]], 1.0, rest_length=1.0, strain_limit=0.5),
            "1.5 m long at most",
        ),
        (lambda: pc.rope(3, 1.0, 10.0, strain_limit=-0.1), r"strain_limit.*≥ 0"),
        (lambda: pc.cloth((3, 3), 1.0, 10.0, strain_limit=np.nan), r"strain_limit"),
    ],
)
def test_limits_that_make_no_sense_are_refused(build: Any, message: str):
    with pytest.raises(pc.SceneError, match=message):
        build()


def test_methods_without_impulses_are_refused():
    rope = pc.rope(5, 1.0, 10.0, pinned="start", strain_limit=0.1)
    with pytest.raises(pc.SceneError, match=r"VelocityVerlet.*strain limits"):
        pc.Simulation(pc.Scene(rope, pc.Gravity((0.0, -9.81))), dt=1e-3, integrator=pc.RungeKutta4())
    with pytest.raises(pc.SceneError, match="Periodic"):
        pc.Simulation(pc.Scene(rope, pc.Periodic((-2.0, -2.0), (2.0, 2.0))))


@pytest.mark.parametrize("first", [True, False], ids=["before forces", "after forces"])
def test_plans_have_constraints_in_the_order_of_their_notes(first: bool):
    """Walls, then contacts of meshes, then limits: also where all of them stand before the forces."""
    sheet = pc.cloth((4, 4), 0.1, 100.0, mass=0.01, axes=((1, 0, 0), (0, 1, 0)), strain_limit=0.1)
    scene = pc.Scene(sheet, pc.SelfContact(sheet, 0.01), pc.Floor(-1.0))
    plan = pc.Simulation(scene, pc.VelocityVerlet() if first else pc.BackwardEuler(), dt=1e-3).plan
    held = [stage for stage in plan.stages if stage in ("contacts", "self-contact", "strain limits")]
    assert held == ["contacts", "self-contact", "strain limits"]
    assert (plan.stages[0] == "contacts") == first
    noted = [note.partition(":")[0] for note in plan.notes]
    assert noted.index("self-contact") < noted.index("strain limits")
