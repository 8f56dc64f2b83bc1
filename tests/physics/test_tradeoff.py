"""The trade between speed and accuracy: slopes are orders, references are right, choices keep their word."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc
from physcore.studies.tradeoff import methods, reference
from physcore.studies.tradeoff.budget import Budget
from physcore.studies.tradeoff.chaos import Chaos, twin
from physcore.studies.tradeoff.experiment import Choice, Experiment
from physcore.studies.tradeoff.restarts import bias
from physics.laboratory import ALL, LONG, name, network

pytestmark = pytest.mark.usefixtures("clock_of_work")

Case = tuple[pc.Scene, float]
"""A scene and its duration [s]."""


def orbit(eccentricity: float, revolutions: int = 3) -> Case:
    """From perihelion, with G M = a = 1."""
    speed = math.sqrt((1.0 + eccentricity) / (1.0 - eccentricity))
    planet = pc.Particles([[1.0 - eccentricity, 0.0]], velocities=[[0.0, speed]])
    return pc.Scene(planet, pc.CentralForce((0.0, 0.0), 1.0, exponent=-2.0)), revolutions * 2.0 * math.pi


def pendulum(speed: float, stiffness: float = 100.0, duration: float = 10.0) -> Case:
    """An elastic pendulum of length and mass one, let go from the horizontal, under a gravity of one."""
    velocities = [[0.0, 0.0], [0.0, speed]]
    bob = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], stiffness, fixed=[0], velocities=velocities)
    return pc.Scene(bob, pc.Gravity((0.0, -1.0))), duration


def double_pendulum(angle: float, duration: float = 60.0) -> Case:
    """Two stiff springs of length one, both at an angle from below."""
    step = np.array([math.sin(angle), -math.cos(angle)])
    places = np.arange(3.0)[:, None] * step
    return pc.Scene(pc.SpringNetwork(places, [[0, 1], [1, 2]], 2000.0, fixed=[0]), pc.Gravity((0.0, -9.81))), duration


def string(count: int, amplitude: float, duration: float) -> Case:
    """A chain between two posts, twice as long as its springs at rest, plucked in its first mode."""
    index = np.arange(count + 1)
    places = np.stack([index.astype(float), amplitude * np.sin(np.pi * index / count)], axis=1)
    pairs = np.stack([index[:-1], index[1:]], axis=1)
    chain = pc.SpringNetwork(places, pairs, 10.0, rest_length=0.5, fixed=[0, count])
    return pc.Scene(chain), duration


def gas(seed: int, spacing: float = 4 / 3, temperature: float = 1.0) -> Case:
    """36 Lennard-Jones atoms in a periodic square."""
    corner = (6.0 * spacing, 6.0 * spacing)
    places = pc.block((0.0, 0.0), corner, spacing)
    velocities = np.random.default_rng(seed).normal(scale=temperature, size=places.shape)
    domain = pc.Periodic((0.0, 0.0), corner)
    return pc.Scene(pc.Particles(places, velocities), pc.LennardJones(epsilon=1.0, sigma=1.0), domain), 20.0


def grains(seed: int, count: int, dimension: int) -> Case:
    """Elastic spheres in a periodic domain."""
    places = pc.block((0.0,) * dimension, (float(count),) * dimension, 1.0)
    velocities = np.random.default_rng(seed).normal(size=places.shape)
    domain = pc.Periodic((0.0,) * dimension, (float(count),) * dimension)
    return pc.Scene(pc.Particles(places, velocities, radius=0.45), pc.SoftSpheres(stiffness=200.0), domain), 20.0


def billiard(angle: float, *obstacles: pc.Boundary) -> Case:
    """A point in a square, with or without something to scatter off (Ya. G. Sinai, 1970)."""
    ball = pc.Particles([[0.8, 0.1]], velocities=[[math.cos(angle), math.sin(angle)]])
    return pc.Scene(ball, pc.Box((-1.0, -1.0), (1.0, 1.0)), *obstacles), 60.0


def well(exponent: float) -> Case:
    bodies = pc.Particles([[1.0, 0.0], [0.5, 0.3]], velocities=[[0.0, 0.7], [0.2, -0.3]])
    return pc.Scene(bodies, pc.CentralForce((0.0, 0.0), 1.0, exponent=exponent)), 30.0


def cloth(duration: float, damping: float) -> Case:
    sheet = pc.cloth((8, 6), 0.1, 200.0, damping=damping, mass=0.01, pinned="top corners")
    return pc.Scene(sheet, pc.Gravity((0.0, -9.81))), duration


def rope(count: int, duration: float) -> Case:
    """It cracks like a whip: nothing damps it."""
    line = pc.rope(count, 1.0, 2000.0, mass=0.01, pinned="start")
    return pc.Scene(line, pc.Gravity((0.0, -9.81))), duration


def thrown(*more: pc.Force | pc.Boundary) -> Case:
    ball = pc.Particles([[0.0, 1.0]], velocities=[[3.0, 4.0]])
    return pc.Scene(ball, pc.Gravity((0.0, -9.81)), *more), 3.0


SCATTERER = pc.Sphere((0.0, 0.0), 0.4)
REGULAR: dict[str, Case] = {
    **{f"orbit {e}": orbit(e, 6) for e in (0.0, 0.3, 0.6, 0.9)},
    "pendulum": pendulum(0.0, duration=40.0),
    "swinging pendulum": pendulum(0.3, duration=100.0),
    "stiff pendulum": pendulum(0.0, stiffness=1e4, duration=20.0),
    "string": string(8, 0.1, 100.0),
    "long string": string(16, 0.05, 60.0),
    "small double pendulum": double_pendulum(0.05),
    "double pendulum": double_pendulum(0.2),
    "square": billiard(0.5),
    "round": (pc.Scene(pc.Particles([[0.3, 0.1]], [[0.7, 0.41]]), pc.Sphere((0.0, 0.0), 1.0, inside=True)), 60.0),
    "linear well": well(1.0),
    "cubic well": well(3.0),
    "cloth": cloth(2.0, 0.02),
    "damped cloth": cloth(4.0, 0.1),
    "throw": thrown(),
    "throw in air": thrown(pc.Drag(linear=0.1, quadratic=0.05)),
    "bounce": thrown(pc.Floor(0.0)),
}
CHAOTIC: dict[str, Case] = {
    **{f"double pendulum {angle}": double_pendulum(angle) for angle in (1.6, 2.0, 2.4, 2.8, 3.0)},
    **{f"gas {seed}": gas(seed) for seed in range(4)},
    "dense gas": gas(5, 1.12, 1.5),
    **{f"grains {seed}": grains(seed, 5, 2) for seed in range(3)},
    "grains in space": grains(1, 3, 3),
    **{f"billiard {angle}": billiard(angle, SCATTERER) for angle in (1.0, 2.0, 4.0)},
    "rope": rope(8, 10.0),
    "long rope": rope(20, 6.0),
    "three masses": (
        pc.Scene(
            pc.SpringNetwork([[0, 0], [1, 0], [2, 0], [3, 0]], [[0, 1], [1, 2], [2, 3]], 500.0, fixed=[0]),
            pc.Gravity((0.0, -9.81)),
        ),
        40.0,
    ),
}


def twins(case: Case) -> Chaos:
    """What `tradeoff` does to tell chaos."""
    experiment = Experiment(*case, threads=1)
    best = methods.methods(experiment)[0]
    steps = experiment.steps_of(reference.START * best.accurate)
    return twin(experiment, Choice(best.integrator, "f64", steps), seed=0)


def test_there_are_twenty_scenes_of_either_kind():
    assert len(REGULAR) == len(CHAOTIC) == 20


@pytest.mark.parametrize("case", REGULAR.values(), ids=REGULAR)
def test_regular_motion_is_told_from_chaos(case):
    chaos = twins(case)
    assert not chaos.chaotic
    assert math.isinf(chaos.horizon)


@pytest.mark.parametrize("case", CHAOTIC.values(), ids=CHAOTIC)
def test_chaos_is_told_from_regular_motion(case):
    """Doubling times of the twin vary along a path, but e-foldings until it is lost do not: ln 1e5 = 11.5 of them."""
    chaos = twins(case)
    assert chaos.chaotic
    assert 0.0 < chaos.horizon < case[1]
    assert chaos.exponent * chaos.horizon == pytest.approx(math.log(1e5), rel=0.8)


SLOPES = [
    (label, case, integrator)
    for label, case in (("pendulum", pendulum(0.0)), ("orbit", orbit(0.3)))
    for integrator in ALL[1:]
    # Its term of fourth order is so small there that the one of sixth order rules as far as rounding.
    if (label, name(integrator)) != ("orbit", "BlanesMoan4")
]
"""Explicit Euler spirals: it is asymptotic only after more steps than this test has time for."""


@pytest.mark.parametrize(
    ("label", "case", "integrator"), SLOPES, ids=lambda value: value if isinstance(value, str) else name(value)
)
def test_measured_slopes_are_the_orders(label, case, integrator):
    """Over the four finest steps that the reference resolves and rounding does not reach, from dt to dt/8.

    The next term of the error is dt/dt₀ of the first for methods that are not symmetric: at a hundredth of the motion
    the slope is off by 0.1 at most. Rounding walks √n ε L in n steps, below 1e-13.
    """
    steps = [0.2 / 2.0**power for power in range(9)]
    trade = pc.tradeoff(*case, integrators=[integrator], precisions=["f64"], dts=steps, budget=10.0)
    rows = [row for row in trade.rows if row.status == "ok" and row.certain and 1e-12 < row.error < 1e-2]
    rows = sorted(rows, key=lambda row: row.dt)[:4]
    assert len(rows) >= 3, trade
    slope = np.polyfit(np.log([row.dt for row in rows]), np.log([row.error for row in rows]), 1)[0]
    assert slope == pytest.approx(integrator.order, abs=0.1)


def test_the_reference_of_an_orbit_is_keplers():
    """After whole revolutions the planet is where it began, and it is uncertain by what it says."""
    case = orbit(0.6)
    experiment = Experiment(*case, threads=1)
    found = reference.find(experiment, methods.methods(experiment), Budget(2.0))
    assert found.agrees
    assert found.uncertainty < 1e-10
    off = np.linalg.norm(found.samples[-1] - found.samples[0])
    assert off < max(10.0 * found.uncertainty, 1e-11)


def test_a_bad_reference_is_found_out(monkeypatch):
    """A method that loses order where nobody expects it disagrees with one of another family."""
    experiment = Experiment(*pendulum(0.0), threads=1)
    honest = Experiment.observe

    def crooked(self: Experiment, simulation: pc.Simulation) -> np.ndarray:
        shift = 1e-5 if simulation.integrator.symplectic else 0.0
        return honest(self, simulation) + shift * simulation.time

    monkeypatch.setattr(Experiment, "observe", crooked)
    found = reference.find(experiment, methods.methods(experiment), Budget(1.0))
    assert not found.agrees
    # Both coordinates are off by 1e-5 of ten seconds.
    assert found.uncertainty == pytest.approx(math.sqrt(2.0) * 1e-4, rel=1e-3)


def test_single_precision_far_from_the_origin_is_measured_or_refused():
    """Two planets 2²² m apart: whatever the origin, one of them is where numbers have a spacing of 1/8 m."""
    planet = orbit(0.0)[0].bodies[0]
    suns = [(2.0**21, 0.0), (-(2.0**21), 0.0)]
    planets = [pc.Particles(planet.positions + sun, planet.velocities) for sun in suns]
    pulls = [pc.CentralForce(sun, 1.0, exponent=-2.0, on=body) for sun, body in zip(suns, planets, strict=True)]
    trade = pc.tradeoff(pc.Scene(*planets, *pulls), 2.0, integrators=[pc.VelocityVerlet()], budget=1.0)
    best = {kind: min(row.error for row in trade.rows if row.precision == kind) for kind in ("f64", "f32")}
    assert best["f32"] > 1.0 / 16.0
    assert best["f64"] < 1e-3
    assert trade.best(error=1e-3).precision == "f64"


def test_steps_past_the_limit_are_rows_that_diverged():
    scene, duration = string(8, 0.1, 60.0)
    limit = pc.stability_limit(scene, pc.VelocityVerlet())
    trade = pc.tradeoff(
        scene,
        duration,
        integrators=[pc.VelocityVerlet()],
        dts=[2.5 * limit, 0.5 * limit],
        precisions=["f64"],
        budget=1.0,
    )
    blown, held = trade.rows
    assert (blown.status, held.status) == ("diverged", "ok")
    assert math.isinf(blown.error)
    assert blown not in trade.front
    assert trade.best(error=math.ldexp(1.0, 9)) is held
    assert "Blew up: VelocityVerlet" in trade.explain()


def test_no_trajectory_error_is_given_for_chaos():
    """Over a window of a Lyapunov time Verlet keeps its order; over the whole run errors would be those of chance."""
    scene, duration = gas(0)
    steps = [2.0**-power for power in (6, 7, 8, 9)]
    trade = pc.tradeoff(scene, duration, integrators=[pc.VelocityVerlet()], precisions=["f64"], dts=steps, budget=8.0)
    assert trade.measure == "restart"
    assert "chaotic" in trade.explain()
    good = [row for row in trade.rows if row.status == "ok" and row.certain]
    assert len(good) >= 3
    slope = np.polyfit(np.log([row.dt for row in good]), np.log([row.error for row in good]), 1)[0]
    assert slope == pytest.approx(2.0, abs=0.3)


def test_a_biased_method_is_found_out_in_chaos():
    """Explicit Euler heats a gas of grains, whatever its trajectories do; semi-implicit Euler does not."""
    scene, duration = grains(1, 5, 2)
    step = 0.25 * pc.stability_limit(scene, pc.VelocityVerlet())
    euler = [pc.ExplicitEuler(), pc.SemiImplicitEuler()]
    trade = pc.tradeoff(scene, duration, integrators=euler, dts=[step], precisions=["f64"], budget=1.0)
    statuses = {name(row.integrator): row.status for row in trade.rows}
    assert statuses["ExplicitEuler"] in ("biased", "diverged")
    assert statuses["SemiImplicitEuler"] == "ok"
    assert isinstance(trade.best(error=1.0).integrator, pc.SemiImplicitEuler)


SURE = np.zeros(3)
"""No doubts about the reference's averages."""


def test_equal_ensembles_are_not_called_biased_and_shifted_ones_are():
    """One comparison in a thousand may be wrong by construction: of 300 more than two with a chance of 0.4 %."""
    generator = np.random.default_rng(2)
    pairs = [generator.normal(1.0, 0.05, (2, 8, 3)) for _ in range(300)]
    assert sum(bias(one, other, SURE).found for one, other in pairs) <= 2
    shifted = generator.normal([1.0, 1.3, 1.0], 0.05, (8, 3))
    verdict = bias(shifted, generator.normal(1.0, 0.05, (8, 3)), SURE)
    assert verdict.found
    assert verdict.quantity == "potential energy"
    assert verdict.relative == pytest.approx(0.3, abs=4.7 * 0.05 / 2.0)


def test_resolution_and_time_step_are_told_apart():
    """A vibrating string of n springs differs from a continuous one by O(1/n²), whatever the time step.

    Its middle moves as cos ωt with ω = 2n sin(π/2n) √(k/m) in units of the length; the chain has k = n, m = 1/n and a
    tension of one half, so that ω → π √½.
    """

    def scene(count: float) -> pc.Scene:
        n = int(count)
        index = np.arange(n + 1)
        places = np.stack([index / n, 1e-3 * np.sin(np.pi * index / n)], axis=1)
        pairs = np.stack([index[:-1], index[1:]], axis=1)
        return pc.Scene(pc.SpringNetwork(places, pairs, float(n), rest_length=0.5 / n, mass=1.0 / n, fixed=[0, n]))

    def middle(simulation: pc.Simulation) -> np.ndarray:
        return simulation.positions[len(simulation.positions) // 2]

    trade = pc.tradeoff(
        scene,
        2.0,
        integrators=[pc.VelocityVerlet()],
        precisions=["f64"],
        resolutions=[8, 16, 32],
        observe=middle,
        budget=3.0,
    )
    errors = {row.resolution: row.discretization_error for row in trade.rows}
    assert errors[8] / errors[16] == pytest.approx(4.0, rel=0.1)
    frequency = 2.0 * 32 * math.sin(math.pi / 64) * math.sqrt(0.5)
    off = 1e-3 * abs(math.cos(2.0 * frequency) - math.cos(2.0 * math.pi * math.sqrt(0.5)))
    assert errors[32] >= off
    assert trade.best(error=1.1 * errors[16]).resolution in (16, 32)
    assert trade.best(error=0.5 * errors[16]).resolution == 32


@pytest.mark.parametrize("seed", range(30 if LONG else 4))
def test_a_choice_keeps_its_word(seed, record_property):
    """A run of another method at a hundredth of its limit finds no more than twice the error that was asked for."""
    generator = np.random.default_rng(seed)
    net = network(seed, dimension=2, count=int(generator.integers(2, 12)), damping=float(generator.choice([0.0, 0.3])))
    scene, duration = net.scene(), float(generator.uniform(1.0, 6.0))
    trade = pc.tradeoff(scene, duration, budget=2.0)
    reached = [row.error for row in trade.rows if row.status == "ok" and row.certain]
    wish = float(np.exp(generator.uniform(*np.log([max(min(reached), 1e-9), 1e-2]))))
    chosen = trade.best(error=wish)
    run = pc.Simulation(scene, **chosen.numerics)
    run.run(duration)
    assert run.time == pytest.approx(duration, rel=1e-12)
    least = pc.stability_limit(scene, pc.RungeKutta4())
    truth = pc.Simulation(scene, pc.RungeKutta4(), duration / math.ceil(duration / (0.01 * least)), "f64")
    truth.run(duration)
    ratio = float(np.linalg.norm(run.positions - truth.positions, axis=1).max()) / wish
    record_property("error over what was asked for", ratio)
    assert ratio <= 2.0


@pytest.mark.parametrize("integrator", ALL[1:], ids=name)
def test_errors_fall_on_the_line_that_held_out_rows_were_predicted_from(integrator):
    """Between two rows whose slope is the order, errors lie on a power of dt up to the next term: within a fifth."""
    trade = pc.tradeoff(*pendulum(0.0), integrators=[integrator], precisions=["f64"], budget=1.0)
    assert trade.held_out
    plain = [row for row in trade.rows if row.prediction is None]
    for row in trade.held_out:
        coarse = min((other for other in plain if other.dt > row.dt), key=lambda other: other.dt)
        fine = max((other for other in plain if other.dt < row.dt), key=lambda other: other.dt)
        slope = math.log(coarse.error / fine.error) / math.log(coarse.dt / fine.dt)
        if abs(slope - integrator.order) < 0.1 and fine.certain:
            assert row.error == pytest.approx(row.prediction.error, rel=0.2)


def test_symmetric_errors_do_not_depend_on_where_and_how_large_a_scene_is():
    """Rescaling by a power of two changes no bit of the search but the scale."""
    scene, duration = string(4, 0.1, 10.0)
    (body,) = scene.bodies
    assert isinstance(body, pc.SpringNetwork)
    large = pc.SpringNetwork(
        2.0 * body.positions, body.pairs, body.stiffness, rest_length=2.0 * body.rest_length, fixed=body.fixed
    )
    options = {"integrators": [pc.VelocityVerlet()], "precisions": ["f64"], "dts": [0.1, 0.05], "budget": 1.0}
    plain = pc.tradeoff(scene, duration, **options)
    scaled = pc.tradeoff(pc.Scene(large), duration, **options)
    for one, other in zip(plain.rows, scaled.rows, strict=True):
        assert other.error == pytest.approx(2.0 * one.error, rel=1e-6)  # the references may have come to other steps
