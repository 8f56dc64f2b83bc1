"""The intact springs and faces of a body that tears."""

from __future__ import annotations

from typing import cast

import numpy as np

from physcore.checks import BoolArray, IntArray
from physcore.film.styles.base import Part
from physcore.scene.bodies import SpringNetwork
from physcore.scene.scene import Scene
from physcore.simulation.sources import Source, SourceFrame

BROKEN = "broken"
"""The field of broken springs."""


def has_tears(source: Source, parts: list[Part]) -> bool:
    """Whether springs of these bodies may break in a film."""
    return source.has(BROKEN) and any(BROKEN in part.body.quantities for part in parts)


def intact(frame: SourceFrame, springs: IntArray) -> BoolArray:
    """Mask (M,) of the unbroken ones among springs, given as indices in the scene; -1 stands for no spring."""
    whole: BoolArray = (frame.fields[BROKEN][springs] == 0.0) | (springs < 0)
    return whole


def sides(scene: Scene, parts: list[Part]) -> IntArray:
    """The springs along the three sides of each face of these bodies (T, 3), as indices in the scene; -1: no spring."""
    found = []
    for part in parts:
        body = cast("SpringNetwork", part.body)  # the style has checked this
        count = len(body)
        keys = np.sort(body.pairs, axis=1) @ [count, 1]
        order = np.argsort(keys, kind="stable")
        wanted = np.sort(body.faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2) @ [count, 1]
        at = np.minimum(np.searchsorted(keys[order], wanted), max(len(keys) - 1, 0))
        exists = keys[order][at] == wanted if len(keys) else np.zeros(wanted.shape, dtype=np.bool_)
        springs = order[at] if len(keys) else np.zeros(wanted.shape, dtype=np.int64)
        found.append(np.where(exists, springs + scene.first_spring(body), -1))
    return np.concatenate(found)
