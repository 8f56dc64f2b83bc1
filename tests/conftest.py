"""How the tests run: with fewer examples by default, with the full number in `make test-long`, and a report."""

from __future__ import annotations

import functools
import math
import os
import platform
from datetime import UTC, datetime
from pathlib import Path

import hypothesis
import pytest

LONG = os.environ.get("PHYSCORE_TESTS") == "long"

hypothesis.settings.register_profile("short", max_examples=12, deadline=None, derandomize=True)
hypothesis.settings.register_profile("long", max_examples=1000, deadline=None)
hypothesis.settings.load_profile("long" if LONG else "short")


CALL, STEP, PARTICLE = 2e-5, 3e-7, 1e-8
"""What a call, an evaluation of the forces, and that of one particle or cell take by the clock of tests [s]."""


@pytest.fixture(autouse=True)
def clock_of_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Studies measure the evaluations of a run in place of its seconds: how busy a machine is decides no test."""
    from physcore import Simulation
    from physcore.studies import clock

    now, within = 0.0, False

    def counted(function):
        def wrapped(self, *arguments, **options):
            nonlocal now, within
            if within:
                return function(self, *arguments, **options)
            within, before = True, self.steps
            try:
                return function(self, *arguments, **options)
            finally:
                within = False
                cells = sum(math.prod(getattr(system, "grid").cells) for system in self.scene.systems if hasattr(system, "grid"))
                size = self.scene.particles + cells
                now += CALL + (self.steps - before) * self.evaluations * (STEP + PARTICLE * size)

        return functools.wraps(function)(wrapped)

    for name in ("step", "run", "record"):
        monkeypatch.setattr(Simulation, name, counted(getattr(Simulation, name)))

    def seconds() -> float:
        nonlocal now
        now += CALL
        return now

    monkeypatch.setattr(clock, "seconds", seconds)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--report", type=Path, help="write a dated table of all tests and what they measured")


def pytest_configure(config: pytest.Config) -> None:
    path = config.getoption("--report")
    is_worker = hasattr(config, "workerinput")
    if path is not None and not is_worker:
        config.pluginmanager.register(Report(path), "physcore-report")


class Report:
    """Collects outcomes, and what tests say with `record_property`, into a Markdown table."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.rows: list[str] = []

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when == "call" or (report.when == "setup" and report.outcome != "passed"):
            measured = ", ".join(f"{name}: {value}" for name, value in report.user_properties)
            name = report.nodeid.removeprefix("tests/")
            self.rows.append(f"| `{name}` | {report.outcome} | {measured} | {report.duration:.1f} |")

    def pytest_sessionfinish(self) -> None:
        import numpy as np

        import physcore

        day = datetime.now(UTC).strftime("%Y-%m-%d")
        head = [
            f"# {self.path.stem}, {day}",
            "",
            f"physcore {physcore.__version__}, NumPy {np.__version__}, Python {platform.python_version()}, "
            f"{platform.machine()}, {platform.system()}. Written by the tests; do not edit.",
            "",
            "| test | outcome | measured | seconds |",
            "|---|---|---|---|",
        ]
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.write_text("\n".join([*head, *sorted(self.rows)]) + "\n", encoding="utf-8")
