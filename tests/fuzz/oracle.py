"""What counts as a fault: anything but a result or one of the errors that physcore raises on purpose."""

from __future__ import annotations

import re
import signal
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Any

import numpy as np
from hypothesis.strategies import SearchStrategy
from values import parts

import physcore as pc

PATH = re.compile(r"[^\W\d]\w*(\.\w+|\[[^\]]*\])*: ", re.DOTALL)
"""How the message of an error starts: with the path of a parameter."""

SIGNATURE = re.compile(r"unexpected keyword argument|missing \d+ required|takes .* positional|multiple values for")
"""What Python says of a call with the wrong arguments."""


@dataclass(frozen=True)
class Target:
    """One kind of entrance."""

    name: str
    examples: SearchStrategy[Any]
    """Cheap to draw; what `check` needs to know, and what the report prints."""
    check: Callable[[Any], int]
    """Makes the calls of an example, and gives how many; raises Fault."""
    share: float
    """Of all calls of a long run."""
    quick: int
    """Examples of a quick run."""
    prepare: Callable[[], None] = lambda: None
    """Called once, in an empty folder."""


class Fault(Exception):
    """What was found: `kind` is the same for the same fault, `script` shows it."""

    def __init__(self, kind: str, script: str) -> None:
        super().__init__(f"{kind}\n    {script}")
        self.kind = kind
        self.script = script


class Late(BaseException):
    """A call took its time; no Exception, so that nobody catches it on the way."""


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raises Late in a block that takes longer, in processor time: other work on the machine does not count [s]."""

    def ring(number: int, frame: FrameType | None) -> None:
        raise Late

    previous = signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, previous)


def attempt(
    call: Callable[[], Any],
    script: str,
    *,
    seconds: float = 2.0,
    long: bool = False,
    allowed: tuple[type[BaseException], ...] = (),
    misused: bool = False,
) -> Any:
    """The result of a call; None where it is refused as it should be.

    Args:
        call: what to call.
        script: the same as a text.
        seconds: the processor time after which it is stopped [s].
        long: whether that is what it was asked for, and no fault.
        allowed: what else it may raise.
        misused: whether it is called with the wrong arguments: Python says so by a TypeError.

    Raises:
        Fault: it raises anything else, or the message does not begin with the path of a parameter.
    """
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"), limited(seconds):
            warnings.simplefilter("ignore")
            return call()
    except Late:
        if not long:
            raise Fault(f"takes longer than {seconds:g} s", script) from None
    except pc.InternalError as error:
        raise Fault(f"InternalError: {_general(error)}", script) from error
    except (pc.SimulationDiverged, pc.FileError, *allowed):
        pass
    except pc.PhyscoreError as error:
        if PATH.match(str(error)) is None and "this simulation is running" not in str(error):
            raise Fault(f"no path: {_general(error)}", script) from error
    except BaseException as error:
        if isinstance(error, (KeyboardInterrupt, Fault)):
            raise
        if not (misused and isinstance(error, TypeError) and SIGNATURE.search(str(error))):
            where, message = _place(error), str(error).partition("\n")[0][:200]
            raise Fault(f"{type(error).__name__} at {where}", f"{script}  # {message}") from error
    return None


def require_finite(value: object, what: str, script: str) -> None:
    """No NaN, and in arrays no infinity either.

    Raises:
        Fault: there is one.
    """
    for values in parts(value):
        if np.isnan(values).any() or (values.ndim > 0 and not np.isfinite(values).all()):
            raise Fault(f"{what} not finite", script)


def require(holds: bool, what: str, script: str) -> None:
    """Raises Fault where something does not hold."""
    if not holds:
        raise Fault(what, script)


def _place(error: BaseException) -> str:
    """The innermost line of physcore that an exception went through."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if "/physcore/" in frame.filename]
    if not frames:
        return "the call"
    return f"{frames[-1].filename.rpartition('/physcore/')[2]}:{frames[-1].lineno}"


def _general(error: BaseException) -> str:
    """A message without what differs from one example to the next."""
    text = re.sub(r"0x[0-9a-f]+|[-+]?\d[\d.,]*(e[-+]?\d+)?", "#", str(error).partition("\n")[0])
    text = re.sub(r"'[^']*'|\"[^\"]*\"", "'…'", text)
    return text[:160]
