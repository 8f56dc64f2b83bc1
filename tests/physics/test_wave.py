"""Waves on grids: discrete modes, orders, symmetries, budgets, reversibility and the limit of the time step."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
import pytest

import physcore as pc
from physcore.integrators import INTEGRATORS

EPSILON = float(np.finfo(float).eps)
SPEED, SPACING = 2.0, 0.1


def mode(cells: tuple[int, ...], numbers: tuple[int, ...], edges: tuple[str, ...]) -> tuple[np.ndarray, float]:
    """An eigenvector of the second differences on a grid, and its angular frequency [1/s].

    Edges lie on faces: between fixed ones it is sin(kx), between free ones cos(kx), with k = πn/L, and round a periodic
    axis cos(2πnx/L). The eigenvalue is −(4 c²/h²) Σ sin²(kh/2), exactly.
    """
    shape, square = np.ones(cells), 0.0
    for axis, (count, number, edge) in enumerate(zip(cells, numbers, edges, strict=True)):
        k = (2.0 if edge == "periodic" else 1.0) * math.pi * number / (count * SPACING)
        x = SPACING * (np.arange(count) + 0.5)
        along = np.sin(k * x) if edge == "fixed" else np.cos(k * x)
        shape = shape * along.reshape([-1 if each == axis else 1 for each in range(len(cells))])
        square += (2.0 * SPEED / SPACING * math.sin(0.5 * k * SPACING)) ** 2
    return shape, math.sqrt(square)


def wave(cells: tuple[int, ...], edges: tuple[str, ...], **options: Any) -> pc.Wave:
    """A wave between edges, one word for each axis."""
    grid = pc.Grid(cells, SPACING, periodic=tuple(word == "periodic" for word in edges))
    words = {axis: word for axis, word in zip("xyz", edges, strict=False) if word != "periodic"}
    return pc.Wave(grid, **{"speed": SPEED, "edges": words, **options})


def run(item: pc.Wave, steps: int, dt: float, integrator: pc.Integrator | None = None) -> pc.Simulation:
    """A simulation after some steps, whatever the limit."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pc.StabilityWarning)
        simulation = pc.Simulation(pc.Scene(item), integrator or pc.VelocityVerlet(), dt, "f64")
    simulation.step(steps)
    return simulation


MODES = {
    "string": ((40,), (3,), ("fixed",)),
    "pipe": ((40,), (3,), ("free",)),
    "ring": ((40,), (3,), ("periodic",)),
    "membrane": ((24, 17), (2, 3), ("fixed", "free")),
    "cylinder": ((24, 17), (2, 3), ("periodic", "fixed")),
    "room": ((9, 8, 7), (2, 1, 3), ("free", "fixed", "periodic")),
}


@pytest.mark.parametrize("name", MODES)
def test_a_mode_swings_at_the_frequency_of_verlet(name):
    """After n steps of Verlet an oscillator that starts at rest is at cos(n θ) with sin(θ/2) = ω dt/2, exactly.

    Rounding of ε per step grows at most with n² through the second differences: 500² ε = 6e-11.
    """
    cells, numbers, edges = MODES[name]
    shape, omega = mode(cells, numbers, edges)
    item = wave(cells, edges, displacement=shape)
    simulation = run(item, 500, 0.01)
    expected = math.cos(500 * 2.0 * math.asin(0.5 * omega * 0.01)) * shape
    assert np.abs(simulation[item].displacement - expected).max() < 500**2 * EPSILON


SECOND_ORDER = [kind for kind in INTEGRATORS if kind.advances("Wave")]


@pytest.mark.parametrize("kind", SECOND_ORDER, ids=lambda kind: kind.__name__)
def test_every_integrator_has_its_order(kind):
    """Against the exact swing of the discrete system, in steps so short that the next order adds a tenth at most."""
    cells, numbers, edges = MODES["membrane"]
    shape, omega = mode(cells, numbers, edges)
    item, errors = wave(cells, edges, displacement=shape), []
    steps = math.ceil(omega / (0.4 if kind.order > 3 else 0.1))
    for count in (steps, 2 * steps):
        found = run(item, count, 1.0 / count, kind())[item]
        off = np.hypot(found.displacement - math.cos(omega) * shape, found.rate / omega + math.sin(omega) * shape)
        errors.append(float(off.max()))
    assert math.log2(errors[0] / errors[1]) == pytest.approx(kind.order, abs=0.25)


@pytest.mark.parametrize("order", [2, 4])
def test_differences_in_space_have_their_order(order):
    """Against the true frequency, with a time integrator of order 6 whose error is far below."""
    errors = []
    for count in (16, 32):
        grid = pc.Grid((count, count), 1.0 / count)
        x, y = grid.coordinates
        start = np.sin(2.0 * math.pi * x) * np.cos(math.pi * y)
        item = pc.Wave(grid, 1.0, start, edges={"y": "free"}, order=order)
        end = run(item, 100, 0.005, pc.BlanesMoan6())[item].displacement
        errors.append(float(np.abs(end - math.cos(0.5 * math.pi * math.sqrt(5.0)) * start).max()))
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.25)


def blob(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Something without any symmetry."""
    return np.exp(-((x - 0.9) ** 2 + (y - 0.7) ** 2) / 0.05) * (1.0 + x)


@pytest.mark.parametrize("medium", ["uniform", "two speeds", "walls"])
def test_mirrors_and_diagonals_are_kept_to_the_bit(medium):
    """Sums over neighbors are symmetric, so that no direction is ahead of another."""
    grid = pc.Grid((32, 32), SPACING)
    x, y = grid.coordinates
    fields: dict[str, Any] = {"speed": SPEED, "displacement": blob(x, y)}
    if medium == "two speeds":
        fields["speed"] = np.where(x + 2.0 * y < 4.0, 1.0, SPEED)
    walls = (np.hypot(x - 2.0, y - 1.2) < 0.4) if medium == "walls" else np.zeros(grid.cells, dtype=bool)

    def end(change: Any) -> np.ndarray:
        turned = {name: change(value) if np.ndim(value) else value for name, value in fields.items()}
        item = pc.Wave(grid, **turned, walls=np.ascontiguousarray(change(walls)))
        return run(item, 200, 0.02)[item].displacement

    plain = end(lambda values: values)
    for change in (np.flipud, np.fliplr, np.transpose):
        assert np.array_equal(end(change), change(plain))


def test_a_shift_round_a_periodic_axis_changes_no_bit():
    grid = pc.Grid((30, 20), SPACING, periodic=True)
    start = grid.field(blob, "start")
    items = [pc.Wave(grid, SPEED, np.roll(start, shift, (0, 1))) for shift in ((0, 0), (7, -3))]
    first, second = (run(item, 100, 0.02)[item].displacement for item in items)
    assert np.array_equal(np.roll(first, (7, -3), (0, 1)), second)


def test_the_budget_of_damping_and_sources_closes_with_the_square_of_the_step():
    """Both are integrals of power by the method's own stages; nothing makes the balance constant but the motion."""
    cells = (30, 20)
    drifts = []
    for steps in (200, 400):
        item = wave(
            cells,
            ("fixed", "free"),
            displacement=blob,
            density=0.7,
            damping=lambda x, y: np.where(x > 1.5, 0.8, 0.0),
            sources=[pc.Source((1.0, 1.0), 3.0, 1.5), pc.Source((2.05, 0.63), 2.0, signal=pc.Ricker(2.0))],
        )
        energy = pc.Simulation(pc.Scene(item), dt=2.0 / steps).record(2.0, 20.0).energy
        assert energy.dissipated_by["damping"][-1] > 0.05 * energy.total[0]
        assert abs(energy.work[-1]) > 0.05 * energy.total[0]
        drifts.append(float(np.abs(energy.drift).max()))
    assert drifts[1] < 1e-2
    assert drifts[0] / drifts[1] == pytest.approx(4.0, rel=0.2)


def test_a_change_between_steps_is_work():
    item = wave((30, 20), ("fixed", "free"), displacement=blob)
    simulation = run(item, 50, 0.02)
    before = simulation.energy()
    simulation[item].set(rate=lambda x, y: np.sin(x), displacement=np.zeros((30, 20)))
    after = simulation.energy()
    assert after.work == pytest.approx(after.total - before.total, rel=1e-12)
    assert after.balance == pytest.approx(before.balance, rel=1e-12)
    with pytest.raises(pc.SceneError, match=r"systems\[0\]\.set\.height: must be one of displacement, rate"):
        simulation[item].set(height=1.0)
    with pytest.raises(pc.SceneError, match=r"systems\[0\]\.set\.rate: must be a number, .* the shape \(30, 20\)"):
        simulation[item].set(rate=np.zeros((20, 30)))


def test_a_symplectic_run_goes_back_to_where_it_began():
    """With the rate turned around; rounding of ε per step grows at most with n²."""
    item = wave((30, 20), ("fixed", "free"), displacement=blob)
    simulation = run(item, 300, 0.02)
    simulation[item].set(rate=-simulation[item].rate)
    simulation.step(300)
    assert np.abs(simulation[item].displacement - item.displacement).max() < 600**2 * EPSILON


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_the_limit_is_that_of_the_checkerboard(dimension):
    """2/ω of Verlet with ω = 2c√D/h: just below nothing grows in 1e4 steps, just above the run diverges and says where.

    On a grid round all axes with an even number of cells the checkerboard is a mode, so that the limit is exact.
    """
    cells = (12, 10, 8)[:dimension]
    rng = np.random.default_rng(4)
    item = wave(cells, ("periodic",) * dimension, displacement=rng.normal(size=cells))
    limit = pc.stability_limit(pc.Scene(item), pc.VelocityVerlet())
    assert limit == pytest.approx(SPACING / (SPEED * math.sqrt(dimension)), rel=1e-3)
    held = run(item, 10_000, 0.999 * limit)
    # At ω dt = 2 (1 − 1e-3) the discrete energy is up to 1/(1 − (ω dt/2)²) = 500 times the true one.
    assert held.energy().total < 500.0 * run(item, 0, 0.1 * limit).energy().total
    with pytest.raises(pc.SimulationDiverged, match=r"cell \(") as caught:
        run(item, 20_000, 1.003 * limit)
    assert np.isfinite(caught.value.last_good.fields["systems[0].displacement"]).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"speed": -1.0}, r"Wave\.speed: must be ≥ 0, got -1"),
        ({"speed": lambda x, y: x - 1.0}, r"Wave\.speed\[0, 0\]: must be ≥ 0, got -0.95"),
        ({"speed": lambda x: x}, r"Wave\.speed: the function raised TypeError"),
        ({"speed": np.full((3, 4), np.nan)}, r"Wave\.speed\[0, 0\]: must be finite, got nan"),
        ({"displacement": np.zeros((4, 3))}, r"Wave\.displacement: .* the shape \(3, 4\) of the grid, got the shape"),
        ({"rate": 1j * np.ones((3, 4))}, r"Wave\.rate: must be an array of real numbers, .* complex"),
        ({"density": 0.0}, r"Wave\.density: must be > 0"),
        ({"walls": np.zeros((3, 4))}, r"Wave\.walls: must be a mask"),
        ({"walls": np.zeros((4, 3), dtype=bool)}, r"Wave\.walls: must be a mask of the shape \(3, 4\)"),
        ({"edges": "open"}, r"Wave\.edges\['x-'\]: must be 'fixed', 'free', 'absorbing', .* got 'open'"),
        ({"edges": {"z": "free"}}, r"Wave\.edges: must name some of 'x', 'y', .* got 'z'"),
        ({"edges": {"x": "periodic"}}, r"Wave\.edges\['x-'\]: .* Grid\(…, periodic=True\)"),
        ({"order": 3}, r"Wave\.order: must be 2 or 4, got 3"),
        ({"sources": [pc.Source((9.0, 0.0), 1.0, 1.0)]}, r"Wave\.sources\[0\]\.where: must be on the grid, x from 0"),
        ({"sources": pc.Source((0.1,), 1.0, 1.0)}, r"Wave\.sources\[0\]\.where: must be 2 numbers"),
        ({"sources": [pc.Source((0.1, 0.1), 1.0, signal=lambda t: None)]}, r"Wave\.sources\[0\]\.signal: its value"),
    ],
)
def test_what_cannot_be_a_wave_is_refused_with_its_path(options, message):
    with pytest.raises(pc.SceneError, match=message):
        pc.Wave(pc.Grid((3, 4), 0.1), **{"speed": 1.0, **options})


def test_edges_are_words_of_axes_and_sides():
    grid = pc.Grid((3, 4, 5), 0.1, periodic=(False, False, True))
    layer = pc.Absorbing(40, 1e-4)
    item = pc.Wave(grid, 1.0, edges={"x-": "free", "x": layer, "y+": "absorbing"})
    assert item.edges == ("free", "absorbing", "fixed", "absorbing", "periodic", "periodic")
    assert item.absorbing == layer
    with pytest.raises(pc.SceneError, match="periodic there"):
        pc.Wave(grid, 1.0, edges={"z": "fixed"})


@pytest.mark.parametrize("integrator", [pc.RungeKutta4(), pc.PEFRL()], ids=lambda each: type(each).__name__)
def test_items_may_have_integrators_of_their_own(integrator, tmp_path):
    """The wave then goes as it goes alone, and the particles too; a checkpoint and a copy keep that."""
    item, dust = (
        wave((20, 10), ("fixed", "free"), displacement=blob, name="pond"),
        pc.Particles([[0.3, 0.4]], [[1.0, 2.0]]),
    )
    well = pc.CentralForce((0.0, 0.0), -1.0, exponent=1.0)
    both = pc.Simulation(pc.Scene(dust, well, item), {item: integrator}, 0.01)
    assert f"by {type(integrator).__name__}" in str(both.plan)
    alone = pc.Simulation(pc.Scene(item), integrator, 0.01), pc.Simulation(pc.Scene(dust, well), dt=0.01)
    both.step(20)
    both.save(tmp_path / "half")
    loaded = pc.load(tmp_path / "half")
    for each in (both, loaded, *alone):
        each.step(20 if each in (both, loaded) else 40)
    assert np.array_equal(both[item].displacement, alone[0][item].displacement)
    assert np.array_equal(both.positions, alone[1].positions)
    assert loaded.state_hash() == both.state_hash()
    assert loaded.provenance == both.provenance
    with pytest.raises(pc.SceneError, match=r"integrator\['lake'\]: is no item of this scene, .* 'bodies', 'pond'"):
        pc.Simulation(both.scene, {"lake": integrator})


def test_accuracy_is_that_of_the_field_where_there_are_no_particles(capsys):
    """Against a run of high order with a hundredth of the step."""
    cells, numbers, edges = MODES["string"]
    shape, omega = mode(cells, numbers, edges)
    item = wave(cells, edges, displacement=shape)
    recording = pc.simulate(pc.Scene(item), 1.0, 10.0, accuracy=1e-5, progress=False)
    exact = np.cos(omega * recording.times)[:, np.newaxis] * shape
    assert np.abs(recording[item].displacement - exact).max() < 1e-5
    assert "keeps within" in capsys.readouterr().out
    assert recording.positions.shape == (11, 0, 1)
    assert recording.momentum.shape == (11, 1)
    assert recording.angular_momentum.shape == (11, 0)


def test_accuracy_takes_one_integrator_for_each_item():
    """The particle's path is that of the method that was asked for it, though the wave has another."""
    item = wave((12, 10), ("fixed",) * 2, displacement=lambda x, y: np.sin(x) * np.sin(y))
    dust = pc.Particles([[1.0, 0.0]])
    scene = pc.Scene(dust, item, pc.CentralForce((0.0, 0.0), 1.0, exponent=1.0))
    chosen = {dust: pc.PEFRL(), item: pc.RungeKutta4()}
    recording = pc.simulate(scene, 1.0, 10.0, accuracy=1e-4, integrator=chosen, progress=False)
    assert recording.plan.integrator == "PEFRL"
    assert any("by RungeKutta4" in note for note in recording.plan.notes)
    assert np.abs(recording.positions[:, 0, 0] - np.cos(recording.times)).max() < 1e-4


def test_a_measured_limit_is_that_of_theory():
    found = pc.stability_limit(pc.Scene(wave((12, 10), ("periodic",) * 2)), pc.VelocityVerlet(), measured=True)
    assert abs(found.margin) < 5e-3
