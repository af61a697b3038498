"""The paper's method on its own: one segment, one key-frame range, and what follows from it over the recording."""
