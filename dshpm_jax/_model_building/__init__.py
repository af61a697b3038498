"""Makes models from labelled recordings: pair statistics, segments from motion, names or a file, shapes and joints."""

from dshpm_jax._model_building.gather import gather as gather
from dshpm_jax._model_building.make import model_from_recordings as model_from_recordings
from dshpm_jax._model_building.make import model_from_skeleton as model_from_skeleton
from dshpm_jax._model_building.segments import segment_entries as segment_entries
from dshpm_jax._model_building.skeleton import Skeleton as Skeleton
from dshpm_jax._model_building.skeleton import posed_clip as posed_clip
from dshpm_jax._model_building.statistics import liveliness as liveliness
from dshpm_jax._model_building.still import named_frame as named_frame
from dshpm_jax._model_building.still import one_frame as one_frame
from dshpm_jax._model_building.tuning import TUNING as TUNING
from dshpm_jax._model_building.tuning import ModelTuning as ModelTuning
