"""Textbook scenes with known motion, over ten periods or so: the table of docs/accuracy.md, and a test of the defaults.

The truth is a closed form, or the extrapolated midpoint rule on the equations of motion, written down here once more.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import physcore as pc

Array = np.ndarray[Any, np.dtype[np.float64]]
TEN = 10.0 * math.tau
G = 9.81


@dataclass(frozen=True)
class Textbook:
    """A scene with its truth."""

    name: str
    scene: pc.Scene
    duration: float
    """Ten periods of the slowest motion where there is one [s]."""
    truth: Callable[[Array], Array]
    """True values of what is observed at these times, one row for each."""
    size: float
    """Size of the motion, in the unit of the values."""
    observe: Callable[[pc.Recording], Array] = lambda recording: recording.positions
    """Values of a recording, frame by frame."""

    def error(self, recording: pc.Recording) -> float:
        """Largest distance from the truth at some 300 frames, relative to the size of the motion."""
        frames = slice(None, None, math.ceil(len(recording.times) / 300))
        found = self.observe(recording)[frames]
        away = np.abs(found - np.reshape(self.truth(recording.times[frames]), found.shape))
        return float(away.max()) / self.size


def solved(rates: Callable[[float, Array], Array], start: Array, times: Array, longest: float) -> Array:
    """The solution of y' = rates(t, y) at given times, by extrapolated midpoint steps of at most `longest` [s]."""
    state, now, found = np.array(start, dtype=float), 0.0, []
    for time in times:
        parts = max(1, math.ceil((time - now) / longest - 1e-9)) if time > now else 0
        for part in range(parts):
            h = (time - now) / parts
            state = _extrapolated(rates, now + part * h, state, h)
        now = float(time)
        found.append(state.copy())
    return np.array(found)


def _extrapolated(rates: Callable[[float, Array], Array], time: float, state: Array, h: float) -> Array:
    """One step of Gragg's method with 2, 4 … 14 substeps, extrapolated to order 14."""
    table: list[Array] = []
    for row, parts in enumerate(range(2, 16, 2)):
        small = h / parts
        before, here = state, state + small * rates(time, state)
        for part in range(1, parts):
            before, here = here, before + 2.0 * small * rates(time + part * small, here)
        new = [0.5 * (before + here + small * rates(time + h, here))]
        for column in range(row):
            ratio = (parts / (parts - 2 * (column + 1))) ** 2
            new.append(new[-1] + (new[-1] - table[column]) / (ratio - 1.0))
        table = new
    return table[-1]


def motion(
    acceleration: Callable[[float, Array, Array], Array], x: Any, v: Any, longest: float
) -> Callable[[Array], Array]:
    """Positions over time of x'' = acceleration(t, x, v)."""
    start = np.concatenate([np.ravel(x), np.ravel(v)]).astype(float)
    half, shape = len(start) // 2, np.shape(x)

    def rates(time: float, state: Array) -> Array:
        here, speed = state[:half], state[half:]
        return np.concatenate([speed, np.ravel(acceleration(time, here.reshape(shape), speed.reshape(shape)))])

    return lambda times: solved(rates, start, times, longest)[:, :half]


def kepler(e: float, far: bool) -> tuple[list[float], list[float], Callable[[Array], Array]]:
    """An orbit of semi-major axis 1 about GM = 1, from its far or its near end: place, velocity and motion."""
    sign = -1.0 if far else 1.0
    near = 1.0 + e if far else 1.0 - e
    speed = math.sqrt((1.0 - e) / (1.0 + e)) if far else math.sqrt((1.0 + e) / (1.0 - e))

    def place(times: Array) -> Array:
        mean = times + (math.pi if far else 0.0)
        anomaly = mean + e * np.sin(mean)
        for _ in range(60):  # Newton's method, damped by the bound of its step
            anomaly -= np.clip((anomaly - e * np.sin(anomaly) - mean) / (1.0 - e * np.cos(anomaly)), -0.5, 0.5)
        x, y = np.cos(anomaly) - e, math.sqrt(1.0 - e * e) * np.sin(anomaly)
        return sign * np.stack([x, y], axis=-1)

    return [near, 0.0], [0.0, speed], place


def _oscillators() -> list[Textbook]:
    """Springs and wells."""
    ends, link = [[0.0, 0.0], [1.2, 0.0]], [[0, 1]]
    mass = pc.SpringNetwork(ends, link, 100.0, rest_length=1.0, mass=1.0, fixed=[0])
    damped = pc.SpringNetwork(ends, link, 100.0, 1.0, rest_length=1.0, mass=1.0, fixed=[0])
    hanging = pc.SpringNetwork([[0.0, 0.0], [0.0, -1.0]], link, 100.0, rest_length=1.0, mass=1.0, fixed=[0])

    def last(axis: int) -> Callable[[pc.Recording], Array]:
        return lambda recording: recording.positions[:, -1, axis]

    quick = math.sqrt(100.0 - 0.25)
    chain = [[float(k), 0.0] for k in range(7)]
    modes = np.sin(np.pi * np.arange(7) / 6.0)
    displaced = np.array(chain) + 0.1 * np.stack([modes, 0.0 * modes], axis=-1)
    slow = 2.0 * math.sqrt(50.0) * math.sin(math.pi / 12.0)
    coupled = pc.SpringNetwork(
        [[0.0, 0.0], [1.2, 0.0], [2.0, 0.0], [3.0, 0.0]],
        [[0, 1], [1, 2], [2, 3]],
        [40.0, 5.0, 40.0],
        rest_length=1.0,
        mass=1.0,
        fixed=[0, 3],
    )
    even, odd = math.sqrt(40.0), math.sqrt(50.0)
    return [
        Textbook("mass on a spring", pc.Scene(mass), TEN / 10.0, lambda t: 1.0 + 0.2 * np.cos(10.0 * t), 0.2, last(0)),
        Textbook(
            "damped mass on a spring",
            pc.Scene(damped),
            TEN / quick,
            lambda t: 1.0 + 0.2 * np.exp(-0.5 * t) * (np.cos(quick * t) + 0.5 / quick * np.sin(quick * t)),
            0.2,
            last(0),
        ),
        Textbook(
            "mass on a spring under gravity",
            pc.Scene(hanging, pc.Gravity((0.0, -G))),
            TEN / 10.0,
            lambda t: -1.0 - G / 100.0 * (1.0 - np.cos(10.0 * t)),
            G / 100.0,
            last(1),
        ),
        Textbook(
            "two coupled masses",
            pc.Scene(coupled),
            TEN / even,
            lambda t: (
                np.array([1.0, 2.0])
                + 0.1 * np.cos(even * t)[:, None] * np.array([1.0, 1.0])
                + 0.1 * np.cos(odd * t)[:, None] * np.array([1.0, -1.0])
            ),
            0.2,
            lambda recording: recording.positions[:, 1:3, 0],
        ),
        Textbook(
            "chain of masses, lowest mode",
            pc.Scene(
                pc.SpringNetwork(
                    displaced, [[k, k + 1] for k in range(6)], 50.0, rest_length=1.0, mass=1.0, fixed=[0, 6]
                )
            ),
            TEN / slow,
            lambda t: np.array(chain)[:, 0] + 0.1 * np.cos(slow * t)[:, None] * modes,
            0.1,
            lambda recording: recording.positions[..., 0],
        ),
        Textbook(
            "harmonic well in the plane",
            pc.Scene(
                pc.Particles([[1.0, 0.0]], [[0.0, 2.0]], mass=1.0), pc.CentralForce((0.0, 0.0), 16.0, exponent=1.0)
            ),
            TEN / 4.0,
            lambda t: np.stack([np.cos(4.0 * t), 0.5 * np.sin(4.0 * t)], axis=-1),
            1.0,
        ),
        Textbook(
            "Duffing oscillator",
            pc.Scene(pc.Particles([[1.0, 0.0]]), pc.CustomForce(lambda time, x, v: -x - 4.0 * x**3 * (1.0, 0.0))),
            TEN / 2.0,
            motion(lambda time, x, v: -x - 4.0 * x**3 * (1.0, 0.0), [1.0, 0.0], [0.0, 0.0], 0.2),
            1.0,
        ),
    ]


def _pendulums() -> list[Textbook]:
    """Rods, and free motion with impacts."""
    rod = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], math.inf, mass=1.0, fixed=[0])
    period = 2.3678419475762374

    def swinging(times: Array) -> Array:
        start = np.array([math.pi / 2.0, 0.0])
        angle = solved(lambda time, y: np.array([y[1], -G * np.sin(y[0])]), start, times, 0.1)[:, 0]
        return np.stack([np.sin(angle), -np.cos(angle)], axis=-1)

    angles = np.array([0.5, 0.8])
    joints = np.cumsum(np.stack([np.sin(angles), -np.cos(angles)], axis=-1), axis=0)
    double = pc.SpringNetwork(np.vstack([[0.0, 0.0], joints]), [[0, 1], [1, 2]], math.inf, mass=1.0, fixed=[0])

    def rates(time: float, y: Array) -> Array:
        one, two, w, u = y
        c, s = math.cos(one - two), math.sin(one - two)
        right = np.array([-2.0 * G * math.sin(one) - u * u * s, -G * math.sin(two) + w * w * s])
        return np.array([w, u, *np.linalg.solve(np.array([[2.0, c], [c, 1.0]]), right)])

    def doubly(times: Array) -> Array:
        found = solved(rates, np.array([*angles, 0.0, 0.0]), times, 0.1)[:, :2]
        return np.cumsum(np.stack([np.sin(found), -np.cos(found)], axis=-1), axis=1)

    bounce = 2.0 * math.sqrt(2.0 / G)

    def bouncing(times: Array) -> Array:
        since = (times + 0.5 * bounce) % bounce - 0.5 * bounce
        return 1.0 - 0.5 * G * since * since

    def damped_bouncing(times: Array) -> Array:
        start, speed, found = 0.5 * bounce, 0.8 * math.sqrt(2.0 * G), []
        for time in times:
            while time > start + 2.0 * speed / G:
                start, speed = start + 2.0 * speed / G, 0.8 * speed
            since = time - start
            found.append(1.0 - 0.5 * G * time * time if since < 0.0 else speed * since - 0.5 * G * since * since)
        return np.array(found)

    def folded(times: Array) -> Array:
        free = np.array([0.2, 0.3]) + times[:, None] * np.array([1.0, 0.7])
        return 1.0 - np.abs(free % 2.0 - 1.0)

    def last_axis(recording: pc.Recording) -> Array:
        return recording.positions[:, 0, 1]

    ball = pc.Particles([[0.0, 1.0]], mass=1.0)
    fall = math.sqrt(G / 0.1)
    return [
        Textbook(
            "pendulum from the horizontal",
            pc.Scene(rod, pc.Gravity((0.0, -G))),
            10.0 * period,
            swinging,
            1.0,
            lambda recording: recording.positions[:, 1],
        ),
        Textbook(
            "double pendulum",
            pc.Scene(double, pc.Gravity((0.0, -G))),
            TEN / math.sqrt(G * (2.0 - math.sqrt(2.0))),
            doubly,
            2.0,
            lambda recording: recording.positions[:, 1:],
        ),
        Textbook(
            "projectile",
            pc.Scene(pc.Particles([[0.0, 0.0]], [[3.0, 10.0]]), pc.Gravity((0.0, -G))),
            2.0,
            lambda t: np.stack([3.0 * t, 10.0 * t - 0.5 * G * t * t], axis=-1),
            6.0,
        ),
        Textbook(
            "projectile with Stokes' drag",
            pc.Scene(pc.Particles([[0.0, 0.0]], [[3.0, 10.0]], mass=1.0), pc.Gravity((0.0, -G)), pc.Drag(linear=0.5)),
            3.0,
            lambda t: np.stack(
                [6.0 * (1.0 - np.exp(-0.5 * t)), 2.0 * (10.0 + 2.0 * G) * (1.0 - np.exp(-0.5 * t)) - 2.0 * G * t],
                axis=-1,
            ),
            6.0,
        ),
        Textbook(
            "fall with Newton's drag",
            pc.Scene(pc.Particles([[0.0, 0.0]], mass=1.0), pc.Gravity((0.0, -G)), pc.Drag(quadratic=0.1)),
            5.0,
            lambda t: -np.log(np.cosh(G * t / fall)) / 0.1,
            fall * 5.0,
            last_axis,
        ),
        Textbook(
            "bouncing ball",
            pc.Scene(ball, pc.Gravity((0.0, -G)), pc.Floor(0.0, restitution=1.0)),
            10.0 * bounce,
            bouncing,
            1.0,
            last_axis,
        ),
        Textbook(
            "bouncing ball with losses",
            pc.Scene(ball, pc.Gravity((0.0, -G)), pc.Floor(0.0, restitution=0.8)),
            4.0,
            damped_bouncing,
            1.0,
            last_axis,
        ),
        Textbook(
            "particle in a box",
            pc.Scene(
                pc.Particles([[0.2, 0.3]], [[1.0, 0.7]]), pc.Box((0.0, 0.0), (1.0, 1.0), restitution=1.0, friction=0.0)
            ),
            20.0,
            folded,
            1.0,
        ),
    ]


def _orbits() -> list[Textbook]:
    """Kepler's problem and its kin."""
    found = []
    for e, far in ((0.0, False), (0.5, False), (0.8, True), (0.9, False), (0.9, True)):
        place, velocity, orbit = kepler(e, far)
        end = "far" if far else "near"
        found.append(
            Textbook(
                f"orbit about a center, e = {e:g} from the {end} end",
                pc.Scene(pc.Particles([place], [velocity]), pc.CentralForce((0.0, 0.0), 1.0)),
                TEN,
                orbit,
                1.0,
            )
        )
    for e, far in ((0.0, False), (0.8, True), (0.9, False), (0.9, True)):
        place, velocity, orbit = kepler(e, far)
        end = "far" if far else "near"
        shares = np.array([0.25, -0.75])
        bodies = pc.Particles(np.outer(shares, place), np.outer(shares, velocity), mass=[0.75, 0.25])
        found.append(
            Textbook(
                f"two bodies, e = {e:g} from the {end} end",
                pc.Scene(bodies, pc.Gravitation(constant=1.0)),
                TEN,
                lambda t, orbit=orbit, shares=shares: orbit(t)[:, None, :] * shares[:, None],
                1.0,
            )
        )
    place, velocity, orbit = kepler(0.3, True)
    shares = np.array([0.5, -0.5])
    charges = pc.Particles(np.outer(shares, place), np.outer(shares, velocity), mass=2.0, charge=[1.0, -1.0])
    found.append(
        Textbook(
            "two opposite charges",
            pc.Scene(charges, pc.Coulomb(constant=1.0)),
            TEN,
            lambda t: orbit(t)[:, None, :] * shares[:, None],
            1.0,
        )
    )
    eight = np.array([[0.97000436, -0.24308753], [-0.97000436, 0.24308753], [0.0, 0.0]])
    speeds = np.array([[0.466203685, 0.43236573], [0.466203685, 0.43236573], [-0.93240737, -0.86473146]])

    def pull(time: float, x: Array, v: Array) -> Array:
        away = x[None] - x[:, None]
        far = np.linalg.norm(away, axis=-1) + np.eye(len(x))
        return (away / far[..., None] ** 3).sum(axis=1)

    found.append(
        Textbook(
            "three bodies on a figure of eight",
            pc.Scene(pc.Particles(eight, speeds, mass=1.0), pc.Gravitation(constant=1.0)),
            10.0 * 6.32591398,
            motion(pull, eight, speeds, 0.1),
            1.0,
        )
    )
    atoms = np.array([[0.0, 0.0], [1.3, 0.0]])

    def bond(time: float, x: Array, v: Array) -> Array:
        r = x[1, 0] - x[0, 0]

        def force(r: float) -> float:
            return 24.0 * (2.0 / r**13 - 1.0 / r**7)

        f = force(r) - force(2.5)
        return np.array([[-f, 0.0], [f, 0.0]])

    found.append(
        Textbook(
            "two atoms of Lennard and Jones",
            pc.Scene(pc.Particles(atoms, mass=1.0), pc.LennardJones(1.0, 1.0, cutoff=2.5)),
            8.0,
            motion(bond, atoms, np.zeros((2, 2)), 0.02),
            0.3,
        )
    )
    return found


def _charges() -> list[Textbook]:
    """Charges in electric and magnetic fields."""
    plus, minus = 0.5 * (6.0 + math.sqrt(36.0 - 2.0)), 0.5 * (6.0 - math.sqrt(36.0 - 2.0))
    trapped = [[0.1, 0.0, 0.1]]

    def penning(times: Array) -> Array:
        fast = 0.1 * minus / (minus - plus)
        slow = 0.1 - fast
        x = fast * np.cos(plus * times) + slow * np.cos(minus * times)
        y = -fast * np.sin(plus * times) - slow * np.sin(minus * times)
        return np.stack([x, y, 0.1 * np.cos(times)], axis=-1)

    def paul(time: float, x: Array, v: Array) -> Array:
        return 0.5 * math.cos(math.tau * time) * 10.0 * x * np.array([0.5, 0.5, -1.0])

    return [
        Textbook(
            "gyration",
            pc.Scene(pc.Particles([[0.0, 0.0]], [[1.0, 0.0]], mass=1.0, charge=1.0), pc.ElectromagneticField(0.0, 2.0)),
            TEN / 2.0,
            lambda t: 0.5 * np.stack([np.sin(2.0 * t), np.cos(2.0 * t) - 1.0], axis=-1),
            0.5,
        ),
        Textbook(
            "drift in crossed fields",
            pc.Scene(pc.Particles([[0.0, 0.0]], mass=1.0, charge=1.0), pc.ElectromagneticField((0.0, 1.0), 2.0)),
            TEN / 2.0,
            lambda t: 0.25 * np.stack([2.0 * t - np.sin(2.0 * t), 1.0 - np.cos(2.0 * t)], axis=-1),
            0.5,
        ),
        Textbook(
            "Penning trap",
            pc.Scene(
                pc.Particles(trapped, mass=1.0, charge=1.0),
                pc.ElectromagneticField(pc.QuadrupoleTrap(1.0), (0.0, 0.0, 6.0)),
            ),
            2.0 * math.tau / minus,
            penning,
            0.1,
        ),
        Textbook(
            "Paul trap",
            pc.Scene(pc.Particles(trapped, mass=1.0, charge=1.0), pc.ElectromagneticField(pc.PaulTrap(0.0, 5.0, 1.0))),
            30.0,
            motion(paul, trapped, [[0.0, 0.0, 0.0]], 0.05),
            0.1,
        ),
    ]


def _fields() -> list[Textbook]:
    """Waves, wave functions, reactions."""
    line = pc.Grid((200,), spacing=0.005)
    square = pc.Grid((128, 96), spacing=1.0 / 128.0)
    x = line.centers[:, 0]
    a, b = np.moveaxis(square.centers, -1, 0)
    drum = np.sin(math.pi * a) * np.sin(2.0 * math.pi * b / 0.75)
    tone = math.pi * math.hypot(1.0, 2.0 / 0.75)

    def after(moment: str) -> Callable[[pc.Recording], Array]:
        def observed(recording: pc.Recording) -> Array:
            item = recording.scene.systems[0]
            density, grid = recording[item].density, item.grid  # type: ignore[attr-defined]
            place = grid.centers[:, 0]
            mean = (density * place).sum(axis=1) * grid.spacing
            wide = np.sqrt((density * (place - mean[:, None]) ** 2).sum(axis=1) * grid.spacing)
            return mean if moment == "mean" else wide

        return observed

    free = pc.Grid.over(-40.0, 60.0, 0.1)
    packet = pc.Schrodinger(free, pc.wave_packet(free, 0.0, 2.0, 2.0))
    well = pc.Schrodinger(free, pc.wave_packet(free, 5.0, 0.0, math.sqrt(0.5)), potential=lambda x: 0.5 * x * x)
    rod = pc.Grid((50,), spacing=0.02)
    heat = pc.ReactionDiffusion(
        rod, pc.Reaction(("T",), lambda u: (0.0 * u,)), {"T": 0.1}, {"T": lambda x: np.cos(math.pi * x)}
    )
    decay = 4.0 * 0.1 / 0.02**2 * math.sin(math.pi / 100.0) ** 2
    cell = pc.Grid((4,), spacing=1.0)
    brusselator = pc.ReactionDiffusion(cell, pc.Brusselator(1.0, 3.0), {"u": 0.1, "v": 0.1}, {"u": 1.0, "v": 1.0})
    fast = pc.ReactionDiffusion(cell, pc.Brusselator(4.0, 18.0), {"u": 0.1, "v": 0.1}, {"u": 4.4, "v": 4.5})

    def kinetics(a: float, b: float) -> Callable[[float, Array], Array]:
        return lambda time, y: np.array([a - (b + 1.0) * y[0] + y[0] ** 2 * y[1], b * y[0] - y[0] ** 2 * y[1]])

    def concentration(recording: pc.Recording) -> Array:
        return recording[recording.scene.systems[0]]["u"][:, 0]

    def lorenz(time: float, y: Array) -> Array:
        return np.array([10.0 * (y[1] - y[0]), y[0] * (28.0 - y[2]) - y[1], y[0] * y[1] - 8.0 / 3.0 * y[2]])

    start = [1.0, 2.0, 20.0]
    pair = pc.PointVortices([[-0.5, 0.0], [0.5, 0.0]], [math.tau, math.tau])

    def first(name: str) -> Callable[[pc.Recording], Array]:
        return lambda recording: recording[recording.scene.systems[0]][name]

    return [
        Textbook(
            "string, third mode",
            pc.Scene(pc.Wave(line, 1.0, lambda x: np.sin(3.0 * math.pi * x))),
            TEN / (3.0 * math.pi),
            lambda t: np.cos(3.0 * math.pi * t)[:, None] * np.sin(3.0 * math.pi * x),
            1.0,
            first("displacement"),
        ),
        Textbook(
            "rectangular drum, mode (1, 2)",
            pc.Scene(pc.Wave(square, 1.0, drum)),
            TEN / tone,
            lambda t: np.cos(tone * t)[:, None, None] * drum,
            1.0,
            first("displacement"),
        ),
        Textbook("free wave packet", pc.Scene(packet), 15.0, lambda t: 2.0 * t, 10.0, after("mean")),
        Textbook(
            "spread of a wave packet",
            pc.Scene(packet),
            15.0,
            lambda t: 2.0 * np.sqrt(1.0 + (t / 8.0) ** 2),
            2.0,
            after("width"),
        ),
        Textbook("coherent state", pc.Scene(well), TEN, lambda t: 5.0 * np.cos(t), 5.0, after("mean")),
        Textbook(
            "heat in a rod",
            pc.Scene(heat),
            3.0,
            lambda t: np.exp(-decay * t)[:, None] * np.cos(math.pi * rod.centers[:, 0]),
            1.0,
            first("T"),
        ),
        Textbook(
            "Brusselator, a = 1, b = 3",
            pc.Scene(brusselator),
            70.0,
            lambda t: solved(kinetics(1.0, 3.0), np.array([1.0, 1.0]), t, 0.02)[:, 0],
            4.0,
            concentration,
        ),
        Textbook(
            "Brusselator, a = 4, b = 18",
            pc.Scene(fast),
            10.0,
            lambda t: solved(kinetics(4.0, 18.0), np.array([4.4, 4.5]), t, 0.002)[:, 0],
            12.0,
            concentration,
        ),
        Textbook(
            "Lorenz system",
            pc.Scene(pc.Tracers([start], pc.Lorenz())),
            6.0,
            lambda t: solved(lorenz, np.array(start), t, 0.02),
            20.0,
            first("positions"),
        ),
        Textbook(
            "pair of vortices",
            pc.Scene(pair),
            TEN / 2.0,
            lambda t: (
                0.5
                * np.stack(
                    [
                        np.stack([-np.cos(2.0 * t), -np.sin(2.0 * t)], -1),
                        np.stack([np.cos(2.0 * t), np.sin(2.0 * t)], -1),
                    ],
                    axis=1,
                )
            ),
            0.5,
            first("positions"),
        ),
    ]


TEXTBOOK = [*_oscillators(), *_pendulums(), *_orbits(), *_charges(), *_fields()]
