"""What `import physcore` costs, and what it leaves out."""

from __future__ import annotations

import subprocess
import sys
from importlib import import_module

import physcore as pc


def python(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip()


def test_heavy_modules_are_not_imported():
    loaded = python("import physcore, sys; print(*sys.modules)").split()
    for module in ("PIL.Image", "matplotlib", "physcore.gallery", "importlib.metadata", "argparse"):
        assert module not in loaded


def test_few_modules_are_imported_besides_those_of_numpy():
    """Modules of the standard library alone, and few of them; benches/overheads.py has the time."""
    before, after = (set(python(f"import {name}, sys; print(*sys.modules)").split()) for name in ("numpy", "physcore"))
    others = {module.partition(".")[0] for module in after - before} - {"physcore", "numpy"}
    assert others <= sys.stdlib_module_names
    assert len(others) < 40


def test_everything_public_is_there_and_documented():
    for name in pc.__all__:
        assert getattr(pc, name).__doc__, name
    assert callable(pc.film)


def test_the_version_is_that_of_the_package():
    assert pc.__version__.count(".") == 2


def test_integrators_are_importable_under_their_public_name():
    public = import_module("physcore.integrators")
    assert public.INTEGRATORS == import_module("physcore.numerics.integrators").INTEGRATORS
    assert public.PEFRL is pc.PEFRL
