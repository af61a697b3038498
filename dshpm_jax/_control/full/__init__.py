"""The full method: evidence of whole lives, an objective that needs no truth, and the search for its best labels."""
