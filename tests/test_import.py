"""What `import physcore` costs, and what it leaves out."""

from __future__ import annotations

import subprocess
import sys

import physcore as pc


def python(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip()


def test_heavy_modules_are_not_imported():
    loaded = python("import physcore, sys; print(*sys.modules)").split()
    for module in ("PIL.Image", "matplotlib", "physcore.gallery", "importlib.metadata", "argparse"):
        assert module not in loaded


def test_the_import_takes_at_most_150_ms_beyond_numpy():
    # Time on the processor, and the least of several: the first one may compile, and others may share the machine.
    code = "import time, numpy; t = time.process_time(); import physcore; print(time.process_time() - t)"
    assert min(float(python(code)) for _ in range(5)) < 0.15


def test_everything_public_is_there_and_documented():
    for name in pc.__all__:
        assert getattr(pc, name).__doc__, name
    assert callable(pc.film)


def test_the_version_is_that_of_the_package():
    assert pc.__version__.count(".") == 2
