"""Single precision is that of the arithmetic: beside double precision it is off by what rounding makes, or refused."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from contracts.comparison import difference, state, tolerance
from contracts.scenes import SCENES
from contracts.transforms import Transform, transformed


@pytest.mark.parametrize("name", [name for name, case in SCENES.items() if not case.is_double])
def test_single_precision_is_double_precision_within_rounding(name):
    case = SCENES[name]
    double, single = (case.advance(case.simulation(precision=precision)) for precision in ("f64", "f32"))
    assert double.state_hash() != single.state_hash()
    assert difference(double.scene, state(double), state(single)) <= tolerance(name, single)


@pytest.mark.parametrize("name", SCENES)
def test_what_single_precision_cannot_hold_is_refused_with_the_reason(name):
    """Numbers that are 2^140 times as large are beyond its range."""
    case = SCENES[name]
    scene = case.shared
    if any(isinstance(system, pc.ReactionDiffusion) for system in scene.systems):
        pytest.skip("its values have no unit, and no length is left in D/h²")
    huge = transformed(scene, Transform(np.eye(scene.dimension), m=2.0**140))
    with pytest.raises(pc.SceneError, match="f32"):
        case.simulation(huge, precision="f32")
