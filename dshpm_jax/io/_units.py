"""Length units of files; inside, every length is in millimetres."""

from pathlib import Path

from dshpm_jax._recording import MILLIMETRES as MILLIMETRES
from dshpm_jax.io._errors import ReadError

FARTHEST_MM = 1e9
"""Millimetres; a model that holds longer lengths is none."""

LOWEST_RATE, HIGHEST_RATE = 0.01, 1e6
"""Frames a second that no motion is captured below, and that no camera exceeds."""

_SPELLINGS = {
    "mm": ("millimeters", "millimetres"),
    "cm": ("centimeters", "centimetres"),
    "m": ("meters", "metres"),
}
_SHORTEST_CUT = 3  # letters of a word that was cut off; of fewer nobody can say what they were


def length_unit(text: str, path: Path) -> str:
    """The unit that a file names, one of `MILLIMETRES`; mm where the field is empty or holds no word at all.

    A word may be cut off, as some files do to it, where it is the beginning of one unit alone.
    """
    word = text.strip().strip("[]().").lower()
    if not word.isalpha():
        return "mm"
    meant = {unit for unit, names in _SPELLINGS.items() if any(name.startswith(word) for name in names)}
    if word in MILLIMETRES or (len(meant) == 1 and len(word) >= _SHORTEST_CUT):
        return word if word in MILLIMETRES else meant.pop()
    known = ", ".join(MILLIMETRES)
    raise ReadError(path, f"its length unit is '{text.strip()}', not one of {known}", "convert it to one of these")
