"""Recordings of rigid bodies that are where a test says, and pictures of them."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

import physcore as pc
from physcore.film import DARK, Orbit, Window
from physcore.film.film_renderer import FilmRenderer
from physcore.simulation.sources import Recorded

SIZE = (200, 160)
CENTERED = Window((-1.0, -0.8), (1.0, 0.8))
"""A window of 100 pixels per meter, with the origin in the middle of the picture."""
ABOVE = Orbit(elevation=90.0, azimuth=-90.0, field_of_view=0.0, target=(0.0, 0.0, 0.0), extent=1.6)
"""A camera that looks down, at 100 pixels per meter, with x to the right and y upward."""
WHITE, BLACK = (255, 255, 255), (0, 0, 0)


def recorded(scene: pc.Scene, fields: Sequence[dict[str, Any]] = ({},), fps: float = 10.0) -> Any:
    """A recording in which rigid bodies are where a test says; without that as at the start."""
    rigid = [body for body in scene.bodies if body.is_rigid]
    turns = "angles" if scene.dimension == 2 else "orientations"
    start: dict[str, Any] = {
        "positions": scene.gather("positions"),
        "velocities": scene.gather("velocities"),
        "rigid_positions": np.concatenate([body.positions for body in rigid]),
        "rigid_velocities": np.concatenate([body.velocities for body in rigid]),
        turns: np.concatenate([getattr(body, turns) for body in rigid]),
        "joint_forces": np.zeros((scene.count("joints"), scene.dimension)),
    }
    channels = {
        name: np.stack([np.asarray(frame.get(name, values), dtype=float) for frame in fields])
        for name, values in start.items()
    }
    times = np.arange(len(fields)) / fps
    return SimpleNamespace(scene=scene, times=times, fps=fps, positions=channels["positions"], channels=channels)


def films(
    recording: Any, style: Any = None, camera: Any = None, theme: Any = DARK, size: Any = SIZE, **options: Any
) -> list[np.ndarray]:
    """All frames of a film as pictures (H, W, 3)."""
    options = {"labels": (), "color_bar": False, **options}
    with FilmRenderer([Recorded(recording)], size, style, camera, theme, None, False, **options) as film:
        return [canvas.pixels().astype(float) for canvas in film.frames()]


def picture(scene: pc.Scene, camera: Any = CENTERED, **options: Any) -> np.ndarray:
    """The picture of a scene at the start."""
    return films(recorded(scene), camera=camera, **options)[0]


def at(shot: np.ndarray, x: float, y: float) -> np.ndarray:
    """The color at a point of the plane, in a picture with 100 pixels per meter about the origin."""
    return shot[round(80 - 100 * y), round(100 + 100 * x)]


def covered(shot: np.ndarray, background: tuple[int, int, int] = DARK.background) -> np.ndarray:
    """Whether each pixel differs from the background."""
    return (shot != np.array(background)).any(axis=2)
