"""Scenes in other coordinates and units: what every kind of item becomes in a similarity transformation.

A force, boundary or body joins the contracts about symmetry by one entry in `QUANTITIES`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

import physcore as pc
from contracts import rigid
from physcore.scene.bodies import Body
from physcore.scene.edges import Condition, Valued
from physcore.scene.grid import GridSystem
from physcore.scene.items import ActingItem
from physcore.scene.points import PointSystem
from physcore.scene.selection import Selection
from physcore.systems.kinetics import Kinetics

Array = NDArray[np.float64]
FAR = 1e3
"""Where a box ends along an axis that it did not have [m]."""


@dataclass(frozen=True)
class Transform:
    """x → m (A x + shift), v → (m/s) (A v + boost); A permutes axes, changes signs, or embeds the plane in space."""

    axes: Array
    """A, shape (new dimension, old dimension)."""
    shift: Array | float = 0.0
    boost: Array | float = 0.0
    m: float = 1.0
    """What a meter becomes."""
    s: float = 1.0
    """What a second becomes."""
    kg: float = 1.0
    """What a kilogram becomes."""

    def unit(self, length: float = 0.0, time: float = 0.0, mass: float = 0.0) -> float:
        """What m^length s^time kg^mass becomes."""
        return self.m**length * self.s**time * self.kg**mass

    def points(self, x: Any) -> Array:
        """Positions, shape (…, D)."""
        return (np.asarray(x) @ self.axes.T + self.shift) * self.m

    def velocities(self, v: Any) -> Array:
        """Velocities, shape (…, D)."""
        return (np.asarray(v) @ self.axes.T + self.boost) * self.unit(1, -1)

    def directions(self, a: Any) -> Array:
        """Vectors that are the same wherever one stands and however one moves, shape (…, D)."""
        return np.asarray(a) @ self.axes.T

    def corners(self, lower: Any, upper: Any, far: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Those of a box along the axes; that far away along an axis that is new."""
        shift = np.broadcast_to(self.shift, len(self.axes))
        ends = []
        for axis, start in zip(self.axes, shift, strict=True):
            partner = int(np.abs(axis).argmax())
            pair = (axis[partner] * lower[partner], axis[partner] * upper[partner]) if axis.any() else (-far, far)
            ends.append(sorted((end + start) * self.m for end in pair))
        return tuple(low for low, _ in ends), tuple(high for _, high in ends)


Rule = Callable[[Transform, Any], Any]


def scalar(length: float = 0.0, time: float = 0.0, mass: float = 0.0) -> Rule:
    """A number of these dimensions; None and words stay."""
    return lambda t, value: value if value is None or isinstance(value, str) else value * t.unit(length, time, mass)


def per_volume(length: float = 0.0, time: float = 0.0) -> Rule:
    """kg m^length s^time per m² in the plane, per m³ in space."""
    return lambda t, value: scalar(length - len(t.axes), time, 1)(t, value)


def vector(length: float = 0.0, time: float = 0.0) -> Rule:
    """A direction, of a length of these dimensions."""
    return lambda t, value: tuple(t.directions(value) * t.unit(length, time))


def point(t: Transform, value: Any) -> Any:
    """A position."""
    return tuple(t.points(value))


def wind(t: Transform, value: Any) -> Any:
    """A velocity; None is zero. A function of time and positions is one of those that it was written for."""
    if callable(value):
        return lambda time, x: t.velocities(value(time / t.s, (x / t.m - t.shift) @ t.axes))
    return tuple(t.velocities(np.zeros(t.axes.shape[1]) if value is None else value))


RESISTANCE = scalar(0, -1, 1)
PARTICLES = {"positions": Transform.points, "velocities": Transform.velocities, "radius": scalar(1)}
MASSES = {**PARTICLES, "mass": scalar(0, 0, 1)}
QUANTITIES: dict[type, dict[str, Rule]] = {
    pc.Gravity: {"acceleration": vector(1, -2)},
    pc.Drag: {"linear": RESISTANCE, "quadratic": scalar(-1, 0, 1), "wind": wind},
    pc.CentralForce: {"center": point, "softening": scalar(1)},
    pc.SelfContact: {"thickness": scalar(1)},
    pc.Wire: {"points": Transform.points},
    pc.Dihedral: {"stiffness": scalar(2, -2, 1), "damping": scalar(2, -1, 1)},
    pc.Wind: {"velocity": wind, "density": per_volume()},
    pc.SoftSpheres: {"damping": RESISTANCE, "tangential_damping": RESISTANCE},
    pc.LennardJones: {"epsilon": scalar(2, -2, 1), "sigma": scalar(1), "cutoff": scalar(1)},
    pc.Gravitation: {"constant": scalar(3, -2, -1), "softening": scalar(1)},
    pc.Coulomb: {"constant": scalar(3, -2, 1), "softening": scalar(1)},
    pc.QuadrupoleTrap: {"strength": scalar(0, -2, 1), "center": point},
    pc.MagneticBottle: {"strength": scalar(0, -1, 1), "length": scalar(1), "center": point},
    pc.Plane: {"point": point, "normal": vector()},
    pc.Sphere: {"center": point, "radius": scalar(1)},
    pc.Capsule: {"start": point, "end": point, "radius": scalar(1)},
    pc.ConvexHull: {"points": Transform.points},
    **{kind: {"anchor": point, "breaking_force": scalar(1, -2, 1)} for kind in (pc.Hinge, pc.BallJoint, pc.Weld)},
    pc.Prismatic: {
        "anchor": point,
        "axis": vector(),
        "lower": scalar(1),
        "upper": scalar(1),
        "breaking_force": scalar(1, -2, 1),
    },
    pc.Rod: {"anchors": Transform.points, "breaking_force": scalar(1, -2, 1)},
    pc.SpringJoint: {
        "anchors": Transform.points,
        "stiffness": scalar(0, -2, 1),
        "damping": RESISTANCE,
        "rest_length": scalar(1),
        "breaking_force": scalar(1, -2, 1),
    },
    pc.Particles: MASSES,
    pc.SpringNetwork: {**MASSES, "stiffness": scalar(0, -2, 1), "damping": RESISTANCE, "rest_length": scalar(1)},
    pc.Fluid: {
        **PARTICLES,
        "spacing": scalar(1),
        "density": per_volume(),
        "viscosity": per_volume(2, -1),
        "surface_tension": per_volume(3, -2),
    },
}
"""The parameters that change; what is not named stays. Laws with an exponent and boxes are below."""


def _changed(item: Any, values: dict[str, Any], t: Transform) -> dict[str, Any]:
    rules = QUANTITIES.get(type(item), {})
    result = {name: rules[name](t, value) if name in rules else value for name, value in values.items()}
    if isinstance(item, (pc.CentralForce, pc.SoftSpheres)):  # a force at 1 m, and at an overlap of 1 m
        name = "strength" if isinstance(item, pc.CentralForce) else "stiffness"
        result[name] = values[name] * t.unit(1 - item.exponent, -2, 1)
    if isinstance(item, pc.Box):
        result["lower"], result["upper"] = t.corners(item.lower, item.upper, FAR)
    return result


def _body(body: Body, t: Transform, order: NDArray[np.int64]) -> Body:
    """Its particles in another order: particle k is the one that was particle order[k]."""
    if isinstance(body, pc.RigidBodies):
        return rigid.bodies(body, t, order)
    values = {entry.name: getattr(body, entry.name) for entry in fields(body)}
    if isinstance(body, pc.Fluid):
        values = {name: value for name, value in values.items() if name not in ("mass", "charge", "radius", "fixed")}
    for name in {"positions", "velocities", "mass", "charge", "radius", "fixed"} & set(values):
        values[name] = values[name][order]
    for name in {"pairs", "faces"} & set(values):
        values[name] = np.argsort(order)[values[name]]
    return type(body)(**_changed(body, values, t))


def _item(item: ActingItem, t: Transform, bodies: dict[Body, Body], orders: dict[Body, Array]) -> ActingItem:
    def target(given: Any) -> Any:
        if isinstance(given, Selection):
            return bodies[given.body], given.mask[orders[given.body]]
        return bodies[given]

    given = {name: item.targets(name) for name in item.naming}
    named = {name: tuple(map(target, own)) if own else None for name, own in given.items()}
    on = named.get("on")
    if isinstance(item, pc.CustomForce):
        return _custom(item, t, on)
    if isinstance(item, pc.ElectromagneticField):
        return _electromagnetic(item, t, on)
    if isinstance(item, pc.HeightField):
        return _height_field(item, t, on)
    if isinstance(item, pc.Floor):  # which is no floor where another axis is up
        up = np.eye(t.axes.shape[1])[-1]
        shared = {"restitution": item.restitution, "friction": item.friction, "no_slip": item.no_slip, "on": on}
        return pc.Plane(tuple(t.points(item.height * up)), tuple(t.directions(up)), **shared)
    values = {entry.name: getattr(item, entry.name) for entry in fields(item) if entry.init and entry.name not in named}
    if isinstance(item, pc.Anchor):
        values["indices"] = item.tied.mask[orders[item.tied.body]]
    return type(item)(**rigid.joint(item, _changed(item, values, t), t), **named)


def _custom(force: pc.CustomForce, t: Transform, on: Any) -> pc.CustomForce:
    """The function in the coordinates that it was written for. Aᵀ is the way back, as A keeps lengths."""

    def back(x: Array) -> Array:
        return (x / t.m - t.shift) @ t.axes

    def function(time: float, x: Array, v: Array) -> Array:
        rate = (v / t.unit(1, -1) - t.boost) @ t.axes
        return t.directions(force.function(time / t.s, back(x), rate)) * t.unit(1, -2, 1)

    def potential(x: Array) -> float:
        assert force.potential is not None
        return force.potential(back(x)) * t.unit(2, -2, 1)

    return pc.CustomForce(function, None if force.potential is None else potential, on=on)


def _height_field(ground: pc.HeightField, t: Transform, on: Any) -> pc.HeightField:
    """Up stays up. Along an axis that is new there are two rows of nodes, with the plane between them."""
    assert t.axes[-1, -1] == 1.0
    level = Transform(t.axes[:-1, :-1], np.broadcast_to(t.shift, len(t.axes))[:-1], m=t.m)
    upper = np.array(ground.origin) + ground.spacing * (np.array(ground.heights.shape) - 1)
    origin, _ = level.corners(ground.origin, upper, 0.5 * ground.spacing)
    heights = _over_cells(level, ground.heights)
    for axis in np.flatnonzero(~level.axes.any(axis=1)):
        heights = np.repeat(heights, 2, axis=axis)
    return pc.HeightField(
        (heights + np.broadcast_to(t.shift, len(t.axes))[-1]) * t.m,
        ground.spacing * t.m,
        origin,
        restitution=ground.restitution,
        friction=ground.friction,
        no_slip=ground.no_slip,
        on=on,
    )


FIELDS: dict[type, Callable[[Any, Array], Array]] = {
    pc.QuadrupoleTrap: lambda f, x: f.strength * (x - f.center) * (0.5, 0.5, -1.0),
    pc.MagneticBottle: lambda f, x: (
        f.strength
        * np.stack(
            [
                -x[:, 0] * x[:, 2] / f.length**2,
                -x[:, 1] * x[:, 2] / f.length**2,
                1.0 + (x[:, 2] ** 2 - 0.5 * (x[:, 0] ** 2 + x[:, 1] ** 2)) / f.length**2,
            ],
            axis=1,
        )
    ),
}
"""Fields that the engine computes, as functions in NumPy."""


def _electromagnetic(force: pc.ElectromagneticField, t: Transform, on: Any) -> pc.ElectromagneticField:
    """Charges stay: E is a force, B a force per velocity along the axis that a mirror turns round. Who moves along with
    charges sees E − u × B.
    """
    plane = t.axes.shape == (2, 2)
    if t.axes.shape[1] == 2:
        axis = np.linalg.det(t.axes) if plane else np.cross(t.axes[:, 0], t.axes[:, 1])
    else:
        axis = np.linalg.det(t.axes) * t.axes

    def back(x: Array) -> Array:
        return (x / t.m - t.shift) @ t.axes

    def turned(values: Any) -> Any:
        """B in the new coordinates."""
        flat = t.axes.shape[1] == 2
        given = np.multiply.outer(values, axis) if flat else np.asarray(values) @ axis.T
        return given * t.unit(0, -1, 1)

    def ready(field: Any) -> Any:
        """The same field in other units and elsewhere, or one along other axes."""
        if np.array_equal(t.axes, np.eye(3)):
            values = {entry.name: getattr(field, entry.name) for entry in fields(field)}
            return type(field)(**_changed(field, values, t))
        return lambda time, x: FIELDS[type(field)](field, x)

    electric, magnetic = (
        ready(field) if isinstance(field, tuple(FIELDS)) else field for field in (force.electric, force.magnetic)
    )
    assert not np.any(t.boost) or not callable(magnetic)
    boost = 0.0
    if np.any(t.boost):
        u, b = t.boost * t.unit(1, -1), turned(magnetic)
        boost = np.cross(u, b) if len(u) == 3 else b * np.array([u[1], -u[0]])

    def electric_function(time: float, x: Array) -> Array:
        return t.directions(electric(time / t.s, back(x))) * t.unit(1, -2, 1) - boost

    def magnetic_function(time: float, x: Array) -> Array:
        return turned(magnetic(time / t.s, back(x)))

    def potential(x: Array) -> float:
        return force.potential(back(x)) * t.unit(2, -2, 1)

    def uniform(vector: Any) -> Any:
        zero = np.zeros(t.axes.shape[1])
        return tuple(t.directions(zero if isinstance(vector, float) else vector) * t.unit(1, -2, 1) - boost)

    def uniform_magnetic(vector: Any) -> Any:
        if isinstance(vector, float) and vector == 0.0:
            return 0.0
        return float(turned(vector)) if plane else tuple(turned(vector))

    kept = tuple(FIELDS)
    return pc.ElectromagneticField(
        electric_function if callable(electric) else electric if isinstance(electric, kept) else uniform(electric),
        magnetic_function
        if callable(magnetic)
        else magnetic
        if isinstance(magnetic, kept)
        else uniform_magnetic(magnetic),
        None if force.potential is None else potential,
        on=on,
    )


def _over_cells(t: Transform, values: Any) -> Any:
    """A field on a grid, along the axes where they are then; along one that is new, one cell. A number stays."""
    if np.ndim(values) == 0:
        return values
    partners = [int(np.abs(axis).argmax()) if axis.any() else None for axis in t.axes]
    moved = np.transpose(values, [partner for partner in partners if partner is not None])
    for axis, partner in enumerate(partners):
        if partner is None:
            moved = np.expand_dims(moved, axis)
        elif t.axes[axis, partner] < 0.0:
            moved = np.flip(moved, axis)
    return moved


def _condition(t: Transform, condition: Condition, axis: int, unit: float) -> Condition:
    """A condition at the edges of an axis; `unit` is that of the field."""
    if not isinstance(condition, Valued):
        return condition
    unit = unit if isinstance(condition, pc.Dirichlet) else unit / t.m

    def moved(values: Any) -> Any:
        if np.ndim(values) == 0:
            return values * unit
        partner = int(np.abs(t.axes[:, axis]).argmax())
        return np.squeeze(_over_cells(t, np.expand_dims(values, axis)), partner) * unit

    value = getattr(condition, condition.key)
    return type(condition)((lambda time: moved(value(time / t.s))) if callable(value) else moved(value))


def _grid(system: GridSystem, t: Transform, unit: float = 1.0) -> tuple[pc.Grid, Any]:
    """Its grid and its edges. Along an axis that is new one cell, with free edges, so that nothing depends on it."""
    grid, spacing = system.grid, system.grid.spacing * t.m
    lower, upper = t.corners(grid.origin, grid.upper, grid.spacing / 2.0)

    def edges(given: tuple[Condition, ...]) -> tuple[Condition, ...]:
        found: list[Condition] = []
        for axis in t.axes:
            partner = int(np.abs(axis).argmax())
            own = [_condition(t, each, partner, unit) for each in given[2 * partner : 2 * partner + 2]]
            pair = own if axis.any() else ["free", "free"]
            found += pair[::-1] if axis.min() < 0.0 else pair
        return tuple(found)

    periodic = [bool(axis.any() and grid.periodic[int(np.abs(axis).argmax())]) for axis in t.axes]
    cells = tuple(round((high - low) / spacing) for low, high in zip(lower, upper, strict=True))
    given: Any = system.edges
    every = {name: edges(each) for name, each in given.items()} if isinstance(given, dict) else edges(given)
    return pc.Grid(cells, spacing, lower, tuple(periodic)), every


def _kinetics(kinetics: Kinetics, t: Transform) -> Kinetics:
    """Those of a user's function take other units of time; others have a rate of 1/s in them, and no other units."""
    if t.s == 1.0 and isinstance(kinetics, pc.Reaction):
        return kinetics
    if t.s == 1.0:
        return type(kinetics)(**{each.name: _over_cells(t, getattr(kinetics, each.name)) for each in fields(kinetics)})
    assert isinstance(kinetics, pc.Reaction)
    return pc.Reaction(
        kinetics.species, lambda *values: tuple(rate * t.unit(0, -1) for rate in kinetics.function(*values))
    )


def _reaction_diffusion(dish: pc.ReactionDiffusion, t: Transform) -> pc.ReactionDiffusion:
    """Values have no unit."""
    grid, edges = _grid(dish, t)
    return pc.ReactionDiffusion(
        grid,
        _kinetics(dish.reaction, t),
        {name: value * t.unit(2, -1) for name, value in dish.diffusion.items()},
        {name: _over_cells(t, values) for name, values in dish.initial.items()},
        edges,
    )


def _wave(wave: pc.Wave, t: Transform) -> pc.Wave:
    grid = wave.grid
    other, edges = _grid(wave, t, t.m)
    new = len(t.axes) - grid.dimension

    def field(values: Any, unit: float) -> Any:
        return _over_cells(t, values) * unit

    def source(given: pc.Source) -> pc.Source:
        local = isinstance(given.where, tuple)
        unit = t.unit(1 + grid.dimension, -2) * grid.spacing**new * t.m**new if local else t.unit(1, -2)
        signal = given.signal
        if isinstance(signal, pc.Ricker):
            signal = pc.Ricker(signal.frequency / t.s)
        return pc.Source(
            point(t, given.where) if local else _over_cells(t, given.where),
            given.amplitude * unit,
            given.frequency / t.s,
            given.phase,
            given.start * t.s,
            given.stop * t.s,
            signal,
        )

    return pc.Wave(
        other,
        field(wave.speed, t.unit(1, -1)),
        field(wave.displacement, t.m),
        field(wave.rate, t.unit(1, -1)),
        field(wave.density, t.unit(-grid.dimension, 0, 1)),
        field(wave.damping, t.unit(0, -1)),
        edges,
        None if wave.walls is None else _over_cells(t, wave.walls),
        [source(each) for each in wave.sources],
        wave.order,  # type: ignore[arg-type]
    )


def _amplitude(packet: pc.Schrodinger, t: Transform) -> float:
    """What 1/√mᴰ becomes, of a wave function that is spread evenly over a cell along an axis that is new."""
    new = len(t.axes) - packet.grid.dimension
    return t.unit(-0.5 * len(t.axes)) * packet.grid.spacing ** (-0.5 * new)


def _schrodinger(packet: pc.Schrodinger, t: Transform) -> pc.Schrodinger:
    grid, edges = _grid(packet, t)
    both = [_over_cells(t, packet.wave_function[..., part]) * _amplitude(packet, t) for part in (0, 1)]
    new = len(t.axes) - packet.grid.dimension
    return pc.Schrodinger(
        grid,
        both[0] + 1j * both[1],
        _over_cells(t, packet.potential) * t.unit(2, -2, 1),
        packet.mass * t.kg,
        packet.hbar * t.unit(2, -1, 1),
        packet.interaction * t.unit(2 + len(t.axes), -2, 1) * packet.grid.spacing**new,
        edges,
    )


FLOWS: dict[type, Callable[[Any], Callable[..., Any]]] = {
    pc.Lorenz: lambda f: lambda x, y, z: (f.sigma * (y - x), x * (f.rho - z) - y, x * y - f.beta * z),
    pc.Rossler: lambda f: lambda x, y, z: (-(y + z), x + f.a * y, f.b + z * (x - f.c)),
    pc.Aizawa: lambda f: (
        lambda x, y, z: (
            (z - f.b) * x - f.d * y,
            f.d * x + (z - f.b) * y,
            f.c + f.a * z - z**3 / 3.0 - (x * x + y * y) * (1.0 + f.e * z) + f.f * z * x**3,
        )
    ),
    pc.Thomas: lambda f: lambda x, y, z: (np.sin(y) - f.b * x, np.sin(z) - f.b * y, np.sin(x) - f.b * z),
    pc.Halvorsen: lambda f: (
        lambda x, y, z: (
            -(f.a * x + 4.0 * (y + z) + y * y),
            -(f.a * y + 4.0 * (z + x) + z * z),
            -(f.a * z + 4.0 * (x + y) + x * x),
        )
    ),
}
"""The flows as functions in NumPy."""


def flow_in_python(flow: Any) -> Callable[[float, Array], Array]:
    """A flow as a function of the time and the positions."""
    if isinstance(flow, pc.Flow):
        return lambda time, x: np.asarray(flow.function(time, x))
    components = FLOWS[type(flow)](flow)
    return lambda time, x: np.column_stack(components(*x.T))


def _tracers(dust: pc.Tracers, t: Transform) -> pc.Tracers:
    """With a function, because flows have their units and their place in them. Aᵀ is the way back."""
    function = flow_in_python(dust.flow)

    def velocity(time: float, x: Array) -> Array:
        return t.directions(function(time / t.s, (x / t.m - t.shift) @ t.axes)) * t.unit(1, -1)

    return pc.Tracers(t.points(dust.positions), pc.Flow(velocity))


def _vortices(vortices: pc.PointVortices, t: Transform) -> pc.PointVortices:
    """A mirror turns them round."""
    turned = np.linalg.det(t.axes) * t.unit(2, -1)
    return pc.PointVortices(t.points(vortices.centers), vortices.circulations * turned, vortices.core * t.m)


SYSTEMS: dict[type, Rule] = {
    pc.Tracers: _tracers,
    pc.PointVortices: _vortices,
    pc.Wave: _wave,
    pc.ReactionDiffusion: _reaction_diffusion,
    pc.Schrodinger: _schrodinger,
}
"""What becomes of systems beside matter."""


def moved(t: Transform, scene: pc.Scene, state: tuple[Array, Array], order: Any = slice(None)) -> tuple[Array, Array]:
    """The state that a state of a scene becomes, with its particles in an order."""
    x, v = state
    if scene.bodies:
        return t.points(x[order]), t.velocities(v[order])
    if isinstance(scene.systems[0], PointSystem):
        return t.points(x), t.directions(v) * t.unit(1, -1)
    if isinstance(scene.systems[0], pc.ReactionDiffusion):
        return _over_cells(t, x), _over_cells(t, v)
    if isinstance(scene.systems[0], pc.Schrodinger):
        unit = _amplitude(scene.systems[0], t)
        return _over_cells(t, x) * unit, _over_cells(t, v) * unit
    return _over_cells(t, x) * t.m, _over_cells(t, v) * t.unit(1, -1)


def transformed(scene: pc.Scene, t: Transform, orders: list[NDArray[np.int64]] | None = None) -> pc.Scene:
    """The same scene in other coordinates and units, the particles of every body in the given order."""
    orders = orders or [np.arange(len(body)) for body in scene.bodies]
    bodies = {body: _body(body, t, order) for body, order in zip(scene.bodies, orders, strict=True)}
    order_of = dict(zip(scene.bodies, orders, strict=True))
    acting = [item for item in (*scene.forces, *scene.boundaries, *scene.constraints) if not isinstance(item, pc.Motor)]
    made = {item: _item(item, t, bodies, order_of) for item in acting}
    motors = [rigid.motor(item, made[item.joint], t) for item in scene.constraints if isinstance(item, pc.Motor)]
    items = [*made.values(), *motors]
    domain = scene.periodic
    domains = [] if domain is None else [pc.Periodic(*t.corners(domain.lower, domain.upper, np.inf))]
    found = {system: SYSTEMS[type(system)](system, t) for system in scene.systems if not system.named()}
    systems = [
        found[system] if system in found else pc.Tracers(t.points(system.start), found[system.flow])
        for system in scene.systems
    ]
    return pc.Scene(*bodies.values(), *items, *domains, *systems)
