"""Nobody is answered but the page: whatever is asked with a wrong token, host, origin or path, nothing comes back."""

import asyncio
import random
from collections.abc import Iterator
from pathlib import Path

import pytest
from wrong_results import write_wrong

from dshpm_jax._review.desk import Desk
from dshpm_jax._review.guard import TOKEN_HEADER, Guard
from dshpm_jax._review.places import places_in

httpx = pytest.importorskip("httpx", reason="Starlette's test client is not installed")
testclient = pytest.importorskip("starlette.testclient", reason="the extra 'review' is not installed")

TOKEN, PORT = "the-right-token_0123456789", 8008
HOST = f"127.0.0.1:{PORT}"
RIGHT = {"host": HOST, TOKEN_HEADER: TOKEN}
TRIALS = 10_000


@pytest.fixture(scope="module")
def out(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("guard")
    (folder / "secret.c3d").write_bytes(b"SECRET")
    out = write_wrong(folder, {})
    (out / "link.c3d").symlink_to(folder / "secret.c3d")
    return out


@pytest.fixture(scope="module")
def guarded(out) -> Iterator[Guard]:
    from dshpm_jax._review.app import app_of

    desk = Desk(places_in(out), "labelled")
    yield Guard(app_of(desk), TOKEN, PORT)
    desk.end()


@pytest.fixture(scope="module")
def ask(guarded):
    client = testclient.TestClient(guarded, base_url=f"http://{HOST}", follow_redirects=False)

    def ask(method: str, path: str, headers, body: bytes | None = None):
        return client.request(method, f"http://{HOST}{path}", headers=headers, content=body)

    return ask


def test_the_page_and_its_calls_are_answered(ask, out):
    (name,) = places_in(out)
    for path in ("/", "/review.js", "/review.css"):
        assert ask("GET", f"/{TOKEN}{path}", {"host": HOST}).status_code == 200
    for path in ("queue", f"trial/{name}", f"points/{name}", "status", "names"):
        found = ask("GET", f"/{TOKEN}/api/{path}", RIGHT)
        assert found.status_code == 200 and found.content
        assert "default-src 'none'" in found.headers["content-security-policy"]
        assert found.headers["referrer-policy"] == "no-referrer" and found.headers["cache-control"] == "no-store"


def test_what_changes_labels_needs_an_origin_of_ours(ask, out):
    (name,) = places_in(out)
    body = b'{"version": 0, "kind": "refuse"}'
    for origin in (None, "null", "http://evil.example", f"https://{HOST}", "http://127.0.0.1:9"):
        headers = RIGHT | ({"origin": origin} if origin else {})
        assert ask("POST", f"/{TOKEN}/api/do/{name}", headers, body).status_code == 403
    assert ask("POST", f"/{TOKEN}/api/do/{name}", RIGHT | {"origin": f"http://{HOST}"}, body).status_code == 200


def wrong_request(rng: random.Random, name: str) -> tuple[str, str, dict[str, str]]:
    """A request with one thing wrong at least."""
    token, headers, rest = TOKEN, dict(RIGHT), rng.choice(["/", "/review.js", "/api/queue", f"/api/trial/{name}"])
    letters = "abcdefghijklmnopqrstuvwxyz0123456789-_"
    kind = rng.choice(["token", "short", "header", "host", "origin", "method", "path", "query"])
    if kind == "token":
        token = "".join(rng.choice(letters) for _ in range(rng.randint(1, 40)))
    elif kind == "short":
        token = TOKEN[: rng.randrange(1, len(TOKEN))] + rng.choice(["", "x", "%00", "/"])
    elif kind == "header":
        rest, headers[TOKEN_HEADER] = f"/api/trial/{name}", rng.choice(["", token[:-1], token + "x", token.upper()])
    elif kind == "host":
        names = [
            "evil.example",
            "127.0.0.1",
            "127.0.0.1:1",
            "localhost",
            f"evil.example:{PORT}",
            f"127.0.0.1.evil:{PORT}",
        ]
        headers["host"] = rng.choice([*names, f"[::1]:{PORT}", f"0.0.0.0:{PORT}", ""])
    elif kind == "origin":
        origins = ["http://evil.example", "null", "https://127.0.0.1", f"http://localhost.evil:{PORT}"]
        headers["origin"] = rng.choice([*origins, f"https://{HOST}", f"http://{HOST}.evil.example"])
    elif kind == "path":
        steps = [
            "..",
            ".",
            "%2e%2e",
            "%2f",
            "..%2f",
            "\\",
            "secret.c3d",
            "link.c3d",
            "walk.c3d",
            "etc",
            "passwd",
            "//",
            "~",
        ]
        rest = "/" + "/".join(rng.choice([*steps, "api", "trial", "points"]) for _ in range(rng.randint(1, 6)))
    elif kind == "query":
        rest += rng.choice(["?x=1", "?../../secret.c3d", "?file=/etc/passwd"])
    method = rng.choice(["PUT", "DELETE", "OPTIONS", "HEAD", "PATCH", "TRACE", "POST"]) if kind == "method" else "GET"
    return method, f"/{token}{rest}", headers


def test_whatever_is_wrong_nothing_is_answered(guarded, out):
    (name,) = places_in(out)
    rng = random.Random(11)

    async def all_of_them() -> None:
        async with httpx.AsyncClient(transport=httpx.ASGITransport(guarded)) as client:
            for _ in range(TRIALS):
                method, path, headers = wrong_request(rng, name)
                found = await client.request(method, f"http://{HOST}{path}", headers=headers)
                assert found.status_code in (403, 404), (method, path, headers)
                assert b"SECRET" not in found.content and len(found.content) < 60, (method, path, headers)

    asyncio.run(all_of_them())


def test_ids_that_are_no_trial(ask):
    for name in ("0" * 16, "walk", "link", "-", "secret"):
        for path in (f"trial/{name}", f"points/{name}", f"candidates/{name}/0/0", f"gaps/{name}/0"):
            assert ask("GET", f"/{TOKEN}/api/{path}", RIGHT).status_code == 404


def test_a_manifest_that_leads_out_of_the_folder(out):
    rows = (out / "manifest.jsonl").read_text()
    known = set(places_in(out))
    for output in ("../secret.c3d", "/etc/passwd", "link.c3d", "a/../../secret.c3d", "walk.labels.json"):
        line = rows.splitlines()[0].replace('"output": "walk.c3d"', f'"output": "{output}"')
        assert output in line
        (out / "manifest.jsonl").write_text(rows + line + "\n")
        assert set(places_in(out)) == known
    (out / "manifest.jsonl").write_text(rows)


def test_headers_that_come_twice(ask):
    twice = [("host", HOST), (TOKEN_HEADER, TOKEN), (TOKEN_HEADER, "x")]
    assert ask("GET", f"/{TOKEN}/api/queue", twice).status_code == 403


def test_too_much_at_once(ask, out):
    (name,) = places_in(out)
    headers = RIGHT | {"origin": f"http://{HOST}"}
    assert ask("POST", f"/{TOKEN}/api/do/{name}", headers, b"{" + b" " * (1 << 17)).status_code == 400
    for body in (
        b"",
        b"[]",
        b"{",
        b'{"version": 0}',
        b'{"version": "a", "kind": "undo"}',
        b'{"version": 0, "kind": "x"}',
    ):
        assert ask("POST", f"/{TOKEN}/api/do/{name}", headers, body).status_code in (400, 404, 409)
