"""Is a trajectory labelled with a confidence of .99 right 99 times in 100?

    python bench/reliability.py LABELLED TRUTH [--png FILE]

LABELLED holds what `dshpm-jax label` wrote (`*.c3d` and `*.labels.json`), TRUTH an .npz for each recording, named by
the path below LABELLED with dots for slashes, with `labels`, `xyz` (frames, labels, 3; NaN where missing), their
`units`, and `judged` (frames, labels). Prints a row for each range of confidence.
"""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from _truth import NEAR, places_of

from dshpm_jax.io import read

EDGES = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999, 1.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("labelled", type=Path)
    parser.add_argument("truth", type=Path)
    parser.add_argument("--png", type=Path)
    arguments = parser.parse_args()
    rows = np.array(
        [row for file in sorted(arguments.labelled.rglob("*.labels.json")) for row in judge(file, arguments)]
    )
    if not len(rows):
        raise SystemExit(f"{arguments.labelled}: no labelled trajectory with a truth")
    confidence, right, life = rows.T
    print(f"{'confidence':>14} {'trajectories':>12} {'mean':>7} {'right':>7} {'points':>9} {'right':>7}")
    table = []
    for low, high in zip(EDGES, EDGES[1:]):
        here = (confidence >= low) & ((confidence < high) | (high == EDGES[-1]))
        if here.any():
            table.append((confidence[here].mean(), right[here].mean(), here.sum()))
            share = np.average(right[here], weights=life[here])
            print(
                f"{low:6.3f} - {high:5.3f} {here.sum():12} {table[-1][0]:7.4f} {table[-1][1]:7.4f} "
                f"{int(life[here].sum()):9} {share:7.4f}"
            )
    sure = confidence >= 0.99
    print(f"of {sure.sum()} trajectories with a confidence of .99 or more, {right[sure].mean():.3%} are right")
    if arguments.png:
        draw(table, arguments.png)


def judge(file: Path, arguments: argparse.Namespace) -> Iterator[tuple[float, bool, int]]:
    """Confidence, whether it is right, and length of every labelled trajectory that can be judged."""
    name = ".".join(file.relative_to(arguments.labelled).parts).removesuffix(".labels.json")
    path = arguments.truth / f"{name}.npz"
    if not path.exists():
        return
    truth = dict(np.load(path))
    labels, judged = truth["labels"].tolist(), truth["judged"]
    places = places_of(truth)
    found = read(file.with_name(file.name.removesuffix(".labels.json") + ".c3d"))
    for row in json.loads(file.read_text())["trajectories"]:
        if row["label"] is None:
            continue
        first, last = row["frames"]
        middle = (first + last) // 2
        if row["label"] not in labels:
            yield row["confidence"], False, last - first + 1
            continue
        k = labels.index(row["label"])
        if judged[middle, k]:
            apart = np.linalg.norm(found.points[middle, found.labels.index(row["label"])] - places[middle, k])
            yield row["confidence"], bool(apart < NEAR), last - first + 1


def draw(table: list[tuple[float, float, int]], path: Path) -> None:
    """The reliability diagram: errors against what the confidence says of them, both logarithmic."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    said, found, count = (np.array(column, float) for column in zip(*table))
    figure, axes = pyplot.subplots(figsize=(4.5, 4.2), layout="constrained")
    axes.plot([1e-5, 1], [1e-5, 1], color="0.7", linewidth=1)
    axes.scatter(1 - said, np.maximum(1 - found, 0.5 / count), s=8 + 12 * np.log10(count), color="#1f5f8b")
    axes.set(xscale="log", yscale="log", xlabel="1 - confidence", ylabel="share that is wrong")
    figure.savefig(path, dpi=150)


if __name__ == "__main__":
    main()
