"""Springs that break: when they do, what they take with them, and that every method and every restart agrees."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import EPSILON

METHODS: list[pc.Integrator] = [
    pc.VelocityVerlet(),
    pc.SemiImplicitEuler(),
    pc.RungeKutta4(),
    pc.RATTLE(),
    pc.BackwardEuler(),
    pc.ImplicitMidpoint(),
    pc.BDF2(),
    pc.XPBD(4, 2),
    pc.ProjectiveDynamics(8),
]
STIFFNESS, BREAKING, SPEED = 500.0, 0.1, 4.0


def pair(**more: Any) -> pc.SpringNetwork:
    """Two masses of 1 and 2 kg that fly apart; their spring is at rest."""
    values = {"mass": [1.0, 2.0], "velocities": [[-2.0 / 3.0 * SPEED, 0.0], [SPEED / 3.0, 0.0]], **more}
    return pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], STIFFNESS, breaking_strain=BREAKING, **values)


def net(**more: Any) -> pc.SpringNetwork:
    """A sheet in the plane that is pulled apart at its upper and its lower edge, each spring with its own strength."""
    cloth = pc.cloth((7, 9), 0.1, 200.0, 0.02, mass=0.01)
    strain = np.random.default_rng(3).uniform(0.05, 0.15, len(cloth.pairs))
    velocities = np.zeros_like(cloth.positions)
    velocities[:, 1] = 12.0 * (cloth.positions[:, 1] - 0.4)
    return pc.SpringNetwork(
        cloth.positions,
        cloth.pairs,
        cloth.stiffness,
        cloth.damping,
        cloth.rest_length,
        cloth.mass,
        velocities=velocities,
        breaking_strain=strain,
        **more,
    )


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("integrator", METHODS, ids=lambda method: type(method).__name__)
def test_a_spring_breaks_at_its_strain_and_takes_its_energy(integrator: pc.Integrator, precision: str):
    """The energy at the first step beyond s L is ½ k (s L)² or more, by at most what a step of SPEED h adds: with
    h = 1e-4 a part of 2 SPEED h/(s L) = 8e-3. Methods of order 1 have lost less than that before.
    """
    body = pair()
    options: Any = {"dt": 1e-4, "integrator": integrator, "precision": precision}
    simulation = pc.Simulation(pc.Scene(body), **options)
    simulation.run(0.02)
    assert not simulation[body].broken.any()
    assert simulation.energy().dissipated == 0.0
    simulation.run(0.5)
    assert simulation[body].broken.all()
    energy = simulation.energy()
    stored = 0.5 * STIFFNESS * BREAKING**2
    assert 1.0 - 1e-6 <= energy.dissipated_by["tearing"] / stored <= 1.0 + 8e-3
    rounding = EPSILON if precision == "f64" else 1e-7
    assert np.abs(simulation.momentum()).max() < 1e4 * rounding
    # It is gone: they fly apart for ever at the speed of the energy that is left.
    speed = np.ptp(simulation.velocities[:, 0])
    assert speed == pytest.approx(np.sqrt(SPEED**2 - 2.0 * stored / (2.0 / 3.0)), rel=0.01)
    before = simulation.velocities
    simulation.run(0.1)
    assert np.abs(simulation.velocities - before).max() < 10.0 * rounding * SPEED


def test_the_budget_closes_while_a_sheet_tears_and_better_with_shorter_steps():
    """A broken spring's energy is that at the end of a step, so that the error of the balance is the method's own."""
    drifts = []
    for dt in (2e-3, 1e-3, 5e-4):
        recording = pc.simulate(pc.Scene(net()), 0.3, fps=100, dt=dt)
        broken = recording[0].broken
        assert broken[-1].sum() > 30
        assert not broken[0].any()
        assert (broken[1:] | ~broken[:-1]).all()
        assert (np.diff(recording.energy.dissipated) >= 0.0).all()
        assert np.abs(recording.momentum).max() < 1e3 * EPSILON
        drifts.append(np.abs(recording.energy.drift).max())
    # Verlet's error is of order 2 between breaks: four times less at half the step, of which three are asked.
    assert drifts[0] < 3e-2
    assert drifts[2] < drifts[0] / 6.0


def test_what_does_not_break_moves_with_the_same_bits():
    strong = pc.SpringNetwork([[0.0, 0.0], [1.1, 0.0]], [[0, 1]], 50.0, rest_length=1.0)
    weak = pc.SpringNetwork([[0.0, 0.0], [1.1, 0.0]], [[0, 1]], 50.0, rest_length=1.0, breaking_strain=0.2)
    runs = [pc.simulate(pc.Scene(body), 2.0, dt=1e-3) for body in (strong, weak)]
    assert (runs[0].positions == runs[1].positions).all()
    assert (runs[0].velocities == runs[1].velocities).all()
    assert not runs[1][weak].broken.any()


@pytest.mark.parametrize("integrator", METHODS, ids=lambda method: type(method).__name__)
def test_a_checkpoint_knows_what_is_broken(integrator: pc.Integrator, tmp_path: Any):
    simulation = pc.Simulation(pc.Scene(net()), dt=1e-3, integrator=integrator)
    simulation.run(0.1)
    assert 0 < simulation[0].broken.sum() < len(net().pairs)
    simulation.save(tmp_path / "torn.npz")
    simulation.run(0.1)
    other = pc.load(tmp_path / "torn.npz")
    other.run(0.1)
    assert other.state_hash() == simulation.state_hash()
    assert (other[0].broken == simulation[0].broken).all()
    assert vars(other.energy()) == vars(simulation.energy())


def test_a_broken_spring_has_no_tension():
    body = pc.SpringNetwork(
        [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]],
        [[0, 1], [1, 2]],
        [np.inf, 100.0],
        velocities=[[0.0, 0.0], [0.0, 0.0], [3.0, 0.0]],
        fixed=[0],
        breaking_strain=[np.inf, 0.1],
    )
    recording = pc.simulate(pc.Scene(body), 0.3, fps=50, dt=1e-3)
    broken, tensions = recording[body].broken, recording[body].tensions
    assert broken[-1].tolist() == [False, True]
    assert tensions[-1, 1] == 0.0
    assert tensions[~broken[:, 1], 1].max() > 5.0


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (lambda: pc.SpringNetwork([[0, 0], [1, 0]], [[0, 1]], np.inf, breaking_strain=0.1), "for a rod, which has no"),
        (lambda: pc.SpringNetwork([[0, 0], [1, 0]], [[0, 1]], 1.0, rest_length=0.0, breaking_strain=0.1), "length 0"),
        (lambda: pc.rope(3, 1.0, 10.0, breaking_strain=-0.1), r"breaking_strain.*≥ 0"),
        (lambda: pc.cloth((3, 3), 1.0, 10.0, breaking_strain=np.nan), r"breaking_strain"),
    ],
)
def test_bad_strains_are_refused(body: Any, message: str):
    with pytest.raises(pc.SceneError, match=message):
        body()


def test_a_method_of_smooth_motion_refuses_what_breaks():
    with pytest.raises(pc.SceneError, match=r"integrator.*springs that break"):
        pc.Simulation(pc.Scene(net()), dt=1e-3, integrator=pc.GaussRadau15())


def test_a_scene_without_weak_springs_has_no_such_field():
    simulation = pc.Simulation(pc.Scene(pc.rope(3, 1.0, 10.0)))
    with pytest.raises(pc.SceneError, match="only networks with a breaking_strain have"):
        _ = simulation[0].broken


def test_films_leave_out_what_is_broken(tmp_path: Any):
    """Frames with all springs broken are bare, whatever the style."""
    cloth = pc.cloth(
        (4, 4), 0.1, 50.0, breaking_strain=0.01, velocities=[[8.0 * (k % 4), 8.0 * (k // 4)] for k in range(16)]
    )
    recording = pc.simulate(pc.Scene(cloth), 0.04, fps=50, dt=1e-3)
    assert recording[cloth].broken[-1].all()
    for style in (pc.styles.Strain(), pc.styles.Surface(), pc.styles.Surface("strain")):
        pc.film(recording, tmp_path / "torn.gif", style=style, size=(160, 120))


def test_the_bending_of_torn_faces_is_dissipated_with_them():
    """A sheet that bends as it is torn apart: hinges at torn faces are gone, and the balance keeps their energy.

    Verlet keeps the balance to (ω dt)², some 1e-5; left out, the energy of bending would be missing, up to a fifth.
    """
    flat = pc.cloth((6, 5), 0.1, 200.0, mass=0.01, origin=(0.0, 0.0, 0.0), breaking_strain=0.02)
    middle = flat.positions.mean(axis=0)
    velocities = 3.0 * (flat.positions - middle)
    velocities[:, 2] = 4.0 * np.cos(40.0 * flat.positions[:, 0])
    sheet = pc.SpringNetwork(
        flat.positions,
        flat.pairs,
        flat.stiffness,
        mass=flat.mass,
        velocities=velocities,
        faces=flat.faces,
        breaking_strain=flat.breaking_strain,
    )
    simulation = pc.Simulation(pc.Scene(sheet, pc.Dihedral(sheet, 1.0)), dt=2e-5)
    start, bent = simulation.energy().balance, 0.0
    for _ in range(100):
        simulation.step(20)
        bent = max(bent, simulation.energy().by_term["dihedral"])
    assert simulation[sheet].broken.mean() > 0.5
    assert bent > 0.1 * start
    assert simulation.energy().by_term["dihedral"] < 0.5 * bent
    assert simulation.energy().balance == pytest.approx(start, rel=1e-3)
