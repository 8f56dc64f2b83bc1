"""Faults that are there on purpose: what finds nothing may be blind. No run of `make fuzz` includes them."""

from __future__ import annotations

from hypothesis import strategies as st
from oracle import Target, attempt, require_finite
from values import evaluate

FAULTS = (
    "1.0",
    "boom(ValueError('x'))",
    "np.float64('nan')",
    "boom(pc.SceneError('it has no path'))",
    "boom(pc.InternalError('x'))",
)
ABORT = "__import__('os').abort()"


def check(source: str) -> int:
    """Evaluate it."""
    require_finite(attempt(lambda: evaluate(source), source), "the result is", source)
    return 1


TARGET = Target(
    "planted",
    st.integers(0, 99).map(lambda number: [*FAULTS, ABORT][min(number // 18, 5)]),
    check,
    share=0.0,
    quick=200,
)
