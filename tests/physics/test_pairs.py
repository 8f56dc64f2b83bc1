"""Pair forces: as the formulas say between every two particles, and with what the laws of motion keep."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physcore as pc
from physics.crowds import CONSERVATIVE, LAWS, SIDE, Crowd, crowd, domain, forces, pairs, potential, rounding
from physics.laboratory import ALL, EPSILON, SYMMETRIC, SYMPLECTIC, Array, name, simulation, state

KINDS = ("open", "strip", "closed")
EPSILONS = {"f64": EPSILON, "f32": float(np.finfo(np.float32).eps)}


def one_evaluation(scene: pc.Scene, precision: str = "f64") -> Array:
    """The forces of the present state (N, D): one explicit step of 1 s changes v by exactly F/m."""
    mass = np.concatenate([body.mass for body in scene.bodies])
    before = np.concatenate([body.velocities for body in scene.bodies])
    run = simulation(scene, pc.ExplicitEuler(), 1.0, precision=precision, on_divergence="ignore")
    run.step(1)
    return (run.velocities - before) * mass[:, None]


@pytest.mark.parametrize("precision", EPSILONS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("law", LAWS)
def test_forces_and_energies_are_those_of_all_pairs(law, dimension, kind, precision):
    """To rounding: that of the force, and one more of m v where it becomes a velocity."""
    people = crowd(law, dimension, kind)
    epsilon = EPSILONS[precision]
    expected = forces(people)
    assert np.abs(expected).max() > 1.0
    found = one_evaluation(people.scene(), precision)
    speed = np.abs(people.velocities) + np.abs(expected) / people.mass[:, None]
    tolerance = rounding(people, epsilon)[:, None] + 4.0 * epsilon * people.mass[:, None] * speed
    assert (np.abs(found - expected) <= tolerance).all()
    run = simulation(people.scene(), pc.VelocityVerlet(), 1e-3, precision=precision)
    # A displacement that is off by ε L changes the energy by F ε L: less than the forces' tolerances times 1 m.
    allowed = rounding(people, epsilon).sum()
    assert run.energy().potential == pytest.approx(potential(people), rel=1e2 * epsilon, abs=allowed)


@pytest.mark.parametrize("kind", ["open", "closed"])
@pytest.mark.parametrize("law", CONSERVATIVE)
def test_a_crowd_is_pushed_down_the_gradient_of_its_energy(law, kind):
    """Along random directions e of unit length, F·e = −dU/ds by central differences of order four.

    A pair moves by about 0.2 s. The error h⁴ U⁽⁵⁾/30 is that of 100 pairs with u⁽⁵⁾ ≤ 3e7 J/m⁵ (r^−12 at 0.8 m), so
    1e-12 · 100 · 3e7 · 0.2⁵ / 30 = 3e-8 N; the rounding of U ≤ 100 J is 100 ε/h = 2e-11 N. No pair may be so near to
    its reach that the differences straddle it: there u is only twice differentiable.
    """
    h = 1e-3

    def straddles(people: Crowd) -> bool:
        near = pairs(people, beyond=2.0 * h)
        return bool((near.distance > near.reach - 2.0 * h).any())

    people = next(each for each in (crowd(law, 2, kind, seed) for seed in range(100)) if not straddles(each))
    run = simulation(people.scene(velocities=0.0), pc.VelocityVerlet(), 1e-3)
    force = one_evaluation(people.scene(velocities=0.0))
    rng = np.random.default_rng(5)

    def energy(shift: Array) -> float:
        run.set(positions=people.positions + shift)
        return run.energy().potential

    for _ in range(5):
        e = rng.standard_normal(force.shape)
        e /= np.linalg.norm(e)
        slope = (8.0 * (energy(h * e) - energy(-h * e)) - (energy(2 * h * e) - energy(-2 * h * e))) / (12.0 * h)
        assert (force * e).sum() == pytest.approx(-slope, abs=1e-7)


STEPS = 200
DT = 0.002
"""A fifteenth of the fastest period: 100 N/m and more pairs on 0.25 kg of reduced mass give ω of about 50/s."""


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_pairs_keep_the_momentum(integrator, law, kind):
    """Newton's third law: rounding of up to four stages a step, and nothing else. Forces change on the way: twice."""
    people = crowd(law, 2, kind)
    run = simulation(people.scene(), integrator, DT)
    before = run.momentum()
    run.step(STEPS)
    moving = EPSILON * (people.mass[:, None] * np.abs(run.velocities)).sum()
    allowed = 2.0 * 4.0 * STEPS * (DT * rounding(people, EPSILON).sum() + moving)
    assert np.abs(run.momentum() - before).max() <= allowed


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("law", [*CONSERVATIVE, "damped"])
@pytest.mark.parametrize("integrator", SYMPLECTIC, ids=name)
def test_pairs_without_friction_keep_the_angular_momentum(integrator, law, dimension):
    """They push along the line that joins them: as above, at a distance of at most the extent from the origin."""
    people = crowd(law, dimension)
    run = simulation(people.scene(), integrator, DT)
    before = run.angular_momentum()
    run.step(STEPS)
    moving = EPSILON * (people.mass[:, None] * np.abs(run.velocities)).sum()
    allowed = people.extent * 2.0 * 4.0 * STEPS * (DT * rounding(people, EPSILON).sum() + moving)
    assert np.abs(run.angular_momentum() - before).max() <= allowed


def moved(people: Crowd, integrator: pc.Integrator, steps: int = STEPS) -> Array:
    run = simulation(people.scene(), integrator, DT)
    run.step(steps)
    return state(run)


def apart(one: Array, other: Array, people: Crowd) -> float:
    """The largest difference of two states, positions up to whole periods."""
    shift = one[0] - other[0]
    shift = shift if people.domain is None else people.domain.nearest(shift)
    return float(max(np.abs(shift).max(), np.abs(one[1] - other[1]).max()))


def tolerance(people: Crowd, integrator: pc.Integrator, steps: int = STEPS) -> float:
    """How far two runs may part that differ by rounding alone.

    Every step rounds each number, of the size of the extent at most, by an ε of it or a few, and what was rounded off
    grows as any other small difference does. That was measured in one direction: a factor of 10 covers the others.
    """
    shift = 1e-9 * np.random.default_rng(0).standard_normal(people.positions.shape)
    parted = moved(people.changed(positions=people.positions + shift), integrator, steps)
    growth = max(1.0, apart(parted, moved(people, integrator, steps), people) / 1e-9)
    return 10.0 * growth * steps * EPSILON * people.extent


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("law", CONSERVATIVE)
@pytest.mark.parametrize("integrator", SYMMETRIC, ids=name)
def test_a_crowd_runs_back_to_where_it_came_from(integrator, law, kind):
    people = crowd(law, 2, kind)
    run = simulation(people.scene(), integrator, DT)
    run.step(STEPS)
    run.set(velocities=-run.velocities)
    run.step(STEPS)
    back = np.stack([run.positions, -run.velocities])
    start = np.stack([people.positions, people.velocities])
    assert apart(back, start, people) <= tolerance(people, integrator, 2 * STEPS)


@pytest.mark.parametrize("kind", ["strip", "closed"])
@pytest.mark.parametrize("law", LAWS)
def test_a_particle_may_stand_for_any_of_its_images(law, kind):
    """Each is moved by whole periods of its own: to where the numbers are larger, and nothing else."""
    people, integrator = crowd(law, 2, kind), pc.VelocityVerlet()
    assert people.domain is not None
    periods = np.where(np.isinf(people.domain.lengths), 0.0, people.domain.lengths)
    images = np.random.default_rng(2).integers(-3, 4, people.positions.shape) * periods
    far = people.changed(positions=people.positions + images)
    assert apart(moved(far, integrator), moved(people, integrator), people) <= tolerance(far, integrator)


@pytest.mark.parametrize("law", LAWS)
def test_a_force_that_names_bodies_acts_on_them_and_between_them(law):
    """Every third particle is another body's, and every third of a body that is left alone."""
    people = crowd(law, 2)
    parts = [slice(start, None, 3) for start in range(3)]

    arrays = ("positions", "velocities", "radius", "mass")
    bodies = [pc.Particles(**{each: getattr(people, each)[part] for each in arrays}) for part in parts]
    acting = replace(LAWS[law], on=[bodies[2], bodies[0]])
    found = one_evaluation(pc.Scene(*bodies, acting))
    alone = len(bodies[0]) + np.arange(len(bodies[1]))
    assert (found[alone] == 0.0).all()
    both = {each: np.concatenate([getattr(people, each)[parts[0]], getattr(people, each)[parts[2]]]) for each in arrays}
    rest = people.changed(**both)
    speed = np.abs(rest.velocities) + np.abs(forces(rest)) / rest.mass[:, None]
    allowed = rounding(rest, EPSILON)[:, None] + 4.0 * EPSILON * rest.mass[:, None] * speed
    assert (np.abs(np.delete(found, alone, axis=0) - forces(rest)) <= allowed).all()


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_ends_of_a_spring_do_not_touch(dimension):
    """Forces and energy are the sums over all other pairs that overlap, by brute force; the springs are at rest."""
    rng = np.random.default_rng(dimension)
    x = rng.uniform(0.0, 3.0, (120, dimension))
    bonds = np.unique(np.sort(rng.integers(0, 100, (300, 2)), axis=1), axis=0)
    bonds = bonds[bonds[:, 0] < bonds[:, 1]]
    body = pc.SpringNetwork(x, bonds, 1.0, mass=1.0, radius=0.4)
    one, other = np.triu_indices(len(x), 1)
    free = ~(one * len(x) + other == (bonds[:, :1] * len(x) + bonds[:, 1:])).any(axis=0)
    apart = x[one[free]] - x[other[free]]
    distance = np.linalg.norm(apart, axis=1)
    overlap = np.maximum(0.8 - distance, 0.0)
    expected = np.zeros_like(x)
    push = (10.0 * overlap / distance)[:, None] * apart
    np.add.at(expected, one[free], push)
    np.add.at(expected, other[free], -push)
    found = one_evaluation(pc.Scene(body, pc.SoftSpheres(10.0)))
    # Some 30 terms of up to 8 N, and springs whose lengths are rounded.
    assert np.abs(found - expected).max() <= 1e3 * EPSILON * 8.0
    energy = pc.Simulation(pc.Scene(body, pc.SoftSpheres(10.0)), dt=1e-3).energy().by_term["repulsion"]
    assert energy == pytest.approx(5.0 * float((overlap**2).sum()), rel=1e-13)
    chain = pc.rope(5, 0.4, 100.0, radius=0.1)
    resting = simulation(pc.Scene(chain, pc.SoftSpheres(100.0)), pc.VelocityVerlet(), 1e-3)
    resting.step(10)
    assert np.abs(resting.velocities).max() < 1e-12


def test_fixed_grains_push_and_are_not_pushed():
    """The fixed one is left out of the momentum; the energy of the pair goes to the other."""
    body = pc.Particles([[0.0, 0.0], [0.9, 0.0]], mass=2.0, radius=0.5, fixed=[0])
    run = simulation(pc.Scene(body, pc.SoftSpheres(100.0)), pc.VelocityVerlet(), 1e-4)
    run.step(5000)
    assert run.positions[0].tolist() == [0.0, 0.0]
    # ½ k δ² = ½ m v²; Verlet keeps the energy of a linear contact to (ω dt)²/4 = 1e-7, and loses dt²-terms at its end.
    assert run.velocities[1, 0] == pytest.approx(0.1 * np.sqrt(100.0 / 2.0), rel=1e-4)


@pytest.mark.parametrize("law", LAWS)
def test_two_particles_in_one_place_have_no_direction_and_stay_finite(law):
    """Grains only: atoms in one place have no finite energy, and that is said when the simulation is made."""
    scene = pc.Scene(pc.Particles([[1.0, 1.0], [1.0, 1.0]], radius=0.5), LAWS[law])
    if law == "atoms":
        with pytest.raises(pc.PhyscoreError):
            simulation(scene, pc.VelocityVerlet(), 1e-3).step(1)
    else:
        run = simulation(scene, pc.VelocityVerlet(), 1e-3)
        run.step(100)
        assert np.isfinite(run.positions).all()


def trimer() -> pc.Scene:
    """Three atoms that stay within each other's reach: no force has an edge on their way."""
    body = pc.Particles([[0.0, 0.0], [1.2, 0.0], [0.5, 1.1]], [[0.1, 0.0], [0.0, 0.2], [-0.1, -0.2]])
    return pc.Scene(body, pc.LennardJones(1.0, 1.0, cutoff=20.0))


def pressed(damping: float) -> pc.Scene:
    """Three grains that a well presses into each other all the time."""
    body = pc.Particles([[-0.5, 0.0], [0.5, 0.1], [0.0, 0.7]], [[0.5, 0.0], [0.0, -0.5], [0.1, 0.2]], radius=1.0)
    return pc.Scene(body, pc.SoftSpheres(40.0, damping), pc.CentralForce((0.0, 0.2), 80.0, exponent=1.0))


SMOOTH = {"trimer": trimer(), "pressed": pressed(0.0), "pressed and damped": pressed(1.0)}


@pytest.mark.parametrize("scene", SMOOTH)
@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_the_order_of_an_integrator_holds_where_pairs_are_smooth(integrator, scene, record_property):
    """The difference of runs with dt and dt/2 shrinks by 2^p when both are halved, up to the next term in dt."""
    steps = {1: 4000, 2: 400, 3: 300, 4: 200, 5: 120, 6: 20}[integrator.order]
    ends = []
    for halving in (1, 2, 4):
        run = simulation(SMOOTH[scene], integrator, 0.5 / (steps * halving))
        run.step(steps * halving)
        ends.append(state(run))
    order = run.plan.order
    measured = np.log2(np.abs(ends[0] - ends[1]).max() / np.abs(ends[1] - ends[2]).max())
    record_property("order", f"{measured:.3f}")
    assert abs(measured - order) < 0.15 or measured > order


def argon(dt: float, start: tuple[Array, Array] | None = None) -> pc.Simulation:
    """256 atoms in reduced units at ρ* = 0.8442 and T* = 0.722 on a face-centered lattice: Verlet's fluid of 1967."""
    cells = 4
    side = (4 * cells**3 / 0.8442) ** (1.0 / 3.0)
    corners = np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3)
    basis = np.array([[0.25, 0.25, 0.25], [0.75, 0.75, 0.25], [0.75, 0.25, 0.75], [0.25, 0.75, 0.75]])
    positions = (corners + basis).reshape(-1, 3) * (side / cells)
    velocities = np.random.default_rng(1967).standard_normal(positions.shape)
    velocities -= velocities.mean(axis=0)
    velocities *= np.sqrt(0.722 * 3 * (len(positions) - 1) / (velocities**2).sum())
    if start is not None:
        positions, velocities = start
    atoms = pc.Particles(positions, velocities)
    box = pc.Periodic((0.0,) * 3, (side,) * 3)
    return simulation(pc.Scene(atoms, pc.LennardJones(1.0, 1.0), box), pc.VelocityVerlet(), dt)


def test_the_energy_of_a_liquid_swings_with_the_square_of_the_step_and_does_not_drift(record_property):
    """From one melted state, over 10 units of time, sampled every 0.05.

    The energy that Verlet keeps differs from the true one by a term of order dt²: its swing falls by 4 when dt is
    halved. The two trajectories part, so the swings are estimates from some 100 independent samples each (the memory
    of a liquid is about 0.1): to 1/√200 = 7 % each, 10 % for their ratio; three times that.
    """
    melted = argon(0.0025)
    melted.step(2000)
    start = melted.positions, melted.velocities
    assert melted.energy().kinetic > 0.3 * 1.5 * 256
    swings = []
    for dt in (0.005, 0.0025):
        run = argon(dt, start)
        values = [run.energy().total]
        for _ in range(200):
            run.step(round(0.05 / dt))
            values.append(run.energy().total)
        swings.append(np.std(values))
        # The means of the halves, each of 50 independent samples, differ by chance by a fifth of the swing.
        assert abs(np.mean(values[:100]) - np.mean(values[100:])) < 3 * 0.2 * swings[-1]
    record_property("ratio", f"{swings[0] / swings[1]:.2f}")
    record_property("swing per atom", f"{swings[0] / 256:.1e}")
    assert swings[0] / swings[1] == pytest.approx(4.0, rel=0.3)


def collide(law: pc.SoftSpheres, speed: float, dt: float, steps: int) -> pc.Simulation:
    """Two grains of 1 and 3 kg that touch head on at the start."""
    body = pc.Particles([[0.0, 0.0], [1.0, 0.0]], [[speed, 0.0], [0.0, 0.0]], mass=[1.0, 3.0], radius=0.5)
    run = simulation(pc.Scene(body, law), pc.VelocityVerlet(), dt)
    run.step(steps)
    return run


REDUCED = 0.75
"""1 · 3 / (1 + 3) [kg]."""


@pytest.mark.parametrize("damping", [0.0, 0.5, 2.0, 5.0])
def test_a_damped_contact_has_the_restitution_of_schwager_and_poschel(damping):
    """Without attraction the contact ends where the force does: e = exp(−β/ω (π − atan(2βω/(ω² − β²)))).

    β = γ/2m, ω² = k/m − β² with the reduced mass. The damping sets in with a jump, somewhere within a step: an error
    of γ/m dt in the speed at each end, twice for the rest. Source: T. Schwager, T. Pöschel, Granul. Matter 9, 465
    (2007).
    """
    stiffness, dt = 100.0, 1e-4
    beta = damping / (2.0 * REDUCED)
    omega = np.sqrt(stiffness / REDUCED - beta**2)
    expected = np.exp(-beta / omega * (np.pi - np.arctan2(2.0 * beta * omega, omega**2 - beta**2)))
    run = collide(pc.SoftSpheres(stiffness, damping), 2.0, dt, 6000)
    parting = np.diff(run.velocities[:, 0])[0] / 2.0
    assert parting == pytest.approx(expected, abs=4.0 * damping / REDUCED * dt + (omega * dt) ** 2)
    # The power that is metered is that of the same force: what is lost of ½ m v² is what was dissipated.
    lost = 0.5 * REDUCED * 2.0**2 * (1.0 - expected**2)
    assert run.energy().dissipated == pytest.approx(lost, abs=4.0 * damping * 2.0**2 * dt + 1e-12)


def test_a_hertzian_contact_yields_as_far_as_hertz_says():
    """2/5 k δ^(5/2) = ½ m v². At its deepest the overlap is flat: samples miss it by (ω dt)²/8 ~ 1e-6."""
    stiffness, speed, dt = 100.0, 2.0, 1e-4
    deepest = (1.25 * REDUCED * speed**2 / stiffness) ** 0.4
    run = collide(pc.SoftSpheres(stiffness, exponent=1.5), speed, dt, 0)
    overlaps = []
    for _ in range(6000):
        run.step(1)
        overlaps.append(1.0 - np.diff(run.positions[:, 0])[0])
    assert max(overlaps) == pytest.approx(deepest, rel=1e-5)
    assert overlaps[-1] < 0.0
    assert np.diff(run.velocities[:, 0])[0] == pytest.approx(speed, rel=1e-5)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("law", ["damped", "rubbing", "rubbing Hertz"])
def test_the_budget_of_damped_grains_closes(law, kind, record_property):
    """What the grains lose is what was metered as dissipated, pair by pair.

    Where a contact begins the damping jumps, at any place within a step: of a contact's loss, some γ/m times its
    duration, the fraction dt over the duration is uncertain: γ u² dt, beside a loss of γ u² times the duration, which
    is 0.1 s here. That is 1e-3 of the loss for dt = 1e-4, if every one errs to the same side.
    """
    people = crowd(law, 2, kind)
    run = simulation(people.scene(), pc.VelocityVerlet(), 1e-4)
    before = run.energy()
    run.step(10_000)
    after = run.energy()
    assert after.dissipated > 0.1 * before.total
    hole = (after.balance - before.balance) / after.dissipated
    record_property("hole", f"{hole:.1e}")
    assert abs(hole) < 1e-3
    assert after.dissipated == pytest.approx(before.total - after.total, rel=2e-3)


@pytest.mark.parametrize("height", [1.0, 10.0, 30.0])
def test_grains_at_rest_are_stepped_so_that_they_can_meet(height):
    """Hertz's contact has no stiffness before it begins, and the speed of the impact is still to come.

    However soon that is: the time step starts from a contact that is pressed in a little, and becomes smaller where
    it is pressed in more. Verlet at half the limit swings by (ω dt)²/4 ~ 6 % of the contact's energy while it lasts,
    and little of that is left when the grains part.
    """
    anvil, ball = (
        pc.Particles([[0.0, 0.0]], radius=0.1, fixed=True),
        pc.Particles([[0.0, height]], mass=0.1, radius=0.1),
    )
    scene = pc.Scene(anvil, ball, pc.SoftSpheres(1e6, exponent=1.5), pc.Gravity((0.0, -9.81)))
    run = pc.Simulation(scene)
    run.run(1.05 * np.sqrt(2.0 * height / 9.81))
    assert run[ball].velocities[0, 1] > 0.0
    assert run.energy().total == pytest.approx(0.1 * 9.81 * height, rel=0.06)


def test_single_precision_is_refused_where_distances_have_no_square_in_it():
    """1e-28 m has the square 1e-56, and the smallest number is 1e-45: such grains would not feel each other."""

    def grains(size: float, precision: str) -> pc.Simulation:
        pair = pc.Particles([[0.0, 0.0], [1.9 * size, 0.0]], radius=size)
        return pc.Simulation(pc.Scene(pair, pc.SoftSpheres(1.0)), dt=1e-3, precision=precision)

    with pytest.raises(pc.SceneError, match="precision: expected f64, got f32 for forces that reach"):
        grains(1e-28, "f32")
    for size, precision in ((1e-28, "f64"), (1e-12, "f32")):
        run = grains(size, precision)
        run.step(1)
        # Half of the overlap's force, once: k δ dt²/2m.
        assert run.velocities[1, 0] == pytest.approx(0.1 * size * 1e-3, rel=1e-4)
        assert run.velocities[0, 0] == -run.velocities[1, 0]


def test_a_gas_in_a_domain_smaller_than_its_speed_per_frame_is_shown_inside():
    people = crowd("linear", 2, "closed").changed(domain=domain("closed", 2))
    run = simulation(people.scene(velocities=people.velocities * 50.0), pc.VelocityVerlet(), 1e-3)
    recording = run.record(1.0, fps=7.0)
    assert ((recording.positions >= 0.0) & (recording.positions < SIDE)).all()


def fastest(positions: Array, radii: Array, masses: Array, stiffness: float) -> float:
    """The largest ω² of soft spheres where they stand: Σ k nnᵀ − F/d (1 − nnᵀ) between every two that overlap."""
    count, dimension = positions.shape
    matrix = np.zeros((count, dimension, count, dimension))
    for one, other in np.argwhere(np.triu(np.ones((count, count)), 1)):
        apart = positions[one] - positions[other]
        distance = np.linalg.norm(apart)
        overlap = radii[one] + radii[other] - distance
        if overlap > 0.0:
            along = np.outer(apart, apart) / distance**2
            block = stiffness * (along - overlap / distance * (np.eye(dimension) - along))
            for i, j, sign in ((one, one, 1), (other, other, 1), (one, other, -1), (other, one, -1)):
                matrix[i, :, j] += sign * block
    root = np.repeat(np.sqrt(masses), dimension)
    return float(np.linalg.eigvalsh(matrix.reshape(root.size, -1) / np.outer(root, root))[-1])


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("dimension", [2, 3])
def test_no_mode_of_a_heap_is_faster_than_the_limit_says(dimension, seed, record_property):
    """Grains of unlike sizes on a shaken lattice, pressed together; the limit allows for more contacts than they have.

    Undamped, that of Verlet is 2/ω.
    """
    rng = np.random.default_rng(seed)
    positions = pc.block((0.0,) * dimension, ({2: 8.0, 3: 4.0}[dimension],) * dimension, 1.0)
    positions += rng.uniform(-0.1, 0.1, positions.shape)
    radii = rng.uniform(0.45, 0.6, len(positions))
    masses = radii**dimension
    scene = pc.Scene(pc.Particles(positions, mass=masses, radius=radii), pc.SoftSpheres(100.0))
    allowed = 4.0 / pc.stability_limit(scene, pc.VelocityVerlet()) ** 2
    found = fastest(positions, radii, masses, 100.0)
    record_property("ω² beside the bound", f"{found / allowed:.2f}")
    assert 0.2 * allowed < found <= allowed


def test_the_limit_of_a_triangular_lattice_is_that_of_theory():
    """Discs that just touch their six neighbors have ω² ≤ 6 k/m (at the corner of the zone's edge, along it)."""
    cell = np.array([[0.0, 0.0], [0.5, np.sqrt(0.75)]])
    corners = np.stack(np.meshgrid(np.arange(6), np.arange(3), indexing="ij"), axis=-1).reshape(-1, 1, 2)
    positions = (corners * [1.0, np.sqrt(3.0)] + cell).reshape(-1, 2) + 0.25
    lattice = pc.Particles(positions, mass=2.0, radius=0.5 + 1e-9)
    scene = pc.Scene(lattice, pc.SoftSpheres(100.0), pc.Periodic((0.0, 0.0), (6.0, 3.0 * np.sqrt(3.0))))
    assert pc.stability_limit(scene, pc.VelocityVerlet()) == pytest.approx(2.0 / np.sqrt(6.0 * 100.0 / 2.0), rel=1e-6)


@pytest.mark.parametrize(("dimension", "aligned"), [(2, 3.0), (3, 4.5)])
def test_the_limit_of_flying_grains_is_that_of_their_hardest_impact(dimension, aligned):
    """Two of the heaviest meet head on at the largest speed v and turn where ½ (m/2)(2v)² = ⅖ k δ^(5/2).

    There Hertz's stiffness is 3/2 k √δ. The contacts of equal spheres around one, 60° apart, hold it in no direction
    with more than 3 of them in 2D and 9/2 in 3D; a mode in which neighbors move against each other has twice that.
    """
    flying = np.zeros((3, dimension))
    flying[0, 0] = 2.0
    masses = [0.1, 0.1, 0.05]
    grains = pc.Particles(np.arange(3.0)[:, None] * np.eye(dimension)[-1], flying, mass=masses, radius=0.2)
    overlap = (2.5 * 0.1 * 2.0**2 / 1e4) ** 0.4
    stiffness = 2.0 * aligned * 1.5 * 1e4 * np.sqrt(overlap)
    limit = pc.stability_limit(pc.Scene(grains, pc.SoftSpheres(1e4, exponent=1.5)), pc.VelocityVerlet())
    assert limit == pytest.approx(2.0 / np.sqrt(stiffness / 0.05), rel=1e-12)


def test_the_limit_of_two_atoms_is_that_of_their_vibration():
    """ω² = 2 U''/m for two that are pressed together, whatever their force across the pair: less than U'' there."""
    distance = 0.7
    atoms = pc.Particles([[0.0, 0.0], [0.6 * distance, 0.8 * distance]], mass=3.0)
    six = distance**-6
    stiffness = 24.0 * (26.0 * six**2 - 7.0 * six) / distance**2
    limit = pc.stability_limit(pc.Scene(atoms, pc.LennardJones(1.0, 1.0)), pc.VelocityVerlet())
    assert limit == pytest.approx(2.0 / np.sqrt(2.0 * stiffness / 3.0), rel=1e-9)
