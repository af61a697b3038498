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
from dshpm_jax._review.desk import Desk
from dshpm_jax._review.edits import Span
from dshpm_jax._review.session import Session, Stale
from dshpm_jax._review.trial import Trial

MAX_BODY = 1 << 16  # bytes of what the page sends

NOT_FOUND, WRONG, STALE = 404, 400, 409


Work = Callable[[Request, dict[str, Any]], Any]
"""What is done with a request and with what came with it; gives what goes back."""


def app_of(desk: Desk) -> Starlette:
    """The app over a desk, to be put behind a `Guard`."""
    answers = _Answers(desk)
    calls: dict[str, Work] = {
        "queue": answers.queue,
        "status": answers.status,
        "trial/{id}": answers.trial,
        "points/{id}": answers.points,
        "candidates/{id}/{version:int}/{track:int}": answers.candidates,
        "gaps/{id}/{version:int}": answers.gaps,
        "errors/{id}/{version:int}/{first:int}": answers.errors,
        "names": answers.sources,
    }
    changes: dict[str, Work] = {"do/{id}": answers.do, "names/{id}": answers.name}
    return Starlette(
        routes=[
            Route("/", _static(page_parts.frame, "text/html")),
            Route("/review.css", _static(page_parts.style, "text/css")),
            Route("/review.js", _static(page_parts.script, "text/javascript")),
            *(Route(f"/api/{path}", _answering(work), methods=["GET"]) for path, work in calls.items()),
            *(Route(f"/api/{path}", _answering(work), methods=["POST"]) for path, work in changes.items()),
        ]
    )


class _Answers:
    """What the page may ask for, each by the name that it has there."""

    def __init__(self, desk: Desk):
        self._desk = desk

    def queue(self, request: Request, sent: dict[str, Any]) -> Any:
        return {"title": self._desk.title, "trials": self._desk.queue()}

    def status(self, request: Request, sent: dict[str, Any]) -> Any:
        return self._desk.status()

    def trial(self, request: Request, sent: dict[str, Any]) -> Any:
        return self._desk.shown(self._opened(request))

    def points(self, request: Request, sent: dict[str, Any]) -> Any:
        return Response(self._desk.points(self._opened(request)), media_type="application/octet-stream")

    def candidates(self, request: Request, sent: dict[str, Any]) -> Any:
        trial = self._opened(request)
        with trial.session.at(request.path_params["version"]):
            return self._desk.candidates(trial, request.path_params["track"])

    def gaps(self, request: Request, sent: dict[str, Any]) -> Any:
        trial = self._opened(request)
        with trial.session.at(request.path_params["version"]):
            return self._desk.gaps(trial)

    def errors(self, request: Request, sent: dict[str, Any]) -> Any:
        trial = self._opened(request)
        with trial.session.at(request.path_params["version"]):
            return self._desk.gap_errors(trial, request.path_params["first"])

    def sources(self, request: Request, sent: dict[str, Any]) -> Any:
        return self._desk.sources()

    def name(self, request: Request, sent: dict[str, Any]) -> Any:
        trial = self._opened(request)
        with trial.session.at(sent["version"]):
            self._desk.name(trial, sent)
            return {}

    def do(self, request: Request, sent: dict[str, Any]) -> Any:
        trial = self._opened(request)
        with trial.session.at(sent["version"]):
            _do(trial.session, sent)
            return self._desk.state(trial)

    def _opened(self, request: Request) -> Trial:
        return self._desk.trial(request.path_params["id"])


def _answering(work: Work) -> Callable[[Request], Any]:
    """Does the work in a thread, and says in a line why it cannot be done."""

    async def answer(request: Request) -> Response:
        try:
            found = await run_in_threadpool(work, request, await _sent(request))
        except KeyError:
            return _wrong("there is no such thing", NOT_FOUND)
        except Stale as error:
            return _wrong(str(error), STALE)
        except (ValueError, TypeError) as error:
            return _wrong(" ".join(str(error).split()), WRONG)
        return found if isinstance(found, Response) else JSONResponse(found)

    return answer


def _do(session: Session, sent: dict[str, Any]) -> None:
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
