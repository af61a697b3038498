"""Makes JAX strict for the tests; the package itself never touches the configuration."""

import os
from pathlib import Path

import jax
import pytest

jax.config.update("jax_numpy_dtype_promotion", "strict")
jax.config.update("jax_numpy_rank_promotion", "raise")

DATA = Path(os.environ.get("DSHPM_DATA", Path(__file__).resolve().parents[2] / "shared" / "data"))


@pytest.fixture
def data() -> Path:
    """The folder of real recordings; a test that needs it is skipped where it is absent."""
    if not DATA.is_dir():
        pytest.skip("no folder of real recordings (set DSHPM_DATA)")
    return DATA
