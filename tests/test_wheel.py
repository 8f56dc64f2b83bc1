"""The wheel: it is installed into an empty environment without a compiler, where README's script runs."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def wheel() -> Path:
    """The wheel in the folder PHYSCORE_WHEEL; or the last one of `make wheels` and `make install`."""
    given = os.environ.get("PHYSCORE_WHEEL")
    folders = [ROOT / "dist/wheels", ROOT / "dist"] if given is None else [Path(given)]
    found = [path for folder in folders for path in folder.glob("physcore-*.whl")]
    if not found:
        pytest.skip("there is no wheel: make wheels, or make install")
    return max(found, key=lambda path: path.stat().st_mtime).resolve()


def python(environment: Path) -> Path:
    return environment / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


@pytest.fixture(scope="module")
def environment(wheel, tmp_path_factory) -> Path:
    """A new environment with the wheel and what it depends on, as wheels: nothing can be compiled."""
    path = tmp_path_factory.mktemp("empty") / "environment"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", path], check=True)
    pip = [sys.executable, "-m", "pip", "--python", python(path), "--quiet", "--disable-pip-version-check"]
    command = [*pip, "install", "--only-binary=:all:", "--no-compile", wheel]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if "No matching distribution found for" in done.stderr and "physcore" not in done.stderr.rpartition("found for")[2]:
        pytest.skip(f"no packages can be installed here: {done.stderr.strip().splitlines()[-1]}")
    assert done.returncode == 0, done.stderr
    return path


def run(environment: Path, folder: Path, *arguments: str) -> str:
    """What Python prints, without anything of this process but the folders that a system needs."""
    kept = {name: os.environ[name] for name in ("SYSTEMROOT", "TEMP", "TMP") if name in os.environ}
    variables = {**kept, "PATH": str(python(environment).parent)}
    done = subprocess.run(
        [python(environment), *arguments], cwd=folder, env=variables, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_script_of_the_readme_runs(environment, tmp_path):
    (script,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), flags=re.DOTALL)
    (tmp_path / "script.py").write_text(script, encoding="utf-8")
    printed = run(environment, tmp_path, "-X", "utf8", "script.py")
    assert printed.startswith("Plan")
    assert "balance" in printed
    assert (tmp_path / "cloth.gif").read_bytes().startswith(b"GIF89a")


def test_the_command_line_is_installed(environment, tmp_path):
    assert "cloth" in run(environment, tmp_path, "-m", "physcore", "list")
    assert (python(environment).parent / ("physcore.exe" if os.name == "nt" else "physcore")).exists()


def test_the_wheel_has_licenses_types_and_nothing_of_the_tests(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    licenses = ("LICENSE-MIT", "LICENSE-APACHE", "OFL.txt")
    for ending in (*licenses, "physcore/py.typed", "physcore/_core.pyi", "fonts/droid-sans-fallback.ttf"):
        assert any(name.endswith(ending) for name in names), ending
    assert all(name.startswith(("physcore/", "physcore-")) for name in names)


def test_one_wheel_serves_all_versions_of_python(wheel):
    """It is for the stable interface of Python 3.11; `make wheels` builds it for C libraries since 2014."""
    assert "-cp311-abi3-" in wheel.name
    if wheel.parent.name == "wheels" and sys.platform == "linux":
        assert "manylinux2014" in wheel.name
