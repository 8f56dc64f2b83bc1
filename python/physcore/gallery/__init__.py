"""Demos: each is one short file to read as an example. Run one with `physcore demo NAME`.

A demo is a module with a docstring, whose first line is its caption, a function `scene()` that builds it, its
`DURATION`, a function `main(path, progress)` that writes a GIF and gives the recordings it is made of, by title, and a
function `figure(recordings)` that measures in them something whose value is known. To add one: a file here and a line
in `DEMOS`. `physcore gallery` shows them all on a page.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.resources import files
from typing import Protocol, cast

from physcore.gallery.figure import Figure
from physcore.scene.scene import Scene
from physcore.simulation.recording import Recording

DEMOS = (
    "cloth",
    "rope",
    "jelly",
    "orbits",
    "pendulums",
    "galaxy",
    "flag",
    "torn_flag",
    "drape",
    "bowl",
    "landslide",
    "dam_break",
    "dam_break_3d",
    "two_dams",
    "splash",
    "drops",
    "lava",
    "rayleigh_taylor",
    "hourglass",
    "crystal",
    "ripples",
    "double_slit",
    "string",
    "lens",
    "whispering_gallery",
    "tunnelling",
    "electron_slits",
    "harmonic_trap",
    "scattering",
    "labyrinth",
    "spirals",
    "turing",
    "figure_eight",
    "solar_system",
    "trojans",
    "collision",
    "penning_trap",
    "magnetic_bottle",
    "butterfly",
    "vortex_street",
    "dipole",
    "double_pendulum",
    "sixfold_pendulum",
    "chain",
    "falling_chain",
    "curtain",
    "folds",
    "knot",
)
"""Every demo; the first one is the default."""

COSTS = "costs.json"
"""The file with what each demo costs."""


class Demo(Protocol):
    """What a module in this folder has."""

    __doc__: str | None
    DURATION: float
    """[s]"""

    def scene(self) -> Scene:
        """What is simulated."""

    def main(self, path: str | os.PathLike[str], progress: bool | None = None) -> Mapping[str, Recording]:
        """Write a GIF to `path`; give the recordings that it shows, by title."""

    def figure(self, recordings: Mapping[str, Recording]) -> Figure:
        """Something measured in the recordings of `main`, beside what is expected of it."""


def demo(name: str) -> Demo:
    """The module of a demo; only that one is imported.

    Raises:
        KeyError: there is no such demo.
    """
    if name not in DEMOS:
        raise KeyError(name)
    return cast(Demo, import_module(f"{__name__}.{name}"))


@dataclass(frozen=True)
class Cost:
    """What a demo took when it was last measured."""

    seconds: float
    """Processor time [s], which does not depend on what else the machine does."""
    bytes: int
    """The size of its film."""


def costs() -> dict[str, Cost]:
    """The costs of demos, as far as they were measured: `physcore gallery -o DIR` writes them into DIR/costs.json."""
    table = json.loads(files(__name__).joinpath(COSTS).read_text(encoding="utf-8"))
    return {name: Cost(**values) for name, values in table.items()}


def caption(name: str) -> str:
    """One line on what a demo shows."""
    return (demo(name).__doc__ or "").partition("\n")[0]
