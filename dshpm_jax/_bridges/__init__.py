"""Recordings to and from what other libraries hold in memory. None of these libraries is imported before it is needed.

`Recording.from_ezc3d`, `to_ezc3d`, `from_kineticstoolkit`, `to_kineticstoolkit` and `to_dataframe` call what is here.
"""
