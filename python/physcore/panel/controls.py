"""Controls of a panel: sliders, switches and choices, which are arguments of the function that builds the scene."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from physcore.checks import count, flag, items, number, shown
from physcore.errors import SceneError


class Control(ABC):
    """Base class of controls: a kind, a first value, and the values that are valid."""

    kind: ClassVar[str]
    """Name of the kind, for the page."""
    value: Any
    """The value at the start."""

    @abstractmethod
    def checked(self, value: object, path: str) -> Any:
        """A valid value; `path` is the name of the control, for messages.

        Raises:
            SceneError: the value is not valid.
        """

    @abstractmethod
    def content(self) -> dict[str, Any]:
        """The range of values, for the page."""


@dataclass(frozen=True)
class Slider(Control):
    """Slider of a panel: a number between two ends.

        def build(stiffness):
            return pc.Scene(pc.cloth((12, 8), 0.05, stiffness=stiffness, mass=2e-3, pinned="top corners"), pc.Gravity())
        panel = pc.live(build, stiffness=pc.Slider(10.0, 1000.0, 200.0), show=False)
        panel.close()

    With whole numbers, `pc.Slider(1, 20, 5)`, all values are whole.

    Args:
        lower, upper: the ends; `lower` must be below `upper`.
        value: the value at the start; None: the lower end.
        logarithmic: whether equal ways of the slider multiply the value by equal factors. Both ends must be positive.

    Raises:
        SceneError: the range is empty, or the value is not in it.
    """

    lower: float
    upper: float
    value: float | None = None
    logarithmic: bool = False

    kind: ClassVar[str] = "slider"

    def __post_init__(self) -> None:
        given = [each for each in (self.lower, self.upper, self.value) if each is not None]
        whole = all(isinstance(each, (int, np.integer)) and not isinstance(each, bool) for each in given)
        object.__setattr__(self, "_is_whole", whole)
        read = _whole if whole else number
        for name in ("lower", "upper"):
            object.__setattr__(self, name, read(getattr(self, name), f"Slider.{name}"))
        if self.lower >= self.upper:
            raise SceneError(f"Slider.upper: must be above the lower end {self.lower:g}, got {self.upper:g}")
        object.__setattr__(self, "logarithmic", flag(self.logarithmic, "Slider.logarithmic"))
        if self.logarithmic and self.lower <= 0.0:
            raise SceneError(f"Slider.lower: must be > 0 on a logarithmic scale, got {self.lower:g}")
        start = self.lower if self.value is None else self.value
        object.__setattr__(self, "value", self.checked(start, "Slider.value"))

    @property
    def whole(self) -> bool:
        """Whether all values are whole numbers."""
        return bool(self.__dict__["_is_whole"])

    def checked(self, value: object, path: str) -> float:
        """A number between the ends."""
        if not self.whole:
            return number(value, path, least=self.lower, most=self.upper)
        return int(number(_whole(value, path), path, least=self.lower, most=self.upper))

    def content(self) -> dict[str, Any]:
        """The ends of the range, and how values are spaced."""
        return {"lower": self.lower, "upper": self.upper, "whole": self.whole, "logarithmic": self.logarithmic}


@dataclass(frozen=True)
class Switch(Control):
    """Switch of a panel: on or off.

        def build(gravity):
            ball = pc.Particles([[0.0, 1.0]], velocities=[[1.0, 0.0]])
            return pc.Scene(ball, *([pc.Gravity()] if gravity else []))
        panel = pc.live(build, gravity=pc.Switch(True), show=False)
        panel.close()

    Args:
        value: whether it is on at the start.

    Raises:
        SceneError: the value is neither True nor False.
    """

    value: bool = False

    kind: ClassVar[str] = "switch"

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", flag(self.value, "Switch.value"))

    def checked(self, value: object, path: str) -> bool:
        """True or False."""
        return flag(value, path)

    def content(self) -> dict[str, Any]:
        """Nothing: both values are known."""
        return {}


@dataclass(frozen=True)
class Choice(Control):
    """Choice of a panel: one of several words or numbers.

        def build(shape):
            ball = pc.RigidBody({"disc": pc.Disc(0.1), "box": pc.Rectangle(0.2, 0.2)}[shape], (0.0, 1.0))
            return pc.Scene(ball, pc.Gravity(), pc.Floor())
        panel = pc.live(build, shape=pc.Choice(("disc", "box")), show=False)
        panel.close()

    Args:
        options: the words or numbers, all different.
        value: the one at the start; None: the first.

    Raises:
        SceneError: there are no options, one is no word or number or occurs twice, or the value is none of them.
    """

    options: tuple[str | float, ...]
    value: str | float | None = None

    kind: ClassVar[str] = "choice"

    def __post_init__(self) -> None:
        options = items(self.options, "Choice.options", "words or numbers")
        if not options:
            raise SceneError("Choice.options: must be words or numbers, at least one, got none")
        for place, option in enumerate(options):
            path = f"Choice.options[{place}]"
            if isinstance(option, bool) or not isinstance(option, (str, int, float)):
                raise SceneError(f"{path}: must be a word or a number, got {shown(option)}")
            if not isinstance(option, str):
                number(option, path)
            if option in options[:place]:
                raise SceneError(f"{path}: {shown(option)} is there twice")
        object.__setattr__(self, "options", tuple(options))
        start = self.options[0] if self.value is None else self.value
        object.__setattr__(self, "value", self.checked(start, "Choice.value"))

    def checked(self, value: object, path: str) -> str | float:
        """One of the options."""
        if isinstance(value, (str, int, float)) and not isinstance(value, bool):
            for option in self.options:
                if option == value:
                    return option
        raise SceneError(f"{path}: must be one of {', '.join(map(repr, self.options))}, got {shown(value)}")

    def content(self) -> dict[str, Any]:
        """The options."""
        return {"options": list(self.options)}


def _whole(value: object, path: str) -> int:
    """A whole number of either sign."""
    if isinstance(value, float) and value.is_integer():
        value = int(value)  # as a page sends it
    return count(value, path, least=-(1 << 53), most=1 << 53)
