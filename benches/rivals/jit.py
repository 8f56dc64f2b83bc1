"""Numba, with types."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from math import nan
from typing import Any, TypeVar

# Threads of GNU OpenMP that wait for work by spinning take the processor from those that have some, ours and theirs.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")

import numpy as np
from measure import Contender, fastest
from numpy.typing import NDArray

from rivals import optional

numba = optional("numba")
prange = numba.prange if numba else range
FASTMATH = {"strict": False, "fastmath": True} if numba else {}
"""Versions of whatever Numba compiles; none where it cannot be imported."""
Function = TypeVar("Function", bound=Callable[..., Any])
Step = Callable[[int], object]


def jit(fastmath: bool, parallel: bool = False) -> Callable[[Function], Function]:
    """Compile a function to machine code when it is first called."""
    decorator: Any = numba.njit(fastmath=fastmath, parallel=parallel, error_model="numpy", nogil=True)

    def compile_lazily(function: Function) -> Function:
        compiled: Function = decorator(function)
        return compiled

    return compile_lazily


def with_threads(threads: int, step: Step) -> Step:
    """A step that runs on so many threads."""

    def run(steps: int) -> None:
        numba.set_num_threads(threads)
        step(steps)

    return run


def numba_best(build: Callable[[Any], Step], versions: Mapping[str, tuple[Any, int]], threads: int = 1) -> Contender:
    """The fastest version on so many threads; each has what it is built from, and the steps that it takes at once."""
    variants = [
        Contender(f"Numba, {name}", with_threads(threads, build(make)), threads, multiple)
        for name, (make, multiple) in versions.items()
    ]
    return fastest(variants) if variants else Contender("Numba", None, threads)


def clock() -> float:
    """The frequency of the processor [GHz], about: a chain of multiplications, 4 cycles for each link on x86-64."""
    if not numba:
        return nan

    @jit(fastmath=False)
    def chain(links: int, seed: int) -> int:
        for link in range(links):
            seed = (seed * 6364136223846793005) ^ link
        return seed

    chain(1, 1)
    best = float("inf")
    for _ in range(5):
        start = time.process_time()
        chain(20_000_000, 1)
        best = min(best, time.process_time() - start)
    return 4 * 20_000_000 / best / 1e9


def columns(vectors: NDArray[np.float64], dtype: type) -> list[NDArray[Any]]:
    """One contiguous array per component."""
    return [np.ascontiguousarray(component, dtype=dtype) for component in vectors.T]
