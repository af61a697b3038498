"""A review that is killed at a random moment has lost nothing that it had shown as kept."""

import random
import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).resolve().parents[1] / "review"))

from killed_reviews import kill_once  # noqa: E402
from wrong_results import write_wrong  # noqa: E402

pytest.importorskip("uvicorn", reason="the extra 'review' is not installed")


@pytest.mark.parametrize("seed", [1, 2])
def test_nothing_is_lost(tmp_path, monkeypatch, seed):
    monkeypatch.setattr("killed_reviews.LONGEST", 2.0)
    write_wrong(tmp_path / "made", {"LTOE": "RTOE", "RTOE": "LTOE"})
    found = kill_once(tmp_path / "made", tmp_path / "try", random.Random(seed), solved=False)
    assert found.wrong == ""
