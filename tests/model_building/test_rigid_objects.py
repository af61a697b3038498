"""Things that are rigid as a whole: one segment; in a line; and such as look the same from several sides."""

import numpy as np
import pytest

from dshpm_jax import Recording, SubjectModel, label
from dshpm_jax.synthesis._curves import rotations

CORNERS = np.array([[0.0, 0.0, 0.0], [180.0, 0.0, 0.0], [60.0, 240.0, 0.0], [0.0, 90.0, 130.0]])
SQUARE = np.array([[0.0, 0.0, 0.0], [150.0, 0.0, 0.0], [150.0, 150.0, 0.0], [0.0, 150.0, 0.0]])
STICK = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 200.0], [0.0, 0.0, 500.0]])


def carried(body: np.ndarray, seed: int = 0, turn: float = 2.0) -> Recording:
    """A thing that is carried through the room and turned by so much (radians)."""
    rng = np.random.default_rng(seed)
    time = np.linspace(0.0, 1.0, 200)
    rotation = rotations(np.degrees(turn) * np.sin(2 * np.pi * time[:, None] + rng.uniform(0, 6, 3)))
    place = rng.uniform(-500, 500, 3) + 400.0 * np.sin(2 * np.pi * time[:, None] + rng.uniform(0, 6, 3))
    points = np.einsum("fij,mj->fmi", rotation, body) + place[:, None] + rng.normal(0, 0.3, (200, len(body), 3))
    return Recording(points, tuple(f"point{k}" for k in range(len(body))), 100.0)


def labels_of(model: SubjectModel, recording: Recording) -> list[str | None]:
    found = label(recording, model)
    return [model.markers[k] if k >= 0 else None for k in found.identities[100]]


def test_an_object_that_is_turned_is_one_segment():
    model = SubjectModel.from_recordings([carried(CORNERS)])
    assert [segment.name for segment in model.segments] == ["object"] and len(model.segments[0].markers) == 4
    assert labels_of(model, carried(CORNERS, seed=1)) == ["point0", "point1", "point2", "point3"]


def test_what_stands_still_with_names_nobody_knows_has_no_segments():
    with pytest.raises(ValueError, match="too little motion"):
        SubjectModel.from_recordings([carried(CORNERS, turn=0.05)])


def test_three_in_a_line_are_told_by_their_distances():
    segments = {"stick": {"markers": ["point0", "point1", "point2"], "parent": None}}
    model = SubjectModel.from_recordings([carried(STICK)], segments)
    assert labels_of(model, carried(STICK, seed=1)) == ["point0", "point1", "point2"]


def test_a_square_looks_the_same_from_eight_sides_so_nothing_is_sure():
    segments = {"square": {"markers": [f"point{k}" for k in range(4)], "parent": None}}
    model = SubjectModel.from_recordings([carried(SQUARE)], segments)
    found = label(carried(SQUARE, seed=1), model)
    assert (found.identity < 0).all() and (found.confidence > 0.5).all()
