"""Names that common models give to the points that they compute, for files in which nothing else tells them apart."""

import re
from collections.abc import Collection, Sequence

from dshpm_jax._recording import is_unlabelled

_ALWAYS = (
    r"Cent(re|er)OfMass.*",
    r"[LR]?[._]?[HKASEW]JC([._]?(reg|Harrington|harrington|func|Bell|Davis))?",  # joint centres
    r"([LR]|left|right)?[._ ]?(hip|knee|ankle|shoulder|elbow|wrist)[._ ]?(joint)?[._ ]?cent(er|re)",
    r"V_(?!s(a|\.)?c).*",  # OpenSim's virtual markers; V_Sacral is a marker
)
_FOOT_FRAMES = ("FOF", "HDF", "HLX")
_FOOT = (
    r"[LR](FOF|HDF|HLX|TIB)[0-3]",
    r"[LR](D1M0|PROXFF|HE1|ANK1|KAX|ArchHeight(Index)?|HFplantar|ViconLegLength)",
    r"proj[LR](KAX|TIB)",
    r"PEL0",
)
"""The Oxford Foot Model; TIB1 and others may well be markers elsewhere, so its frames have to be there as well."""


def known_outputs(names: Sequence[str]) -> set[int]:
    """Which columns have names of computed points.

    Arguments:
        names: of all columns, without prefixes.
    """
    there = set(names)
    foot = any({f"{side}{frame}{k}" for k in range(4)} <= there for side in "LR" for frame in _FOOT_FRAMES)
    patterns = [re.compile(text, re.IGNORECASE) for text in _ALWAYS] + [re.compile(text) for text in _FOOT if foot]
    axes = _axes(there)
    return {
        c
        for c, name in enumerate(names)
        if not is_unlabelled(name) and (name in axes or any(pattern.fullmatch(name) for pattern in patterns))
    }


def _axes(there: Collection[str]) -> set[str]:
    """Plug-in Gait stores a segment's axes as four points: PELO, PELA, PELL, PELP."""
    stems = {name[:-1] for name in there if len(name) > 2}
    return {stem + end for stem in stems if {stem + end for end in "OALP"} <= set(there) for end in "OALP"}
