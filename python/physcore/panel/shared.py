"""A simulation that plays in another thread, for reading."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import wraps
from typing import Any

from physcore.panel.runner import Runner
from physcore.simulation.simulation import Simulation
from physcore.simulation.state import Part


class SharedSimulation:
    """Simulation of a panel. Each access waits for the end of a batch of steps.

    It passes for a `Simulation`: all attributes are those of the present one, which `Panel.reset` replaces.
    """

    def __init__(self, runner: Runner) -> None:
        object.__setattr__(self, "_runner", runner)

    @property  # type: ignore[misc]
    def __class__(self) -> type:
        """Simulation, for `isinstance`."""
        return Simulation

    def __getattr__(self, name: str) -> Any:
        runner: Runner = object.__getattribute__(self, "_runner")
        value = runner.read(lambda session: getattr(session.simulation, name))
        if not callable(value) or isinstance(value, type):
            return value

        @wraps(value)
        def called(*arguments: Any, **keywords: Any) -> Any:
            # The present simulation may be another one than when the method was looked up.
            return runner.ask(lambda session: getattr(session.simulation, name)(*arguments, **keywords))

        return called

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{name} of a simulation cannot be set")

    def __getitem__(self, key: Any) -> Part:
        runner: Runner = object.__getattribute__(self, "_runner")
        part = runner.read(lambda session: session.simulation[key])

        def put(values: Mapping[str, Any]) -> None:
            runner.ask(lambda session: session.simulation[key].set(**values))

        return replace(part, replace=put)

    def __copy__(self) -> Simulation:
        """A simulation that goes on by itself from the present state."""
        runner: Runner = object.__getattribute__(self, "_runner")
        return runner.read(lambda session: session.simulation.__copy__())

    def __repr__(self) -> str:
        runner: Runner = object.__getattribute__(self, "_runner")
        return runner.read(lambda session: repr(session.simulation))
