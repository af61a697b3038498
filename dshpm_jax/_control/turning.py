"""Whole chains of labels exchanged with their counterparts, where they carry each other's."""

import numpy as np

from dshpm_jax._control.moves import Move
from dshpm_jax._control.scene import Scene
from dshpm_jax._control.settling import State, make_moves
from dshpm_jax._requests import Control
from dshpm_jax._types import NO_MATCH


def turn(scene: Scene, state: State, frames: np.ndarray) -> Control:
    """Exchanges chains where that pays."""
    moves = []
    for to in scene.body.turns:
        changed = np.flatnonzero((state.identity != NO_MATCH) & (to[state.identity] != state.identity))
        if len(changed):
            moves.append(Move(changed, to[state.identity[changed]], 0.0))
    following = yield from make_moves(scene, state, moves, frames)
    return following if following.worth > state.worth else state
