"""Runs over files and folders: what is to be labelled with which model, where, and what became of it."""

from dshpm_jax._archive.jobs import Job as Job
from dshpm_jax._archive.jobs import find_jobs as find_jobs
from dshpm_jax._archive.jobs import in_shard as in_shard
from dshpm_jax._archive.outcomes import Outcome as Outcome
from dshpm_jax._archive.result_status import Due as Due
from dshpm_jax._archive.run import Order as Order
from dshpm_jax._archive.run import label_archive as label_archive
from dshpm_jax._archive.run import what_is_due as what_is_due
from dshpm_jax._outcomes import DOUBTFUL as DOUBTFUL
from dshpm_jax._outcomes import FAILED as FAILED
from dshpm_jax._outcomes import KEPT as KEPT
from dshpm_jax._outcomes import LABELLED as LABELLED
from dshpm_jax._outcomes import PARTLY as PARTLY
from dshpm_jax._outcomes import PASSED as PASSED
