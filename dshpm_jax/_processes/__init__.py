"""Processes of this machine: of `label --workers` and of `experiment --workers`."""

from dshpm_jax._processes.memory import machine_memory as machine_memory
from dshpm_jax._processes.pool import ProcessPool as ProcessPool
from dshpm_jax._processes.pool import WorkerDied as WorkerDied
