"""How large is the page of a recording, how long does it take to make and to load, and does it play?

    python bench/pages.py [LABELLED.c3d] [--frames 600,3000,10000]

A labelled recording (by default a person of 49 markers made on the spot, with gaps and ghosts) is cut or repeated to
each length. Loading is the time from the start of the page until its script has run and the first frame is drawn, in
headless Chromium if there is one; a redraw is the mean of a hundred frames of the figure. On two busy CPU cores,
without a graphics card; the second is a real recording of 52 markers, a tenth of its points missing and a tenth false:

    made on the spot
       600 frames  238 columns    0.32 MB  made in  0.31 s  loaded in 0.25 s  redraw 1.84 ms
      3000 frames  238 columns    1.51 MB  made in  1.13 s  loaded in 0.83 s  redraw 1.98 ms
     10000 frames  238 columns    4.98 MB  made in  4.26 s  loaded in 1.48 s  redraw 6.34 ms
    nick_freeform_001.worn.c3d
       600 frames  120 columns    0.34 MB  made in  0.32 s  loaded in 0.45 s  redraw 2.55 ms
      3000 frames  120 columns    1.63 MB  made in  0.82 s  loaded in 0.61 s  redraw 1.38 ms
     10000 frames  120 columns    5.38 MB  made in  1.80 s  loaded in 0.73 s  redraw 6.11 ms
"""

import argparse
import re
import shutil
import subprocess
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from dshpm_jax import Recording, io
from dshpm_jax.report._film import make_film
from dshpm_jax.report._page import make_page
from dshpm_jax.report._player import player_data
from dshpm_jax.synthesis import add_ghosts, open_gaps, person

PROBE = """<script>
draw();
const loaded = performance.now();
for (let k = 0; k < 100; k++) { show(k * frames / 100); draw(); }
document.title = `loaded ${loaded.toFixed(0)} redraw ${((performance.now() - loaded) / 100).toFixed(2)}`;
</script>"""


def repeated(recording: Recording, sidecar: dict | None, frames: int) -> tuple[Recording, dict | None]:
    """The recording cut or repeated to `frames`, and its sidecar with it."""
    length = recording.num_frames
    points = np.concatenate([recording.points] * -(-frames // length))[:frames]
    if sidecar is not None:
        rows = [
            row | {"frames": [row["frames"][0] + start, min(row["frames"][1] + start, frames - 1)], "columns": None}
            for start in range(0, frames, length)
            for row in sidecar["trajectories"]
            if row["frames"][0] + start < frames
        ]
        sidecar = sidecar | {"frames": frames, "trajectories": rows}
    return replace(recording, points=points, source=None), sidecar


def measure(recording: Recording, sidecar: dict | None, frames: int, browser: str | None) -> None:
    recording, sidecar = repeated(recording, sidecar, frames)
    start = time.perf_counter()
    page = make_page("player", "bench", player_data(make_film(recording, sidecar), "bench"))
    made = time.perf_counter() - start
    shown = f"  {in_browser(page, browser)}" if browser else ""
    columns = recording.points.shape[1]
    print(f"{frames:6} frames {columns:4} columns  {len(page) / 1e6:6.2f} MB  made in {made:5.2f} s{shown}", flush=True)


def in_browser(page: str, browser: str) -> str:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "page.html"
        path.write_text(page.replace("</body>", PROBE + "</body>"))
        command = [browser, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder}/profile"]
        command += ["--window-size=1280,800", "--dump-dom", path.as_uri()]
        dom = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True).stdout
    found = re.search(r"loaded (\d+) redraw ([\d.]+)", dom)
    return f"loaded in {int(found[1]) / 1000:.2f} s  redraw {found[2]} ms" if found else "did not run"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", nargs="?", type=Path)
    parser.add_argument("--frames", default="600,3000,10000")
    arguments = parser.parse_args()
    if arguments.recording:
        recording, sidecar = io.read(arguments.recording), io.read_sidecar(io.sidecar_path(arguments.recording))
    else:
        rng = np.random.default_rng(0)
        made = person(49, "freeform", 1200, seed=0).recording
        recording, sidecar = add_ghosts(open_gaps(made, 0.1, rng), 0.1, rng), None
    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    for frames in map(int, arguments.frames.split(",")):
        measure(recording, sidecar, frames, browser)


if __name__ == "__main__":
    main()
