"""Contact of meshes: nothing passes through, momentum and budget are kept, impulses and friction follow theory."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import physcore as pc
from physics.crossings import crossings, mesh
from physics.laboratory import LONG

METHODS: list[pc.Integrator] = [
    pc.VelocityVerlet(),
    pc.BackwardEuler(),
    pc.BDF2(),
    pc.XPBD(4, 2),
    pc.ProjectiveDynamics(8),
]
IDS = [type(method).__name__ for method in METHODS]
LEVEL = ((1, 0, 0), (0, 1, 0))


def triangle(size: float = 0.1, height: float = 0.0, tip: bool = False, **more: Any) -> pc.SpringNetwork:
    """Three masses of 1 kg on springs so soft that they do nothing; its center, or its tip, is on the z axis."""
    angles = 2.0 * np.pi * np.arange(3) / 3.0 + 0.1
    points = size * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(3)])
    if tip:
        points = (points - points[0])[:, [1, 2, 0]]
        points *= np.sign(points[1, 2])
    values: dict[str, Any] = {"stiffness": 0.1, "faces": [[0, 1, 2]], **more}
    return pc.SpringNetwork(np.add(points, (0.0, 0.0, height)), [[0, 1], [1, 2], [0, 2]], **values)


def thrown(rng: np.random.Generator, spacing: float) -> pc.SpringNetwork:
    """A bent cloth in any position, which flies down at about 4 m/s and turns."""
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0][:2].tolist()
    cloth = pc.cloth(tuple(rng.integers(5, 9, 2)), spacing, 100.0, 0.02, mass=0.002, origin=(0.0, 0.0, 0.0), axes=axes)
    sites = cloth.positions - cloth.positions.mean(axis=0)
    sites = sites + np.outer(0.1 * spacing * np.sin(sites @ rng.normal(0.0, 10.0, 3)), np.cross(*axes))
    return pc.SpringNetwork(
        np.add(sites, (0.0, 0.0, 0.75)),
        cloth.pairs,
        100.0,
        0.02,
        mass=0.002,
        velocities=rng.normal(0.0, 1.0, 3) + np.cross(rng.normal(0.0, 8.0, 3), sites) + (0.0, 0.0, -4.0),
        faces=cloth.faces,
    )


def drop(seed: int) -> tuple[pc.Scene, list[pc.SpringNetwork], dict[str, Any]]:
    """A cloth that is thrown at another one, at a block of jelly, at a rope, or at a fixed sheet, above an obstacle on
    a floor; and the numerics. Every method meets every body, and every obstacle in either precision.
    """
    rng = np.random.default_rng(seed)
    spacing = 0.05
    cloth = thrown(rng, spacing)
    others = [
        lambda: pc.cloth((6, 5), 0.06, 100.0, 0.02, mass=0.002, origin=(-0.15, -0.12, 0.4), axes=LEVEL),
        lambda: pc.soft_body((4, 3, 3), 0.07, 100.0, 0.02, mass=0.004, origin=(-0.1, -0.07, 0.25)),
        lambda: pc.rope(9, 0.4, 100.0, 0.02, 0.004, (-0.2, 0.02, 0.4), (0.99, -0.1, 0.02), pinned="both"),
        lambda: pc.cloth((4, 4), 0.06, 100.0, 0.02, origin=(-0.07, -0.08, 0.4), axes=LEVEL, pinned=range(16)),
    ]
    obstacles = [
        lambda **contact: pc.Sphere((0.02, 0.01, 0.05), 0.1, **contact),
        lambda **contact: pc.Box((-0.08, -0.06, 0.0), (0.05, 0.09, 0.14), inside=False, **contact),
        lambda **contact: pc.Capsule((-0.1, -0.03, 0.08), (0.12, 0.04, 0.12), 0.04, **contact),
    ]
    other = others[seed % len(others)]()
    touch = pc.SelfContact(
        cloth,
        spacing * rng.uniform(0.1, 0.6),
        friction=rng.choice([0.0, 0.3]),
        restitution=rng.choice([0.0, 0.5, 1.0]),
        on=other,
    )
    scene = pc.Scene(
        cloth,
        other,
        touch,
        pc.SelfContact(other, touch.thickness),
        pc.Gravity((0.0, 0.0, -9.81)),
        pc.Floor(0.0, restitution=rng.choice([0.0, 0.7]), friction=0.3),
        obstacles[seed % len(obstacles)](restitution=0.3, friction=rng.choice([0.0, 0.5]), on=cloth),
    )
    method = METHODS[seed // len(others) % len(METHODS)]
    # Steps of half a frame but for Verlet.
    dt = pc.AutoStep() if isinstance(method, pc.VelocityVerlet) else 1.0 / 60.0
    return scene, [cloth, other], {"integrator": method, "dt": dt, "precision": "f32" if seed % 7 % 2 else "f64"}


# Impacts that explicit steps at half of their limit resolve to several percent, with the square of the step.
@pytest.mark.filterwarnings("ignore:the energy balance drifted")
@pytest.mark.parametrize("seed", range(1000 if LONG else 40))
def test_nothing_passes_through(seed: int):
    """Edges and triangles of every frame, in exact arithmetic."""
    scene, bodies, numerics = drop(seed)
    recording = pc.simulate(scene, 0.6, fps=30, **numerics)
    edges, faces = mesh(*bodies)
    assert [crossings(frame, edges, faces) for frame in recording.positions] == [0] * len(recording.times)
    assert np.isfinite(recording.energy.balance).all()


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("integrator", METHODS, ids=IDS)
def test_a_contact_takes_the_energy_of_its_restitution(integrator: pc.Integrator, precision: str):
    """A tip meets the middle of a triangle at 1 m/s: 1/m* = 1 + 3 (1/3)² = 4/3 per kg, and ½ m* (1 − e²) v² is lost."""
    for restitution in (0.0, 0.5, 1.0):
        plate, point = triangle(), triangle(height=0.05, tip=True, velocities=(0.0, 0.0, -1.0))
        scene = pc.Scene(plate, point, pc.SelfContact(plate, 0.01, restitution=restitution, on=point))
        options: Any = {"dt": 1e-3, "integrator": integrator, "precision": precision}
        simulation = pc.Simulation(scene, **options)
        simulation.run(0.06)
        relative = simulation[point].velocities[0, 2] - simulation[plate].velocities[:, 2].mean()
        assert relative == pytest.approx(restitution, abs=2e-3)
        # The iteration ends at a thousandth of the velocity; f32 keeps 7 digits of 1.5 J.
        assert simulation.energy().dissipated == pytest.approx(0.375 * (1.0 - restitution**2), abs=1e-3)
        assert simulation.energy().balance == pytest.approx(1.5, abs=1e-5)
        # In f32 each of 240 substeps rounds velocities of 1 m/s, of three particles, by up to 6e-8.
        assert np.abs(simulation.momentum() - (0.0, 0.0, -3.0)).max() < (1e-5 if precision == "f64" else 4.5e-5)


def test_contacts_keep_momentum_and_angular_momentum():
    """Impulses between closest points, a distance apart along the normal: without friction no moment is left over, but
    for what a contact that is found on the way turns before it acts.
    """
    one = pc.cloth((7, 7), 0.05, 200.0, mass=0.002, origin=(0.0, 0.0, 0.0), axes=LEVEL)
    other = pc.cloth(
        (5, 5),
        0.045,
        200.0,
        mass=0.003,
        origin=(0.07, 0.05, 0.05),
        axes=((0.96, 0.0, 0.28), (0.0, 1.0, 0.0)),
        velocities=(0.5, 0.0, -3.0),
    )
    recording = pc.simulate(pc.Scene(one, other, pc.SelfContact(one, 0.01, on=other)), 0.1, fps=60)
    energy = recording.energy
    assert energy.dissipated[-1] > 0.1 * energy.kinetic[0]
    assert np.abs(recording.momentum - recording.momentum[0]).max() < 1e-14
    size = np.abs(recording.angular_momentum).max()
    assert np.abs(recording.angular_momentum - recording.angular_momentum[0]).max() < 2e-3 * size
    assert np.abs(energy.drift).max() < 2e-3


def test_friction_is_coulombs():
    """A triangle on a fixed one loses μ g t of its speed, and stands still from v/(μ g) on: within a step of 1e-3 s."""
    friction, speed = 0.25, 1.0
    ground = triangle(size=2.0, fixed=[0, 1, 2])
    for method in (pc.VelocityVerlet(), pc.XPBD(1, 1)):
        slider = triangle(size=0.05, height=0.01, stiffness=1e4, damping=10.0, velocities=(speed, 0.0, 0.0))
        touch = pc.SelfContact(ground, 0.01, friction=friction, on=slider)
        simulation = pc.Simulation(
            pc.Scene(ground, slider, touch, pc.Gravity((0.0, 0.0, -9.81))), dt=1e-3, integrator=method
        )
        simulation.run(0.2)
        assert simulation[slider].velocities[:, 0].mean() == pytest.approx(speed - friction * 9.81 * 0.2, abs=5e-3)
        simulation.run(0.4)
        assert np.abs(simulation[slider].velocities).max() < 0.02
        assert simulation.energy().dissipated == pytest.approx(1.5 * speed**2, rel=0.02)


@pytest.mark.parametrize(("slope", "friction"), [(0.3, 0.5), (0.8, 0.5), (0.8, 0.25)])
def test_layers_slide_on_a_wall_as_one(slope: float, friction: float):
    """Two sheets on a plane of slope tan θ: they stick where it is below the friction of the wall, and slide with the
    acceleration g (sin θ − μ cos θ) above it. The wall meets the momentum of the lower sheet first and what the upper
    one presses with in the contacts, so that only the sum of both is the load. Within a step of 1/240 s.
    """
    thickness, h, duration = 0.01, 1.0 / 240.0, 0.4
    below, above = (
        pc.cloth((4, 4), 0.05, 200.0, 0.05, mass=0.002, origin=(0.011 * k, 0.006 * k, thickness * k), axes=LEVEL)
        for k in range(2)
    )
    across = 9.81 / np.hypot(1.0, slope)
    scene = pc.Scene(
        below,
        above,
        pc.Gravity((slope * across, 0.0, -across)),
        pc.Floor(0.0, restitution=0.0, friction=friction),
        pc.SelfContact(below, thickness, friction=1.0, on=above),
    )
    simulation = pc.Simulation(scene, pc.XPBD(1, 10), dt=h)
    start = simulation.positions.copy()
    simulation.run(duration)
    acceleration = max(across * (slope - friction), 0.0)
    moved = (simulation.positions - start)[:, 0].mean()
    assert moved == pytest.approx(0.5 * acceleration * duration**2, abs=2.0 * 9.81 * h * duration * 0.5)
    assert simulation.velocities[:, 0].mean() == pytest.approx(acceleration * duration, abs=3.0 * 9.81 * h)


@pytest.mark.parametrize(
    "integrator", [pc.VelocityVerlet(), pc.BackwardEuler(), pc.XPBD(2, 4)], ids=lambda m: type(m).__name__
)
def test_a_stack_comes_to_rest_and_does_not_creep(integrator: pc.Integrator):
    """Four sheets that fall a little, on a floor with friction: in the last second they neither move nor sink. Gravity
    gives g h in a step, which contacts take to the tolerance of their iteration.
    """
    thickness, h = 0.01, 1e-3
    sheets = [
        pc.cloth((4, 4), 0.05, 100.0, 0.1, mass=0.002, origin=(0.004 * k, 0.003 * k, 1.2 * thickness * k), axes=LEVEL)
        for k in range(4)
    ]
    pairs = [pc.SelfContact(one, thickness, 0.5, on=sheets[k + 1 : k + 2]) for k, one in enumerate(sheets)]
    scene = pc.Scene(
        *sheets,
        *pairs,
        pc.Floor(0.0, restitution=0.0, friction=0.5),
        pc.Gravity((0.0, 0.0, -9.81)),
        pc.Drag(2e-3),
    )
    simulation = pc.Simulation(scene, integrator, dt=h)
    simulation.run(1.0)
    start, kinetic = simulation.positions.copy(), 0.5 * 64 * 0.002 * (9.81 * h) ** 2
    simulation.run(1.0)
    assert np.abs(simulation.positions - start).max() < 0.05 * thickness
    assert simulation.energy().kinetic < 0.3 * kinetic


@pytest.mark.parametrize("wall", [True, False], ids=["wall", "sheet"])
def test_impacts_of_several_bodies_give_no_energy(wall: bool):
    """A heavy triangle strikes the tip of a light one before a wall, or a fixed sheet, with restitution 1."""
    light = triangle(size=0.01, height=0.012, tip=True, mass=0.01)
    heavy = triangle(height=0.06, velocities=(0.0, 0.0, -2.0), mass=1.0)
    ground: list[Any] = [pc.Floor(0.0, restitution=1.0)]
    touch = [pc.SelfContact(heavy, 0.01, restitution=1.0, on=light)]
    if not wall:
        sheet = triangle(size=1.0, fixed=[0, 1, 2])
        ground, touch = [sheet], [*touch, pc.SelfContact(sheet, 0.01, restitution=1.0, on=[light, heavy])]
    simulation = pc.Simulation(pc.Scene(light, heavy, *ground, *touch), pc.XPBD(1, 2), dt=1e-3)
    total = simulation.energy().total
    for _ in range(60):
        simulation.run(1e-3)
        assert simulation.energy().total <= total * (1.0 + 1e-5)  # springs of 0.1 N/m, XPBD, rounding of the iteration
        assert simulation.energy().dissipated >= -1e-5 * total


@pytest.mark.parametrize("integrator", METHODS, ids=IDS)
def test_layers_at_rest_stay_at_rest(integrator: pc.Integrator):
    """Three sheets, a thickness apart, on a floor: they move by no more than what gravity gives in a step, g h²."""
    thickness, h = 0.01, 2e-3
    sheets = [
        pc.cloth((5, 4), 0.05, 100.0, 0.05, mass=0.002, origin=(0.013 * k, 0.007 * k, thickness * (k + 1)), axes=LEVEL)
        for k in range(3)
    ]
    pairs = [pc.SelfContact(one, thickness, on=sheets[k + 1 : k + 2]) for k, one in enumerate(sheets)]
    floor = pc.Floor(thickness, restitution=0.0)
    simulation = pc.Simulation(
        pc.Scene(*sheets, *pairs, floor, pc.Gravity((0.0, 0.0, -9.81))), dt=h, integrator=integrator
    )
    start = simulation.positions.copy()
    simulation.run(0.5)
    # Where a vertex of one sheet is beside the other, nothing holds it but its springs: these corners hang a little.
    inside = np.abs(simulation.positions - start)[:20, 2]
    assert inside.max() <= 2.0 * 9.81 * h**2
    assert np.abs(simulation.positions - start)[:, 2].max() < 0.3 * thickness
    # Verlet's velocity at the end of a step has half a kick of gravity in it.
    assert simulation.energy().kinetic < 0.06 * (9.81 * h) ** 2


def test_ropes_cross_without_passing():
    """Two ropes, edge against edge: the one that falls hangs over the one that is held."""
    held = pc.rope(12, 1.0, 400.0, 0.05, 0.01, (-0.5, 0.0, 0.0), (1.0, 0.0, 0.0), pinned="both")
    falling = pc.rope(12, 1.0, 400.0, 0.05, 0.01, (0.03, -0.5, 0.1), (0.02, 1.0, 0.0))
    scene = pc.Scene(
        held, falling, pc.Gravity((0, 0, -9.81)), pc.Drag(0.02), pc.SelfContact(held, 0.02, 1.0, on=falling)
    )
    simulation = pc.Simulation(scene)
    simulation.run(0.5)
    over, under = simulation[falling].positions, simulation[held].positions
    assert over[:, 2].max() > under[:, 2].min() > -0.5


def test_what_is_torn_lets_pass():
    """A sheet whose springs all break at once stops nothing; one that holds does."""
    for strain, passes in ((0.001, True), (np.inf, False)):
        sheet = pc.cloth((5, 5), 0.1, 100.0, mass=0.01, origin=(0.0, 0.0, 0.0), axes=LEVEL, breaking_strain=strain)
        wide = pc.SpringNetwork(
            sheet.positions,
            sheet.pairs,
            100.0,
            rest_length=sheet.rest_length * 0.9,
            mass=0.01,
            fixed=np.arange(25),
            faces=sheet.faces,
            breaking_strain=sheet.breaking_strain,
        )
        points = np.add(triangle(size=0.05, height=0.1).positions, (0.22, 0.21, 0.0))
        ball = pc.SpringNetwork(points, [[0, 1], [1, 2], [0, 2]], 1.0, mass=0.01, velocities=(0.0, 0.0, -2.0))
        simulation = pc.Simulation(pc.Scene(wide, ball, pc.SelfContact(wide, 0.02, on=ball)), dt=1e-3)
        simulation.run(0.15)
        assert (simulation[ball].positions[:, 2].max() < -0.1) == passes


@pytest.mark.parametrize("values", [{"thickness": 0.0}, {"thickness": 0.06}, {"friction": -1.0}, {"restitution": 1.5}])
def test_a_value_out_of_range_is_named(values: dict[str, float]):
    with pytest.raises(pc.SceneError, match=rf"SelfContact\.{next(iter(values))}: "):
        pc.SelfContact(pc.cloth((3, 3), 0.05, 1.0, origin=(0, 0, 0)), **{"thickness": 0.01, **values})


def test_what_has_no_surface_is_refused():
    cloth = pc.cloth((3, 3), 0.05, 1.0, origin=(0, 0, 0))
    with pytest.raises(pc.SceneError, match=r"SelfContact\.body: must be a SpringNetwork in 3D with springs"):
        pc.SelfContact(pc.Particles([[0.0, 0.0, 0.0]]), 0.01)
    with pytest.raises(pc.SceneError, match=r"SelfContact\.body: must be a SpringNetwork in 3D with springs"):
        pc.SelfContact(pc.cloth((3, 3), 0.05, 1.0), 0.01)
    with pytest.raises(pc.SceneError, match=r"SelfContact\.body: must have faces with an area"):
        pc.SelfContact(pc.SpringNetwork(np.outer(range(3), (1, 0, 0)), [[0, 1]], 1.0, faces=[[0, 1, 2]]), 0.01)
    with pytest.raises(pc.SceneError, match=r"SelfContact\.on: must be other bodies"):
        pc.SelfContact(cloth, 0.01, on=cloth)


def test_what_an_engine_cannot_do_is_said():
    cloth = pc.cloth((3, 3), 0.05, 1.0, origin=(0, 0, 0))
    touch = pc.SelfContact(cloth, 0.01)
    for method in (pc.RungeKutta4(), pc.ImplicitMidpoint()):
        with pytest.raises(pc.SceneError, match=r"integrator: expected VelocityVerlet\(\), .* for SelfContact"):
            pc.Simulation(pc.Scene(cloth, touch), integrator=method)
    with pytest.raises(pc.SceneError, match=r"constraints\[0\].*no Periodic domain"):
        pc.Simulation(pc.Scene(cloth, touch, pc.Periodic((-1, -1, -1), (1, 1, 1))))
    with pytest.raises(pc.SceneError, match="one SelfContact for two bodies"):
        pc.Simulation(pc.Scene(cloth, touch, touch))


def test_bodies_that_cross_at_the_start_are_refused():
    plate, needle = triangle(), triangle(height=-0.05, tip=True)
    with pytest.raises(pc.SceneError, match=r"the edge between the particles 3 and [45] in a triangle"):
        pc.Simulation(pc.Scene(plate, needle, pc.SelfContact(plate, 0.01, on=needle)))


def test_what_is_driven_through_is_an_error():
    """Fixed particles keep their velocities, and so pass through each other: the run ends before they do."""
    plate = triangle(fixed=[0, 1, 2])
    needle = triangle(height=0.05, tip=True, fixed=[0, 1, 2], velocities=(0.0, 0.0, -1.0))
    simulation = pc.Simulation(pc.Scene(plate, needle, pc.SelfContact(plate, 0.01, on=needle)), dt=1e-3)
    with pytest.raises(pc.SimulationDiverged, match="passes through others"):
        simulation.run(0.1)
    edges, faces = mesh(plate, needle)
    assert crossings(simulation.positions, edges, faces) == 0
