"""Is anything lost when the program behind `dshpm-jax review` is killed at a random moment?

    python bench/killed_reviews.py [--times 200] [--seed 0]

Each time a fresh copy of a result is corrected as fast as the program answers: labels set, confirmed, cut, undone, done
again. At a random moment the program is killed (SIGKILL). Then every correction that it had answered to must be in
the file of corrections, no file may be half, and the program that is started next must show all of them.
Every fifth time corrections are solved anew; the other times the model is away, so that there are more of them. On two
busy CPU cores:

    killed 200 times, 1898 corrections answered to, 0 times something was lost or half
"""

import argparse
import json
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from dataclasses import dataclass
from http.client import HTTPConnection, HTTPException
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np

from dshpm_jax import SubjectModel, io
from dshpm_jax.__main__ import main as command
from dshpm_jax._corrections import corrections_path, read_corrections
from dshpm_jax._corrections._format import resolved
from dshpm_jax._review.places import places_in
from dshpm_jax._review.saying import words
from dshpm_jax._review.trial import open_trial
from dshpm_jax.synthesis import add_ghosts, open_gaps, person, scramble

FRAMES, RATE = 240, 60.0
LONGEST = 4.0  # seconds after the first correction until the program is killed
SOLVED = 5  # every so many times
IN_FLIGHT = 4  # lines that what was asked last may have added before its answer came


@dataclass
class Killed:
    """One time: the corrections that were answered to, those that are kept, and what is wrong, if anything."""

    answered: int
    kept: int
    wrong: str


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("--times", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        made = make_results(Path(folder))
        found = []
        for k in range(arguments.times):
            rng = random.Random(arguments.seed * 1000 + k)
            found.append(kill_once(made, Path(folder) / "try", rng, solved=k % SOLVED == 0))
            if found[-1].wrong:
                print(f"time {k}: {found[-1].wrong}", flush=True)
    answered = sum(one.answered for one in found)
    wrong = sum(bool(one.wrong) for one in found)
    print(f"killed {len(found)} times, {answered} corrections answered to, {wrong} times something was lost or half")
    sys.exit(bool(wrong))


def make_results(folder: Path) -> Path:
    """A folder with a recording and its result."""
    rng = np.random.default_rng(0)
    whole = person(34, "walking", FRAMES, RATE, 1, 5).recording
    recording, _ = scramble(add_ghosts(open_gaps(whole, 0.1, rng), 0.1, rng), rng)
    captures = folder / "made" / "captures"
    captures.mkdir(parents=True)
    io.write_c3d(recording, captures / "walk.c3d")
    io.write_model(SubjectModel.from_recordings([person(34, frames=300, seed=1).recording]), captures / "model.json")
    command(["label", str(captures), "-o", str(folder / "made" / "labelled")])
    return folder / "made"


def kill_once(made: Path, folder: Path, rng: random.Random, solved: bool) -> Killed:
    """Corrects a copy of the result, kills the program at a random moment, and looks at what is left."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(made, folder)
    _move(folder, made)
    model = folder / "captures" / "model.json"
    if not solved:
        model.unlink()
    reviewing = _Reviewing(folder / "labelled")
    timer = threading.Timer(rng.uniform(0.0, LONGEST), reviewing.kill)
    try:
        reviewing.correct(rng, timer.start)
    finally:
        timer.cancel()
        reviewing.kill()
    return Killed(len(reviewing.shown), *_left(folder / "labelled", reviewing.shown))


def _move(folder: Path, made: Path) -> None:
    """The manifest says where the recording is."""
    path = folder / "labelled" / "manifest.jsonl"
    path.write_text(path.read_text().replace(str(made), str(folder)))


class _Reviewing:
    """The program, and what it has answered to; `shown` are the corrections that stood in its last answer."""

    def __init__(self, out: Path):
        command = [sys.executable, "-m", "dshpm_jax", "review", str(out), "--no-open"]
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        assert self._process.stdout is not None
        self._lines = self._process.stdout
        address = urlsplit(self._lines.readline().strip())
        self._host, self._token = address.netloc, address.path.strip("/")
        self.shown: list[str] = []

    def kill(self) -> None:
        self._process.send_signal(signal.SIGKILL)
        self._process.wait()
        self._lines.close()

    def correct(self, rng: random.Random, started) -> None:
        """Corrects until the program is gone."""
        connection = HTTPConnection(self._host, timeout=60)
        try:
            (trial,) = self._ask(connection, "queue")["trials"]
            state = self._ask(connection, f"trial/{trial['id']}")
            names = state["names"]
            started()
            while True:
                state = self._ask(connection, f"do/{trial['id']}", _wanted(rng, state, names)) or state
                if "history" in state:
                    self.shown = [one["text"] for one in state["history"] if one["stands"]]
        except (OSError, HTTPException):
            return
        finally:
            connection.close()

    def _ask(self, connection: HTTPConnection, path: str, body: dict[str, Any] | None = None) -> Any:
        """The answer; None where it was refused."""
        headers = {"X-Review-Token": self._token, "Origin": f"http://{self._host}"}
        sent = None if body is None else json.dumps(body)
        connection.request("GET" if body is None else "POST", f"/{self._token}/api/{path}", sent, headers)
        answer = connection.getresponse()
        content = answer.read()
        return json.loads(content) if answer.status == 200 else None


def _wanted(rng: random.Random, state: dict[str, Any], names: list[str]) -> dict[str, Any]:
    """Something that a person may do."""
    version = {"version": state["version"]}
    if state["proposal"]:
        return {**version, "kind": "accept", "mine_only": rng.random() < 0.3}
    track = rng.randrange(len(state["tracks"]))
    _, first, last, *_ = state["tracks"][track]
    kind = rng.choice(["assign", "assign", "none", "confirm", "cut", "undo", "redo"])
    if kind in ("undo", "redo"):
        return {**version, "kind": kind}
    if kind == "cut":
        return {**version, "kind": "cut", "track": track, "frame": rng.randint(first, last)}
    if kind == "confirm":
        return {**version, "kind": "confirm", "track": track}
    label = None if kind == "none" else rng.choice(names)
    return {**version, "kind": "assign", "track": track, "first": first, "last": last + 1, "label": label}


def _left(out: Path, shown: list[str]) -> tuple[int, str]:
    """How many corrections are kept, and what is wrong with the files."""
    try:
        found = read_corrections(corrections_path(out / "walk.c3d"))
        lines = found.lines if found else ()
        standing = _stood(lines)
        if not any(_stood(lines[: len(lines) - k]) == shown for k in range(IN_FLIGHT + 1)):
            return len(standing), f"shown as kept: {shown[-3:]}, found: {standing[-3:]}"
        if (out / "walk.c3d").exists():
            io.read(out / "walk.c3d")
        if io.read_sidecar(out / "walk.labels.json") is None:
            return len(standing), "the sidecar is damaged"
        for line in (out / "manifest.jsonl").read_text().splitlines():
            json.loads(line)
        (place,) = places_in(out).values()
        trial = open_trial(place)
        again = [words(one) for one in trial.session.standing]
        trial.close()
        return len(standing), "" if again == standing else "the program shows other corrections"
    except Exception as error:
        return 0, f"{type(error).__name__}: {error}"


def _stood(lines) -> list[str]:
    return [words(one) for one in resolved(lines)[0]]


if __name__ == "__main__":
    main()
