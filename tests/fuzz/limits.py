"""Fuzzing of limits: heavy scenes that are short of memory, or interrupted within a step, in processes of their own."""

from __future__ import annotations

import os
import resource
import signal
import sys
import traceback
from contextlib import suppress
from pathlib import Path
from types import FrameType

import numpy as np
from hypothesis import strategies as st
from oracle import Fault, Target

import physcore as pc

sys.path.append(str(Path(__file__).parents[1]))
from heavy import HEAVY

Example = tuple[str, str, float]
"""A heavy scene, the limit, and its size: available memory or processor time, from 0 to 1."""

EXAMPLES = st.tuples(st.sampled_from(sorted(HEAVY)), st.sampled_from(["memory", "time"]), st.floats(0.01, 1.0))
MEMORY = 150e6
"""Largest memory that is left to a scene [bytes]."""
TIME = 0.3
"""Longest processor time before an interrupt [s]."""


def check(example: Example) -> int:
    """Run a scene in a child process, which has started no thread before; it ends by itself, and finds nothing."""
    name, limit, size = example
    scene, numerics = HEAVY[name]
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            (_short_of_memory if limit == "memory" else _interrupted)(scene, numerics, size)
        except BaseException:
            os.write(writer, traceback.format_exc().encode()[-4000:])
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as found:
        said = found.read()
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    script = f"{limit} limit {size:.3g} of\n    pc.Simulation({scene}, {numerics}).step(3)"
    if status != 0:
        raise Fault(f"ends the process ({status})", script)
    if said:
        raise Fault(said.strip().rpartition("\n")[2], f"{script}\n{said}")
    return 3


def _started(scene: str, numerics: str) -> pc.Simulation:
    names = {"pc": pc, "np": np, "random": np.random.default_rng(1)}
    simulation: pc.Simulation = eval(f"pc.Simulation({scene}, {numerics})", names)
    return simulation


def _short_of_memory(scene: str, numerics: str, size: float) -> None:
    """An error of physcore, or Python's own, and no abort."""
    limit = _address_space() + int(size * MEMORY)
    resource.setrlimit(resource.RLIMIT_AS, (limit, resource.getrlimit(resource.RLIMIT_AS)[1]))
    with suppress(pc.PhyscoreError, MemoryError):
        _started(scene, numerics).step(3)


def _address_space() -> int:
    """The address space of this process [bytes]."""
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * os.sysconf("SC_PAGE_SIZE")


def _interrupted(scene: str, numerics: str, size: float) -> None:
    """After an interrupt the state is that of a whole step, and the run goes on with the same bits."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    run, plain = _started(scene, numerics), _started(scene, numerics)
    signal.signal(signal.SIGPROF, interrupt)
    signal.setitimer(signal.ITIMER_PROF, size * TIME)
    with suppress(KeyboardInterrupt):
        run.step(1000)
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    plain.step(run.steps)
    assert plain.state_hash() == run.state_hash(), "other bits after an interrupt"
    run.step()
    plain.step()
    assert plain.state_hash() == run.state_hash(), "other bits a step after an interrupt"


TARGET = Target("limits", EXAMPLES, check, share=0.02, quick=4)
