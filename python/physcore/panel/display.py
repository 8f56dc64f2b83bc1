"""How a panel is shown: as a page in the browser, or as a widget in a notebook."""

from __future__ import annotations

import sys
import webbrowser
from typing import TYPE_CHECKING

from physcore.errors import PhyscoreError

if TYPE_CHECKING:
    from physcore.panel.panel import Panel


def display(panel: Panel) -> None:
    """Show a panel: in a notebook as a widget, elsewhere in the browser, with its address on the terminal."""
    if in_notebook():
        from IPython.display import display as show

        show(widget(panel))  # type: ignore[no-untyped-call]
        return
    print(f"The panel is {panel.url}", file=sys.stderr, flush=True)
    webbrowser.open(panel.url)


def widget(panel: Panel) -> object:
    """The widget of a panel.

    Raises:
        PhyscoreError: anywidget is not installed.
    """
    try:
        from physcore.panel.widget import PanelWidget
    except ImportError as error:
        raise PhyscoreError(
            "live: a widget needs the package anywidget, which is not installed: pip install 'physcore[live]'; "
            "without it open panel.url in a browser"
        ) from error
    return PanelWidget(panel)


def in_notebook() -> bool:
    """Whether this is a kernel of a notebook, as opposed to a script or a terminal."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return shell is not None and hasattr(shell, "kernel")
