"""Which scores label best? Any set of them on any cases, with paired differences.

    python bench/scores.py ARCHIVE TRUTH [--method paper] [--only REGEX] [--png FILE] [SCORE[+SCORE] ...]

ARCHIVE holds unlabelled recordings below folders with a `model.json`, TRUTH an .npz for each, as `ablation.py` reads
them. A SCORE is a class of `dshpm_jax`, or FILE.py:CLASS; a candidate score and a match score can be joined by `+`,
and what is not given is the default. Everything is compared with the defaults, which need not be named. Prints F1 over
points for each recording, then for each contestant the mean, the mean difference to the defaults with its standard
error, on how many recordings it is better and worse, and the seconds (the first run of each compiles).
"""

import argparse
import importlib.util
import re
import time
from pathlib import Path

import numpy as np
from _truth import f1, name_of

import dshpm_jax
from dshpm_jax import AbstractCandidateScore, Driver, Settings, label_many, read, read_model

DEFAULTS = "defaults"
CONTESTANTS = ("GaussianCandidate+GaussianMatch", "RobustResidual")
SAME = 5e-5  # differences of F1 below this are none


def main() -> None:
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("archive", type=Path)
    parser.add_argument("truth", type=Path)
    parser.add_argument("scores", nargs="*", default=CONTESTANTS, metavar="SCORE")
    parser.add_argument("--method", choices=("full", "paper", "static"), default="full")
    parser.add_argument("--only", default="", help="paths below ARCHIVE that count")
    parser.add_argument("--png", type=Path)
    arguments = parser.parse_args()
    files = [f for f in sorted(arguments.archive.rglob("*.c3d")) if re.search(arguments.only, str(f))]
    recordings = [read(file) for file in files]
    models = [read_model(file.parent / "model.json") for file in files]
    truths = [dict(np.load(arguments.truth / name_of(file, arguments.archive))) for file in files]
    contestants = {DEFAULTS: Driver()} | {name: driver_of(name) for name in arguments.scores}
    settings = Settings(method=arguments.method)
    found: dict[str, np.ndarray] = {}
    seconds: dict[str, float] = {}
    for name, driver in contestants.items():
        start = time.perf_counter()
        labelled = label_many(recordings, models, settings, driver)
        found[name] = np.array([f1(labelling, truth) for labelling, truth in zip(labelled, truths)])
        seconds[name] = time.perf_counter() - start
    print("F1 over points".ljust(44) + " ".join(f"{name[:24]:>24}" for name in found))
    for k, file in enumerate(files):
        row = " ".join(f"{values[k]:24.4f}" for values in found.values())
        print(f"{str(file.relative_to(arguments.archive))[:43]:44}{row}")
    print(f"{'':44}{'mean':>8} {'difference':>19} {'better':>7} {'worse':>6} {'seconds':>8}")
    for name, values in found.items():
        apart = values - found[DEFAULTS]
        error = apart.std(ddof=1) / np.sqrt(len(apart)) if len(apart) > 1 else np.nan
        wins, losses = int((apart > SAME).sum()), int((apart < -SAME).sum())
        print(
            f"{name[:43]:44}{values.mean():8.4f} {apart.mean():+9.4f} +- {error:.4f} {wins:7} {losses:6} "
            f"{seconds[name]:8.1f}"
        )
    if arguments.png:
        draw(found, arguments.png)


def driver_of(names: str) -> Driver:
    """A driver with the named scores."""
    candidate = match = None
    for name in names.split("+"):
        score = class_of(name)()
        if isinstance(score, AbstractCandidateScore):
            candidate = score
        else:
            match = score
    return Driver(candidate_score=candidate, match_score=match)


def class_of(name: str) -> type:
    """A class of the package, or of a file: `scores.py:MyScore`."""
    file, _, found = name.rpartition(":")
    if not file:
        return getattr(dshpm_jax, found)
    spec = importlib.util.spec_from_file_location(Path(file).stem, file)
    if spec is None or spec.loader is None:
        raise SystemExit(f"{file}: is no Python file")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return getattr(module, found)


def draw(found: dict[str, np.ndarray], path: Path) -> None:
    """F1 of each contestant against that of the defaults, a dot a recording."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(4.5, 4.2), layout="constrained")
    axes.plot([0, 1], [0, 1], color="0.7", linewidth=1)
    for name, values in found.items():
        if name != DEFAULTS:
            axes.plot(found[DEFAULTS], values, "o", markersize=4, label=name)
    axes.set(xlabel="F1 with the defaults", ylabel="F1", xlim=(0, 1.01), ylim=(0, 1.01))
    axes.legend(fontsize=7)
    figure.savefig(path, dpi=150)


if __name__ == "__main__":
    main()
