"""Is `dshpm-jax review` smooth: pictures a second while a trial plays, and how long a correction takes?

    python bench/reviewing.py LABELLED [--trial NAME] [--corrections 20]

LABELLED is a folder of results; a copy of it is corrected. Pictures are counted for some seconds in headless Chromium,
1,400 by 900 pixels, with all points and all names shown. A correction gives a random label to a random labelled
trajectory of half a second at least; counted is from the question to the answer; then it is refused or taken back. On
two CPU cores with a load of 13, no graphics card, 49 markers, with gaps and ghosts:

    1,000 frames of 103 points, 1,325 trajectories
    without names: 36.8 pictures a second, 3.05 ms each
    20 corrections, of processor time: median 0.96 s, worst 1.84 s
    20 corrections, by the clock: median 2.96 s, worst 9.57 s

    10,000 frames of 69 points, 10,295 trajectories
    without names: 55.8 pictures a second, 2.20 ms each
    20 corrections, of processor time: median 1.51 s, worst 3.05 s
    20 corrections, by the clock: median 8.74 s, worst 22.20 s
"""

import argparse
import random
import shutil
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from dshpm_jax._compile_cache import cache_programs
from dshpm_jax._review.desk import Desk
from dshpm_jax._review.places import places_in
from dshpm_jax._review.serving import Server

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from devtools import Browser  # noqa: E402  # pyright: ignore[reportMissingImports]

SECONDS = 5.0  # of play
LEAST_SECONDS = 0.5  # of a trajectory that is corrected
COUNTING = """
window.pictures = 0; window.busy = 0;
const next = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = draw => next(now => {
  const start = performance.now(); draw(now); window.busy += performance.now() - start; window.pictures += 1;
});
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("labelled", type=Path)
    parser.add_argument("--trial", help="its name in the folder; the first by default")
    parser.add_argument("--corrections", type=int, default=20)
    arguments = parser.parse_args()
    cache_programs()
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "labelled"
        shutil.copytree(arguments.labelled, out)
        places = places_in(out)
        name = next(key for key, place in places.items() if arguments.trial in (None, place.name))
        desk = Desk(places, "bench")
        server = Server(desk)
        server.start()
        try:
            play(server.address + f"#trial={name}", Path(folder) / "profile")
            correct(desk, name, arguments.corrections)
        finally:
            server.stop()


def play(address: str, profile: Path) -> None:
    with Browser(profile) as browser:
        start = time.perf_counter()
        browser.open(address)
        print(f"open {time.perf_counter() - start:.2f} s; {browser.text('#about')}")
        browser.run(COUNTING)
        for labels in (False, True):
            if labels:
                browser.press("l")
            browser.press(" ")
            time.sleep(1)
            browser.run("window.pictures = 0, window.busy = 0")
            time.sleep(SECONDS)
            pictures, busy = browser.run("[window.pictures, window.busy]")
            browser.press(" ")
            what = "with all names" if labels else "without names"
            print(f"{what}: {pictures / SECONDS:.1f} pictures a second, {busy / max(pictures, 1):.2f} ms each")


def correct(desk: Desk, name: str, count: int) -> None:
    trial, rng = desk.trial(name), random.Random(0)
    session, rate = trial.session, trial.session.labelling.recording.rate
    took, worked, changed = [], [], []
    while len(took) <= count:
        labelling = session.labelling
        tracks = labelling.trajectories
        j = rng.choice(np.flatnonzero((labelling.identity >= 0) & (tracks.stop - tracks.start >= LEAST_SECONDS * rate)))
        wanted = {"kind": "assign", "track": int(j), "label": rng.choice(labelling.model.markers)}
        wanted |= {"first": int(tracks.start[j]), "last": int(tracks.stop[j])}
        start, begun = time.perf_counter(), time.process_time()
        session.propose(wanted)
        desk.state(trial)
        took.append(time.perf_counter() - start)
        worked.append(time.process_time() - begun)
        changed.append(len((session.told() or {"others": ()})["others"]))
        if session.proposal is None:
            session.undo()
        session.refuse()
    print(f"the first correction, with what has to be compiled or read for it: {took[0]:.2f} s")
    for what, times in (("by the clock", took), ("of processor time", worked)):
        rest = np.array(times[1:])
        print(f"{count} corrections, {what}: median {np.median(rest):.2f} s, worst {rest.max():.2f} s")
    print(f"labels that each changes besides: {changed[1:]}")


if __name__ == "__main__":
    main()
