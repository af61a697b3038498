"""One frame of a recording whose points a person names by their numbers."""

from collections.abc import Mapping

from dshpm_jax._recording import Recording, is_unlabelled


def one_frame(recording: Recording, frame: int) -> Recording:
    """That frame alone; `ValueError` if the recording does not have it."""
    if not 0 <= frame < recording.num_frames:
        raise ValueError(f"got frame {frame}: the recording has frames 0 to {recording.num_frames - 1}")
    return recording.frames(frame, frame + 1)


def named_frame(recording: Recording, frame: int, names: Mapping[int, str]) -> Recording:
    """That frame alone with the named points alone; a point's number is its column.

    Raises:
        ValueError: there is no such frame or point, or a name is given twice, or would count as none.
    """
    still = one_frame(recording, frame)
    seen = still.present[0]
    if unseen := sorted(k for k in names if not (0 <= k < len(seen) and seen[k])):
        raise ValueError(f"frame {frame} does not show the points {unseen}; it shows {seen.nonzero()[0].tolist()}")
    given = list(names.values())
    if twice := sorted({name for name in given if given.count(name) > 1}):
        raise ValueError(f"several points are called {', '.join(twice)}; a marker is one point")
    if empty := sorted(k for k, name in names.items() if is_unlabelled(name)):
        raise ValueError(f"the points {empty} have names that capture systems give to unnamed points; choose others")
    return Recording(still.points[:, list(names)], tuple(given), recording.rate, recording.unit, recording.source)
