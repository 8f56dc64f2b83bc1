"""Notes and warnings on waves and fronts that a grid does not carry, against the speeds that are measured."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc
from physcore.simulation.gaps import narrow
from physcore.systems.resolution import front_speed, spikes, wave_number


def symptoms(run: pc.Recording | pc.Simulation) -> set[str]:
    return {finding.symptom for finding in pc.diagnose(run)}


def noted(recording: pc.Recording) -> float:
    """The relative speed that the plan states; 1 where it has no note."""
    notes = [note for note in recording.plan.notes if "of their speed on this grid" in note]
    return float(notes[0].partition("travel at ")[2].split()[0]) if notes else 1.0


@pytest.mark.parametrize("turns", [0.2, 1.0, 1.5])
@pytest.mark.parametrize("integrator", ["CrankNicolson", "Staggered", "SplitStep"])
def test_a_packet_moves_as_the_plan_says(integrator, turns):
    """Differences move it at sin(kh)/kh of p/m, modes at p/m. The packet's own width in k adds some percent."""
    grid = pc.Grid.over(-60.0, 60.0, 0.5)
    packet = pc.wave_packet(grid, -20.0, turns / 0.5, 4.0)
    recording = pc.simulate(pc.Scene(pc.Schrodinger(grid, packet)), 8.0, fps=1.0, integrator=integrator)
    density = recording[recording.scene.systems[0]].density
    middle = (density * grid.centers[:, 0]).sum(axis=1) / density.sum(axis=1)
    assert (middle[-1] - middle[0]) / (8.0 * turns / 0.5) == pytest.approx(noted(recording), abs=0.06)
    slow = integrator != "SplitStep" and turns >= 1.0
    assert (noted(recording) < 1.0) == slow


def test_a_momentum_beyond_the_grid_is_warned_of():
    grid = pc.Grid.over(-50.0, 50.0, 0.5)
    with pytest.warns(pc.SceneWarning, match=r"p h/ħ = 3\.5 is above π"):
        packet = pc.wave_packet(grid, 0.0, 7.0, 3.0)
    recording = pc.simulate(pc.Scene(pc.Schrodinger(grid, packet)), 1.0)
    assert symptoms(recording) == {"coarse"}


@pytest.mark.parametrize(("order", "cells"), [(2, 6.0), (2, 30.0), (4, 5.0), (4, 12.0)])
def test_a_train_of_waves_travels_as_the_plan_says(order, cells):
    """The envelope of a train that runs to the right, u_t = −c u_x, in small steps."""
    grid = pc.Grid((1200,), spacing=1.0)
    k = math.tau / cells

    def train(x: np.ndarray) -> np.ndarray:
        return np.exp(-(((x - 200.0) / 50.0) ** 2)) * np.cos(k * (x - 200.0))

    def rate(x: np.ndarray) -> np.ndarray:
        return -(train(x + 1e-4) - train(x - 1e-4)) / 2e-4

    wave = pc.Wave(grid, 1.0, train, rate, order=order)
    recording = pc.simulate(pc.Scene(wave), 600.0, fps=1.0 / 600.0, dt=0.1)
    energy = np.square(recording[wave].rate[-1])
    ahead = grid.centers[:, 0] > 200.0
    middle = (energy * grid.centers[:, 0])[ahead].sum() / energy[ahead].sum()
    assert (middle - 200.0) / 600.0 == pytest.approx(noted(recording), abs=0.05)
    assert (noted(recording) < 1.0) == (cells < 10.0)


@pytest.mark.parametrize(
    ("frequency", "warned", "coarse"), [(1.0 / 0.25, True, False), (1.0 / 0.34, False, True), (0.5, False, False)]
)
def test_sources_of_short_waves_are_named(frequency, warned, coarse):
    grid = pc.Grid((300,), spacing=0.1)
    source = pc.Source((15.0,), 1.0, frequency=frequency)
    if warned:
        with pytest.warns(pc.SceneWarning, match=r"Wave\.sources\[0\]: its waves have 2\.5 cells in a wavelength"):
            pc.Wave(grid, 1.0, sources=source)
        return
    recording = pc.simulate(pc.Scene(pc.Wave(grid, 1.0, sources=source, edges="absorbing")), 10.0)
    assert any("sources[0]: 3.4 cells" in note for note in recording.plan.notes) == coarse
    assert (symptoms(recording) == {"coarse"}) == coarse


@pytest.mark.parametrize("cells", [0.3, 1.5])
def test_a_front_runs_as_the_plan_says(cells):
    """Fisher's front with r = 1, D = 1. Its speed falls below the asymptotic one by 3/(2t), Bramson's correction."""
    spacing = 1.0 / cells
    grid = pc.Grid((int(200.0 * cells),), spacing=spacing)
    logistic = pc.Reaction(("n",), lambda n: (n * (1.0 - n),))
    dish = pc.ReactionDiffusion(grid, logistic, {"n": 1.0}, {"n": lambda x: 1.0 * (x < 20.0)})
    recording = pc.simulate(pc.Scene(dish), 50.0, fps=0.2)
    amount = recording[dish]["n"].sum(axis=1) * spacing
    late = (amount[-1] - amount[-5]) / 20.0
    expected = 2.0 * front_speed(cells)
    assert late == pytest.approx(expected - 1.5 / 40.0 / front_speed(cells), rel=0.03)
    notes = [note for note in recording.plan.notes if "fronts have" in note]
    assert bool(notes) == (cells < 1.0)
    assert not notes or f"run {front_speed(cells):.2f} times too fast" in notes[0]


def test_the_wave_number_of_a_sine_is_exact():
    """Where it is periodic: Σ|Δu|² = 4 sin²(kh/2) Σu²; of a field of zeros and of an alternating one 0 and π."""
    cells = np.arange(4000)
    assert wave_number(np.sin(0.3 * cells)) == pytest.approx(0.3, rel=2.0 / 4000.0)
    assert wave_number(np.exp(1.2j * cells)) == pytest.approx(1.2, rel=2.0 / 4000.0)
    assert wave_number((-1.0) ** cells) == pytest.approx(math.pi, abs=0.05)
    assert wave_number(np.zeros(5)) == 0.0


def sloshing(rows: int) -> tuple[float, list[str]]:
    """The loss of amplitude of the first mode of a layer in its first period, and the plan's notes on its rows.

    The layer is 1 m deep and 4 m long. It starts flat, with the velocities of the mode of linear waves.
    """
    spacing, k, height = 1.0 / rows, math.pi / 4.0, 0.05
    x = pc.block((0.0, 0.0), (4.0, 1.0), spacing)
    frequency = math.sqrt(9.81 * k * math.tanh(k))
    along = -np.sin(k * x[:, 0]) * np.cosh(k * x[:, 1]), np.cos(k * x[:, 0]) * np.sinh(k * x[:, 1])
    fluid = pc.Fluid(x, spacing, velocities=height * frequency / math.sinh(k) * np.column_stack(along))
    scene = pc.Scene(fluid, pc.Gravity((0.0, -9.81)), pc.Box((0.0, 0.0), (4.0, 10.0)))
    period = 2.0 * math.pi / frequency
    recording = pc.simulate(scene, 1.25 * period, fps=40.0 / period)
    middle = np.abs(recording.positions[:, :, 0].mean(axis=1) - 2.0)
    loss = 1.0 - middle[30:].max() / middle[:20].max()
    return loss, [note for note in recording.plan.notes if "rows of particles" in note]


@pytest.mark.parametrize("rows", [3, 8])
def test_a_layer_of_few_rows_loses_the_amplitude_that_the_plan_states(rows):
    loss, notes = sloshing(rows)
    assert (loss > 0.05) == (rows < 6) == bool(notes)
    assert all(note.startswith(f"bodies[0]: {rows} rows of particles") for note in notes)


def test_a_container_with_room_for_few_rows_is_noted():
    water = pc.Fluid(pc.block((0.0, 0.0), (0.3, 1.0), 0.1), 0.1)
    plan = pc.Simulation(pc.Scene(water, pc.Gravity(), pc.Box((0.0, 0.0), (0.3, 3.0)))).plan
    assert any("3 rows of particles" in note and "a spacing of 0.05 m" in note for note in plan.notes)


def test_a_slanted_jet_of_few_rows_is_noted():
    for angle in (0.0, 0.3, 1.1):
        along = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
        jets = [pc.Fluid(pc.block((0.0, 0.0), (2.0, height), 0.05) @ along, 0.05) for height in (0.15, 0.5)]
        scenes = (pc.Scene(jet, pc.Floor(-5.0), pc.Gravity((0.0, -9.81))) for jet in jets)
        thin, thick = (pc.Simulation(scene).plan.notes for scene in scenes)
        assert any("3 rows of particles" in note and "a spacing of 0.025 m" in note for note in thin)
        assert not any("rows of particles" in note for note in thick)


def sluice(rows: float) -> tuple[float, list[str]]:
    """The flow through a slot of 0.1 m below a gate [m²/s], and the plan's notes on gaps."""
    spacing = 0.1 / rows
    water = pc.Fluid(pc.block((0.0, 0.0), (0.6, 0.6), spacing), spacing)
    gate, tank = pc.Box((0.6, 0.1), (0.7, 3.0), inside=False), pc.Box((0.0, 0.0), (4.0, 3.0))
    recording = pc.simulate(pc.Scene(water, gate, tank, pc.Gravity((0.0, -9.81))), 0.6, fps=10.0)
    passed = 0.36 * (recording.positions[:, :, 0] > 0.65).mean(axis=1)
    return (passed[6] - passed[2]) / 0.4, [note for note in recording.plan.notes if "gap" in note]


@pytest.mark.parametrize(("rows", "least", "most"), [(2, 0.15, 0.8), (3, 0.05, 0.4), (6, -0.02, 0.05)])
def test_a_narrow_gap_lets_less_through_as_the_plan_says(rows, least, most):
    """Of the flow of 12 and 16 rows, 0.181 m²/s; a particle more or less that has passed is a flow of h²/0.4 s."""
    flow, notes = sluice(rows)
    assert least <= 1.0 - flow / 0.181 <= most
    expected = f"boundaries[0] and boundaries[1]: {rows} particles fit into the gap of 0.1 m between them"
    assert all(note.startswith(expected) and "a spacing of 0.013 m keeps 5 %" in note for note in notes)
    assert len(notes) == (rows < 6)


PEG = pc.Sphere((0.0, 0.0), 0.3)


@pytest.mark.parametrize(
    ("boundaries", "width"),
    [
        ((PEG, pc.Sphere((0.8, 0.0), 0.3)), 0.2),
        ((PEG, pc.Sphere((1.5, 0.0), 0.3)), None),
        ((PEG, pc.Sphere((0.605, 0.0), 0.3)), None),  # closer than a tenth of a particle
        ((PEG, pc.Capsule((0.5, -1.0), (0.5, 1.0), 0.05)), 0.15),
        ((PEG, pc.Box((0.5, -1.0), (2.0, 1.0), inside=False)), 0.2),
        ((PEG, pc.Box((-0.4, -0.35), (2.0, 2.0))), 0.05),
        ((PEG, pc.Sphere((0.1, 0.0), 0.5, inside=True)), 0.1),
        ((PEG, pc.Plane((0.0, -0.4), (0.0, 1.0))), 0.1),
        ((PEG, pc.ConvexHull([[0.3, 0.3], [0.9, 0.3], [0.3, 0.9]])), 0.3 * math.sqrt(2.0) - 0.3),
        ((pc.Floor(), pc.Plane((0.0, 0.25), (0.0, -2.0))), 0.25),
        ((pc.Floor(on="other"), pc.Plane((0.0, 0.25), (0.0, -1.0))), None),
        (
            (pc.ConvexHull([[0, 0], [1, 0], [0, 1]]), pc.ConvexHull([[1.1, 0.1], [1.1, 1.1], [0.1, 1.1]])),
            0.1 * math.sqrt(2.0),
        ),
    ],
)
def test_gaps_are_found_between_boundaries_of_every_kind(boundaries, width):
    """To 2 % of a spacing."""
    water = pc.Fluid(pc.block((2.0, 2.0), (3.0, 3.0), 0.1), 0.1)
    notes = narrow(pc.Scene(water, pc.Particles([[2.0, 0.0]], name="other"), *boundaries))
    assert len(notes) == (width is not None)
    if width is not None:
        assert float(notes[0].partition("the gap of ")[2].split()[0]) == pytest.approx(width, rel=0.05)


def test_the_narrowest_gap_of_a_bed_of_pegs_is_noted_once():
    water = pc.Fluid(pc.block((2.0, 2.0, 2.0), (2.6, 2.6, 2.6), 0.1), 0.1)
    pegs = [pc.Sphere((0.5 * place, 0.0, 0.0), 0.1 + 0.01 * place) for place in range(5)]
    [note] = narrow(pc.Scene(water, *pegs))
    assert note.startswith("boundaries[3] and boundaries[4]: 2.3 particles fit into the gap of 0.23 m")
    assert note.endswith("; 3 more have fewer than 6")


@pytest.mark.parametrize(("width", "sharp"), [(0.7, True), (0.9, True), (1.2, False), (1.6, False)])
@pytest.mark.parametrize("dimension", [1, 2])
def test_a_spike_levels_off_as_the_plan_says(width, sharp, dimension):
    """A Gaussian: Σ u² falls at D/σ² along each axis. The figure is that of a Gaussian whose differences between
    cells are the same; those of the sampled one depend on its place in a cell.
    """
    grid = pc.Grid((60,) * dimension, spacing=0.1)
    places = [x - 3.02 for x in grid.coordinates] if dimension > 1 else [grid.coordinates[0] - 3.02]
    spike = np.exp(-sum(x * x for x in places) / (2.0 * (0.1 * width) ** 2))
    still = pc.Reaction(("u",), lambda u: (0.0 * u,))
    item = pc.ReactionDiffusion(grid, still, {"u": 1.0}, {"u": 5.0 + spike})
    duration = 1e-6
    recording = pc.simulate(pc.Scene(item), duration, fps=1.0 / duration)
    notes = [note for note in recording.plan.notes if "spikes" in note]
    assert bool(notes) == sharp
    squares = np.square(recording[item]["u"] - 5.0).reshape(2, -1).sum(axis=1)
    rate = (1.0 - squares[1] / squares[0]) / duration / (dimension / (0.1 * width) ** 2)
    stated = float(notes[0].partition("about ")[2].split()[0]) if notes else 1.0
    assert rate == pytest.approx(stated, abs=0.06 if sharp else 0.1)


def test_spikes_are_told_from_noise_and_from_wide_seeds():
    cells = np.zeros((80, 80))
    of = lambda values: spikes("v", values, 0.1)  # noqa: E731
    noise = np.random.default_rng(0).normal(size=cells.shape)
    assert of(cells) == of(noise) == of(1.0 + 0.01 * noise) == []
    cells[40:44, 40:44] = 1.0
    assert of(cells) == of(1.0 - cells) == []
    cells[:] = 0.0
    cells[40, 40] = cells[20, 60] = 1.0
    assert "a width σ of at most 0.3 cells" in of(cells)[0]
    assert "σ = 0.16 m" in of(1.0 - cells)[0]


def accordion(angle: float, folds: int) -> pc.SpringNetwork:
    """A sheet of strips, each tilted by ± half of the angle between neighbors [rad]."""
    sheet = pc.cloth((folds + 1, 3), 1.0, 1.0, axes=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    column = np.round(sheet.positions[:, 0]).astype(int)
    positions = sheet.positions.copy()
    positions[:, 0] *= math.cos(angle / 2)
    positions[:, 2] = math.sin(angle / 2) * (column % 2)
    pairs, stiffness = sheet.pairs, sheet.stiffness
    return pc.SpringNetwork(positions, pairs=pairs, stiffness=stiffness, mass=1.0, faces=sheet.faces)


@pytest.mark.parametrize("degrees", [0.0, 80.0, 100.0])
def test_a_sheet_is_coarse_where_its_edges_are_folded_by_more_than_a_right_angle(degrees):
    """The edges between strips are 2 of about 6 per pair of squares; the others, across and along a strip, are flat."""
    found = [
        one
        for one in pc.diagnose(pc.Simulation(pc.Scene(accordion(math.radians(degrees), 8))))
        if one.symptom == "coarse"
    ]
    assert bool(found) == (degrees > 90.0)
    if found:
        inner = 7 * 2 + 8 * 1 + 8 * 2  # between strips, along the middle of them, and diagonals
        assert found[0].measured == pytest.approx(7 * 2 / inner)
        assert "finer mesh" in found[0].cure
