"""A step that fails can be taken again in parts: counted, warned of, the same bits however it was asked for."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import physcore as pc
from physcore.studies.audit import audit

DT = 0.02


def meeting(speed: float = 6.0) -> pc.Scene:
    """Two atoms that fly at each other: steps of 0.02 s resolve their orbits, but not so fast a collision."""
    atoms = pc.Particles([[-2.0, 0.0], [2.0, 0.0]], velocities=[[speed, 0.0], [-speed, 0.0]])
    return pc.Scene(atoms, pc.LennardJones(epsilon=1.0, sigma=1.0))


def run(scene: pc.Scene, **numerics) -> pc.Simulation:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pc.StabilityWarning)
        return pc.Simulation(scene, **{"dt": DT, "on_divergence": "substep", **numerics})


def test_a_collision_that_is_too_fast_for_the_step_is_taken_in_parts():
    """The same step without it throws the atoms apart with many times their energy."""
    with pytest.raises(pc.SimulationDiverged):
        run(meeting(), on_divergence="raise", max_energy_growth=1.0).step(100)
    simulation = run(meeting())
    energy = simulation.energy().total
    with pytest.warns(pc.StabilityWarning, match="a step failed .* and is taken again in parts"):
        simulation.step(100)
    assert simulation.substeps >= 1
    assert simulation.steps > 100
    assert simulation.time == pytest.approx(100 * DT, rel=1e-12)
    # Within what the watch lets pass: the balance rose by less than the largest energy so far.
    assert simulation.energy().total < 2.0 * energy
    assert simulation.plan.substeps == simulation.substeps
    assert "taken again in parts" in str(simulation.plan)


@pytest.mark.parametrize(
    ("integrator", "dt", "cause"),
    [
        (pc.VelocityVerlet(), pc.AdaptiveStep(), "safety"),
        (pc.BogackiShampine3(), pc.AdaptiveStep(tolerance=0.1), "tolerance"),
    ],
    ids=["safety", "tolerance"],
)
def test_a_step_that_follows_the_motion_into_a_collision_is_halved_and_says_so_once(integrator, dt, cause):
    """At 100 m/s the atoms are within each other before the step's ends can tell that they are near."""
    simulation = run(meeting(100.0), integrator=integrator, dt=dt)
    start, energy = (simulation.positions, simulation.velocities), simulation.energy().total
    with pytest.warns(pc.StabilityWarning, match=f"diverged and was halved: take a smaller {cause}") as warned:
        simulation.run(0.1)
    assert len(warned) == 1
    assert simulation.substeps == simulation.plan.substeps >= 1
    assert simulation.time == pytest.approx(0.1, rel=1e-12)
    assert simulation.energy().total < 2.0 * energy
    once = simulation.substeps
    simulation.set(*start)
    simulation.run(0.1)
    # The controller of errors remembers the collision, and comes to the next one with smaller steps.
    assert simulation.substeps > once or cause == "tolerance"


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
@pytest.mark.parametrize("dt", [DT, pc.AutoStep(safety=1.0)])
def test_the_bits_do_not_depend_on_how_the_steps_were_asked_for(dt, tmp_path: Path):
    whole, single = run(meeting(), dt=dt), run(meeting(), dt=dt)
    whole.step(700)
    for _ in range(350):
        single.step(1)
    single.save(tmp_path / "half")
    resumed = pc.load(tmp_path / "half")
    assert isinstance(resumed, pc.Simulation)
    assert resumed.substeps == single.substeps
    resumed.step(350)
    assert resumed.state_hash() == whole.state_hash()
    assert resumed.substeps == whole.substeps


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
def test_frames_stay_at_their_times_and_the_audit_counts():
    simulation = run(meeting())
    recording = simulation.record(2.0, fps=25)
    assert np.allclose(recording.times, np.arange(51) / 25)
    assert recording.plan.substeps == simulation.substeps >= 1
    assert f"substeps: {simulation.substeps} steps failed" in audit(recording)


def test_where_nothing_fails_nothing_changes():
    calm, plain = run(meeting(0.5)), run(meeting(0.5), on_divergence="raise")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        calm.step(500)
    plain.step(500)
    assert calm.substeps == 0
    assert calm.state_hash() == plain.state_hash()


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
def test_what_fails_in_the_smallest_parts_too_is_told():
    """A million times the limit of a spring: a thousandth of that is past all bounds as well."""
    spring = pc.SpringNetwork([[0.0, 0.0], [1.1, 0.0]], [[0, 1]], 1e12, rest_length=1.0)
    simulation = run(pc.Scene(spring), dt=1.0)
    with pytest.raises(pc.SimulationDiverged) as caught:
        simulation.step(1000)
    assert caught.value.last_good is not None
    assert np.isfinite(simulation.positions).all()
