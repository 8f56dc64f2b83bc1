"""What can be sent to another process, and comes out there as it was."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import physcore as pc
from physcore import styles
from physcore.film import DARK, LIGHT, Corotating, Follow, Keyframes, Orbit, Window

CLOTH = pc.cloth((4, 4), 0.1, 100.0, 0.1, pinned="top", name="cloth")
WATER = pc.Fluid(pc.block((0.0, -1.0), (0.3, -0.7), 0.1), 0.1)
SCENES = {
    "springs": pc.Scene(CLOTH, pc.Gravity((0.0, -9.81), on=CLOTH), pc.Floor(-1.0)),
    "a fluid": pc.Scene(WATER, pc.Gravity((0.0, -9.81)), pc.Box((-0.5, -1.0), (0.5, 1.0))),
    "grains": pc.Scene(pc.Particles([[0.0, 0.0], [0.15, 0.0]], radius=0.1), pc.SoftSpheres(100.0, 0.1)),
}


def sent(value):
    return pickle.loads(pickle.dumps(value))


def pull(time, positions, velocities):
    return -positions


def test_a_simulation_with_a_function_that_has_a_name_is_sent_too():
    first = pc.Simulation(pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(pull)), dt=0.01)
    first.step(10)
    second = sent(first)
    first.step(10)
    second.step(10)
    assert second.state_hash() == first.state_hash()


def test_a_function_without_a_name_is_refused_by_its_path_and_copied_all_the_same():
    force = pc.CustomForce(lambda time, x, v: -x)
    simulation = pc.Simulation(pc.Scene(pc.Particles([[1.0, 0.0]]), pc.Drag(1.0), force), dt=0.01)
    with pytest.raises(pc.SceneError, match=r"forces\[1\]\.function: cannot be pickled .*top level of a module"):
        pickle.dumps(simulation)
    assert copy.deepcopy(simulation).state_hash() == simulation.state_hash()


def test_the_bodies_of_a_scene_stay_keys():
    scene = SCENES["springs"]
    loaded, named, simulation = sent((scene, {CLOTH: "cloth"}, pc.Simulation(scene)))
    (body,) = loaded.bodies
    assert named[body] == "cloth"
    assert loaded.forces[0].bodies() == (body,)
    assert simulation.scene is loaded
    assert simulation[body].positions.shape == (16, 2)
    assert loaded.hash() == scene.hash()


def test_a_texture_is_sent_with_its_style():
    pixels = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    style = styles.Surface(texture=pixels)
    assert sent(style) == style == styles.Surface(texture=pixels.copy())
    assert hash(sent(style)) == hash(style)
    assert style != styles.Surface(texture=255 - pixels)
    assert copy.deepcopy(style) == style


@pytest.mark.parametrize(
    "value",
    [
        *(kind() for kind in styles.STYLES),
        DARK,
        LIGHT,
        Orbit(azimuth=10.0, target=(0.0, 1.0, 2.0)),
        Window((0.0, 0.0), (1.0, 1.0)),
        Keyframes({0.0: Orbit(), 1.0: Orbit(azimuth=0.0)}),
        Follow(0, Orbit()),
        Corotating(0, (1, 2), Orbit()),
        pc.AdaptiveStep(tolerance=1e-3),
        pc.Periodic((0.0, 0.0), (1.0, 1.0)),
    ],
    ids=lambda value: type(value).__name__,
)
def test_styles_cameras_and_themes_are_sent(value):
    assert sent(value) == value


def test_recordings_are_sent(tmp_path):
    recording = pc.simulate(SCENES["a fluid"], 0.1, channels=("positions", "pressures"))
    loaded = sent(recording)
    for name, values in recording.channels.items():
        np.testing.assert_array_equal(values, loaded.channels[name])
    assert loaded.plan == recording.plan
    assert loaded.provenance == recording.provenance
    loaded.save(tmp_path / "loaded")
    recording.save(tmp_path / "recording")
    assert (tmp_path / "loaded").read_bytes() == (tmp_path / "recording").read_bytes()


def test_a_trade_is_sent():
    scene = pc.Scene(pc.Particles([[1.0, 0.0]], velocities=[0.0, 1.0]), pc.CentralForce((0.0, 0.0), 1.0))
    trade = pc.tradeoff(scene, 1.0, integrators=[pc.VelocityVerlet()], precisions=["f64"], budget=0.1)
    loaded = sent(trade)
    assert str(loaded) == str(trade)
    assert loaded.best(error=1.0).numerics == trade.best(error=1.0).numerics
