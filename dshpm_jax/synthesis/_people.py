"""People of 15 segments with as many markers as the paper's: 27, 34 or 49 (section 5.1), 30 or 50 (section 5.2).

World and neutral pose: x forwards, y to the left, z up; standing upright, arms down, palms to the body.
"""

import numpy as np
from jaxtyping import Float

from dshpm_jax._types import NO_PARENT
from dshpm_jax.synthesis._activities import INDEX, SEGMENTS, Movement, activity
from dshpm_jax.synthesis._curves import integral, rotations, smooth, turn_about
from dshpm_jax.synthesis._figure import Figure, FigureBone, Marker, Synthetic, capture, pose

NOISE = 0.3  # mm
PLACEMENT = 3.0  # mm, how exactly markers are put on
SOLE = ((-50.0, 0.0, -75.0), (175.0, 0.0, -75.0))  # heel and tip of a foot, from the ankle (mm)
CONTACT = 12.0  # mm, how softly the lowest of heels and tips stands on the ground

MIDDLE_BONES = (("pelvis", "", (0, 0, 0)), ("thorax", "pelvis", (-20, 0, 100)), ("head", "thorax", (-10, 0, 480)))
SIDE_BONES = (  # of the left side; parents without a side are in the middle
    ("upper arm", "thorax", (0, 180, 420)),
    ("forearm", "upper arm", (0, 0, -290)),
    ("hand", "forearm", (0, 0, -255)),
    ("thigh", "pelvis", (0, 92, 0)),
    ("shank", "thigh", (0, 0, -430)),
    ("foot", "shank", (0, 0, -415)),
)

# name, segment, place (mm), softness (mm), shared with the segment's parent, the smallest protocol that has it
MIDDLE_MARKERS = (
    ("C7", "thorax", (-68, 4, 465), 4.0, False, 27),
    ("T10", "thorax", (-112, -6, 250), 5.0, False, 27),
    ("CLAV", "thorax", (72, 5, 405), 4.0, False, 27),
    ("SACR", "pelvis", (-98, 3, 62), 5.0, False, 27),
    ("STRN", "thorax", (112, -6, 255), 6.0, False, 49),
    ("RBAK", "thorax", (-118, -88, 345), 8.0, False, 49),
    ("TOPH", "head", (5, 14, 228), 1.5, False, 49),
    ("LBAK", "thorax", (-122, 74, 150), 8.0, False, 50),
)
SIDE_MARKERS = (  # of the left side, without the letter of the side
    ("FHD", "head", (96, 72, 128), 1.5, False, 27),
    ("BHD", "head", (-88, 60, 152), 1.5, False, 34),
    ("SHO", "upper arm", (0, 30, 42), 10.0, True, 27),
    ("UPA", "upper arm", (-14, 50, -140), 8.0, False, 34),
    ("ELB", "forearm", (0, 42, 0), 4.0, True, 27),
    ("WRA", "hand", (34, 5, 0), 3.0, True, 27),
    ("WRB", "hand", (-30, 8, 0), 3.0, True, 30),
    ("FIN", "hand", (20, 16, -86), 2.0, False, 27),  # on the second knuckle, as usual
    ("HIP", "thigh", (0, 76, -8), 8.0, True, 27),
    ("THI", "thigh", (26, 78, -215), 17.0, False, 27),
    ("KNE", "shank", (0, 56, 0), 6.0, True, 27),
    ("TIB", "shank", (36, 46, -185), 6.0, False, 30),
    ("ANK", "foot", (0, 42, -4), 3.0, True, 27),
    ("HEE", "foot", (-56, 0, -44), 2.0, False, 27),
    ("TOE", "foot", (130, -8, -38), 2.0, False, 27),
    ("ASI", "pelvis", (86, 118, 76), 6.0, False, 49),
    ("MEL", "forearm", (0, -38, 0), 4.0, True, 49),
    ("FRM", "forearm", (24, 30, -110), 5.0, False, 49),
    ("MKN", "shank", (0, -46, 0), 6.0, True, 49),
    ("MAN", "foot", (0, -35, 4), 3.0, True, 49),
    ("MT5", "foot", (92, 50, -46), 2.0, False, 49),
)
SPARSE_HEAD = ("BHD", "head", (-100, 22, 150), 1.5, False, 27)  # stands for LBHD and RBHD
PROTOCOLS = (27, 30, 34, 49, 50)
LEFT_OUT = {30: ("T10",), 34: ("BHD",), 49: ("BHD",), 50: ("BHD",)}  # though a smaller protocol has it

# from anatomical angles to turns about y, x and z; the second and third change sign on the right
FLEXES_BACK = {"pelvis", "thorax", "head", "shank"}  # flexion that turns from z to x


def person(
    markers: int = 34, activity: str = "walking", frames: int = 600, rate: float = 60.0, subject: int = 0, seed: int = 0
) -> Synthetic:
    """A person in motion.

    Arguments:
        markers: 27, 30, 34, 49 or 50.
        activity: "standing", "walking", "running" or "freeform".
        frames, rate: length of the take and frames a second.
        subject: whose body it is, from 0: lengths of the segments, places of the markers, softness.
        seed: of the take: how the person moves, how the soft tissue swings, measurement noise.
    """
    if markers not in PROTOCOLS:
        raise ValueError(f"no protocol of {markers} markers: choose one of {PROTOCOLS}")
    if frames < 1 or rate <= 0:
        raise ValueError(f"got {frames} frames at {rate} Hz: ask for one frame or more at a positive rate")
    figure = _subject(markers, subject)
    movement, tissue = np.random.default_rng([seed, 1]).spawn(2)
    relative, root = _move(figure, activity, frames, rate, movement)
    return capture(figure, relative, root, rate, NOISE, np.random.default_rng([subject, markers, 2]), tissue)


def _subject(markers: int, subject: int) -> Figure:
    """The figure of one subject: the reference body, scaled by segment, with markers put on by hand."""
    body, putting_on = np.random.default_rng([subject, 0]), np.random.default_rng([subject, markers, 1])
    scale = _scales(body, subject)
    bones = tuple(_scaled(bone, scale) for bone in _bones())
    worn = [m for m, least in _markers() if least <= markers and m.name not in LEFT_OUT.get(markers, ())]
    placed = tuple(_put_on(marker, scale[marker.bone], putting_on) for marker in worn)
    return Figure(bones, placed)


def _scales(rng: np.random.Generator, subject: int) -> Float[np.ndarray, "segments"]:
    """How much larger each segment is than the reference; both sides nearly alike; subject 0 is the reference."""
    if subject == 0:
        return np.ones(len(SEGMENTS))
    build = rng.uniform(0.88, 1.1)
    kinds = {name.split(" ", 1)[-1] if " " in name else name: rng.normal(1, 0.035) for name in SEGMENTS}
    sides = rng.normal(1, 0.004, len(SEGMENTS))
    return build * sides * np.array([kinds[n.split(" ", 1)[-1] if " " in n else n] for n in SEGMENTS])


def _scaled(bone: FigureBone, scale: Float[np.ndarray, "segments"]) -> FigureBone:
    """`bone` on a larger or smaller parent."""
    size = 1.0 if bone.parent == NO_PARENT else scale[bone.parent]
    x, y, z = bone.offset
    return bone._replace(offset=(x * size, y * size, z * size))


def _put_on(marker: Marker, scale: float, rng: np.random.Generator) -> Marker:
    """`marker` on a segment of another size, some millimetres from where it should be."""
    x, y, z = np.array(marker.place) * scale + rng.normal(0, PLACEMENT, 3).clip(-2 * PLACEMENT, 2 * PLACEMENT)
    return marker._replace(place=(float(x), float(y), float(z)))


def _bones() -> tuple[FigureBone, ...]:
    """The reference body, in the order of `SEGMENTS`."""
    found = {name: (parent, offset) for name, parent, offset in MIDDLE_BONES}
    for name, parent, (x, y, z) in SIDE_BONES:
        for side, sign in (("left", 1), ("right", -1)):
            found[f"{side} {name}"] = (parent if parent in found else f"{side} {parent}", (x, sign * y, z))
    return tuple(FigureBone(n, INDEX[found[n][0]] if found[n][0] else NO_PARENT, found[n][1]) for n in SEGMENTS)


def _markers() -> list[tuple[Marker, int]]:
    """Every marker of the reference body with the smallest protocol that has it."""
    found = []
    for name, segment, place, softness, shared, least in (*MIDDLE_MARKERS, SPARSE_HEAD):
        found.append((Marker(name, INDEX[segment], place, softness, shared), least))
    for name, segment, (x, y, z), softness, shared, least in SIDE_MARKERS:
        for letter, side, sign in (("L", "left", 1), ("R", "right", -1)):
            bone = INDEX[segment] if segment in INDEX else INDEX[f"{side} {segment}"]
            found.append((Marker(letter + name, bone, (x, sign * y, z), softness, shared), least))
    return sorted(found, key=lambda one: one[0].bone)


def _move(figure: Figure, name: str, frames: int, rate: float, rng: np.random.Generator):
    """Rotations relative to the parents, and the way of the pelvis (mm)."""
    seconds = np.arange(frames) / rate
    motion = activity(name, seconds, rate, rng)
    relative = rotations(motion.angles * _signs())
    heading = rng.uniform(0, 360) + integral(motion.turn, rate)
    relative[:, 0] = turn_about(2, heading) @ relative[:, 0]
    root = _way(motion, heading, rate) + np.append(20 * smooth(rng, seconds, 0.5, (2,)), np.zeros((frames, 1)), axis=1)
    root[:, 2] = _height(figure, relative, root) + motion.flight
    return relative, root


def _signs() -> Float[np.ndarray, "segments 3"]:
    """Signs that turn anatomical angles into right-handed turns about y, x and z."""
    found = np.ones((len(SEGMENTS), 3))
    for name, row in zip(SEGMENTS, found, strict=True):
        row[0] = 1 if name.split(" ")[-1] in FLEXES_BACK else -1
        if name.startswith("left"):
            row[1:] = (1, -1)
        elif name.startswith("right"):
            row[1:] = (-1, 1)
    return found


def _way(motion: Movement, heading, rate: float) -> Float[np.ndarray, "frames 3"]:
    """Where the heading and the speed lead, about the origin of the room (mm)."""
    angle = np.deg2rad(heading)
    velocity = motion.speed[:, None] * np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], -1)
    return integral(velocity, rate)


def _height(figure: Figure, relative, root) -> Float[np.ndarray, "frames"]:
    """The height of the pelvis at which the lowest of heels and tips stands on the ground (mm)."""
    turned, positions = pose(figure, relative, root * (1, 1, 0))
    ends = [
        positions[:, foot, 2] + turned[:, foot, 2] @ np.array(end)
        for foot in (INDEX["left foot"], INDEX["right foot"])
        for end in SOLE
    ]
    return CONTACT * np.log(np.exp(-np.stack(ends) / CONTACT).sum(0))
