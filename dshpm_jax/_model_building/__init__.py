"""Models from labelled recordings: pair statistics, segments from motion, names or a file, shapes and joints."""

from dshpm_jax._model_building.expectation import expected_spread as expected_spread
from dshpm_jax._model_building.gather import gather as gather
from dshpm_jax._model_building.neighbours import MAX_NEIGHBOURS as MAX_NEIGHBOURS
from dshpm_jax._model_building.neighbours import Neighbourhood as Neighbourhood
from dshpm_jax._model_building.neighbours import as_arrays as as_arrays
from dshpm_jax._model_building.neighbours import build_neighbourhoods as build_neighbourhoods
from dshpm_jax._model_building.segments import build_segments as build_segments
from dshpm_jax._model_building.segments import segment_entries as segment_entries
from dshpm_jax._model_building.skeleton import POSED_SECONDS as POSED_SECONDS
from dshpm_jax._model_building.skeleton import Skeleton as Skeleton
from dshpm_jax._model_building.skeleton import bone_groups as bone_groups
from dshpm_jax._model_building.skeleton import posed_clip as posed_clip
from dshpm_jax._model_building.statistics import pair_statistics as pair_statistics
from dshpm_jax._model_building.still import named_frame as named_frame
from dshpm_jax._model_building.still import one_frame as one_frame
