"""The registry of scenes that every contract is tested on: a small one of every kind, with its numerics.

A system, force or method joins all contracts by one entry in `SCENES`.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

import physcore as pc
from contracts import rigid_scenes
from physcore.integrators import INTEGRATORS
from physcore.systems.kinetics import Kinetics

STEPS = 60
"""Steps that a contract takes where the number does not matter: several chunks, and some rebuilt neighbor lists."""


@dataclass(frozen=True)
class Case:
    """A scene, the numerics that it is computed with, and the time step [s]."""

    scene: Callable[[], pc.Scene]
    dt: float
    numerics: dict[str, Any] = field(default_factory=dict)
    large: Callable[[], pc.Scene] | None = None
    """The same kind of scene with so much work in a step that threads share it; None: another case has it."""

    @cached_property
    def shared(self) -> pc.Scene:
        """Its scene, built once for all tests: scenes never change."""
        return self.scene()

    @property
    def adaptive(self) -> bool:
        """Whether its steps follow the motion."""
        return isinstance(self.numerics.get("dt"), pc.AdaptiveStep) or (
            self.is_self_adaptive and isinstance(self.numerics.get("dt"), pc.AutoStep)
        )

    @property
    def is_self_adaptive(self) -> bool:
        """Whether its integrator chooses the steps itself with dt="auto"."""
        return isinstance(self.numerics.get("integrator"), pc.GaussRadau15)

    @property
    def is_double(self) -> bool:
        """Whether it is refused in single precision."""
        return isinstance(self.numerics.get("integrator"), pc.GaussRadau15)

    @property
    def duration(self) -> float:
        """The duration of `STEPS` steps [s]."""
        return STEPS * self.dt

    def simulation(self, scene: pc.Scene | None = None, **changes: Any) -> pc.Simulation:
        """A simulation of it, or of another scene with its numerics."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", pc.StabilityWarning)
            return pc.Simulation(scene or self.shared, **{"dt": self.dt, **self.numerics, **changes})

    def advance(self, run: pc.Simulation, steps: int = STEPS) -> pc.Simulation:
        """Take so many steps, or as long as they would take where steps follow the motion."""
        if self.adaptive:
            run.run(steps * self.dt)
        else:
            run.step(steps)
        return run


def _random() -> np.random.Generator:
    return np.random.default_rng(20)


def _rounded(values: np.ndarray) -> np.ndarray:
    """To 24 binary digits after the point: the last bits of NumPy's exponentials and powers depend on the CPU."""
    return np.round(2.0**24 * values) / 2.0**24


def network(dimension: int = 2, side: int = 5) -> pc.Scene:
    """A shuffled net of damped springs, one end held, under gravity."""
    rng = _random()
    sites = np.stack(np.meshgrid(*[np.arange(side)] * dimension, indexing="ij"), -1).reshape(-1, dimension)
    positions = sites + rng.uniform(-0.1, 0.1, sites.shape)
    grid = np.arange(len(sites)).reshape((side,) * dimension)
    ends = [(np.delete(grid, -1, axis).ravel(), np.delete(grid, 0, axis).ravel()) for axis in range(dimension)]
    near = np.array(sorted(pair for first, second in ends for pair in zip(first, second, strict=True)))
    body = pc.SpringNetwork(
        positions,
        rng.permutation(near),
        rng.uniform(10.0, 100.0, len(near)),
        0.3,
        mass=rng.uniform(0.5, 2.0, len(sites)),
        velocities=rng.uniform(-0.3, 0.3, sites.shape),
        fixed=[0],
    )
    return pc.Scene(body, pc.Gravity(-np.eye(dimension)[-1]))


def cloth(shape: tuple[int, int] = (12, 9)) -> pc.Scene:
    """A sheet whose springs run as a stencil, falling on a ball with friction."""
    sheet = pc.cloth(shape, 0.1, 200.0, 0.05, mass=0.01, origin=(-0.55, -0.4, 0.0), pinned="top corners")
    ground = pc.Sphere((0.0, 0.0, -0.43), 0.4, inside=False, restitution=0.2, friction=0.3)
    return pc.Scene(sheet, pc.Gravity((0.0, 0.0, -9.81)), pc.Drag(0.001), ground)


def torn(side: int = 9) -> pc.Scene:
    """A sheet in the plane that is pulled apart, so that its springs break from the third step on."""
    sheet = pc.cloth((side, side), 0.1, 100.0, 0.02, mass=0.01)
    sites = sheet.positions - sheet.positions.mean(axis=0)
    body = pc.SpringNetwork(
        sheet.positions,
        sheet.pairs,
        sheet.stiffness,
        sheet.damping,
        mass=0.01,
        velocities=sites[:, :1] * [0.4, 1.0] + sites[:, 1:] * [0.3, 9.0],
        fixed=[0],
        breaking_strain=_random().uniform(0.02, 0.12, len(sheet.pairs)),
    )
    return pc.Scene(body, pc.Gravity((0.0, -9.81)))


def shell(shape: tuple[int, int] = (8, 6)) -> pc.Scene:
    """A dented sheet, held at two corners, that springs and the angles between its faces hold in shape."""
    rng = _random()
    sheet = pc.cloth(shape, 0.1, 1.0, origin=(-0.35, -0.25, 0.0))
    dented = sheet.positions + rng.uniform(-0.02, 0.02, sheet.positions.shape)
    body = pc.SpringNetwork(
        dented,
        sheet.pairs,
        rng.uniform(20.0, 50.0, len(sheet.pairs)),
        0.02,
        mass=rng.uniform(0.005, 0.015, len(sheet)),
        fixed=[0, shape[0] - 1],
        velocities=rng.uniform(-0.5, 0.5, dented.shape),
        faces=sheet.faces,
    )
    return pc.Scene(body, pc.Dihedral(body, 0.02, 1e-4), pc.Gravity((0.0, 0.0, -9.81)))


def flag(shape: tuple[int, int] = (8, 6)) -> pc.Scene:
    """The same sheet in the wind, without resistance to bending."""
    (body,) = shell(shape).bodies
    return pc.Scene(body, pc.Wind((3.0, -2.0, 4.0), 1.2, tangential=0.1), pc.Gravity((0.0, 0.0, -9.81)))


def strings(shape: tuple[int, int] = (7, 6)) -> pc.Scene:
    """A soft sheet that swings between its upper corners, at its longest in many places."""
    sheet = pc.cloth(shape, 0.1, 20.0, 0.02, mass=0.01, origin=(0.0, 0.0, 0.0), pinned="top corners", strain_limit=0.02)
    velocities = _random().uniform(-0.5, 0.5, (len(sheet), 3)) * ~sheet.fixed[:, None]
    body = pc.SpringNetwork(
        sheet.positions,
        sheet.pairs,
        sheet.stiffness,
        sheet.damping,
        sheet.rest_length,
        sheet.mass,
        fixed=sheet.fixed,
        velocities=velocities,
        strain_limit=sheet.strain_limit,
    )
    return pc.Scene(body, pc.Gravity((0.0, -9.81, 0.0)))


def sheets(shape: tuple[int, int] = (7, 6)) -> pc.Scene:
    """A dented sheet that falls on another one, held at three corners, with friction, and bounces a little."""
    rng = _random()
    width, depth = shape
    across = np.array([0.8, 0.36, 0.48]), np.array([-0.6, 0.48, 0.64])
    bodies = []
    for height, turn, speed in ((0.0, 1.0, 0.0), (0.06, 0.83, -1.5)):
        sheet = pc.cloth(shape, 0.1 * turn, 40.0, 0.02, mass=0.01, origin=(0.0, 0.0, 0.0), axes=across)
        normal = np.cross(*across)
        dents = rng.uniform(-0.01, 0.01, sheet.positions.shape)
        x = sheet.positions - sheet.positions.mean(axis=0) + dents + height * normal
        mass = rng.uniform(0.005, 0.015, len(sheet))
        fixed = [] if speed else [0, width - 1, width * (depth - 1)]
        body = pc.SpringNetwork(
            x, sheet.pairs, 40.0, 0.02, mass=mass, velocities=speed * normal, fixed=fixed, faces=sheet.faces
        )
        bodies.append(body)
    held, falling = bodies
    touch = pc.SelfContact(falling, 0.03, friction=0.3, restitution=0.4, on=held)
    return pc.Scene(held, falling, pc.Gravity((-2.0, 1.0, -9.0)), touch)


def wires(dimension: int = 2, friction: float = 0.0) -> pc.Scene:
    """Beads on a closed and an open wire, one of each held by a spring to the other, with drag and gravity."""
    turn = 2.0 * np.pi * np.arange(12) / 12.0
    ring = np.zeros((12, dimension))
    ring[:, 0], ring[:, -1] = _rounded(np.cos(turn)), _rounded(0.75 * np.sin(turn))
    bend = np.zeros((9, dimension))
    bend[:, 0] = 0.25 * np.arange(9) - 0.5
    bend[:, -1] = _rounded(0.125 * np.arange(9) * np.arange(-8, 1) / 4.0) - 1.0
    places = np.concatenate([ring[[0, 3, 7]], bend[[2, 5]]])
    masses = [0.5, 1.0, 2.0, 1.0, 0.5]
    beads = pc.SpringNetwork(places, [[0, 3], [1, 2]], 6.0, 0.1, rest_length=0.5, mass=masses)
    closed = pc.Wire(ring, on=(beads, [0, 1, 2]), closed=True, friction=friction)
    open_ = pc.Wire(bend, on=(beads, [3, 4]), friction=friction)
    down = -4.0 * np.eye(dimension)[-1]
    return pc.Scene(beads, closed, open_, pc.Gravity(down), pc.Drag(0.05, on=beads))


def chain(links: int = 12, dimension: int = 2) -> pc.Scene:
    """A chain of rods with a heavy end, and a loose one that two springs tie to it, with drag."""
    nodes = np.zeros((links + 2, dimension))
    nodes[:, 0] = 0.1 * np.arange(links + 2)
    nodes[-2] += 0.1 * np.eye(dimension)[-1] - 0.1 * np.eye(dimension)[0]
    nodes[1:, -1] += _rounded(0.02 * np.arange(1, links + 2) ** 1.5)
    ends = np.arange(links + 1)
    body = pc.SpringNetwork(
        nodes,
        [*np.column_stack([ends, ends + 1]), [links - 1, links + 1]],
        [*[np.inf] * (links - 1), np.inf, 20.0, 30.0],
        0.05,
        mass=[*[0.1] * links, 1.0, 0.3],
        fixed=[0],
    )
    return pc.Scene(body, pc.Gravity(-9.81 * np.eye(dimension)[-1]), pc.Drag(0.02))


def dropped(links: int = 6, dimension: int = 2) -> pc.Scene:
    """A chain of rods, not in line, that falls on a floor beside a loose ball and bounces."""
    nodes = np.zeros((links + 1, dimension))
    nodes[:, 0] = 0.1 * np.arange(links + 1)
    nodes[:, -1] = _rounded(0.08 + 0.03 * np.cos(1.7 * np.arange(links + 1)))
    ends = np.arange(links)
    body = pc.SpringNetwork(nodes, np.column_stack([ends, ends + 1]), np.inf, mass=0.1 + 0.02 * ends.sum() / links)
    ball = pc.Particles([[-0.2] * (dimension - 1) + [0.05]], radius=0.02)
    return pc.Scene(body, ball, pc.Gravity(-9.81 * np.eye(dimension)[-1]), pc.Floor(restitution=0.5))


def truss(side: int = 3) -> pc.Scene:
    """A braced box of rods in space, of which many are redundant, that turns."""
    nodes = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), -1).reshape(-1, 3) * 0.5
    pairs = [[i, j] for j in range(len(nodes)) for i in range(j) if np.linalg.norm(nodes[i] - nodes[j]) < 0.9]
    velocities = np.cross((0.3, 1.0, -0.5), nodes) + 0.2
    return pc.Scene(pc.SpringNetwork(nodes, pairs, np.inf, mass=0.2, velocities=velocities))


def swarm(*items: pc.Force | pc.Boundary, dimension: int = 3, count: int = 700) -> pc.Scene:
    """Independent particles, in more than one block."""
    rng = _random()
    shape = (count, dimension)
    x, v = rng.uniform(-1.0, 1.0, shape), rng.uniform(-1.0, 1.0, shape)
    return pc.Scene(pc.Particles(x, v, radius=0.01, name="swarm"), *items)


def crowd(*items: pc.Force | pc.Periodic | pc.Boundary, dimension: int = 3, side: int = 6) -> pc.Scene:
    """Particles on a jittered lattice, near enough to feel each other."""
    rng = _random()
    sites = pc.block((0.0,) * dimension, (float(side),) * dimension, 1.0)
    positions = sites + rng.uniform(-0.2, 0.2, sites.shape)
    motion = rng.uniform(-1.0, 1.0, sites.shape)
    radius = rng.uniform(0.4, 0.6, len(sites))
    return pc.Scene(pc.Particles(positions, motion, radius=radius, mass=radius**2), *items)


def pool(dimension: int = 2, spacing: float = 0.1) -> pc.Scene:
    """A block of water that collapses in a box."""
    upper = (0.8, 1.2) if dimension == 2 else (0.6, 0.6, 0.8)
    water = pc.Fluid(pc.block((0.0,) * dimension, upper, spacing), spacing)
    down = pc.Gravity(-9.81 * np.eye(dimension)[-1])
    return pc.Scene(water, down, pc.Box((0.0,) * dimension, (1.6,) * dimension))


def drops(spacing: float = 0.1) -> pc.Scene:
    """A square drop, which its surface tension makes round, and no walls."""
    drop = pc.Fluid(pc.block((-0.5, -0.5), (0.5, 0.5), spacing), spacing, surface_tension=5.0)
    return pc.Scene(drop)


def layers(spacing: float = 0.1) -> pc.Scene:
    """Oil over water, and a heavy net that sinks into it."""
    water = pc.Fluid(pc.block((0.0, 0.0), (0.8, 0.4), spacing), spacing)
    oil = pc.Fluid(pc.block((0.0, 0.4), (0.8, 0.8), spacing), spacing, 800.0)
    net = pc.rope(6, 0.5, 2e3, damping=1.0, mass=2.0, start=(0.15, 0.9), velocities=(0.0, -1.0))
    return pc.Scene(water, oil, net, pc.Gravity((0.0, -9.81)), pc.Box((0.0, 0.0), (0.8, 2.0)))


SUMMED = {"fluids": pc.WeaklyCompressible(sound_speed=10.0, density_from="summation")}
"""How vortices are computed."""


def vortices(spacing: float = 0.1) -> pc.Scene:
    """Four vortices in a periodic fluid whose density is a sum."""
    cells = pc.block((0.0, 0.0), (1.0, 1.0), spacing)
    x, y = 2.0 * np.pi * cells.T
    flow = _rounded(0.5 * np.stack([np.sin(x) * np.cos(y), -np.cos(x) * np.sin(y)], axis=1))
    water = pc.Fluid(cells, spacing, velocities=flow)
    return pc.Scene(water, pc.Periodic((0.0, 0.0), (1.0, 1.0)))


def ripples(side: int = 24, **options: Any) -> pc.Scene:
    """Waves from a point and from a row of cells, among walls, in a medium of two speeds, with damping on one side."""
    grid = pc.Grid((side, side - 7), 0.5)
    x, y = grid.coordinates
    end = grid.upper[0]
    hump = _rounded(0.2 * np.exp(-((x - 0.3 * end) ** 2 + (y - 0.4 * end) ** 2) / (0.05 * end) ** 2))
    row = (np.abs(x - grid.origin[0] - 0.25) < 0.1) & (y > 0.2 * end)
    sources = [pc.Source((0.61 * end, 0.52 * end), 0.4, 0.7, phase=0.3), pc.Source(row, 0.1, signal=pc.Ricker(0.5))]
    medium = {
        "speed": np.where(x + y < end, 1.0, 1.5),
        "damping": np.where(x > 0.8 * end, 0.4, 0.0),
        "walls": (np.abs(x - 0.5 * end) < 0.5) & (y < 0.3 * end),
        "edges": {"x": "fixed", "y": "free"},
    }
    return pc.Scene(pc.Wave(grid, displacement=hump, sources=sources, **{**medium, **options}))


def beside() -> pc.Scene:
    """Waves beside a net that takes several substeps in each of their steps."""
    net, waves = network(), ripples()
    return pc.Scene(*net.bodies, *net.forces, *waves.systems)


def string(cells: int = 200, **options: Any) -> pc.Scene:
    """A plucked string in 1D, fixed at one end, which rings."""
    shape = {
        "displacement": lambda x: 0.1 * np.minimum(x / 0.3, (1.0 - x) / 0.7),
        "edges": {"x-": "fixed", "x+": "free"},
    }
    return pc.Scene(pc.Wave(pc.Grid(cells, 1.0 / cells), 1.0, **{**shape, **options}))


def _hump(x: np.ndarray) -> np.ndarray:
    return _rounded(0.1 * np.exp(-((x - 0.4) ** 2) / 0.02))


def room(side: int = 10, **options: Any) -> pc.Scene:
    """Sound in a room in 3D that repeats itself along one axis."""
    grid = pc.Grid((side, side + 2, side - 3), 0.1, periodic=(False, True, False))

    def bang(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        return _rounded(np.exp(-((x - 0.4) ** 2 + (y - 0.3) ** 2 + (z - 0.2) ** 2) / 0.02))

    return pc.Scene(pc.Wave(grid, 1.0, rate=bang, edges="free", **options))


def dish(side: int = 24, **options: Any) -> pc.Scene:
    """Gray and Scott's reaction around a drop in a dish, which is open at one side."""
    grid = pc.Grid((side, side - 5), 0.01)
    x, y = grid.coordinates
    drop = _rounded(np.exp(-((x - 0.11) ** 2 + (y - 0.08) ** 2) / 0.03**2))
    kinetics = pc.GrayScott(0.035, 0.0625)
    shape = {"initial": {"u": 1.0 - 0.5 * drop, "v": 0.3 * drop}, "edges": {"x-": "fixed"}}
    return pc.Scene(pc.ReactionDiffusion(grid, kinetics, {"u": 2e-5, "v": 1e-5}, **{**shape, **options}))


def chart(side: int = 24) -> pc.Scene:
    """Gray and Scott's reaction, whose feed varies along x and whose kill along y, around a drop."""
    scene = dish(side)
    (plain,) = scene.systems
    assert isinstance(plain, pc.ReactionDiffusion)
    x, y = plain.grid.coordinates
    kinetics = pc.GrayScott(_rounded(0.02 + 0.15 * x), _rounded(0.05 + 0.1 * y))
    return pc.Scene(pc.ReactionDiffusion(plain.grid, kinetics, plain.diffusion, plain.initial, {"x-": "fixed"}))


def heated(side: int = 16, **options: Any) -> pc.Scene:
    """A reaction in a dish whose sides hold values and let through fluxes, along one side from cell to cell."""
    grid = pc.Grid((side, side - 5), 0.5)
    y = grid.coordinates[1][0]
    edges = {
        "u": {"x-": pc.Dirichlet(_rounded(1.0 + 0.2 * np.sin(y))), "x+": pc.Neumann(-0.1), "y+": "fixed"},
        "v": {"y-": pc.Dirichlet(2.0), "x-": pc.Neumann(_rounded(0.1 * np.cos(y)))},
    }
    start = {"u": 1.0, "v": 2.0}
    kinetics = pc.Brusselator(1.0, 2.5)
    return pc.Scene(pc.ReactionDiffusion(grid, kinetics, {"u": 0.5, "v": 2.0}, start, edges, **options))


def rod(cells: int = 20) -> pc.Scene:
    """A reaction in Python in a tube whose ends are driven in time, by operations that are rounded alike everywhere."""
    ends = {"x-": pc.Dirichlet(lambda t: abs(t % 2.0 - 1.0)), "x+": pc.Neumann(lambda t: 0.1 * t)}
    decay = pc.Reaction(("n", "waste"), lambda n, waste: (-0.1 * n, 0.1 * n))
    start = {"n": 0.5, "waste": 0.0}
    tube = pc.ReactionDiffusion(
        pc.Grid(cells, 0.5), decay, {"n": 0.5, "waste": 0.1}, start, {"n": ends, "waste": "fixed"}
    )
    return pc.Scene(tube)


def strata(side: int = 24, **options: Any) -> pc.Scene:
    """Waves through layers of several densities, with damping, a source and an open side."""
    grid = pc.Grid((side, side - 7), 0.5)
    x, y = grid.coordinates
    end = grid.upper[0]
    hump = _rounded(0.2 * np.exp(-((x - 0.3 * end) ** 2 + (y - 0.4 * end) ** 2) / (0.05 * end) ** 2))
    medium = {
        "density": np.where(x + y < end, 1.0, np.where(y < 0.3 * end, 0.2, 4.0)),
        "damping": np.where(x > 0.8 * end, 0.4, 0.0),
        "walls": (np.abs(x - 0.5 * end) < 0.5) & (y < 0.3 * end),
        "sources": pc.Source((0.61 * end, 0.52 * end), 0.4, 0.7, phase=0.3),
        "edges": {"x": "fixed", "y": "free"},
    }
    return pc.Scene(pc.Wave(grid, np.where(x < 0.6 * end, 1.0, 1.5), hump, **{**medium, **options}))


def shaken(side: int = 16, **options: Any) -> pc.Scene:
    """A membrane whose sides are moved: one in time, one held in a curve, one pulled."""
    grid = pc.Grid((side, side - 5), 0.5)
    y = grid.coordinates[1][0]
    shape = _rounded(np.sin(y))
    edges = {
        "x-": pc.Dirichlet(lambda t: 0.2 * abs(t % 2.0 - 1.0)),
        "x+": pc.Dirichlet(_rounded(0.1 * shape)),
        "y-": pc.Neumann(0.3),
        "y+": "free",
    }
    return pc.Scene(pc.Wave(grid, 1.0, edges=edges, **options))


def clock(cells: int = 120) -> pc.Scene:
    """The Brusselator in a closed tube, which oscillates."""
    grid = pc.Grid(cells, 0.5, periodic=True)
    bent = grid.field(lambda x: _rounded(np.sin(2.0 * np.pi * x / grid.upper[0])), "start")
    start = {"u": 1.0 + 0.2 * bent, "v": 2.5 - 0.1 * bent}
    return pc.Scene(pc.ReactionDiffusion(grid, pc.Brusselator(1.0, 2.5), {"u": 0.5, "v": 2.0}, start))


def heart(side: int = 8) -> pc.Scene:
    """A pulse of FitzHugh and Nagumo's in 3D."""
    grid = pc.Grid((side, side + 2, side - 3), 0.5, periodic=(False, True, False))
    start = {"u": grid.field(lambda x, y, z: np.where(x + 0.3 * z < 1.5, 1.0, -1.2), "start"), "v": -0.6}
    return pc.Scene(pc.ReactionDiffusion(grid, pc.FitzHughNagumo(), {"u": 0.5, "v": 0.05}, start))


def packet(cells: tuple[int, ...] = (24, 20), **options: Any) -> pc.Scene:
    """A packet of waves in a trap, between walls but along y."""
    dimension = len(cells)
    grid = pc.Grid(cells, 0.5, periodic=(False, True, False)[:dimension])
    middle = 0.5 * np.array(grid.upper)
    psi = pc.wave_packet(grid, 0.8 * middle, 0.6 * (-1.0) ** np.arange(dimension), 1.2)

    def trap(*place: np.ndarray) -> np.ndarray:
        return sum(0.05 * (x - center) ** 2 for x, center in zip(place, middle.tolist(), strict=True))

    return pc.Scene(pc.Schrodinger(grid, psi, **{"potential": trap, **options}))


def predators(side: int = 12) -> pc.Scene:
    """A reaction in Python, of operations that are rounded alike everywhere: prey and those that live on it."""
    grid = pc.Grid((side, side - 3), 0.5)
    x, y = grid.coordinates
    start = {"prey": _rounded(0.5 + 0.1 * np.cos(x)), "hunters": _rounded(0.3 + 0.1 * np.sin(y))}
    kinetics = pc.Reaction(("prey", "hunters"), lambda n, p: (n * (1.0 - n) - n * p, 0.5 * n * p - 0.2 * p))
    return pc.Scene(pc.ReactionDiffusion(grid, kinetics, {"prey": 0.1, "hunters": 0.4}, start))


def cloud(flow: Any, count: int = 300, center: tuple[float, ...] = (0.0, 0.0, 0.0), size: float = 0.3) -> pc.Scene:
    """Tracers in a flow."""
    places = np.array(center) + size * _random().normal(size=(count, len(center)))
    return pc.Scene(pc.Tracers(places, flow))


def whirl(count: int = 40, dust: int = 0, core: float = 0.0) -> pc.Scene:
    """Vortices of both signs on a jittered lattice, and dust between them."""
    rng = _random()
    sites = pc.block((0.0, 0.0), (5.0, count / 5.0), 1.0)
    vortices = pc.PointVortices(
        sites + rng.uniform(-0.2, 0.2, sites.shape),
        rng.uniform(0.5, 1.5, len(sites)) * rng.choice([-1.0, 1.0], len(sites)),
        core,
    )
    return pc.Scene(pc.Tracers(rng.uniform(0.0, 5.0, (dust, 2)), vortices), vortices) if dust else pc.Scene(vortices)


def stirred() -> pc.Scene:
    """A flow in Python, of operations that are rounded alike everywhere: Duffing's oscillator, driven to and fro."""

    def velocity(time: float, place: np.ndarray) -> np.ndarray:
        x, v = place.T
        return np.column_stack([v, x - x * x * x - 0.2 * v + 0.3 * abs(time % 2.0 - 1.0)])

    return cloud(pc.Flow(velocity), center=(0.0, 0.0))


IN_PYTHON: dict[type[Kinetics], Callable[[Any], Callable[..., Any]]] = {
    pc.GrayScott: lambda k: lambda u, v: (k.feed * (1.0 - u) - u * v * v, u * v * v - (k.feed + k.kill) * v),
    pc.Brusselator: lambda k: lambda u, v: (k.a - (k.b + 1.0) * u + u * u * v, k.b * u - u * u * v),
    pc.Schnakenberg: lambda k: lambda u, v: (k.a - u + u * u * v, k.b - u * u * v),
    pc.FitzHughNagumo: lambda k: (
        lambda u, v: (
            u - u**3 / 3.0 - v + k.current,
            k.epsilon * (u + k.beta - k.gamma * v),
        )
    ),
    pc.Reaction: lambda k: k.function,
}
"""The kinetics as functions in NumPy."""


def cluster(count: int = 150, dimension: int = 3, **options: Any) -> pc.Scene:
    """Stars and a heavy one that is held, which attract each other, and comets that only feel them."""
    rng = _random()
    shape = (count, dimension)
    stars = pc.Particles(
        rng.uniform(-1.0, 1.0, shape),
        rng.uniform(-0.3, 0.3, shape),
        mass=rng.uniform(0.5, 1.5, count) / count,
        fixed=[0],
    )
    comets = pc.Particles(rng.uniform(-1.0, 1.0, (20, dimension)), mass=1e-3)
    return pc.Scene(stars, comets, pc.Gravitation(1.0, 0.05, sources=stars, **options))


def plasma(count: int = 100, dimension: int = 3, **options: Any) -> pc.Scene:
    """As many charges of each sign, in a harmonic well."""
    rng = _random()
    shape = (count, dimension)
    signs = np.where(np.arange(count) % 2 == 0, 1.0, -1.0)
    ions = pc.Particles(rng.uniform(-1.0, 1.0, shape), rng.uniform(-0.3, 0.3, shape), mass=0.5, charge=signs)
    well = pc.CentralForce((0.0,) * dimension, 1.0, exponent=1.0)
    return pc.Scene(ions, pc.Coulomb(0.01, 0.05, **options), well)


def crossed(count: int = 60, dimension: int = 2) -> pc.Scene:
    """Ions in crossed uniform fields, which repel each other, with one that is held."""
    rng = _random()
    shape = (count, dimension)
    signs = np.where(np.arange(count) % 2 == 0, 1.0, -0.5)
    start = rng.uniform(-1.0, 1.0, shape)
    ions = pc.Particles(start, rng.uniform(-1.0, 1.0, shape), mass=0.5, charge=signs, fixed=[0])
    electric, magnetic = ((0.3, -0.2), 1.5) if dimension == 2 else ((0.3, -0.2, 0.1), (0.5, -1.0, 1.5))
    return pc.Scene(ions, pc.Coulomb(0.01, 0.05), pc.ElectromagneticField(electric, magnetic))


def trap(count: int = 600) -> pc.Scene:
    """Ions in a Penning trap whose magnet is tilted, in which they fall."""
    rng = _random()
    ions = pc.Particles(
        rng.uniform(-1.0, 1.0, (count, 3)),
        rng.uniform(-0.5, 0.5, (count, 3)),
        mass=rng.uniform(0.5, 1.5, count),
        charge=1.0,
        fixed=[0],
    )
    return pc.Scene(ions, DOWN, pc.ElectromagneticField(pc.QuadrupoleTrap(1.0, (0.1, 0.0, -0.2)), (0.0, 2.0, 6.0)))


def trap_alone(count: int = 600) -> pc.Scene:
    """The same in weightlessness."""
    ions = trap(count).bodies[0]
    return pc.Scene(ions, pc.ElectromagneticField(pc.QuadrupoleTrap(1.0, (0.1, 0.0, -0.2)), (0.0, 2.0, 6.0)))


def bottle(count: int = 600) -> pc.Scene:
    """Ions in a magnetic bottle, under drag."""
    rng = _random()
    ions = pc.Particles(rng.uniform(-0.3, 0.3, (count, 3)), rng.uniform(-1.0, 1.0, (count, 3)), charge=-2.0)
    return pc.Scene(ions, BREEZE, pc.ElectromagneticField(magnetic=pc.MagneticBottle(2.0, 0.7)))


def by_function(count: int = 40) -> pc.Scene:
    """Ions in fields written in Python, in operations that are rounded alike everywhere."""
    rng = _random()
    ions = pc.Particles(rng.uniform(-1.0, 1.0, (count, 2)), rng.uniform(-0.5, 0.5, (count, 2)), charge=0.5)
    return pc.Scene(
        ions,
        pc.ElectromagneticField(
            lambda time, x: -2.0 * x,
            lambda time, x: 1.0 + time * x[:, 0] * x[:, 1],
            potential=lambda x: 0.5 * float((x * x).sum()),
        ),
    )


def trio() -> pc.Scene:
    """Three equal masses on the figure eight, without softening (Chenciner, Montgomery, Ann. Math. 152, 881 (2000))."""
    x, v = np.array([0.97000436, -0.24308753]), np.array([0.93240737, 0.86473146])
    return pc.Scene(pc.Particles([x, -x, 0.0 * x], [0.5 * v, 0.5 * v, -v]), pc.Gravitation(1.0))


def years() -> pc.Scene:
    """A sun and its planets in astronomical units and days, with the default G."""
    units = pc.units.system(length=pc.units.AU, time=pc.units.day, mass=pc.units.solar_mass)
    places, speeds = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.5]], [[0.0, 0.0], [0.0, 0.0172], [-0.014, 0.0]]
    return pc.Scene(pc.Particles(places, speeds, mass=[1.0, 3e-6, 3e-7]), pc.Gravitation(), units=units)


def harmonic() -> pc.CustomForce:
    """A well written in Python, in operations that are rounded alike everywhere."""
    return pc.CustomForce(lambda time, x, v: -3.0 * x, potential=lambda x: 1.5 * float((x * x).sum()))


STONES = (
    pc.ConvexHull([[-0.9, -0.9, -1.1], [0.8, -0.7, -1.2], [0.0, 0.9, -1.15], [0.1, 0.0, -1.8]], restitution=0.5),
    pc.Capsule((-1.0, -0.2, -1.4), (1.0, 0.9, -1.3), 0.2, friction=0.3),
)
HILLS = _rounded(np.sin(7.0 * np.arange(11))[:, None] * np.cos(5.0 * np.arange(9)))
LAND = pc.HeightField(-1.3 + 0.2 * HILLS, 0.3, (-1.4, -1.1), restitution=0.5, friction=0.2)
PROFILE = pc.HeightField(-1.3 + 0.2 * HILLS[:, 0], 0.3, -1.4, restitution=0.5, friction=0.2)
ROOM = pc.Box((-1.1,) * 3, (1.1,) * 3, restitution=0.8, friction=0.3)
GRAINS = pc.SoftSpheres(50.0, 0.2, 0.3, 0.1, exponent=1.5)
DOWN = pc.Gravity((0.0, 0.0, -9.81))
STAR = pc.CentralForce((0.0, 0.0, 0.0), 1.0, softening=0.1)
POWER = pc.CentralForce((0.0, 0.0), 1.0, -1.7, 0.1)
ATOMS = pc.LennardJones(1.0, 0.9)
BREEZE = pc.Drag(0.1, wind=(1.0, 0.0, 0.5))
RESISTANCE = pc.Drag(0.0, 0.2)
BOUNCES = pc.SoftSpheres(50.0, friction=0.3, exponent=1.5, restitution=0.6)
VORTEX = pc.Drag(0.1, 0.2, wind=lambda time, x: np.stack([-x[:, 1], x[:, 0], 0.3 * x[:, 1]], axis=1) / (1.0 + time) - x)


def selected() -> pc.Scene:
    """Independent particles of which some are heavy, and some attract each other."""
    some = _random().permutation(700)
    heavy, drawn = pc.Gravity((0.0, 0.0, -9.81), on=("swarm", some[:300])), ("swarm", some[200:320])
    return swarm(heavy, pc.Drag(0.1, on=("swarm", slice(0, 500))), pc.Gravitation(0.01, 0.1, on=drawn, sources=drawn))


def grains(side: int = 6, contact: pc.SoftSpheres = GRAINS) -> pc.Scene:
    """Soft spheres between periodic sides, which fall on a floor."""
    return crowd(contact, DOWN, pc.Periodic((0.0, 0.0, -np.inf), (side, side, np.inf)), pc.Floor(-1.0), side=side)


def _large_network() -> pc.Scene:
    return network(side=120)


def _large_cloth() -> pc.Scene:
    return cloth((100, 90))


def _large_swarm() -> pc.Scene:
    return swarm(DOWN, BREEZE, count=200_000)


def _large_grains() -> pc.Scene:
    return grains(side=20)


RK4 = {"integrator": pc.RungeKutta4()}
RADAU = {"integrator": pc.GaussRadau15()}
F32 = {"precision": "f32"}
LARGE = {pc.VelocityVerlet: _large_network, pc.SemiImplicitEuler: _large_network, pc.DormandPrince5: _large_network}

RIGID: dict[str, Case] = {
    "tumbling": Case(rigid_scenes.tumbling, 0.02),
    "spinning of order 4": Case(rigid_scenes.spinning, 0.04, {"integrator": pc.RATTLE(4)}),
    "tumbling adaptive": Case(rigid_scenes.tumbling, 0.02, {"dt": pc.AdaptiveStep()}),
    "discs": Case(rigid_scenes.discs, 0.01, large=lambda: rigid_scenes.discs(66)),
    "stack": Case(rigid_scenes.stack, 0.002),
    "die": Case(rigid_scenes.die, 0.0025),
    "linkage": Case(rigid_scenes.linkage, 0.005),
    "frame": Case(rigid_scenes.frame, 0.005),
    "machine": Case(rigid_scenes.machine, 0.005),
    "struck": Case(rigid_scenes.struck, 0.005),
    "paddle": Case(rigid_scenes.paddle, 0.005),
    "naps": Case(rigid_scenes.naps, 0.02),
    "sails": Case(rigid_scenes.sails, 0.01),
    "weathervane": Case(rigid_scenes.weathervane, 0.01),
    "hammock": Case(rigid_scenes.hammock, 0.004, large=lambda: rigid_scenes.hammock(70)),
    "caught": Case(rigid_scenes.caught, 0.0015),
    "flagpole": Case(rigid_scenes.flagpole, 0.004),
    "heap": Case(rigid_scenes.heap, 0.001, rigid_scenes.pile()),
    "heap f32": Case(rigid_scenes.heap, 0.001, {**rigid_scenes.pile(), "precision": "f32"}),
    "discs f32": Case(rigid_scenes.discs, 0.01, {"precision": "f32"}),
    "floating box": Case(
        rigid_scenes.floating,
        1e-3,
        {"fluids": pc.WeaklyCompressible(sound_speed=40.0)},
        large=lambda: rigid_scenes.floating(0.0125),
    ),
    "drop on a shard": Case(rigid_scenes.splashes, 1e-3, {"fluids": pc.WeaklyCompressible(sound_speed=20.0)}),
}
"""Scenes with rigid bodies."""

SCENES: dict[str, Case] = {
    **{
        f"network {kind.__name__}": Case(
            network, 0.01, {"integrator": kind(), "precision": precision}, large=LARGE.get(kind)
        )
        for kind, precision in zip(INTEGRATORS, ["f64", "f32"] * len(INTEGRATORS), strict=False)
        if kind.advances("Wave")
    },
    "network 3D": Case(lambda: network(3), 0.01),
    "network adaptive": Case(network, 0.01, {"dt": pc.AdaptiveStep()}),
    "network by error": Case(network, 0.01, {"dt": pc.AdaptiveStep(tolerance=1e-5), "integrator": pc.DormandPrince5()}),
    "shell": Case(shell, 0.002, large=lambda: shell((100, 60))),
    "shell f32 RungeKutta4": Case(shell, 0.002, {**F32, **RK4}, large=lambda: shell((100, 60))),
    "chain": Case(chain, 0.002, large=lambda: chain(20_000)),
    "chain 3D f32": Case(lambda: chain(dimension=3), 0.002, F32),
    "chain of order 4": Case(chain, 0.01, {"integrator": pc.RATTLE(4)}),
    "chain adaptive": Case(chain, 0.002, {"dt": pc.AdaptiveStep()}),
    "truss": Case(truss, 0.01),
    "dropped": Case(dropped, 0.002),
    "dropped 3D f32": Case(lambda: dropped(dimension=3), 0.002, F32),
    "chain XPBD": Case(chain, 0.002, {"integrator": pc.XPBD(3, 4)}),
    "shell BDF2": Case(shell, 0.002, {"integrator": pc.BDF2(1e-12)}, large=lambda: shell((70, 60))),
    "flag BackwardEuler f32": Case(flag, 0.002, {**F32, "integrator": pc.BackwardEuler(1e-7)}),
    "grains BackwardEuler": Case(grains, 0.002, {"integrator": pc.BackwardEuler(1e-12)}),
    "atoms ImplicitMidpoint": Case(
        lambda: crowd(ATOMS, dimension=2), 0.001, {"integrator": pc.ImplicitMidpoint(1e-12)}
    ),
    "swarm star BDF2": Case(lambda: swarm(STAR, RESISTANCE, BREEZE, count=100), 0.01, {"integrator": pc.BDF2(1e-12)}),
    "network XPBD": Case(network, 0.02, {"integrator": pc.XPBD(3, 2)}, large=_large_network),
    "network ProjectiveDynamics": Case(network, 0.02, {"integrator": pc.ProjectiveDynamics(4)}, large=_large_network),
    "network BackwardEuler": Case(network, 0.02, {"integrator": pc.BackwardEuler()}, large=_large_network),
    "network 3D ImplicitMidpoint": Case(lambda: network(3), 0.02, {"integrator": pc.ImplicitMidpoint(1e-12)}),
    "network BDF2": Case(network, 0.02, {"integrator": pc.BDF2(1e-12)}, large=_large_network),
    "cloth BDF2": Case(cloth, 0.005, {"integrator": pc.BDF2()}),
    "cloth BackwardEuler f32": Case(cloth, 0.005, {**F32, "integrator": pc.BackwardEuler(1e-6)}),
    "cloth XPBD f32": Case(cloth, 0.005, {**F32, "integrator": pc.XPBD(4)}),
    "cloth ProjectiveDynamics f32": Case(cloth, 0.005, {**F32, "integrator": pc.ProjectiveDynamics(6)}),
    "cloth": Case(cloth, 0.002, large=_large_cloth),
    "cloth f32": Case(cloth, 0.002, F32, large=_large_cloth),
    "flag": Case(flag, 0.002, large=lambda: flag((100, 60))),
    "flag f32 RungeKutta4": Case(flag, 0.002, {**F32, **RK4}, large=lambda: flag((100, 60))),
    "torn": Case(torn, 0.002, large=lambda: torn(90)),
    "torn f32 RungeKutta4": Case(torn, 0.002, {**RK4, **F32}),
    "torn adaptive": Case(torn, 0.002, {"dt": pc.AdaptiveStep()}),
    "torn BackwardEuler": Case(torn, 0.002, {"integrator": pc.BackwardEuler(1e-12)}),
    "torn XPBD": Case(torn, 0.002, {"integrator": pc.XPBD(3, 2)}),
    "torn ProjectiveDynamics": Case(torn, 0.002, {"integrator": pc.ProjectiveDynamics(6)}),
    "strings": Case(strings, 0.002),
    "strings f32": Case(strings, 0.002, F32),
    "strings BDF2": Case(strings, 0.004, {"integrator": pc.BDF2(1e-12)}),
    "strings XPBD": Case(strings, 0.002, {"integrator": pc.XPBD(3, 2)}),
    "wires": Case(wires, 0.002),
    "wires 3D f32": Case(lambda: wires(3), 0.002, F32),
    "wires with friction": Case(lambda: wires(friction=0.2), 0.004),
    "wires of order 4": Case(wires, 0.01, {"integrator": pc.RATTLE(4)}),
    "wires adaptive": Case(lambda: wires(3), 0.002, {"dt": pc.AdaptiveStep()}),
    "wires BackwardEuler": Case(lambda: wires(friction=0.2), 0.004, {"integrator": pc.BackwardEuler(1e-12)}),
    "wires BDF2": Case(wires, 0.004, {"integrator": pc.BDF2(1e-12)}),
    "wires XPBD": Case(wires, 0.004, {"integrator": pc.XPBD(3, 2)}),
    "wires ProjectiveDynamics": Case(wires, 0.004, {"integrator": pc.ProjectiveDynamics(6)}),
    "sheets": Case(sheets, 0.002, large=lambda: sheets((70, 60))),
    "sheets f32": Case(sheets, 0.002, F32),
    "sheets adaptive": Case(sheets, 0.002, {"dt": pc.AdaptiveStep()}),
    "sheets BackwardEuler": Case(sheets, 0.004, {"integrator": pc.BackwardEuler(1e-12)}),
    "sheets BDF2": Case(sheets, 0.004, {"integrator": pc.BDF2(1e-12)}),
    "sheets XPBD": Case(sheets, 0.004, {"integrator": pc.XPBD(3, 2)}),
    "sheets ProjectiveDynamics": Case(sheets, 0.004, {"integrator": pc.ProjectiveDynamics(6)}),
    "swarm folded": Case(lambda: swarm(DOWN, BREEZE), 0.01, large=_large_swarm),
    "swarm folded f32": Case(lambda: swarm(DOWN, pc.Drag(0.1)), 0.01, F32, large=_large_swarm),
    "swarm quadratic drag": Case(
        lambda: swarm(DOWN, RESISTANCE), 0.01, RK4, large=lambda: swarm(DOWN, RESISTANCE, count=30_000)
    ),
    "swarm star": Case(lambda: swarm(STAR), 0.01, RK4, large=lambda: swarm(STAR, count=30_000)),
    "swarm star f32": Case(lambda: swarm(STAR), 0.01, F32),
    "swarm power": Case(lambda: swarm(POWER, dimension=2), 0.01, large=lambda: swarm(POWER, dimension=2, count=30_000)),
    "swarm in a box": Case(lambda: swarm(DOWN, ROOM), 0.01, large=lambda: swarm(DOWN, ROOM, count=30_000)),
    "swarm in a box RungeKutta4": Case(lambda: swarm(DOWN, ROOM), 0.01, RK4),
    "swarm on stones": Case(lambda: swarm(DOWN, *STONES), 0.01, large=lambda: swarm(DOWN, *STONES, count=30_000)),
    "swarm on stones f32": Case(lambda: swarm(DOWN, *STONES), 0.01, F32),
    "swarm on hills": Case(lambda: swarm(DOWN, LAND), 0.01, large=lambda: swarm(DOWN, LAND, count=30_000)),
    "swarm on hills 2D f32": Case(lambda: swarm(pc.Gravity((0.0, -9.81)), PROFILE, dimension=2), 0.01, F32),
    "swarm in Python": Case(lambda: swarm(harmonic()), 0.01),
    "swarm in a vortex": Case(lambda: swarm(VORTEX), 0.01),
    "swarm in a vortex BDF2": Case(lambda: swarm(VORTEX, count=100), 0.01, {"integrator": pc.BDF2(1e-12)}),
    "selected": Case(selected, 0.01),
    "selected f32 RungeKutta4": Case(selected, 0.01, {**F32, **RK4}),
    "grains": Case(grains, 0.002, large=_large_grains),
    "grains f32": Case(grains, 0.002, F32, large=_large_grains),
    "grains by restitution": Case(lambda: grains(contact=BOUNCES), 0.002),
    "grains by restitution f32": Case(lambda: grains(contact=BOUNCES), 0.002, F32),
    "atoms": Case(lambda: crowd(ATOMS), 0.002, {"integrator": pc.PEFRL()}, large=lambda: crowd(ATOMS, side=18)),
    "atoms 2D f32": Case(lambda: crowd(ATOMS, dimension=2), 0.002, F32),
    "cluster": Case(cluster, 0.01, large=lambda: cluster(5000)),
    "cluster f32": Case(cluster, 0.01, F32, large=lambda: cluster(5000)),
    "plasma 2D": Case(lambda: plasma(dimension=2), 0.01, large=lambda: plasma(5000, 2)),
    "plasma f32 RungeKutta4": Case(plasma, 0.01, {**F32, **RK4}),
    "cluster by a tree": Case(
        lambda: cluster(300, opening_angle=0.9), 0.01, large=lambda: cluster(20_000, opening_angle=0.9)
    ),
    "cluster by a tree f32": Case(
        lambda: cluster(300, opening_angle=0.9), 0.01, F32, large=lambda: cluster(20_000, opening_angle=0.9)
    ),
    "plasma by a tree 2D": Case(lambda: plasma(200, 2, opening_angle=0.8), 0.01),
    "trio": Case(trio, 0.01, {"integrator": pc.BlanesMoan4()}),
    "years in days": Case(years, 1.0),
    "trio adaptive": Case(trio, 0.01, {"dt": pc.AdaptiveStep()}),
    "trio by its coefficients": Case(trio, 0.1, {"dt": pc.AutoStep(), **RADAU}),
    "cluster GaussRadau15": Case(lambda: cluster(40), 0.05, RADAU),
    "network GaussRadau15": Case(network, 0.05, RADAU),
    "swarm GaussRadau15": Case(
        lambda: swarm(STAR, RESISTANCE, BREEZE, count=20),
        0.01,
        RADAU,
        large=lambda: swarm(STAR, RESISTANCE, BREEZE, count=30_000),
    ),
    "swarm in Python GaussRadau15": Case(lambda: swarm(harmonic(), count=20), 0.05, RADAU),
    "pool": Case(pool, 1e-3, large=lambda: pool(spacing=0.0125)),
    "pool f64 McLachlan2": Case(pool, 1e-3, {"precision": "f64", "integrator": pc.McLachlan2()}),
    "pool 3D": Case(lambda: pool(3), 1e-3, large=lambda: pool(3, spacing=0.03)),
    "pool shifting": Case(
        pool, 1e-3, {"fluids": pc.WeaklyCompressible(shifting=1.0)}, large=lambda: pool(spacing=0.0125)
    ),
    "pool SemiImplicitEuler": Case(pool, 1e-3, {"integrator": pc.SemiImplicitEuler()}),
    "layers": Case(layers, 1e-3, large=lambda: layers(spacing=0.01)),
    "vortices": Case(vortices, 1e-3, SUMMED, large=lambda: vortices(spacing=0.0125)),
    "vortices RungeKutta4": Case(vortices, 1e-3, {"precision": "f64", **RK4, **SUMMED}),
    "atoms adaptive": Case(lambda: crowd(ATOMS, dimension=2), 0.002, {"dt": pc.AdaptiveStep()}),
    "swarm star by error": Case(
        lambda: swarm(STAR, count=5), 0.01, {"dt": pc.AdaptiveStep(tolerance=1e-6), "integrator": pc.BogackiShampine3()}
    ),
    "ripples": Case(ripples, 0.1, large=lambda: ripples(900)),
    "ripples f32": Case(ripples, 0.1, F32, large=lambda: ripples(900)),
    "ripples order 4 RungeKutta4": Case(lambda: ripples(order=4), 0.1, RK4, large=lambda: ripples(500, order=4)),
    "ripples BlanesMoan4": Case(ripples, 0.1, {"integrator": pc.BlanesMoan4()}),
    "ripples beside a network": Case(beside, 0.15),
    "string": Case(string, 0.002),
    "string by error": Case(
        lambda: string(40, displacement=_hump),
        0.005,
        {"dt": pc.AdaptiveStep(tolerance=1e-7), "integrator": pc.DormandPrince5()},
    ),
    "strata": Case(strata, 0.1),
    "strata f32 order 4 RungeKutta4": Case(lambda: strata(order=4), 0.05, {**RK4, **F32}),
    "strata in the open": Case(lambda: strata(edges={"x": "absorbing", "y": "free"}, walls=None), 0.1),
    "shaken": Case(shaken, 0.1),
    "shaken RungeKutta4 f32": Case(shaken, 0.1, {**RK4, **F32}),
    "room": Case(room, 0.02, large=lambda: room(90)),
    "dish": Case(dish, 0.5, large=lambda: dish(400)),
    "dish f32 ExplicitEuler": Case(dish, 0.5, {"integrator": pc.ExplicitEuler(), **F32}, large=lambda: dish(900)),
    "dish DormandPrince5": Case(dish, 1.0, {"integrator": pc.DormandPrince5()}),
    "dish RungeKuttaChebyshev": Case(dish, 4.0, {"integrator": pc.RungeKuttaChebyshev()}, large=lambda: dish(400)),
    "dish by error": Case(dish, 1.0, {"dt": pc.AdaptiveStep(tolerance=1e-6), "integrator": pc.BogackiShampine3()}),
    "chart": Case(chart, 0.5, large=lambda: chart(400)),
    "chart f32 ExplicitEuler": Case(chart, 0.5, {"integrator": pc.ExplicitEuler(), **F32}),
    "heated": Case(heated, 0.02, large=lambda: heated(400)),
    "heated f32 RungeKuttaChebyshev": Case(heated, 0.05, {"integrator": pc.RungeKuttaChebyshev(), **F32}),
    "rod": Case(rod, 0.1),
    "rod by error": Case(rod, 0.1, {"dt": pc.AdaptiveStep(tolerance=1e-6), "integrator": pc.DormandPrince5()}),
    "clock": Case(clock, 0.05),
    "heart": Case(heart, 0.05, large=lambda: heart(60)),
    "predators": Case(predators, 0.1),
    "packet": Case(packet, 0.05, large=lambda: packet((220, 200))),
    "packet f32 order 4": Case(packet, 0.1, {"integrator": pc.SplitStep(order=4), **F32}),
    "packet 3D interacting": Case(lambda: packet((10, 9, 8), interaction=0.3), 0.05),
    "packet CrankNicolson": Case(
        lambda: packet((60,)), 0.05, {"integrator": pc.CrankNicolson()}, large=lambda: packet((220, 200))
    ),
    "packet Staggered": Case(lambda: packet((60,)), 0.02, {"integrator": pc.Staggered()}),
    "packet in the open": Case(lambda: packet((60,), potential=lambda x: 0.01 * x, edges="absorbing"), 0.05),
    "butterfly": Case(
        lambda: cloud(pc.Lorenz(), center=(1.0, 2.0, 25.0)), 0.005, large=lambda: cloud(pc.Lorenz(), 120_000)
    ),
    "butterfly f32 ExplicitEuler": Case(
        lambda: cloud(pc.Lorenz(), center=(1.0, 2.0, 25.0)), 0.002, {"integrator": pc.ExplicitEuler(), **F32}
    ),
    "band RungeKuttaChebyshev": Case(
        lambda: cloud(pc.Rossler(), center=(4.0, 0.0, 0.0)), 0.02, {"integrator": pc.RungeKuttaChebyshev()}
    ),
    "shells by error": Case(
        lambda: cloud(pc.Aizawa()), 0.02, {"dt": pc.AdaptiveStep(tolerance=1e-6), "integrator": pc.DormandPrince5()}
    ),
    "loops f32 BogackiShampine3": Case(
        lambda: cloud(pc.Thomas(), center=(1.0, 0.3, -0.7)), 0.05, {"integrator": pc.BogackiShampine3(), **F32}
    ),
    "wings adaptive": Case(lambda: cloud(pc.Halvorsen(), center=(-5.0, 0.0, 0.0)), 0.002, {"dt": pc.AdaptiveStep()}),
    "stirred": Case(stirred, 0.02),
    "whirl": Case(whirl, 0.02, {"integrator": pc.DormandPrince5()}, large=lambda: whirl(1500)),
    "whirl with cores f32": Case(lambda: whirl(dust=700, core=0.2), 0.02, F32, large=lambda: whirl(dust=20_000)),
    "charges": Case(crossed, 0.02, large=lambda: crossed(4200)),
    "charges 3D f32 RungeKutta4": Case(lambda: crossed(dimension=3), 0.02, {"integrator": pc.RungeKutta4(), **F32}),
    "trap": Case(trap, 0.01, large=lambda: trap(100_000)),
    "trap alone": Case(trap_alone, 0.01, large=lambda: trap_alone(400_000)),
    "trap alone f32": Case(trap_alone, 0.01, F32),
    "trap adaptive": Case(trap, 0.01, {"dt": pc.AdaptiveStep()}),
    "bottle f32": Case(bottle, 0.02, F32, large=lambda: bottle(200_000)),
    "bottle exact": Case(bottle, 0.05, {"integrator": pc.Boris(exact_angle=True)}),
    "by function": Case(by_function, 0.02),
    "drop": Case(drops, 1e-3, {"fluids": pc.WeaklyCompressible(sound_speed=20.0)}, large=lambda: drops(spacing=0.0125)),
    **RIGID,
}
