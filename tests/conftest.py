"""How the tests run: with fewer examples by default, all of them in `make test-long`; what they cost, and a report."""

from __future__ import annotations

import os
import platform
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import hypothesis
import pytest

from forks import Forks

os.environ.setdefault("PHYSCORE_TRACEBACKS", "full")
LONG = os.environ.get("PHYSCORE_TESTS") == "long"

hypothesis.settings.register_profile("short", max_examples=12, deadline=None, derandomize=True)
hypothesis.settings.register_profile("long", max_examples=1000, deadline=None)
hypothesis.settings.load_profile("long" if LONG else "short")


@pytest.fixture(scope="session")
def forks() -> Iterator[Forks]:
    """Processes for scripts that end themselves, are killed, or have limits of their own."""
    with closing(Forks()) as forks:
        yield forks


@pytest.fixture(scope="module")
def clock_of_work() -> Iterator[None]:
    """Let studies measure the evaluations of runs in place of seconds: how busy a machine is decides no test."""
    from work import counted

    with counted():
        yield


def _scene(item: pytest.Item) -> str:
    """The scene that a contract is tested on: all contracts of a scene follow each other, and share its plain run."""
    parameters = item.callspec.params if isinstance(item, pytest.Function) and hasattr(item, "callspec") else {}
    return str(parameters.get("name", "")) if "contracts" in item.path.parts else ""


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Put the tests in order, and mark those that `long.txt` names: they take seconds, and others like them remain."""
    items.sort(key=_scene)
    names = set(Path(__file__).with_name("long.txt").read_text(encoding="utf-8").splitlines())
    named = [item for item in items if item.nodeid in names]
    for item in named:
        item.add_marker(pytest.mark.long)
    if not config.args_source.name.startswith("ARGS") and len(named) < len(names):
        raise pytest.UsageError(
            f"tests/long.txt names {sorted(names - {item.nodeid for item in named})}, which are gone"
        )


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--report", type=Path, help="write a dated table of all tests and what they measured")
    parser.addoption("--costs", type=int, help="list the files and tests that took the most processor time, so many")


def pytest_configure(config: pytest.Config) -> None:
    path = config.getoption("--report")
    is_worker = hasattr(config, "workerinput")
    if path is not None and not is_worker:
        config.pluginmanager.register(Report(path), "physcore-report")
    if config.getoption("--costs") is not None or is_worker:
        config.pluginmanager.register(Costs(), "physcore-costs")


COLLECTED = "imports and collection"


class Costs:
    """Sums the processor time of tests and their processes, by file and by test, over all workers."""

    def __init__(self) -> None:
        self.before = self.used()
        self.seconds: Counter[str] = Counter()

    def used(self) -> float:
        """The processor time of this process and of those that it has waited for [s]."""
        return sum(os.times()[:4])

    def pytest_collection_finish(self) -> None:
        self.before = self.seconds[COLLECTED] = self.used()

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        if hasattr(session.config, "workeroutput"):
            session.config.workeroutput[COLLECTED] = self.seconds[COLLECTED]

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        self.seconds[COLLECTED] += getattr(node, "workeroutput", {}).get(COLLECTED, 0.0)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self) -> Iterator[None]:
        report = yield
        now = self.used()
        report.processor_time, self.before = now - self.before, now
        return report

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        for name in {"all tests", report.nodeid.partition("::")[0], report.nodeid}:
            self.seconds[name] += getattr(report, "processor_time", 0.0)  # A worker that dies measures nothing.

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
        count = config.getoption("--costs")
        files = [each for each in self.seconds.most_common() if "::" not in each[0]][: count + 2]
        tests = [each for each in self.seconds.most_common() if "::" in each[0]][:count]
        terminalreporter.section("processor time [s]")
        for name, seconds in [*files, *tests]:
            terminalreporter.write_line(f"{seconds:8.1f}  {name}")


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
