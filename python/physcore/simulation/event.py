"""Events: roots of functions of the state, which a run looks for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from physcore.arithmetic import dots, lengths
from physcore.checks import FloatArray, IntArray, Vector, array, called, count, flag, items, number, shown, text, vector
from physcore.errors import SceneError
from physcore.scene.bodies import Body
from physcore.scene.contents import BodyKey
from physcore.scene.points import PointSystem
from physcore.scene.scene import Scene
from physcore.simulation.state import Snapshot

Owner: TypeAlias = BodyKey | PointSystem
"""Owner of particles: a body, or tracers or vortices."""
Which: TypeAlias = Owner | tuple[Owner, Any]
"""All particles of a body, or `(body, index)`: those of an index, as of NumPy."""

AXES = "xyz"

EPSILON = float(np.finfo(float).eps)

STEADY = 1e-9
"""Fraction of a distance by which it may vary and be constant for `Event.closest_approach`."""


@dataclass(frozen=True, eq=False)
class Event:
    """Event: a root of a function of the state, such as a crossing or a closest approach.

        ball = pc.Particles([[0.0, 2.0]], name="ball")
        landing = pc.Event(lambda state: state["ball"].positions[0, 1], direction=-1, terminal=True)
        recording = pc.simulate(pc.Scene(ball, pc.Gravity()), duration=5.0, events=[landing])
        recording.events[landing].times  # [0.6386]
        recording.events[landing]["ball"].velocities  # at these times, (1, 1, 2)

    The run evaluates the function after each step. Where a value changes its sign, it repeats the step from its start.
    The same integrator takes it with other lengths, until the root is known to the resolution of the clock. So the
    times are as accurate as the run, and the steps of the run keep their bits. `direction` and `terminal` have the
    meaning that they have in `scipy.integrate.solve_ivp`.

    A value that becomes exactly 0 is an event. One that departs from 0 is none, as at the start of a run. Two roots of
    a value within one step cancel and are missed: a smaller dt separates them. A jump past 0 is an event too.

    A step that is watched takes two copies of the state and one call of the function beside its own work. A step with
    an event takes about ten further steps, in a second copy of the scene. `physcore.film` of a scene takes no events:
    record with events, then film the recording.

    Args:
        function: `function(state)` returns a number, or an array of numbers (M,) with roots of their own. All must be
            finite. The state is a Snapshot: `state.time`, `state[body].positions`, `state[wave].displacement`. The
            function must depend on nothing else.
        direction: 1 for roots at which a value rises, −1 for those at which it falls, 0 for both.
        terminal: whether the run ends at the event; n: whether it ends at the n-th one.
        name: name in results; by default that of the function.
        period: for values that are known up to multiples of a period, such as angles: roots are multiples of it, and a
            change by more than half of it within a step is a wrap.

    Raises:
        SceneError: an argument is not valid. In a run: the function raised an exception, which is the cause
            (`__cause__`), or returned what is no finite number. The message begins with `events[i].function`, and the
            simulation is at the start of the step.
    """

    function: Callable[[Snapshot], ArrayLike]
    direction: int = 0
    terminal: bool | int = False
    name: str | None = None
    period: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise SceneError(f"Event.function: must be a function of the state, got {shown(self.function)}")
        if number(self.direction, "Event.direction") not in (-1.0, 0.0, 1.0):
            raise SceneError(f"Event.direction: must be −1, 0 or 1, got {shown(self.direction)}")
        terminal = self.terminal
        if isinstance(terminal, (bool, np.bool_)):
            terminal = flag(terminal, "Event.terminal")
        else:
            terminal = count(terminal, "Event.terminal", least=1)
        name = self.name
        if name is None:
            own = getattr(self.function, "__name__", "")
            name = own if own and not own.startswith("<") else "event"
        object.__setattr__(self, "direction", int(self.direction))
        object.__setattr__(self, "terminal", terminal)
        object.__setattr__(self, "name", text(name, "Event.name"))
        if self.period is not None:
            object.__setattr__(self, "period", number(self.period, "Event.period", above=0.0))

    @classmethod
    def crossing(
        cls,
        body: Which,
        axis: str | Vector,
        value: float = 0.0,
        *,
        direction: int = 0,
        terminal: bool | int = False,
        name: str | None = None,
    ) -> Event:
        """Crossing of a plane by each particle of a body.

            pc.Event.crossing("ball", "y", 0.5, direction=-1)  # on the way down
            pc.Event.crossing(("atoms", 3), (1.0, 1.0), 0.0)  # particle 3, through the line x + y = 0

        Args:
            body: the body, its index or its name, or Tracers or PointVortices; `(body, index)` for some of its
                particles. `indices` of the occurrences tell them apart.
            axis: "x", "y" or "z", or a vector: the normal of the plane.
            value: coordinate of the plane along the axis [m]. In a periodic domain its images count too.
            direction: 1 for crossings along the axis, −1 for those against it, 0 for both.
            terminal: as for `Event`.
            name: as for `Event`; by default such as "ball: y = 0.5".

        Raises:
            SceneError: an argument is not valid. At the start of a run: there is no such particle, or the plane is
                oblique in a periodic domain.
        """
        function = Crossing(*_which(body, "Event.crossing.body"), _axis(axis), number(value, "Event.crossing.value"))
        return cls(function, direction, terminal, str(function) if name is None else name)

    @classmethod
    def closest_approach(cls, a: Which, b: Which, *, terminal: bool | int = False, name: str | None = None) -> Event:
        """Closest approach of two particles: a minimum of their distance, where r·v rises through 0.

            pc.Event.closest_approach("comet", "sun")

        In a periodic domain the distance is that to the nearest image.

        A constant distance has no minima, although rounding makes r·v differ from 0. So values up to 1e-9 |r| |v|, and
        up to the effect of rounding, have no sign. An event is a step at whose end r·v is above, after it was below.
        Distances that vary by less than 1e-9 of themselves have no minima. For a fraction e, if a step ends where r·v
        has no sign, the time is late by up to 1e-9 / e of |r| / |v|.

        Args:
            a: the body, its index or its name, or Tracers or PointVortices; `(body, index)` for some of its particles.
            b: likewise. As many particles as `a`, pair by pair, or one for all; `indices` of the occurrences tell the
                pairs apart.
            terminal: as for `Event`.
            name: as for `Event`; by default such as "closest approach of comet and sun".

        Raises:
            SceneError: an argument is not valid. At the start of a run: there is no such particle.
        """
        one, other = _which(a, "Event.closest_approach.a"), _which(b, "Event.closest_approach.b")
        function = Approach(*one, *other)
        return cls(function, 1, terminal, str(function) if name is None else name)


@dataclass(frozen=True, eq=False)
class Crossing:
    """Function of the event `Event.crossing`: signed distances [m] of particles from a plane."""

    body: Owner
    index: Any
    axis: str | tuple[float, ...]
    value: float

    def __call__(self, state: Snapshot) -> FloatArray:
        """The distances in a state."""
        positions: FloatArray = state[self.body].positions[self.index]
        return dots(positions, self._normal(positions.shape[-1])) - self.value

    def __str__(self) -> str:
        along = self.axis if isinstance(self.axis, str) else f"{shown(self.axis)}·x"
        return f"{_called(self.body, self.index)}: {along} = {self.value:g}"

    def check(self, scene: Scene, path: str) -> None:
        """Refuse a plane or particles that are not those of a scene."""
        _particles(scene, self.body, self.index, f"{path}.crossing.body")
        dimension = scene.dimension
        if (AXES.index(self.axis) >= dimension) if isinstance(self.axis, str) else len(self.axis) != dimension:
            raise SceneError(f"{path}.crossing.axis: must be one of {dimension}D, got {shown(self.axis)}")

    def period(self, scene: Scene, path: str) -> float | None:
        """The length of a periodic domain along the axis [m]."""
        if scene.periodic is None or scene.system(self.body) is not None:
            return None
        normal = self._normal(scene.dimension)
        across = [float(length) for length in scene.periodic.lengths[normal != 0.0] if np.isfinite(length)]
        if not across:
            return None
        if np.count_nonzero(normal) > 1:
            raise SceneError(
                f"{path}.crossing.axis: must be perpendicular to an axis in a periodic domain, got {shown(self.axis)}"
            )
        return across[0]

    def _normal(self, dimension: int) -> FloatArray:
        return np.array(self.axis) if not isinstance(self.axis, str) else np.eye(dimension)[AXES.index(self.axis)]


@dataclass(frozen=True, eq=False)
class Approach:
    """Function of the event `Event.closest_approach`: r·v [m²/s] of pairs."""

    body: Owner
    index: Any
    other: Owner
    other_index: Any

    def __call__(self, state: Snapshot) -> FloatArray:
        """The products in a state."""
        return dots(*self._relative(state))

    def uncertainty(self, state: Snapshot) -> FloatArray:
        """Bound of |r·v| [m²/s] below which its sign is unknown.

        A distance that varies by the fraction e of itself, in the time in which the pair turns, has |r·v| ≤ e |r| |v|.
        Methods that solve equations by iteration keep distances to some 1e-10 of themselves: e = 1e-9 is above.

        Each coordinate of a position x or a velocity u is rounded by ε/2 of itself, some times in a step. To first
        order this changes r·v by ε/2 ((|x₁| + |x₂|) |v| + (|u₁| + |u₂|) |r|) each time. 16 times are allowed for.
        """
        apart, relative = map(lengths, self._relative(state))
        one, other = state[self.body], state[self.other]
        places = lengths(one.positions[self.index]) + lengths(other.positions[self.other_index])
        speeds = lengths(one.velocities[self.index]) + lengths(other.velocities[self.other_index])
        bound: FloatArray = STEADY * apart * relative + 8.0 * EPSILON * (places * relative + speeds * apart)
        return bound

    def _relative(self, state: Snapshot) -> tuple[FloatArray, FloatArray]:
        """The relative positions r and the relative velocities v."""
        one, other = state[self.body], state[self.other]
        apart = one.positions[self.index] - other.positions[self.other_index]
        if state.scene is not None and state.scene.periodic is not None:
            apart = state.scene.periodic.nearest(apart)
        return apart, one.velocities[self.index] - other.velocities[self.other_index]

    def __str__(self) -> str:
        return f"closest approach of {_called(self.body, self.index)} and {_called(self.other, self.other_index)}"

    def check(self, scene: Scene, path: str) -> None:
        """Refuse particles that are not those of a scene, or that are no pairs."""
        one = _particles(scene, self.body, self.index, f"{path}.closest_approach.a")
        other = _particles(scene, self.other, self.other_index, f"{path}.closest_approach.b")
        if one.size != other.size and 1 not in (one.size, other.size):
            raise SceneError(
                f"{path}.closest_approach.b: must be as many particles as a, or one; got {one.size} and {other.size}"
            )
        if (one == other).any():
            raise SceneError(f"{path}.closest_approach.b: must be other particles than a")

    def period(self, scene: Scene, path: str) -> None:
        """None: where the nearest image changes, r·v falls, and the event is a rise."""
        del scene, path


def period_in(event: Event, scene: Scene, path: str) -> float | None:
    """The period of the values in a scene: of a crossing in a periodic domain, the length of the domain.

    Raises:
        SceneError: the scene lacks what the event is about.
    """
    if not isinstance(event.function, (Crossing, Approach)):
        return event.period
    event.function.check(scene, path)
    return event.function.period(scene, path)


def values_of(event: Event, state: Snapshot, path: str) -> FloatArray:
    """The values of the function in a state, shape () or (M,).

    Raises:
        SceneError: the function raised an exception, or returned what is no finite number.
    """
    given = called(event.function, f"{path}.function", state)
    place = f"{path}.function at t = {state.time:.6g} s: its value"
    values = array(given, place)
    if np.asarray(given).dtype == np.bool_:
        raise SceneError(f"{place}: must be a number that changes its sign at the event, got {shown(given)}")
    if values.ndim > 1:
        raise SceneError(f"{place}: must be a number or an array (M,), got the shape {values.shape}")
    return values


def decided(event: Event, values: FloatArray, state: Snapshot, before: FloatArray | None) -> FloatArray:
    """The values of an event in a state. Where a sign is unknown, those before; 0 if there are none."""
    if not isinstance(event.function, Approach):
        return values
    unknown = np.abs(values) <= event.function.uncertainty(state)
    return np.where(unknown, 0.0 if before is None else before, values)


def checked(events: object, scene: Scene) -> tuple[Event, ...]:
    """The events that a run looks for.

    Raises:
        SceneError: one of them is none, or does not suit the scene.
    """
    if isinstance(events, Event):
        raise SceneError("events: must be a list of Event; write events=[…]")
    given = items(events, "events", "Event")
    for index, event in enumerate(given):
        if not isinstance(event, Event):
            hint = "; write pc.Event(…)" if callable(event) else ""
            raise SceneError(f"events[{index}]: must be an Event, got {shown(event)}{hint}")
        if any(event is other for other in given[:index]):
            raise SceneError(f"events[{index}]: is given twice")
        period_in(event, scene, f"events[{index}]")
    return tuple(given)


def _which(given: Which, path: str) -> tuple[Owner, Any]:
    """A body and the index of some of its particles.

    Raises:
        SceneError: they are neither.
    """
    body, index = given if isinstance(given, tuple) and len(given) == 2 else (given, slice(None))
    if isinstance(body, np.integer) and not isinstance(body, np.timedelta64):
        body = int(body)
    if isinstance(body, bool) or not isinstance(body, (Body, PointSystem, int, str)):
        raise SceneError(f"{path}: must be a body, its index or its name, or (body, index), got {shown(given)}")
    return body, index


def _axis(axis: object) -> str | tuple[float, ...]:
    """An axis by its letter, or a normal of unit length."""
    if isinstance(axis, str):
        if axis not in tuple(AXES):
            raise SceneError(f"Event.crossing.axis: must be 'x', 'y' or 'z', or a vector, got {shown(axis)}")
        return axis
    normal = np.array(vector(axis, "Event.crossing.axis"))
    largest = np.abs(normal).max()
    if largest == 0.0:
        raise SceneError("Event.crossing.axis: must not be the zero vector")
    normal /= largest
    return tuple((normal / lengths(normal)).tolist())


def _particles(scene: Scene, body: Owner, index: Any, path: str) -> IntArray:
    """The numbers of the particles of an index, in the order of the scene.

    Raises:
        SceneError: there are none.
    """
    try:
        found = np.atleast_1d(_numbers(scene, body)[index])
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise SceneError(f"{path}: {error.args[0] if error.args else error}") from None
    if found.size == 0 or found.ndim != 1:
        raise SceneError(f"{path}: must be particles of {_called(body, slice(None))}, got the index {shown(index)}")
    return found


def _numbers(scene: Scene, body: Owner) -> IntArray:
    """The numbers of the particles of a body in a scene; negative ones for points of systems.

    Raises:
        KeyError: it is not in the scene.
    """
    last = 0
    for system in scene.systems:
        points = system.elements.get("points", 0)
        if points and scene.system(body) == scene.system(system):
            return np.arange(last - points, last)
        last -= points
    if getattr(body, "section", None) == "systems":
        raise KeyError(f"{body!r} is no system of this scene")
    own = scene.place(cast("BodyKey", body))
    return np.arange(own.start, own.stop)


def _called(body: Owner, index: Any) -> str:
    """The name of particles of a body."""
    name = str(body) if isinstance(body, (int, str)) else body.name or type(body).__name__
    return name if isinstance(index, slice) and index == slice(None) else f"{name}[{shown(index)}]"
