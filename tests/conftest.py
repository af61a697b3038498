"""Makes JAX strict for the tests, which the package itself never does, and lets a slow machine pass them."""

import os
from pathlib import Path

import jax
import pytest
from hypothesis import settings
from making import make_model, make_recording

from dshpm_jax import io

os.environ.setdefault("DSHPM_CACHE", "")  # commands that tests run keep nothing in the user's folder of caches
jax.config.update("jax_numpy_dtype_promotion", "strict")
jax.config.update("jax_numpy_rank_promotion", "raise")
settings.register_profile("unhurried", deadline=None)
settings.load_profile("unhurried")

DATA = Path(os.environ.get("DSHPM_DATA", Path(__file__).resolve().parents[2] / "shared" / "data"))


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """The working folder of a command: a recording `walk.c3d` with the labels that `model.json` knows."""
    monkeypatch.chdir(tmp_path)
    io.write_c3d(make_recording(60), tmp_path / "walk.c3d")
    io.write_model(make_model(("LASI", "RASI", "SACR")), tmp_path / "model.json")
    return tmp_path


@pytest.fixture
def data() -> Path:
    """The folder of real recordings; a test that needs it is skipped where it is absent."""
    if not DATA.is_dir():
        pytest.skip("no folder of real recordings (set DSHPM_DATA)")
    return DATA
