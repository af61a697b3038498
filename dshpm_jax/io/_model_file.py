"""Subject models as JSON that people can read, compare and correct."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from dshpm_jax._hierarchy import depth_first
from dshpm_jax._model import MAX_NEIGHBOURS, Segment, SubjectModel
from dshpm_jax._types import NO_PARENT
from dshpm_jax.io._atomic import write_whole
from dshpm_jax.io._errors import ReadError
from dshpm_jax.io._fields import DECIMALS, decode, encode
from dshpm_jax.io._units import FARTHEST_MM

if TYPE_CHECKING:
    from dshpm_jax._model_building import Skeleton

FORMAT, VERSION = "dshpm-model", 2
"""Of what is written. Version 1 is read too (`_from_version_1`); a program that knows only version 1 refuses version 2
and says that the model is to be made again."""

SET_KIND = "marker set"
"""The entry `kind` of the file of a marker set (`_set_file`); a subject's model has none."""

MADE = "made"
"""The entry that says from what a model was found that nobody labelled; it is no part of the model."""

DROPPED = ("pair_low", "pair_high", "pair_frames")
"""Tables of version 1 that nothing read."""

RENAMED = {"softness": "distance_sd", "spread": "marker_sd"}
"""Entries of a neighbourhood in version 1, and what they are called now."""

SUBJECT_FILES = (".vsk", ".osim")
"""Endings of files in which other programs keep a subject."""

LEAST = 10.0**-DECIMALS
"""What must not be 0 is not written smaller either."""

MOST_DISTORTED = 10.0
"""A distance that changes by ten times itself is none that tells anything."""

_REMEDY = "make it again with 'dshpm-jax model' or correct that entry"
_LABEL_FIRST = "label a recording with it: 'dshpm-jax label' keeps the subject's own model beside the results"


def write_model(model: SubjectModel, path: str | Path, made: Mapping[str, Any] | None = None) -> None:
    """Writes a model as JSON, whole or not at all: a line for each row of a table, lengths rounded to 1e-4 mm.

    What is at `path` is replaced, whatever it is; the folder must be there.

    Arguments:
        made: by what and from what the model was made, for who wonders (`made_from` reads it).
    """
    head = {"format": FORMAT, "version": VERSION} | ({MADE: dict(made)} if made else {})
    write_whole(Path(path), [(layout(head | encode(model)) + "\n").encode(errors="backslashreplace")])


def read_model(path: str | Path, markers: str | Path | None = None) -> SubjectModel:
    """Reads a model, or makes one of a subject file (`SUBJECT_FILES`).

    Arguments:
        markers: a file of markers beside a subject file, which has none or others (OpenSim's MarkerSet .xml).

    Raises:
        ReadError: the file cannot be read or is no model; it names the entry that is wrong.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if markers is not None and suffix != ".osim":
        raise ReadError(path, "a file of markers goes with an .osim file alone", "leave it out")
    if suffix in SUBJECT_FILES:
        return _from_subject_file(path, None if markers is None else Path(markers))
    found = read_entries(path)
    if found.get("kind") == SET_KIND:
        raise ReadError(path, "is a marker set, the model of nobody in particular", _LABEL_FIRST)
    if (version := found.pop("version", None)) not in (1, VERSION):
        raise ReadError(path, f"has version {version}, this program knows 1 and {VERSION}", "make it again")
    found.pop(MADE, None)
    if version == 1:
        _from_version_1(found)
    try:
        model = decode(SubjectModel, found, "the model", {})
        check_model(model)
    except ValueError as error:
        raise ReadError(path, str(error), _REMEDY) from None
    return model


def made_from(path: str | Path) -> dict[str, Any] | None:
    """By what and from what a model was made, where its file says so; None for other files."""
    try:
        found = read_entries(Path(path)).get(MADE)
    except (ReadError, OSError):
        return None
    return found if isinstance(found, dict) else None


def read_entries(path: Path) -> dict[str, Any]:
    """What the file of a model holds, besides its format; `ReadError` if it is none."""
    try:
        found = json.loads(path.read_bytes())
    except OSError as error:
        raise ReadError(path, f"cannot be read ({error.strerror})", "check the path") from None
    except (ValueError, RecursionError) as error:  # brackets within brackets, thousands deep
        what = "the file is empty" if not path.stat().st_size else f"is no JSON ({error})"
        raise ReadError(path, what, "make it again with 'dshpm-jax model'") from None
    if not isinstance(found, dict) or found.pop("format", None) != FORMAT:
        raise ReadError(path, "this is no marker model", "make one with 'dshpm-jax model'")
    return found


def _from_version_1(found: dict[str, Any]) -> None:
    """Brings the entries of a file of version 1 into those of today; what is damaged stays so, to be told."""
    for name in DROPPED:
        found.pop(name, None)
    whole = found.get("neighbourhoods")
    for near in whole if isinstance(whole, list) else []:
        if isinstance(near, dict):
            for old, new in RENAMED.items():
                if old in near:
                    near[new] = near.pop(old)


def _read_skeleton(path: Path, markers: Path | None) -> "Skeleton":
    """The skeleton of a subject file. Its readers import scipy, which other files need not wait for."""
    if path.suffix.lower() == ".vsk":
        from dshpm_jax.io._vsk import read_vsk

        return read_vsk(path)
    from dshpm_jax.io._osim import read_osim

    return read_osim(path, markers)


def _from_subject_file(path: Path, markers: Path | None) -> SubjectModel:
    skeleton = _read_skeleton(path, markers)
    try:
        return SubjectModel.from_skeleton(skeleton, path.name)
    except ValueError as error:
        raise ReadError(path, f"no model can be made of it ({error})", "make one from a labelled recording") from None


def is_model(path: str | Path) -> bool:
    """Whether a file says that it is a model, sound or not."""
    try:
        found = json.loads(Path(path).read_bytes())
    except (OSError, ValueError, RecursionError):
        return False
    return isinstance(found, dict) and found.get("format") == FORMAT


def layout(value: Any, indent: int = 0) -> str:
    """JSON with a line for each entry, but the innermost lists and objects in one line."""
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    if not any(isinstance(item, dict | list) for item in inner):
        return json.dumps(value, ensure_ascii=False)
    pad = " " * (indent + 1)
    if isinstance(value, dict):
        rows = [f"{pad}{json.dumps(key)}: {layout(item, indent + 1)}" for key, item in value.items()]
    else:
        rows = [pad + layout(item, indent + 1) for item in value]
    opening, closing = "{}" if isinstance(value, dict) else "[]"
    return f"{opening}\n" + ",\n".join(rows) + f"\n{' ' * indent}{closing}"


def check_model(model: SubjectModel) -> None:
    """Raises ValueError where the parts of a model contradict each other."""
    if not model.markers:
        raise ValueError("the model has no markers")
    if len(set(model.markers)) < len(model.markers):
        twice = next(name for name in model.markers if model.markers.count(name) > 1)
        raise ValueError(f"the model has two markers with the name '{twice}'")
    for name in ("pair_mean", "pair_spread"):
        table = getattr(model, name)
        if not np.array_equal(table, table.T, equal_nan=True):
            raise ValueError(f"the model.{name} is not symmetric")
        if (table < 0).any():
            raise ValueError(f"the model.{name} holds negative numbers")
        _check_lengths(table, f"the model.{name}")
    for s, segment in enumerate(model.segments):
        _check_segment(model, s, segment)
    if len(model.neighbourhoods) not in (0, model.num_markers):
        raise ValueError(f"the model has {len(model.neighbourhoods)} neighbourhoods for {model.num_markers} markers")
    for m, near in enumerate(model.neighbourhoods):
        if not set(near.markers) <= set(range(model.num_markers)) - {m}:
            raise ValueError(f"the model.neighbourhoods[{m}] names a marker that is none of the others")
        if len(near.markers) > MAX_NEIGHBOURS:
            raise ValueError(f"the model.neighbourhoods[{m}] has {len(near.markers)} markers, at most {MAX_NEIGHBOURS}")
        if not (np.isfinite(near.shape).all() and (near.distance_sd >= LEAST).all() and near.marker_sd >= LEAST):
            raise ValueError(f"the model.neighbourhoods[{m}] holds missing or negative numbers")
        _check_lengths(np.r_[near.shape.ravel(), near.distance_sd, near.marker_sd], f"the model.neighbourhoods[{m}]")
    if len(depth_first(model.segments)) < len(model.segments):
        raise ValueError("the parents of the segments form a circle")
    if lost := set(range(model.num_markers)) - {m for segment in model.segments for m in segment.markers}:
        raise ValueError(f"the marker '{model.markers[min(lost)]}' belongs to no segment")


def _check_lengths(lengths: np.ndarray, place: str) -> None:
    """Kernels count in single precision, in which a length beyond reason is infinite; NaN is unknown."""
    if (np.abs(lengths) > FARTHEST_MM).any():
        raise ValueError(f"{place} holds lengths of more than {FARTHEST_MM:g} mm")


def _check_segment(model: SubjectModel, s: int, segment: Segment) -> None:
    place = f"the segment '{segment.name}'"
    if not segment.markers:
        raise ValueError(f"{place} has no markers")
    if list(segment.markers) != sorted(set(segment.markers)):
        raise ValueError(f"{place} does not list its markers in ascending order, each once")
    if not (0 <= segment.markers[0] and segment.markers[-1] < model.num_markers):
        raise ValueError(f"{place} names a marker beyond the {model.num_markers} of the model (they count from 0)")
    if not np.isfinite(segment.shape).all():
        raise ValueError(f"{place} has a shape with missing numbers")
    _check_lengths(segment.shape, place)
    if segment.parent != NO_PARENT and not (0 <= segment.parent < len(model.segments) and segment.parent != s):
        raise ValueError(f"{place} has the parent {segment.parent}, which is no other segment")
    shared = set(segment.markers)
    if segment.parent != NO_PARENT:
        shared &= set(model.segments[segment.parent].markers)
    if not set(segment.join) <= shared:
        raise ValueError(f"{place} joins its parent in markers that they do not share")
    if not (0 < segment.distortion_ratio <= MOST_DISTORTED and 0 < segment.matching_quantity <= 1):
        wanted = f"a distortion_ratio between 0 and {MOST_DISTORTED:g} and a matching_quantity between 0 and 1"
        raise ValueError(f"{place} needs {wanted}")
