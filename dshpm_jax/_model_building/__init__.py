"""Models from labelled recordings: pair statistics, segments from motion, names or a file, shapes and joints."""

from dshpm_jax._model_building.gather import gather as gather
from dshpm_jax._model_building.segments import build_segments as build_segments
from dshpm_jax._model_building.statistics import pair_statistics as pair_statistics
