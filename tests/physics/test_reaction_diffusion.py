"""Reactions and diffusion: kinetics as they are written, budgets, spreading, fronts, patterns, and what is refused."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

import physcore as pc
from contracts.scenes import IN_PYTHON
from physcore.errors import SceneError
from physcore.integrators import INTEGRATORS
from physcore.systems.kinetics import KINETICS, PEARSON, Pearson

BUILT_IN = [
    pc.GrayScott(0.035, 0.0625),
    pc.FitzHughNagumo(current=0.2),
    pc.Brusselator(1.0, 2.5),
    pc.Schnakenberg(0.1, 0.9),
]
VARYING = [
    pc.GrayScott(np.linspace(0.02, 0.06, 120).reshape(12, 10), 0.0625),
    pc.FitzHughNagumo(
        current=np.linspace(0.0, 0.5, 120).reshape(12, 10), gamma=np.linspace(0.6, 0.9, 120).reshape(12, 10)
    ),
    pc.Brusselator(1.0, np.linspace(2.0, 3.0, 120).reshape(12, 10)),
    pc.Schnakenberg(np.linspace(0.05, 0.2, 120).reshape(12, 10), 0.9),
]
FIRST_ORDER = [kind() for kind in INTEGRATORS if kind.advances("Tracers")]


def patch(kinetics, cells=(12, 10), edges="free", spacing=0.5):
    """Species at random values on a small grid."""
    rng = np.random.default_rng(4)
    grid = pc.Grid(cells, spacing)
    start = {name: rng.uniform(0.2, 1.0, cells) for name in kinetics.names}
    return pc.ReactionDiffusion(grid, kinetics, dict.fromkeys(kinetics.names, 0.05), start, edges)


def test_all_kinetics_are_tested():
    assert {type(kinetics) for kinetics in BUILT_IN} | {pc.Reaction} == set(KINETICS)


@pytest.mark.parametrize("kinetics", BUILT_IN + VARYING, ids=lambda kinetics: type(kinetics).__name__)
def test_a_cell_by_itself_follows_its_equations(kinetics):
    """Without diffusion each cell is an ordinary equation, here by the classical Runge–Kutta method in NumPy.

    Both take the same steps, so that roundings alone are between them, 400 of them of numbers up to 5.
    """
    dish = patch(kinetics)
    still = pc.ReactionDiffusion(dish.grid, kinetics, {"u": 0.0, "v": 0.0}, dish.initial)
    run = pc.Simulation(pc.Scene(still), integrator=pc.RungeKutta4(), dt=0.02)
    run.step(100)
    function = IN_PYTHON[type(kinetics)](kinetics)
    y, h = np.stack([np.asarray(dish.initial[name]) for name in ("u", "v")]), 0.02
    for _ in range(100):
        k1 = np.stack(function(*y))
        k2 = np.stack(function(*(y + h / 2 * k1)))
        k3 = np.stack(function(*(y + h / 2 * k2)))
        k4 = np.stack(function(*(y + h * k3)))
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    assert max(np.abs(run[still][name] - y[index]).max() for index, name in enumerate(("u", "v"))) < 1e-13


@pytest.mark.parametrize("integrator", FIRST_ORDER, ids=lambda integrator: type(integrator).__name__)
@pytest.mark.parametrize("kinetics", BUILT_IN + VARYING, ids=lambda kinetics: type(kinetics).__name__)
def test_amounts_are_what_was_supplied_less_what_was_removed(kinetics, integrator):
    """Edges that hold zero take some; 60 steps add roundings of sums of 120 numbers."""
    recording = pc.simulate(pc.Scene(patch(kinetics, edges={"x": "fixed"})), 1.2, 10.0, integrator=integrator, dt=0.02)
    (dish,) = recording.scene.systems
    for name in kinetics.names:
        budget = recording.budgets[name]
        assert budget.unit == "m²"
        np.testing.assert_allclose(budget.total, recording[dish][name].sum(axis=(1, 2)) * 0.25, rtol=1e-13)
        assert np.abs(budget.drift).max() < 1e-13
        assert (np.diff(budget.removed_by["edges"]) != 0.0).all()
    assert not recording.energy.total.any()


def test_diffusion_alone_keeps_the_amount_between_free_edges():
    nothing = pc.Reaction(("n",), lambda n: (0.0 * n,))
    grid = pc.Grid((20, 30), 0.1)
    drop = grid.field(lambda x, y: np.exp(-((x - 1.0) ** 2 + (y - 1.5) ** 2) / 0.02), "drop")
    recording = pc.simulate(pc.Scene(pc.ReactionDiffusion(grid, nothing, {"n": 0.1}, {"n": drop})), 2.0)
    budget = recording.budgets["n"]
    assert not budget.supplied.any()
    assert not budget.removed.any()
    assert np.abs(budget.drift).max() < 1e-13
    values = recording[recording.scene.systems[0]]["n"]
    assert (np.diff(values.max(axis=(1, 2))) <= 0.0).all()  # the maximum principle
    assert values.min() >= 0.0


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_a_drop_spreads_as_a_gaussian(dimension):
    """On an infinite plane σ² grows by 2 D t, on the grid too: Σ i² of a step of diffusion is exact.

    What is beyond the edges, at 6 σ, is 1e-8 of all.
    """
    cells = (33,) * dimension
    grid = pc.Grid(cells, 0.1, origin=-1.65)
    start = grid.field(lambda *x: np.exp(-sum(each**2 for each in x) / (2.0 * 0.2**2)), "start")
    nothing = pc.Reaction(("n",), lambda n: (0.0 * n,))
    drop = pc.ReactionDiffusion(grid, nothing, {"n": 0.02}, {"n": start})
    run = pc.Simulation(pc.Scene(drop), dt=0.05)
    run.run(0.8)

    def variance(values):
        return float((values * grid.coordinates[0] ** 2).sum() / values.sum())

    assert variance(run[drop]["n"]) - variance(start) == pytest.approx(2.0 * 0.02 * 0.8, rel=1e-4)


def test_a_front_of_fishers_equation_travels_at_its_speed():
    """u_t = D u_xx + u (1 − u): a front as exp(−x/2) ahead has the speed 5/2 √D. The grid adds 1/12 (h/2)² of it."""
    grid = pc.Grid(600, 0.25)
    start = grid.field(lambda x: 1.0 / (1.0 + np.exp((x - 30.0) / 2.0)), "start")
    fisher = pc.Reaction(("n",), lambda n: (n * (1.0 - n),))
    front = pc.ReactionDiffusion(grid, fisher, {"n": 1.0}, {"n": start})
    recording = pc.simulate(pc.Scene(front), 24.0, 1.0)
    place = grid.spacing * recording[front]["n"].sum(axis=1)
    speed = (place[-1] - place[-7]) / 6.0
    assert speed == pytest.approx(2.5, rel=0.01)


def test_an_embedded_estimate_keeps_the_error_of_a_step_to_its_tolerance():
    dish = patch(pc.Brusselator(1.0, 2.5))
    fine = pc.Simulation(pc.Scene(dish), dt=0.001)
    fine.run(4.0)
    for integrator in FIRST_ORDER:
        if not integrator.embedded:
            continue
        run = pc.Simulation(pc.Scene(dish), integrator=integrator, dt=pc.AdaptiveStep(tolerance=1e-6))
        run.run(4.0)
        error = np.abs(run[dish]["u"] - fine[dish]["u"]).max()
        assert 1e-9 < error < 1e-6 * run.steps, integrator


def test_a_stabilized_method_takes_long_steps():
    """Its plan says how many stages a step takes; at 25 times the limit of the classical method it is off by 1e-3."""
    grid = pc.Grid(200, 0.01, periodic=True)
    kinetics = pc.GrayScott(0.035, 0.0625)
    wave = grid.field(lambda x: 0.5 + 0.2 * np.cos(2.0 * np.pi * x / 2.0), "wave")
    tube = pc.ReactionDiffusion(grid, kinetics, {"u": 2e-3, "v": 1e-3}, {"u": wave, "v": 0.3})
    scene = pc.Scene(tube)
    limit = pc.stability_limit(scene, pc.RungeKutta4())
    dt = 25.0 * limit
    steps = round(20.0 / dt)
    run = pc.Simulation(scene, integrator=pc.RungeKuttaChebyshev(), dt=20.0 / steps)
    assert any("stages" in note for note in run.plan.notes)
    run.step(steps)
    assert run.plan.evaluations > 5
    exact = pc.Simulation(scene, integrator=pc.RungeKutta4(), dt=0.5 * limit)
    exact.run(20.0)
    assert np.abs(run[tube]["u"] - exact[tube]["u"]).max() < 1e-3


def test_spots_of_the_class_lambda_divide():
    """One drop becomes many spots: maxima of v in their neighborhoods."""
    assert set(PEARSON) == set(get_args(Pearson))
    grid = pc.Grid((80, 80), 0.0125, periodic=True)
    drop = grid.field(lambda x, y: np.exp(-((x - 0.503) ** 2 + (y - 0.461) ** 2) / 0.04**2), "drop")
    start = {"u": 1.0 - 0.5 * drop, "v": 0.3 * drop}
    dish = pc.ReactionDiffusion(grid, pc.GrayScott.pearson("lambda"), {"u": 2e-5, "v": 1e-5}, start)
    run = pc.Simulation(pc.Scene(dish), integrator=pc.ExplicitEuler(), dt=1.0)

    def spots():
        v = run[dish]["v"]
        around = [np.roll(v, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]
        return np.count_nonzero((v > 0.2) & (v > np.max(around, axis=0)))

    assert spots() == 1
    run.step(4000)
    assert spots() >= 8


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"grid": 3}, "ReactionDiffusion.grid: must be a Grid"),
        ({"reaction": "Gray"}, "ReactionDiffusion.reaction: must be one of GrayScott"),
        ({"diffusion": 1.0}, "ReactionDiffusion.diffusion: must be a mapping of the species 'u', 'v'"),
        ({"diffusion": {"u": 1.0}}, "ReactionDiffusion.diffusion: must have a value for each species, 'v' has none"),
        ({"diffusion": {"u": 1.0, "v": -1.0}}, "ReactionDiffusion.diffusion['v']: must be ≥ 0"),
        ({"diffusion": {"u": 1.0, "v": 1.0, "w": 1.0}}, "ReactionDiffusion.diffusion['w']: is none of the species"),
        ({"initial": {"u": 1.0, "v": np.zeros(3)}}, "ReactionDiffusion.initial['v']: must be a number, a function"),
        ({"initial": {"u": 1.0, "v": np.nan}}, "ReactionDiffusion.initial['v']"),
        ({"edges": "absorbing"}, "ReactionDiffusion.edges['x-']: must be 'free', 'fixed', Dirichlet(…)"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_path(change, message):
    arguments = {
        "grid": pc.Grid((4, 3), 0.5),
        "reaction": pc.GrayScott(0.03, 0.06),
        "diffusion": {"u": 1.0, "v": 1.0},
        "initial": {"u": 1.0, "v": 0.0},
    }
    with pytest.raises(SceneError) as caught:
        pc.ReactionDiffusion(**{**arguments, **change})
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda n: n, "of shape (1, 4)"),
        (lambda n: (n[:2],), "of shape (1, 4)"),
        (lambda n: (n / 0.0,), "finite"),
        (lambda n: ("x",), "real numbers"),
        (lambda n: None, "None"),
    ],
)
@pytest.mark.filterwarnings("ignore:divide by zero")
def test_a_function_that_gives_no_rates_is_refused(function, message):
    kinetics = pc.Reaction(("n",), function)
    tank = pc.ReactionDiffusion(pc.Grid(4, 1.0), kinetics, {"n": 1.0}, {"n": 1.0})
    with pytest.raises(SceneError) as caught:
        pc.Simulation(pc.Scene(tank))
    assert "reaction.function" in str(caught.value)
    assert message in str(caught.value)


def test_a_name_that_is_none_is_refused():
    for species in ((), ("u", "u"), ("a b",), "u v"):
        with pytest.raises(SceneError, match=r"Reaction\.species"):
            pc.Reaction(species, lambda *values: values)
