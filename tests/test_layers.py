"""The architecture as a test: every module imports only from its left."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "python" / "physcore"

LAYERS = [
    "errors",
    "_core",
    "memory",
    "checks",
    "schema",
    "files",
    "overlaps",
    "periodic",
    "shapes",
    "kernels",
    "bodies",
    "fluid",
    "builders",
    "influence",
    "forces",
    "boundaries",
    "integrators",
    "scene",
    "numerics",
    "energy",
    "state",
    "plan",
    "engine",
    "progress",
    "storage",
    "serial",
    "provenance",
    "pace",
    "sampling",
    "recording",
    "simulation",
    "stability",
    "loading",
    "evidence",
    "formats",
    "film",
    "output",
    "tradeoff",
    "accuracy",
    "audit",
    "benchmark",
    "gallery",
    "__main__",
]

# What has to look to its right, and why.
EXCEPTIONS = {
    ("scene", "serial"),  # when its hash is asked for, and not before
    ("scene", "storage"),  # likewise
    ("errors", "state"),  # for the type checker alone: the type of SimulationDiverged.last_good
    ("recording", "film"),  # when a notebook shows a recording, and not before
}

FILES = sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")


def layer(module: str) -> str:
    """The layer of `physcore.forces.drag` is "forces"; of `physcore` itself "" (the public face)."""
    return module.split(".")[1] if "." in module else ""


def imports(path: Path) -> set[str]:
    """The modules of this package that a file imports."""
    modules: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            modules |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module == "physcore":
            modules |= {f"physcore.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            modules.add(node.module)
    return {module for module in modules if module.split(".")[0] == "physcore"}


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_go_left_only(path):
    own = path.relative_to(PACKAGE).with_suffix("").parts[0]
    position = LAYERS.index(own)
    for module in imports(path):
        other = layer(module)
        if other == "" and own in ("gallery", "__main__"):
            continue  # What stands at the end imports the public face, as a user does.
        assert other in LAYERS, f"{path.name} imports {module}, which is in no layer"
        if (own, other) not in EXCEPTIONS:
            assert LAYERS.index(other) <= position, f"{own} imports {module}, which is to its right"


def test_every_layer_exists():
    rooms = {path.relative_to(PACKAGE).with_suffix("").parts[0] for path in FILES} | {"_core"}
    assert rooms == set(LAYERS)
