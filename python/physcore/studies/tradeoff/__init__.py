"""What speed costs in accuracy: measured, on the user's own scene.

    trade = pc.tradeoff(scene, duration=10.0)
    print(trade)                          # every row: integrator, time step, precision, seconds, error
    simulation = pc.Simulation(scene, **trade.best(error=1e-4).numerics)

`measuring` is the recipe; `experiment` runs a choice, `reference` and `chaos` say what it can be compared with,
`restarts` what to compare where trajectories are lost, `search` spends the budget on each `ladder` of time steps, and
`result` is what comes out.
"""

from __future__ import annotations

from physcore.studies.tradeoff.measuring import tradeoff
from physcore.studies.tradeoff.result import Prediction, Row
from physcore.studies.tradeoff.trade import Tradeoff

__all__ = ["Prediction", "Row", "Tradeoff", "tradeoff"]
