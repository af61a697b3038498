"""Do recordings come back as they were?

    python bench/round_trips.py FOLDER...

Reads every recording in folders, gives each trajectory of a named column that column's label, writes the result in the
format of its source, as C3D and as TRC, and compares it with the source cell by cell: in the format of the source all
cells of points, as bytes or as text, besides names and the order of columns; in the others the coordinates. The exit
status is 1 if any file differs.
"""

import argparse
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

from dshpm_jax import Labelling, Reason, Recording, Segment, SubjectModel, io
from dshpm_jax._trajectories import from_columns
from dshpm_jax._types import NO_MATCH
from dshpm_jax.io._c3d import raw_c3d
from dshpm_jax.io._c3d_format import read_layout
from dshpm_jax.io._text import text_table

NEAR_MM = 1e-3  # single precision at some metres
KINDS = (".c3d", ".trc")


def main() -> int:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path)
    found: Counter[str] = Counter()
    for folder in parser.parse_args().folders:
        for path in sorted(path for path in folder.rglob("*") if path.is_file() and io.may_be_recording(path)):
            for what in differences(path):
                found[what.partition(":")[0]] += 1
                if not what.startswith("same"):
                    print(f"{path.relative_to(folder)}: {what}")
    for what, count in sorted(found.items()):
        print(f"{what:40} {count:5}")
    return 1 if any(not what.startswith(("same", "refused")) for what in found) else 0


def differences(path: Path) -> list[str]:
    """A line for each format that the file is written in."""
    try:
        recording = io.read(path)
    except io.ReadError as error:
        return [f"refused: {str(error).removeprefix(str(path))}"]
    labelling, said = labelling_of(recording), []
    with tempfile.TemporaryDirectory() as folder:
        for kind in dict.fromkeys((path.suffix.lower(), *KINDS)):
            out = Path(folder) / f"{path.stem}{kind}"
            io.write_labelled(labelling, out)
            own = kind == path.suffix.lower()
            wrong = (cells_of(path) != cells_of(out)) if own else coordinates_differ(labelling, out)
            said.append(f"{'differs' if wrong else 'same'} as {kind}{', cell by cell' if own else ''}")
    return said


def labelling_of(recording: Recording) -> Labelling:
    """Each trajectory has the label of its column, where that is the only one of its name."""
    names = Counter(name for name, named in zip(recording.labels, recording.labelled) if named)
    markers = [name for name, times in names.items() if times == 1][::-1]
    tracks = from_columns(recording.points, recording.rate)
    column = tracks.column[tracks.start, tracks.slot]
    identity = np.array([markers.index(n) if (n := recording.labels[c]) in markers else NO_MATCH for c in column], int)
    count = len(markers)
    mean, spread = np.zeros((2, count, count))
    segments = (Segment("all", tuple(range(count)), np.zeros((count, 3))),)
    model = SubjectModel(tuple(markers), segments, pair_mean=mean, pair_spread=spread)
    reasons = tuple(Reason.OUTSIDE if k == NO_MATCH else Reason.MATCHED for k in identity)
    return Labelling(recording, model, tracks, identity, np.ones(len(tracks)), reasons)


def cells_of(path: Path) -> list[Counter]:
    """In each frame the cells of its points, whatever their order, and what else the frame holds; gaps left out."""
    if path.suffix.lower() == ".c3d":
        file = read_layout(path)
        raw = raw_c3d(path)
        seen = np.asarray(np.isfinite(raw.points).all(-1))
        rows = [file.points[:, c] for c in raw.columns]
        frames = [Counter(row[t].tobytes() for row, s in zip(rows, seen.T) if s[t]) for t in range(len(seen))]
        return [frame + Counter([other.tobytes()]) for frame, other in zip(frames, file.analog)]
    table = text_table(path)
    points = {c + k for c in table.columns for k in range(table.stride)}
    frames = []
    for _, cells in table.frames():
        cells = cells + [""] * (table.file_width() - len(cells))
        own = (tuple(cells[c : c + table.stride]) for c in table.columns)
        rest = tuple(cell for c, cell in enumerate(cells) if c not in points and cell)
        frames.append(Counter([cell for cell in own if any(cell)]) + Counter([rest]))
    return frames


def coordinates_differ(labelling: Labelling, out: Path) -> bool:
    before, after = labelling.to_recording(), io.read(out, drop=["!*"], frozen_gaps=False)
    if before.points.shape != after.points.shape or not np.array_equal(before.present, after.present):
        return True
    return bool(np.nanmax(np.abs(before.points - after.points), initial=0) > NEAR_MM)


if __name__ == "__main__":
    raise SystemExit(main())
