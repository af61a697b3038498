"""Hashes that tell whether a result still belongs to its input, model and settings."""

import dataclasses
import hashlib
import json
from functools import lru_cache
from pathlib import Path

from dshpm_jax import io
from dshpm_jax._archive.jobs import subjects
from dshpm_jax._marker_set import MarkerSet
from dshpm_jax._model import SubjectModel
from dshpm_jax._settings import Settings
from dshpm_jax._subjects import side_by_side
from dshpm_jax.io._form import AS_IT_IS, Form

NEWER = {"keep_labels": False, "keep_frames": None}
"""Settings that came later, and what they are where nothing is said: results from before stay up to date."""

INPUT, MODEL, SETTINGS, FORM = "sha256", "model", "settings", "form"  # names of the hashes in manifests and sidecars


def hash_file(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def hash_settings(settings: Settings) -> str:
    """Of all that can change a label; how complete a file has to be is no such thing."""
    found = dataclasses.asdict(settings)
    del found["completeness"]
    found = {name: value for name, value in found.items() if name not in NEWER or value != NEWER[name]}
    return _hash(found)


def hash_form(form: Form) -> dict[str, str]:
    """The hash of what was asked of the axes, the unit and the names of a result, if anything was."""
    return {} if form == AS_IT_IS else {FORM: _hash(dataclasses.asdict(form))}


def read_models(paths: tuple[Path, ...]) -> tuple[SubjectModel | MarkerSet, str]:
    """The model of the subjects of `paths`, or a marker set, and a hash that tells it from others."""
    hashes = tuple(hash_file(path) for path in paths)
    model = _read_models(paths, hashes)
    return model, hashes[0] if len(paths) == 1 else _hash([subjects(paths), hashes])


@lru_cache(maxsize=8)
def _read_models(paths: tuple[Path, ...], hashes: tuple[str, ...]) -> SubjectModel | MarkerSet:
    """Read once for all batches of a process, as long as the files have these hashes; subject files take seconds."""
    if len(paths) == 1:
        return io.read_model_or_set(paths[0])
    return side_by_side(dict(zip(subjects(paths), [io.read_model(path) for path in paths])))


def _hash(value: object) -> str:
    return hashlib.sha256(json.dumps(value).encode()).hexdigest()
