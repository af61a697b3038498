"""How many key-frames are asked."""

import numpy as np
import pytest
from takes import model

from dshpm_jax import Settings
from dshpm_jax._control.full.key_frames import usual_number
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._trajectories import from_columns


@pytest.mark.parametrize(("seconds", "wanted"), [(1, 10), (200, 10), (201, 11), (3600, 180)])
def test_long_recordings_have_more_key_frames(seconds, wanted):
    tracks = from_columns(np.zeros((seconds * 2, 1, 3)), 2.0)
    assert usual_number(LabellingProblem(tracks, model(), Settings())) == wanted
