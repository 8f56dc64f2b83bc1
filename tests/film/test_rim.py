"""The rim of a cloth with a thickness."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import physcore as pc
from physcore.film import DARK, Orbit

CLOTH = pc.cloth((11, 11), 0.1, 10.0, origin=(0.0, 0.0, 0.0), axes=((1, 0, 0), (0, 1, 0)))


def inked(path: Path, *items: Any, **style: Any) -> np.ndarray:
    """How many rows of each column of a picture are inked: a level cloth, seen from its side."""
    recording = pc.simulate(pc.Scene(CLOTH, *items), 0.01, fps=100, dt=0.01, progress=False)
    camera = Orbit(azimuth=-90.0, elevation=0.0, target=(0.5, 0.5, 0.0), extent=1.2)
    pc.film(
        recording,
        path,
        size=(200, 150),
        style=pc.styles.Surface("white", **style),
        camera=camera,
        labels=(),
        background=DARK.background,
    )
    with Image.open(path) as image:
        return (np.abs(np.asarray(image.convert("RGB")).astype(float) - np.array(DARK.background)) > 20).any(2).sum(0)


def test_a_rim_is_as_wide_as_the_cloth_is_thick(tmp_path):
    """Edge-on a cloth has no area; its rim nearest to the eye is in the scale of the target to a tenth, half a side of
    the cloth off, and its edges are uncertain by a pixel each.
    """
    columns = inked(tmp_path / "thick.png", thickness=0.1)
    across = columns[100]
    along = np.count_nonzero(columns)
    assert across == pytest.approx(0.1 * along, rel=0.1, abs=2)
    assert inked(tmp_path / "thin.png")[100] <= 2


def test_the_thickness_is_that_of_self_contact_unless_it_is_given(tmp_path):
    contact = pc.SelfContact(CLOTH, thickness=0.08)
    of_contact = inked(tmp_path / "contact.png", contact)
    np.testing.assert_array_equal(of_contact, inked(tmp_path / "given.png", thickness=0.08))
    assert inked(tmp_path / "none.png", contact, thickness=0.0)[100] <= 2


def test_a_thickness_below_zero_is_refused():
    with pytest.raises(pc.SceneError, match=r"Surface.thickness: must be ≥ 0"):
        pc.styles.Surface(thickness=-0.1)
