"""What the page may ask for: itself, the queue, a trial, and to do something to it."""

import json
from collections.abc import Callable
from typing import Any

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from dshpm_jax._review import page_parts
from dshpm_jax._review.desk import CannotOpen, Desk
from dshpm_jax._review.edits import Span
from dshpm_jax._review.session import Stale

MAX_BODY = 1 << 16  # bytes of what the page sends

NOT_FOUND, WRONG, STALE = 404, 400, 409


def app_of(desk: Desk) -> Starlette:
    """The app over a desk, to be put behind a `Guard`."""

    def answering(work: Callable[[Request, dict[str, Any]], Any]) -> Callable[[Request], Any]:
        async def answer(request: Request) -> Response:
            try:
                sent = await _sent(request)
                found = await run_in_threadpool(work, request, sent)
            except KeyError:
                return _wrong("there is no such thing", NOT_FOUND)
            except Stale as error:
                return _wrong(str(error), STALE)
            except (ValueError, TypeError) as error:
                return _wrong(" ".join(str(error).split()), WRONG)
            return found if isinstance(found, Response) else JSONResponse(found)

        return answer

    def trial(request: Request, sent: dict[str, Any]) -> Any:
        return desk.shown(desk.trial(request.path_params["id"]))

    def points(request: Request, sent: dict[str, Any]) -> Any:
        return Response(desk.points(desk.trial(request.path_params["id"])), media_type="application/octet-stream")

    def options(request: Request, sent: dict[str, Any]) -> Any:
        opened = desk.trial(request.path_params["id"])
        with opened.session.at(request.path_params["version"]):
            return desk.candidates(opened, request.path_params["track"])

    def do(request: Request, sent: dict[str, Any]) -> Any:
        opened = desk.trial(request.path_params["id"])
        with opened.session.at(sent["version"]):
            _do(opened.session, sent)
            return desk.state(opened)

    def gaps(request: Request, sent: dict[str, Any]) -> Any:
        opened = desk.trial(request.path_params["id"])
        with opened.session.at(request.path_params["version"]):
            return desk.gaps(opened)

    def errors(request: Request, sent: dict[str, Any]) -> Any:
        opened = desk.trial(request.path_params["id"])
        with opened.session.at(request.path_params["version"]):
            return desk.gap_errors(opened, request.path_params["first"])

    def name(request: Request, sent: dict[str, Any]) -> Any:
        opened = desk.trial(request.path_params["id"])
        with opened.session.at(sent["version"]):
            desk.name(opened, sent)
            return {}

    def queue(request: Request, sent: dict[str, Any]) -> Any:
        return {"title": desk.title, "trials": desk.queue()}

    routes = [
        Route("/", _static(page_parts.frame, "text/html")),
        Route("/review.css", _static(page_parts.style, "text/css")),
        Route("/review.js", _static(page_parts.script, "text/javascript")),
        Route("/api/queue", answering(queue)),
        Route("/api/status", answering(lambda request, sent: desk.status())),
        Route("/api/trial/{id}", answering(trial)),
        Route("/api/points/{id}", answering(points)),
        Route("/api/candidates/{id}/{version:int}/{track:int}", answering(options)),
        Route("/api/gaps/{id}/{version:int}", answering(gaps)),
        Route("/api/errors/{id}/{version:int}/{first:int}", answering(errors)),
        Route("/api/names", answering(lambda request, sent: desk.sources())),
        Route("/api/names/{id}", answering(name), methods=["POST"]),
        Route("/api/do/{id}", answering(do), methods=["POST"]),
    ]
    return Starlette(routes=routes)


def _do(session: Any, sent: dict[str, Any]) -> None:
    """One thing that a person does."""
    simple = {"undo": session.undo, "redo": session.redo, "refuse": session.refuse, "all": session.confirm_all}
    kind = sent["kind"]
    if kind in simple:
        simple[kind]()
    elif kind == "accept":
        session.accept(bool(sent.get("mine_only")))
    elif kind == "fill":
        session.fill(str(sent["marker"]), Span(int(sent["first"]), int(sent["last"])), bool(sent["accepted"]))
    else:
        session.propose(sent)


async def _sent(request: Request) -> dict[str, Any]:
    """What came with a request; `ValueError` if it is too much, or no names and values."""
    body = b""
    async for chunk in request.stream():
        body += chunk
        if len(body) > MAX_BODY:
            raise ValueError("that is too much at once")
    found = json.loads(body) if body else {}
    if not isinstance(found, dict):
        raise ValueError("that is nothing that the page sends")
    return found


def _static(content: Callable[[], bytes], kind: str) -> Callable[[Request], Any]:
    async def answer(request: Request) -> Response:
        return Response(content(), media_type=kind)

    return answer


def _wrong(text: str, status: int) -> JSONResponse:
    return JSONResponse({"error": text}, status_code=status)


__all__ = ["CannotOpen", "app_of"]
