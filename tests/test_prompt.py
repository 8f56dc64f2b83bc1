"""What a prompt shows of results: what `print` does, in ten lines at most."""

from __future__ import annotations

import pytest

import physcore as pc
from physcore.markup import Printed

pytestmark = pytest.mark.usefixtures("clock_of_work")

SCENE = pc.Scene(pc.Particles([[1.0, 0.0]], [[0.0, 1.0]]), pc.CentralForce((0.0, 0.0), 1.0, exponent=-2.0))


@pytest.fixture(scope="module")
def trade() -> pc.Tradeoff:
    return pc.tradeoff(SCENE, 1.0, budget=0.5)


@pytest.fixture(scope="module")
def results() -> list[Printed]:
    field = pc.ReactionDiffusion(pc.Grid(8, 1.0), pc.Reaction(("n",), lambda n: (-n,)), {"n": 1.0}, {"n": 1.0})
    budgets = pc.simulate(pc.Scene(field), 0.1).budgets
    recording = pc.simulate(SCENE, 0.1)
    limit = pc.stability_limit(SCENE, pc.VelocityVerlet(), measured=True)
    return [
        recording.energy,
        pc.Simulation(SCENE).energy(),
        *budgets.values(),
        *pc.Simulation(pc.Scene(field)).budgets().values(),
        recording.plan,
        pc.diagnose(recording),
        pc.lyapunov(SCENE, 1.0, exponents=2),
        limit,
    ]


def test_results_are_shown_as_they_are_printed(results):
    kinds = {type(each) for each in results}
    assert {pc.EnergySeries, pc.Energy, pc.AmountSeries, pc.Amount, pc.Plan, pc.Diagnosis, pc.Lyapunov} <= kinds
    for result in results:
        assert repr(result) == str(result)
        assert "array(" not in repr(result)


def test_a_trade_is_a_table_of_ten_lines_at_most(trade):
    lines = repr(trade).splitlines()
    assert len(lines) <= 10
    assert lines[1].split()[:1] == ["integrator"]
    shown = [line.split()[1] for line in lines[2:-1]]
    assert shown[0] == trade.front[0].label
    assert shown[-1] == trade.front[-1].label
    assert f"of {len(trade.rows)} rows" in lines[-1]
    assert len(str(trade).splitlines()) == len(trade.rows) + 3
