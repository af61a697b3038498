"""Moves: which changes of several labels at once are tried."""

import numpy as np
from takes import model

from dshpm_jax import Settings
from dshpm_jax._control.moves import propose_moves
from dshpm_jax._control.scene import Scene
from dshpm_jax._trajectories import from_columns
from dshpm_jax._types import NO_MATCH


def test_a_take_is_passed_on_along_a_limb():
    """A real point that is no marker holds the last label of a limb, and all others are shifted by one."""
    scene = Scene(from_columns(np.zeros((10, 4, 3)), 100.0), model(), Settings())
    a, b, c = 5, 6, 7
    evidence = np.full((4, scene.model.num_markers), -12.0)
    evidence[0, a] = 9.0
    evidence[1, [a, b]] = 7.0, 2.0
    evidence[2, [b, c]] = 7.0, 3.0
    evidence[3, c] = 5.0
    moves = propose_moves(scene, np.array([NO_MATCH, a, b, c]), evidence)
    proposed = [dict(zip(move.trajectories.tolist(), move.labels.tolist())) for move in moves]
    assert {0: a, 1: b, 2: c, 3: NO_MATCH} in proposed
    assert {0: a, 1: b, 2: NO_MATCH} in proposed
