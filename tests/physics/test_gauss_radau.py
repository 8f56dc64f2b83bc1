"""Gauss–Radau collocation: its order, its rounding errors, its own steps, and what it refuses."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc
from physics.laboratory import EPSILON, Array, simulation, state
from work import counted

RADAU = pc.GaussRadau15()


def kepler(eccentricity: float) -> pc.Scene:
    """Two bodies about their center of mass, from periapsis; G (m₁ + m₂) = a = 1, the period is 2π."""
    near, speed = 1.0 - eccentricity, math.sqrt((1.0 + eccentricity) / (1.0 - eccentricity))
    share = np.array([[-0.25], [0.75]])
    bodies = pc.Particles(share * (near, 0.0), share * (0.0, speed), mass=[0.75, 0.25])
    return pc.Scene(bodies, pc.Gravitation(1.0))


PERIOD = 2.0 * math.pi


def drive(time: float, positions: Array, velocities: Array) -> Array:
    """Gyroscopic, driven and dissipative, all smooth."""
    turned = np.stack([-velocities[:, 1], velocities[:, 0]], axis=1)
    return turned + np.cos(3.0 * time) - 0.2 * velocities * (1.0 + positions**2)


def driven() -> pc.Scene:
    well = pc.CentralForce((0.0, 0.0), 4.0, exponent=1.0)
    particles = pc.Particles([[1.0, 0.5], [-0.3, 0.8]], [[0.2, 0.0], [0.0, -0.7]])
    return pc.Scene(particles, well, pc.Drag(linear=0.1), pc.CustomForce(drive))


@pytest.mark.parametrize(
    ("scene", "duration", "steps"),
    [(lambda: kepler(0.3), 2.0, (3, 4, 5)), (driven, 3.0, (4, 6, 8))],
    ids=["kepler", "driven"],
)
def test_fixed_steps_are_of_order_15(scene, duration, steps, record_property):
    """Between errors that the leading term rules and rounding there is a factor of two in the steps: terms of other
    orders change the order that is seen by one.
    """
    exact = simulation(scene(), RADAU, duration / 200)
    exact.step(200)
    errors = []
    for count in steps:
        run = simulation(scene(), RADAU, duration / count)
        run.step(count)
        errors.append(float(np.abs(state(run) - state(exact)).max()))
    order = np.log(errors[0] / errors[-1]) / np.log(steps[-1] / steps[0])
    record_property("errors", errors)
    record_property("order", f"{order:.2f}")
    assert min(errors) > 50 * EPSILON
    assert order == pytest.approx(15.0, abs=1.1)


@pytest.mark.parametrize("numerics", [{"dt": PERIOD / 60}, {}], ids=["fixed", "adaptive"])
def test_a_run_goes_back_to_where_it_began(numerics):
    """Steps below rounding error are those of the exact flow, which is reversible. A rounding of a position or a
    velocity shifts the phase by up to 3π ε a revolution, there and back; some 60 steps a revolution add up at random.
    """
    run = pc.Simulation(kepler(0.3), RADAU, **numerics)
    start = state(run)
    run.run(3 * PERIOD)
    run.set(velocities=-run.velocities)
    run.run(3 * PERIOD)
    back = state(run) * np.array([1.0, -1.0])[:, None, None]
    assert np.abs(back - start).max() < 6 * 3 * math.pi * math.sqrt(6 * 60) * EPSILON


def test_an_ellipse_of_high_eccentricity_closes_after_fifty_turns():
    """From apoapsis, r = 1.95. Rounding of the start shifts the energy −½ by 2 ε/1.95 at the most, and so the period by
    1.5 times 2 ε of itself: 50 periods, with the speed of the apoapsis, √(0.05/1.95), by 1.1e-14. The rest is the
    roundings of 280 steps a turn, most of which turn the ellipse: at the periapsis, r = 0.05, by ε/0.05 in each of the
    hundred steps there, at random, √(50 · 100) 20 ε = 3.1e-13, seen from r = 1.95. Three standard deviations of that.
    """
    speed = math.sqrt(0.05 / 1.95)
    share = np.array([[-0.25], [0.75]])
    bodies = pc.Particles(share * (1.95, 0.0), share * (0.0, speed), mass=[0.75, 0.25])
    run = pc.Simulation(pc.Scene(bodies, pc.Gravitation(1.0)), RADAU)
    run.run(50 * PERIOD)
    assert run.time == pytest.approx(50 * PERIOD, rel=1e-15)
    assert np.abs(run.positions - bodies.positions).max() < 3 * 1.95 * 3.1e-13


def planets(count: int = 16) -> pc.Scene:
    """Independent planets about a star with a = 1, e below 0.1, each at another phase: so many walks in one run."""
    rng = np.random.default_rng(4)
    angle, eccentricity = rng.uniform(0.0, 2.0 * math.pi, count), rng.uniform(0.0, 0.1, count)
    radial = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across = np.stack([-radial[:, 1], radial[:, 0]], axis=1)
    speed = np.sqrt((1.0 + eccentricity) / (1.0 - eccentricity))[:, None]
    bodies = pc.Particles((1.0 - eccentricity[:, None]) * radial, speed * across)
    return pc.Scene(bodies, pc.CentralForce((0.0, 0.0), 1.0, exponent=-2.0))


def energies(run: pc.Simulation) -> Array:
    """Of each planet, about −½."""
    radius = np.hypot(*run.positions.T)
    return 0.5 * (run.velocities**2).sum(axis=1) - 1.0 / radius


def walk(integrator: pc.Integrator, orbits: tuple[int, ...]) -> tuple[Array, Array, Array]:
    """Steps, rms of the relative energy errors of all planets after so many orbits, and what rounding allows for it.

    At each node the position is rounded by ε/(4√3) at random, which changes the acceleration by as much, and its own
    root, quotient and products by some three times that: 0.5 ε, of which the velocity takes up h a, averaged over eight
    nodes. That changes v²/2 by v · h a · 0.5 ε/√8, of the energy ½: 0.35 h ε a step. The velocities and places that
    energies are read off are rounded too: 4 ε/√12.
    """
    run = pc.Simulation(planets(), integrator, threads=1)
    start, done, found = energies(run), 0, []
    for each in orbits:
        run.run((each - done) * PERIOD)
        error, done = energies(run) / start - 1.0, each
        h = run.time / run.steps
        allowed = (0.35 * h * math.sqrt(run.steps) + 4.0 / math.sqrt(12.0)) * EPSILON
        found.append((run.steps, float(np.sqrt((error**2).mean())), allowed))
    steps, rms, most = np.array(found).T
    return steps, rms, most


def test_the_energy_errs_by_roundings_that_do_not_add_up(record_property):
    """A thousand orbits: an error of one sign of ε/2000 a step would show as more than what is allowed."""
    steps, rms, allowed = walk(RADAU, (1000,))
    record_property("steps, rms", (int(steps[0]), float(rms[0])))
    assert rms[0] < allowed[0]


@pytest.mark.long
def test_brouwers_law_holds_over_a_million_orbits(record_property):
    """The energy error grows like the square root of the steps: over two decades of time the slope of 16 walks is ½,
    known to 1/√(2·16)·√2/ln 100 = 0.054 at one standard deviation. Errors of one sign would make it 1. The tolerance
    is small, because that of 1e-9 leaves an error of the method of some 1e-20 a step, as much as the walk after 1e5.
    """
    steps, rms, allowed = walk(pc.GaussRadau15(1e-11), (10_000, 30_000, 100_000, 300_000, 1_000_000))
    slope = np.polyfit(np.log(steps), np.log(rms), 1)[0]
    record_property("steps", steps.tolist())
    record_property("rms", rms.tolist())
    record_property("slope", float(slope))
    assert slope == pytest.approx(0.5, abs=0.16)
    assert (rms < allowed).all()


def test_steps_follow_the_motion_and_end_at_each_frame():
    """Frames of a tenth of a step and of ten do not change how large the steps become."""
    scene = kepler(0.9)
    recording = pc.simulate(scene, PERIOD, fps=8 / PERIOD, integrator=RADAU)
    np.testing.assert_allclose(recording.times, np.arange(9) * PERIOD / 8, rtol=1e-15)
    free = pc.Simulation(scene, RADAU)
    free.run(PERIOD)
    # Each frame cuts a step in two parts at the most, and halves the one before.
    assert recording.provenance.segments[-1].steps <= free.steps + 3 * 8
    (note,) = (note for note in free.plan.notes if note.startswith("adaptive steps"))
    assert "1e-09 of the largest acceleration" in note
    smallest, largest = (float(word) for word in note.split(" from ")[1].replace(",", "").split()[0:4:3])
    # Kepler's third law for the circle of the periapsis and the apoapsis: 19^1.5 = 83.
    assert largest > 20.0 * smallest
    np.testing.assert_allclose(recording.positions[-1], free.positions, rtol=0.0, atol=1e-12)


def test_a_short_run_does_not_lose_the_step_size():
    run = pc.Simulation(kepler(0.1), RADAU)
    run.run(PERIOD)
    usual = run.dt
    run.run(1e-6)
    assert run.dt == pytest.approx(1e-6)
    before = run.steps
    run.run(2.0 * usual)
    assert run.steps <= before + 4


def test_each_digit_of_the_tolerance_costs_a_seventh_of_a_decade_of_steps(record_property):
    """b₆ stands for h⁷ in a: each power of ten takes 10^(1/7) = 1.39 times the steps. The error of the method is of
    order 15 in h, far below the tolerance, and at rounding from 1e-5 on.
    """
    scene = kepler(0.7)
    exact = pc.Simulation(scene, RADAU)
    exact.run(10.0)
    tolerances, errors, steps = 10.0 ** -np.arange(2.0, 9.0), [], []
    for tolerance in tolerances:
        run = pc.Simulation(scene, pc.GaussRadau15(tolerance))
        run.run(10.0)
        errors.append(float(np.abs(run.positions - exact.positions).max()))
        steps.append(run.steps)
    record_property("errors, steps", (errors, steps))
    assert (np.array(errors) < tolerances).all()
    assert max(errors[3:]) < 1e-13
    slope = np.polyfit(np.log(tolerances), np.log(steps), 1)[0]
    assert slope == pytest.approx(-1 / 7, rel=0.1)


def test_a_close_encounter_after_long_quiet_is_met_by_steps_that_are_taken_back():
    """A comet that falls past its star at a thousandth of its first distance."""
    comet = pc.Particles([[1.0, 0.0]], [[0.0, 0.03]])
    run = pc.Simulation(pc.Scene(comet, pc.CentralForce((0.0, 0.0), 1.0, exponent=-2.0)), RADAU)
    energy = run.energy().total
    run.run(2.0)
    # v² = 2/r at r = v₀²/2 = 4.5e-4: an ulp of r = 1 is ε/4.5e-4 of the potential there, 2/r, in few steps.
    assert run.energy().total == pytest.approx(energy, rel=20 * EPSILON / 4.5e-4**2)


def network() -> pc.Scene:
    """Springs with damping, one end held and one end carried along, in wind."""
    rope = pc.rope(6, 1.0, 50.0, damping=0.3, mass=0.1, pinned="both")
    velocities = np.zeros((6, 2))
    velocities[-1] = (0.3, 0.1)
    rope = pc.SpringNetwork(
        rope.positions * 1.1,
        rope.pairs,
        50.0,
        damping=0.3,
        rest_length=0.2,
        mass=0.1,
        fixed=[0, 5],
        velocities=velocities,
    )
    return pc.Scene(rope, pc.Gravity((0.0, -9.81)), pc.Drag(linear=0.05, quadratic=0.02, wind=(1.0, 0.0)))


@pytest.mark.parametrize("numerics", [{"dt": 5e-3}, {}], ids=["fixed", "adaptive"])
def test_the_budget_closes_to_rounding(numerics):
    """Dissipation, wind and the work of the carried end are integrated by the same quadrature, of order 15. What rounds
    are the powers and energies of up to 20 J in some 200 steps.
    """
    run = pc.Simulation(network(), RADAU, **numerics)
    first = run.energy().balance
    run.run(1.0)
    energy = run.energy()
    assert energy.dissipated > 0.1
    assert abs(energy.work) > 0.01
    assert abs(energy.balance - first) < 20.0 * math.sqrt(200) * 16 * EPSILON


def test_fixed_particles_hold_and_keep_their_velocity():
    run = pc.Simulation(network(), RADAU)
    start = run.positions
    run.run(0.5)
    np.testing.assert_array_equal(run.positions[0], start[0])
    np.testing.assert_array_equal(run.velocities[-1], (0.3, 0.1))
    # Two-sums: the rounding of one sum.
    np.testing.assert_allclose(run.positions[-1], start[-1] + 0.5 * np.array([0.3, 0.1]), rtol=2 * EPSILON)


def test_a_change_of_the_state_starts_anew():
    """A run that is set is one that begins there, in the same bits: what was predicted and rounded is forgotten."""
    scene = kepler(0.4)
    run = pc.Simulation(scene, RADAU, 0.05)
    run.step(7)
    run.set(positions=scene.bodies[0].positions, velocities=scene.bodies[0].velocities)
    run.step(5)
    fresh = pc.Simulation(scene, RADAU, 0.05)
    fresh.step(5)
    np.testing.assert_array_equal(state(run), state(fresh))


def test_free_particles_fly_on_with_ever_longer_steps():
    run = pc.Simulation(pc.Scene(pc.Particles([[0.0, 0.0], [1.0, 2.0]], [[1.0, 0.0], [0.5, -0.25]])), RADAU)
    run.run(100.0)
    np.testing.assert_allclose(run.positions, [[100.0, 0.0], [51.0, -23.0]], rtol=4 * EPSILON)
    assert run.steps < 20


def test_the_plan_says_what_it_is():
    run = pc.Simulation(kepler(0.1), RADAU)
    assert (run.plan.integrator, run.plan.order, run.plan.precision) == ("GaussRadau15", 15, "f64")
    run.run(PERIOD)
    assert any("iterations per step" in note for note in run.plan.notes)
    assert run.evaluations == 15


def test_a_step_beyond_the_limit_warns_and_says_so_afterwards():
    """On ω = 1 the iterations of h = 5 are halved in each pass only: after 12 of them they have not converged."""
    oscillator = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0))
    assert pc.stability_limit(oscillator, RADAU) == pytest.approx(math.sqrt(0.1 / 0.0144))
    with pytest.warns(pc.StabilityWarning, match="above the limit of stability"):
        run = pc.Simulation(oscillator, RADAU, 5.0)
    run.step(3)
    assert any("they did not converge: take a smaller dt" in note for note in run.plan.notes)


@pytest.mark.parametrize("tolerance", [0.0, -1e-9, math.nan, math.inf, "small"])
def test_a_tolerance_out_of_range_is_refused(tolerance):
    with pytest.raises(pc.SceneError, match=r"GaussRadau15\.tolerance: must be"):
        pc.GaussRadau15(tolerance)


def test_what_it_cannot_drive_is_refused():
    ball = pc.Scene(pc.Particles([[0.0, 1.0]]), pc.Gravity((0.0, -1.0)), pc.Floor())
    with pytest.raises(pc.SceneError, match=r"integrator: expected an explicit one.*boundaries, got GaussRadau15"):
        pc.Simulation(ball, RADAU)
    with pytest.raises(pc.SceneError, match=r"precision: expected .f64. with GaussRadau15"):
        pc.Simulation(kepler(0.1), RADAU, precision="f32")
    pool = pc.Scene(pc.Fluid(pc.block((0.0, 0.0), (0.2, 0.2), 0.05), 0.05))
    with pytest.raises(pc.SceneError, match=r"integrator: expected .* with a fluid, got GaussRadau15"):
        pc.Simulation(pool, RADAU, precision="f64", fluids=pc.WeaklyCompressible(sound_speed=10.0))
    with pytest.raises(pc.SceneError, match=r"dt: GaussRadau15\(\) has a tolerance of its own"):
        pc.Simulation(kepler(0.1), RADAU, pc.AdaptiveStep(tolerance=1e-6))
    with pytest.raises(pc.SceneError, match=r"integrator: GaussRadau15\(\) cannot drive it"):
        pc.Simulation(pc.Scene(pc.Wave(pc.Grid((20,), 0.1), 1.0)), RADAU)
    with pytest.raises(pc.SceneError, match="dt: adaptive steps are not equal"):
        pc.Simulation(kepler(0.1), RADAU).step()


def test_other_systems_beside_it_need_steps_of_a_given_length():
    tracers = pc.Tracers([[1.0, 1.0]], pc.Flow(lambda time, positions: -positions))
    both = pc.Scene(*kepler(0.1).bodies, pc.Gravitation(1.0), tracers)
    with pytest.raises(pc.SceneError, match=r"dt: GaussRadau15\(\) chooses the steps of the bodies"):
        pc.Simulation(both, RADAU)
    run = pc.Simulation(both, RADAU, 0.01)
    run.step(10)
    alone = pc.Simulation(kepler(0.1), RADAU, 0.01)
    alone.step(10)
    np.testing.assert_array_equal(state(run), state(alone))


def test_trades_and_accuracies_take_it_where_it_is_named():
    """With steps of a given length, beside others; its errors are below what the reference is known to."""
    with counted():
        trade = pc.tradeoff(
            kepler(0.3),
            PERIOD,
            integrators=[RADAU, pc.DormandPrince5()],
            precisions=["f64"],
            budget=2.0,
            progress=False,
        )
    best = {kind: min(row.error for row in trade.rows if type(row.integrator) is kind) for kind in (pc.GaussRadau15,)}
    assert best[pc.GaussRadau15] < 1e-11
    recording = pc.simulate(kepler(0.3), PERIOD, fps=2.0, integrator=RADAU, accuracy=1e-12)
    assert recording.plan.integrator == "GaussRadau15"


def test_a_tolerance_below_rounding_is_raised_to_it():
    """b₆ is a sum of accelerations with the weights 1/Π (hₙ − hₘ), 11525 together, times their rounding ε/2: 1.3e-12.
    Shorter steps would not make it smaller; at a tolerance below they are those of that one.
    """
    run = pc.Simulation(kepler(0.3), pc.GaussRadau15(1e-300))
    run.run(PERIOD)
    usual = pc.Simulation(kepler(0.3), pc.GaussRadau15(2e-12))
    usual.run(PERIOD)
    assert run.steps < 1.5 * usual.steps
    np.testing.assert_allclose(run.positions, usual.positions, rtol=0.0, atol=100 * EPSILON)


def test_an_encounter_far_from_the_origin_passes():
    """Two stars come within 1e-7 of each other at a distance of 1 from the origin: an ulp there is 1e-9 of theirs, and
    the force is known no better; steps that went on shrinking would not end.
    """
    near = 1e-7
    speed = math.sqrt((2.0 - near) / near)
    share = np.array([[-0.25], [0.75]])
    pair = pc.Particles(1.0 + share * (2.0 - near, 0.0), share * (0.0, speed * near / (2.0 - near)), mass=[0.75, 0.25])
    run = pc.Simulation(pc.Scene(pair, pc.Gravitation(1.0)), RADAU)
    energy = run.energy().total
    run.run(PERIOD)
    assert run.steps < 3000
    # The potential there is 2e6 times as large, of which an ulp is 1e-9.
    assert run.energy().total == pytest.approx(energy, rel=0.1)
