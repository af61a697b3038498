"""Models of the synthetic people are learnt from short takes here, which is quick."""

import pytest

from dshpm_jax._experiments import subjects


@pytest.fixture(autouse=True)
def short_model_takes(monkeypatch):
    monkeypatch.setattr(subjects, "MODEL_FRAMES", 240)
