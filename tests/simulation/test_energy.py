"""The energy series: sums, drift, and the plot."""

from __future__ import annotations

import builtins

import numpy as np
import pytest

import physcore as pc
from physcore.studies.audit import audit

SERIES = pc.EnergySeries(
    kinetic=np.array([0.0, 3.0, 1.0]),
    by_term={"gravity": np.array([5.0, 1.0, 2.0]), "springs": np.array([0.0, 1.0, 0.5])},
    internal=np.array([0.5, 0.0, 0.0]),
    dissipated=np.array([0.0, 0.5, 1.5]),
    dissipated_by={"drag": np.array([0.0, 0.5, 1.5])},
    work=np.array([0.0, 0.0, 1.0]),
    times=np.array([0.0, 0.1, 0.2]),
)


def test_total_and_balance_are_the_sums_that_they_say():
    assert SERIES.potential.tolist() == [5.0, 2.0, 2.5]
    assert SERIES.total.tolist() == [5.5, 5.0, 3.5]
    assert SERIES.balance.tolist() == [5.5, 5.5, 4.0]


def test_drift_is_relative_to_the_energy_in_motion():
    # (balance − 5.5) / (largest kinetic 3 + range of the potential 3 + range of the internal energy 0.5)
    np.testing.assert_allclose(SERIES.drift, [0.0, 0.0, -1.5 / 6.5])


def test_what_does_not_move_does_not_drift():
    recording = pc.simulate(pc.Scene(pc.Particles([[0.0, 0.0]])), 0.5)
    assert (recording.energy.potential == 0.0).all()
    assert (recording.energy.drift == 0.0).all()


def test_the_plot_shows_each_term_and_the_balance():
    pytest.importorskip("matplotlib").use("Agg")
    axes = SERIES.plot()
    labels = [line.get_label() for line in axes.get_lines()]
    assert labels[:3] == ["kinetic", "potential: gravity", "potential: springs"]
    assert {"internal", "dissipated", "work"} <= set(labels)
    assert any("balance" in label for label in labels)
    assert SERIES.plot(axes) is axes


def test_without_matplotlib_the_plot_says_how_to_get_it(monkeypatch):
    real = builtins.__import__

    def missing(name, *arguments):
        if name.startswith("matplotlib"):
            raise ImportError(name)
        return real(name, *arguments)

    monkeypatch.setattr(builtins, "__import__", missing)
    with pytest.raises(pc.PhyscoreError, match=r"pip install \"physcore\[plot\]\""):
        SERIES.plot()


def test_the_audit_lists_every_term():
    scene = pc.Scene(pc.rope(3, 1.0, 100.0, pinned="start"), pc.Gravity((0.0, -1.0)))
    text = audit(pc.simulate(scene, 0.5))
    for word in ("3 particles", "BlanesMoan4", "kinetic", "potential: gravity", "potential: springs", "dissipated"):
        assert word in text
    for word in ("work", "balance", "drift: at most", "momentum", "angular momentum"):
        assert word in text


def test_a_budget_beyond_the_search_for_neighbors_is_a_divergence():
    """The step of an explicit method ends with positions that no evaluation has seen."""
    atoms = pc.Particles([[0.0, 0.0], [1.0, 0.0]], velocities=[[1e15, 0.0], [0.0, 0.0]])
    with pytest.warns(pc.StabilityWarning):
        simulation = pc.Simulation(pc.Scene(atoms, pc.LennardJones(1.0, 1.0, cutoff=2.5)), pc.ExplicitEuler(), dt=1e8)
    simulation.step()
    with pytest.raises(pc.SimulationDiverged, match=r"step 1 .* position of particle 0"):
        simulation.energy()


def test_a_budget_is_printed_as_a_table():
    head, *rows, drift = str(SERIES).splitlines()
    assert head.split() == ["energy", "[J]", "start", "end"]
    assert [row.split()[-2:] for row in rows if "springs" in row] == [["0", "0.5"]]
    assert [row.split()[-2:] for row in rows if "balance" in row] == [["5.5", "4"]]
    assert drift == "  drift: at most 2.3e-01 of the energy in motion: look at dt"  # 1.5 / 6.5
    assert "array(" not in str(SERIES)
    last = str(SERIES.at(2)).splitlines()
    assert last[0].split() == ["energy", "[J]", "at", "0.2", "s"]
    assert [row.split()[-1] for row in last if "balance" in row] == ["4"]
