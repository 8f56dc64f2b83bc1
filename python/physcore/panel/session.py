"""The session of a panel: the scene of its controls, the simulation of this scene, and the hand in it."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

from physcore.checks import FloatArray, count, shown, span
from physcore.errors import PhyscoreError, SceneError
from physcore.numerics.choices import Options
from physcore.panel.controls import Control
from physcore.panel.hand import Hand, attitude, chosen_stiffness, grasp, scene_with
from physcore.scene.bodies import Body
from physcore.scene.scene import Scene
from physcore.simulation.energy import Drift
from physcore.simulation.passage import Course
from physcore.simulation.simulation import Simulation
from physcore.spelling import did_you_mean


class Session:
    """State of a panel without its clock. One thread at a time may use it.

    Args:
        build: the function that builds a scene from the values of the controls.
        controls: the controls by name.
        numerics: options of the simulation.

    Raises:
        SceneError: `build` fails, or gives no scene, or the scene cannot be simulated.
    """

    hand: Hand | None

    def __init__(self, build: Callable[..., Scene], controls: Mapping[str, Control], numerics: Options) -> None:
        self._build, self._controls, self._numerics = build, controls, numerics
        _check_signature(build, controls)
        self.values: dict[str, Any] = {name: control.value for name, control in controls.items()}
        self.scene = self._scene_of(self.values)
        self.speed = 1.0
        """Seconds of the simulation per second."""
        self.note = ""
        """Effect of the last change."""
        self._damped = True
        self._start(self.scene)

    def _start(self, scene: Scene) -> None:
        """Begin at time 0, without a hand. If this fails, nothing has changed.

        Raises:
            SceneError: the scene cannot be simulated.
        """
        self.simulation = Simulation(scene, **self._numerics)
        self.scene, self.hand = scene, None
        self.course, self.drift = Course(self.simulation), Drift()

    def set(self, changes: Mapping[str, object]) -> None:
        """Set controls, and go on from the present state where possible, else begin at time 0.

        Raises:
            SceneError: there is no such control, a value is not valid, or the scene cannot be built or simulated.
                Nothing has changed then.
        """
        values = dict(self.values)
        for name, value in changes.items():
            if name not in self._controls:
                known = ", ".join(self._controls) or "none"
                raise SceneError(
                    f"set.{name}: there is no such control; there are {known}{did_you_mean(name, self._controls)}"
                )
            values[name] = self._controls[name].checked(value, f"set.{name}")
        scene = self._scene_of(values)
        hand = None if self.hand is None else self.hand.within(scene, self.scene)
        try:
            self._replace(scene, hand)
            self.note = "goes on from the present state"
        except SceneError as error:
            self._start(scene)
            self.note = f"started anew: {str(error).removeprefix('replace.')}"
        self.values = values

    def reset(self) -> None:
        """Go back to the scene of the controls at time 0.

        Raises:
            SceneError: the scene cannot be built or simulated. Nothing has changed then.
        """
        self._start(self._scene_of(self.values))
        self.note = ""

    def step(self, number: object) -> None:
        """Take a number of steps."""
        self.course.begin()
        self.simulation.step(count(number, "step.n"))

    def grab(self, key: object, stiffness: object) -> None:
        """Hold a particle or a rigid body where it is.

        Raises:
            SceneError: there is no such element, it cannot be moved, or the stiffness is not valid.
        """
        given = None if stiffness is None else span(stiffness, "grab.stiffness")
        places = self.places
        body, index = grasp(self.scene, key, places)
        if given is None:
            given = chosen_stiffness(body, index, self.simulation.dt, self.speed)
        turned = attitude(self.simulation[body], index) if body.is_rigid else None
        self._replace(self.scene, Hand(body, index, tuple(places[body][index].tolist()), given, turned))

    def drag(self, point: object) -> None:
        """Move the pointer.

        Raises:
            SceneError: nothing is held, or the point is not valid.
        """
        self._replace(self.scene, self._holding("drag.point").at(point))

    def turn(self, rotation: object) -> None:
        """Turn the rigid body that is held.

        Raises:
            SceneError: nothing is held, or no rigid body, or the rotation is not valid.
        """
        self._replace(self.scene, self._holding("turn.rotation").turned(rotation))

    def release(self) -> None:
        """Let go."""
        if self.hand is not None:
            self._replace(self.scene, None)

    def _holding(self, path: str) -> Hand:
        """The hand, for what needs one.

        Raises:
            SceneError: nothing is held.
        """
        if self.hand is None:
            raise SceneError(f"{path}: nothing is held; panel.grab((body, index)) before")
        return self.hand

    @property
    def places(self) -> dict[Body, FloatArray]:
        """The present positions of each body [m]."""
        return {body: self.simulation[body].positions for body in self.scene.bodies}

    def _replace(self, scene: Scene, hand: Hand | None) -> None:
        """Go on in a scene with a hand; without damping of the hand, where the method of the scene allows for none.

        Raises:
            SceneError: the scene cannot go on from the present state.
        """
        try:
            self.simulation.replace(scene_with(scene, hand, damped=self._damped))
        except SceneError:
            if hand is None or not self._damped:
                raise
            self.simulation.replace(scene_with(scene, hand, damped=False))
            self._damped = False
        self.scene, self.hand = scene, hand
        self.course.begin()

    def _scene_of(self, values: Mapping[str, Any]) -> Scene:
        """The scene of some values of the controls.

        Raises:
            SceneError: `build` raised an exception, or returned no Scene.
        """
        try:
            scene = self._build(**values)
        except PhyscoreError:
            raise
        except Exception as error:
            raise SceneError(f"build: the function raised {type(error).__name__}: {error}") from error
        if not isinstance(scene, Scene):
            hint = "; does it end with return?" if scene is None else ""
            raise SceneError(f"build: must return a Scene, got {shown(scene)}{hint}")
        return scene


def _check_signature(build: object, controls: Mapping[str, Control]) -> None:
    """Check that a function takes the controls as keywords, as far as its signature is known.

    Raises:
        SceneError: it is no function, or takes others.
    """
    if not callable(build):
        raise SceneError(f"build: must be a function that returns a Scene, got {shown(build)}")
    try:
        signature = inspect.signature(build)
    except (TypeError, ValueError):
        return
    try:
        signature.bind(**dict.fromkeys(controls))
    except TypeError as error:
        names = ", ".join(controls) or "no arguments"
        raise SceneError(f"build: must take {names}, got a function of {signature} ({error})") from None
