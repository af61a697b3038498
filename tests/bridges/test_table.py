"""Tables of pandas, which need not be installed: a stand-in keeps what it is given."""

import sys
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from making import make_recording
from recordings import recordings

from dshpm_jax._bridges.optional import distinct


def _stand_in() -> SimpleNamespace:
    return SimpleNamespace(
        MultiIndex=SimpleNamespace(from_product=lambda parts, names: (list(product(*parts)), names)),
        Index=lambda values, name: (values, name),
        DataFrame=lambda data, index, columns, copy: SimpleNamespace(data=data, index=index, columns=columns),
    )


@given(recordings)
def test_a_row_for_each_frame_and_a_column_for_each_coordinate(recording):
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "pandas", _stand_in())
        table = recording.to_dataframe()
    seconds, name = table.index
    np.testing.assert_allclose(seconds, np.arange(recording.num_frames) / recording.rate)
    pairs, levels = table.columns
    assert name == "seconds" and levels == ["marker", "axis"] and len(set(pairs)) == len(pairs)
    for k, label in enumerate(distinct(recording.labels)):
        for axis in range(3):
            column = pairs.index((label, "xyz"[axis]))
            np.testing.assert_array_equal(table.data[:, column], recording.points[:, k, axis])


def test_pandas_itself():
    pytest.importorskip("pandas")
    recording = make_recording(9, ["LKNE", "RKNE"])
    table = recording.to_dataframe()
    np.testing.assert_array_equal(table["RKNE"]["z"], recording["RKNE"][:, 2])
    table.loc[:, ("RKNE", "z")] = 0.0  # of its own
    assert np.nanmax(np.abs(recording["RKNE"][:, 2])) > 0


def test_without_pandas(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"to_dataframe needs pandas.*pip install 'dshpm-jax\[pandas\]'"):
        make_recording(9).to_dataframe()


@pytest.mark.parametrize(
    ("labels", "expected"),
    [
        (["A", "B"], ["A", "B"]),
        (["", "A", ""], ["*1", "A", "*3"]),
        (["*2", "", "A"], ["*2", "*3", "A"]),
        (["A", "A", "A_2"], ["A", "A_3", "A_2"]),
    ],
)
def test_names_are_made_distinct(labels, expected):
    assert distinct(labels) == expected
