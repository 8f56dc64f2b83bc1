"""The panel without a page: playing, controls, dragging, and what may go wrong."""

from __future__ import annotations

import threading

import numpy as np
import pytest

import physcore as pc
from chromium import until

pytest.importorskip("websockets", reason="the extra physcore[live] is not installed")

RODS = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], np.inf, fixed=[0], name="rod")


def net(stiffness=200.0, size=12):
    sheet = pc.cloth((size, 8), 0.05, stiffness=stiffness, damping=0.02, mass=2e-3, pinned="top corners", name="net")
    return pc.Scene(sheet, pc.Gravity())


@pytest.fixture
def panel():
    sliders = {"stiffness": pc.Slider(20.0, 2000.0, 200.0), "size": pc.Slider(4, 20, 12)}
    with pc.live(net, show=False, **sliders) as opened:
        yield opened


def test_a_panel_begins_paused_and_plays_and_pauses(panel):
    assert panel.simulation.time == 0.0
    panel.play()
    until(lambda: panel.simulation.time > 0.1, "physics")
    panel.pause()
    time = panel.simulation.time
    assert panel.simulation.time == time


def test_steps_have_the_bits_of_a_simulation_by_itself(panel):
    alone = pc.Simulation(net())
    alone.step(25)
    panel.step(20)
    panel.step(5)
    assert panel.simulation.state_hash() == alone.state_hash()
    panel.reset()
    assert panel.simulation.steps == 0
    np.testing.assert_array_equal(panel.simulation.positions, net().bodies[0].positions)


def test_playing_has_the_bits_of_the_same_steps(panel):
    panel.play()
    until(lambda: panel.simulation.steps > 50, "physics")
    panel.pause()
    alone = pc.Simulation(net())
    alone.step(panel.simulation.steps)
    assert panel.simulation.state_hash() == alone.state_hash()


def test_a_slider_goes_on_or_starts_anew_and_says_which(panel):
    panel.step(100)
    before = panel.simulation.energy()
    panel.set(stiffness=400.0)
    after = panel.simulation.energy()
    assert panel.simulation.steps == 100
    assert panel.note == "goes on from the present state"
    # The same strains at twice the stiffness have twice the energy, and the springs gain it by work.
    assert after.by_term["springs"] == pytest.approx(2.0 * before.by_term["springs"], rel=1e-12)
    assert after.work - before.work == pytest.approx(after.total - before.total, rel=1e-12)
    panel.set(size=10)
    assert panel.simulation.steps == 0
    assert panel.note.startswith("started anew: bodies['net'].positions: must be 96 as before, got 80")
    assert panel.values == {"stiffness": 400.0, "size": 10}


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"stiffness": 5000.0}, r"^set.stiffness: must be ≤ 2000, got 5000$"),
        ({"stiffnes": 100.0}, r"^set.stiffnes: there is no such control.*did you mean 'stiffness'"),
        ({"size": 4.5}, r"^set.size: must be a whole number"),
        ({"stiffness": 300.0, "size": 3}, r"^set.size: must be ≥ 4"),
    ],
)
def test_what_is_refused_changes_nothing(panel, values, message):
    panel.step(10)
    state = panel.simulation.state_hash()
    with pytest.raises(pc.SceneError, match=message):
        panel.set(**values)
    assert panel.simulation.state_hash() == state
    assert panel.values == {"stiffness": 200.0, "size": 12}


def test_a_build_that_fails_leaves_the_panel_as_it_was():
    def build(k):
        if k > 1.0:
            raise ZeroDivisionError("no")
        return None if k > 0.5 else net()

    with pc.live(build, k=pc.Slider(0.0, 2.0), show=False) as panel:
        panel.step(5)
        for k, message in ((1.5, r"^build: the function raised ZeroDivisionError: no$"), (0.7, r"^build: must return")):
            with pytest.raises(pc.SceneError, match=message):
                panel.set(k=k)
        assert panel.simulation.steps == 5
        assert panel.values == {"k": 0.0}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"k": pc.Slider(0.0, 1.0)}, r"^build: must take k, got a function of \(stiffness"),
        ({"dt": -1.0}, r"^dt: must be > 0"),
        ({"fps": 0.0}, r"^fps: "),
        ({"port": 70000}, r"^port: must be ≤ 65535"),
        ({"theme": "blue"}, r"^theme: must be one of"),
        ({"labels": ("integrator",)}, r"label 'integrator' needs a Simulation"),
    ],
)
def test_options_are_checked_before_anything_runs(options, message):
    threads = threading.active_count()
    with pytest.raises(pc.SceneError, match=message):
        pc.live(net, show=False, **options)
    assert threading.active_count() == threads


def test_a_misspelt_option_is_named():
    with pytest.raises(TypeError, match=r"unexpected keyword argument 'tehme'; did you mean 'theme'"):
        pc.live(net, show=False, tehme="dark")


def test_a_taken_port_is_an_error_by_name():
    with pc.live(net, show=False) as panel:
        port = int(panel.url.split(":")[2].split("/")[0])
        with pytest.raises(pc.SceneError, match=rf"^port: {port} cannot be used: .*in use"):
            pc.live(net, show=False, port=port)


@pytest.mark.parametrize("numerics", [{}, {"dt": 5e-4}, {"integrator": "RungeKutta4"}, {"precision": "f32"}], ids=str)
def test_a_drag_closes_the_budget(numerics):
    with pc.live(net, show=False, **numerics) as panel:
        start = panel.simulation.energy().balance
        panel.grab(("net", 5), stiffness=100.0)
        place = panel.simulation["net"].positions[5]
        for share in np.linspace(0.0, 1.0, 20):
            panel.drag(place + share * np.array([0.15, 0.05]))
            panel.step(20)
        # The net pulls it back, by about a third of the spring's length.
        assert np.linalg.norm(panel.simulation["net"].positions[5] - place) > 0.05
        held = panel.simulation.energy()
        panel.release()
        free = panel.simulation.energy()
        # The spring's energy goes when it is released, which is work.
        assert free.work - held.work == pytest.approx(free.total - held.total, rel=1e-9)
        assert "central" in held.by_term
        assert "central" not in free.by_term
        scale = free.kinetic + abs(free.work) + free.dissipated
        assert abs(free.balance - start) < 0.01 * scale


def test_the_pointer_does_the_work_of_its_spring():
    """A spring of stiffness k that is drawn out by d, while nothing moves, has taken k d²/2."""
    with pc.live(lambda: pc.Scene(pc.Particles([[0.0, 0.0]], mass=2.0, name="ball")), show=False) as panel:
        panel.grab("ball", stiffness=50.0)
        assert panel.simulation.energy().work == 0.0
        panel.drag((0.3, -0.4))
        assert panel.simulation.energy().work == pytest.approx(0.5 * 50.0 * 0.25, rel=1e-12)
        panel.release()
        assert panel.simulation.energy().work == pytest.approx(0.0, abs=1e-12)


def test_a_rigid_body_is_dragged_and_a_rod_too():
    box = pc.RigidBody(pc.Rectangle(0.2, 0.2), (0.0, 1.0), mass=1.0, name="box")
    for scene, key in ((pc.Scene(box, pc.Gravity(), pc.Floor()), "box"), (pc.Scene(RODS, pc.Gravity()), ("rod", 1))):
        with pc.live(lambda scene=scene: scene, show=False) as panel:
            place = panel.simulation[key if isinstance(key, str) else key[0]].positions[-1]
            panel.grab(key)
            panel.drag(place + 0.2)
            panel.play()
            name = key if isinstance(key, str) else key[0]
            until(lambda: panel.simulation[name].positions[-1, 1] > place[1] + 0.05, "the drag")  # noqa: B023
            assert panel.error == ""


def test_requests_are_done_in_their_order(panel):
    """A drag that waits is done before a later release, and is no drag of what is held next."""
    free, done = threading.Event(), []
    panel.runner.post(lambda session: free.wait())
    panel.runner.urge("drag", lambda session: done.append("first place"))
    panel.runner.urge("drag", lambda session: done.append("second place"))
    panel.runner.post(lambda session: done.append("release"))
    panel.runner.post(lambda session: done.append("grab"))
    panel.runner.urge("drag", lambda session: done.append("third place"))
    free.set()
    until(lambda: "third place" in done, "the last drag")
    assert done == ["second place", "release", "grab", "third place"]


def test_the_nearest_free_element_is_grabbed_by_a_point(panel):
    corner = panel.simulation["net"].positions[0]
    fixed = net().bodies[0].fixed
    panel.grab(panel.simulation["net"].positions[np.flatnonzero(fixed)[0]])
    panel.drag(corner + 1.0)
    panel.play()
    until(lambda: panel.simulation.energy().work > 0.0, "the drag")


@pytest.mark.parametrize(
    ("key", "message"),
    [
        (("nets", 1), r"^grab.key: no body 'nets'.*did you mean 'net'"),
        (("net", 96), r"^grab.key\[1\]: must be ≤ 95"),
        ((1.0, 2.0, 3.0), r"^grab.key: must be \(body, index\), or a point of 2 components"),
    ],
)
def test_what_is_not_there_cannot_be_grabbed(panel, key, message):
    with pytest.raises(pc.SceneError, match=message):
        panel.grab(key)
    with pytest.raises(pc.SceneError, match=r"^drag.point: nothing is held"):
        panel.drag((0.0, 0.0))
    panel.release()


def test_what_is_fixed_cannot_be_grabbed(panel):
    with pytest.raises(pc.SceneError, match=r"^grab.key: bodies\['net'\] holds element \d+ fixed"):
        panel.grab(("net", int(np.flatnonzero(net().bodies[0].fixed)[0])))
    with (
        pc.live(lambda: pc.Scene(pc.Wave(pc.Grid((8, 8), 0.1), 1.0)), show=False) as waves,
        pytest.raises(pc.SceneError, match=r"^grab.key: there is nothing to hold"),
    ):
        waves.grab((0.0, 0.0))


def test_the_hand_stays_when_a_slider_moves(panel):
    panel.grab(("net", 5), stiffness=100.0)
    panel.drag(panel.simulation["net"].positions[5] + 0.1)
    energy = panel.simulation.energy().by_term["central"]
    assert energy == pytest.approx(0.5 * 100.0 * 0.02, rel=1e-12)
    panel.set(stiffness=500.0)
    assert panel.simulation.energy().by_term["central"] == energy
    panel.set(size=9)
    assert "central" not in panel.simulation.energy().by_term


def test_a_given_step_stays_and_the_plan_says_when_it_is_above_the_limit():
    with pytest.warns(pc.StabilityWarning, match="above the limit"):
        panel = pc.live(net, stiffness=pc.Slider(20.0, 2000.0, 200.0), dt=4e-3, show=False)
    with panel:
        assert panel.report.plan["over"]
        panel.set(stiffness=20.0)
        assert panel.simulation.dt == 4e-3
        assert not panel.report.plan["over"]


def test_a_divergence_pauses_and_is_told():
    with pytest.warns(pc.StabilityWarning, match="above the limit"):
        panel = pc.live(net, stiffness=pc.Slider(20.0, 2000.0, 200.0), dt=2e-2, show=False)
    with panel:
        panel.play()
        until(lambda: panel.error, "the divergence")
        assert "diverged" in panel.error or "blew up" in panel.error or "limit" in panel.error
        assert not panel.report.playing
        panel.reset()
        assert panel.error == ""
        assert panel.simulation.time == 0.0


def test_a_simulation_is_read_whole_from_any_thread(panel):
    """Positions and velocities of one read are of one state: their sum of energies is that of the budget."""
    panel.play()
    until(lambda: panel.simulation.steps > 0, "physics")
    for _ in range(20):
        frame = panel.simulation.frame()
        kinetic = 0.5 * 2e-3 * (frame.velocities**2).sum()
        assert kinetic == pytest.approx(frame.energy.kinetic, rel=1e-9)
    assert isinstance(panel.simulation, pc.Simulation)
    pixels = pc.Renderer(panel.simulation.scene, size=(80, 60)).draw(panel.simulation)
    assert pixels.shape == (60, 80, 3)


def test_a_part_of_the_simulation_can_be_set(panel):
    panel.simulation["net"].set(velocities=(0.0, 1.0))
    assert panel.simulation.energy().kinetic == pytest.approx(0.5 * 2e-3 * 94, rel=1e-9)


def test_a_closed_panel_ends_all_threads_and_says_so():
    threads = threading.active_count()
    panel = pc.live(net, show=False)
    panel.play()
    assert threading.active_count() > threads
    panel.close()
    panel.close()
    assert threading.active_count() == threads
    assert panel.closed
    assert panel.wait(0.0)
    for action in (panel.play, panel.step, panel.release, lambda: panel.simulation.time):
        with pytest.raises(pc.PhyscoreError, match="this panel is closed"):
            action()


@pytest.mark.parametrize(
    "scene",
    [
        pc.Scene(pc.Wave(pc.Grid((32, 32), 0.1), 1.0, displacement=lambda x, y: np.exp(-(x**2) - y**2))),
        pc.Scene(RODS, pc.Gravity()),
        pc.Scene(pc.Fluid.block((0.0, 0.0), (0.4, 0.4), 0.05), pc.Gravity(), pc.Box((0.0, 0.0), (1.0, 1.0))),
        pc.Scene(pc.Particles([[0.2, 0.1]], velocities=[[5.0, 0.0]]), pc.Periodic((0.0, 0.0), (1.0, 1.0))),
        pc.Scene(pc.RigidBody(pc.Cuboid(0.2, 0.2, 0.2), (0.0, 0.0, 1.0)), pc.Gravity(), pc.Floor()),
    ],
    ids=["wave", "rods", "fluid", "periodic", "rigid"],
)
def test_every_kind_of_scene_plays(scene):
    with pc.live(lambda: scene, show=False) as panel:
        panel.play()
        until(lambda: panel.simulation.time > 0.05 or panel.error, "physics")
        assert panel.error == ""


def test_pictures_show_the_energy_if_they_are_asked_to():
    options = {"labels": ("time", "dt", "energy"), "inset": "energy", "size": (320, 240)}
    with pc.live(net, show=False, **options) as panel, pc.live(net, show=False, size=(320, 240)) as plain:
        for each in (panel, plain):
            each.step(200)
            each.artist.watch(on=True)
            until(lambda each=each: each.artist.picture.state.time == each.simulation.time, "a picture")
        assert panel.report.error == ""
        assert (panel.artist.picture.pixels != plain.artist.picture.pixels).any()
        # Energies are kept for the diagram alone: a panel may play for days.
        assert len(panel.artist._renderer._seen.energies) == 2
        assert len(plain.artist._renderer._seen.energies) == 0


def test_scenes_of_other_scales_play_at_a_speed_that_suits_them():
    day = pc.Particles([[1.5e11, 0.0]], velocities=[[0.0, 29800.0]], mass=6e24)
    sun = pc.CentralForce((0.0, 0.0), strength=1.327e20 * 6e24)
    with pc.live(lambda: pc.Scene(day, sun), dt=3600.0, show=False) as panel:
        assert panel.speed == 9e5  # four steps for each of 60 pictures, in one digit
        panel.play()
        until(lambda: panel.simulation.time > 86400.0, "physics")
