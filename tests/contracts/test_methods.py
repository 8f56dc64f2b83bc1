"""Which method can advance which item: the engine's answer, against what becomes of a scene with both."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import physcore as pc
from physcore.integrators import INTEGRATORS
from physcore.numerics.choices import check
from physcore.simulation import engine

GRID = pc.Grid((6, 6), 0.5)
ITEMS = {
    "bodies": pc.Particles([[0.0, 0.0]]),
    "Wave": pc.Wave(GRID, 1.0),
    "ReactionDiffusion": pc.ReactionDiffusion(
        GRID, pc.GrayScott(0.03, 0.06), {"u": 0.1, "v": 0.1}, {"u": 1.0, "v": 0.0}
    ),
    "Schrodinger": pc.Schrodinger(GRID, np.ones(GRID.cells)),
    "Tracers": pc.Tracers([[0.0, 0.0]], pc.Flow(lambda time, x: -x)),
    "PointVortices": pc.PointVortices([[0.0, 0.0]], 1.0),
}


def test_every_kind_of_system_is_asked_for():
    assert {"bodies", *(kind.__name__ for kind in pc.systems.SYSTEMS)} == set(ITEMS)


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")  # Euler's method is unstable for waves.
@pytest.mark.parametrize(("kind", "item"), list(product(INTEGRATORS, ITEMS)))
def test_the_engine_builds_what_it_says_it_can_advance(kind, item):
    scene = pc.Scene(ITEMS[item])
    numerics = replace(check({"dt": 1e-3, "precision": "f64"}, scene), integrator=kind())
    if kind.advances(item):
        engine.build(scene, numerics).step(1, 1e-3)
        assert isinstance(pc.Simulation(scene, kind(), dt=1e-3).integrator, kind)
        return
    with pytest.raises(pc.SceneError, match="integrator: "):
        engine.build(scene, numerics)
    with pytest.raises(pc.SceneError, match=rf"integrator: {kind.__name__}\(\) cannot drive it; "):
        pc.Simulation(scene, kind(), dt=1e-3)


def test_kinds_that_the_engine_does_not_know_have_no_method():
    assert not any(kind.advances("Pond") for kind in INTEGRATORS)
