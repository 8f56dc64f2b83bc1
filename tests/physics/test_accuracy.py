"""Accuracy that was asked for is kept, proved and told; what cannot be had is refused with what can."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import physcore as pc
from physcore.studies.tradeoff.convergence import AGREEMENT, convergence, stagnant
from physcore.studies.tradeoff.experiment import Experiment
from physics.laboratory import ALL, LONG, name, network, orbits

pytestmark = pytest.mark.usefixtures("clock_of_work")

E = 0.6
ORBIT = pc.Scene(
    pc.Particles([[1.0 - E, 0.0]], velocities=[[0.0, math.sqrt((1.0 + E) / (1.0 - E))]]),
    pc.CentralForce((0.0, 0.0), 1.0, exponent=-2.0),
)
"""An ellipse around a unit mass, from perihelion; its period is 2π."""


def kepler(times: np.ndarray) -> np.ndarray:
    """Where the planet is, by Kepler's equation M = u − e sin u, solved by Newton's method."""
    u = times.copy()
    for _ in range(50):
        u -= (u - E * np.sin(u) - times) / (1.0 - E * np.cos(u))
    return np.stack([np.cos(u) - E, math.sqrt(1.0 - E * E) * np.sin(u)], axis=1)


@pytest.mark.parametrize("accuracy", [1e-2, 1e-5, 1e-9])
def test_an_orbit_is_as_accurate_as_was_asked_for(accuracy, capsys):
    recording = pc.simulate(ORBIT, 20.0, fps=8.0, accuracy=accuracy)
    off = np.linalg.norm(recording.positions[:, 0] - kepler(recording.times), axis=1).max()
    assert off <= accuracy
    said = capsys.readouterr().out
    assert "keeps within" in said
    assert recording.plan.notes[-1] == said.strip()
    assert len(recording.times) == 161
    run = pc.Simulation(ORBIT, getattr(pc, recording.plan.integrator)(), recording.plan.dt)
    assert np.array_equal(run.record(20.0, 8.0).positions, recording.positions)


@pytest.mark.parametrize("seed", range(30 if LONG else 5))
def test_random_networks_are_as_accurate_as_was_asked_for(seed, record_property):
    """Against steps of a hundredth of the limit, of another family where there is one of high order: 0.03⁴ = 1e-6 of
    the fastest oscillations' 5 % at most.
    """
    generator = np.random.default_rng(seed)
    damping = float(generator.choice([0.0, 0.3]))
    scene = network(seed, dimension=3, count=int(generator.integers(2, 12)), damping=damping).scene()
    target = 10.0 ** generator.uniform(-7.0, -2.0)
    recording = pc.simulate(scene, 3.0, fps=10.0, accuracy=target)
    chosen = recording.plan.integrator
    other = pc.BlanesMoan6() if chosen == "RungeKutta4" and damping == 0.0 else pc.RungeKutta4()
    limit = pc.stability_limit(scene, other)
    truth = pc.simulate(scene, 3.0, fps=10.0, integrator=other, dt=0.1 / math.ceil(0.1 / (0.01 * limit)))
    off = float(np.linalg.norm(recording.positions - truth.positions, axis=2).max())
    record_property("error over what was asked for", off / target)
    assert off <= target


@pytest.mark.parametrize("drift", [1e-2, 1e-5, 1e-8])
def test_an_energy_budget_is_kept(drift):
    recording = pc.simulate(ORBIT, 20.0, fps=8.0, energy_drift=drift)
    assert np.abs(recording.energy.drift).max() <= drift


@pytest.mark.parametrize("integrator", ALL, ids=name)
def test_an_integrator_that_is_given_is_the_one_that_is_used(integrator):
    scene = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0))
    recording = pc.simulate(scene, 2.0, fps=8.0, accuracy=1e-3, integrator=integrator)
    assert recording.plan.integrator == name(integrator)
    assert np.abs(recording.positions[:, 0, 0] - np.cos(recording.times)).max() <= 1e-3


def test_what_no_number_holds_is_refused_with_the_best_there_is():
    with pytest.raises(pc.AccuracyError, match="no method gets there") as caught:
        pc.simulate(ORBIT, 6.0, fps=4.0, accuracy=1e-18)
    assert 1e-17 < caught.value.error < 1e-11
    copy = pickle.loads(pickle.dumps(caught.value))
    assert (str(copy), copy.error) == (str(caught.value), caught.value.error)


def test_chaos_is_refused():
    step = np.array([math.sin(3.0), -math.cos(3.0)])
    rods = pc.SpringNetwork(np.arange(3.0)[:, None] * step, [[0, 1], [1, 2]], 200.0, fixed=[0])
    with pytest.raises(pc.AccuracyError, match="chaotic"):
        pc.simulate(pc.Scene(rods, pc.Gravity((0.0, -9.81))), 60.0, fps=2.0, accuracy=1e-6)


def test_it_can_be_had_in_single_precision_as_far_as_that_goes():
    assert pc.simulate(ORBIT, 3.0, fps=4.0, accuracy=1e-3, precision="f32").plan.precision == "f32"
    with pytest.raises(pc.AccuracyError):
        pc.simulate(ORBIT, 3.0, fps=4.0, accuracy=1e-10, precision="f32")


def test_a_fluid_keeps_its_energy_budget():
    water = pc.Fluid(pc.block((0.0, 0.0), (0.2, 0.4), 0.05), 0.05)
    scene = pc.Scene(water, pc.Gravity((0.0, -9.81)), pc.Box((0.0, 0.0), (0.8, 0.8)))
    method = pc.WeaklyCompressible(sound_speed=30.0)
    recording = pc.simulate(scene, 0.2, fps=20.0, energy_drift=1e-3, channels=("densities",), fluids=method)
    assert recording.plan.integrator in ("VelocityVerlet", "McLachlan2")  # the others do not carry densities
    assert recording.densities.shape == (5, 32)
    assert np.abs(recording.energy.drift).max() <= 1e-3


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"accuracy": 0.0}, "accuracy: must be > 0"),
        ({"energy_drift": -1.0}, "energy_drift: must be > 0"),
        ({"accuracy": 1e-3, "dt": 0.1}, "dt: is what accuracy= and energy_drift= choose"),
        ({"accuracy": 1e-3, "fps": 0.1}, "fps: there is no frame but the first"),
        ({"accuracy": 1e-3, "integrator": "best"}, "integrator: must be one of"),
        ({"accuracy": 1e-3, "channels": ("colors",)}, "channels: must be"),
    ],
)
def test_bad_input_is_named(arguments, message):
    with pytest.raises(pc.SceneError, match=message):
        pc.simulate(**{"scene": ORBIT, "duration": 1.0, **arguments})


@pytest.mark.parametrize(
    ("options", "advised", "spared"),
    [
        ({"precision": "f32"}, ['precision="f64"'], ["leave integrator out"]),
        ({"integrator": pc.VelocityVerlet()}, ["leave integrator out"], ["precision="]),
        ({"precision": "f64"}, ["chaotic"], ["precision=", "leave integrator out"]),
    ],
    ids=str,
)
def test_the_hint_of_an_accuracy_that_is_out_of_reach_names_what_is_not_in_use(options, advised, spared):
    well = pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0))
    with pytest.raises(pc.AccuracyError, match="accuracy: no method gets there") as caught:
        pc.simulate(well, 0.5, accuracy=1e-30, **options)
    assert all(hint in str(caught.value) for hint in advised)
    assert not any(hint in str(caught.value) for hint in spared)
    with pytest.raises(pc.AccuracyError, match="energy_drift: no method gets there"):
        pc.simulate(well, 0.5, energy_drift=1e-30, **options)


def evaluations(monkeypatch: pytest.MonkeyPatch) -> list[pc.Simulation]:
    """The simulations that are built from now on."""
    built: list[pc.Simulation] = []
    original = pc.Simulation.__init__

    def init(self: pc.Simulation, *arguments: object, **options: object) -> None:
        original(self, *arguments, **options)
        built.append(self)

    monkeypatch.setattr(pc.Simulation, "__init__", init)
    return built


CLOTH = pc.Scene(
    pc.cloth((4, 3), 0.1, 200.0, damping=0.02, mass=0.01, pinned="top"), pc.Gravity((0.0, -9.81)), pc.Drag(linear=1e-3)
)
SHOT = pc.Scene(
    pc.Particles([[0.0, 0.0]], velocities=[[30.0, 20.0]]), pc.Gravity((0.0, -9.81)), pc.Drag(quadratic=0.02)
)


@pytest.mark.parametrize(
    ("scene", "duration", "targets"),
    [
        *[(ORBIT, 20.0, {"accuracy": 10.0**-power}) for power in (2, 5, 9)],
        *[(ORBIT, 20.0, {"energy_drift": 10.0**-power}) for power in (2, 5, 9)],
        *[(CLOTH, 0.5, {"accuracy": 10.0**-power}) for power in (2, 4, 7)],
        *[(SHOT, 3.0, {"accuracy": 10.0**-power}) for power in (2, 5, 8)],
        (CLOTH, 0.5, {"accuracy": 1e-4, "energy_drift": 1e-5}),
    ],
)
def test_the_choice_costs_at_most_six_of_the_runs_that_it_returns(scene, duration, targets, monkeypatch):
    """Probes of a sixteenth with all methods, then runs with a quarter, half and all of the steps that are needed: 1.75
    of the last one, or 3.5 where nothing but the limit is coarser. Two frames per second leave all steps open.
    """
    built = evaluations(monkeypatch)
    recording = pc.simulate(scene, duration, fps=2.0, **targets)
    spent = sum(run.steps * run.plan.evaluations for run in built)
    returned = sum(segment.steps for segment in recording.provenance.segments) * recording.plan.evaluations
    assert spent <= 6 * returned


@settings(max_examples=10)
@given(orbits(), st.floats(-8.0, -2.0))
def test_random_orbits_are_as_accurate_as_was_asked_for(orbit, decade):
    """Against a method of another family, with steps of a thousandth of the shortest period, of order five or more:
    (2π/1000)⁵ = 1e-11 for a circle, and a thousand times that where a planet comes near the center.
    """
    scene = orbit.scene()
    recording = pc.simulate(scene, 4.0, fps=8.0, accuracy=10.0**decade)
    other = pc.BlanesMoan6() if recording.plan.integrator == "DormandPrince5" else pc.DormandPrince5()
    truth = pc.simulate(scene, 4.0, fps=8.0, integrator=other, dt=1.0 / 8.0 / 256.0)
    assert np.linalg.norm(recording.positions - truth.positions, axis=2).max() <= 10.0**decade


@pytest.mark.parametrize("seed", range(20 if LONG else 4))
def test_balls_that_bounce_in_air_are_as_accurate_as_was_asked_for(seed):
    """Each impact leaves an error of first order, whose size depends on where in a step it comes: small by chance, too.
    Of the reference they are below 1e-5, a tenth of the smallest target: it takes 8192 steps in each frame.
    """
    generator = np.random.default_rng(seed)
    count = int(generator.integers(1, 4))
    places = generator.uniform(0.2, 0.8, (count, 2))
    balls = pc.Particles(places, velocities=generator.normal(scale=2.0, size=(count, 2)), radius=0.05)
    scene = pc.Scene(balls, pc.Gravity((0.0, -9.81)), pc.Box((0.0, 0.0), (1.0, 1.0)), pc.Drag(quadratic=0.2))
    target = 10.0 ** generator.uniform(-4.0, -2.0)
    recording = pc.simulate(scene, 1.0, fps=10.0, accuracy=target)
    truth = pc.simulate(scene, 1.0, fps=10.0, integrator=pc.DormandPrince5(), dt=0.1 / 2**13)
    assert np.linalg.norm(recording.positions - truth.positions, axis=2).max() <= target


def test_a_step_that_diverges_is_halved_once(monkeypatch):
    """Nothing limits the step of two atoms far apart; when they meet, the longest are too long."""
    atoms = pc.Particles([[0.0, 0.0], [4.0, 0.0]], velocities=[[20.0, 0.0], [-20.0, 0.0]])
    scene = pc.Scene(atoms, pc.LennardJones(epsilon=1.0, sigma=1.0))
    runs: list[tuple[int, bool]] = []
    attempt, recorded = Experiment.attempt, Experiment.recorded

    def watched(original):
        def run(self, choice, *arguments):
            try:
                trial = original(self, choice, *arguments)
            except pc.SimulationDiverged:
                runs.append((choice.steps, False))
                raise
            runs.append((choice.steps, trial.complete))
            return trial

        return run

    monkeypatch.setattr(Experiment, "attempt", watched(attempt))
    monkeypatch.setattr(Experiment, "recorded", watched(recorded))
    recording = pc.simulate(scene, 0.5, fps=10.0, accuracy=1e-4, integrator=pc.VelocityVerlet())
    assert np.isfinite(recording.positions).all()
    failed = [index for index, (_, complete) in enumerate(runs) if not complete]
    assert failed
    assert all(runs[index + 1][0] == 2 * runs[index][0] for index in failed)
    assert len({steps for steps, _ in runs}) == len(runs)


def test_errors_that_follow_the_order_are_bounded_closely():
    """e(n) = C n⁻ᵖ exactly: the bound is twice the error of the last run, the safety factor."""
    for order in (1, 2, 4, 6):
        steps = [3, 6, 12]
        errors = [float(count) ** -order for count in steps]
        found = convergence(steps, [errors[0] - errors[1], errors[1] - errors[2]], order)
        assert found.asymptotic
        assert found.order == pytest.approx(order)
        assert errors[2] <= found.finer <= 2.0 * errors[2] * (1.0 + 1e-12)
        assert errors[1] <= found.coarser
        assert found.coarser <= 2.0 * errors[1]


@example(actual=1.51, order=2, share=1.0)  # the largest error of which the order of the method is believed
@example(actual=1.0, order=3, share=1 / 64)  # order 2.5 is measured
@given(actual=st.floats(1.0, 6.0), order=st.integers(1, 6), share=st.floats(0.0, 1.0))
def test_bounds_hold_for_any_order_from_one(actual, order, share):
    """Two terms of different orders, neither below one: whatever is believed, neither run is off by more. One thing is
    not seen: a term of lower order, which the measured order hides. The rest is within the bound: if d = Σ dᵢ with
    orders qᵢ ≥ p − 1/2, the error Σ dᵢ/(2^qᵢ − 1) is at most d/(2^(p − 1/2) − 1) ≤ 2d/(2^p − 1) for p ≥ 2.
    """
    steps = [4, 8, 16]
    errors = [share * count**-actual + (1.0 - share) * float(count) ** -order for count in steps]
    differences = [errors[0] - errors[1], errors[1] - errors[2]]
    for runs in (2, 3):
        found = convergence(steps[-runs:], differences[1 - runs :], order)
        assert errors[1] <= found.coarser * (1.0 + 1e-12)
        hides = found.asymptotic and actual < order - AGREEMENT
        hidden = share * 16.0**-actual if hides else 0.0
        assert errors[2] <= hidden + found.finer * (1.0 + 1e-12)


@pytest.mark.parametrize(("order", "surplus"), [(2, 1), (2, 2), (4, 1), (5, 2)])
def test_errors_that_fall_faster_than_the_order_are_bounded_by_the_order(order, surplus):
    """Errors h^(p+s) in three runs: the bound is not that of order one, which is the last difference and more."""
    steps = [10, 20, 30]
    errors = [float(number) ** -(order + surplus) for number in steps]
    differences = [errors[0] - errors[1], errors[1] - errors[2]]
    found = convergence(steps, differences, order)
    assert not found.asymptotic
    assert errors[2] < found.finer
    assert found.finer <= 2.0001 * differences[0] * (2.0**-order - 3.0**-order) / (1.0 - 2.0**-order) / (
        1.5**order - 1.0
    )


def test_a_difference_that_is_small_by_chance_is_not_believed():
    """7.6e-3, 3.1e-3 and then 9e-7, as bouncing balls gave: the last one says nothing."""
    found = convergence([8, 16, 32, 64], [7.6e-3, 3.1e-3, 9.2e-7], 2)
    assert not found.asymptotic
    assert found.finer == pytest.approx(7.6e-3 / 4.0)
    impacts = convergence([8, 16, 32, 64], [7.6e-3, 3.1e-3, 9.2e-7], 2, certain=1)
    assert impacts.finer == pytest.approx(2.0 * 7.6e-3 / 4.0)
    assert math.isinf(convergence([16, 32, 64], [3.1e-3, 9.2e-7], 2, certain=1).finer)
    assert not convergence([16, 32, 64], [4e-3, 1e-3], 2, certain=1).asymptotic


def test_an_order_that_kinks_may_take_away_is_not_used():
    """Errors that follow order six may hide one of order two: the finer run is believed to be off by two thirds of the
    difference, not by two sixty-thirds.
    """
    steps, differences = [1, 2, 4], [1.0 - 2.0**-6, 2.0**-6 - 4.0**-6]
    assert convergence(steps, differences, 6).finer == pytest.approx(2.0 * differences[1] / 63.0)
    assert convergence(steps, differences, 6, certain=2).finer == pytest.approx(2.0 * differences[1] / 3.0)


def test_rounding_and_chaos_are_told_from_convergence():
    noise = [2.6e-13, 1.3e-13, 2.2e-13, 6.9e-14]
    assert not stagnant([1.0 / 4.0**level for level in range(12)], 1.0)
    assert not stagnant([1.0 / 2.0**level for level in range(12)], 1.0)
    assert stagnant([1e-7, *noise], 1.0)
    assert stagnant([4.2, 3.9, 3.9, 4.3, 4.4, 3.6, 4.3], 4.0)
    assert not stagnant([4.2, 3.9, 3.9, 4.3], 4.0)
    bounces = [1.3e-3, 1.6e-3, 5.4e-5, 3.5e-7, 9.0e-5, 4.6e-5, 3.4e-6, 1.3e-5, 6.4e-6]
    # Of equal reductions per step, some halvings reduce much, and steps that are near each other little.
    steps = [18, 36, 43, 50, 92]
    assert not stagnant([1.0 / count**2 for count in steps], 1.0, steps)
    assert not any(stagnant(bounces[:count], 0.0) for count in range(len(bounces) + 1))


@pytest.mark.parametrize("seed", range(23, 29))
def test_what_is_within_reach_is_not_refused(seed):
    """Steps that are near each other differ by little, which is no stagnation."""
    rng = np.random.default_rng(seed)
    places, duration = rng.normal(size=(8, 3)) * 3.0 + (0.0, 0.0, 25.0), float(rng.uniform(1.0, 4.0))
    scene = pc.Scene(pc.Tracers(places, pc.Lorenz()))
    found = pc.simulate(scene, duration, fps=4.0 / duration, accuracy=1e-4)
    fine = pc.simulate(scene, duration, fps=4.0 / duration, integrator="RungeKutta4", dt=duration / 40_000)
    off = found[scene.systems[0]].positions - fine[scene.systems[0]].positions
    assert np.linalg.norm(off, axis=-1).max() <= 1e-4


def stars(angle: float) -> pc.Scene:
    rng = np.random.default_rng(5)
    places, velocities = rng.normal(size=(600, 3)), 0.3 * rng.normal(size=(600, 3))
    force = pc.Gravitation(1.0, softening=0.05, opening_angle=angle)
    return pc.Scene(pc.Particles(places, velocities, mass=1.0 / 600.0), force)


def test_the_error_of_a_tree_counts():
    """All runs share it, so that no comparison of steps shows it."""
    with pytest.raises(pc.AccuracyError, match=r"^forces\[0\]\.opening_angle: the trees alone are off by") as refused:
        pc.simulate(stars(1.2), 0.5, fps=4, accuracy=1e-5)
    rough = pc.simulate(stars(1.2), 0.5, fps=4, dt=1.0 / 256.0)
    exact = pc.simulate(stars(0.0), 0.5, fps=4, dt=1.0 / 256.0)
    off = np.linalg.norm(rough.positions - exact.positions, axis=-1).max()
    assert off > 1e-5
    assert refused.value.error == pytest.approx(off, rel=0.5)
    pc.simulate(stars(0.2), 0.5, fps=4, accuracy=1e-3)


def test_rods_are_held_by_the_order_that_is_cheaper(capsys):
    rod = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], math.inf, mass=1.0, fixed=[0])
    recording = pc.simulate(pc.Scene(rod, pc.Gravity((0.0, -9.81))), 2.0, fps=8, accuracy=1e-8)
    assert recording.plan.order == 4
