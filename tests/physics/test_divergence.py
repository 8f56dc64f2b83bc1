"""Divergence: a run that blows up says so, where and why, and stands where it was good; nothing else alarms."""

from __future__ import annotations

import contextlib
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import physcore as pc
from physics.laboratory import (
    ALL,
    LONG,
    amplification,
    largest_step,
    name,
    network,
    simulation,
    state,
    unwarned,
    wide_edge,
)

STABLE = [integrator for integrator in ALL if not isinstance(integrator, pc.ExplicitEuler)]
NETWORK = network(seed=7, dimension=2, count=9)
HANGING = pc.Scene(NETWORK.body(fixed=[0], damping=0.5), pc.Gravity((0.0, -1.0)))


def edge(scene: pc.Scene, integrator: pc.Integrator) -> float:
    """The limit of stability, or where a wide region of instability begins above a narrow one."""
    return pc.stability_limit(scene, integrator) * wide_edge(integrator) / largest_step(integrator)


def unstable(integrator: pc.Integrator, factor: float = 1.3, **numerics) -> pc.Simulation:
    return simulation(HANGING, integrator, factor * edge(HANGING, integrator), **numerics)


def beyond(integrator: pc.Integrator) -> float:
    """A multiple of the limit that blows up. At twice its own DormandPrince5 grows by a few percent per step without
    damping, and not at all in this net; at four times it grows by several times.
    """
    return 4.0 if isinstance(integrator, pc.DormandPrince5) else 2.0


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("integrator", STABLE, ids=name)
def test_a_run_above_the_limit_is_stopped_with_a_diagnosis(integrator, precision):
    run = unstable(integrator, factor=beyond(integrator), precision=precision)
    with pytest.raises(pc.SimulationDiverged) as caught:
        run.step(100_000)
    error = caught.value
    assert 1 <= error.step < 100_000
    assert error.time == pytest.approx(error.step * run.dt, rel=1e-12)
    assert 0 <= error.particle < len(NETWORK.mass)
    assert error.quantity in {"position", "velocity", "energy"}
    assert error.cause
    assert "would hold" in error.hint
    for word in (str(error.step), error.cause, error.hint):
        assert word in str(error)
    assert run.steps == error.step - 1
    assert np.isfinite(state(run)).all()
    assert np.array_equal(error.last_good.positions, run.positions)
    assert np.array_equal(error.last_good.velocities, run.velocities)
    assert error.last_good.time == run.time


@pytest.mark.parametrize("factor", [150.0, 1e4])
@pytest.mark.filterwarnings("ignore:dt = :physcore.StabilityWarning")
def test_a_step_far_beyond_the_limit_is_told_the_limit_at_the_start(factor):
    """The limit did not fall: the step that is named holds."""
    scene = pc.Scene(pc.rope(20, 1.0, 1e4, mass=0.01, pinned="start"), pc.Gravity((0.0, -9.81)))
    limit = float(pc.stability_limit(scene, pc.VelocityVerlet()))
    with pytest.raises(pc.SimulationDiverged) as caught:
        pc.Simulation(scene, integrator="VelocityVerlet", dt=factor * limit).step(1000)
    hint = caught.value.hint
    assert "at the start, set by springs; take dt = " in hint
    held = float(hint.rpartition("take dt = ")[2].split()[0])
    assert 0.5 * limit < held <= limit
    pc.Simulation(scene, integrator="VelocityVerlet", dt=held).step(1000)


@pytest.mark.parametrize("kind", ["well", "spring"])
@pytest.mark.parametrize("integrator", STABLE, ids=name)
def test_a_slow_growth_is_noticed_however_far_it_has_come(integrator, kind):
    """In one long call the numbers may be close to overflow, and the energy beyond it, before anybody looks."""
    start = [[1.0, 0.0]]
    well = pc.Scene(pc.Particles(start), pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0))
    spring = pc.Scene(pc.SpringNetwork([[0.0, 0.0], *start], [[0, 1]], 1.0, rest_length=0.0, fixed=[0]))
    scene = {"well": well, "spring": spring}[kind]
    for factor in (1.001, 1.01, 1.1):
        for steps in (2000, 10_000, 200_000):
            dt = factor * edge(scene, integrator)
            growth = np.abs(np.linalg.eigvals(amplification(integrator, dt))).max()
            if steps * math.log(growth) < math.log(1e4):
                continue  # less than a thousandfold, in energy a million, need not be seen
            run = simulation(scene, integrator, dt)
            with pytest.raises(pc.SimulationDiverged):
                run.step(steps)


def test_the_hint_holds():
    """The dt that the hint names does what it promises."""
    run = unstable(pc.VelocityVerlet(), factor=2.0)
    with pytest.raises(pc.SimulationDiverged) as caught:
        run.step(100_000)
    assert caught.value.hint.count("dt = ") == 2
    dt = float(caught.value.hint.rsplit("dt = ", 1)[1].split()[0])
    better = simulation(HANGING, pc.VelocityVerlet(), dt)
    better.step(10_000)
    assert np.isfinite(state(better)).all()


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_told_to_ignore_it_a_runaway_goes_on_to_the_first_value_that_is_not_finite(precision):
    """A11: at 1.01 of the limit Verlet grows by 1.3266 per step, and x leaves the range after some 310 or 2500 steps.

    ln(3.4e38)/ln(1.3266) = 314 and ln(1.8e308)/ln(1.3266) = 2511, less what v ≈ 2x and the sums in the step take: 1 %.
    """
    well = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0))
    run = simulation(well, pc.VelocityVerlet(), 2.02, precision=precision, on_divergence="ignore")
    with pytest.raises(pc.SimulationDiverged, match="not finite") as caught:
        run.step(100_000)
    expected = np.log(float(np.finfo(precision.replace("f", "float")).max)) / np.log(1.326584426950908)
    assert caught.value.step == pytest.approx(expected, rel=0.02)
    assert np.isfinite(state(run)).all()
    strict = simulation(well, pc.VelocityVerlet(), 2.02, precision=precision)
    with pytest.raises(pc.SimulationDiverged, match="run away") as early:
        strict.step(100_000)
    # Runaway: a rise by 1e6 times the largest energy, which follows the growth: about 25 to 60 steps.
    assert early.value.step < 100


def test_told_to_ignore_it_an_energy_that_is_not_finite_is_said():
    """After 1500 steps of the test above |x| is about 1.3266¹⁵⁰⁰ = 1e184, the square of which is beyond f64."""
    well = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0))
    run = simulation(well, pc.VelocityVerlet(), 2.02, on_divergence="ignore")
    run.step(500)
    assert np.isfinite(run.energy().total)
    run.step(1000)
    with pytest.warns(pc.StabilityWarning, match=r"beyond the range of numbers \(inf\)"):
        run.energy()


def test_told_to_ignore_it_an_angular_momentum_that_is_not_finite_is_said():
    """|x| and |v| are about 1e184, and so is the momentum; their product is beyond f64."""
    orbit = pc.Particles([[1.0, 0.0], [-1.0, 0.0]], [[0.0, 1.0], [0.0, -1.0]], mass=[1.0, 2.0])
    run = simulation(
        pc.Scene(orbit, pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0)),
        pc.VelocityVerlet(),
        2.02,
        on_divergence="ignore",
    )
    run.step(1500)
    assert np.isfinite(run.momentum()).all()
    with pytest.warns(pc.StabilityWarning, match=r"the angular momentum at .* beyond the range of numbers"):
        run.angular_momentum()


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
def test_the_energy_of_coincident_atoms_is_infinite_and_that_is_said():
    """A wall stops both atoms at one point in the first step: U(0) = ∞, and neither NaN nor silence."""
    atoms = pc.Particles([[0.0, 0.0], [0.3, 0.0]], [[1.0, 0.0], [2.0, 0.0]])
    run = pc.Simulation(
        pc.Scene(atoms, pc.LennardJones(1e-3, 0.1, 0.25), pc.Plane((0.5, 0.0), (-1.0, 0.0), restitution=0.0)),
        dt=1.0,
        integrator=pc.SemiImplicitEuler(),
    )
    run.step(1)
    assert (run.positions[0] == run.positions[1]).all()
    with pytest.warns(pc.StabilityWarning, match=r"the energy at .* \(inf\): it has diverged, or particles coincide"):
        assert run.energy().potential == np.inf


def test_a_force_of_the_users_that_is_not_finite_is_named():
    broken = pc.CustomForce(lambda time, x, v: np.full_like(x, np.nan if time > 0.5 else 0.0))
    run = pc.Simulation(pc.Scene(pc.Particles([[0.0, 0.0]]), broken), dt=0.125)
    with pytest.raises(pc.PhyscoreError, match=r"forces\[0\]\.function"):
        run.step(10)


@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_an_oscillation_does_not_alarm_however_its_energy_spirals(integrator):
    """A01 run through, and on: explicit Euler multiplies its energy by 7.9e6 in 1024 steps, because it must."""
    well = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0))
    run = simulation(well, integrator, 0.125)
    run.step(1024)
    run.step(4096)
    assert np.isfinite(state(run)).all()


@pytest.mark.parametrize("integrator", ALL, ids=name)
@pytest.mark.parametrize("dt", [10.0, 1000.0])
def test_a_free_fall_of_a_million_seconds_is_no_divergence(integrator, dt):
    run = simulation(pc.Scene(pc.Particles([[0.0, 0.0]]), pc.Gravity((0.0, -9.81))), integrator, dt)
    run.run(1e6)
    # v = g t; x = g t²/2, of which the methods of order 1 are off by g t dt/2.
    assert run.velocities[0, 1] == pytest.approx(-9.81e6, rel=1e-9)
    assert run.positions[0, 1] == pytest.approx(-9.81e12 / 2.0, rel=1e-9 if integrator.order > 1 else 1.1 * dt / 1e6)


@pytest.mark.parametrize("integrator", STABLE, ids=name)
def test_the_crack_of_a_whip_is_no_divergence(integrator):
    """A tapering rope whose handle is swung and stopped: its tip becomes several times as fast, and that is physics."""
    count = 60
    mass = np.linspace(0.02, 0.0005, count)
    handle = np.zeros((count, 2))
    handle[0] = (0.0, 6.0)
    whip = pc.rope(count, 2.0, 2000.0, damping=0.02, mass=mass, pinned="start", velocities=handle)
    scene = pc.Scene(whip, pc.Gravity((0.0, -9.81)))
    run = simulation(scene, integrator, 0.4 * pc.stability_limit(scene, integrator))
    run.run(0.3)
    run.set(velocities=np.where(np.arange(count)[:, None] == 0, 0.0, run.velocities))
    fastest = 0.0
    for _ in range(100):
        run.run(0.01)
        fastest = max(fastest, float(np.linalg.norm(run.velocities, axis=1).max()))
    assert fastest > 12.0


@pytest.mark.parametrize("integrator", STABLE, ids=name)
def test_a_scene_that_comes_to_rest_is_no_divergence(integrator):
    """However long a single call: what is left of the motion at its end is not the scale of its energy."""
    rope = pc.rope(10, 1.0, 100.0, damping=0.05, mass=0.01, pinned="start")
    scene = pc.Scene(rope, pc.Gravity((0.0, -9.81)), pc.Drag(0.02))
    for fraction in (0.1, 0.5, 0.9):
        run = simulation(scene, integrator, fraction * pc.stability_limit(scene, integrator))
        run.step(int(60.0 / run.dt))
        # The pendulum's amplitude falls by exp(−t b/2m) = exp(−t/s): nothing but rounding is left.
        assert run.energy().kinetic < 1e-20


@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_a_particle_released_from_rest_is_no_divergence(integrator):
    """Explicit Euler's balance rises in the very first step, by (a dt)²/2, before anything has moved."""
    scene = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0), pc.Drag(0.5))
    run = simulation(scene, integrator, 0.1)
    for _ in range(10):
        run.step(1)
    run.step(10_000)
    assert np.abs(run.positions).max() < 1e-6


@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_a_fall_into_a_bare_center_is_finite_or_diagnosed(integrator):
    """C03: nothing resolves r = 0. The particle comes out somewhere, or the run says that it ran away; never NaN."""
    scene = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 2.0))
    run = simulation(scene, integrator, 1e-3)
    with contextlib.suppress(pc.SimulationDiverged):
        run.step(5000)
    assert np.isfinite(state(run)).all()


def outcome(run: pc.Simulation, pieces: list[int]) -> tuple[object, ...]:
    """How a run ends whose steps are asked for in pieces: what is said of a divergence, and where it then stands."""
    said: tuple[object, ...] = ()
    try:
        for piece in pieces:
            run.step(piece)
    except pc.SimulationDiverged as error:
        said = (error.step, error.time, error.particle, error.quantity, error.cause, error.hint)
    return (*said, run.steps, run.substeps, run.time, run.state_hash())


PIECES = {
    "one by one": [1] * 400,
    "unequal": [1, 7, 64, 3, 125, 200],
    "halves": [200] * 2,
}


@pytest.mark.parametrize("integrator", STABLE, ids=name)
def test_the_step_that_is_taken_in_parts_does_not_depend_on_how_steps_were_asked_for(integrator):
    """It is a function of the trajectory; the rope whips, so energy comes and goes."""
    rope = pc.Scene(pc.rope(6, 1.0, 100.0, mass=0.01))
    motion = np.sin(np.arange(12.0)).reshape(6, 2)

    def run() -> pc.Simulation:
        made = simulation(rope, integrator, 1.3 * edge(rope, integrator), on_divergence="substep")
        made.set(velocities=motion)
        return made

    with unwarned():
        whole = outcome(run(), [400])
        assert {name: outcome(run(), pieces) for name, pieces in PIECES.items()} == dict.fromkeys(PIECES, whole)


@pytest.mark.parametrize("seed", [4, 6, 10, 17, 26])
def test_a_rope_that_whips_above_the_limit_fails_at_one_step(seed):
    """Its energy comes and goes for hundreds of steps before it runs away, so that it matters when somebody looks."""
    rng = np.random.default_rng(seed)
    motion = rng.normal(size=(3, 2)) * 10.0 ** rng.uniform(-3.0, 1.0)
    rope = pc.Scene(pc.rope(3, 1.0, 100.0, mass=0.01))

    def ended(pieces: list[int]) -> tuple[object, ...]:
        run = simulation(rope, pc.PEFRL(), 1.3 * pc.stability_limit(rope, pc.PEFRL()))
        run.set(velocities=motion)
        return outcome(run, pieces)

    assert len({ended(pieces) for pieces in ([6000], [1] * 6000, [100] * 60, [50] * 120, [60] * 100)}) == 1


@settings(max_examples=4 if not LONG else 1000)
@given(
    seed=st.integers(0, 10**6),
    factor=st.floats(0.8, 4.0),
    integrator=st.sampled_from(STABLE),
    precision=st.sampled_from(["f64", "f32"]),
    rule=st.sampled_from(["raise", "substep", "ignore"]),
    pieces=st.lists(st.integers(1, 60), min_size=1, max_size=12),
)
def test_random_networks_fail_at_one_step_however_it_is_reached(seed, factor, integrator, precision, rule, pieces):
    scene = pc.Scene(network(seed, 2, 7, damping=0.1, motion=1.0).body(fixed=[0]), pc.Gravity((0.0, -1.0)))
    numerics = {"precision": precision, "on_divergence": rule, "max_energy_growth": 10.0}
    dt = factor * edge(scene, integrator)
    with unwarned():
        whole, parts = (simulation(scene, integrator, dt, **numerics) for _ in range(2))
        assert outcome(whole, [sum(pieces)]) == outcome(parts, pieces)


def test_taken_in_parts_a_step_above_the_limit_stays_bounded():
    """At 1.5 times the limit, halves are stable: the energy stays within what the monitor lets pass, a doubling."""
    rope = pc.Scene(pc.rope(6, 1.0, 100.0, mass=0.01))
    run = simulation(rope, pc.VelocityVerlet(), 1.5 * edge(rope, pc.VelocityVerlet()), on_divergence="substep")
    run.set(velocities=np.sin(np.arange(12.0)).reshape(6, 2))
    start = run.energy()
    with unwarned():
        for _ in range(300):
            run.step(1)
    assert run.substeps > 100
    # Verlet's energy at 0.75 of the limit is off by up to 1/(1 − 0.75²) = 2.3 times, beside the rise that is let pass.
    assert run.energy().total < 2.0 * 2.3 * start.total


class TestNumbersOutOfRange:
    """Nothing that is not finite goes on in silence."""

    @pytest.mark.parametrize("what", ["positions", "velocities"])
    def test_what_single_precision_cannot_hold_is_refused(self, what):
        body = pc.Particles(**{"positions": [[0.0, 0.0], [1.0, 0.0]], what: [[0.0, 0.0], [1e39, 0.0]]})
        with pytest.raises(pc.SceneError, match=rf"^bodies\[0\]\.{what}.*: .* range of f32"):
            pc.Simulation(pc.Scene(body), precision="f32", dt=0.1)
        run = pc.Simulation(pc.Scene(pc.Particles([[0.0, 0.0], [1.0, 0.0]])), precision="f32", dt=0.1)
        before = run.state_hash()
        with pytest.raises(pc.SceneError, match=rf"^set\.{what}\[1\]: .* range of f32"):
            run.set(**{what: [[0.0, 0.0], [1e39, 0.0]]})
        assert run.state_hash() == before

    def test_atoms_at_the_same_place_are_named(self):
        atoms = pc.Particles([[0.0, 0.0], [2.0, 0.0], [5.0, 1.0], [2.0, 0.0]])
        with pytest.raises(pc.SceneError, match=r"energy that is finite.*particles 1 and 3 coincide"):
            pc.Simulation(pc.Scene(atoms, pc.LennardJones(1.0, 1.0)), dt=1e-3)

    def test_a_state_that_is_refused_leaves_no_trace_in_the_lists_of_neighbors(self):
        rng = np.random.default_rng(2)
        atoms = pc.Particles(pc.block((0.0, 0.0), (5.0, 5.0), 1.0), rng.uniform(-1.0, 1.0, (25, 2)))
        run, plain = (pc.Simulation(pc.Scene(atoms, pc.LennardJones(1.0, 0.9)), dt=2e-3) for _ in range(2))
        run.step(50)
        places = run.positions
        places[3] = places[4]
        with pytest.raises(pc.SceneError, match="particles 3 and 4 coincide"):
            run.set(positions=places)
        run.step(200)
        plain.step(250)
        assert run.state_hash() == plain.state_hash()

    @pytest.mark.parametrize("pieces", [[15], [1] * 15, [2] * 8])
    @pytest.mark.parametrize("integrator", ALL, ids=name)
    def test_a_step_that_carries_a_particle_out_of_range_fails(self, integrator, pieces):
        """10 m/s · n · 1e37 s passes 3.4e38 m in the fourth step."""
        free = pc.Scene(pc.Particles([[0.0, 0.0]], [[10.0, 0.0]]))
        run = simulation(free, integrator, 1e37, precision="f32")
        assert outcome(run, pieces)[0] == 4
        assert np.isfinite(run.positions).all()

    @pytest.mark.parametrize("pieces", [[10_000], [1] * 10_000, [999] * 11])
    def test_the_spiral_of_explicit_euler_ends_where_its_energy_leaves_the_range(self, pieces):
        """√(1 + h²)ⁿ passes √(2 · 1.8e308), whose energy is out of range, at n = ln(3.6e308)/ln(1 + h²) = 1781.

        The energy then is all kinetic, or will be within a quarter of a turn, some three steps.
        """
        well = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0))
        run = simulation(well, pc.ExplicitEuler(), 0.7)
        ended = outcome(run, pieces)
        assert ended[0] == pytest.approx((math.log(2.0) + math.log(np.finfo(float).max)) / math.log(1.49), abs=3)
        assert np.isfinite(run.energy().total)


def test_the_onset_of_a_force_is_no_divergence():
    """Where all was at rest, the first step under a force has no work that a trapezoid could see, and no scale."""

    def push(time, x, v):
        return np.where(time > 1.0, 1.0, 0.0) + 0.0 * x

    run = pc.Simulation(pc.Scene(pc.Particles([[0.0, 0.0], [1.0, 0.0]]), pc.CustomForce(push)), dt=0.1)
    run.step(30)
    # From the first evaluation after 1 s on, and half of the step before it: v = 2 s · 1 m/s² within one step.
    assert run.velocities[0, 0] == pytest.approx(2.0, abs=0.1)
