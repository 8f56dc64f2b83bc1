"""Examples run: the one in the docstring of every top-level name, and the scripts of `examples/`."""

from __future__ import annotations

import inspect
import math
import re
import textwrap
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import physcore as pc


def example(text: str) -> str:
    """The first indented block of a docstring, before its sections (Args:, Raises: …)."""
    head = re.split(r"^[A-Z][\w ]*:\n(?=    )", inspect.cleandoc(text), maxsplit=1, flags=re.MULTILINE)[0]
    found = re.search(r"^\n((?:    .*\n)+)", f"{head}\n", flags=re.MULTILINE)
    return textwrap.dedent(found[1]) if found else ""


PACKAGES = {"Atoms": "ase", "read": "trimesh"}
"""Packages that read the files of an example."""


def write_files(folder: Path) -> None:
    """Write the files that examples read: a solid, a crystal, a table and a picture."""
    corners = np.array([(0, 0, 0), (20, 0, 0), (0, 20, 0), (0, 0, 20)])
    solid = ["solid bunny"]
    for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
        vertices = [f"vertex {x} {y} {z}" for x, y, z in corners[list(face)]]
        solid += ["facet normal 0 0 0", "outer loop", *vertices, "endloop", "endfacet"]
    (folder / "bunny.stl").write_text("\n".join([*solid, "endsolid bunny"]) + "\n")
    cells = np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3)
    atoms = 5.26 * (cells + np.array([(0, 0, 0), (0, 0.5, 0.5), (0.5, 0, 0.5), (0.5, 0.5, 0)])).reshape(-1, 3)
    heading = 'Lattice="21.04 0 0 0 21.04 0 0 0 21.04" Properties=species:S:1:pos:R:3 pbc="T T T"'
    rows = [f"Ar {x} {y} {z}" for x, y, z in atoms]
    (folder / "argon.xyz").write_text("\n".join([str(len(atoms)), heading, *rows]) + "\n")
    (folder / "stars.csv").write_text("x [AU],y [AU],mass [M☉],name\n0,0,1,Sun\n1,0,3e-6,Earth\n", encoding="utf-8")
    Image.fromarray(np.tile(np.arange(64, dtype=np.uint8) * 4, (48, 1))).save(folder / "island.png")


@pytest.fixture(scope="module")
def recorded():
    """A cloth, its scene and its recording, none of which can be changed."""
    cloth = pc.cloth((5, 4), 0.1, 100.0, damping=0.02, mass=0.01, pinned="top corners", name="cloth")
    scene = pc.Scene(cloth, pc.Gravity())
    return {"cloth": cloth, "scene": scene, "recording": pc.simulate(scene, duration=0.2)}


@pytest.fixture
def names(tmp_path, monkeypatch, recorded):
    """What examples may use without building it."""
    monkeypatch.chdir(tmp_path)
    write_files(tmp_path)
    return {"pc": pc, "np": np, "math": math, "rng": np.random.default_rng(1), **recorded}


@pytest.mark.filterwarnings("ignore::UserWarning")  # Some show what is warned of.
@pytest.mark.parametrize("name", pc.__all__)
def test_the_example_of_a_name_runs(name, names):
    if name in PACKAGES:
        pytest.importorskip(PACKAGES[name])
    text = example(getattr(pc, name).__doc__)
    assert f"{name}" in text, text
    exec(compile(text, name, "exec"), names)


def test_the_help_of_a_fluid_starts_with_five_lines_and_what_to_change():
    lines = inspect.cleandoc(pc.Fluid.__doc__).splitlines()
    assert len([line for line in lines[2:8] if line.startswith("    ")]) == 5
    assert lines[8].startswith("Change these three first: ")


SCRIPTS = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))
SHORTER = 0.05
"""The part of its duration for which a script simulates."""


def test_there_are_ten_scripts_or_more():
    assert len(SCRIPTS) >= 10


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_a_script_runs_without_a_warning(script, tmp_path, monkeypatch, clock_of_work):
    simulate, tradeoff = pc.simulate, pc.tradeoff
    monkeypatch.setattr(
        pc, "simulate", lambda scene, duration, **options: simulate(scene, SHORTER * duration, **options)
    )
    monkeypatch.setattr(pc, "tradeoff", lambda scene, duration, budget: tradeoff(scene, duration, budget=0.2 * budget))
    monkeypatch.chdir(tmp_path)
    exec(compile(script.read_text(encoding="utf-8"), script.name, "exec"), {"__name__": "__main__"})
    films = [path for path in tmp_path.iterdir() if path.stem == script.stem]
    assert len(films) == script.read_text(encoding="utf-8").count("pc.film(")
