"""Labels a subject of whom nothing is labelled, by what a marker set knows of others."""
