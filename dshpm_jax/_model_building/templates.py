"""Segments by the names of markers alone, for recordings that show no motion."""

from collections.abc import Mapping, Sequence

from dshpm_jax._model_building.body_parts import parts_of_each

BY_NAMES = "body-parts"
"""The template that reads any family of names that `body_parts` knows."""

_PLUG_IN_GAIT_LIMBS = {
    "upper arm": "SHO UPA ELB",
    "forearm": "ELB FRM FRA WRA WRB",
    "hand": "WRA WRB FIN",
    "thigh": "THI THIA KNE KNM",
    "shank": "KNE KNM TIB TIAP TIBA ANK ANM MED",
    "foot": "ANK ANM MED HEE TOE",
}
_HELEN_HAYES_LIMBS = {
    "upper arm": "SHO UPA ELB ASHO AELB",
    "forearm": "ELB WRI WRA WRB AELB AWRI",
    "thigh": "THI THIGH KNE KNEE MKNE MKNEE LKNE",
    "shank": "KNE KNEE MKNE MKNEE TIB SHANK ANK ANKLE MANK MANKLE LKNE",
    "foot": "ANK ANKLE MANK MANKLE HEE HEEL TOE",
}


def _sided(limbs: dict[str, str]) -> dict[str, list[str]]:
    sides = (("left", "L"), ("right", "R"))
    return {
        f"{side} {part}": [letter + stem for stem in stems.split()]
        for side, letter in sides
        for part, stems in limbs.items()
    }


TEMPLATES: Mapping[str, Mapping[str, Sequence[str]]] = {
    "plug-in-gait": {
        "head": "LFHD RFHD LBHD RBHD".split(),
        "trunk": "C7 T10 CLAV STRN RBAK LSHO RSHO".split(),
        "pelvis": "LASI RASI LPSI RPSI SACR".split(),
        **_sided(_PLUG_IN_GAIT_LIMBS),
    },
    "helen-hayes": {
        "head": "TOPH FRTH REARH LFHD RFHD LBHD RBHD".split(),
        "trunk": "LSHO RSHO OFFSET C7 T10 CLAV STRN RSCAP".split(),
        "pelvis": "LASI RASI SACR VSAC LASIS RASIS".split(),
        **_sided(_HELEN_HAYES_LIMBS),
    },
    BY_NAMES: {},
}


def by_template(names: Sequence[str], template: str) -> dict[str, list[int]]:
    """The markers of each part of the body in a template; markers that it does not know are in none."""
    if template not in TEMPLATES:
        raise ValueError(f"no template {template!r}; there are {', '.join(sorted(TEMPLATES))}")
    if template == BY_NAMES:
        return by_names(names)
    place = {name.upper(): i for i, name in enumerate(names)}
    found = {part: sorted(place[n] for n in labels if n in place) for part, labels in TEMPLATES[template].items()}
    return {part: markers for part, markers in found.items() if markers}


def by_names(names: Sequence[str]) -> dict[str, list[int]]:
    """The markers whose names say each part of the body; a marker at a joint is in both."""
    found: dict[str, list[int]] = {}
    for i, parts in enumerate(parts_of_each(names)):
        for part in sorted(parts):
            found.setdefault(part, []).append(i)
    return found
