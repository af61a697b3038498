"""A recording as a table of pandas."""

from typing import Any

import numpy as np

from dshpm_jax._bridges.optional import distinct, optional
from dshpm_jax._recording import Recording

AXES = ("x", "y", "z")


def dataframe(recording: Recording) -> Any:
    """What `Recording.to_dataframe` returns."""
    pandas = optional("pandas", "to_dataframe", "'dshpm-jax[pandas]'")
    names = ["marker", "axis"]
    columns = pandas.MultiIndex.from_product([distinct(recording.labels), AXES], names=names)
    seconds = pandas.Index(np.arange(recording.num_frames) / recording.rate, name="seconds")
    flat = recording.points.reshape(recording.num_frames, -1)
    return pandas.DataFrame(flat, index=seconds, columns=columns, copy=True)
