"""Who is answered: the page that this program opened, and nobody else on this machine or in a browser's other tabs."""

import re
from collections.abc import Awaitable, Callable, Iterable, Mapping
from hmac import compare_digest
from secrets import token_urlsafe
from typing import Any

TOKEN_BYTES = 24
TOKEN_HEADER = "x-review-token"
"""The page says the token here too, so that no form or picture of another page can ask for anything."""

PATH = re.compile(rb"/(?P<token>[A-Za-z0-9_-]{1,80})(?P<rest>/([A-Za-z0-9_-]+(\.[a-z]+|(/[A-Za-z0-9_-]+)+))?)")
"""All that a path may hold: no escapes, no empty steps, and no dots but in the names of our own two files."""

CALLS = b"/api/"
"""Where data is asked for and changed; besides that there are the page, its style and its script."""

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors "
)

Scope = Mapping[str, Any]
App = Callable[[Any, Any, Any], Awaitable[None]]


def new_token() -> str:
    """A token that nobody guesses."""
    return token_urlsafe(TOKEN_BYTES)


class Guard:
    """Stands before an app and answers 403, without a word, to whoever does not come from the page.

    Arguments:
        app: gets what passes, with the token taken out of its path.
        token: the first step of every path.
        port: where the server listens; a request to another host or from another origin is none of ours.
        framed_by: origins whose pages may show this one inside theirs, such as that of a notebook.
    """

    def __init__(self, app: App, token: str, port: int, framed_by: Iterable[str] = ()):
        self._app, self._token = app, token.encode()
        self._hosts = {f"{name}:{port}".encode() for name in ("127.0.0.1", "localhost")}
        self._origins = {b"http://" + host for host in self._hosts}
        self._headers = _headers(tuple(framed_by))

    async def __call__(self, scope: Scope, receive: Any, send: Any) -> None:
        if scope["type"] != "http":
            return
        path = PATH.fullmatch(scope.get("raw_path") or scope["path"].encode())
        if path is None or scope.get("query_string") or not self._welcome(scope, path["token"], path["rest"]):
            await send({"type": "http.response.start", "status": 403, "headers": [(b"content-length", b"0")]})
            await send({"type": "http.response.body", "body": b""})
            return

        async def dressed(message: dict[str, Any]) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [*message.get("headers", ()), *self._headers]
            await send(message)

        rest = path["rest"]
        await self._app({**scope, "path": rest.decode(), "raw_path": rest, "root_path": ""}, receive, dressed)

    def _welcome(self, scope: Scope, token: bytes, rest: bytes) -> bool:
        headers: dict[bytes, bytes] = {}
        for name, value in scope["headers"]:
            if name in headers and name in (b"host", b"origin", TOKEN_HEADER.encode()):
                return False
            headers[name] = value
        called, changes = rest.startswith(CALLS), scope["method"] != "GET"
        origin, said = headers.get(b"origin"), headers.get(TOKEN_HEADER.encode(), b"")
        return (
            headers.get(b"host") in self._hosts
            and compare_digest(token, self._token)
            and scope["method"] in ("GET", "POST")
            and (called or not changes)
            and (not called or compare_digest(said, self._token))
            and (origin in self._origins if origin is not None else not changes)
        )


def _headers(framed_by: tuple[str, ...]) -> list[tuple[bytes, bytes]]:
    policy = POLICY + (" ".join(framed_by) or "'none'")
    found = {
        "content-security-policy": policy,
        "cache-control": "no-store",
        "referrer-policy": "no-referrer",
        "x-content-type-options": "nosniff",
        "cross-origin-resource-policy": "same-origin",
        "cross-origin-opener-policy": "same-origin",
    }
    return [(name.encode(), value.encode()) for name, value in found.items()]
