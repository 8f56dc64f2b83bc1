"""The diagnosis: each symptom is provoked, and scenes without any are silent."""

from __future__ import annotations

import importlib
import math

import numpy as np
import pytest

import physcore as pc
from physcore.simulation.energy import FAIR_DRIFT, GOOD_DRIFT, verdict

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
    plan = pc.Simulation(stiff, "VelocityVerlet").plan
    assert plan.limit_term == "custom"
    # Velocity Verlet is stable up to ω dt = 2; the stiffness is found by differences, to 1e-4.
    assert plan.dt_limit == pytest.approx(2.0 / FREQUENCY, rel=1e-3)


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
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
        step = float(found["explodes"].cure.split("dt=")[1])
        assert np.abs(pc.simulate(stiff, 2.0, dt=step).energy.drift).max() < 1.1 * FAIR_DRIFT


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
    drifts = (0.0, GOOD_DRIFT, -2.0 * GOOD_DRIFT, FAIR_DRIFT, -2.0 * FAIR_DRIFT, math.nan)
    assert [verdict(drift) for drift in drifts] == ["good"] * 2 + ["fair"] * 2 + ["look at dt"] * 2


@pytest.mark.parametrize(("damping", "creeps"), [(0.2, False), (4.0, False), (20.0, True)])
def test_damping_far_beyond_critical_is_sluggish(damping, creeps):
    net = pc.cloth((6, 5), 0.05, 200.0, damping=damping, mass=0.01, pinned="top")
    # Two masses of 0.01 kg on a spring: ζ = c/(2 √(k m/2)) = c/2.
    found = symptoms(pc.Simulation(pc.Scene(net, pc.Gravity())))
    assert ("sluggish" in found) == creeps
    if creeps:
        assert found["sluggish"].measured == pytest.approx(damping / 2.0)


def test_a_loss_of_the_method_is_sluggish_and_no_explosion():
    swing = pc.Particles([[1.0, 0.0]])
    scene = pc.Scene(swing, pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0))
    found = symptoms(pc.simulate(scene, 6.0, integrator="BackwardEuler", dt=0.1))
    # It shrinks by 1/√(1 + ω² dt²) in each of 60 steps: the energy by 1.01⁻⁶⁰ = 0.55. What is lost is compared with
    # the largest kinetic energy and the range of the potential together, up to twice the energy.
    assert set(found) == {"sluggish"}
    assert 0.5 * (1.0 - 1.01**-60) < found["sluggish"].measured < 1.0 - 1.01**-60
    assert "BackwardEuler" in found["sluggish"].cause


BALL = pc.Particles([[0.0, 0.5]], radius=0.1, name="ball")
BED = pc.Particles(np.column_stack([np.linspace(-1, 1, 11), np.zeros(11)]), radius=0.1, fixed=True, name="bed")


def test_bodies_without_a_force_between_them_penetrate():
    found = symptoms(pc.simulate(pc.Scene(BALL, BED, pc.Gravity()), 0.5))["penetrates"]
    assert "'ball'" in found.cause
    assert "'bed'" in found.cause
    assert "SoftSpheres" in found.cure
    assert 1.0 < found.measured <= 2.0  # Centers that meet overlap by both radii.


@pytest.mark.parametrize(("anchors", "sides"), [((0.0, 0.0), (0.3, 0.25)), ((0.0, 0.3), (-0.3, 0.3))])
def test_networks_that_were_placed_within_each_other_may_be_there(anchors, sides):
    """Two pendulums that hang from one point do not feel each other; two that swing through each other may not know."""
    rods = [
        pc.SpringNetwork([[at, 0.0], [at + side, -1.0]], [[0, 1]], math.inf, radius=[0.0, 0.1], fixed=[0])
        for at, side in zip(anchors, sides, strict=True)
    ]
    found = symptoms(pc.simulate(pc.Scene(*rods, pc.Gravity()), 1.5, integrator=pc.RATTLE(), fps=40))
    assert ("penetrates" in found) == (anchors[0] != anchors[1])


@pytest.mark.parametrize("stiffness", [100.0, 20_000.0])
def test_spheres_that_are_too_soft_penetrate(stiffness):
    recording = pc.simulate(pc.Scene(BALL, BED, pc.SoftSpheres(stiffness), pc.Gravity()), 0.6)
    # The ball falls 0.3 m onto one of the spheres and squeezes it by δ: m g (0.3 + δ) = k δ²/2.
    weight = 9.81
    deepest = (weight + math.sqrt(weight**2 + 0.6 * weight * stiffness)) / stiffness / 0.1
    found = symptoms(recording)
    assert ("penetrates" in found) == (stiffness < 1000.0)
    if "penetrates" in found:
        assert 0.7 * min(deepest, 2.0) < found["penetrates"].measured <= 1.01 * deepest  # a frame is near the deepest
        assert "too soft" in found["penetrates"].cause


def test_a_swarm_and_a_chain_may_overlap_themselves():
    swarm = pc.Particles([[0.0, 1.0], [0.05, 1.0], [0.5, 1.0]], velocities=[[0, 0], [0, 0], [-1, 0]], radius=0.1)
    chain = pc.SpringNetwork([[0.0, 3.0], [0.1, 3.0], [0.2, 3.0]], [[0, 1], [1, 2]], 100.0, radius=0.1)
    assert not symptoms(pc.simulate(pc.Scene(swarm, chain), 0.5))


@pytest.mark.parametrize(("spacing", "coarse"), [(0.15, True), (0.02, False)])
def test_a_ball_comes_through_a_coarse_cloth(spacing, coarse):
    count = round(0.6 / spacing) + 1
    origin, axes = (-0.3, -0.3, 0.12), ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    sheet = pc.cloth((count, count), spacing, 100.0, damping=0.03, mass=0.002, origin=origin, axes=axes, name="sheet")
    scene = pc.Scene(sheet, pc.Gravity(), pc.Sphere((0.02, 0.01, 0.0), radius=0.1, restitution=0.0, friction=0.5))
    found = symptoms(pc.simulate(scene, 0.4))
    assert ("penetrates" in found) == coarse
    if coarse:
        assert "Sphere" in found["penetrates"].cause
        assert "'sheet'" in found["penetrates"].cause


@pytest.mark.parametrize(("damping", "trembles"), [(0.0, True), (0.3, False)])
def test_a_cloth_without_damping_jitters(damping, trembles):
    cloth = pc.cloth((16, 12), 0.05, 200.0, damping=damping, mass=0.004, pinned="top")
    found = symptoms(pc.simulate(pc.Scene(cloth, pc.Gravity()), 3.0))
    assert ("jitters" in found) == trembles
    if trembles:
        assert 0.25 < found["jitters"].measured <= 1.0
        assert given_damping(found["jitters"]) < 0.35


def given_damping(finding: pc.Finding) -> float:
    """The damping that a cure names."""
    return float(finding.cure.split("damping=")[1].split()[0])


@pytest.mark.parametrize(("damping", "windy"), [(0.0, False), (0.01, False), (0.0, True)])
def test_the_damping_that_a_cure_names_is_enough(damping, windy):
    """For a curtain that hangs, and for one in the wind, which keeps it in motion."""

    def curtain(damping: float) -> pc.Scene:
        if not windy:
            return pc.Scene(pc.cloth((16, 12), 0.05, 200.0, damping, mass=0.004, pinned="top"), pc.Gravity())
        slope = ((1.0, 0.0, 0.0), (0.0, 0.6, 0.8))
        sheet = pc.cloth((14, 10), 0.05, 400.0, damping, mass=0.002, origin=(0.0, 0.0, 0.0), axes=slope, pinned="top")
        return pc.Scene(sheet, pc.Gravity(), pc.Wind((0.0, 5.0, 0.0)))

    def found(damping: float) -> dict[str, pc.Finding]:
        return symptoms(pc.simulate(curtain(damping), 3.0, fps=24 if windy else 30))

    assert "jitters" not in found(given_damping(found(damping)["jitters"]))


@pytest.mark.parametrize(("spacing", "symptom"), [(0.03, "clumps"), (0.02, None), (0.0145, "scatters")])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_fluid_that_is_not_at_its_spacing_clumps_or_scatters(spacing, symptom, dimension):
    places = pc.block((0.0,) * dimension, (0.2,) * dimension, 0.02)
    shaken = places + np.random.default_rng(1).uniform(-0.002, 0.002, places.shape)
    # Shaken by a tenth, distances grow by (D − 1) (0.1²/3), a percent, and at the rim some nearest ones are others.
    for positions, tolerance in ((places, 1e-9), (shaken, 0.05)):
        scene = pc.Scene(pc.Fluid(positions, spacing, name="water"))
        simulation = pc.Simulation(scene, fluids=pc.WeaklyCompressible(sound_speed=10.0))
        found = symptoms(simulation)
        assert set(found) == ({symptom} if symptom else set())
        if symptom:
            assert found[symptom].measured == pytest.approx(spacing / 0.02, rel=tolerance)
            assert "spacing" in found[symptom].cure


@pytest.mark.filterwarnings("ignore:.*pages load a GIF above 5 MB slowly")
def test_a_film_that_would_be_too_large_is_told_and_its_size_is_known(tmp_path):
    rng = np.random.default_rng(1)
    dust = pc.Particles(rng.uniform(-1, 1, (10_000, 2)), velocities=rng.normal(0, 1, (10_000, 2)))
    recording = pc.simulate(pc.Scene(dust, pc.Box((-1, -1), (1, 1))), 4.0)
    found = symptoms(recording)
    size = pc.film(recording, tmp_path / "dust.gif").path.stat().st_size
    # Near colors save a fifth to a half of what is estimated to a tenth.
    assert 0.5 * 0.9 < size / found["large"].measured < 0.8 * 1.1


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("rope", 0.5),
        ("jelly", 0.5),
        ("orbits", 1),
        ("pendulums", 0.2),
        ("galaxy", 0.1),
        ("drape", 0.3),
        ("folds", 0.2),
        ("splash", 0.02),
        ("lava", 0.02),
        ("dam_break", 0.02),
        ("crystal", 0.05),
        ("collision", 0.02),
        ("chain", 0.3),
        ("solar_system", 0.1),
        ("penning_trap", 0.1),
        ("dipole", 0.5),
        ("double_pendulum", 0.2),
        ("string", 0.3),
    ],
)
def test_demos_are_well(name, part):
    shown = importlib.import_module(f"physcore.gallery.{name}")
    duration = part * shown.DURATION
    recording = pc.simulate(shown.scene(), duration, fps=40 / duration)
    assert pc.diagnose(recording) == ()
