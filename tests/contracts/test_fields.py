"""The table of fields in Python against the engine's."""

from __future__ import annotations

import pytest

import physcore as pc
from contracts.scenes import SCENES
from physcore.scene.fields import Field
from physcore.simulation import engine


def in_engine(fields: dict[str, Field]) -> dict[str, tuple[str, tuple[int, ...]]]:
    """The units and shapes of fields and of their time integrals, by name."""
    integrals = {each.integral: (f"{each.unit}·s", each.shape) for each in fields.values() if each.integral}
    return {name: (each.unit, each.shape) for name, each in fields.items()} | integrals


@pytest.mark.parametrize("name", SCENES)
def test_scenes_have_the_fields_that_the_engine_lists(name):
    run = SCENES[name].simulation()
    listed = {info.name: (info.unit, info.shape) for info in engine.fields(run._world, run.scene)}
    known = in_engine(run.scene.fields)
    if isinstance(run.integrator, pc.XPBD):
        known.pop("tensions", None)  # It moves the ends of rods, and has no forces of theirs.
    assert listed == {name: (run.scene.units.symbol(unit), shape) for name, (unit, shape) in known.items()}


LOCATIONS = {"particles": "points", "fluid particles": "points", "rigid bodies": "bodies"}
"""Elements that have another name in the engine, where tracers and vortices are points too."""


@pytest.mark.parametrize("name", SCENES)
def test_fields_stand_at_the_same_elements_as_in_the_engine(name):
    run = SCENES[name].simulation()
    known = {
        source: LOCATIONS.get(field.element, field.element)
        for field in reversed(run.scene.fields.values())  # rows of rigid bodies follow those of particles
        for source in (field.source, field.integral)
    }
    listed = {name: location for name, _, location, *_ in run._world.fields() if location != "whole"}
    assert listed == {field: known[field] for field in listed}
    # With XPBD() there are no tensions, and without bodies no positions.
    present = {field.source for field in run.scene.fields.values() if field.shape[0]} - {"tensions"}
    assert present <= listed.keys()


@pytest.mark.parametrize("name", SCENES)
def test_parts_of_all_items_cover_every_field(name):
    """Each row of each field belongs to one item, but for the walls of fluids, which are none."""
    scene = SCENES[name].shared
    rows = {field.name: [] for field in scene.fields.values()}
    presses = "wall_forces" in rows
    wires = [each for each in scene.constraints if each.element is not None]
    for item in (*scene.bodies, *scene.systems, *scene.probes, *wires, *(scene.boundaries if presses else ())):
        for field, part in scene.parts(item).values():
            length = scene.fields[field].shape[0]
            rows[field] += [part] if isinstance(part, int) else range(length)[part]
    for field, found in rows.items():
        assert len(found) == len(set(found))
        missing = set(range(scene.fields[field].shape[0])) - set(found)
        if field == "wall_forces":
            missing -= {len(scene.boundaries) + index for index, body in enumerate(scene.bodies) if body.is_fluid}
        elif scene.fields[field].element == "fluid particles":
            missing -= {
                row for body in scene.bodies if not body.is_fluid for row in range(scene.particles)[scene.slice(body)]
            }
        assert not missing, field
