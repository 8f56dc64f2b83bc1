"""A scene that is replaced while it runs: the state goes on by names, and the change of energy is work."""

from __future__ import annotations

import copy
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from contracts.scenes import SCENES, STEPS
from physcore.simulation import engine

EPS = float(np.finfo(float).eps)


def roundings(*energies: pc.Energy) -> float:
    """A bound on the rounding of sums of the terms of budgets: each is rounded a few times."""
    terms = [
        term
        for each in energies
        for term in (each.kinetic, *each.by_term.values(), each.internal, each.dissipated, each.work)
    ]
    return 16.0 * EPS * float(np.abs(terms).sum())


def net(stiffness: float = 200.0, name: str | None = "net", **options: Any) -> pc.SpringNetwork:
    given = {"damping": 0.02, "mass": 2e-3, "pinned": "top corners", **options}
    return pc.cloth((6, 5), 0.05, stiffness=stiffness, name=name, **given)


def running(*items: Any, time: float = 0.1, **numerics: Any) -> pc.Simulation:
    """A simulation that has run for some time."""
    simulation = pc.Simulation(pc.Scene(*(items or (net(), pc.Gravity()))), **numerics)
    simulation.run(time)
    return simulation


def test_state_and_clock_go_on_and_the_change_of_energy_is_work() -> None:
    simulation = running()
    before, positions, velocities = simulation.energy(), simulation.positions, simulation.velocities
    time, steps = simulation.time, simulation.steps
    scene = pc.Scene(net(800.0), pc.Gravity())
    simulation.replace(scene)
    after = simulation.energy()
    assert simulation.scene is scene
    assert (simulation.time, simulation.steps) == (time, steps)
    assert np.array_equal(simulation.positions, positions)
    assert np.array_equal(simulation.velocities, velocities)
    assert after.by_term["springs"] == pytest.approx(4.0 * before.by_term["springs"], rel=1e-12)
    assert after.work - before.work == pytest.approx(after.total - before.total, abs=roundings(before, after))
    assert after.dissipated_by == before.dissipated_by
    simulation.run(0.3)
    assert simulation.time == pytest.approx(time + 0.3, rel=1e-12)
    end = simulation.energy()
    assert end.dissipated > after.dissipated
    # Where the steps are those of a net that was there from the start, so is the drift.
    assert abs(end.balance - before.balance) < 1e-4 * (end.kinetic + end.dissipated + abs(end.work))


def test_a_spring_that_is_removed_takes_its_energy() -> None:
    """½ k (r − L)², and nothing else."""
    rope = pc.rope(5, 1.0, stiffness=50.0, mass=0.1, pinned="start", name="rope")
    simulation = running(rope, pc.Gravity(), time=0.2)
    x, (one, other) = simulation.positions, rope.pairs[2]
    length = float(np.linalg.norm(x[other] - x[one]))
    energy = 0.5 * rope.stiffness[2] * (length - rope.rest_length[2]) ** 2
    kept = [0, 1, 3]
    cut = pc.SpringNetwork(
        rope.positions, rope.pairs[kept], rope.stiffness[kept], rest_length=rope.rest_length[kept], mass=rope.mass,
        fixed=rope.fixed, name="rope",
    )  # fmt: skip
    before = simulation.energy()
    simulation.replace(pc.Scene(cut, pc.Gravity()))
    after = simulation.energy()
    assert energy > 5e-4
    assert after.work - before.work == pytest.approx(-energy, abs=roundings(before, after))
    simulation.run(0.2)
    # The end is a body in free fall now, apart from its own spring: its center is on a parabola.
    assert simulation.positions[3:, 1].mean() < x[3:, 1].mean() - 0.5 * 9.81 * 0.2**2 / 2


@pytest.mark.parametrize("first", [True, False], ids=["before", "behind"])
def test_a_body_that_is_added_brings_its_energy(first: bool) -> None:
    """½ m v² + m g y, wherever it stands in the scene; when it is removed it takes it along."""
    gravity = pc.Gravity((0.0, -9.81))
    ball = pc.Particles([[0.0, 2.0], [1.0, 3.0]], velocities=[[1.0, 0.0], [0.0, 2.0]], mass=[0.5, 0.25], name="balls")
    energy = 0.5 * 0.5 * 1.0 + 0.5 * 0.25 * 4.0 + 9.81 * (0.5 * 2.0 + 0.25 * 3.0)
    simulation = running(net(), gravity)
    before, own = simulation.energy(), simulation["net"].positions
    bodies = (ball, net()) if first else (net(), ball)
    simulation.replace(pc.Scene(*bodies, gravity))
    with_balls = simulation.energy()
    assert with_balls.work - before.work == pytest.approx(energy, abs=roundings(before, with_balls))
    assert np.array_equal(simulation["net"].positions, own)
    assert np.array_equal(simulation["balls"].velocities, ball.velocities)
    simulation.replace(pc.Scene(net(), gravity))
    without = simulation.energy()
    assert without.work - with_balls.work == pytest.approx(-energy, abs=roundings(with_balls, without))
    assert np.array_equal(simulation["net"].positions, own)


def test_what_was_dissipated_by_a_force_that_is_gone_stays_in_the_budget() -> None:
    simulation = running(net(damping=0.0), pc.Gravity(), pc.Drag(linear=0.01))
    spent = simulation.energy().dissipated_by["drag"]
    assert spent > 0.0
    simulation.replace(pc.Scene(net(damping=0.0), pc.Gravity()))
    simulation.run(0.2)
    energy = simulation.energy()
    assert energy.dissipated_by["drag"] == spent == energy.dissipated
    simulation.replace(pc.Scene(net(damping=0.0), pc.Gravity(), pc.Drag(linear=0.01)))
    assert simulation.energy().dissipated_by["drag"] == spent
    simulation.run(0.1)
    assert simulation.energy().dissipated_by["drag"] > spent


@given(
    st.lists(
        st.tuples(st.floats(10.0, 1e3), st.floats(-20.0, 20.0), st.floats(0.0, 0.05), st.booleans()),
        min_size=1,
        max_size=4,
    )
)
def test_the_balance_is_closed_at_every_replacement(changes: list[tuple[float, float, float, bool]]) -> None:
    """To the rounding of its terms, whatever the parameters are, and in whatever order the bodies stand."""
    ball = pc.Particles([[0.3, 0.4]], velocities=[[0.2, 0.0]], name="ball")
    simulation = running(net(), ball, pc.Gravity(), time=0.02)
    for stiffness, pull, drag, turned in changes:
        before, positions = simulation.energy(), {name: simulation[name].positions for name in ("net", "ball")}
        bodies = (ball, net(stiffness)) if turned else (net(stiffness), ball)
        simulation.replace(pc.Scene(*bodies, pc.Gravity((0.0, pull)), pc.Drag(linear=drag)))
        after = simulation.energy()
        assert abs(after.balance - before.balance) <= roundings(before, after)
        for name, own in positions.items():
            assert np.array_equal(simulation[name].positions, own)
        simulation.run(0.01)


def test_forth_and_back_is_reversible() -> None:
    """Velocity Verlet is, and so are two replacements in the opposite order; 400 steps of about ten roundings each."""

    def scene(strength: float) -> pc.Scene:
        ball = pc.Particles([[1.0, 0.0]], velocities=[[0.0, 0.7]], name="ball")
        return pc.Scene(ball, pc.CentralForce((0.0, 0.0), strength, 1.0))

    simulation = pc.Simulation(scene(1.0), "VelocityVerlet", dt=0.01)
    start = simulation.positions
    simulation.step(100)
    simulation.replace(scene(3.0))
    simulation.step(100)
    simulation.set(velocities=-simulation.velocities)
    simulation.step(100)
    simulation.replace(scene(1.0))
    simulation.step(100)
    assert abs(simulation.positions - start).max() < 400 * 10 * EPS
    assert simulation.energy().work == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("name", [name for name in SCENES if not SCENES[name].adaptive])
def test_an_equal_scene_changes_no_bit(name: str) -> None:
    case = SCENES[name]
    scene = case.scene()
    plain, replaced = case.simulation(scene), case.simulation(scene)
    for run in (plain, replaced):
        case.advance(run, STEPS // 3)
    replaced.replace(case.scene() if not has_code(scene) else scene)
    for run in (plain, replaced):
        case.advance(run, STEPS - STEPS // 3)
    assert plain.state_hash() == replaced.state_hash()
    assert vars(plain.energy()) == vars(replaced.energy())


def has_code(scene: pc.Scene) -> bool:
    from physcore.scene.records import Record

    return any(Record.of(item).code for item in (*scene.forces, *scene.systems))


def starts_warm(scene: pc.Scene) -> bool:
    """Whether the impulses of meshes or rigid bodies that meet, or of springs at their longest, begin with those of the
    last step.
    """
    limited = [body.strain_limit for body in scene.bodies if isinstance(body, pc.SpringNetwork)]
    return scene.has_rigid_bodies or bool(scene.constraints) or any(np.isfinite(limit).any() for limit in limited)


LISTED = 3e-6
"""Where neighbors are listed anew, sums over them have another order: 40 steps of single precision."""
PULLED = 0.025
"""Water that leaves a wall feels its suction for one more half kick, in spacings s. A density off by a percent has the
pressure 0.01 ρc², which accelerates by 0.02 c²/s; half a step of at most s/4c gives 0.0025 c, and 40 steps 0.025 s."""


@pytest.mark.parametrize("name", [name for name in SCENES if not SCENES[name].adaptive and "wires" not in name])
def test_a_new_world_is_as_one_whose_state_was_set(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """In all bits, but where neighbors or contacts of meshes are looked for anew.

    Beads, which are put on their wires anew, have a test of their own.
    """
    case = SCENES[name]
    written, replaced = case.simulation(), case.simulation()
    for run in (written, replaced):
        case.advance(run, STEPS // 3)
    fields = {info.name: engine.read(run._world, run.scene, info.name) for info in engine.fields(run._world, run.scene)}
    state = {info.name: info.state for info in engine.fields(run._world, run.scene)}
    present = {each: values for each, values in fields.items() if state[each] and values.size}
    engine.write(written._world, written.scene, present)
    tied = any(isinstance(each, pc.Anchor) for each in replaced.scene.constraints)
    monkeypatch.setattr(engine, "is_same", lambda one, other: False)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pc.StabilityWarning)
        replaced.replace(replaced.scene)
    for each, values in fields.items():
        if state[each]:
            new = engine.read(replaced._world, replaced.scene, each)
            # Normalized, and L = I ω, are rounded, and so are the places and velocities of what is tied to a body.
            if each in ("orientations", "angular_velocities") or (tied and each in ("positions", "velocities")):
                np.testing.assert_allclose(new, values, rtol=0.0, atol=1e-14 * max(1.0, np.abs(values).max()))
                continue
            assert np.array_equal(new, values, equal_nan=True), each
    before = written.energy()
    assert abs(replaced.energy().balance - before.balance) <= roundings(before)
    if starts_warm(replaced.scene):
        return
    for run in (written, replaced):
        case.advance(run, STEPS - STEPS // 3)
    if written.state_hash() != replaced.state_hash():
        assert written._world.plan()["systems"][0]["pairs"] > 0 or replaced.scene.fluids, "nothing is listed"
        away, fluids = abs(written.positions - replaced.positions).max(), replaced.scene.fluids
        pulled = PULLED * fluids[0].spacing if fluids and replaced.scene.boundaries else 0.0
        assert away < LISTED * abs(written.positions).max() + pulled


def test_fields_of_grids_go_on() -> None:
    """A wave in a faster medium: the field is the same, and its potential energy is four times as large."""

    def scene(speed: float, cells: tuple[int, int] = (32, 24), name: str | None = "wave") -> pc.Scene:
        grid = pc.Grid(cells, 0.05)
        return pc.Scene(pc.Wave(grid, speed, displacement=lambda x, y: np.exp(-8 * (x**2 + y**2)), name=name))

    simulation = pc.Simulation(scene(1.0), dt=0.005)
    simulation.run(0.3)
    before, field, rate = simulation.energy(), simulation["wave"].displacement, simulation["wave"].rate
    simulation.replace(scene(2.0))
    after = simulation.energy()
    assert np.array_equal(simulation["wave"].displacement, field)
    assert np.array_equal(simulation["wave"].rate, rate)
    assert after.kinetic == before.kinetic
    assert after.potential == pytest.approx(4.0 * before.potential, rel=1e-12)
    assert after.work - before.work == pytest.approx(after.total - before.total, abs=roundings(before, after))
    with pytest.raises(pc.SceneError, match=r"replace\.wave\.displacement: must have the shape \(32, 24\) as before"):
        simulation.replace(scene(1.0, (24, 32)))
    simulation.replace(scene(1.0, (24, 32), "other"))
    assert simulation["other"].displacement.shape == (24, 32)


def test_what_has_left_through_open_edges_goes_on_beyond_them() -> None:
    """A pulse that is halfway through an edge leaves as it would have; in a layer of another width it is cut, and some
    of it comes back.
    """

    def scene(width: int | str = "auto", *more: pc.Wave) -> pc.Scene:
        grid = pc.Grid(200, 0.05)
        layer = pc.Absorbing(width)
        pulse = pc.Wave(
            grid, 1.0, lambda x: np.exp(-8.0 * (x - 8.0) ** 2), edges="absorbing", absorbing=layer, name="pond"
        )
        return pc.Scene(pulse, *more)

    def end(other: pc.Scene | None) -> np.ndarray:
        run = pc.Simulation(scene(), dt=0.025)
        run.run(2.0)
        if other is not None:
            run.replace(other)
        run.run(3.0)
        return run["pond"].displacement

    plain, beside = end(None), pc.Wave(pc.Grid(10, 0.1), 1.0, name="other")
    assert np.abs(end(scene("auto", beside)) - plain).max() < 1e-12
    assert np.abs(end(scene(24)) - plain).max() > 0.01


def test_species_that_are_supplied_by_a_replacement_are_in_their_budgets() -> None:
    """The fields go on, in cells of four times the area: so do the amounts, which are three quarters supplied."""

    def scene(spacing: float, *more: Any) -> pc.Scene:
        start = {"u": 1.0, "v": lambda x, y: 0.5 * np.exp(-50 * ((x - 0.3) ** 2 + (y - 0.3) ** 2))}
        grid = pc.Grid((16, 16), spacing)
        return pc.Scene(pc.ReactionDiffusion(grid, pc.GrayScott(0.03, 0.06), {"u": 1e-4, "v": 5e-5}, start), *more)

    simulation = pc.Simulation(scene(0.04), dt=0.5)
    simulation.run(5.0)
    before = simulation.budgets()
    simulation.replace(scene(0.08, pc.Particles([[0.1, 0.1]])))
    after = simulation.budgets()
    assert after.keys() == before.keys()
    for name, amount in after.items():
        assert amount.total == pytest.approx(4.0 * before[name].total, rel=1e-12)
        assert amount.supplied_by["replacement"] == pytest.approx(3.0 * before[name].total, rel=1e-12)
        assert amount.balance == pytest.approx(before[name].balance, rel=1e-12), name
    simulation.run(5.0)
    for name, amount in simulation.budgets().items():
        assert amount.balance == pytest.approx(before[name].balance, rel=1e-9), name


def test_steps_are_chosen_anew_and_a_given_one_stays() -> None:
    """A stability limit of 2/ω is halved by four times the stiffness."""
    stiff, soft = pc.Scene(net(800.0), pc.Gravity()), pc.Scene(net(), pc.Gravity())
    simulation = running()
    simulation.replace(stiff)
    assert simulation.dt == pytest.approx(pc.Simulation(stiff).dt, rel=0.2)
    assert simulation.dt < 0.6 * pc.Simulation(soft).dt
    simulation.run(0.01)
    assert simulation.plan.notes[-1].startswith("the scene was replaced at 0.1 s")
    fixed = running(dt=1.5e-3)
    with pytest.warns(pc.StabilityWarning, match=r"dt = 0\.0015 s is above"):
        fixed.replace(pc.Scene(net(20_000.0), pc.Gravity()))
    assert fixed.dt == 1.5e-3
    segments = simulation.provenance.segments
    assert [segment.start for segment in segments] == pytest.approx([0.0, 0.1])
    assert sum(segment.steps for segment in segments) == simulation.steps


def test_a_particle_that_is_newly_held_has_the_velocity_that_is_given() -> None:
    loose = running(net(pinned=None), pc.Gravity())
    assert (loose.velocities[:, 1] < 0.0).all()
    moving = loose["net"].velocities
    loose.replace(pc.Scene(net(pinned="top corners"), pc.Gravity()))
    held = loose.scene.bodies[0].fixed
    assert (loose["net"].velocities[held] == 0.0).all()
    assert np.array_equal(loose["net"].velocities[~held], moving[~held])
    place = loose.positions[held]
    loose.run(0.1)
    assert np.array_equal(loose.positions[held], place)


def test_bodies_without_names_are_matched_by_object_and_by_order() -> None:
    one, two = net(name=None), net(name=None, origin=(1.0, 0.0))
    simulation = running(one, two, pc.Gravity())
    places = [simulation[body].positions for body in (one, two)]
    simulation.replace(pc.Scene(two, one, pc.Gravity((0.0, -1.0))))
    assert [np.array_equal(simulation[body].positions, own) for body, own in zip((one, two), places, strict=True)]
    again = [net(name=None, origin=(1.0, 0.0)), net(name=None)]
    simulation.replace(pc.Scene(*again, pc.Gravity()))
    for body, own in zip(again, reversed(places), strict=True):
        assert np.array_equal(simulation[body].positions, own)
    simulation.replace(pc.Scene(again[1], pc.Gravity()))
    assert np.array_equal(simulation.positions, places[0])


GRID = pc.Grid((16, 16), 0.1)
REFUSED: dict[str, tuple[Callable[[], tuple[Any, ...]], str]] = {
    "number": (
        lambda: (pc.cloth((5, 5), 0.05, 200.0, name="net"),),
        r"replace\.bodies\['net'\]\.positions: must be 30 as before, got 25",
    ),
    "dimension": (lambda: (pc.Particles([[0.0, 0.0, 0.0]], name="net"),), r"replace\.scene: must be in 2D"),
    "kind": (
        lambda: (pc.Fluid(pc.block((0, 0), (0.3, 0.25), 0.05), 0.05, name="net"),),
        r"replace\.bodies\['net'\]: is a Fluid, and was a SpringNetwork",
    ),
    "names": (
        lambda: (net(name=None), pc.Particles([[9.0, 9.0]]), net()),
        r"replace\.bodies\[0\]: has no name, and it cannot be told whether it was bodies\[1\]",
    ),
    "system": (lambda: (net(), pc.Wave(GRID, 1.0, name="field")), r"replace\.field: is a Wave, and was a Schrodinger"),
    "boundary": (
        lambda: (net(), pc.Floor(-1e-5)),
        r"replace\.bodies\['net'\]\.positions\[\d+\]: expected a center on the allowed side of boundaries\[0\]",
    ),
    "rods": (lambda: (net(np.inf),), r"rods|stiffness"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_carried_over_is_refused_by_name(name: str) -> None:
    """And the simulation is as before."""
    items, words = REFUSED[name]
    nameless = pc.Particles([[5.0, 5.0]])
    psi = pc.Schrodinger(GRID, pc.wave_packet(GRID, (0.8, 0.8), (1.0, 0.0), 0.2), name="field")
    old = (net(), nameless, psi, pc.Gravity(on="net")) if name != "rods" else (net(), pc.Gravity())
    simulation, plain = (pc.Simulation(pc.Scene(*old), dt=5e-4) for _ in range(2))
    simulation.step(100)
    plain.step(200)
    scene, energy = simulation.scene, simulation.energy()
    with pytest.raises(pc.SceneError, match=words):
        simulation.replace(pc.Scene(*items()))
    assert simulation.scene is scene
    assert vars(simulation.energy()) == vars(energy)
    simulation.step(100)
    assert simulation.state_hash() == plain.state_hash()


@pytest.mark.parametrize("given", [None, 3, net()])
def test_only_scenes_are_taken(given: Any) -> None:
    with pytest.raises(pc.SceneError, match="scene: must be a Scene"):
        running().replace(given)


def test_other_units_are_refused() -> None:
    units = pc.units.system(length=(1e-3, "mm"), time=(1.0, "s"), mass=(1.0, "kg"))
    with pytest.raises(pc.SceneError, match=r"replace\.scene: must have the units"):
        running().replace(pc.Scene(net(), pc.Gravity(), units=units))


def test_a_checkpoint_has_the_new_scene_and_the_whole_budget(tmp_path: Path) -> None:
    simulation = running()
    simulation.replace(pc.Scene(net(800.0), pc.Gravity(), pc.Drag(linear=0.01)))
    simulation.run(0.1)
    simulation.save(tmp_path / "run")
    loaded = pc.load(tmp_path / "run")
    assert isinstance(loaded, pc.Simulation)
    for other in (loaded, copy.copy(simulation)):
        assert other.scene.hash() == simulation.scene.hash()
        assert vars(other.energy()) == vars(simulation.energy())
        assert other.provenance == simulation.provenance
        assert other.plan.notes == simulation.plan.notes
    simulation.run(0.1)
    loaded.run(0.1)
    assert loaded.state_hash() == simulation.state_hash()
    assert vars(loaded.energy()) == vars(simulation.energy())
    loaded.replace(pc.Scene(net(), pc.Gravity()))
    simulation.replace(pc.Scene(net(), pc.Gravity()))
    assert vars(loaded.energy()) == vars(simulation.energy())


def test_frames_do_not_go_on_and_recordings_begin_anew() -> None:
    simulation = running()
    frames = simulation.frames(1.0)
    next(frames)
    simulation.replace(pc.Scene(net(800.0), pc.Gravity()))
    with pytest.raises(pc.PhyscoreError, match="the scene of this simulation was replaced between two of its frames"):
        next(frames)
    energy = simulation.energy()
    recording = simulation.record(0.2)
    assert recording.scene is simulation.scene
    assert recording.times[0] == pytest.approx(0.1)
    assert recording.energy.work[0] == energy.work
    assert abs(recording.energy.drift).max() < 1e-3


def test_events_are_found_in_the_new_scene() -> None:
    """A ball that falls from 1 m crosses 0 after √(2/g); under a quarter of the weight from 0.2 s on it is later."""

    def scene(pull: float) -> pc.Scene:
        return pc.Scene(pc.Particles([[0.0, 1.0]], name="ball"), pc.Gravity((0.0, -pull)))

    event = pc.Event.crossing("ball", "y", 0.0)
    simulation = pc.Simulation(scene(9.81))
    simulation.run(0.2, events=[event])
    simulation.replace(scene(9.81 / 4))
    height, speed = 1.0 - 0.5 * 9.81 * 0.04, 9.81 * 0.2
    later = 0.2 + (np.sqrt(speed**2 + 2 * 9.81 / 4 * height) - speed) / (9.81 / 4)
    simulation.run(1.0, events=[event])
    assert simulation.events[0].times == pytest.approx([later], rel=1e-9)


def test_a_scene_is_not_replaced_while_it_steps() -> None:
    runs: list[pc.Simulation] = []

    def replacing(time: float, positions: np.ndarray, velocities: np.ndarray) -> np.ndarray:
        for run in runs:
            run.replace(pc.Scene(net(), pc.Gravity()))
        return np.zeros_like(positions)

    runs.append(pc.Simulation(pc.Scene(net(), pc.CustomForce(replacing)), dt=1e-3))
    with pytest.raises(pc.PhyscoreError, match="this simulation is running"):
        runs[0].step()


def test_water_goes_on_with_its_densities() -> None:
    """Half of a collapsing column's internal energy is lost where densities begin at rest; here the flow goes on."""

    def scene(pull: float, *more: Any) -> pc.Scene:
        water = pc.Fluid(pc.block((0.0, 0.0), (0.3, 0.6), 0.05), 0.05, name="water")
        return pc.Scene(*more, water, pc.Box((0.0, 0.0), (1.0, 1.0)), pc.Gravity((0.0, -pull)))

    simulation = pc.Simulation(scene(9.81), fluids=pc.WeaklyCompressible(sound_speed=40.0))
    simulation.run(0.2)
    before, energy = simulation["water"], simulation.energy()
    assert np.ptp(before.densities) > 1.0
    simulation.replace(scene(9.81 / 6, pc.Particles([[0.8, 0.8]], name="ball")))
    after = simulation["water"]
    assert np.array_equal(after.densities, before.densities)
    assert np.array_equal(after.positions, before.positions)
    assert simulation.energy().internal == pytest.approx(energy.internal, rel=1e-12)
    assert simulation.energy().dissipated == energy.dissipated
    simulation.run(0.1)
    assert simulation["ball"].positions[0, 1] == pytest.approx(0.8 - 0.5 * 9.81 / 6 * 0.1**2, abs=1e-5)


def test_broken_springs_stay_broken() -> None:
    """A rope that is overloaded tears at its top; under less weight it does not heal."""

    def scene(pull: float, strain: float | None = 0.05, name: str = "rope", count: int = 6) -> pc.Scene:
        rope = pc.rope(count, 1.0, 50.0, 0.05, mass=0.1, pinned="start", direction=(0.0, -1.0), name=name)
        torn = {} if strain is None else {"breaking_strain": strain}
        body = pc.SpringNetwork(
            rope.positions, rope.pairs, rope.stiffness, rope.damping, rope.rest_length, rope.mass, fixed=rope.fixed,
            name=name, **torn,
        )  # fmt: skip
        other = pc.rope(4, 1.0, 50.0, mass=0.1, start=(2.0, 0.0), name="other")
        return pc.Scene(other, body, pc.Gravity((0.0, -pull)))

    simulation = pc.Simulation(scene(9.81))
    simulation.run(0.3)
    broken, energy = simulation["rope"].broken, simulation.energy()
    assert broken.any()
    assert not broken.all()
    simulation.replace(scene(1.0))
    assert np.array_equal(simulation["rope"].broken, broken)
    assert simulation.energy().dissipated_by == energy.dissipated_by
    simulation.run(0.1)
    assert (simulation["rope"].broken >= broken).all()
    with pytest.raises(pc.SceneError, match=r"replace\.bodies\['rope'\]\.breaking_strain: must be given as before"):
        simulation.replace(scene(1.0, None))
    whole = scene(1.0, name="new")
    simulation.replace(whole)
    assert not simulation["new"].broken.any()


def test_beads_go_on_along_their_wire() -> None:
    """On a line that slopes by 45°, with a = g/√2 along it before and half of that after: s = a t²/2 and so on."""
    slope = np.array([1.0, -1.0]) / np.sqrt(2.0)

    def scene(pull: float) -> pc.Scene:
        bead = pc.Particles([0.5 * slope], mass=0.2, name="bead")
        line = pc.Wire(np.outer(np.linspace(0.0, 4.0, 5), slope), on=bead)
        return pc.Scene(bead, line, pc.Gravity((0.0, -pull)))

    simulation = pc.Simulation(scene(10.0), dt=1e-3)
    simulation.run(0.4)
    before, position, velocity = simulation.energy(), simulation.positions, simulation.velocities
    simulation.replace(scene(5.0))
    after = simulation.energy()
    # The bead is put on the wire, to the rounding of its place.
    assert simulation.positions == pytest.approx(position, abs=1e-14)
    assert simulation.velocities == pytest.approx(velocity, abs=1e-14)
    assert abs(after.balance - before.balance) <= roundings(before, after)
    simulation.run(0.4)
    first, second = 10.0 / np.sqrt(2.0), 5.0 / np.sqrt(2.0)
    along = 0.5 + 0.5 * first * 0.4**2 + first * 0.4 * 0.4 + 0.5 * second * 0.4**2
    assert simulation.positions[0] == pytest.approx(along * slope, abs=1e-6)
