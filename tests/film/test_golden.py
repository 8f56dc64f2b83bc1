"""A handful of stills look as they did when somebody last looked at them and found them good.

To change them on purpose: `PHYSCORE_GOLDEN=write pytest tests/film/test_golden.py`, look at every picture in
tests/film/golden, and commit those that are better.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

import physcore as pc
from physcore.film import Orbit, Window

GOLDEN = Path(__file__).parent / "golden"
SIZE = (320, 240)
SEEN = 12.0
"""Differences of a blurred picture below this are not seen: about two just noticeable ones of a channel [1/255]."""
RARE = 0.002
"""The share of pixels that may differ by more: an edge that lies elsewhere by less than a pixel."""

Motion = Callable[[np.ndarray, float], np.ndarray]


def moved(scene: pc.Scene, motion: Motion, count: int = 12, fps: float = 30.0) -> Any:
    """A recording in which particles go where a formula says: nothing here depends on an integrator."""
    start = np.concatenate([body.positions for body in scene.bodies])
    times = np.arange(count) / fps
    positions = np.stack([motion(start, time) for time in times])
    channels = {"positions": positions, "velocities": np.gradient(positions, times, axis=0)}
    return SimpleNamespace(scene=scene, times=times, fps=fps, positions=positions, channels=channels)


def swirl(start: np.ndarray, time: float) -> np.ndarray:
    """Everything goes around the z axis, faster within."""
    angle = 2.0 * time / (0.3 + np.linalg.norm(start[:, :2], axis=1))
    cosine, sine = np.cos(angle), np.sin(angle)
    turned = start.copy()
    turned[:, 0], turned[:, 1] = (
        cosine * start[:, 0] - sine * start[:, 1],
        sine * start[:, 0] + cosine * start[:, 1],
    )
    return turned


def billow(start: np.ndarray, time: float) -> np.ndarray:
    """A sheet in the x–z plane moves like a flag."""
    waving = start.copy()
    waving[:, 1] += 0.25 * start[:, 0] * np.sin(6.0 * start[:, 0] - 4.0 * time + start[:, 2])
    return waving


def slosh(start: np.ndarray, time: float) -> np.ndarray:
    """Water leans to one side; what is higher leans more."""
    leaning = start.copy()
    leaning[:, -1] *= 1.0 + 0.4 * np.sin(2.0 * start[:, 0] - 1.0 + 3.0 * time)
    return leaning


def disc(count: int) -> np.ndarray:
    """Points that fill a disc evenly (Vogel's spiral)."""
    index = np.arange(count) + 0.5
    radius, angle = np.sqrt(index / count), index * np.pi * (3.0 - np.sqrt(5.0))
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)


def tilted(count: int) -> np.ndarray:
    """The same disc in space."""
    flat = disc(count)
    return np.column_stack([flat, 0.3 * flat[:, 0]])


def flag() -> pc.Scene:
    return pc.Scene(pc.cloth((25, 17), 1 / 16, 10.0, axes=((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)), pinned="left"))


def checkers() -> np.ndarray:
    row, column = np.indices((32, 48)) // 8
    light = ((row + column) % 2 == 0)[..., np.newaxis]
    return np.where(light, (236, 230, 214), (176, 40, 52)).astype(np.uint8)


def water(dimension: int) -> pc.Scene:
    sides = (1.0, 0.5) if dimension == 2 else (1.0, 0.5, 0.4)
    fluid = pc.Fluid(pc.block((0.0,) * dimension, sides, 0.05), 0.05)
    return pc.Scene(fluid, pc.Box((0.0,) * dimension, (1.0, 0.9) if dimension == 2 else (1.0, 0.5, 0.8)))


PICTURES: dict[str, tuple[Callable[[], Any], dict[str, Any]]] = {
    "galaxy": (
        lambda: moved(pc.Scene(pc.Particles(disc(300)), pc.CentralForce((0.0, 0.0), 1.0, -2.0)), swirl),
        {"style": pc.styles.Points(glow=0.8, trail=0.2), "title": "Glow and trails"},
    ),
    "field": (
        lambda: moved(pc.Scene(pc.Particles(disc(300))), swirl),
        {
            "style": [pc.styles.Paths([3, 40]), pc.styles.Points("body", size=3.0), pc.styles.Arrows(spacing=22.0)],
            "theme": "light",
        },
    ),
    "flag": (
        lambda: moved(flag(), billow),
        {"style": pc.styles.Surface(texture=checkers()), "camera": Orbit(azimuth=-70.0, aperture=0.02)},
    ),
    "strain": (
        lambda: [moved(flag(), billow), moved(flag(), billow, count=6)],
        {"style": [pc.styles.Strain()], "titles": ["late", "early"], "theme": "light", "size": (480, 240)},
    ),
    "water": (
        lambda: moved(water(2), slosh),
        {"style": [pc.styles.Fluid(surface=True), pc.styles.Streamlines()], "camera": Window((-0.1, -0.1), (1.1, 1.0))},
    ),
    "tank": (lambda: moved(water(3), slosh), {"style": pc.styles.Fluid(surface=True)}),
    "grains": (
        lambda: moved(pc.Scene(pc.Particles(tilted(200), radius=0.05), pc.Floor(-0.5)), swirl),
        {"style": pc.styles.Points(color="speed", colormap="viridis")},
    ),
}  # fmt: skip


def blurred(picture: np.ndarray) -> np.ndarray:
    """The mean of each pixel and its eight neighbors."""
    padded = np.pad(picture, ((1, 1), (1, 1), (0, 0)), mode="edge")
    height, width, _ = picture.shape
    return sum(padded[i : i + height, j : j + width] for i in range(3) for j in range(3)) / 9.0


@pytest.mark.parametrize("name", PICTURES)
def test_a_still_looks_as_it_did(name: str, tmp_path: Path) -> None:
    recording, options = PICTURES[name]
    path = tmp_path / f"{name}.png"
    pc.film(recording(), path, sidecar=False, **{"size": SIZE, **options})
    if os.environ.get("PHYSCORE_GOLDEN") == "write":
        GOLDEN.mkdir(exist_ok=True)
        with Image.open(path) as image:
            image.save(GOLDEN / path.name, optimize=True)
    with Image.open(path) as image, Image.open(GOLDEN / path.name) as golden:
        new, old = (np.asarray(each.convert("RGB")).astype(float) for each in (image, golden))
    assert new.shape == old.shape
    apart = np.abs(blurred(new) - blurred(old)).max(axis=2)
    assert (apart > SEEN).mean() < RARE
    assert apart.mean() < 0.5


def test_a_picture_that_looks_different_is_noticed(tmp_path: Path) -> None:
    """The same scene without its glow."""
    recording, options = PICTURES["galaxy"]
    style = pc.styles.Points(trail=0.2)
    pc.film(recording(), tmp_path / "dull.png", **{"size": SIZE, **options, "style": style})
    with Image.open(tmp_path / "dull.png") as image, Image.open(GOLDEN / "galaxy.png") as golden:
        new, old = (np.asarray(each.convert("RGB")).astype(float) for each in (image, golden))
    assert (np.abs(blurred(new) - blurred(old)).max(axis=2) > SEEN).mean() > 10.0 * RARE
