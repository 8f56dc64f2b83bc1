"""The function `live`, which opens a panel."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, cast

from physcore.checks import count, flag, span
from physcore.entrance import entrance
from physcore.film.renderer import Renderer
from physcore.numerics.choices import Options
from physcore.panel.controls import Control
from physcore.panel.display import display
from physcore.panel.pace import nominal_speed
from physcore.panel.panel import Panel
from physcore.panel.session import Session
from physcore.scene.scene import Scene
from physcore.spelling import KeywordError

OWN: dict[str, Any] = {"fps": 60.0, "speed": None, "show": True, "port": 0}
"""Options of `live` itself, with their defaults."""
PICTURES = tuple(
    name for name in inspect.signature(Renderer.__init__).parameters if name not in ("self", "scene", "fps")
)
"""Options of pictures."""


@entrance
def live(
    build: Callable[..., Scene],
    *,
    fps: float = 60.0,
    speed: float | None = None,
    show: bool = True,
    port: int = 0,
    **options: Any,
) -> Panel:
    """Open a panel: a simulation that plays, with sliders, in a page of the browser or in a notebook.

        def build(stiffness, wind):
            net = pc.cloth((12, 8), 0.05, stiffness=stiffness, damping=0.02, mass=2e-3, pinned="top corners")
            return pc.Scene(net, pc.Gravity(), *([pc.Drag(0.01, wind=(1.0, 0.0))] if wind else []))
        panel = pc.live(build, stiffness=pc.Slider(10.0, 1000.0, 200.0), wind=pc.Switch(False), show=False)
        panel.play()
        panel.set(stiffness=800.0)
        panel.close()

    The page has the buttons play, pause, step, reset and save, the controls, the curve of energy with its drift, and
    the time step with its limit. The mouse drags particles and rigid bodies by a spring, whose work is in the budget.

    Physics runs in a thread of its own at its time step, pictures are drawn in another one by the renderer of films.
    Neither waits for the other. A scene that is too slow for its speed plays slower, and the page says by how much.

    The page is served to this machine alone, and to those who know its address, which has a token in it. When the page
    is closed, the panel closes after five seconds. A panel whose page was never opened runs until `close`.

    Args:
        build: a function that takes the controls by name and returns a Scene.
        fps: pictures per second.
        speed: seconds of the simulation, or units of time of its scene, per second. None: 1, or with time steps above
            0.1 s or below 1 µs about four steps per picture.
        show: whether to open the page in the browser, or in a notebook to show the panel as a widget.
        port: the port of the page; 0: any that is free.
        options: controls, which are Slider, Switch or Choice, by the names of the arguments of `build`; numerics (dt,
            integrator …) as of Simulation; and options of the pictures (style, camera, size, theme …) as of Renderer.

    Returns:
        Panel: to play, pause, set and read from a script, at time 0 and paused; a page that opens it begins to play.

    Raises:
        SceneError: `build` fails or returns no Scene, an option is not valid, or the port is taken.
        PhyscoreError: websockets is not installed.

    Warns:
        StabilityWarning: a given `dt` is above the limit of stability.
    """
    given = {"fps": fps, "speed": speed, "show": show, "port": port, **options}
    controls = {name: value for name, value in given.items() if isinstance(value, Control)}
    own = {**OWN, **{name: given[name] for name in OWN if name not in controls}}  # `build` may have a `speed` too
    numerics = {name: options[name] for name in options if name in Options.__annotations__ and name not in controls}
    pictures = {name: options[name] for name in options if name in PICTURES and name not in controls}
    for name in options:
        if name not in (*controls, *numerics, *pictures):
            raise KeywordError("live", name, (*OWN, *Options.__annotations__, *PICTURES))
    rate, where = span(own["fps"], "fps"), count(own["port"], "port", most=65535)
    pace = None if own["speed"] is None else span(own["speed"], "speed")
    shown = flag(own["show"], "show")
    session = Session(build, controls, cast("Options", numerics))
    session.speed = nominal_speed(session.simulation.dt, rate) if pace is None else pace
    panel = Panel(session, controls, pictures, rate, where, shown=shown)
    if shown:
        display(panel)
    return panel
