"""Moves that might pay, a file a kind: each proposes, and `full.moves` judges."""
