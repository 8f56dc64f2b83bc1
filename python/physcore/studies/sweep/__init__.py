"""Sweeps over parameters.

    table = pc.sweep(build, {"stiffness": [50.0, 100.0]}, duration=0.1, measure=height)
    print(table)

The submodules are as follows:

- `sweeping`: the function `sweep`;
- `grid`: the points;
- `task`: the work of one point;
- `workers` and `team`: executors, and processes of this machine;
- `folder`: files of finished points;
- `result` and `table`: the rows, and the table that shows them;
- `drawing`: figures and films.
"""

from __future__ import annotations

from physcore.studies.sweep.result import SweepRow
from physcore.studies.sweep.sweeping import sweep
from physcore.studies.sweep.table import Sweep

__all__ = ["Sweep", "SweepRow", "sweep"]
