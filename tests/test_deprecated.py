"""Names of before go on working, and say what they are called now."""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pytest

import physcore as pc
from physcore import forces
from physcore.film import provenance

SCENE = pc.Scene(pc.Particles([[0.0, 0.0]], velocities=1.0))


@pytest.mark.parametrize(
    ("module", "name", "now"),
    [
        ("physcore", "Repulsion", pc.SoftSpheres),
        ("physcore.forces", "Repulsion", forces.SoftSpheres),
        ("physcore", "evidence", provenance),
        ("physcore.film", "evidence", provenance),
    ],
)
def test_a_name_of_before_gives_the_new_thing(module, name, now):
    with pytest.warns(DeprecationWarning, match=rf"{name} is now .*{now.__name__}"):
        assert getattr(import_module(module), name) is now


def test_runaway_is_max_energy_growth():
    with pytest.warns(DeprecationWarning, match="runaway= is now max_energy_growth="):
        before = pc.Simulation(SCENE, runaway=7.0)
    with pytest.warns(DeprecationWarning, match="runaway= is now max_energy_growth="):
        recording = pc.simulate(SCENE, 0.1, runaway=7.0)
    now = pc.Simulation(SCENE, max_energy_growth=7.0).provenance.numerics
    assert before.provenance.numerics == recording.provenance.numerics == now
    assert now["max_energy_growth"] == 7.0
    assert "runaway" not in now


def test_both_names_at_once_are_refused():
    with (
        pytest.warns(DeprecationWarning, match="max_energy_growth"),
        pytest.raises(pc.SceneError, match="runaway: is the old name of max_energy_growth"),
    ):
        pc.Simulation(SCENE, max_energy_growth=7.0, runaway=7.0)


def test_what_a_hash_says_of_a_force_does_not_change_with_its_name():
    grains = pc.Particles(np.zeros((1, 2)), radius=0.1)
    scene = pc.Scene(grains, pc.SoftSpheres(100.0, 0.1))
    assert scene.packed()["forces"][0]["kind"] == "Repulsion"


def test_integrators_are_importable_under_their_public_name():
    public = import_module("physcore.integrators")
    assert public.INTEGRATORS == import_module("physcore.numerics.integrators").INTEGRATORS
    assert public.PEFRL is pc.PEFRL
