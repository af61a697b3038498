"""A labeller that stands in for the real one."""

import sys
from types import SimpleNamespace

import pytest
from making import make_labelling


@pytest.fixture
def labeller(monkeypatch):
    """Stands in for the real one: a column gets the label that it carries."""

    def label_many(recordings, models, settings, known):
        for recording, model in zip(recordings, models, strict=True):
            yield make_labelling(recording, list(model.markers))

    monkeypatch.setitem(sys.modules, "dshpm_jax._label", SimpleNamespace(label_many=label_many))
