"""The server: on this machine alone, behind a guard, until it is ended."""

import socket
import threading
from collections.abc import Iterable
from typing import Any

from dshpm_jax._bridges.optional import optional
from dshpm_jax._review.desk import Desk
from dshpm_jax._review.guard import Guard, new_token

HOST = "127.0.0.1"
INSTALL = "'dshpm-jax[review]'"


class Server:
    """Serves a desk at `address` until it is stopped.

    Arguments:
        port: 0 takes any that is free.
        framed_by: origins whose pages may show this one inside theirs.

    Raises:
        ImportError: the libraries of the extra `review` are not there.
        OSError: the port is taken.
    """

    def __init__(self, desk: Desk, port: int = 0, framed_by: Iterable[str] = ()):
        uvicorn = optional("uvicorn", "the page", INSTALL)
        optional("starlette", "the page", INSTALL)
        from dshpm_jax._review.app import app_of

        self._desk = desk
        self._socket = socket.create_server((HOST, port))
        self.port = self._socket.getsockname()[1]
        token = new_token()
        self.address = f"http://{HOST}:{self.port}/{token}/"
        app: Any = Guard(app_of(desk), token, self.port, framed_by)
        about = {"lifespan": "off", "access_log": False, "log_level": "critical", "server_header": False}
        self._server = uvicorn.Server(uvicorn.Config(app, timeout_graceful_shutdown=2, **about))
        self._thread: threading.Thread | None = None

    def run(self) -> None:
        """Serves until Ctrl-C, then writes what is due."""
        try:
            self._server.run(sockets=[self._socket])
        except KeyboardInterrupt:  # which is how it is meant to end
            pass
        finally:
            self._end()

    def start(self) -> None:
        """Serves in a thread of its own."""
        self._thread = threading.Thread(target=self._server.run, args=([self._socket],), daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Ends what `start` began, and writes what is due."""
        self._server.should_exit = True
        if self._thread is not None:
            self._thread.join()
        self._end()

    def _end(self) -> None:
        self._socket.close()
        self._desk.end()
