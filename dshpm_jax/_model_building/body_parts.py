"""What the names of common marker sets say about the body: the part that a marker sits on.

Covers Plug-in Gait, Helen Hayes and Cleveland names, the 41 and 53 markers of CMU and HDM05, OpenSim's gait sets and
the spelt-out names of Qualisys projects. A marker at a joint sits on both parts. Names are only ever a hint next to
motion, and the whole evidence where a recording shows no motion.
"""

import re
from collections.abc import Sequence

SIDED = {"shoulder", "upper arm", "forearm", "hand", "thigh", "shank", "foot"}
"""Parts that a body has twice; the others are one, whatever side a marker's name says."""

ADJACENT = {
    frozenset(pair)
    for pair in (
        ("head", "trunk"),
        ("trunk", "pelvis"),
        ("trunk", "upper arm"),
        ("upper arm", "forearm"),
        ("forearm", "hand"),
        ("pelvis", "thigh"),
        ("thigh", "shank"),
        ("shank", "foot"),
    )
}
"""Parts that meet at a joint."""

# A stem is a name in lower case without side and without `_`, `.`, `-` and blanks. The first pattern that matches the
# whole stem counts, so the particular ones come first.
_STEMS = (
    (r"(f|b|t|front|back|top|rear|lateral)?(hd|head)(\w|fl|fr|bl|br|front|back|top|rear)?\d?", "head"),
    (r"ariel|nose|chin|ear|temple|forehead|vertex|glabella|nasion", "head"),
    (r"hip[fb][lr]?", "pelvis"),
    (r"asis?|psis?|[fbm]wt|v?sacr(um|al)?|waist[lrfb]*|pelvis\d?|ic|iliac(crest)?|cri(st|sta)?|l[45]|s[12]", "pelvis"),
    (r"hip|troch(anter)?|gtr?o?|hjc", "pelvis thigh"),
    (r"c7|t\d+|l[123]|clav?|clavicle|strn|stern(um)?|xiph(oid)?|xp|man(ub(rium)?)?|ij|jn|px|neck", "trunk"),
    (r"bak|back|spine\w*|offset|chest", "trunk"),
    (r"scap\w*|thorax\d?|trunk\d?|bac|sternum\w*|upperback|lowerback", "trunk"),
    (r"[fbt]sh|sho\w?|shoulder\w*|acr\w*|shld\w*|sh", "trunk upper arm"),
    (r"(upa|upperarm|ua|uarm|arm|hum|humerus|bicep|tricep|deltoid|delt)\w?\d?", "upper arm"),
    (r"[iolm]?(elb?|elbow)(o?l|o?m|in|out|lat\w*|med\w*|inner|outer)?|[lm]el|melb|lelb|hle|hme", "upper arm forearm"),
    (r"(frm|fa|fore?arm|farm|lowerarm|rad|forearm\w*)\d?|fa(superior|radius|ulna)", "forearm"),
    (r"wre|[io]?wr[abiome]?|wrist\w*|radius|ulna|(rs|us)p?|wr(lat|med)|thumb\w*wrist", "forearm hand"),
    (r"(fin|finger|hand|hnd|thm|thumb|pink(ie|y)|index|knuckle|hm\d|mc\d|[io]hand)\w?\d?", "hand"),
    (r"(thi|thigh|th|thy|quad|hams|femur|thl|tha|thf)\w{0,2}\d?", "thigh"),
    (r"[iolm]?(knee?|kni|kn)(lat|med|l|m|in|out|inner|outer)?|[lm]epi|(fl|fm)e|pat(ella)?|[lm]fc", "thigh shank"),
    (r"(tib|tibia|tb|ti|shn|shank|shin|sk|calf|leg|fib|hf|tt|tto|tub)\w{0,3}\d?|sh\d|shank\w*", "shank"),
    (r"[iolm]?(ank?|ankle)(lat|med|l|m|in|out|inner|outer)?|[lm]?mal|mankle|(fa|ta)m|[lm]malleolus", "shank foot"),
    (r"(heel?|hel|calc?|calcn|calcaneus|(big|little|small|pink(ie|y))?toe)(lat|med|tip)?\d?", "foot"),
    (r"mt\d?|p?\d(mt|met|meta|mtp?)|mf\w|mtp?\d|met\d", "foot"),
    (r"(d1m|d5m|fcc|vm1|vm5|smh|fmh|vmh|dmt\d|foot|big|hallux|nav|st|pt)\w?\d?", "foot"),
)
_PATTERNS = tuple((re.compile(pattern), tuple(re.split(r" (?!arm)", parts))) for pattern, parts in _STEMS)


_PINKIE = re.compile(r"pink(ie|y)(?!toe)")
_BIG_TOE, _OTHER_FINGER = re.compile(r"(bigtoe|big|hallux)\w?\d?"), re.compile(r"(thm|thumb|index)\w?\d?")


def parts_of_each(labels: Sequence[str]) -> list[frozenset[str]]:
    """The parts of each name of a marker set (see `parts_of`), in which one name may say what another means.

    A "pinkie" is a little finger, but a little toe in a set that names a big toe and no other finger by its name.
    """
    stems = {stem for label in labels for _, stem in _readings(label)}
    toes = any(map(_BIG_TOE.fullmatch, stems)) and not any(map(_OTHER_FINGER.fullmatch, stems))
    return [parts_of(label, toes) for label in labels]


def parts_of(label: str, pinkie_is_toe: bool = False) -> frozenset[str]:
    """The parts of the body that a marker of this name sits on (`"left thigh"`); empty where the name says nothing."""
    for side, stem in _readings(label):
        stem = _PINKIE.sub("pinkietoe", stem) if pinkie_is_toe else stem
        for pattern, parts in _PATTERNS:
            if pattern.fullmatch(stem):
                sided = [part for part in parts if part in SIDED]
                if sided and not side:
                    return frozenset(part for part in parts if part not in SIDED)
                return frozenset(f"{side} {part}" if part in SIDED else part for part in parts)
    return frozenset()


def _readings(label: str) -> list[tuple[str, str]]:
    """Ways to read a name as a side and a stem, the surest first."""
    name = label.strip().lower()
    sides = {"l": "left", "left": "left", "r": "right", "right": "right"}
    found = []
    if match := re.fullmatch(r"(left|right|[lr](?=[_. -]))[_. -]*(.+)", name):
        found.append((sides[match[1]], match[2]))
    if match := re.fullmatch(r"(.+?)(?:[_. -](l|r)|[_. -]*(left|right))(\d*)", name):
        found.append((sides[match[2] or match[3]], match[1] + match[4]))
    if name[:1] in ("l", "r"):
        found.append((sides[name[0]], name[1:]))
    found.append(("", name))
    return [(side, re.sub(r"[_. -]", "", stem)) for side, stem in found if stem]


def meet(one: str, other: str) -> bool:
    """Whether two parts are the same side of a body and share a joint."""
    first, second = _split(one), _split(other)
    sides = {first[0], second[0]} - {""}
    return len(sides) < 2 and frozenset((first[1], second[1])) in ADJACENT


def _split(part: str) -> tuple[str, str]:
    side, _, bare = part.partition(" ")
    return (side, bare) if side in ("left", "right") else ("", part)


def recognised(labels: Sequence[str]) -> float:
    """Share of the names that say a part of the body."""
    return sum(map(bool, parts_of_each(labels))) / max(len(labels), 1)
