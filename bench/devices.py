"""How much faster is an archive on a GPU than on the CPU, and are its labels the same?

    python bench/devices.py [--quick]

The same recordings, worn walks of 600 frames in 49 markers, labelled in turns on both. Where JAX finds no GPU, one
line says so.
"""

from collections.abc import Iterator

import jax
import numpy as np
from _rows import Row, run
from _timing import paired, warm_seconds
from scaling import more_recordings

from dshpm_jax import Labelling, label_many


def rows(quick: bool) -> Iterator[Row]:
    if jax.default_backend() == "cpu":
        print("no GPU is here: nothing to compare")
        return
    count = 10 if quick else 1000
    recordings, model = more_recordings(count)

    def on(kind: str) -> list[Labelling]:
        with jax.default_device(jax.devices(kind)[0]):
            return list(label_many(recordings, model))

    kinds = (jax.default_backend(), "cpu")
    for kind in kinds:
        warm_seconds(lambda: on(kind), 1)
    (gpu, _), (_, ratio) = paired([lambda: on(kinds[0]), lambda: on("cpu")], 1 if quick else 3)
    frames = sum(recording.num_frames for recording in recordings)
    same = [np.array_equal(a.identity, b.identity) for a, b in zip(on(kinds[0]), on("cpu"))]
    yield Row(f"{count} recordings", "CPU / GPU", ratio, at_least=20.0)
    yield Row(f"{count} recordings", "GPU (frames/s)", frames / gpu)
    yield Row(f"{count} recordings", "recordings labelled the same (%)", 100 * float(np.mean(same)))


if __name__ == "__main__":
    run(__doc__, rows)
