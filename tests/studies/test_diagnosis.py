"""The diagnosis: each symptom is provoked, and scenes without any are silent."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc
from physcore.simulation.energy import GOOD_DRIFT, verdict

STIFFNESS = 1e4
"""[N/m]"""
FREQUENCY = math.sqrt(STIFFNESS)
"""ω of a particle of 1 kg [rad/s]."""


def symptoms(what, **options):
    findings = pc.diagnose(what, **options)
    for finding in findings:
        assert finding.cause
        assert finding.cure
        assert math.isfinite(finding.measured)
        assert finding.symptom in str(findings)
        assert finding.cure in findings._repr_html_().replace("&quot;", '"')
    return {finding.symptom: finding for finding in findings}


@pytest.fixture
def stiff():
    force = pc.CustomForce(lambda time, x, v: -STIFFNESS * x, potential=lambda x: 0.5 * STIFFNESS * (x**2).sum())
    return pc.Scene(pc.Particles([[0.1, 0.0]]), force)


@pytest.fixture
def atoms():
    return pc.Scene(pc.Particles([[0.0, 0.0], [0.1, 0.0]]), pc.LennardJones(epsilon=1.0, sigma=1.0, cutoff=2.5))


def test_an_orbit_is_well():
    planet = pc.Particles([[1.0, 0.0]], velocities=[[0.0, 1.0]])
    scene = pc.Scene(planet, pc.CentralForce((0.0, 0.0), 1.0, exponent=-2.0))
    found = pc.diagnose(pc.simulate(scene, 6.0))
    assert found == ()
    assert str(found) == "nothing wrong was found" in found._repr_html_()
    assert pc.diagnose(pc.Simulation(scene), duration=6.0) == ()


def test_the_automatic_step_of_a_function_is_below_its_limit(stiff):
    plan = pc.Simulation(stiff).plan
    assert plan.limit_term == "custom"
    # Velocity Verlet is stable up to ω dt = 2; the stiffness is found by differences, to 1e-4.
    assert plan.dt_limit == pytest.approx(2.0 / FREQUENCY, rel=1e-3)


@pytest.mark.parametrize("part", [0.25, 0.5, 0.95])
def test_a_drift_that_is_seen_explodes(stiff, part):
    # Verlet keeps ½v² + ½ω²(1 − (ω dt/2)²)x² exactly, so that the energy of an oscillation varies by (ω dt/2)² of
    # itself; with a share s of the limit that is s². The drift compares it with the largest kinetic energy and the
    # range of the potential together, each of which is about the energy: between a half of s² and s².
    recording = pc.simulate(stiff, 2.0, dt=part * 2.0 / FREQUENCY)
    drift = np.abs(recording.energy.drift).max()
    assert 0.45 * part**2 < drift < 1.05 * part**2
    found = symptoms(recording)
    assert ("explodes" in found) == (drift > 0.05)
    if "explodes" in found:
        assert found["explodes"].measured == drift
        step = float(found["explodes"].cure.split("dt=")[1].split(",")[0])
        assert np.abs(pc.simulate(stiff, 2.0, dt=step).energy.drift).max() < 1.1 * GOOD_DRIFT


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
def test_a_step_above_the_limit_is_told_before(stiff):
    found = symptoms(pc.Simulation(stiff, dt=3.0 / FREQUENCY))
    assert found["explodes"].measured == pytest.approx(1.5, rel=1e-3)
    assert not symptoms(pc.Simulation(stiff, dt=0.2 / FREQUENCY))


def test_two_atoms_within_each_other_are_slow(atoms):
    simulation = pc.Simulation(atoms)
    before = simulation.state_hash()
    found = symptoms(simulation, duration=1.0)["slow"]
    assert found.measured == math.ceil(1.0 / simulation.dt) > 1e8
    assert "Lennard-Jones" in found.cause
    assert "move apart" in found.cure
    assert (simulation.steps, simulation.state_hash()) == (0, before)
    assert not symptoms(simulation)  # Nobody said how long.


def test_what_is_no_run_is_refused(atoms):
    with pytest.raises(pc.SceneError, match=r"diagnose.run: .*write pc.diagnose\(pc.Simulation\(scene\)\)"):
        pc.diagnose(atoms)
    with pytest.raises(pc.SceneError, match=r"diagnose.duration: "):
        pc.diagnose(pc.Simulation(atoms), duration=-1.0)


def test_the_drift_has_a_verdict():
    assert [verdict(drift) for drift in (0.0, GOOD_DRIFT, -2.0 * GOOD_DRIFT, math.nan)] == ["good"] * 2 + [
        "look at dt"
    ] * 2
