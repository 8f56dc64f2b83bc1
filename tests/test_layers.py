"""The architecture as a test: folders import from their left alone, modules never in a circle."""

from __future__ import annotations

import ast
import subprocess
import sys
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "python" / "physcore"

LAYERS = [
    "errors",
    "spelling",
    "entrance",
    "_core",
    "memory",
    "units",
    "checks",
    "arithmetic",
    "progress",
    "markup",
    "storage",
    "scene",
    "forces",
    "boundaries",
    "constraints",
    "systems",
    "files",
    "numerics",
    "simulation",
    "film",
    "output",
    "studies",
    "panel",
    "gallery",
    "__main__",
]

KINDS = 22
"""Largest number of tests on kinds of scene items, such as `isinstance(item, Fluid)`, in the package."""

ALIASES = {"integrators"}
"""Modules that give what is elsewhere under a public name; the package itself does not use them."""

FILES = {
    ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__"): path
    for path in sorted(PACKAGE.rglob("*.py"))
}
"""All modules by name."""


def layer(module: str) -> str:
    """The layer of `physcore.forces.drag` is "forces"; of `physcore` itself "" (the public face)."""
    return module.split(".")[1] if "." in module else ""


@cache
def imports(path: Path) -> set[str]:
    """The modules of this package that a file imports anywhere: at its head, in functions, for the type checker."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names if layer(alias.name) or alias.name == "physcore"}
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "physcore":
            assert node.module is not None
            inner = {f"{node.module}.{alias.name}" for alias in node.names}
            modules = {name for name in inner if name in FILES or name == "physcore._core"}
            found |= modules if len(modules) == len(inner) else {*modules, node.module}
    return {name for name in found if name.split(".")[0] == "physcore"}


@pytest.mark.parametrize("name", [name for name in FILES if layer(name) not in ("", *ALIASES)])
def test_imports_go_left_only(name):
    own = layer(name)
    for module in imports(FILES[name]):
        other = layer(module)
        if other == "" and own in ("gallery", "__main__"):
            continue  # What stands at the end imports the public face, as a user does.
        assert other in LAYERS, f"{name} imports {module}, which is in no layer"
        assert LAYERS.index(other) <= LAYERS.index(own), f"{name} imports {module}, which is to its right"


def test_every_layer_exists():
    assert {layer(name) for name in FILES if layer(name)} | {"_core"} == {*LAYERS, *ALIASES}


def test_items_answer_for_themselves():
    """Only what users give is tested for its kind; the script lists these tests."""
    script = PACKAGE.parents[1] / "scripts" / "kinds-of-items"
    found = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True).stdout
    assert int(found.split()[-1]) <= KINDS, found


def test_no_module_imports_itself_through_others():
    graph = {name: imports(path) for name, path in FILES.items()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"circular imports: {' → '.join(reversed(error.args[1]))}")
