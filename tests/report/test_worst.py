"""The worst of many entries are kept, within their bytes."""

import json

from hypothesis import given
from hypothesis import strategies as st

from dshpm_jax.report._worst import Worst


@given(st.lists(st.text("a<\u20ac", max_size=30), max_size=60), st.integers(10, 300))
def test_it_keeps_what_comes_first_and_fits(entries, most):
    worst = Worst(most)
    for k, entry in enumerate(entries):
        worst.add((len(entry), k), entry)
    kept = worst.entries()
    in_order = [entry for _, entry in sorted((len(entry), k, entry)[1:] for k, entry in enumerate(entries))]
    in_order.sort(key=len)
    assert kept == in_order[: len(kept)] and worst.added == len(entries)

    def size(some):
        return sum(len(json.dumps(entry).replace("<", "\\u003c")) + 1 for entry in some)

    assert size(kept) <= most
    assert len(kept) == len(entries) or size(in_order[: len(kept) + 1]) > most
