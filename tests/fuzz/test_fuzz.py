"""A short fuzzing of every entrance, the faults that it must see, and the edge values of every argument."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
TARGETS = sorted(
    path.stem
    for path in HERE.glob("*.py")
    if path.stem != "planted" and "\nTARGET = " in path.read_text(encoding="utf-8")
)


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, timeout=3600, check=False)


def test_nothing_is_found():
    """In one process for all targets, which has to import them, and one for each of them."""
    outcome = run(str(HERE), "--quick", "--processes", "1")
    assert outcome.returncode == 0, outcome.stdout + outcome.stderr


def test_every_kind_of_fault_is_found():
    outcome = run(str(HERE), "--quick", "planted")
    assert outcome.returncode == 1, outcome.stderr
    kinds = ("ValueError at", "the result is not finite", "no path", "InternalError", "ends the process (-6)")
    assert [kind for kind in kinds if kind not in outcome.stdout] == []


def test_every_target_is_in_a_long_run():
    (names,) = (
        ast.literal_eval(node.value)
        for node in ast.parse((HERE / "__main__.py").read_text(encoding="utf-8")).body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "TARGETS"
    )
    assert sorted(names) == TARGETS


def test_edge_values_are_accepted_or_refused_by_an_error_of_physcore():
    outcome = run(str(HERE / "edges.py"), "--check")
    assert outcome.returncode == 0, outcome.stdout + outcome.stderr
