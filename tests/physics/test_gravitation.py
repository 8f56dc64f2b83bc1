"""Gravitation and Coulomb's law: the sums of their formulas, the orbits of Kepler, and the laws of conservation."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import EPSILON, Array, simulation

pytestmark = pytest.mark.filterwarnings("ignore::physcore.SceneWarning")  # masses that have charges too
EPSILONS = {"f64": EPSILON, "f32": float(np.finfo(np.float32).eps)}
RUN = 256
"""Terms that the engine sums in the precision of the run."""


def points(count: int, dimension: int, seed: int = 1) -> Array:
    """Different points on a lattice of 2⁻⁹ m within 2 m, which f32 holds exactly."""
    cells = 1024
    numbers = np.random.default_rng(seed).choice(cells**dimension, count, replace=False)
    return np.stack([numbers // cells**axis % cells for axis in range(dimension)], axis=1) / 512.0 - 1.0


def pulls(targets: Array, sources: Array, charges: Array, softening: float) -> Array:
    """The terms c d/s³ toward each source (N, M, D), 0 at zero distance."""
    d = sources[None] - targets[:, None]
    square = (d**2).sum(axis=2)
    s = np.sqrt(square + softening**2)
    return np.where(square > 0.0, charges / np.where(square > 0.0, s, 1.0) ** 3, 0.0)[..., None] * d


def potential(positions: Array, charges: Array, softening: float) -> float:
    """Σ cᵢcⱼ/s over all pairs."""
    d = positions[None] - positions[:, None]
    s = np.sqrt((d**2).sum(axis=2) + softening**2)
    upper = np.triu_indices(len(positions), 1)
    return float((np.outer(charges, charges)[upper] / s[upper]).sum())


def kick(scene: pc.Scene, **numerics: object) -> Array:
    """The accelerations of particles at rest: an explicit step of 1 s changes v by exactly a."""
    run = simulation(scene, pc.ExplicitEuler(), 1.0, on_divergence="ignore", **numerics)
    run.step(1)
    return run.velocities


@pytest.mark.parametrize("softening", [0.0, 0.05])
@pytest.mark.parametrize("count", [1, 2, 65, 300])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("precision", EPSILONS)
def test_forces_and_energies_are_the_sums_over_all_pairs(precision, dimension, count, softening):
    """A term is off by up to 10 ε (three squares and their sum, root, quotient, four products), a sum by ε per term."""
    x, rng = points(count, dimension), np.random.default_rng(2)
    mass, charge = rng.uniform(0.5, 2.0, count), rng.uniform(-1.0, 1.0, count)
    for law, c, sign in [(pc.Gravitation(1.5, softening), mass, 1.5), (pc.Coulomb(0.7, softening), charge, -0.7)]:
        scene = pc.Scene(pc.Particles(x, mass=mass, charge=charge), law)
        terms = sign * (c / mass)[:, None, None] * pulls(x, x, c, softening)
        allowed = (12.0 + min(count, RUN)) * EPSILONS[precision] * np.abs(terms).sum(axis=1)
        found = kick(scene, precision=precision)
        assert (np.abs(found - terms.sum(axis=1)) <= allowed).all()
        run = simulation(scene, pc.VelocityVerlet(), 1.0, precision=precision)
        energy = -sign * potential(x, c, softening)
        # In double precision whatever that of the run, but for the pair of each particle with itself, which cancels.
        itself = abs(sign) * (c**2).sum() / softening if softening else 0.0
        scale = abs(sign) * potential(x, np.abs(c), softening) + itself
        assert run.energy().potential == pytest.approx(energy, rel=0.0, abs=(20.0 + count) * EPSILON * scale)


def test_single_precision_sums_as_well_as_double():
    """10⁵ sources: terms are rounded at random, by ε √10⁵ of one; a plain sum in f32 would be off by 10⁻⁴."""
    sources = pc.Particles(points(100_000, 3), mass=np.random.default_rng(3).uniform(0.5, 1.5, 100_000))
    targets = pc.Particles(points(64, 3, seed=5) + 2.0**-10)
    scene = pc.Scene(sources, targets, pc.Gravitation(1.0, 2.0**-6, on=targets, sources=sources))
    one, other = (kick(scene, precision=precision)[len(sources) :] for precision in ("f32", "f64"))
    exact = pulls(targets.positions[:4], sources.positions, sources.mass, 2.0**-6).sum(axis=1)
    np.testing.assert_allclose(other[:4], exact, rtol=1e-12, atol=1e-12 * np.abs(exact).max())
    assert np.sqrt(((one - other) ** 2).sum() / (other**2).sum()) < 1e-6


def test_a_shell_pulls_from_its_center_outside_and_not_inside():
    """Newton's theorem, with the shell as a product rule of Gauss and equal angles, exact up to the degree 47.

    Inside at r = 0.3 its field is one of degree 48 and more: 0.3⁴⁷. Rounding: the sum of 1152 terms of 1 m/s² together.
    """
    z, weights = np.polynomial.legendre.leggauss(24)
    angle = 2.0 * np.pi * np.arange(48) / 48
    radius = np.sqrt(1.0 - z**2)
    shell = np.stack(
        [np.outer(radius, np.cos(angle)), np.outer(radius, np.sin(angle)), np.outer(z, np.ones(48))], axis=2
    )
    walls = pc.Particles(shell.reshape(-1, 3), mass=np.repeat(weights / 96.0, 48))
    directions = np.array([[0.6, 0.0, 0.8], [0.0, -1.0, 0.0], [0.48, 0.6, -0.64]])
    probes = pc.Particles(np.concatenate([0.3 * directions, 4.0 * directions]))
    felt = kick(pc.Scene(walls, probes, pc.Gravitation(1.0, on=probes, sources=walls)))[len(walls) :]
    assert np.abs(felt[:3]).max() < 1e-14
    np.testing.assert_allclose(felt[3:], -directions / 16.0, rtol=0.0, atol=1e-14)


ECCENTRICITY, MASSES = 0.5, np.array([1.0, 0.3])
PERIOD = 2.0 * np.pi / np.sqrt(MASSES.sum())
"""Of the semi-major axis 1 with G = 1."""


def pair(eccentricity: float = ECCENTRICITY, softening: float = 0.0) -> pc.Scene:
    """Two bodies about their center of mass at rest, at periapsis."""
    near, mass = 1.0 - eccentricity, MASSES.sum()
    speed = np.sqrt(mass * (1.0 + eccentricity) / near)
    share = np.array([[-MASSES[1]], [MASSES[0]]]) / mass
    bodies = pc.Particles(share * (near, 0.0), share * (0.0, speed), mass=MASSES)
    return pc.Scene(bodies, pc.Gravitation(1.0, softening))


def test_two_bodies_close_their_ellipse_in_the_period_of_kepler():
    """Back at the start, neither early nor turned; the error falls with the order of the method, here 6."""
    scene, missed = pair(), []
    for steps in (250, 500):
        run = simulation(scene, pc.BlanesMoan6(), PERIOD / steps)
        run.step(steps)
        missed.append(np.abs(run.positions - scene.bodies[0].positions).max())
    assert missed[0] / missed[1] == pytest.approx(2.0**6, rel=0.3)
    assert missed[1] < 1e-8


def test_an_attractor_that_is_fixed_is_as_heavy_as_it_is_said_to_be():
    sun = pc.Particles([[0.0, 0.0]], mass=2.0, fixed=[0])
    planet = pc.Particles([[1.0, 0.0]], [[0.0, np.sqrt(2.0)]], mass=1e-3)
    period = 2.0 * np.pi / np.sqrt(2.0)
    run = simulation(pc.Scene(sun, planet, pc.Gravitation(1.0)), pc.BlanesMoan6(), period / 200)
    run.step(200)
    np.testing.assert_allclose(run.positions, [[0.0, 0.0], [1.0, 0.0]], rtol=0.0, atol=1e-9)


def test_charges_of_one_sign_part_and_of_two_meet():
    for charges, sign in [((2.0, 3.0), 1.0), ((-2.0, -3.0), 1.0), ((2.0, -3.0), -1.0)]:
        felt = kick(pc.Scene(pc.Particles([[0.0, 0.0], [2.0, 0.0]], charge=charges), pc.Coulomb(1.0)))
        np.testing.assert_array_equal(felt, sign * np.array([[-1.5, 0.0], [1.5, 0.0]]))


@pytest.mark.parametrize("precision", EPSILONS)
@pytest.mark.parametrize("law", [pc.Gravitation(1.0, 0.1), pc.Coulomb(1.0, 0.1)], ids=["gravitation", "coulomb"])
def test_momentum_and_angular_momentum_are_kept_to_rounding(law, precision):
    """Of a velocity m ε v a step, and of a force ε Σ|F| dt; each has an arm of at most the extent of the cloud."""
    rng, count, steps, dt = np.random.default_rng(4), 60, 100, 0.01
    charge = rng.uniform(-0.3, 0.3, count)
    cloud = pc.Particles(
        points(count, 3), rng.uniform(-0.5, 0.5, (count, 3)), mass=rng.uniform(0.5, 1.5, count) / count, charge=charge
    )
    run = simulation(pc.Scene(cloud, law), pc.VelocityVerlet(), dt, precision=precision)
    before = run.momentum(), run.angular_momentum()
    run.step(steps)
    c = cloud.mass if isinstance(law, pc.Gravitation) else charge
    forces = np.abs(c[:, None, None] * pulls(run.positions, run.positions, c, 0.1)).sum()
    speed = np.abs(run.velocities).max()
    rounding = steps * EPSILONS[precision] * (12.0 * 2.0 * dt * forces + 2.0 * cloud.mass.sum() * speed)
    extent = np.abs(run.positions).max()
    assert np.abs(run.momentum() - before[0]).max() <= rounding
    assert np.abs(run.angular_momentum() - before[1]).max() <= 4.0 * (extent + speed) * rounding


def test_single_precision_covers_the_solar_system_in_si_units():
    """The cube of its distances, 10³⁸ m³ and more, is beyond f32."""
    distance, year = pc.units.AU, pc.units.year
    places = np.array([[0.0, 0.0, 0.0], [distance, 0.0, 0.0], [0.0, 30.07 * distance, 0.0]])
    mass = [pc.units.solar_mass, pc.units.earth_mass, 1.02e26]
    scene = pc.Scene(pc.Particles(places, mass=mass), pc.Gravitation())
    one, other = (kick(scene, precision=precision) for precision in ("f32", "f64"))
    np.testing.assert_allclose(one, other, rtol=1e-5, atol=1e-12)
    assert -other[1, 0] == pytest.approx(4.0 * np.pi**2 * distance / year**2, rel=1e-4)  # an orbit of a year


def test_the_work_of_one_sided_sources_closes_the_budget():
    """Comets that feel a pair of stars and do not pull them; the balance errs like dt², as the energy of the pair."""
    stars = pair().bodies[0]
    comet = pc.Particles([[1.5, 1.0], [-2.0, 0.5]], [[-0.3, 0.4], [0.3, -0.6]], mass=0.1)
    scene = pc.Scene(stars, comet, pc.Gravitation(1.0, 0.05, sources=stars))
    drifts = []
    for steps in (1000, 2000):
        run = simulation(scene, pc.VelocityVerlet(), PERIOD / steps)
        start = run.energy()
        run.step(steps)
        end = run.energy()
        drifts.append((end.total - end.work) - (start.total - start.work))
    assert abs(drifts[1]) < 3e-3 * abs(end.work - start.work)
    assert drifts[0] / drifts[1] == pytest.approx(4.0, rel=0.2)
    alone = simulation(pc.Scene(stars, pc.Gravitation(1.0, 0.05)), pc.VelocityVerlet(), PERIOD / 2000)
    alone.step(2000)
    np.testing.assert_array_equal(run.positions[:2], alone.positions)


@pytest.mark.parametrize("softening", [0.0, 0.3])
def test_the_automatic_step_is_a_hundredth_of_the_period(softening):
    """On a circle with ω² = G M/s³; softened alike."""
    mass, s3 = MASSES.sum(), (1.0 + softening**2) ** 1.5
    share = np.array([[-MASSES[1]], [MASSES[0]]]) / mass
    speed = np.sqrt(mass / s3)
    scene = pc.Scene(
        pc.Particles(share * (1.0, 0.0), share * (0.0, speed), mass=MASSES), pc.Gravitation(1.0, softening)
    )
    run = pc.Simulation(scene)
    limit = run.plan
    assert (limit.limit_term, limit.limit_kind) == ("gravitation", "accuracy")
    assert limit.dt_limit == pytest.approx(2.0 * np.pi * np.sqrt(s3 / mass) / 100.0, rel=1e-12)


def test_adaptive_steps_follow_an_encounter():
    """At e = 0.9 the period of the periapsis is √1000 times shorter than at the mean distance."""
    period, scene = PERIOD, pair(0.9)
    run = pc.Simulation(scene, dt=pc.AdaptiveStep())
    before = run.energy().total
    run.run(period)
    assert run.steps > 300
    assert run.energy().total == pytest.approx(before, rel=0.05)
    assert np.abs(run.energy().total - before) < 0.05 * abs(before)


def test_coincident_particles_are_named_where_there_is_no_softening():
    places = np.concatenate([points(70, 2), [[0.3, 0.4]], [[0.3, 0.4]]])
    with pytest.raises(pc.SceneError, match=r"forces\[0\].*particles 70 and 71 both at \[0.3, 0.4\] m.*softening"):
        simulation(pc.Scene(pc.Particles(places), pc.Gravitation(1.0)), pc.VelocityVerlet(), 0.01).step(1)
    felt = kick(pc.Scene(pc.Particles(places), pc.Gravitation(1.0, 0.1)))
    np.testing.assert_array_equal(felt[70], felt[71])


def test_a_periodic_domain_is_refused():
    cloud, domain = pc.Particles(points(3, 2)), pc.Periodic((-2.0, -2.0), (2.0, 2.0))
    for law in (pc.Gravitation(1.0), pc.Coulomb(1.0)):
        with pytest.raises(pc.SceneError, match=r"forces\[0\].*without a Periodic domain"):
            pc.Simulation(pc.Scene(cloud, law, domain), dt=0.01)


def test_sources_are_bodies_of_the_scene():
    cloud, stranger = pc.Particles(points(3, 2)), pc.Particles([[5.0, 5.0]])
    with pytest.raises(pc.SceneError, match=r"forces\[0\]\.sources.*not in the scene"):
        pc.Scene(cloud, pc.Gravitation(1.0, sources=stranger))
    with pytest.raises(pc.SceneError, match=r"Coulomb\.sources: must be a body"):
        pc.Coulomb(1.0, sources=3)
    with pytest.raises(pc.SceneError, match=r"Gravitation\.softening"):
        pc.Gravitation(softening=-1.0)


def test_what_names_its_sources_is_saved_and_loaded(tmp_path):
    stars, comets = pc.Particles(points(3, 2)), pc.Particles(points(2, 2, seed=7) + 3.0)
    scene = pc.Scene(stars, comets, pc.Gravitation(1.0, on=comets, sources=stars))
    run = pc.Simulation(scene, dt=0.01)
    run.step(5)
    run.save(tmp_path / "run.physcore")
    loaded = pc.load(tmp_path / "run.physcore")
    force = loaded.scene.forces[0]
    assert (force.bodies("on"), force.bodies("sources")) == ((loaded.scene.bodies[1],), (loaded.scene.bodies[0],))
    assert loaded.scene.hash() == scene.hash() != pc.Scene(stars, comets, pc.Gravitation(1.0, on=comets)).hash()
    run.step(5)
    loaded.step(5)
    np.testing.assert_array_equal(loaded.positions, run.positions)
