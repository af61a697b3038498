"""How long until the first label of a fresh process, and does a second recording compile anything?

    python bench/startup.py [--quick]

`dshpm-jax label` with one worn recording of 600 frames in 49 markers, in a process of its own: the whole command,
results and report included, with an empty folder for compiled programs and then with the one that it filled. In this
process, the programs that a second recording of the same kind compiles are counted.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from _rows import Row, run
from _timing import compiling
from scaling import MARKERS, model_of, walk

from dshpm_jax import label, write_c3d, write_model
from dshpm_jax._compile_cache import cache_programs

CASE = "one recording of 600 frames"


def rows(quick: bool) -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_c3d(walk(), folder / "walk.c3d")
        write_model(model_of(MARKERS), folder / "model.json")
        cold = command(folder, "cold")
        cached = np.median([command(folder, f"cached{k}") for k in range(1 if quick else 5)], axis=0)
        for name, (spent, busy), aim in (("cold", cold, 15.0), ("programs cached", cached, 4.0)):
            yield Row(CASE, f"a fresh process, {name} (s)", float(spent), at_most=aim)
            yield Row(CASE, f"its processor time, {name} (s)", float(busy))
        os.environ["DSHPM_CACHE"] = str(folder / "cache")
        cache_programs()
        with compiling() as programs:
            label(walk(), model_of(MARKERS))
        yield Row(CASE, "programs", len(programs))
        with compiling() as programs:
            label(walk(seed=1), model_of(MARKERS))
        yield Row("a second recording like it", "programs compiled", len(programs), at_most=0)


def command(folder: Path, out: str) -> tuple[float, float]:
    """Seconds that one run takes, and those of the processor: on busy cores the first are far more."""
    arguments = ["label", str(folder / "walk.c3d"), "--model", str(folder / "model.json"), "-o", str(folder / out)]
    environment = os.environ | {"DSHPM_CACHE": str(folder / "cache")}
    whole = [sys.executable, "-m", "dshpm_jax", *arguments]
    before = os.times()
    subprocess.run(whole, env=environment, check=True, stdout=subprocess.DEVNULL)
    after = os.times()
    busy = after.children_user - before.children_user + after.children_system - before.children_system
    return after.elapsed - before.elapsed, busy


if __name__ == "__main__":
    run(__doc__, rows)
