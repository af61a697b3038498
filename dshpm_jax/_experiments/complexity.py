"""Rigid fits that labelling takes when points are missing or extra (section 5.2.3, Fig. 10).

The trials are those of `corruption`; what it left in the folder is not run again.
"""

from collections.abc import Sequence
from pathlib import Path

from dshpm_jax._experiments.corruption import HEADER, curves, plan, rows_of
from dshpm_jax._experiments.figures import save
from dshpm_jax._experiments.records import Records, write_rows
from dshpm_jax._experiments.statistics import Mean, mean_of
from dshpm_jax._experiments.trials import ExperimentPlan, TrialResult

__all__ = ["draw", "plan", "write_table"]


def write_table(plan: ExperimentPlan, records: Records, path: Path) -> None:
    """A row for each point: the mean number of fits with its 95 % interval."""
    write_rows(path, (*HEADER, "fits", "low", "high"), rows_of(plan, records, fits_of))


def draw(plan: ExperimentPlan, records: Records, path: Path) -> None:
    """Fits on a logarithmic scale against the fraction that is missing or extra."""
    figure, ax = curves(plan, records, fits_of)
    ax.set_yscale("log")
    ax.set_ylabel("rigid fits (SVD-count)")
    save(figure, path)


def fits_of(outcomes: Sequence[TrialResult]) -> Mean:
    """The mean number of fits over trials."""
    return mean_of([one.fits for one in outcomes], (1.0, float("inf")))
