"""Demos: short modules that serve as examples. Run one with `physcore demo NAME`.

Each demo is a module with the following contents:

- a docstring, whose first line is the caption;
- `scene()`, which builds the scene;
- `DURATION`, the simulated time;
- `main(path, progress)`, which writes a GIF with a title and a line below it, and returns its recordings by title;
- `figure(recordings)`, which measures a quantity whose value is known.

To add a demo: a module here, a line in `DEMOS`, and its name on the page of its law in docs/eighteen.

`physcore gallery` shows all demos on a page.
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
    "bowl",
    "pendulums",
    "brachistochrone",
    "cradle",
    "dominoes",
    "wrecking_ball",
    "galton",
    "letters",
    "bridge",
    "gyroscope",
    "dzhanibekov",
    "double_pendulum",
    "sixfold_pendulum",
    "butterfly",
    "chain",
    "falling_chain",
    "rope",
    "knot",
    "cloth",
    "flag",
    "torn_flag",
    "drape",
    "curtain",
    "folds",
    "jelly",
    "orbits",
    "solar_system",
    "trojans",
    "figure_eight",
    "galaxy",
    "collision",
    "penning_trap",
    "magnetic_bottle",
    "dipole",
    "crystal",
    "hourglass",
    "landslide",
    "dam_break",
    "dam_break_3d",
    "two_dams",
    "splash",
    "drops",
    "lava",
    "rayleigh_taylor",
    "floating_box",
    "water_wheel",
    "vortex_street",
    "string",
    "ripples",
    "lens",
    "whispering_gallery",
    "double_slit",
    "turing",
    "spirals",
    "labyrinth",
    "tunnelling",
    "electron_slits",
    "harmonic_trap",
    "scattering",
)
"""All demos, in the order of the eighteen films of the site, from a ball to a wave function."""
DEFAULT = "cloth"
"""The demo that is shown if no other is asked for."""

COSTS = "costs.json"
"""File with the measured cost of each demo."""


class Demo(Protocol):
    """Interface of the demo modules."""

    __doc__: str | None
    DURATION: float
    """Simulated time [s]."""

    def scene(self) -> Scene:
        """Build the scene."""

    def main(self, path: str | os.PathLike[str], progress: bool | None = None) -> Mapping[str, Recording]:
        """Write a GIF to `path` and return the recordings that it shows, by title."""

    def figure(self, recordings: Mapping[str, Recording]) -> Figure:
        """A quantity measured in the recordings of `main`, with its expected value."""


def demo(name: str) -> Demo:
    """Import and return the module of a demo.

    Raises:
        KeyError: there is no such demo.
    """
    if name not in DEMOS:
        raise KeyError(name)
    return cast(Demo, import_module(f"{__name__}.{name}"))


@dataclass(frozen=True)
class Cost:
    """Measured cost of a demo."""

    seconds: float
    """Processor time [s], which does not depend on the load of the machine."""
    bytes: int
    """Size of the film [bytes]."""


def costs() -> dict[str, Cost]:
    """The measured costs of demos. `physcore gallery -o DIR` writes them into DIR/costs.json."""
    table = json.loads(files(__name__).joinpath(COSTS).read_text(encoding="utf-8"))
    return {name: Cost(**values) for name, values in table.items()}


def caption(name: str) -> str:
    """The caption of a demo: one line."""
    return (demo(name).__doc__ or "").partition("\n")[0]
