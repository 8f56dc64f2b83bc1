"""The live panel: a simulation that runs while one looks at it, with sliders, in a page of the browser.

Registries: controls stand in `controls`; what the page may ask for, in `requests`.
"""

from physcore.panel.controls import Choice, Control, Slider, Switch
from physcore.panel.opening import live
from physcore.panel.panel import Panel

__all__ = ["Choice", "Control", "Panel", "Slider", "Switch", "live"]
