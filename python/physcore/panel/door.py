"""The door of a panel's server: who may come in."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from http import HTTPStatus
from urllib.parse import parse_qs, urlsplit

PAGE, SOCKET = "/", "/socket"
"""Paths of the page and of the connection for its messages. There are no others."""
HOSTS = ("127.0.0.1", "localhost")
"""Names of this machine."""


@dataclass(frozen=True)
class Door:
    """Checks of requests: only pages of this server on this machine, with the token, have an answer."""

    port: int
    token: str

    @property
    def url(self) -> str:
        """The address of the page, with the token."""
        return f"http://{HOSTS[0]}:{self.port}{PAGE}?token={self.token}"

    def refusal(self, target: str, headers: Callable[[str], Sequence[str]]) -> HTTPStatus | None:
        """The reason for refusing a request; None: it may come in, and its path is PAGE or SOCKET.

        A foreign `Host` is a name that was made to lead here (DNS rebinding), and a foreign `Origin` another page.

        Args:
            target: path and query of the request.
            headers: gives all values of a header.
        """
        try:
            parts = urlsplit(target)
            tokens = parse_qs(parts.query).get("token", [])
        except ValueError:
            return HTTPStatus.BAD_REQUEST
        own = [f"{host}:{self.port}" for host in HOSTS]
        hosts, origins = list(headers("Host")), list(headers("Origin"))
        if len(hosts) != 1 or hosts[0] not in own:
            return HTTPStatus.FORBIDDEN
        if len(origins) > 1 or any(origin not in [f"http://{host}" for host in own] for origin in origins):
            return HTTPStatus.FORBIDDEN
        if len(tokens) != 1 or not secrets.compare_digest(tokens[0].encode(), self.token.encode()):
            return HTTPStatus.FORBIDDEN
        known = parts.path in (PAGE, SOCKET) and not parts.netloc
        return None if known else HTTPStatus.NOT_FOUND


def new_token() -> str:
    """A token that cannot be guessed: 256 random bits."""
    return secrets.token_urlsafe(32)
