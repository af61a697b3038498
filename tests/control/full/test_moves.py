"""Moves: which changes of several labels at once are tried."""

from dataclasses import replace

import numpy as np
import pytest
from takes import model

from dshpm_jax import Settings
from dshpm_jax._control.full.assignment import assign_labels
from dshpm_jax._control.full.neighbourhoods.ejection_chains import propose_takes
from dshpm_jax._control.full.neighbourhoods.exchanges import propose_moves
from dshpm_jax._control.full.objective import Solution
from dshpm_jax._control.problem import LabellingProblem
from dshpm_jax._control.tuning import TUNING
from dshpm_jax._trajectories import from_columns
from dshpm_jax._types import NO_MATCH


def test_a_take_is_passed_on_along_a_limb():
    """A real point that is no marker holds the last label of a limb, and all others are shifted by one."""
    problem = LabellingProblem(from_columns(np.zeros((10, 4, 3)), 100.0), model(), Settings())
    a, b, c = 5, 6, 7
    llr = np.full((4, problem.model.num_markers), -12.0)
    llr[0, a] = 9.0
    llr[1, [a, b]] = 7.0, 2.0
    llr[2, [b, c]] = 7.0, 3.0
    llr[3, c] = 5.0
    solution = Solution(np.array([NO_MATCH, a, b, c]), llr, 0.0, None)  # type: ignore[arg-type]
    moves = propose_moves(problem, solution)
    proposed = [dict(zip(move.trajectories.tolist(), move.labels.tolist())) for move in moves]
    assert {0: a, 1: b, 2: c, 3: NO_MATCH} in proposed
    assert {0: a, 1: b, 2: NO_MATCH} in proposed


def takes_one_by_one(t, identity, llr):
    """Every take, followed as a person would: the trajectories and labels of each, and what it promises."""

    def beside(label, others):
        meet = [any(t.start[k] < t.stop[o] and t.start[o] < t.stop[k] for o in others) for k in range(len(t))]
        return np.flatnonzero((identity == label) & meet)

    def best_free(k, but):
        scores = llr[k].copy()
        scores[[label for label in range(len(scores)) if set(beside(label, [k])) - {k}]] = -np.inf
        scores[but] = -np.inf
        return int(scores.argmax()) if scores.max() > TUNING.min_take_llr else NO_MATCH

    found = []
    for j in np.flatnonzero(identity == NO_MATCH):
        for label in np.argsort(-llr[j], kind="stable")[: TUNING.labels_tried]:
            if llr[j, label] <= TUNING.min_take_llr:
                break
            displaced, gained, moved = beside(label, [j]), llr[j, label], {j: label}
            promise = gained - llr[displaced, label].sum()
            found.append((promise, moved | dict.fromkeys(displaced, NO_MATCH)))
            if len(displaced):
                found.append((promise, moved | {k: best_free(k, label) for k in displaced}))
            while len(displaced) and len(set(moved.values())) <= TUNING.max_chain_length:
                scores = llr[displaced].mean(0)
                scores[list(moved.values())] = -np.inf
                if scores.max() <= TUNING.min_take_llr:
                    break
                label = int(scores.argmax())
                gained += (llr[displaced, label] - llr[displaced, identity[displaced]]).sum()
                moved |= dict.fromkeys(displaced, label)
                displaced = beside(label, displaced)
                lost = llr[displaced, label].sum()
                found.append((gained - lost, moved | dict.fromkeys(displaced, NO_MATCH)))
    return found


@pytest.mark.parametrize("seed", range(6))
def test_takes_side_by_side_are_those_one_by_one(seed):
    rng = np.random.default_rng(seed)
    points = np.where(rng.random((60, 12, 1)) < 0.05, np.nan, np.zeros((60, 12, 3)))
    t = from_columns(points, 100.0)
    llr = rng.uniform(-14, 12, (len(t), 8))
    identity = assign_labels(rng.uniform(-5, 5, (len(t), 8)), t.start, t.stop)
    expected = sorted(takes_one_by_one(t, identity, llr), key=lambda take: -take[0])
    found = {
        tuple(sorted(zip(m.trajectories.tolist(), m.labels.tolist()))): m.promise
        for m in propose_takes(t, identity, llr, replace(TUNING, max_moves=50))
    }
    assert len(expected) > 100
    for promise, labels in expected[:50]:
        assert found[tuple(sorted((int(k), int(v)) for k, v in labels.items()))] == pytest.approx(promise)
