"""What was decided about each trajectory, as JSON beside the labelled file."""

import json
import re
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from dshpm_jax._hierarchy import depth_first
from dshpm_jax._labelling import Labelling
from dshpm_jax._recording import is_unlabelled
from dshpm_jax._types import NO_MATCH
from dshpm_jax.io._atomic import write_whole

FORMAT = "dshpm-labels"

_COLUMN_RUNS = re.compile(rb'"columns": \[\[[-0-9, \[\]]*\]\], ')  # no label holds this: its quotes are escaped


def sidecar_path(path: str | Path) -> Path:
    """Where the sidecar of a labelled file is."""
    return Path(path).with_name(f"{Path(path).stem}.labels.json")


def write_sidecar(labelling: Labelling, path: str | Path, record: Mapping[str, Any] | None = None) -> None:
    """Writes source columns, frames, label, confidence and reason of every trajectory, a line each.

    What `record` holds (settings, say, or hashes) goes into the head as it is. Frames and columns count from 0; both
    ends of a frame range belong to it.
    """
    content = sidecar(labelling) | dict(record or {})
    rows = ",\n".join("  " + _dumps(row) for row in content.pop("trajectories"))
    lines = [f" {json.dumps(key)}: {_dumps(value)}" for key, value in content.items()]
    lines.append(f' "trajectories": [\n{rows}\n ]')
    write_whole(Path(path), [("{\n" + ",\n".join(lines) + "\n}\n").encode()])


def sidecar(labelling: Labelling) -> dict[str, Any]:
    """What `write_sidecar` writes and `read_sidecar` gives back.

    Frames and columns count from 0; `trajectories` has an entry for each.
    """
    recording, model = labelling.recording, labelling.model
    return {
        "format": FORMAT,
        "version": 1,
        "made_by": f"dshpm-jax {version('dshpm-jax')}",
        "source": recording.source.name if recording.source else None,
        "rate": recording.rate,
        "frames": recording.num_frames,
        **({"notes": recording.notes} if recording.notes else {}),
        "markers": model.markers,
        "segments": [
            {"name": model.segments[s].name, "markers": [model.markers[m] for m in model.segments[s].markers]}
            for s in depth_first(model.segments)
        ],
        "stats": labelling.stats,
        "trajectories": [_row(labelling, j) for j in range(len(labelling.trajectories))],
    }


def read_sidecar(path: str | Path, column_runs: bool = True) -> dict[str, Any] | None:
    """A whole sidecar; None where there is none or the file is something else.

    Without `column_runs`, trajectories that change their column do not say where: that is most of a sidecar of raw
    points, and of the time to read it.
    """
    try:
        text = Path(path).read_bytes()
        found = json.loads(text if column_runs else _COLUMN_RUNS.sub(b"", text))
    except (OSError, ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) and found.get("format") == FORMAT and "trajectories" in found else None


def read_sidecar_head(path: str | Path) -> dict[str, Any] | None:
    """All but the trajectories of a sidecar; None where there is none or the file is something else."""
    found = read_sidecar(path)
    if found is not None:
        del found["trajectories"]
    return found


def _row(labelling: Labelling, trajectory: int) -> dict[str, Any]:
    """The sidecar's row of one trajectory; `columns` are runs [column, first, last] where it changes its column.

    `could_be` is there where other labels fit it too, or one is withheld, which then comes first.
    """
    tracks, recording = labelling.trajectories, labelling.recording
    start, stop = int(tracks.start[trajectory]), int(tracks.stop[trajectory])
    column = tracks.column[start:stop, tracks.slot[trajectory]]
    edges = [0, *(np.flatnonzero(np.diff(column)) + 1), len(column)]
    runs = [
        [recording.columns[column[a]], start + int(a), start + int(b) - 1]
        for a, b in zip(edges, edges[1:], strict=False)
    ]
    identity = int(labelling.identity[trajectory])
    found: dict[str, Any] = {"column": runs[0][0] if len(runs) == 1 else None}
    if len(runs) > 1:
        found["columns"] = runs
    elif not is_unlabelled(recording.labels[column[0]]):
        found["was"] = recording.labels[column[0]]
    found |= {
        "frames": [start, stop - 1],
        "label": None if identity == NO_MATCH else labelling.model.markers[identity],
        "confidence": round(float(labelling.confidence[trajectory]), 4),
        "reason": str(labelling.reason[trajectory]),
    }
    others = () if labelling.could_be is None else labelling.could_be[trajectory]
    could_be = [labelling.model.markers[marker] for marker in others if marker != NO_MATCH]
    return found | {"could_be": could_be} if could_be else found


def _dumps(value: Any) -> str:
    return json.dumps(value, default=_plain)


def _plain(value: Any) -> Any:
    """Numpy values and paths, which json does not know."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else str(value)
