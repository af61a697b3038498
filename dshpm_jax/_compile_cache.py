"""Compiled programs kept on disk, for who asks for it."""

import os


def cache_programs() -> None:
    """Keeps compiled programs in the folder that DSHPM_CACHE names, if it does: they are good for one machine only."""
    if folder := os.environ.get("DSHPM_CACHE"):
        import jax

        jax.config.update("jax_compilation_cache_dir", folder)
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.1)
