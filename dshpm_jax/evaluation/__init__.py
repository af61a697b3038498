"""Measures of a labelling against the truth (section 5)."""

from dshpm_jax.evaluation._rates import Scores as Scores
from dshpm_jax.evaluation._rates import point_identification_rate as point_identification_rate
from dshpm_jax.evaluation._rates import precision_recall_f1 as precision_recall_f1
from dshpm_jax.evaluation._rates import scores_by_label as scores_by_label
from dshpm_jax.evaluation._rates import trajectory_identification_rate as trajectory_identification_rate
