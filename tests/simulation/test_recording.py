"""Recordings: frames at a fixed rate, whatever the time step, that change nothing in the run."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from physcore.simulation.energy import Energy
from physcore.simulation.state import Frame, Snapshot
from physcore.simulation.within import between
from physcore.studies.audit import audit

BALL = pc.Particles([[0.0, 1.0]], velocities=[[2.0, 5.0]], name="ball")
THROW = pc.Scene(BALL, pc.Gravity((0.0, -9.81)))


def parabola(times: np.ndarray) -> np.ndarray:
    return np.stack([2.0 * times, 1.0 + 5.0 * times - 9.81 / 2 * times**2], axis=-1)


@pytest.mark.parametrize(
    ("duration", "fps", "frames"), [(2.0, 30.0, 61), (0.0, 30.0, 1), (1.0 / 3.0, 30.0, 11), (0.99, 10.0, 10)]
)
@pytest.mark.parametrize("dt", ["auto", 1e-3, 1.0 / 30.0, 0.07])
def test_frames_are_at_multiples_of_the_interval(duration, fps, frames, dt):
    recording = pc.simulate(THROW, duration, fps, dt=dt)
    assert len(recording) == frames
    assert (recording.times == np.arange(frames) / fps).all()
    assert recording.positions.shape == recording.velocities.shape == (frames, 1, 2)
    # Verlet and a cubic are both exact on a parabola: what is left is rounding, of steps · ulp(10).
    np.testing.assert_allclose(recording.positions[:, 0], parabola(recording.times), rtol=0, atol=1e-11)
    np.testing.assert_allclose(recording.velocities[:, 0, 1], 5.0 - 9.81 * recording.times, rtol=0, atol=1e-11)


def test_a_frame_on_a_step_is_that_step():
    simulation = pc.Simulation(THROW, dt=0.01)
    recording = simulation.record(1.0, fps=20.0)
    assert (recording.positions[-1] == simulation.positions).all()
    assert recording.energy.times[7] == pytest.approx(recording.times[7], abs=1e-6 * 0.01)


def test_the_energy_of_a_frame_between_steps_is_that_of_the_step_before():
    recording = pc.simulate(THROW, duration=1.0, fps=30.0, dt=0.07)
    steps = np.floor(recording.times / 0.07 + 1e-6)
    np.testing.assert_allclose(recording.energy.times, steps * 0.07, rtol=1e-14)
    np.testing.assert_allclose(recording.energy.total, recording.energy.total[0], rtol=1e-13)


def test_a_recording_can_start_later():
    simulation = pc.Simulation(THROW, dt=0.01)
    simulation.run(0.5)
    recording = simulation.record(0.5, fps=10.0)
    assert recording.times[0] == simulation.time - 0.5 == 0.5
    np.testing.assert_allclose(recording.positions[:, 0], parabola(recording.times), rtol=0, atol=1e-12)


@pytest.mark.parametrize("dt", ["auto", 0.01])
def test_who_steps_between_two_frames_is_told(dt):
    simulation = pc.Simulation(THROW, dt=dt)
    frames = simulation.frames(1.0)
    next(frames)
    simulation.step()
    with pytest.raises(pc.PhyscoreError, match="took 1 steps between two of its frames"):
        next(frames)


def test_the_frames_of_automatic_steps_end_with_the_duration():
    simulation = pc.Simulation(THROW)
    simulation.record(0.99, fps=10.0)
    assert simulation.time == pytest.approx(0.99, rel=1e-14)


def test_a_body_has_its_part():
    still = pc.Particles([[7.0, 7.0], [8.0, 8.0]], fixed=True)
    recording = pc.simulate(pc.Scene(still, BALL, pc.Gravity((0.0, -9.81))), 0.5)
    assert (recording[BALL].positions == recording.positions[:, 2:]).all()
    assert (recording["ball"].velocities == recording.velocities[:, 2:]).all()
    assert (recording[0].positions == still.positions).all()
    assert repr(recording[0]) == "Trajectory(16 frames: positions (16, 2, 2), velocities (16, 2, 2))"
    assert (recording[still].times == recording.times).all()


def test_only_the_channels_asked_for_are_kept():
    recording = pc.simulate(THROW, 0.5, channels=("positions",))
    assert recording.positions.shape == (16, 1, 2)
    with pytest.raises(pc.SceneError, match="velocities were not recorded"):
        _ = recording.velocities


def test_only_fluids_have_densities_and_pressures():
    with pytest.raises(pc.SceneError, match=r"channels: .* only a Fluid has densities and pressures"):
        pc.simulate(THROW, 0.5, channels=("positions", "densities"))
    with pytest.raises(pc.SceneError, match="pressures: only a Fluid has them"):
        _ = pc.Simulation(THROW)[BALL].pressures
    with pytest.raises(pc.SceneError, match=r"densities were not recorded; .* only a Fluid has them"):
        _ = pc.simulate(THROW, 0.5).densities


def test_momentum_and_angular_momentum_are_recorded():
    recording = pc.simulate(THROW, 0.5, dt=0.01, fps=10.0)
    assert recording.momentum.shape == (6, 2)
    np.testing.assert_allclose(recording.momentum, recording.velocities[:, 0], rtol=1e-14)
    x, v = recording.positions[:, 0], recording.velocities[:, 0]
    np.testing.assert_allclose(
        recording.angular_momentum[:, 0], x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0], rtol=0, atol=1e-13
    )


def test_a_recording_that_does_not_fit_is_refused_before_it_starts(monkeypatch):
    monkeypatch.setattr("physcore.memory.available", lambda: 1000)
    simulation = pc.Simulation(THROW)
    with pytest.raises(pc.SceneError, match=r"duration: 61 frames of 1 particles .*lower fps"):
        simulation.record(2.0)
    assert simulation.steps == 0


def test_save_and_load_give_the_same_recording(tmp_path):
    path = tmp_path / "throw.npz"
    recording = pc.simulate(THROW, 0.5)
    recording.save(path)
    loaded = pc.load(path)
    assert isinstance(loaded, pc.Recording)
    for name in ("times", "positions", "velocities", "momentum", "angular_momentum"):
        assert (getattr(loaded, name) == getattr(recording, name)).all()
    assert (loaded.energy.total == recording.energy.total).all()
    assert (loaded.plan, loaded.fps) == (recording.plan, recording.fps)
    assert (loaded["ball"].positions == recording.positions).all()
    with np.load(path) as archive:
        assert (archive["positions"] == recording.positions).all()


RATES = {"positions": "velocities", "velocities": None}


def state(x: float, v: float) -> dict[str, np.ndarray]:
    return {"positions": np.array([[x]]), "velocities": np.array([[v]])}


def frame(x: float, v: float) -> Frame:
    energy = Energy(kinetic=0.0, by_term={}, internal=0.0, dissipated=0.0, dissipated_by={}, work=0.0, time=0.0)
    return Frame(0.0, state(x, v), 0.1, energy, np.zeros(1), np.zeros(1))


@given(coefficients=st.tuples(*[st.floats(-10, 10)] * 4), fraction=st.floats(0, 1), dt=st.floats(0.1, 10))
def test_the_interpolation_is_exact_for_cubics(coefficients, fraction, dt):
    cubic = np.polynomial.Polynomial(coefficients)
    slope = cubic.deriv()
    after = Snapshot(dt, state(cubic(dt), slope(dt)))
    found = between(frame(cubic(0.0), slope(0.0)), after, fraction, dt, RATES)
    # Rounding: some ten operations on terms of at most 10 · 4 · 10³ (positions), and that divided by dt (velocities).
    scale = 40.0 * max(1.0, dt) ** 3
    assert found.positions[0, 0] == pytest.approx(cubic(fraction * dt), abs=30 * 2.0**-53 * scale)
    assert found.velocities[0, 0] == pytest.approx(slope(fraction * dt), abs=300 * 2.0**-53 * scale / min(1.0, dt))


@given(x=st.floats(-1e9, 1e9), fraction=st.floats(0, 1))
def test_what_rests_stays_where_it_is_to_the_bit(x, fraction):
    assert between(frame(x, 0.0), Snapshot(0.1, state(x, 0.0)), fraction, 0.1, RATES).positions[0, 0] == x


def test_budgets_of_other_quantities_are_saved_and_tell_their_drift(tmp_path):
    """balance = total + removed − supplied, and the drift is relative to the largest total."""
    whole = pc.Simulation(pc.Scene(pc.Particles([[0.0, 0.0]])), dt=0.1).record(0.2, fps=10.0)
    assert whole.budgets == {}
    moments = [pc.Amount("mol", 2.0 - 0.5 * k, {"edges": 0.4 * k}, {"feed": 0.1 * k}, 0.1 * k) for k in range(3)]
    recording = replace(whole, budgets={"u": pc.AmountSeries.of(moments)})
    recording.save(tmp_path / "run")
    loaded = pc.load(tmp_path / "run")
    for series in (recording.budgets["u"], loaded.budgets["u"]):
        assert series.unit == "mol"
        np.testing.assert_allclose(series.removed, [0.0, 0.4, 0.8])
        np.testing.assert_allclose(series.supplied, [0.0, 0.1, 0.2])
        np.testing.assert_allclose(series.balance, [2.0, 1.8, 1.6])
        np.testing.assert_allclose(series.drift, [0.0, -0.1, -0.2])
        np.testing.assert_allclose(series.times, [0.0, 0.1, 0.2])
    assert "u [mol]: 2 → 1, drift at most 2.0e-01" in audit(recording)


def test_a_recording_is_filmed_by_itself(tmp_path):
    recording = pc.simulate(THROW, 0.1)
    film = recording.film(tmp_path / "one.png", size=(80, 60))
    pc.film(recording, tmp_path / "other.png", size=(80, 60))
    assert film.path.read_bytes() == (tmp_path / "other.png").read_bytes()


def test_a_table_has_a_row_for_each_particle_at_each_time():
    pytest.importorskip("pandas")
    grains = pc.Particles([[0.0, 1.0], [2.0, 3.0]], velocities=[[1.0, 0.0], [0.0, 0.0]])
    recording = pc.simulate(pc.Scene(BALL, grains, pc.Gravity()), 0.1)
    table = recording.to_dataframe()
    assert list(table.columns) == ["time", "body", "particle", "x", "y", "vx", "vy"]
    assert len(table) == len(recording) * 3
    assert table.body[:3].tolist() == ["ball", 1, 1]
    assert table.particle[:3].tolist() == [0, 0, 1]
    np.testing.assert_array_equal(table[["x", "y"]].to_numpy(), recording.positions.reshape(-1, 2))
    np.testing.assert_array_equal(table[["vx", "vy"]].to_numpy(), recording.velocities.reshape(-1, 2))
    np.testing.assert_array_equal(table.time[::3], recording.times)
    mine = recording[grains].to_dataframe()
    assert list(mine.columns) == ["time", "particle", "x", "y", "vx", "vy"]
    np.testing.assert_array_equal(mine.y, recording.positions[:, 1:, 1].ravel())
    wave = pc.simulate(pc.Scene(pc.Wave(pc.Grid((4, 4), 0.1), 1.0)), 0.1)
    with pytest.raises(pc.SceneError, match="to_dataframe: nothing with particles was recorded"):
        wave.to_dataframe()


def test_a_plot_shows_means_and_bands():
    pytest.importorskip("matplotlib").use("Agg")
    two = pc.Particles([[0.0, 1.0], [2.0, 3.0]], name="two")
    recording = pc.simulate(pc.Scene(two, pc.Gravity()), 0.1)
    axes = recording.plot("positions")
    assert [line.get_label() for line in axes.get_lines()] == ["x", "y"]
    np.testing.assert_array_equal(axes.get_lines()[1].get_ydata(), recording.positions[:, :, 1].mean(axis=1))
    assert len(axes.collections) == 2
    assert axes.get_ylabel() == "positions [m]"
    assert recording["two"].plot("velocities").get_ylabel() == "velocities [m/s]"
    assert recording.plot().get_ylabel() == "energy [J]"
    (line,) = recording.plot("angular_momentum").get_lines()
    np.testing.assert_array_equal(line.get_ydata(), recording.angular_momentum[:, 0])
    with pytest.raises(pc.SceneError, match=r"plot.channel: .* did you mean 'velocities'\?"):
        recording.plot("velocity")


@pytest.mark.parametrize(("module", "call"), [("pandas", "to_dataframe"), ("matplotlib", "plot")])
def test_what_is_not_installed_is_named(module, call, monkeypatch):
    recording = pc.simulate(THROW, 0.1)
    for name in (module, *(each for each in sys.modules if each.startswith(f"{module}."))):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(pc.PhyscoreError, match=r"pip install \"physcore\["):
        getattr(recording, call)()
