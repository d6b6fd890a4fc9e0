"""A viser server that lets in nobody else: Host, Origin and a random key in the address are checked at every request.

viser binds to all interfaces, answers any host name and any page of any origin, and offers to open a tunnel to a public server.
None of that is wanted for a page on which files are read and written.
"""

from __future__ import annotations

import contextlib
import dataclasses
import hmac
import http
import io
import logging
import secrets
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import viser
import viser.infra._infra as inner
from viser._messages import ShareUrlRequest
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from .page import extended

LOOPBACK = "127.0.0.1"
# Names of this machine that a browser on it may use.
LOCAL = ("127.0.0.1", "localhost", "[::1]")
REFUSED = b"pennate view: this address is not valid. Open the one that the program printed, its last part included.\n"

Handler = Callable[[Any, Request], Response | None]
# One server is made at a time: see `guarded`.
making = threading.Lock()


class GuardError(RuntimeError):
    """The server cannot be guarded, and was not started."""


@dataclasses.dataclass
class Guard:
    """Who is let in."""

    key: str
    # Names of hosts besides this machine's own, as they stand in the address; empty unless asked for.
    hosts: tuple[str, ...] = ()
    port: int = 0

    def why_not(self, request: Request) -> str | None:
        """What is wrong with a request, or nothing."""
        names = request.headers.get_all("Host")
        if len(names) != 1 or not self.knows(names[0]):
            return "host"
        origins = request.headers.get_all("Origin")
        upgrade = request.headers.get("Upgrade", "").lower() == "websocket"
        if (upgrade and len(origins) != 1) or any(not self.same(origin, names[0]) for origin in origins):
            return "origin"
        first = request.path.partition("?")[0].strip("/").partition("/")[0]
        if not hmac.compare_digest(first.encode("utf-8", "replace"), self.key.encode()):
            return "key"
        return None

    def knows(self, host: str) -> bool:
        """Whether a Host header is one of ours, with our port."""
        name, _, port = host.rpartition(":")
        return port == str(self.port) and name.lower() in (*LOCAL, *(each.lower() for each in self.hosts))

    @staticmethod
    def same(origin: str, host: str) -> bool:
        """Whether an origin is the page itself."""
        return origin.lower() == f"http://{host.lower()}"

    def around(self, handler: Handler) -> Handler:
        """The handler of viser, behind the checks and without the key in its path."""

        def checked(connection: Any, request: Request) -> Response | None:
            if self.why_not(request) is not None:
                headers = Headers(
                    [("Content-Type", "text/plain; charset=utf-8"), ("Content-Length", str(len(REFUSED)))]
                )
                return Response(http.HTTPStatus.FORBIDDEN, "Forbidden", headers, REFUSED)
            rest = request.path.strip("/").partition("/")[2] if "/" in request.path.strip("/") else ""
            # The page is compressed in itself; asked for as it is, it can be added to.
            plain = Headers(each for each in request.headers.raw_items() if each[0].lower() != "accept-encoding")
            found = handler(connection, dataclasses.replace(request, path="/" + rest, headers=plain))
            if found is not None:
                found = extended(found)
                found.headers["Referrer-Policy"] = "no-referrer"
                found.headers["X-Content-Type-Options"] = "nosniff"
                found.headers["Cache-Control"] = "no-store"
            return found

        return checked


class Stand:
    """The module `websockets` as viser sees it while a server is made: `serve` gets the guarded handler."""

    def __init__(self, real: Any, guard: Guard) -> None:
        self.real, self.guard, self.used = real, guard, False
        self.asyncio = self
        self.server = self

    def serve(self, handler: Any, host: str, port: int, **options: Any) -> Any:
        """As `websockets.asyncio.server.serve`."""
        self.used = True
        self.guard.port = port
        options["process_request"] = self.guard.around(options["process_request"])
        return self.real.asyncio.server.serve(handler, host, port, **options)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.real, name)


@contextlib.contextmanager
def guarded(guard: Guard) -> Iterator[Stand]:
    """While this lasts, servers that viser makes are guarded; viser has no argument for it."""
    with making:
        module: Any = inner
        real = module.websockets
        stand = module.websockets = Stand(real, guard)
        try:
            yield stand
        finally:
            module.websockets = real


def heard(record: logging.LogRecord) -> bool:
    """Whether a line of the log is more than a browser that opened a connection and did not use it."""
    return record.getMessage() != "opening handshake failed"


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """viser prints a table of its own."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield


class Server(viser.ViserServer):
    """viser's server behind a `Guard`; `address` is the only one that it answers to."""

    guard: Guard

    def __init__(self, port: int, label: str, bind: str = LOOPBACK, hosts: Sequence[str] = ()) -> None:
        self.guard = Guard(secrets.token_urlsafe(18), tuple(hosts))
        logging.getLogger("websockets.server").addFilter(heard)
        with quiet(), guarded(self.guard) as stand:
            super().__init__(host=bind, port=port, label=label, verbose=False)
        if not stand.used:
            self.stop()
            raise GuardError(f"viser {viser.__version__} cannot be guarded by this version of pennate; viser 1.1 can")
        self.guard.port = self.get_port()
        # A page that was let in may not open a tunnel to the outside.
        self._websock_server.unregister_handler(ShareUrlRequest)

    @property
    def address(self) -> str:
        """The address with its key."""
        name = self.guard.hosts[0] if self.guard.hosts else LOOPBACK
        return f"http://{name}:{self.guard.port}/{self.guard.key}/"

    def stop(self) -> None:
        """Stops it."""
        with quiet():
            super().stop()

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Never: a key in an address is no good where the address goes through somebody else's server."""
        return None
