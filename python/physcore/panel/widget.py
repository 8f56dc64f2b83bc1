"""The panel in a notebook: the client of the page, with the kernel's messages in place of a WebSocket."""

from __future__ import annotations

import json
import re
import threading
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import anywidget

from physcore.errors import PhyscoreError
from physcore.panel.panel import page
from physcore.panel.server import AHEAD, GRACE, framed

if TYPE_CHECKING:
    from physcore.panel.artist import Picture
    from physcore.panel.panel import Panel

MODULE = """
function render({ model, el }) {
  const root = document.createElement("div");
  el.append(root);
  let to = null;
  const heard = (message, buffers) => {
    if (to === null) return;
    if (buffers && buffers.length) to.binary(buffers[0]); else to.text(message);
  };
  mount(root, {
    send: message => model.send(message),
    open: given => { to = given; model.on("msg:custom", heard); model.send({do: "open"}); },
    keys: false,
  });
  return () => { model.off("msg:custom", heard); model.send({do: "shut"}); };
}
export default { render };
"""
"""End of the widget's module, after the client of the page."""


def parts() -> tuple[str, str]:
    """The client and the style of the page."""
    text = page()
    client = re.search(r'<script id="client">\n"use strict";\n(.*?)</script>', text, flags=re.DOTALL)
    style = re.search(r'<style id="look">\n(.*?)html, body .*?</style>', text, flags=re.DOTALL)
    assert client is not None  # The page is part of the package.
    assert style is not None
    return client[1], style[1]


CLIENT, STYLE = parts()


class PanelWidget(anywidget.AnyWidget):
    """Widget of a panel. When its last view is gone for five seconds, the panel closes."""

    _esm = CLIENT + MODULE
    _css = STYLE

    def __init__(self, panel: Panel) -> None:
        super().__init__()
        self._panel = panel
        self._views, self._away = 0, 0
        self._leaving: threading.Timer | None = None
        panel.listeners.append(self._say)
        panel.viewers.append(self._show)
        self.on_msg(self._heed)

    def _say(self, content: dict[str, Any]) -> None:
        """Send a message to all views."""
        if self._views:
            self.send(content)

    def _show(self, picture: Picture) -> None:
        """Send a picture, unless those before are still on their way."""
        if self._views and self._away < AHEAD:
            self._away += 1
            self.send({"kind": "picture"}, [framed(picture.pixels, picture.hand)])

    def _heed(self, widget: object, message: object, buffers: Sequence[bytes]) -> None:
        """Do what a view asks for."""
        del widget, buffers
        kind = message.get("do") if isinstance(message, dict) else None
        if kind == "open":
            self._open()
        elif kind == "shut":
            self._shut()
        elif kind == "seen":
            self._away = 0
        elif kind == "save":
            self._save()
        else:
            self._panel.desk.receive(message)

    def _open(self) -> None:
        """Begin with a view."""
        if self._leaving is not None:
            self._leaving.cancel()
            self._leaving = None
        self._views, self._away = self._views + 1, 0
        for text in self._panel.greeting():
            self.send(json.loads(text))
        self._panel.watched(self, on=True)

    def _shut(self) -> None:
        """End with a view."""
        self._views = max(0, self._views - 1)
        if not self._views:
            self._panel.watched(self, on=False)
            self._leaving = threading.Timer(GRACE, self._panel.close)
            self._leaving.start()

    def _save(self) -> None:
        """Send the last seconds as a GIF."""
        try:
            content = self._panel.gif()
        except PhyscoreError as error:
            self.send({"kind": "saved", "error": str(error)})
        else:
            self.send({"kind": "saved", "bytes": len(content)})
            self.send({"kind": "film"}, [b"GIF " + content])
