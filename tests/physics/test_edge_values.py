"""Edges with values: heat between temperatures, given fluxes, driven strings, budgets, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physcore.errors import FileError, SceneError
from physcore.integrators import INTEGRATORS

NOTHING = pc.Reaction(("T",), lambda heat: (0.0 * heat,))
FIRST_ORDER = [kind() for kind in INTEGRATORS if kind.advances("Tracers")]
D = 0.1


def rod(cells, edges, start=0.0, length=1.0):
    """Heat in a rod, or in a plate."""
    grid = pc.Grid(cells, length / np.ravel(cells)[0])
    return pc.ReactionDiffusion(grid, NOTHING, {"T": D}, {"T": start}, edges)


def test_heat_between_two_temperatures_becomes_linear_and_flows_through():
    """Ghosts 2g − u are on the line too. After 40 decay times e^−40 = 4e-18 of the slowest mode is left."""
    item = rod(20, {"x-": pc.Dirichlet(3.0), "x+": pc.Dirichlet(1.0)})
    run = pc.Simulation(pc.Scene(item), integrator=pc.RungeKuttaChebyshev(), dt=0.05)
    decay = np.pi**2 * D
    run.run(40.0 / decay)
    assert np.abs(run[item]["T"] - (3.0 - 2.0 * item.grid.coordinates[0])).max() < 1e-12
    before, start = run.budgets()["T"], run.time
    run.run(10.0)
    after = run.budgets()["T"]
    flux = D * 2.0 * (run.time - start)
    assert after.supplied_by["edges"] - before.supplied_by["edges"] == pytest.approx(flux, rel=1e-11)
    assert after.removed_by["edges"] - before.removed_by["edges"] == pytest.approx(flux, rel=1e-11)


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_a_linear_profile_stays_but_for_rounding(precision):
    item = rod(20, {"x-": pc.Dirichlet(3.0), "x+": pc.Neumann(-2.0)}, lambda x: 3.0 - 2.0 * x)
    run = pc.Simulation(pc.Scene(item), precision=precision, dt=0.005)
    run.step(1000)
    # Rounding of a rate, 4 w u ε with w = D/h² = 40/s, over the decay time 1/(D π²/4) = 4 s of the slowest mode.
    epsilon = np.finfo(precision.replace("f", "float")).eps
    assert np.abs(run[item]["T"] - (3.0 - 2.0 * item.grid.coordinates[0])).max() < 4 * 40 * 3.0 * epsilon * 4.0


@pytest.mark.parametrize("integrator", FIRST_ORDER, ids=lambda integrator: type(integrator).__name__)
def test_a_flux_through_the_edges_adds_what_it_carries(integrator):
    """D q per area and time; an inflow of 1 + t is integrated exactly by methods of order 2."""
    side = np.linspace(0.0, 1.0, 12)
    edges = {"x-": pc.Neumann(2.0), "x+": pc.Neumann(-side), "y+": pc.Neumann(lambda t: 1.0 + t)}
    item = rod((10, 12), edges, 5.0)
    run = pc.Simulation(pc.Scene(item), integrator=integrator, dt=0.01)
    start = run.budgets()["T"].total
    run.step(100)
    budget = run.budgets()["T"]
    lengths, t = (1.2, 1.0), 1.0
    driven = t + 0.5 * t * t - (0.0 if integrator.order > 1 else 0.5 * t * 0.01)
    supplied, removed = D * (2.0 * lengths[0] * t + lengths[1] * driven), D * side.sum() * 0.1 * t
    assert budget.total - start == pytest.approx(supplied - removed, rel=1e-12)
    assert budget.supplied_by["edges"] == pytest.approx(supplied, rel=1e-12)
    assert budget.removed_by["edges"] == pytest.approx(removed, rel=1e-12)


def test_edges_that_follow_a_solution_in_time_keep_order_two_in_space():
    """u = e^(−D k² t) sin(k x + 1), with its value at one end and its derivative at the other."""
    k = 4.0

    def error(cells):
        fade = lambda t: np.exp(-D * k * k * t)  # noqa: E731
        edges = {
            "x-": pc.Dirichlet(lambda t: fade(t) * np.sin(1.0)),
            "x+": pc.Neumann(lambda t: fade(t) * k * np.cos(k + 1.0)),
        }
        item = rod(cells, edges, lambda x: np.sin(k * x + 1.0))
        run = pc.Simulation(pc.Scene(item), dt=0.001)
        run.run(0.5)
        return np.abs(run[item]["T"] - fade(0.5) * np.sin(k * item.grid.coordinates[0] + 1.0)).max()

    errors = [error(cells) for cells in (10, 20, 40)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize("integrator", FIRST_ORDER, ids=lambda integrator: type(integrator).__name__)
def test_methods_keep_their_order_beside_edges_that_vary(integrator):
    """Values are those at the time of each stage. The grid is coarse, so that steps can be long."""
    edges = {"x-": pc.Dirichlet(lambda t: np.sin(3.0 * t)), "x+": pc.Neumann(lambda t: np.cos(2.0 * t))}
    item = rod(4, edges)

    def end(dt, method):
        run = pc.Simulation(pc.Scene(item), integrator=method, dt=dt)
        run.run(1.6)
        return run[item]["T"]

    exact = end(0.001, pc.DormandPrince5())
    long = 0.1 if integrator.order > 1 else 0.02
    errors = [np.abs(end(dt, integrator) - exact).max() for dt in (long, 0.5 * long)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(integrator.order, abs=0.35)


def test_an_error_estimate_knows_the_values_at_the_end_of_a_step():
    edges = {"x-": pc.Dirichlet(lambda t: np.sin(3.0 * t))}
    item = rod(4, edges)
    fine = pc.Simulation(pc.Scene(item), dt=0.001)
    fine.run(2.0)
    for integrator in FIRST_ORDER:
        if integrator.embedded:
            run = pc.Simulation(pc.Scene(item), integrator=integrator, dt=pc.AdaptiveStep(tolerance=1e-6))
            run.run(2.0)
            error = np.abs(run[item]["T"] - fine[item]["T"]).max()
            assert 1e-9 < error < 1e-6 * run.steps, integrator
            assert run.steps < 400, integrator


@pytest.mark.parametrize("integrator", FIRST_ORDER, ids=lambda integrator: type(integrator).__name__)
def test_amounts_of_species_at_edges_of_their_own_are_accounted_for(integrator):
    """Sums of 99 numbers in 200 steps, each rounded."""
    grid = pc.Grid((11, 9), 0.5)
    y = grid.coordinates[1][0]
    edges = {
        "u": {"x-": pc.Dirichlet(1.0 + 0.5 * np.sin(y)), "x+": "fixed", "y": pc.Neumann(lambda t: 0.1 * np.cos(t))},
        "v": pc.Dirichlet(lambda t: 2.0 + np.sin(t)),
    }
    item = pc.ReactionDiffusion(grid, pc.Brusselator(1.0, 2.5), {"u": 0.5, "v": 1.0}, {"u": 1.0, "v": 2.5}, edges)
    recording = pc.simulate(pc.Scene(item), 4.0, fps=5.0, integrator=integrator, dt=0.02)
    for name in ("u", "v"):
        assert np.abs(recording.budgets[name].drift).max() < 1e-13
        assert recording.budgets[name].supplied_by["edges"][-1] > 0.1
        assert recording.budgets[name].removed_by["edges"][-1] > 0.1


@pytest.mark.parametrize("system", ["species", "wave"])
def test_zero_is_the_word_and_forms_of_a_value_are_equal_bit_for_bit(system):
    grid = pc.Grid((7, 6), 0.1)
    hump = grid.field(lambda x, y: x * (1.0 - y), "hump")

    def end(edges):
        if system == "species":
            item = pc.ReactionDiffusion(grid, NOTHING, {"T": D}, {"T": hump}, edges)
        else:
            item = pc.Wave(grid, 1.0, hump, edges=edges)
        run = pc.Simulation(pc.Scene(item), dt=0.01)
        run.step(30)
        return next(iter(run[item].fields.values()))

    words = end({"x": "fixed", "y": "free"})
    assert np.array_equal(end({"x": pc.Dirichlet(0.0), "y": pc.Neumann(0.0)}), words)
    plain = end({"x": pc.Dirichlet(2.0), "y": pc.Neumann(-0.3)})
    assert np.abs(plain - words).max() > 0.01
    assert np.array_equal(end({"x": pc.Dirichlet(np.full(6, 2.0)), "y": pc.Neumann(np.full(7, -0.3))}), plain)
    assert np.array_equal(end({"x": pc.Dirichlet(lambda t: 2.0), "y": pc.Neumann(lambda t: -0.3)}), plain)
    assert np.array_equal(
        end({"x": pc.Dirichlet(lambda t: np.full(6, 2.0)), "y": pc.Neumann(lambda t: np.full(7, -0.3))}), plain
    )


def test_values_that_enter_a_field_of_noise_are_no_divergence():
    item = rod(20, {"x-": pc.Dirichlet(1.0)}, lambda x: 1e-9 * np.sin(40.0 * x))
    pulled = rod(20, {"x-": pc.Neumann(1.0)}, lambda x: 1e-9 * np.sin(40.0 * x))
    for each in (item, pulled):
        run = pc.Simulation(pc.Scene(each))
        run.run(5.0)
        assert run[each]["T"].max() > 0.5


def reflected(g, x, t, length=1.0):
    """A string at rest whose end at 0 follows g, and whose other end is held: all echoes, for c = 1."""
    u = np.zeros_like(x)
    for n in range(int(t / (2.0 * length)) + 2):
        for sign, way in ((1.0, 2.0 * n * length + x), (-1.0, 2.0 * (n + 1) * length - x)):
            u += sign * np.where(t > way, g(t - way), 0.0)
    return u


def test_a_string_that_is_driven_in_resonance_follows_dalembert():
    """Each way to and fro adds to the amplitude. Smooth at the start, so that errors are of order 2."""

    def g(t):
        return 0.1 * np.sin(np.pi * np.asarray(t)) ** 3

    def error(cells):
        grid = pc.Grid(cells, 1.0 / cells)
        string = pc.Wave(grid, 1.0, edges={"x-": pc.Dirichlet(g), "x+": "fixed"})
        run = pc.Simulation(pc.Scene(string), dt=0.5 / cells)
        run.run(6.0)
        expected = reflected(g, grid.coordinates[0], 6.0)
        assert np.abs(expected).max() > 0.5
        return np.abs(run[string].displacement - expected).max()

    errors = [error(cells) for cells in (40, 80, 160)]
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.3)
    assert errors[2] < 0.01


def test_a_string_that_is_pulled_at_its_end_follows_dalembert():
    """Its slope there is −q: u = c ∫ q dt up to t − x/c, until the wave comes back."""

    def error(cells):
        grid = pc.Grid(cells, 1.0 / cells)
        string = pc.Wave(grid, 2.0, edges={"x-": pc.Neumann(lambda t: np.sin(9.0 * t) ** 2), "x+": "absorbing"})
        run = pc.Simulation(pc.Scene(string), dt=0.2 / cells)
        run.run(0.8)
        late = np.maximum(0.0, 0.8 - grid.coordinates[0] / 2.0)
        expected = 2.0 * (0.5 * late - np.sin(18.0 * late) / 36.0)
        return np.abs(run[string].displacement - expected).max()

    errors = [error(cells) for cells in (40, 80, 160)]
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.3)
    assert errors[2] < 1e-3


def smooth(t):
    return 0.1 * np.sin(4.0 * t) ** 3


DRIVEN = {
    "held": ({"x-": pc.Dirichlet(smooth), "x+": "fixed"}, 0.0),
    "pulled": ({"x-": pc.Neumann(smooth), "x+": pc.Dirichlet(0.3)}, 0.3),
    "open": ({"x-": pc.Dirichlet(smooth), "x+": "absorbing"}, 0.0),
}


@pytest.mark.parametrize(
    ("integrator", "order"), [(pc.RungeKutta4(), 4), (pc.VelocityVerlet(), 2)], ids=["RungeKutta4", "VelocityVerlet"]
)
@pytest.mark.parametrize(
    ("edges", "cells"), [(name, (30,)) for name in DRIVEN] + [("held", (12, 9)), ("open", (12, 9))]
)
def test_the_energy_of_a_driven_wave_is_the_work_of_its_edges(edges, cells, integrator, order):
    """The balance closes to the order of the method, here from steps of 0.6 and 0.3 of the limit on."""
    grid = pc.Grid(cells, 1.0 / cells[0], periodic=(False, True)[: len(cells)])
    conditions, start = DRIVEN[edges]
    item = pc.Wave(grid, 1.0, start, density=3.0, damping=0.2 if edges == "held" else 0.0, edges=conditions)

    def drift(dt):
        run = pc.Simulation(pc.Scene(item), integrator=integrator, dt=dt)
        start, most = run.energy(), 0.0
        assert start.work == 0.0
        for _ in range(20):
            run.run(0.1)
            most = max(most, abs(run.energy().balance - start.balance))
        assert run.energy().work > 1e-3
        return most

    dt = 0.1 / (2 * cells[0] // 3)
    errors = [drift(dt), drift(0.5 * dt)]
    assert np.log2(errors[0] / errors[1]) > order - 0.3


def test_a_string_that_is_raised_slowly_stores_the_work():
    """½ ρ c² g²/L, of a straight string. Half a cell at each end is included, so that no error of order 1 is left."""
    item = pc.Wave(
        pc.Grid(10, 0.1),
        1.0,
        density=2.0,
        damping=5.0,
        edges={"x-": pc.Dirichlet(lambda t: 0.2 * min(t / 40.0, 1.0)), "x+": "fixed"},
    )
    run = pc.Simulation(pc.Scene(item), dt=0.02)
    run.run(60.0)
    assert run.energy().total == pytest.approx(0.5 * 2.0 * 0.2**2, rel=1e-6)
    held = pc.Wave(
        pc.Grid(10, 0.1), 1.0, lambda x: 3.0 - 2.0 * x, edges={"x-": pc.Dirichlet(3.0), "x+": pc.Neumann(-2.0)}
    )
    energy = pc.Simulation(pc.Scene(held)).energy()
    assert energy.total == pytest.approx(0.5 * 4.0, rel=1e-12)
    assert energy.work == 0.0


def test_a_field_that_is_set_beside_driven_edges_keeps_the_balance():
    item = pc.Wave(pc.Grid(30, 1.0 / 30), 1.0, edges={"x-": pc.Dirichlet(lambda t: np.sin(2.0 * t)), "x+": "free"})
    run = pc.Simulation(pc.Scene(item), integrator=pc.RungeKutta4(), dt=0.001)
    run.step(400)
    before = run.energy()
    run[item].set(displacement=0.5 * np.cos(item.grid.coordinates[0]))
    after = run.energy()
    assert after.balance == pytest.approx(before.balance, abs=1e-12)
    assert after.total - before.total == pytest.approx(after.work - before.work, abs=1e-12)
    assert abs(after.total - before.total) > 0.01
    run.step(400)
    assert run.energy().balance == pytest.approx(before.balance, abs=1e-6)


def test_plans_and_files_know_the_values(tmp_path):
    grid = pc.Grid((4, 3), 0.1)
    held = {"x-": pc.Dirichlet([1.0, 2.0, 3.0]), "y": pc.Neumann(0.5)}
    items = [
        pc.ReactionDiffusion(grid, NOTHING, {"T": D}, {"T": 0.0}, held),
        pc.ReactionDiffusion(grid, pc.Brusselator(1.0, 2.0), {"u": D, "v": D}, {"u": 1.0, "v": 2.0}, {"u": held}),
        pc.Wave(grid, 1.0, edges=held),
    ]
    for item in items[1:]:
        run = pc.Simulation(pc.Scene(item), dt=0.01)
        assert "values at the edges" in str(run.plan)
        run.step(5)
        run.save(tmp_path / "run")
        again = pc.load(tmp_path / "run")
        assert again.scene.systems[0].edges == item.edges
        again.step(5)
        run.step(5)
        assert again.state_hash() == run.state_hash()
    driven = pc.Simulation(pc.Scene(pc.Wave(grid, 1.0, edges={"y-": pc.Dirichlet(lambda t: t)})))
    with pytest.raises(FileError, match=r"systems\[0\]\.edges\['y-'\]\.value: a Wave cannot be saved"):
        driven.save(tmp_path / "driven")


@pytest.mark.parametrize("kind", [pc.Dirichlet, pc.Neumann])
@pytest.mark.parametrize(
    ("make", "path"),
    [
        (lambda side: pc.Wave(GRID, 1.0, edges=side), "edges"),
        (lambda side: dish(side), "edges"),
        (lambda side: dish({"v": side}), "edges['v']"),
    ],
)
def test_functions_that_fail_later_are_named_by_their_sides(kind, make, path):
    late = kind(lambda t: 1.0 if t < 0.05 else np.nan)
    for side in ("x-", "x+", "y-", "y+"):
        run = pc.Simulation(pc.Scene(make({side: late})), dt=0.01)
        with pytest.raises((SceneError, pc.SimulationDiverged)) as caught:
            run.step(20)
        assert f"systems[0].{path}[{side!r}].{kind.key}" in str(caught.value)
        assert run.steps <= 5


def test_species_named_as_axes_are_told_from_sides():
    kinetics = pc.Reaction(("x", "y"), lambda x, y: (0.0 * x, 0.0 * y))
    common = {"reaction": kinetics, "diffusion": {"x": 1.0, "y": 1.0}, "initial": {"x": 1.0, "y": 1.0}}
    of = lambda edges: pc.ReactionDiffusion(pc.Grid((4, 3), 0.5), edges=edges, **common).edges  # noqa: E731
    assert of({"x": "fixed"}) == ("fixed", "fixed", "free", "free")
    assert of({"x": {"x-": "fixed"}}) == {"x": ("fixed", "free", "free", "free"), "y": ("free",) * 4}
    assert of({"x": {"x": "free"}}) == ("free",) * 4


GRID = pc.Grid((4, 3), 0.5)


def dish(edges):
    return pc.ReactionDiffusion(GRID, pc.GrayScott(0.03, 0.06), {"u": D, "v": D}, {"u": 1.0, "v": 0.0}, edges)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: pc.Dirichlet("warm"), r"Dirichlet\.value: must be a number, got 'warm'"),
        (lambda: pc.Dirichlet(np.nan), r"Dirichlet\.value: must be finite"),
        (lambda: pc.Neumann(lambda: 1.0), r"Neumann\.gradient: the function raised TypeError"),
        (lambda: pc.Neumann(lambda t: "a"), r"Neumann\.gradient: its value"),
        (
            lambda: dish(pc.Dirichlet([1.0, 2.0])),
            r"edges\['x-'\]\.value: must be a number or an array of the shape \(3,\)",
        ),
        (
            lambda: dish({"u": {"y-": pc.Neumann(np.zeros(3))}}),
            r"edges\['u'\]\['y-'\]\.gradient: .* \(4,\) of the side, got",
        ),
        (lambda: dish({"x": 1.0}), r"edges\['x-'\]: must be 'free', 'fixed', Dirichlet\(…\) or Neumann\(…\), got 1\.0"),
        (lambda: dish({"w": "free"}), r"edges: must name some of 'x', 'y', .* got 'w'"),
        (
            lambda: pc.Wave(pc.Grid(4, 0.5), 1.0, edges=pc.Dirichlet([1.0])),
            r"value: must be a number, on a grid in 1D, got",
        ),
        (
            lambda: pc.Wave(GRID, 1.0, edges=pc.Dirichlet(1.0), order=4),
            r"Wave\.order: must be 2 beside edges with values",
        ),
        (
            lambda: pc.Schrodinger(GRID, 1.0, edges=pc.Dirichlet(1.0)),
            r"Schrodinger\.edges\['x-'\]: must be 'fixed', .* got Dirichlet",
        ),
        (
            lambda: pc.Wave(pc.Grid((4, 3), 0.5, periodic=True), 1.0, edges={"x": pc.Dirichlet(1.0)}),
            r"Wave\.edges\['x'\]: the grid is periodic there",
        ),
    ],
)
def test_what_does_not_fit_is_refused_with_its_path(make, message):
    with pytest.raises(SceneError, match=message):
        make()


@pytest.mark.parametrize("value", [1.0, lambda time: 1.0], ids=["number", "function"])
def test_a_constant_value_does_no_work(value):
    """A membrane whose edge is at 1 moves as one whose edge is at 0 does, with the same energies, up to rounding.

    Displacements of up to 2 in place of 1 round to 2 ε each; 1000 steps of 120 cells add up to less than 1e-10.
    """
    grid = pc.Grid((12, 10), 0.1)
    start = np.random.default_rng(2).uniform(-1.0, 1.0, grid.cells)

    def run(shift: float, edges: object) -> pc.Recording:
        return pc.simulate(
            pc.Scene(pc.Wave(grid, 1.0, start + shift, edges=edges)),
            35.0,
            fps=1.0,
            integrator="VelocityVerlet",
            dt=0.035,
        )

    held, fixed = run(1.0, pc.Dirichlet(value)), run(0.0, "fixed")
    assert not held.energy.work.any()
    assert held.energy.total == pytest.approx(fixed.energy.total, rel=1e-10)
    assert np.abs(held.energy.drift - fixed.energy.drift).max() < 1e-10
