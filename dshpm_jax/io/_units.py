"""Length units of files; inside, every length is in millimetres."""

from pathlib import Path

from dshpm_jax._recording import MILLIMETRES as MILLIMETRES
from dshpm_jax.io._errors import ReadError

FARTHEST_MM = 1e9
"""No system measures a point a thousand kilometres away; what a file has there was not seen."""

LOWEST_RATE, HIGHEST_RATE = 0.01, 1e6
"""Frames a second that no motion is captured below, and that no camera exceeds."""

_SPELLINGS = {
    "millimeter": "mm",
    "millimetre": "mm",
    "centimeter": "cm",
    "centimetre": "cm",
    "meter": "m",
    "metre": "m",
}


def length_unit(text: str, path: Path) -> str:
    """The unit that a file names, one of `MILLIMETRES`; mm where the field is empty or holds no word at all."""
    word = text.strip().strip("[]().").lower()
    if not word.isalpha():
        return "mm"
    unit = _SPELLINGS.get(word.removesuffix("s"), word)
    if unit not in MILLIMETRES:
        known = ", ".join(MILLIMETRES)
        raise ReadError(path, f"its length unit is '{text.strip()}', not one of {known}", "convert it to one of these")
    return unit
