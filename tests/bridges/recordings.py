"""Recordings of all kinds for the laws of bridges: gaps, columns without a name, names that come twice."""

from hypothesis import strategies as st
from making import make_recording

from dshpm_jax._recording import MILLIMETRES

NAMES = ("LKNE", "RKNE", "*4", "", "C7")

recordings = st.builds(
    make_recording,
    frames=st.integers(2, 9),
    labels=st.lists(st.sampled_from(NAMES), min_size=1, max_size=6),
    seed=st.integers(0, 99),
    unit=st.sampled_from(sorted(MILLIMETRES)),
    rate=st.sampled_from([50.0, 100.0, 119.88, 1000.0]),
)
