"""Server of a panel: the page, and a connection for pictures, reports and requests, in a thread of its own."""

from __future__ import annotations

import asyncio
import json
import logging
import socket
import struct
import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from http import HTTPStatus
from typing import TYPE_CHECKING, Any

from physcore.errors import PhyscoreError, SceneError
from physcore.panel.door import PAGE, Door, new_token

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

GRACE = 5.0
"""Time for which a panel waits for another page after the last one was closed [s], as for a reload."""
AHEAD = 2
"""Largest number of pictures on their way to a page."""
LONGEST = 1 << 16
"""Largest size of a message from a page [bytes]."""
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "connect-src 'self' ws://127.0.0.1:{port} ws://localhost:{port}; frame-ancestors 'none'; base-uri 'none'; "
    "form-action 'none'"
)
"""Content Security Policy of the page: nothing is fetched from elsewhere."""


class Server:
    """Server on this machine alone.

    Args:
        page: the page.
        port: the port; 0: any that is free.
        receive: is called with each message of a page, in the server's thread; must return at once.
        greet: gives the messages for a new page.
        save: gives the GIF of the last seconds; is called in a thread of its own.
        watched: is called with whether there is a page, when this changes.
        deserted: is called when all pages have been closed for GRACE seconds.
        daemon: whether the interpreter may end while it runs.

    Raises:
        SceneError: the port is taken.
        PhyscoreError: websockets is not installed.
    """

    def __init__(
        self,
        page: str,
        port: int,
        *,
        receive: Callable[[object], None],
        greet: Callable[[], list[str]],
        save: Callable[[], bytes],
        watched: Callable[[bool], None],
        deserted: Callable[[], None],
        daemon: bool,
    ) -> None:
        try:
            import websockets.asyncio.server  # noqa: F401 - a hint before anything runs
        except ImportError as error:
            raise PhyscoreError(
                "live: needs the package websockets, which is not installed: pip install 'physcore[live]'"
            ) from error
        self._page, self._receive, self._greet, self._save = page.encode(), receive, greet, save
        self._watched, self._deserted = watched, deserted
        self._socket = _bound(port)
        self.door = Door(self._socket.getsockname()[1], new_token())
        self._clients: set[_Client] = set()
        self._leaving: asyncio.TimerHandle | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._end = asyncio.Event()
        self._started: Future[None] = Future()
        self._thread = threading.Thread(target=self._run, name="physcore-panel-server", daemon=daemon)

    def start(self) -> None:
        """Start to listen; on return the address answers."""
        self._thread.start()
        self._started.result()

    def stop(self) -> None:
        """Close all connections and the port, and wait for the end of the thread."""
        if self._loop is not None:
            with suppress(RuntimeError):  # The loop has ended already.
                self._loop.call_soon_threadsafe(self._end.set)
        if self._thread.ident is not None and threading.current_thread() is not self._thread:
            self._thread.join()
        self._socket.close()

    def tell(self, content: dict[str, Any]) -> None:
        """Send a message to all pages, from any thread."""
        text = json.dumps(content, allow_nan=False)
        self._for_each(lambda client: client.say(text))

    def show(self, pixels: NDArray[Any], hand: tuple[float, ...] | None) -> None:
        """Send a picture to all pages that have shown the last ones, from any thread."""
        content = framed(pixels, hand)
        self._for_each(lambda client: client.offer(content))

    def _for_each(self, work: Callable[[_Client], object]) -> None:
        """Have something done for each page, in the server's thread."""
        loop = self._loop
        if loop is not None and self._clients:
            with suppress(RuntimeError):  # The loop has ended.
                loop.call_soon_threadsafe(lambda: [work(client) for client in self._clients])

    def _run(self) -> None:
        try:
            asyncio.run(self._serve())
        except BaseException as error:
            if not self._started.done():
                self._started.set_exception(error)

    async def _serve(self) -> None:
        from websockets.asyncio.server import serve

        self._loop = asyncio.get_running_loop()
        silent = logging.getLogger("physcore.panel")
        silent.addHandler(logging.NullHandler())
        silent.propagate = False
        async with serve(
            self._talk,
            sock=self._socket,
            process_request=self._answer,
            compression=None,
            max_size=LONGEST,
            server_header=None,
            close_timeout=1.0,
            logger=silent,
        ):
            self._started.set_result(None)
            await self._end.wait()
            self._loop = None

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """The page, or a refusal; None lets the connection for messages begin."""
        refusal = self.door.refusal(request.path, request.headers.get_all)
        if refusal is not None:
            return connection.respond(refusal, f"{refusal.phrase}\n")
        if request.path.partition("?")[0] != PAGE:
            return None
        answer = connection.respond(HTTPStatus.OK, "")
        answer.body = self._page
        headers = {
            "Content-Length": str(len(self._page)),
            "Content-Type": "text/html; charset=utf-8",
            "Content-Security-Policy": POLICY.format(port=self.door.port),
            "Cache-Control": "no-store",
            "Cross-Origin-Opener-Policy": "same-origin",
            "Cross-Origin-Resource-Policy": "same-origin",
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
        }
        for name, value in headers.items():
            if name in answer.headers:
                del answer.headers[name]
            answer.headers[name] = value
        return answer

    async def _talk(self, connection: ServerConnection) -> None:
        """Serve one page until it is closed."""
        client = _Client(connection)
        self._join(client)
        sending = asyncio.ensure_future(client.send())
        try:
            async for text in connection:
                self._heed(client, text)
        finally:
            sending.cancel()
            self._leave(client)

    def _join(self, client: _Client) -> None:
        if self._leaving is not None:
            self._leaving.cancel()
            self._leaving = None
        self._clients.add(client)
        for text in self._greet():
            client.say(text)
        self._watched(True)

    def _leave(self, client: _Client) -> None:
        self._clients.discard(client)
        if not self._clients:
            self._watched(False)
            self._leaving = asyncio.get_running_loop().call_later(GRACE, self._deserted)

    def _heed(self, client: _Client, text: str | bytes) -> None:
        """Do what a page asks for."""
        try:
            message = json.loads(text)
        except (ValueError, RecursionError):
            return
        kind = message.get("do") if isinstance(message, dict) else None
        if kind == "seen":
            client.seen(message.get("number"))
        elif kind == "save":
            task = asyncio.ensure_future(self._give(client))
            client.tasks.add(task)
            task.add_done_callback(client.tasks.discard)
        else:
            self._receive(message)

    async def _give(self, client: _Client) -> None:
        """Send the last seconds as a GIF."""
        try:
            content = await asyncio.to_thread(self._save)
        except PhyscoreError as error:
            client.say(json.dumps({"kind": "saved", "error": str(error)}))
        else:
            client.say(json.dumps({"kind": "saved", "bytes": len(content)}))
            client.say(b"GIF " + content)


class _Client:
    """Connection to one page. A page that is slow in showing pictures gets fewer of them."""

    def __init__(self, connection: ServerConnection) -> None:
        self._connection = connection
        self._messages: list[str | bytes] = []
        self._picture: bytes | None = None
        self._away = 0
        """Pictures on their way."""
        self._ready = asyncio.Event()
        self.tasks: set[asyncio.Future[None]] = set()

    def say(self, message: str | bytes) -> None:
        """Send a message."""
        self._messages.append(message)
        self._ready.set()

    def offer(self, picture: bytes) -> None:
        """Send a picture in place of an earlier one that has not been sent."""
        self._picture = picture
        self._ready.set()

    def seen(self, number: object) -> None:
        """Note that the page has received a number of pictures, and shown the last of them."""
        if isinstance(number, int):
            self._away = min(max(0, self._away - number), AHEAD)
        self._ready.set()

    async def send(self) -> None:
        """Send what is to be sent, until cancelled."""
        from websockets.exceptions import ConnectionClosed

        try:
            while True:
                await self._ready.wait()
                self._ready.clear()
                messages, self._messages = self._messages, []
                for message in messages:
                    await self._connection.send(message)
                if self._picture is not None and self._away < AHEAD:
                    picture, self._picture = self._picture, None
                    self._away += 1
                    await self._connection.send(picture)
        except ConnectionClosed:
            return


def framed(pixels: NDArray[Any], hand: tuple[float, ...] | None) -> bytes:
    """A picture as a message: "RGB ", width, height, four pixel coordinates of the hand or NaN, and the colors."""
    height, width = pixels.shape[:2]
    ends = hand if hand is not None else (float("nan"),) * 4
    return struct.pack("<4sII4f", b"RGB ", width, height, *ends) + pixels.tobytes()


def _bound(port: int) -> socket.socket:
    """A socket that listens on this machine.

    Raises:
        SceneError: the port is taken, or may not be used.
    """
    try:
        return socket.create_server(("127.0.0.1", port))
    except OSError as error:
        reason = error.strerror or str(error)
        raise SceneError(f"port: {port} cannot be used: {reason}; port=0 takes any that is free") from error
