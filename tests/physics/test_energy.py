"""Energy: bounded for symmetric integrators, closed with every loss and every driver, and open where a force lies."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings

import physcore as pc
from physcore.forces import FORCES
from physics.laboratory import (
    ALL,
    EPSILON,
    LONG,
    SYMMETRIC,
    Array,
    discrete_energy_error,
    largest_step,
    name,
    network,
    networks,
    orbits,
    simulation,
)

STEPS = 100_000 if LONG else 10_000
SAMPLES = 500


def balances(run: pc.Simulation, steps: int, samples: int) -> Array:
    """total + dissipated − work [J] at equal intervals, the start included."""
    values = [run.energy().balance]
    for _ in range(samples):
        run.step(steps // samples)
        values.append(run.energy().balance)
    return np.array(values)


@pytest.mark.parametrize("integrator", SYMMETRIC, ids=name)
@settings(max_examples=100 if LONG else 12)
@given(net=networks())
def test_the_energy_of_a_network_stays_within_what_the_discrete_modes_allow(integrator, net):
    """Its swing is bounded by the sum over modes of |1 + r/q| V ≤ the worst factor times all energy, for ever.

    The worst factor belongs to the fastest mode that the certified limit allows. A factor of 2 is left for what the
    strains of 5 % and their turning add to harmonic modes: relative changes of the stiffness by a few strains, with
    the transverse stiffness of a strained spring.

    McLachlan2's error is dt² (α v·V''v + β |∇V|²) with α = (1 − 6λ + 6λ²)/12 and β = (1 − 6λ)/24. In a harmonic mode
    one nearly cancels the other, and in one that turns it does not: there both count, by 2(|α| + |β|) (ω dt)² at most.

    No drift: the means of the first and last quarter differ by less than
    the bound, and the bound holds to the end of the run, however long.
    """
    limit = pc.stability_limit(net.scene(), integrator)
    fraction = 0.25
    run = simulation(net.scene(), integrator, fraction * limit)
    swing = discrete_energy_error(integrator, fraction * largest_step(integrator))
    if isinstance(integrator, pc.McLachlan2):
        swing = 2.0 * (0.00540 + 0.00663) * (fraction * largest_step(integrator)) ** 2
    bound = 2.0 * swing * run.energy().total + rounding(run, STEPS)
    error = balances(run, STEPS, SAMPLES)
    error -= error[0]
    assert np.abs(error).max() <= bound
    quarter = SAMPLES // 4
    assert abs(error[-quarter:].mean() - error[:quarter].mean()) <= bound / 2


def rounding(run: pc.Simulation, steps: int) -> float:
    """What rounding may add to the energy [J]: an ε of it per step, with random signs, and five standard deviations."""
    return 5.0 * np.sqrt(steps) * EPSILON * max(run.energy().total, 1e-300)


@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_the_plan_recommends_who_keeps_the_energy_better_at_equal_cost(integrator, record_property):
    """Below the fraction of the limit that the note names, in four networks: the one named errs less with steps that
    take as many evaluations per second. They are then at most half of its own limit.
    """
    advice = re.compile(r"with dt below (\d+)% of the stability limit (\w+) keeps energy better at equal cost")
    for seed in range(4):
        scene = network(seed, dimension=2 + seed % 2, count=10).scene()
        run = simulation(scene, integrator, 1e-4)
        found = [match for note in run.plan.notes if (match := advice.search(note))]
        assert bool(found) == (integrator.order > 1 and name(integrator) not in ("BlanesMoan4", "BlanesMoan6"))
        for match in found:
            other = getattr(pc, match[2])()
            dt = 0.95 * float(match[1]) / 100.0 * pc.stability_limit(scene, integrator)
            cost = simulation(scene, other, 1e-4).plan.evaluations / run.plan.evaluations
            assert cost * dt < 0.5 * pc.stability_limit(scene, other)
            swings = []
            for kind, step in ((integrator, dt), (other, cost * dt)):
                values = balances(simulation(scene, kind, step), round(2000 * dt / step), SAMPLES // 10)
                swings.append(np.abs(values - values[0]).max())
            record_property(f"gain {seed}", f"{swings[0] / swings[1]:.3g}")
            assert swings[1] < 0.5 * swings[0]


@pytest.mark.parametrize("integrator", SYMMETRIC, ids=name)
@settings(max_examples=1000 if LONG else 6)
@given(orbit=orbits())
def test_the_energy_error_of_an_orbit_is_bounded_by_a_constant_times_dt_to_the_order(integrator, orbit):
    """The largest error over four turns shrinks by 2^p when dt is halved, up to the next term, and does not grow.

    The steps are half a hundredth of the fastest turn, so the next term, smaller by (π/100)² times a factor of the
    method's, is far below the quarter that is left. From turn to turn the steps fall differently on the closest
    approach, where the error is largest: half of it is left for that.

    Along a circle the first term vanishes: it is A e dt^p, and the method makes e = k dt² of a circle, so that halving
    dt leaves 3/16 A k dt^(p+2) where one eccentricity just cancels the other. Verlet's energy error is dt² (v·V''v/12 −
    |∇V|²/24), whose slope at the unit circle in the field r^n is dt²/4: it shifts the circle by dt²/4(n + 3), and
    changes by twice e times itself in half a turn. So A k = 1/8(n + 3), which leaves 3/128 dt⁴ at most for n ≥ −2.
    PEFRL's is far smaller.
    """
    dt = 0.5 * min(simulation(orbit.scene(), integrator, 1e-3).plan.dt_limit, 0.02 * np.pi)
    turn = int(np.ceil(2.0 * np.pi / dt))
    errors = []
    for halving in (1, 2):
        run = simulation(orbit.scene(), integrator, dt / halving)
        values = balances(run, 4 * turn * halving, 4 * turn)
        errors.append(np.abs(values - values[0]))
    coarse, fine = (error.max() for error in errors)
    noise = 10.0 * np.sqrt(turn) * EPSILON * (abs(values[0]) + 1.0)
    circle = 0.025 * dt ** (integrator.order + 2)
    assert fine <= 1.25 * coarse / 2**integrator.order + circle + noise
    first, second = errors[0][: 2 * turn].max(), errors[0][2 * turn :].max()
    assert second <= 1.5 * first + circle + noise


@pytest.mark.parametrize("integrator", SYMMETRIC, ids=name)
def test_the_energy_of_an_orbit_has_no_drift_over_many_turns(integrator):
    """Symplectic: the mean energy over ten turns is the same at the end of the run as at its start.

    The error repeats from turn to turn, up to where the steps fall on the orbit: a tenth of its largest value, twice.
    At order 6 it is below rounding for steps of 0.01, 3e-14, and 1e-9 for those of 0.05.
    """
    dt = 0.05 if integrator.order == 6 else 0.01
    orbit = pc.Scene(pc.Particles([[0.4, 0.0]], [[0.0, 2.0]]), pc.CentralForce((0.0, 0.0), 1.0))
    run = simulation(orbit, integrator, dt)
    window = round(20.0 * np.pi / dt)

    def errors() -> Array:
        return np.abs(balances(run, window, window) + 0.5)

    first = errors()
    run.step(5 * STEPS - 2 * window)
    last = errors()
    assert last.max() <= 1.2 * first.max()
    assert abs(last.mean() - first.mean()) <= 0.02 * first.max()


def driven() -> pc.Scene:
    """Every loss and driver at once: damped springs, drag in a wind, a fixed particle that moves, a free orbit."""
    net = network(seed=3, dimension=2, count=6, damping=0.5)
    velocities = net.velocities.copy()
    velocities[0] = (0.3, -0.2)
    planet = pc.Particles([[5.0, 5.0]], [[0.5, 0.0]])
    return pc.Scene(
        net.body(fixed=[0], velocities=velocities),
        planet,
        pc.Gravity((0.0, -1.0)),
        pc.Drag(linear=0.2, quadratic=0.3, wind=(0.5, 0.2)),
        pc.CentralForce((5.0, 4.0), 2.0, softening=0.3, on=planet),
    )


def closure(scene: pc.Scene, integrator: pc.Integrator, steps: int) -> float:
    """Root mean square of the budget's error over 0.5 s, at fifty common times."""
    run = simulation(scene, integrator, 0.5 / steps)
    values = balances(run, steps, 50)
    return float(np.sqrt(np.mean((values - values[0]) ** 2)))


@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_the_budget_closes_to_the_order_of_the_integrator(integrator, record_property):
    """total + dissipated − work is constant up to C dt^p: the powers are integrated with the method's own stages."""
    scene = driven()
    run = simulation(scene, integrator, 1e-4)
    order = run.plan.order
    steps = {1: 1000, 2: 200, 3: 400, 4: 400, 5: 200}[order]
    coarse, fine = closure(scene, integrator, steps), closure(scene, integrator, 2 * steps)
    measured = np.log2(coarse / fine)
    record_property("order", f"{measured:.3f}")
    assert measured > order - 0.1
    run.step(5000)
    energy = run.energy()
    assert energy.dissipated_by["drag"] > 0.01
    assert energy.dissipated_by["damping"] > 0.001
    assert abs(energy.work) > 0.01


@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_the_budget_opens_when_a_drag_is_changed_in_the_force_alone(integrator):
    """A drag that is 1 % stronger than the one that is metered leaves a hole of 1 % of what is dissipated.

    The extra −0.01 b v is a CustomForce that claims to be conservative, with no potential: it acts and is not metered.
    """
    b = 0.5
    body = pc.Particles([[0.0, 0.0], [1.0, 0.0]], [[1.0, 2.0], [0.0, -1.0]])
    honest = (body, pc.Drag(linear=b), pc.Gravity((0.0, -1.0)))
    extra = pc.CustomForce(lambda time, positions, velocities: -0.01 * b * velocities, potential=lambda positions: 0.0)
    dt = 1e-4 if integrator.order == 1 else 1e-3
    holes = []
    for scene in (pc.Scene(*honest), pc.Scene(*honest, extra)):
        run = simulation(scene, integrator, dt)
        before = run.energy().balance
        run.step(round(1.0 / dt))
        holes.append((run.energy().balance - before) / run.energy().dissipated)
    closed, opened = holes
    # The error of order one is b dt/2 of the drag's power and g dt/2 of gravity's: below 1e-4 of what is dissipated.
    assert abs(closed) < 2e-4
    assert opened == pytest.approx(-0.01, rel=0.05)


@pytest.mark.parametrize("integrator", SYMMETRIC, ids=name)
def test_the_budget_opens_when_a_force_is_not_the_gradient_of_its_potential(integrator):
    """A force 1 % stronger than −∇U opens the budget by 1 % of the change of U; the true one closes it."""
    holes = []
    for strength in (1.0, 1.01):
        force = pc.CustomForce(lambda time, x, v, s=strength: -s * x, potential=lambda x: 0.5 * float((x**2).sum()))
        run = simulation(pc.Scene(pc.Particles([[1.0, 0.0]]), force), integrator, 0.001)
        before = run.energy().balance
        run.step(1500)
        holes.append(run.energy().balance - before)
    # At t = 1.5 nearly all of U = 0.5 J is kinetic energy, 1.01 of it: the hole is 0.01 · 0.5 · (1 − cos² 1.5).
    assert abs(holes[0]) < 1e-6
    assert holes[1] == pytest.approx(0.01 * 0.5 * np.sin(1.5) ** 2, rel=0.02)


SPOTS = np.array([[0.7, 0.2, -0.3], [-0.4, 0.9, 0.5], [1.2, -0.6, 0.8]])
FIELDS = {
    pc.Gravity: lambda d: [pc.Gravity((0.3, -9.81, 1.5)[:d])],
    pc.CentralForce: lambda d: [
        pc.CentralForce((0.1, -0.2, 0.3)[:d], strength, exponent, softening)
        for strength in (1.5, -0.5)
        for exponent in (-3.0, -2.0, -1.0, -0.5, 0.0, 1.0, 2.0, 2.5, 3.0)
        for softening in (0.0, 0.2)
    ],
    pc.CustomForce: lambda d: [pc.CustomForce(lambda t, x, v: -4.0 * x**3, potential=lambda x: float((x**4).sum()))],
    # The grains overlap by 0.15 m or more, or not at all; the atoms have a cutoff between them, and one beyond all.
    pc.SoftSpheres: lambda d: [pc.SoftSpheres(10.0, exponent=exponent) for exponent in (1.0, 1.5)],
    pc.LennardJones: lambda d: [pc.LennardJones(1.0, 0.6, cutoff) for cutoff in (None, 2.4)],
    pc.Gravitation: lambda d: [pc.Gravitation(1.5, softening) for softening in (0.0, 0.2)],
    pc.Coulomb: lambda d: [pc.Coulomb(0.7, softening) for softening in (0.0, 0.2)],
    pc.Drag: lambda d: [],
    pc.Dihedral: lambda d: [],
    pc.Wind: lambda d: [],
    pc.ElectromagneticField: lambda d: [
        pc.ElectromagneticField((0.3, -0.2, 0.5)[:d]),
        *([pc.ElectromagneticField(pc.QuadrupoleTrap(1.5, (0.1, 0.0, 0.2)))] if d == 3 else []),
    ],
}
"""Forces with a potential, for each registered kind; Drag and Wind have none, Dihedral that of a surface
(test_dihedral.py)."""


def test_every_registered_force_is_held_against_its_potential():
    assert set(FIELDS) == set(FORCES)


def gradient(run: pc.Simulation, spots: Array) -> Array:
    """∇U (N, D) by central differences of order four, (8 (U₁ − U₋₁) − (U₂ − U₋₂)) / 12 h."""
    h = 1e-3
    result = np.empty_like(spots)
    for index in np.ndindex(*spots.shape):

        def energy(shift: float, index: tuple[int, ...] = index) -> float:
            moved = spots.copy()
            moved[index] += shift * h
            run.set(positions=moved)
            return run.energy().potential

        result[index] = (8.0 * (energy(1) - energy(-1)) - (energy(2) - energy(-2))) / (12.0 * h)
    run.set(positions=spots)
    return result


def force(scene: pc.Scene) -> Array:
    """The forces on particles at rest (N, D): one explicit step changes v by exactly F dt/m."""
    mass = np.concatenate([body.mass for body in scene.bodies])
    run = simulation(scene, pc.ExplicitEuler(), 1.0, on_divergence="ignore")
    run.step(1)
    return run.velocities * mass[:, None]


# The error of the differences is h⁴ U⁽⁵⁾/30, and the rounding of U over h: with h = 1e-3, U⁽⁵⁾ up to 1e3 (r^−3 at
# r ≥ 0.5) and U up to 40 J, 3e-11 and 1e-11; the forces are of the order of 1 N.
TOLERANCE = 1e-9


@pytest.mark.filterwarnings("ignore::physcore.SceneWarning")
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("kind", FORCES, ids=lambda kind: kind.__name__)
def test_a_force_is_minus_the_gradient_of_its_potential(kind, dimension):
    spots = np.ascontiguousarray(SPOTS[:, :dimension])
    for field in FIELDS[kind](dimension):
        body = pc.Particles(spots, mass=[0.5, 1.0, 2.0], charge=[1.0, -0.5, 2.0], radius=[0.9, 0.8, 0.7])
        scene = pc.Scene(body, field)
        found = force(scene)
        expected = -gradient(simulation(scene, pc.ExplicitEuler(), 1.0), spots)
        np.testing.assert_allclose(found, expected, rtol=TOLERANCE, atol=TOLERANCE, err_msg=repr(field))


@given(net=networks())
def test_springs_pull_along_the_gradient_of_their_energy(net):
    """Springs of up to 100 N/m: energies and forces up to some 100 times those above."""
    expected = -gradient(simulation(net.scene(velocities=0.0), pc.ExplicitEuler(), 1.0), net.positions)
    np.testing.assert_allclose(force(net.scene(velocities=0.0)), expected, rtol=TOLERANCE, atol=100 * TOLERANCE)


@given(net=networks(damping=1.0))
def test_losses_never_give_energy_back(net):
    """Drag and damping take −F·v ≥ 0 in every step, and what they take is gone from the total."""
    run = simulation(pc.Scene(net.body(), pc.Drag(0.1, 0.1)), pc.VelocityVerlet(), 0.01)
    taken, total = [0.0], run.energy().total
    for _ in range(50):
        run.step(4)
        taken.append(run.energy().dissipated)
    assert (np.diff(taken) >= 0.0).all()
    assert run.energy().total < total


@pytest.mark.parametrize("drag", [pc.Drag(linear=0.4, wind=(2.0, 1.0)), pc.Drag(quadratic=0.3, wind=(2.0, 1.0))])
@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_the_work_of_a_wind_is_the_momentum_that_it_gives(integrator, drag):
    """F·w is linear in the force, so that W = w·Δp whatever the stages, if both are summed up alike.

    A splitting takes forces at other velocities than powers: they differ by a factor of γ dt ≤ 1e-2 at most.
    """
    wind, dt = np.array([2.0, 1.0]), 1e-2
    run = simulation(pc.Scene(pc.Particles([[0.0, 0.0]], [[0.5, -1.0]]), drag), integrator, dt)
    run.step(100)
    given = float(wind @ (run.velocities[0] - [0.5, -1.0]))
    assert given > 1.0
    assert run.energy().work == pytest.approx(given, rel=1e-2)


@pytest.mark.parametrize("before", [0, 16, 40])
def test_the_energy_of_a_cloth_does_not_depend_on_who_comes_before_it(before):
    """½ k (r − L)² of every spring of a sheet that is drawn out by a tenth, however its particles are numbered."""
    cloth = pc.cloth((9, 8), 0.1, 50.0)
    lengths = np.linalg.norm(cloth.positions[cloth.pairs[:, 0]] - cloth.positions[cloth.pairs[:, 1]], axis=1)
    lengths = lengths.round(12)  # alike to the bit, so that the springs are stencils; off by 5e-12 of a length
    drawn = pc.SpringNetwork(1.1 * cloth.positions, cloth.pairs, 50.0, rest_length=lengths)
    others = [pc.Particles(np.zeros((before, 2)) - 1.0)] if before else []
    energy = simulation(pc.Scene(*others, drawn), pc.VelocityVerlet(), 1e-3).energy()
    assert energy.potential == pytest.approx(float((0.5 * 50.0 * (0.1 * lengths) ** 2).sum()), rel=1e-9)


@pytest.mark.parametrize("drag", [pc.Drag(linear=0.4), pc.Drag(quadratic=0.3), pc.Drag(0.1, 0.2, wind=(2.0, 1.0))])
@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_what_drag_dissipates_is_what_is_lost(integrator, drag):
    """But for the error of the method, γ dt ≤ 2e-2 of it at first order. Drag has no potential energy."""
    run = simulation(pc.Scene(pc.Particles([[0.0, 0.0]], [[0.5, -3.0]]), drag), integrator, 1e-2)
    start = run.energy()
    run.step(50)
    end = run.energy()
    assert end.dissipated > 1.0
    assert end.dissipated == pytest.approx(start.kinetic - end.kinetic + end.work, rel=2e-2)
    assert not end.by_term


@pytest.mark.parametrize(("displaced", "share"), [(True, -1.0 / 12.0), (False, 1.0 / 6.0)])
def test_verlet_dissipates_its_shadow_energy(displaced, share):
    """A damped spring, from a displacement or a velocity to rest: E (1 + y²/6 − …), y = ωh, as its shadow Hamiltonian.

    On x'' = −ω²x Verlet keeps ½v² + ½ω²x² (1 − y²/4), and the Hamiltonian whose flow it follows is that times
    arcsin(y/2)/(y/2 √(1 − y²/4)) = 1 + y²/6 + O(y⁴). Of a displacement that is E (1 − y²/12), of a velocity
    E (1 + y²/6). The next order is a tenth of y⁴, and damping by ξ = 0.01 changes the factors by as much.
    """
    y, damping = 0.2, 0.01
    body = pc.SpringNetwork(
        [[0.0, 0.0], [1.0 if displaced else 0.0, 0.0]],
        [[0, 1]],
        stiffness=1.0,
        damping=2.0 * damping,
        rest_length=0.0,
        fixed=[0],
        velocities=[[0.0, 0.0], [0.0 if displaced else 1.0, 0.0]],
    )
    run = simulation(pc.Scene(body), pc.VelocityVerlet(), y)
    start = run.energy().total
    run.step(int(10.0 / (damping * y)))
    end = run.energy()
    assert end.total < 1e-6 * start
    assert (end.dissipated / start - 1.0) / y**2 == pytest.approx(share, abs=0.01)
