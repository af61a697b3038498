"""Labels that somebody changed in a result with another program, as corrections."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Int

from dshpm_jax import io
from dshpm_jax._archive.hashes import hash_file
from dshpm_jax._archive.manifest import MANIFEST_NAME, known_rows
from dshpm_jax._corrections import Change, Correction, append, corrections_path
from dshpm_jax._geometry import is_seen
from dshpm_jax._known import runs
from dshpm_jax._recording import Recording
from dshpm_jax._types import NO_MATCH, UNKNOWN

SAME = 0.05  # mm, what another program's rounding may move a point
ASIDE = "changed"  # in the name of a result that makes room, before its ending


def adopt(result: Path, source: Path | None = None) -> list[Correction]:
    """What somebody changed in the labels of a result, as corrections; none where nobody changed anything.

    A point that lost its label is taken for no marker. What else was changed, such as filled gaps, is no correction.

    Arguments:
        result: a labelled file with its sidecar.
        source: the recording that was labelled; by default what the manifest of the run says.

    Raises:
        ReadError: a file is not there, cannot be read, or holds another recording.
    """
    sidecar = io.read_sidecar(io.sidecar_path(result))
    if sidecar is None:
        raise io.ReadError(result, "no sidecar of 'label' is beside it", "label the recording first")
    if hash_file(result) == sidecar.get("output"):
        return []
    source = source or source_of(result)
    how, markers = sidecar.get("settings", {}), sidecar["markers"]
    options = how.get("unlabelled", ()), [*io.kept(markers), *how.get("drop", ())], how.get("frozen_gaps", True)
    turned = io.Form(axes=sidecar.get("written", {}).get("axes", ""))
    before, after = turned.of(io.read(source, *options)), io.read(result, *options[:2], frozen_gaps=False)
    if after.num_frames != before.num_frames:
        wrong = f"it has {after.num_frames} frames, and {source} {before.num_frames}"
        raise io.ReadError(result, wrong, "put the frames back that were cut off, or leave its labels")
    was, now = _labels_in(sidecar, before), _labels_now(before, after, markers)
    changes = tuple(
        Change(before.columns[column], first, last, _name(label, markers), _name(int(was[first, column]), markers))
        for column, first, last, label in runs(np.where(now == was, UNKNOWN, now), was)
    )
    return [Correction("label", changes, by=f"taken over from {result.name}")] if changes else []


def take_over(result: Path, source: Path | None = None) -> list[Correction]:
    """`adopt`, kept beside the result; the changed file makes room under another name, so that `label` makes it anew.

    Raises:
        ReadError: as `adopt`.
        OSError: the corrections cannot be kept; then nothing has changed.
    """
    source = source or source_of(result)
    found = adopt(result, source)
    for correction in found:
        append(corrections_path(result), correction, source)
    if found:
        os.replace(result, _free_name(result))
    return found


def source_of(result: Path) -> Path:
    """The recording that a result is of, by the manifest of its run; `ReadError` where none says so."""
    for folder in result.absolute().parents:
        if (folder / MANIFEST_NAME).is_file():
            row = known_rows(folder).get(result.absolute().relative_to(folder).as_posix())
            if row is not None:
                return Path(row["input"])
    raise io.ReadError(result, f"no {MANIFEST_NAME} above it says of which recording it is", "give the recording too")


def _free_name(result: Path) -> Path:
    names = (f"{result.stem}.{ASIDE}{'-' * (k > 0)}{k or ''}{result.suffix}" for k in range(10**6))
    return next(path for path in map(result.with_name, names) if not path.exists())


def _labels_in(sidecar: Mapping[str, Any], recording: Recording) -> Int[np.ndarray, "frames points"]:
    """The labels that the sidecar says the points had."""
    number = {None: NO_MATCH, **{name: k for k, name in enumerate(sidecar["markers"])}}
    place = {column: k for k, column in enumerate(recording.columns)}
    found = np.full(recording.points.shape[:2], UNKNOWN, np.int32)
    for row in sidecar["trajectories"]:
        for column, first, last in row.get("columns") or [[row["column"], *row["frames"]]]:
            if column in place:
                found[first : last + 1, place[column]] = number[row["label"]]
    return found


def _labels_now(before: Recording, after: Recording, markers: list[str]) -> Int[np.ndarray, "frames points"]:
    """The labels that points of a recording have in a file of the same points, `UNKNOWN` where they are not there."""
    from scipy.spatial import KDTree  # slow to import

    number = np.array([markers.index(name) if name in markers else NO_MATCH for name in after.labels])
    found = np.full(before.points.shape[:2], UNKNOWN, np.int32)
    seen, there = is_seen(before.points), is_seen(after.points)
    for t in np.flatnonzero(seen.any(1) & there.any(1)):
        columns, others = np.flatnonzero(seen[t]), np.flatnonzero(there[t])
        apart, nearest = map(np.asarray, KDTree(before.points[t, columns]).query(after.points[t, others]))
        same = apart < SAME
        found[t, columns[nearest[same]]] = number[others[same]]
    return found


def _name(label: int, markers: list[str]) -> str | None:
    return None if label < 0 else markers[label]
