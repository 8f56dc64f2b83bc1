"""Trade-off between speed and accuracy, measured on the user's own scene.

    trade = pc.tradeoff(scene, duration=10.0)
    print(trade)                          # every row: integrator, time step, precision, seconds, error
    simulation = pc.Simulation(scene, **trade.best(error=1e-4).numerics)

The submodules are as follows:

- `measuring`: the function `tradeoff`;
- `experiment`: runs of a choice of numerics;
- `methods`: the methods that support a scene;
- `convergence`: errors from runs with different steps;
- `reference` and `chaos`: the solution that results are compared with;
- `restarts`: the comparison of chaotic runs.

For the work–precision diagram, `search` spends the budget on a series of time steps for each method, and `result` is
the outcome. For `simulate(accuracy=…)`, `selection` finds the method and the step that meet a target, by the
`refinement` of steps.
"""

from __future__ import annotations

from physcore.studies.tradeoff.measuring import tradeoff
from physcore.studies.tradeoff.result import Prediction, Row
from physcore.studies.tradeoff.trade import Tradeoff

__all__ = ["Prediction", "Row", "Tradeoff", "tradeoff"]
