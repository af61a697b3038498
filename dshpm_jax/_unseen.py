"""`find_subject`: the model of a subject of whom nothing is labelled, from recordings that all show them."""

from collections.abc import Iterable
from pathlib import Path

from dshpm_jax import io
from dshpm_jax._control.methods import check_for_sets
from dshpm_jax._control.tuning import TUNING
from dshpm_jax._control.unseen.label import find_own_model
from dshpm_jax._driver import Driver
from dshpm_jax._given import GivenRecording, one_or_more, recording_of
from dshpm_jax._marker_set import MarkerSet
from dshpm_jax._model import SubjectModel
from dshpm_jax._pretracking import pretrack
from dshpm_jax._settings import Settings


def find_subject(
    recordings: GivenRecording | Iterable[GivenRecording],
    markers: MarkerSet | str | Path,
    settings: Settings | None = None,
    driver: Driver | None = None,
) -> SubjectModel:
    """The model of a subject of whom nothing is labelled.

    Arguments:
        recordings: unlabelled ones, all of this subject; each tells about sizes and proportions. Their order does not
            matter.
        markers: what subjects who wear the same markers have in common, or its file.
        settings, driver: as for `label`.

    Raises:
        ReadError: a file cannot be read.
        ValueError: no recording has points, or the settings ask for another method.
    """
    settings = Settings() if settings is None else settings
    check_for_sets(settings)
    known = markers if isinstance(markers, MarkerSet) else io.read_marker_set(markers)
    read = [recording_of(one, known, settings) for one in one_or_more(recordings)]
    tracked = [found for found in map(pretrack, read) if len(found)]
    if not tracked:
        raise ValueError("no point is seen in any frame of the recordings; there is nothing to find a subject by")
    names = sorted(recording.source.name for recording in read if recording.source)
    control = find_own_model(tracked, known, settings, TUNING, tuple(names))
    return next((Driver() if driver is None else driver).run([control]))
