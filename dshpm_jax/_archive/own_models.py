"""The own model of a subject of whom nothing is labelled: found once from the recordings of a folder, then used again.

All recordings of a folder tell about one subject's sizes. Whoever needs the model first makes it, always of the same
recordings, so that neither batches nor workers decide what comes out. It lies beside the results.
"""

from collections.abc import Iterable, Sequence
from importlib.metadata import version
from pathlib import Path

from dshpm_jax import io
from dshpm_jax._archive.jobs import MODEL_NAME, Job
from dshpm_jax._compile_cache import cache_programs
from dshpm_jax._given import recording_of
from dshpm_jax._marker_set import MarkerSet, Member
from dshpm_jax._model import SubjectModel
from dshpm_jax._recording import Recording
from dshpm_jax._settings import Settings

SET = "marker_set"
"""The entry of `io.made_from` that holds the hash of the set."""


def member_of(job: Job, markers: MarkerSet, set_hash: str, out: Path, settings: Settings) -> Member:
    """The subject of a job: the model that lies beside its result, found now if it is not there.

    Raises:
        ReadError: what is there is somebody else's.
        OSError: the model cannot be written.
    """
    place = out / job.target.with_name(MODEL_NAME)
    if (found := own_model_of(job, set_hash, out)) is not None:
        return Member(markers, found)
    if place.exists() and io.made_from(place) is None:
        raise io.ReadError(place, "is there and none that 'label' wrote", "move it away, or label without a set")
    model = _found(job.beside, markers, settings)
    place.parent.mkdir(parents=True, exist_ok=True)
    about = {"by": f"dshpm-jax {version('dshpm-jax')}", SET: set_hash, "subjects": markers.subjects}
    io.write_model(model, place, about | {"recordings": model.sources})
    return Member(markers, io.read_model(place))  # as it is read the next time, rounded


def own_model_of(job: Job, set_hash: str, out: Path) -> SubjectModel | None:
    """The model that lies beside the result of a job, if it was found by the set of this hash."""
    place = out / job.target.with_name(MODEL_NAME)
    made = io.made_from(place)
    return io.read_model(place) if made is not None and made.get(SET) == set_hash else None


def forget_own_models(jobs: Iterable[Job], out: Path) -> None:
    """Removes the models that `member_of` wrote for these jobs, so that they are found anew."""
    for place in {out / job.target.with_name(MODEL_NAME) for job in jobs if job.beside}:
        if place.exists() and io.made_from(place) is not None:
            place.unlink(missing_ok=True)


def _found(sources: Sequence[Path], markers: MarkerSet, settings: Settings) -> SubjectModel:
    cache_programs()
    from dshpm_jax._unseen import find_subject  # jax is slow to start, and not needed before

    return find_subject(list(_readable(sources, markers, settings)), markers, settings)


def _readable(sources: Sequence[Path], markers: MarkerSet, settings: Settings) -> Iterable[Recording]:
    """The recordings that can be read; what is wrong with the others is said where they are labelled."""
    for source in sources:
        try:
            yield recording_of(source, markers, settings)
        except ValueError:
            continue
