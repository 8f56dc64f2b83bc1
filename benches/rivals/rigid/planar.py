"""Rigid bodies in 2D by pymunk, by Box2D 3 (pyb2d3) and by Box2D 2.4 (libbox2d, of the system).

Units are meters and kilograms, for which Box2D is tuned; pymunk's tolerance is set to that of Box2D, 5 mm.
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from rivals import optional
from rivals.rigid.pile import FRICTION, GRAVITY, Array, Pile, State

FAR = 1e3
"""Length of the ground and of walls [m]."""
SLOP = 0.005
"""Overlap that is left alone [m]."""


def lines(pile: Pile) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Ends of the ground and of the walls."""
    if pile.width is None:
        return [((-FAR, 0.0), (FAR, 0.0))]
    return [((0.0, 0.0), (pile.width, 0.0)), ((0.0, 0.0), (0.0, FAR)), ((pile.width, 0.0), (pile.width, FAR))]


def corners(half: Array) -> list[tuple[float, float]]:
    """Of a rectangle."""
    a, b = half.tolist()
    return [(-a, -b), (a, -b), (a, b), (-a, b)]


class Pymunk:
    """pymunk: impulses, and a bias against overlap."""

    name, note = "pymunk", ""
    module = "pymunk"

    def __init__(self, pile: Pile, dt: float, iterations: int = 10, slop: float = SLOP, hashed: bool = False) -> None:
        import pymunk

        self.space, self.dt = pymunk.Space(), dt
        self.space.gravity, self.space.iterations, self.space.collision_slop = (0.0, -GRAVITY), iterations, slop
        if hashed:
            self.space.use_spatial_hash(2.0 * float(pile.sizes.max()), 10 * len(pile.mass))
        shapes: list[Any] = [pymunk.Segment(self.space.static_body, *line, 0.0) for line in lines(pile)]
        self.bodies = []
        for place, size, angle, mass, moment in zip(
            pile.positions, pile.sizes, pile.turns, pile.mass, pile.moments, strict=True
        ):
            body = pymunk.Body(float(mass), float(moment[0]))
            body.position, body.angle = tuple(place.tolist()), float(angle)
            shapes.append(pymunk.Circle(body, float(size[0])) if pile.round else pymunk.Poly(body, corners(size)))
            self.bodies.append(body)
            self.space.add(body)
        for shape in shapes:
            shape.friction, shape.elasticity = np.sqrt(FRICTION), 0.0  # the product counts
        self.space.add(*shapes)

    def step(self, steps: int) -> None:
        """Take steps."""
        for _ in range(steps):
            self.space.step(self.dt)

    def state(self) -> State:
        """Of all bodies."""
        rows = np.array([(*one.position, one.angle, *one.velocity, one.angular_velocity) for one in self.bodies])
        return State(rows[:, :2], rows[:, 2], rows[:, 3:5], rows[:, 5])


class Box2D3:
    """Box2D from version 3.1 on: small steps with soft contacts, as stiff as a step allows with `stiff`.

    With `scale`, lengths are in another unit.
    """

    name, note = "Box2D 3 (pyb2d3", ")"
    module = "pyb2d3"

    def __init__(self, pile: Pile, dt: float, substeps: int = 4, scale: float = 1.0, stiff: bool = False) -> None:
        import pyb2d3

        self.dt, self.substeps, self.scale, pile = dt, substeps, scale, pile.scaled(scale)
        hertz = {"contact_hertz": 0.25 * substeps / dt} if stiff else {}  # it allows no more
        self.world = pyb2d3.World(gravity=(0.0, -GRAVITY * scale), maximum_linear_speed=400.0 * scale, **hertz)
        self.world.sleeping_enabled = False
        material = pyb2d3.surface_material(friction=FRICTION, restitution=0.0)
        ground = self.world.create_static_body()
        for line in lines(pile):
            ground.create_shape(pyb2d3.shape_def(material=material), pyb2d3.segment(*line))
        # The density of the shape is that per area.
        definition = pyb2d3.shape_def(material=material, density=pile.density)
        self.bodies, self._kept = pyb2d3.Bodies(), []
        for place, size, angle in zip(pile.positions, pile.sizes, pile.turns, strict=True):
            body = self.world.create_dynamic_body(
                position=tuple(place.tolist()), rotation=pyb2d3.make_rot(float(angle)), sleep_threshold=0.0
            )
            shape = pyb2d3.circle(radius=float(size[0])) if pile.round else pyb2d3.box(*size.tolist())
            body.create_shape(definition, shape)
            self.bodies.append(body.id)

    def step(self, steps: int) -> None:
        """Take steps."""
        for _ in range(steps):
            self.world.step(self.dt, self.substeps)

    def state(self) -> State:
        """Of all bodies."""
        places, turns, velocities, spins = (
            np.asarray(getattr(self.bodies, f"get_{name}")(), float)
            for name in ("positions", "rotations", "linear_velocities", "angular_velocities")
        )
        return State(places / self.scale, np.arctan2(turns[:, 1], turns[:, 0]), velocities / self.scale, spins)


class Box2D2:
    """Box2D 2.4, from C++: impulses, and passes over the positions against overlap.

    Rectangles have a skin of 10 mm, and start 15 mm too near if they touch; it is thinner where `scale` is larger.
    """

    module = "Box2D 2.4"

    def __init__(self, pile: Pile, dt: float, velocity: int = 8, position: int = 3, scale: float = 1.0) -> None:
        self.library, self.dt, self.count = box2d_2(), dt, len(pile.mass)
        self.scale, pile = scale, pile.scaled(scale)
        self.iterations = velocity, position
        ends = np.array(lines(pile), dtype=np.float64)
        sizes = np.column_stack([pile.sizes, np.zeros((self.count, 2 - pile.sizes.shape[1]))])
        rows = np.ascontiguousarray(np.column_stack([pile.positions, pile.turns, sizes]))
        self.world = self.library.build(
            self.count,
            rows.ctypes,
            len(ends),
            ends.ctypes,
            *map(ctypes.c_double, (scale * GRAVITY, pile.density, FRICTION)),
        )

    def step(self, steps: int) -> None:
        """Take steps."""
        self.library.step(ctypes.c_void_p(self.world), steps, ctypes.c_double(self.dt), *self.iterations)

    def state(self) -> State:
        """Of all bodies."""
        rows = np.empty((self.count, 6))
        self.library.read(ctypes.c_void_p(self.world), rows.ctypes)
        return State(rows[:, :2] / self.scale, rows[:, 2], rows[:, 3:5] / self.scale, rows[:, 5])


@cache
def box2d_2() -> Any:
    """Functions of box2d.cpp, compiled here; None where there is no compiler, or no libbox2d with its headers."""
    compiler = shutil.which("c++") or shutil.which("g++")
    if compiler is None:
        return None
    target = Path(tempfile.mkdtemp(prefix="box2d-")) / "box2d.so"
    options = ["-O3", "-march=native", "-std=c++17", "-shared", "-fPIC"]
    command = [compiler, *options, str(Path(__file__).with_name("box2d.cpp")), "-lbox2d", "-o", str(target)]
    if subprocess.run(command, check=False, capture_output=True).returncode != 0:
        return None
    library = ctypes.CDLL(str(target))
    library.build.restype = ctypes.c_void_p
    library.version.restype = ctypes.c_char_p
    return library


def version(peer: Any) -> str | None:
    """Of an engine in 2D, None where it is not installed."""
    if peer is Box2D2:
        library = box2d_2()
        return library and f"Box2D {library.version().decode()}, C++"
    return optional(peer.module) and f"{peer.name} {importlib.metadata.version(peer.module)}{peer.note}"
