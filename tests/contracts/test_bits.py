"""The bits of a trajectory do not change from one version to the next: those of `bits.json` are the reference.

A change that means to change them writes the file anew, in a commit of its own that says why:

    PYTHONPATH=tests python -m contracts.test_bits
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from contracts.scenes import SCENES, Case

REFERENCE = Path(__file__).with_name("bits.json")


def bits(case: Case, **numerics: object) -> str:
    """A hash of positions, velocities, time and the energy budget after some steps, in double precision."""
    run = case.simulation(**numerics)
    case.advance(run)
    energy = run.energy()
    budget = [run.time, energy.kinetic, *energy.by_term.values(), energy.internal, *energy.dissipated_by.values()]
    fields = [values for system in run.scene.systems for values in run[system].fields.values()]
    content = [run.positions, run.velocities, *fields, np.array([*budget, energy.work])]
    return hashlib.blake2b(b"".join(values.tobytes() for values in content), digest_size=12).hexdigest()


@pytest.mark.parametrize("name", SCENES)
def test_the_bits_are_those_of_the_reference(name):
    assert bits(SCENES[name]) == json.loads(REFERENCE.read_text(encoding="utf-8"))[name]


def test_the_reference_has_no_scene_that_is_gone():
    assert set(json.loads(REFERENCE.read_text(encoding="utf-8"))) == set(SCENES)


if __name__ == "__main__":
    reference = {name: bits(case) for name, case in SCENES.items()}
    REFERENCE.write_text(json.dumps(reference, indent=2) + "\n", encoding="utf-8")
