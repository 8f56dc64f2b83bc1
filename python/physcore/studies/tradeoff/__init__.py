"""What speed costs in accuracy: measured, on the user's own scene.

    trade = pc.tradeoff(scene, duration=10.0)
    print(trade)                          # every row: integrator, time step, precision, seconds, error
    simulation = pc.Simulation(scene, **trade.best(error=1e-4).numerics)

`measuring` is the recipe; `experiment` runs a choice, `methods` says which there are, `convergence` what runs with
other steps say of its error; `reference` and `chaos` say what it can be compared with, `restarts` what to compare where
trajectories are lost. For the work–precision diagram `search` spends the budget on a series of time steps for each
method, and `result` is what comes out. For `simulate(accuracy=…)` a `selection` finds the method and the step that meet
a target, by the `refinement` of steps.
"""

from __future__ import annotations

from physcore.studies.tradeoff.measuring import tradeoff
from physcore.studies.tradeoff.result import Prediction, Row
from physcore.studies.tradeoff.trade import Tradeoff

__all__ = ["Prediction", "Row", "Tradeoff", "tradeoff"]
