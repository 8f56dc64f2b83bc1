"""Textbook scenes with all defaults: error, steps and CPU time, the table of docs/accuracy.md.

python benches/defaults.py
"""

from __future__ import annotations

import sys
import time
import warnings
from pathlib import Path

from measure import table

import physcore as pc

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from textbook import TEXTBOOK, Textbook

RATES = (5.0, 30.0, 120.0)
"""Frame rates [1/s]."""


def row(case: Textbook) -> tuple[str, ...]:
    """Integrator, largest error over all frame rates, and steps and CPU time at the lowest one, the best of three."""
    recordings = [pc.simulate(case.scene, case.duration, fps=fps) for fps in RATES]
    seconds = []
    for _ in range(3):
        start = time.process_time()
        pc.simulate(case.scene, case.duration, fps=RATES[0])
        seconds.append(time.process_time() - start)
    first = recordings[0]
    steps = sum(segment.steps for segment in first.provenance.segments)
    error = max(case.error(recording) for recording in recordings)
    return case.name, first.plan.integrator, f"{error:.0e}", f"{steps}", f"{1e3 * min(seconds):.0f}"


def main() -> None:
    """Print the table."""
    warnings.simplefilter("error", pc.StabilityWarning)
    columns = ("scene", "integrator", "error", "steps", "CPU time [ms]")
    table("Ten periods with all defaults", columns, (row(case) for case in TEXTBOOK))


if __name__ == "__main__":
    main()
