"""Rigid fits of given correspondences, compiled."""

import jax

from dshpm_jax._kernels.rigid_fit import rigid_fit

fit_poses = jax.jit(rigid_fit)
