"""Wave functions: modes, orders, conservation, absorbing edges, an interaction, and bad input."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc

METHODS = [pc.SplitStep(), pc.SplitStep(order=4), pc.CrankNicolson(), pc.Staggered()]
ENDS = [("fixed", "fixed"), ("free", "free"), ("fixed", "free"), ("free", "fixed"), ("periodic", "periodic")]


def run(item: pc.Schrodinger, integrator: pc.Integrator, dt: float, steps: int, **numerics: object) -> pc.Simulation:
    simulation = pc.Simulation(pc.Scene(item), integrator=integrator, dt=dt, precision="f64", **numerics)
    simulation.step(steps)
    return simulation


def mode(ends: tuple[str, str], count: int, number: int) -> tuple[np.ndarray, float]:
    """A mode between two ends, and its wave number per spacing."""
    places = np.arange(count) + 0.5
    if ends[0] == "periodic":
        q = 2 * np.pi * number / count
        return np.exp(1j * q * places), q
    half = 0.5 * (ends[0] != ends[1])
    q = np.pi * (number + half) / count
    return (np.sin if ends[0] == "fixed" else np.cos)(q * places) + 0j, q


@pytest.mark.parametrize("cells", [2, 5, 8, 9])
@pytest.mark.parametrize("ends", ENDS)
def test_modes_turn_at_their_energies(ends: tuple[str, str], cells: int) -> None:
    # ψ exp(−iEt/ħ) with E = ħ²q²/2m for split steps, to rounding: transforms of even and odd lengths, at all ends.
    wave, q = mode(ends, cells, 1)
    grid = pc.Grid((cells,), 0.7, periodic=ends[0] == "periodic")
    edges = {} if grid.periodic[0] else {"x-": ends[0], "x+": ends[1]}
    item = pc.Schrodinger(grid, wave, mass=1.3, hbar=0.9, edges=edges)
    energy = (0.9 * q / 0.7) ** 2 / (2 * 1.3)
    simulation = run(item, pc.SplitStep(), 0.3, 4)
    assert np.abs(simulation[item].wave_function - wave * np.exp(-1j * energy * 1.2 / 0.9)).max() < 1e-13
    norm = np.sum(np.abs(wave) ** 2) * 0.7
    assert math.isclose(simulation.energy().kinetic, energy * norm, rel_tol=1e-12)


@pytest.mark.parametrize("ends", ENDS)
def test_differences_have_their_own_modes(ends: tuple[str, str]) -> None:
    # With three points E = ħ²/mh² (1 − cos q), and a step of Crank and Nicolson's turns by 2 atan(E dt/2ħ).
    wave, q = mode(ends, 8, 1)
    grid = pc.Grid((8,), 0.7, periodic=ends[0] == "periodic")
    edges = {} if grid.periodic[0] else {"x-": ends[0], "x+": ends[1]}
    item = pc.Schrodinger(grid, wave, mass=1.3, hbar=0.9, edges=edges)
    energy = 0.81 / (1.3 * 0.49) * (1 - math.cos(q))
    turned = wave * np.exp(-4j * 2 * math.atan(energy * 0.3 / 1.8))
    assert np.abs(run(item, pc.CrankNicolson(), 0.3, 4)[item].wave_function - turned).max() < 1e-13
    leap = np.exp(-4j * 2 * math.asin(energy * 0.3 / 1.8))  # Visscher's: a leapfrog of both parts
    if ends[0] != "periodic":
        shown = run(item, pc.Staggered(), 0.3, 4)[item].wave_function
        assert np.abs(shown.real - (wave * leap).real).max() < 1e-13


@pytest.mark.parametrize("method", METHODS, ids=repr)
@pytest.mark.parametrize("cells", [(24,), (12, 10), (6, 5, 4)], ids=["1D", "2D", "3D"])
def test_orders(method: pc.Integrator, cells: tuple[int, ...]) -> None:
    grid = pc.Grid(cells, 0.5)
    middle = np.array(grid.upper) / 2
    packet = pc.wave_packet(grid, middle, 0.4, 0.8)
    item = pc.Schrodinger(
        grid, packet, potential=lambda *x: 0.5 * sum((a - m) ** 2 for a, m in zip(x, middle, strict=True))
    )
    base = 8 * len(cells) if method != pc.Staggered() else 64  # below the resonance, and below the limit of stability
    ends = [run(item, method, 0.8 / steps, steps)[item].wave_function for steps in (base, 2 * base, 4 * base)]
    order = math.log2(np.linalg.norm(ends[0] - ends[1]) / np.linalg.norm(ends[1] - ends[2]))
    assert abs(order - method.order) < 0.25, order


@pytest.mark.parametrize("method", METHODS, ids=repr)
def test_probability_is_kept_and_threads_change_no_bit(method: pc.Integrator) -> None:
    grid = pc.Grid((40, 36), 0.5)
    item = pc.Schrodinger(grid, pc.wave_packet(grid, (8, 9), (1, -0.5), 1.5), potential=lambda x, y: 0.1 * x)
    one, two = (run(item, method, 0.02, 50, threads=threads) for threads in (1, 2))
    assert one.state_hash() == two.state_hash()
    bound = 1e-12 if method != pc.Staggered() else 1e-3  # whose norm oscillates by (E dt/ħ)²
    assert abs(one.budgets()["probability"].total - 1.0) < bound


def test_an_interaction_keeps_a_soliton() -> None:
    # g < 0: ψ = √(−m g)/2ħ sech(κ (x − vt)) exp(i …) with κ = −m g/2ħ²; N = 1 (Pitaevskii & Stringari, chapter 5.5).
    grid = pc.Grid((240,), 0.1, origin=-12.0, periodic=True)
    kappa, speed = 1.5, 0.5
    x = grid.centers[:, 0]
    start = math.sqrt(kappa / 2) / np.cosh(kappa * x) * np.exp(1j * speed * x)
    item = pc.Schrodinger(grid, start, interaction=-2 * kappa)
    expected = np.abs(np.roll(start, 10)) ** 2  # after 2 s it is 1 m farther
    errors = {
        integrator: np.abs(run(item, integrator, dt, round(2.0 / dt))[item].density - expected).max()
        for integrator, dt in ((pc.SplitStep(), 0.001), (pc.SplitStep(order=4), 0.002), (pc.CrankNicolson(), 0.002))
    }
    assert errors[pc.SplitStep()] < 1e-5
    assert errors[pc.SplitStep(order=4)] < 1e-7
    assert errors[pc.CrankNicolson()] < 0.02  # (κh)²/12 of the differences, over κ² t turns


@pytest.mark.parametrize("part", [0.99, 1.01])
def test_staggered_steps_are_stable_up_to_their_limit(part: float) -> None:
    grid = pc.Grid((16,), 0.5)
    item = pc.Schrodinger(grid, (-1.0) ** np.arange(16))  # the fastest mode: E = 2 ħ²/mh²
    dt = part * 2.0 / 8.0
    simulation = pc.Simulation(pc.Scene(item), integrator=pc.Staggered(), dt="auto", precision="f64")
    assert math.isclose(simulation.plan.dt_limit, 0.25, rel_tol=1e-12)
    if part < 1.0:
        assert run(item, pc.Staggered(), dt, 400).budgets()["probability"].total < 60.0 * 8.0
    else:
        with pytest.warns(pc.StabilityWarning), pytest.raises(pc.SimulationDiverged):
            run(item, pc.Staggered(), dt, 4000)


def test_split_steps_know_their_resonance() -> None:
    grid = pc.Grid((64,), 0.2, periodic=True)
    item = pc.Schrodinger(grid, pc.wave_packet(grid, 6.0, 1.0, 1.0), potential=lambda x: 0.1 * np.cos(x))
    plan = pc.Simulation(pc.Scene(item), integrator=pc.SplitStep()).plan
    assert math.isclose(plan.dt_limit, 4 * math.pi / (math.pi / 0.2) ** 2, rel_tol=1e-12)
    assert plan.dt < plan.dt_limit
    free = pc.Schrodinger(grid, pc.wave_packet(grid, 6.0, 1.0, 1.0))
    assert pc.Simulation(pc.Scene(free), integrator=pc.SplitStep(), dt=10.0).plan.dt_limit == math.inf


def test_what_is_set_counts_as_supplied_and_checkpoints_go_on(tmp_path) -> None:
    grid = pc.Grid((48,), 0.25)
    item = pc.Schrodinger(grid, pc.wave_packet(grid, 6.0, 2.0, 1.0), edges="absorbing", name="packet")
    simulation = run(item, pc.SplitStep(), 0.02, 200)
    probability, energy = simulation.budgets()["probability"], simulation.energy()
    assert probability.removed > 0.3
    assert abs(probability.total + probability.removed - 1.0) < 1e-12
    assert abs(energy.balance / run(item, pc.SplitStep(), 0.02, 1).energy().balance - 1.0) < 1e-12  # free motion
    simulation.save(tmp_path / "there.npz")
    loaded = pc.load(tmp_path / "there.npz")
    for each in (simulation, loaded):
        each.step(10)
    assert simulation.state_hash() == loaded.state_hash()
    simulation[item].set(wave_function=pc.wave_packet(grid, 3.0, 0.0, 1.0))
    after = simulation.budgets()["probability"]
    assert abs(after.total - 1.0) < 1e-12
    assert abs(after.total + after.removed - after.supplied - 1.0) < 1e-12
    with pytest.raises(pc.SceneError, match=r"set\.wave_function"):
        simulation[item].set(wave_function=np.zeros(47))


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"potential": 1j * np.ones(8)}, r"Schrodinger\.potential: must be"),
        ({"potential": np.ones(7)}, r"Schrodinger\.potential: .*shape"),
        ({"wave_function": np.ones(7)}, r"Schrodinger\.wave_function: .*shape"),
        ({"wave_function": np.zeros(8)}, r"Schrodinger\.wave_function: must not be zero"),
        ({"wave_function": np.full(8, np.nan + 0j)}, r"Schrodinger\.wave_function.*finite"),
        ({"mass": 0.0}, r"Schrodinger\.mass"),
        ({"hbar": -1.0}, r"Schrodinger\.hbar"),
        ({"edges": "open"}, r"Schrodinger\.edges"),
    ],
)
def test_bad_input(values: dict[str, object], message: str) -> None:
    with pytest.raises(pc.SceneError, match=message):
        pc.Schrodinger(pc.Grid((8,), 1.0), **{"wave_function": np.ones(8), **values})


def landscape(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A potential without symmetry."""
    return 0.1 * (x - 4.0) ** 2 + 0.3 * np.sin(y) * x


@pytest.mark.parametrize("method", METHODS, ids=repr)
def test_wave_functions_superpose(method: pc.Integrator) -> None:
    """Without interaction the motion of a sum is the sum of motions, to the rounding of 50 steps; with it, it is not.

    Staggered has real and imaginary parts half a step apart: its motion is linear over real numbers.
    """
    grid = pc.Grid((24, 20), 0.4)
    one, two = pc.wave_packet(grid, (3.0, 4.0), (1.0, 0.0), 1.0), pc.wave_packet(grid, (6.0, 4.0), (-1.0, 0.5), 0.8)

    def end(start: np.ndarray, interaction: float) -> np.ndarray:
        item = pc.Schrodinger(grid, start, landscape, interaction=interaction)
        return run(item, method, 0.02, 50)[item].wave_function

    share = -0.5 if method == pc.Staggered() else 1j

    def excess(interaction: float) -> float:
        together = end(2.0 * one + share * two, interaction)
        return float(np.abs(together - 2.0 * end(one, interaction) - share * end(two, interaction)).max())

    assert excess(0.0) < 1e-13
    if method != pc.Staggered():
        assert excess(1.0) > 1e-2


@pytest.mark.parametrize("interaction", [0.0, -1.0])
@pytest.mark.parametrize("method", METHODS[:2], ids=repr)
def test_a_moving_observer_sees_the_same_density(method: pc.Integrator, interaction: float) -> None:
    """ψ exp(iqx/ħ) moves by qt/m more, with the same |ψ|²: to rounding without interaction; with it the nonlinear term
    makes waves that the grid does not have, of |ψ̂|² at a third of its largest wave number.
    """
    grid = pc.Grid((240,), 0.1, origin=-12.0, periodic=True)
    (x,) = grid.coordinates
    start = np.exp(-(x**2) / 2.0) * (1.0 + 0.3 * x)
    boost, mass = 2.0 * np.pi * 3 / 24.0, 1.3
    time = 30 * 0.1 * mass / boost  # 30 cells
    densities = []
    for momentum in (0.0, boost):
        item = pc.Schrodinger(grid, start * np.exp(1j * momentum * x), mass=mass, interaction=interaction)
        densities.append(run(item, method, time / 1000, 1000)[item].density)
    moved = np.roll(densities[0], 30)
    assert np.abs(moved - densities[0]).max() > 0.1
    assert np.abs(densities[1] - moved).max() < (1e-12 if interaction == 0.0 else 1e-9)


@pytest.mark.parametrize("method", METHODS, ids=repr)
@pytest.mark.parametrize("edges", ["fixed", "free", "periodic"])
@pytest.mark.parametrize("cells", [60, 64])
def test_parity_is_kept(method: pc.Integrator, edges: str, cells: int) -> None:
    """A wave function that is even or odd about the middle stays so: to the bit with Staggered, whose neighbors are on
    both sides; elsewhere to the rounding of 300 steps of up to five substeps, in which sums run from one end on.
    """
    grid = pc.Grid((cells,), 0.25, origin=-cells / 8, periodic=edges == "periodic")
    packet = pc.wave_packet(grid, 2.0, 1.0, 1.0)
    words = {} if edges == "periodic" else {"edges": edges}
    for sign in (1.0, -1.0):
        item = pc.Schrodinger(grid, packet + sign * packet[::-1], lambda x: 0.1 * x * x, **words)
        end = run(item, method, 0.01, 300)[item].wave_function
        off = np.abs(end - sign * end[::-1]).max()
        assert off <= (0.0 if method == pc.Staggered() else 1e-12)


@pytest.mark.parametrize("method", METHODS, ids=repr)
def test_the_period_in_a_trap_has_the_order_of_the_method(method: pc.Integrator) -> None:
    """Of a packet at 2 m from the middle, by its place after a quarter: 2 δω t. That of the grid, which methods of
    differences have besides, is the same for each step, and drops out of differences. Staggered shows its second-order
    error of the real part half a step later.
    """
    grid = pc.Grid((64,), 0.25, origin=-8.0)
    (x,) = grid.coordinates
    item = pc.Schrodinger(grid, pc.wave_packet(grid, 2.0, 0.0, math.sqrt(0.5)), lambda x: 0.5 * x * x)
    base = {2: 24, 4: 24}[method.order] if method != pc.Staggered() else 100
    places = []
    for steps in (base, 2 * base, 4 * base):
        density = run(item, method, 0.5 * math.pi / steps, steps)[item].density
        places.append(float(density @ x / density.sum()))
    assert math.log2(abs(places[0] - places[1]) / abs(places[1] - places[2])) == pytest.approx(method.order, abs=0.2)
    if isinstance(method, pc.SplitStep) and method.order == 2:  # a leapfrog's frequency is 1 + dt²/24
        assert places[0] == pytest.approx(-2.0 * (0.5 * math.pi) ** 3 / 24.0 / base**2, rel=0.02)


@pytest.mark.parametrize("method", [pc.SplitStep(), pc.CrankNicolson(), pc.Staggered()], ids=repr)
@pytest.mark.parametrize("cells", [(60,), (60, 16)], ids=["1D", "2D"])
def test_an_absorbing_edge_meters_what_the_grid_loses(method: pc.Integrator, cells: tuple[int, ...]) -> None:
    """The packet leaves at x+; what has been removed is the norm that is missing, at any time: to rounding, and with
    Staggered, which keeps R² + I₊I₋ instead of |ψ|², up to its (E dt)² of what changes in a step.
    """
    grid = pc.Grid(cells, 0.2)
    packet = pc.wave_packet(grid, [6.0, 1.6][: len(cells)], [3.0, 0.0][: len(cells)], [0.8, 0.4][: len(cells)])
    item = pc.Schrodinger(grid, packet, edges={"x+": "absorbing"})
    simulation = pc.Simulation(pc.Scene(item), integrator=method, dt=0.005, precision="f64")
    removed = []
    for _ in range(16):
        simulation.step(50)
        amount = simulation.budgets()["probability"]
        removed.append(amount.removed_by["edges"])
        missing = 1.0 - float((np.abs(simulation[item].wave_function) ** 2).sum()) * 0.2 ** len(cells)
        assert abs(removed[-1] - missing) < (1e-6 if method == pc.Staggered() else 2e-12)
    assert removed[0] < 1e-6
    assert (np.diff(removed) > 0.0).all()
    assert removed[-1] > 0.98
