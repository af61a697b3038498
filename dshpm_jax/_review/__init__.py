"""A page, served on this machine alone, in which a person sets the last labels of a folder of results."""
