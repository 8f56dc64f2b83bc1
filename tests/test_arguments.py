"""The boundary where arguments enter: whatever is passed is taken, or refused by the name of the parameter."""

from __future__ import annotations

import inspect
import tracemalloc
import warnings
from collections.abc import Callable
from concurrent.futures import Executor, Future
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import physcore as pc
from physcore import styles
from physcore.film import Corotating, Follow, Keyframes, Orbit, Theme, Window, provenance
from physcore.film.colors.themes import DARK


class Hostile:
    """Fails at whatever it is asked."""

    def _fail(self, *arguments: object) -> Any:
        raise ZeroDivisionError("no")

    __float__ = __index__ = __len__ = __iter__ = __eq__ = __lt__ = __array__ = __fspath__ = __repr__ = _fail
    __hash__ = None  # type: ignore[assignment]


def circular() -> list[Any]:
    """A list that has itself in it, twice at every level."""
    result: list[Any] = []
    result += [result, result]
    return result


def deep() -> list[Any]:
    """A list that is nested more deeply than Python recurs."""
    result: list[Any] = []
    for _ in range(5000):
        result = [result]
    return result


def objects() -> np.ndarray:
    """An array that NumPy knows nothing about."""
    result = np.empty(2, dtype=object)
    result[0] = Hostile()
    return result


VALUES: dict[str, Any] = {
    "nothing": None,
    "true": True,
    "zero": 0,
    "minus one": -1,
    "too large for a float": 10**400,
    "too large to be written": 10**5000,
    "a huge count": 10**15,
    "the least number": 5e-324,
    "the largest number": 1.7e308,
    "a tiny number": 1e-9,
    "nan": float("nan"),
    "inf": float("inf"),
    "complex": 1j,
    "text": "fast",
    "a number as text": "1",
    "a null character": "a\0b",
    "a lone surrogate": "\ud800",
    "bytes": b"1",
    "bytearray": bytearray(b"1"),
    "an empty list": [],
    "a list of nothing": [None],
    "a ragged list": [[1.0], [1.0, 2.0]],
    "a circular list": circular(),
    "a deep list": deep(),
    "a list of large numbers": [10**400, 1.0],
    "a mapping": {"a": 1},
    "a set": {1, 2},
    "an object": object(),
    "a hostile object": Hostile(),
    "a class": pc.VelocityVerlet,
    "a class of items": pc.Drag,
    "a function": lambda *arguments: "nothing",
    "a generator": (number for number in (1.0, 2.0)),
    "an array of numbers": np.array([1, 2]),
    "an array of one number": np.array([1.0]),
    "an array of words": np.array(["auto", "f32"]),
    "an array of complex numbers": np.array([1j, 2.0]),
    "an array of objects": objects(),
    "a deep array of objects": np.empty((1,) * 64, dtype=object),
    "an array of times": np.array(["2020-01-01"], dtype="M8[D]"),
    "a masked array": np.ma.array([1.0, 2.0], mask=[True, False]),
    "masked": np.ma.masked,
    "a list with masked entries": [np.ma.masked, 1.0],
    "an array that is too large": np.broadcast_to(np.float64(0.0), (10**13, 2)),
    "a NumPy bool": np.True_,
    "a long double": np.longdouble("1e4000"),
    "a large fraction": Fraction(10**400, 3),
    "a decimal": Decimal("NaN"),
    "a time": np.timedelta64(1, "s"),
    "a path": Path("nowhere") / "at all.gif",
}

SHEET = pc.cloth((3, 3), 1.0, 1.0, origin=(0.0, 0.0, 0.0))
POINTS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
DISCS = pc.RigidBodies(pc.Disc(0.1), POINTS)
CORNERS = np.vstack([np.zeros(3), np.eye(3)])
SIDES = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
MESH = pc.Mesh(CORNERS, SIDES)
ONE = pc.Particles(POINTS, radius=0.1)
SCENE = pc.Scene(ONE, pc.Gravity((0.0, -1.0)))
RECORDING = pc.simulate(SCENE, 0.1)


def simulation(**options: Any) -> pc.Simulation:
    return pc.Simulation(SCENE, dt=1e-3, **options)


WAVES = [pc.Simulation(pc.Scene(wave), dt=1e-3)[wave] for wave in [pc.Wave(pc.Grid((3, 4), 0.5), 1.0)]]
FUNCTIONS = [
    pc.Simulation(pc.Scene(psi), dt=1e-3)[psi] for psi in [pc.Schrodinger(pc.Grid((3, 4), 0.5), np.ones((3, 4)))]
]


class AtOnce(Executor):
    """Computes what is submitted at once, without the processes that would take most of the time."""

    def submit(self, function: Callable[..., object], /, *arguments: object, **options: object) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(function(*arguments, **options))
        except Exception as error:
            future.set_exception(error)
        return future


CALLS: dict[str, tuple[Callable[..., object], dict[str, Any]]] = {
    "Particles": (pc.Particles, {"positions": POINTS}),
    "SpringNetwork": (pc.SpringNetwork, {"positions": POINTS, "pairs": [[0, 1]], "stiffness": 1.0}),
    "Fluid": (pc.Fluid, {"positions": POINTS, "spacing": 1.0}),
    "rope": (pc.rope, {"particles": 3, "length": 1.0, "stiffness": 1.0}),
    "cloth": (pc.cloth, {"shape": (2, 3), "spacing": 1.0, "stiffness": 1.0}),
    "cloth of a material": (pc.cloth, {"shape": (2, 3), "spacing": 1.0, "material": pc.materials.silk}),
    "Material": (
        pc.materials.Material,
        {"areal_density": 0.1, "warp": 2.0, "weft": 3.0, "shear": 1.0, "bending": 1e-6},
    ),
    "soft_body": (pc.soft_body, {"shape": (2, 3), "spacing": 1.0, "stiffness": 1.0}),
    "block": (pc.block, {"lower": (0.0, 0.0), "upper": (1.0, 1.0), "spacing": 0.5}),
    "ball": (pc.ball, {"center": (0.0, 0.0), "radius": 1.0, "spacing": 0.5}),
    "cylinder": (pc.cylinder, {"center": (0.0, 0.0, 0.0), "radius": 1.0, "height": 1.0, "spacing": 0.5}),
    "Gravity": (pc.Gravity, {"acceleration": (0.0, -1.0)}),
    "Drag": (pc.Drag, {"linear": 1.0}),
    "CentralForce": (pc.CentralForce, {"center": (0.0, 0.0), "strength": 1.0}),
    "Dihedral": (pc.Dihedral, {"on": SHEET, "stiffness": 1.0}),
    "Wind": (pc.Wind, {"velocity": (1.0, 0.0, 0.0)}),
    "SelfContact": (pc.SelfContact, {"body": SHEET, "thickness": 0.1}),
    "Wire": (pc.Wire, {"points": [[0.0, 0.0], [1.0, 1.0]]}),
    "RigidBodies": (pc.RigidBodies, {"shape": pc.Disc(0.1), "positions": POINTS}),
    "RigidBodies in 3D": (
        pc.RigidBodies,
        {"shape": pc.Ball(0.1), "positions": CORNERS, "orientations": (0.0, 1.0, 0.0, 0.0)},
    ),
    "RigidBody": (pc.RigidBody, {"shape": pc.Disc(0.1), "position": (0.0, 1.0)}),
    "Disc": (pc.Disc, {"radius": 0.1}),
    "Rectangle": (pc.Rectangle, {"width": 0.1, "height": 0.2}),
    "Polygon": (pc.Polygon, {"vertices": POINTS}),
    "Ball": (pc.Ball, {"radius": 0.1}),
    "Cuboid": (pc.Cuboid, {"a": 0.1, "b": 0.2, "c": 0.3}),
    "Hull": (pc.Hull, {"points": CORNERS}),
    "MeshShape": (pc.MeshShape, {"vertices": CORNERS, "faces": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]}),
    "Compound": (pc.Compound, {"shapes": [(pc.Disc(0.1), (0.0, 0.0)), (pc.Disc(0.1), (1.0, 0.0), 0.5)]}),
    "Compound of arrays": (
        pc.Compound,
        {"shapes": [pc.Disc(0.1)], "positions": [(0.0, 0.0)], "angles": [0.5], "orientations": None},
    ),
    "Hinge": (pc.Hinge, {"one": (DISCS, 0), "other": (DISCS, 1), "anchor": (0.5, 0.0)}),
    "BallJoint": (pc.BallJoint, {"one": (DISCS, 0), "other": (ONE, 1), "anchor": (1.0, 0.0)}),
    "Weld": (pc.Weld, {"one": (DISCS, 0), "other": None}),
    "Prismatic": (pc.Prismatic, {"one": (DISCS, 0), "other": None, "axis": (1.0, 0.0)}),
    "Rod": (pc.Rod, {"one": (DISCS, 0), "other": (DISCS, 1)}),
    "SpringJoint": (pc.SpringJoint, {"one": (DISCS, 0), "other": (DISCS, 1), "anchors": None, "stiffness": 1.0}),
    "Motor": (pc.Motor, {"joint": pc.Hinge((DISCS, 0), None, (0.0, 0.0)), "speed": 1.0, "torque": 1.0}),
    "Anchor": (pc.Anchor, {"network": ONE, "indices": [0], "body": (DISCS, 0)}),
    "SoftSpheres": (pc.SoftSpheres, {"stiffness": 1.0}),
    "Gravitation": (pc.Gravitation, {"constant": 1.0}),
    "Coulomb": (pc.Coulomb, {"constant": 1.0}),
    "ElectromagneticField": (pc.ElectromagneticField, {"magnetic": 1.0}),
    "UniformField": (pc.UniformField, {"field": (0.0, 0.0, 1.0)}),
    "QuadrupoleTrap": (pc.QuadrupoleTrap, {"strength": 1.0}),
    "PaulTrap": (pc.PaulTrap, {"constant": 0.0, "alternating": 1.0, "frequency": 1.0}),
    "MagneticDipole": (pc.MagneticDipole, {"moment": (0.0, 0.0, 1.0)}),
    "CurrentLoop": (pc.CurrentLoop, {"radius": 1.0, "current": 1.0}),
    "MagneticBottle": (pc.MagneticBottle, {"strength": 1.0, "length": 1.0}),
    "TravellingWave": (
        pc.TravellingWave,
        {"amplitude": (0.0, 1.0), "wave_vector": (1.0, 0.0), "frequency": 1.0},
    ),
    "LennardJones": (pc.LennardJones, {"epsilon": 1.0, "sigma": 1.0}),
    "CustomForce": (pc.CustomForce, {"function": lambda time, x, v: -x}),
    "Floor": (pc.Floor, {}),
    "Plane": (pc.Plane, {"point": (0.0, 0.0), "normal": (0.0, 1.0)}),
    "Box": (pc.Box, {"lower": (0.0, 0.0), "upper": (1.0, 1.0)}),
    "Capsule": (pc.Capsule, {"start": (0.0, 0.0), "end": (1.0, 0.0), "radius": 0.1}),
    "ConvexHull": (pc.ConvexHull, {"points": [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]}),
    "HeightField": (pc.HeightField, {"heights": [0.0, 1.0], "spacing": 1.0}),
    "HeightField.over": (
        pc.HeightField.over,
        {"function": lambda x: x, "lower": 0.0, "upper": 1.0, "spacing": 1.0},
    ),
    "Sphere": (pc.Sphere, {"center": (0.0, 0.0), "radius": 1.0}),
    "Periodic": (pc.Periodic, {"lower": (0.0, 0.0), "upper": (1.0, 1.0)}),
    "Grid": (pc.Grid, {"cells": (3, 4), "spacing": 0.5}),
    "Grid.over": (pc.Grid.over, {"lower": (0.0, 0.0), "upper": (1.0, 2.0), "spacing": 0.5}),
    "Absorbing": (pc.Absorbing, {}),
    "Dirichlet": (pc.Dirichlet, {"value": 1.0}),
    "Neumann": (pc.Neumann, {"gradient": 1.0}),
    "Wave": (pc.Wave, {"grid": pc.Grid((3, 4), 0.5), "speed": 1.0}),
    "Lorenz": (pc.Lorenz, {}),
    "Rossler": (pc.Rossler, {}),
    "Aizawa": (pc.Aizawa, {}),
    "Thomas": (pc.Thomas, {}),
    "Halvorsen": (pc.Halvorsen, {}),
    "Flow": (pc.Flow, {"function": lambda time, x: -x}),
    "Tracers": (pc.Tracers, {"positions": POINTS, "flow": pc.Flow(lambda time, x: -x)}),
    "PointVortices": (pc.PointVortices, {"centers": POINTS, "circulations": 1.0}),
    "Source": (pc.Source, {"where": (0.5, 0.5), "amplitude": 1.0, "frequency": 1.0}),
    "Ricker": (pc.Ricker, {"frequency": 1.0}),
    "ReactionDiffusion": (
        pc.ReactionDiffusion,
        {
            "grid": pc.Grid((3, 4), 0.5),
            "reaction": pc.GrayScott(0.04, 0.06),
            "diffusion": {"u": 1.0, "v": 0.5},
            "initial": {"u": 1.0, "v": 0.0},
        },
    ),
    "a species": (
        lambda u=1.0, v=0.5: pc.ReactionDiffusion(
            pc.Grid((3, 4), 0.5), pc.GrayScott(0.04, 0.06), {"u": u, "v": v}, {"u": 1.0, "v": v}
        ),
        {},
    ),
    "GrayScott": (pc.GrayScott, {"feed": 0.04, "kill": 0.06}),
    "GrayScott.pearson": (pc.GrayScott.pearson, {"pattern": "mu"}),
    "FitzHughNagumo": (pc.FitzHughNagumo, {}),
    "Brusselator": (pc.Brusselator, {"a": 1.0, "b": 2.0}),
    "Schnakenberg": (pc.Schnakenberg, {"a": 0.1, "b": 0.9}),
    "Reaction": (pc.Reaction, {"species": ("n",), "function": lambda n: (n * (1.0 - n),)}),
    "Schrodinger": (pc.Schrodinger, {"grid": pc.Grid((3, 4), 0.5), "wave_function": np.ones((3, 4))}),
    "wave_packet": (pc.wave_packet, {"grid": pc.Grid((3, 4), 0.5), "center": 1.0, "momentum": 1.0, "width": 0.5}),
    "SplitStep": (pc.SplitStep, {}),
    "CrankNicolson": (pc.CrankNicolson, {}),
    "Staggered": (pc.Staggered, {}),
    "RungeKuttaChebyshev": (pc.RungeKuttaChebyshev, {}),
    "a part of a system": (
        lambda displacement=0.0, rate=0.0: WAVES[0].set(
            displacement=0.0 if displacement is None else displacement, rate=rate
        ),
        {},
    ),
    "a part of a wave function": (
        lambda wave_function=1.0: FUNCTIONS[0].set(wave_function=wave_function),
        {"wave_function": np.ones((3, 4))},
    ),
    "WendlandC2": (pc.WendlandC2, {}),
    "WendlandC4": (pc.WendlandC4, {}),
    "CubicSpline": (pc.CubicSpline, {}),
    "AutoStep": (pc.AutoStep, {}),
    "AdaptiveStep": (pc.AdaptiveStep, {}),
    "Scene": (lambda item=SCENE.bodies[0]: pc.Scene(item), {}),
    "Simulation": (pc.Simulation, {"scene": SCENE}),
    "step": (lambda n=1: simulation().step(n), {}),
    "run": (lambda duration=0.01: simulation().run(duration), {}),
    "frames": (
        lambda duration=0.01, fps=30.0: list(zip(range(2), simulation().frames(duration, fps), strict=False)),
        {},
    ),
    "frames of automatic steps": (
        lambda duration=0.01, fps=30.0: list(zip(range(2), pc.Simulation(SCENE).frames(duration, fps), strict=False)),
        {},
    ),
    "record": (
        lambda duration=0.01, fps=30.0, channels=("positions",), progress=None: simulation().record(
            duration, fps, channels, progress=progress
        ),
        {},
    ),
    "set": (lambda positions=None, velocities=None: simulation().set(positions, velocities), {}),
    "save": (lambda path=Path("/nowhere/x"): simulation().save(path), {"path": "state"}),
    "load": (pc.load, {"path": "/nowhere/x"}),
    "save a recording": (lambda path=Path("/nowhere/x"): RECORDING.save(path), {"path": "run"}),
    "export": (pc.export, {"recording": RECORDING, "path": Path("x.xyz")}),
    "export a scene": (pc.export, {"recording": SCENE, "path": Path("x.xyz"), "duration": 1e-3}),
    "read": (pc.read, {"path": "/nowhere/x.stl"}),
    "read a picture": (pc.read, {"path": Path(__file__).parents[1] / "docs" / "images" / "drape.png"}),
    "Mesh": (pc.Mesh, {"vertices": CORNERS, "faces": SIDES}),
    "moved": (MESH.moved, {}),
    "cloth of a mesh": (MESH.cloth, {"stiffness": 1.0, "areal_density": 1.0}),
    "rigid body of a mesh": (MESH.rigid_body, {}),
    "boundary of a mesh": (MESH.boundary, {}),
    "contains": (MESH.contains, {"points": CORNERS}),
    "fill": (MESH.fill, {"spacing": 0.2}),
    "from_mesh": (pc.from_mesh, {"mesh": SimpleNamespace(vertices=CORNERS, faces=SIDES)}),
    "Atoms": (pc.Atoms, {"positions": CORNERS, "species": "H"}),
    "atoms of a species": (pc.Atoms(CORNERS, "H").of, {"species": "H"}),
    "Signal": (pc.Signal, {"values": [0.0, 1.0], "rate": 2.0}),
    "channel": (pc.Signal([[0.0, 1.0]], 2.0).channel, {"index": 0}),
    "text of a picture": (pc.Picture.text, {"text": "R"}),
    "mask": (pc.Picture.text("R").mask, {}),
    "outline": (pc.Picture.text("R").outline, {"height": 0.1}),
    "height_field": (pc.Picture.text("R").height_field, {"width": 1.0, "lowest": 0.0, "highest": 1.0}),
    "solid": (pc.HeightField([0.0, 1.0], 1.0).solid, {"depth": 1.0}),
    "film": (pc.film, {"recording": RECORDING, "path": "film.png", "size": (64, 48)}),
    "film a scene": (pc.film, {"recording": SCENE, "path": "film.png", "duration": 1e-3, "size": (64, 48)}),
    "provenance": (provenance, {"path": "/nowhere/x.gif"}),
    "stability_limit": (pc.stability_limit, {"scene": SCENE, "integrator": pc.VelocityVerlet()}),
    "tradeoff": (
        pc.tradeoff,
        {"scene": SCENE, "duration": 1e-3, "budget": 1e-3, "integrators": [pc.VelocityVerlet()], "dts": [1e-3]},
    ),
    "sweep": (
        pc.sweep,
        {
            "build": lambda stiffness: SCENE,
            "parameters": {"stiffness": [1.0]},
            "duration": 1e-3,
            "measure": len,
            "executor": AtOnce(),
        },
    ),
    "Window": (Window, {"lower": (0.0, 0.0), "upper": (1.0, 1.0)}),
    "Orbit": (Orbit, {}),
    "Keyframes": (Keyframes, {"cameras": {0.0: Orbit(), 1.0: Orbit()}}),
    "Follow": (Follow, {"bodies": 0}),
    "Corotating": (Corotating, {"first": 0, "second": 1}),
    "Theme": (Theme, {name: getattr(DARK, name) for name in inspect.signature(Theme).parameters}),
    **{f"styles.{kind.__name__}": (kind, {}) for kind in styles.STYLES},
}

CALLS["simulate"] = (pc.simulate, {"scene": SCENE, "duration": 1e-3})
CALLS["simulate to an accuracy"] = (
    pc.simulate,
    {"scene": SCENE, "duration": 0.1, "accuracy": 0.1, "integrator": pc.VelocityVerlet()},
)
LEGITIMATE = {("step", "n", "a huge count"), ("tradeoff", "observe", "a class")}
"""What takes a year, and a function of the user's that fails by itself."""
NUMERICS = ("integrator", "dt", "precision", "threads", "max_energy_growth", "on_divergence")


def parameters(function: Callable[..., object]) -> list[str]:
    """The arguments that can be given by name."""
    given = inspect.signature(function).parameters.values()
    names = [each.name for each in given if each.kind in (each.POSITIONAL_OR_KEYWORD, each.KEYWORD_ONLY)]
    return [*names, *(NUMERICS if any(each.kind == each.VAR_KEYWORD for each in given) else ())]


@pytest.mark.parametrize("call", [call for call in CALLS if call not in ("load", "provenance", "read")])
def test_what_is_right_is_taken(call, tmp_path, monkeypatch):
    """So that the errors below are those of one argument."""
    monkeypatch.chdir(tmp_path)
    function, arguments = CALLS[call]
    function(**arguments)


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
@pytest.mark.parametrize(
    ("call", "parameter"), [(call, name) for call, (function, _) in CALLS.items() for name in parameters(function)]
)
def test_any_value_of_any_argument_is_taken_or_refused_by_name(call, parameter, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    function, arguments = CALLS[call]
    messages: list[str] = []
    for name, value in VALUES.items():
        if (call, parameter, name) in LEGITIMATE:
            continue
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", pc.SceneWarning)
                function(**{**arguments, parameter: value})
        except pc.PhyscoreError as error:
            messages.append(str(error))
        except Exception as error:
            pytest.fail(f"{call}({parameter}={name}): {type(error).__name__}: {str(error)[:200]}")
    assert all(len(message) < 1000 for message in messages)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (
            lambda: pc.Particles(POINTS, mass=10**400),
            "Particles.mass: must be at most 1.8e.308 in size, got a wh",
        ),
        (lambda: pc.Particles(POINTS, mass=[1.0, 10**400, 1.0]), r"Particles.mass\[1\]: must be at most 1.8e.308"),
        (lambda: pc.Gravity((0.0, 10**400)), r"Gravity.acceleration\[1\]: must be at most 1.8e.308"),
        (lambda: pc.Floor(np.longdouble("1e4000")), "Floor.height: must be finite, got inf"),
        (lambda: pc.Floor("1"), "Floor.height: must be a number, got '1', which is text"),
        (lambda: pc.Floor(b"1"), "Floor.height: must be a number, got b'1', which is bytes"),
        (lambda: pc.Floor(1j), "Floor.height: must be a number, got 1j, which is complex"),
        (lambda: pc.Floor(np.ma.masked), "Floor.height: must be a number, got masked, which is masked"),
        (lambda: pc.Floor([1.0]), r"Floor.height: must be a number, got \[1.0\]"),
        (lambda: pc.Floor(np.array([1.0])), r"Floor.height: must be a number, .*, an array of shape \(1,\)"),
        (
            lambda: pc.Particles([[0.0, 1j]]),
            "positions: must be an array of real numbers, .*, which is complex",
        ),
        (
            lambda: pc.Particles([["a", "b"]]),
            "positions: must be an array of real numbers, .*, which is text",
        ),
        (lambda: pc.Particles([[np.ma.masked, 1.0]]), "Particles.positions: must not have masked entries"),
        (lambda: pc.Particles(POINTS, fixed=[1j]), "Particles.fixed: must be a bool mask or .*, which is complex"),
        (
            lambda: pc.Periodic(("0", "0"), (1, 1)),
            "lower: must be an array of real numbers, .*, which is text",
        ),
        (lambda: pc.Periodic(np.ma.array([0.0, 1.0], mask=[1, 0]), (1, 1)), "Periodic.lower: must not have masked"),
        (lambda: pc.Particles(circular()), "Particles.positions: must be an array of numbers, got lists in lists"),
        (lambda: pc.Fluid(POINTS, 1.0, obstacles="no"), "Fluid.obstacles: must be True or False, got 'no'"),
        (lambda: pc.Fluid(POINTS, 1e-51), "Fluid.spacing: must be ≥ 1e-50"),
        (lambda: pc.Fluid(POINTS, 1e-50, 1e-300), "Fluid.density: density · spacing.2 must be a finite mass above 0"),
        (
            lambda: simulation(precision=np.array([1, 2])),
            r"precision: must be 'f32', 'f64' or 'auto', got array\(",
        ),
        (lambda: pc.Simulation(SCENE, dt=np.array([1, 2])), "dt: must be a number"),
        (lambda: simulation().set({0: [0.0, 0.0], "none": 1.0}), "set.positions: no body 'none'"),
        (lambda: SCENE.targets(0), "targets.item: must be a force or a boundary, got 0"),
        (lambda: list(simulation().frames(0.05, fps=5e-324)), "fps: must be ≥ 1e-100"),
        (lambda: simulation().record(1.0, fps=1e300), "fps: must be ≤ 1e.100"),
        (lambda: simulation().record(1.0, fps=1e13, channels=()), "duration: 10000000000001 frames .* GB are free"),
        (lambda: simulation().save(None), "path: must be the name of a file, a string or a pathlib.Path, got None"),
        (lambda: pc.export(RECORDING, "\udcff.pvd"), "path: must be a string without lone surrogates"),
        (lambda: simulation().save("a\0b"), "path: must be a name without null characters"),
        (lambda: Theme(**{**vars(DARK), "text": "reed"}), "Theme.text: must be like '#10c0ff'"),
    ],
)
def test_what_is_wrong_with_an_argument_is_said(build, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(pc.SceneError, match=message):
        build()


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: pc.block((0, 0), (1, 1), 1e-9), r"block.spacing: 1e.18 cells take 4.8e.10 GB, and .* GB are free"),
        (lambda: pc.block((0, 0), (1, 1), 1e-99), "block.spacing: .* cells take .* GB"),
        (lambda: pc.ball((0, 0, 0), 1.0, 1e-6), "ball.spacing: 8e.18 cells take"),
        (lambda: pc.cylinder((0, 0, 0), 1.0, 1e9, 1e-2), "cylinder.spacing: .* cells take"),
        (lambda: pc.rope(10**15, 1.0, 1.0), "rope.particles: 1000000000000000 particles take 2.25e.08 GB"),
        (lambda: pc.cloth((10**6, 10**6), 1.0, 1.0), "cloth.shape: 1000000000000 particles with their springs take"),
        (lambda: pc.soft_body((10**5,) * 3, 1.0, 1.0), "soft_body.shape: 1000000000000000 particles with their spri"),
        (lambda: pc.Fluid(np.broadcast_to(0.0, (10**13, 2)), 1.0), "Fluid.positions: 20000000000000 numbers take"),
        (lambda: pc.Particles(np.broadcast_to(0.0, (10**13, 2))), "Particles.positions: 20000000000000 numbers take"),
        (lambda: pc.film(SCENE, "x.gif", duration=1e13, fps=50), "duration: the times of 500000000000001 frames take"),
    ],
)
def test_what_does_not_fit_into_memory_is_refused_before_it_is_allocated(build, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    tracemalloc.start()
    try:
        with pytest.raises(pc.SceneError, match=message):
            build()
        assert tracemalloc.get_traced_memory()[1] < 10**7
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    "build",
    [
        lambda: pc.rope(20_000, 1.0, 1.0, start=(0.0, 0.0, 0.0)),
        lambda: pc.cloth((140, 140), 0.1, 1.0, origin=(0.0, 0.0, 0.0)),
        lambda: pc.soft_body((27, 27, 27), 0.1, 1.0),
        lambda: pc.block((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), 0.03),
        lambda: pc.ball((0.0, 0.0), 1.0, 0.01),
        lambda: pc.cylinder((0.0, 0.0, 0.0), 1.0, 1.0, 0.04),
    ],
)
def test_the_memory_that_a_builder_is_said_to_take_is_what_it_takes(build, monkeypatch):
    """At least the peak that is measured, up to a hundredth for small objects, and at most twice that."""
    said: list[float] = []
    monkeypatch.setattr("physcore.memory.require", lambda needed, *arguments: said.append(needed))
    tracemalloc.start()
    build()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak <= 1.01 * max(said) <= 2.0 * peak
