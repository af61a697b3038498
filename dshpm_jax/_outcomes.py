"""What may become of a recording in a run: the words that manifests, tables and pages have for it."""

LABELLED, PARTLY, DOUBTFUL = "labelled", "partly labelled", "doubtful"
KEPT, FAILED, PASSED = "kept", "failed", "passed over"

WORST_FIRST = (FAILED, KEPT, DOUBTFUL, PARTLY, LABELLED, PASSED)
"""The order in which people look at them; `report/run/words.js` has their colours."""
