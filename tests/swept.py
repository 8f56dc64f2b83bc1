"""Scenes and measures of sweeps, in a module that other processes can import."""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np

import physcore as pc

GRID = {"stiffness": [50.0, 100.0, -1.0], "dt": [1e-3, 2e-3]}
"""Six points; the rope refuses a negative stiffness."""


def rope(stiffness=100.0, damping=0.01):
    return pc.Scene(pc.rope(6, 1.0, stiffness=stiffness, damping=damping, mass=0.01, pinned="start"), pc.Gravity())


def slow(number, folder):
    """A scene that takes a second to build, and leaves a file when it begins."""
    Path(folder, f"begun-{number}-{os.getpid()}").touch()
    time.sleep(1.0)
    return rope()


def deadly(number):
    """A scene whose building kills its process for the number 1."""
    if number == 1:
        os.kill(os.getpid(), 9)
    return rope(50.0 + number)


def fragile(number):
    if number == 1:
        raise ZeroDivisionError("one is not allowed")
    return "no scene" if number == 2 else rope(50.0 + number)


def sag(recording):
    return float(-recording.positions[-1, :, 1].min())


def several(recording):
    return {"sag": np.float32(sag(recording)), "times": recording.times[:3], "name": ("rope", True, None)}


def failing(recording):
    raise RuntimeError("cannot be measured")
