"""Results with labels that are wrong where a test knows it, as if a run had made them."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import cache
from pathlib import Path

import numpy as np

from dshpm_jax import Labelling, Reason, Recording, Settings, SubjectModel, io
from dshpm_jax._archive import Job, Outcome
from dshpm_jax._archive.hashes import INPUT, MODEL, SETTINGS, hash_file, hash_settings, read_models
from dshpm_jax._archive.manifest import Manifest
from dshpm_jax._archive.outcomes import figures_of
from dshpm_jax._archive.results import write_result
from dshpm_jax._trajectories import from_columns
from dshpm_jax._types import NO_MATCH
from dshpm_jax.report._run_page import write_run_page
from dshpm_jax.synthesis import add_ghosts, person

LEFT_ARM, RIGHT_ARM = ("LELB", "LWRA", "LWRB", "LFIN"), ("RELB", "RWRA", "RWRB", "RFIN")
ARMS_EXCHANGED = dict(zip((*LEFT_ARM, *RIGHT_ARM), (*RIGHT_ARM, *LEFT_ARM), strict=True))


@cache
def model() -> SubjectModel:
    return SubjectModel.from_recordings([person(34, frames=240, seed=1).recording])


@cache
def take(frames: int = 120, ghosts: float = 0.02) -> tuple[Recording, tuple[str, ...]]:
    """A walk without names, and the name of each of its columns."""
    recording = person(34, "walking", frames, 60.0, 1, 7).recording
    recording = add_ghosts(recording, ghosts, np.random.default_rng(3))
    names = tuple(label if label in model().markers else "" for label in recording.labels)
    points = recording.points.astype(np.float32).astype(float)
    return Recording(points, ("",) * len(names), recording.rate), names


def labelling_as(recording: Recording, names: Sequence[str], doubtful: Sequence[str] = ()) -> Labelling:
    """Each column is called what `names` say; labels among `doubtful` are .8 sure."""
    tracks = from_columns(recording.points, recording.rate)
    column = tracks.column[tracks.start, tracks.slot]
    said = [names[c] for c in column]
    identity = np.array([model().markers.index(n) if n in model().markers else NO_MATCH for n in said], np.int32)
    sure = np.where([name in doubtful for name in said], 0.8, 0.999)
    reason = tuple(Reason.OUTSIDE if k == NO_MATCH else Reason.MATCHED for k in identity)
    return Labelling(recording, model(), tracks, identity, sure, reason, {"svd_count": 1, "model_fit": 1.0})


def write_wrong(folder: Path, wrong: Mapping[str, str], name: str = "walk", frames: int = 120) -> Path:
    """A folder of results in `folder/labelled` whose one result has labels exchanged as `wrong` says; gives it."""
    recording, names = take(frames)
    source, out = folder / "captures" / f"{name}.c3d", folder / "labelled"
    source.parent.mkdir(exist_ok=True, parents=True)
    out.mkdir(exist_ok=True)
    io.write_c3d(recording, source)
    path = folder / "captures" / "model.json"
    if not path.exists():
        io.write_model(model(), path)
    labelling = labelling_as(io.read(source), [wrong.get(n, n) for n in names], list(wrong))
    settings = Settings()
    hashes = {INPUT: hash_file(source), SETTINGS: hash_settings(settings), MODEL: read_models((path,))[1]}
    job, figures = Job(source, Path(f"{name}.c3d"), (path,), page=True), figures_of(labelling)
    write_result(labelling, job, out, hashes, {"settings": asdict(settings), "figures": figures})
    manifest = Manifest(out)
    manifest.add(Outcome(job, "labelled", "", hashes, figures, seconds=0.1))
    manifest.close()
    write_run_page(out, list(manifest.rows.values()))
    return out
