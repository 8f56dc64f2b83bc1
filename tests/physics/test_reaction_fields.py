"""Kinetics whose parameters are fields: the same equations, cell by cell, and what is refused."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import physcore as pc
from physcore.errors import SceneError

CELLS = (24, 18)
KINETICS = [
    (pc.GrayScott, {"feed": 0.035, "kill": 0.0625}),
    (pc.FitzHughNagumo, {"epsilon": 0.08, "beta": 0.7, "gamma": 0.8, "current": 0.2}),
    (pc.Brusselator, {"a": 1.0, "b": 2.5}),
    (pc.Schnakenberg, {"a": 0.1, "b": 0.9}),
]
METHODS = [pc.ExplicitEuler(), pc.RungeKutta4(), pc.RungeKuttaChebyshev()]


def noisy(kinetics, edges="free", cells=CELLS):
    """Species at random values."""
    rng = np.random.default_rng(7)
    start = {name: rng.uniform(0.2, 1.0, cells) for name in kinetics.names}
    return pc.ReactionDiffusion(pc.Grid(cells, 0.5), kinetics, dict.fromkeys(kinetics.names, 0.05), start, edges)


def values(run):
    """All fields and budgets of a simulation of one dish."""
    (dish,) = run.scene.systems
    budgets = [vars(run.budgets()[name]) for name in dish.reaction.names]
    return [run[dish][name] for name in dish.reaction.names], budgets


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("integrator", METHODS, ids=lambda integrator: type(integrator).__name__)
@pytest.mark.parametrize(("kind", "parameters"), KINETICS)
def test_a_field_of_equal_values_is_the_number_bit_for_bit(kind, parameters, integrator, precision):
    dishes = [
        noisy(kind(**parameters), {"x-": "fixed"}),
        noisy(kind(**{name: np.full(CELLS, value) for name, value in parameters.items()}), {"x-": "fixed"}),
    ]
    runs = [pc.Simulation(pc.Scene(dish), integrator=integrator, precision=precision, dt=0.1) for dish in dishes]
    assert runs[0].plan.dt_limit == runs[1].plan.dt_limit
    for run in runs:
        run.step(50)
    (plain, budgets), (varied, others) = map(values, runs)
    assert all(np.array_equal(one, other) for one, other in zip(plain, varied, strict=True))
    assert budgets == others
    assert "parameters of each cell" in str(runs[1].plan)


def test_patches_of_a_map_are_runs_of_their_own():
    """In n steps of Euler's method, what happens at an interface reaches n cells: all others have the same bits."""
    feeds, kills, steps = (0.03, 0.05), (0.055, 0.065), 5
    grid = pc.Grid(CELLS, 0.5)
    middle = [0.5 * length for length in grid.upper]
    kinetics = pc.GrayScott(
        feed=lambda x, y: np.where(x < middle[0], *feeds), kill=lambda x, y: np.where(y < middle[1], *kills)
    )
    chart = noisy(kinetics)
    run = pc.Simulation(pc.Scene(chart), integrator=pc.ExplicitEuler(), dt=0.2)
    run.step(steps)
    half = [count // 2 for count in CELLS]
    for i, feed in enumerate(feeds):
        for j, kill in enumerate(kills):
            alone = noisy(pc.GrayScott(feed, kill))
            own = pc.Simulation(pc.Scene(alone), integrator=pc.ExplicitEuler(), dt=0.2)
            own.step(steps)
            corner = tuple(
                slice(None, count - steps) if place == 0 else slice(count + steps, None)
                for place, count in zip((i, j), half, strict=True)
            )
            for name in ("u", "v"):
                assert np.array_equal(run[chart][name][corner], own[alone][name][corner])
                assert not np.array_equal(run[chart][name], own[alone][name])


def test_smooth_parameters_keep_order_two_in_space():
    """Each halving of the spacing divides the difference to the next finer grid by four."""

    def end(cells):
        grid = pc.Grid(cells, 1.0 / cells, periodic=True)
        wave = 2.0 * np.pi * grid.coordinates[0]
        kinetics = pc.GrayScott(0.04 + 0.02 * np.sin(wave), 0.06 + 0.01 * np.cos(wave))
        start = {"u": 1.0 - 0.3 * np.cos(wave), "v": 0.3 + 0.2 * np.cos(wave)}
        tube = pc.ReactionDiffusion(grid, kinetics, {"u": 2e-3, "v": 1e-3}, start)
        run = pc.Simulation(pc.Scene(tube), dt=0.05)
        run.run(10.0)
        return run[tube]["v"].reshape(16, -1).mean(axis=1)

    coarse, middle, fine = (end(cells) for cells in (16, 32, 64))
    order = np.log2(np.abs(coarse - middle).max() / np.abs(middle - fine).max())
    assert order == pytest.approx(2.0, abs=0.2)


def test_functions_become_arrays_of_the_grid_and_compare_by_value():
    grid = pc.Grid(CELLS, 0.5)
    x, _ = grid.coordinates
    kinetics = pc.GrayScott(lambda x, y: 0.03 + 0.001 * x, 0.06)
    dish = noisy(kinetics)
    assert dish.reaction == pc.GrayScott(0.03 + 0.001 * x, 0.06)
    assert dish.reaction != pc.GrayScott(0.03 + 0.002 * x, 0.06)
    assert dish.reaction != kinetics
    for again in (copy.deepcopy(dish.reaction), pickle.loads(pickle.dumps(dish.reaction))):
        assert again == dish.reaction
        assert hash(again) == hash(dish.reaction)
        with pytest.raises(ValueError, match="read-only"):
            again.feed[0, 0] = 1.0
    assert pc.GrayScott(0.03, 0.06) == pc.GrayScott(0.03, 0.06)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: pc.GrayScott(np.full(CELLS, -1.0), 0.06), r"GrayScott.feed\[0, 0\]: must be ≥ 0, got -1"),
        (lambda: pc.GrayScott(0.03, [0.06, np.nan]), r"GrayScott.kill\[1\]: must be finite, got nan"),
        (
            lambda: noisy(pc.GrayScott(0.03, np.zeros((3, 4)))),
            r"ReactionDiffusion.reaction.kill: .*\(24, 18\).*\(3, 4\)",
        ),
        (
            lambda: noisy(pc.GrayScott(lambda x, y: x - 1.0, 0.06)),
            r"ReactionDiffusion.reaction.feed\[0, 0\]: must be ≥ 0, got -0.75",
        ),
        (
            lambda: noisy(pc.Brusselator(lambda x: x, 2.0)),
            "ReactionDiffusion.reaction.a: the function raised TypeError",
        ),
        (lambda: pc.Schnakenberg("a", 0.9), "Schnakenberg.a: must be a number, got 'a'"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_path(make, message):
    with pytest.raises(SceneError, match=message):
        make()
