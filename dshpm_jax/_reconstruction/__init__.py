"""Reconstructed motion: poses of segments, joints between them, and on request the missing markers."""

from dshpm_jax._reconstruction.expected import ExpectedErrors as ExpectedErrors
from dshpm_jax._reconstruction.expected import GapErrors as GapErrors
from dshpm_jax._reconstruction.export import write_motion as write_motion
from dshpm_jax._reconstruction.filling import Filled as Filled
from dshpm_jax._reconstruction.motion import Found as Found
from dshpm_jax._reconstruction.motion import Motion as Motion
from dshpm_jax._reconstruction.reconstruct import reconstruct as reconstruct
