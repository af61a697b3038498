"""A rigid robot arm of six joints and a hand of sixteen segments."""

import numpy as np

from dshpm_jax._types import NO_PARENT
from dshpm_jax.synthesis._curves import rotations, smooth
from dshpm_jax.synthesis._figure import Figure, FigureBone, Marker, Synthetic, capture

ROBOT_NOISE = 0.1  # mm
ROBOT_SIZE_STEP = 0.15  # relative size between one robot and the next
Y, X, Z = 0, 1, 2  # order of the turns in `rotations`

# link, parent, joint in the parent (mm), axis of the joint, its middle and reach (degrees)
LINKS = (
    ("base", NO_PARENT, (0, 0, 0), Z, 0, 0),
    ("shoulder", 0, (0, 0, 200), Z, 0, 110),
    ("upper arm", 1, (0, 0, 150), Y, 20, 45),
    ("forearm", 2, (0, 0, 450), Y, 65, 40),
    ("wrist 1", 3, (0, 0, 200), Z, 0, 100),
    ("wrist 2", 4, (0, 0, 230), Y, 25, 55),
    ("tool", 5, (0, 0, 110), Z, 0, 120),
)
LINK_MARKERS = (  # angle about the link (degrees), distance from it and height along it (mm)
    ((10, 170, 20), (95, 150, 55), (200, 165, 30), (300, 155, 90)),
    ((20, 115, 70), (130, 120, 100), (250, 110, 50)),
    ((35, 80, 90), (150, 75, 190), (240, 85, 300), (330, 78, 370)),
    ((20, 70, 50), (140, 75, 100), (260, 72, 150)),
    ((60, 62, 50), (170, 66, 110), (300, 60, 160)),
    ((15, 58, 40), (150, 62, 60), (265, 56, 75)),
    ((40, 60, 40), (130, 85, 60), (215, 55, 95), (320, 75, 75)),
)

FINGERS = {  # knuckle in the palm's frame (mm), lengths of the three bones (mm), spread and fold at rest (degrees)
    "thumb": ((28, 34, -14), (44, 34, 27), 48, 8),
    "index": ((92, 33, 0), (46, 28, 22), 9, 18),
    "middle": ((95, 10, 3), (51, 32, 23), 2, 18),
    "ring": ((90, -13, 1), (47, 30, 23), -5, 20),
    "little": ((82, -35, -4), (37, 22, 20), -13, 20),
}
BONES_OF_A_FINGER = ("proximal", "middle", "distal")


def robot_arm(frames: int = 600, rate: float = 60.0, subject: int = 0, seed: int = 0) -> Synthetic:
    """A robot arm on a fixed base, seven rigid links with three or four markers each, nothing shared.

    Arguments:
        frames, rate: length of the take and frames a second.
        subject: changes its size.
        seed: its programme.
    """
    size = 1 + ROBOT_SIZE_STEP * subject
    seconds = np.arange(frames) / rate
    movement, camera = np.random.default_rng([seed, 3]).spawn(2)
    degrees = np.zeros((frames, len(LINKS), 3))
    for k, (_, _, _, axis, middle, reach) in enumerate(LINKS):
        degrees[:, k, axis] = middle + reach * np.tanh(smooth(movement, seconds, 0.35))
    bones = tuple(FigureBone(name, parent, _times(size, joint)) for name, parent, joint, *_ in LINKS)
    figure = Figure(bones, _link_markers(size))
    root = np.zeros((frames, 3))
    return capture(figure, rotations(degrees), root, rate, ROBOT_NOISE, np.random.default_rng(subject), camera)


def _times(size: float, place) -> tuple[float, float, float]:
    x, y, z = place
    return size * x, size * y, size * z


def _link_markers(size: float) -> tuple[Marker, ...]:
    found = []
    for k, places in enumerate(LINK_MARKERS):
        for n, (angle, distance, height) in enumerate(places):
            x, y = distance * np.cos(np.deg2rad(angle)), distance * np.sin(np.deg2rad(angle))
            found.append(Marker(f"{LINKS[k][0].replace(' ', '_')}_{n + 1}", k, _times(size, (x, y, height))))
    return tuple(found)


def hand(frames: int = 600, rate: float = 60.0, subject: int = 0, seed: int = 0) -> Synthetic:
    """A hand of a palm and five fingers of three bones: 28 small markers, those over the joints shared.

    Its markers are as near as 15 mm to each other, and ten bones have two only: the hard end of what can be labelled.
    The palm's frame: x to the finger tips, y to the thumb, z out of the back of the hand.

    Arguments:
        frames, rate: length of the take and frames a second.
        subject: whose hand it is, from 0.
        seed: of the take.
    """
    rng = np.random.default_rng([subject, 4])
    size = 1.0 if subject == 0 else rng.uniform(0.9, 1.15)
    seconds = np.arange(frames) / rate
    movement, camera = np.random.default_rng([seed, 5]).spawn(2)
    bones, markers = _hand(size, rng)
    root = np.array([0, 0, 1000.0]) + 150 * smooth(movement, seconds, 0.4, (3,))
    relative = rotations(_grips(seconds, movement))
    return capture(Figure(bones, markers), relative, root, rate, ROBOT_NOISE, rng, camera)


def _hand(size: float, rng: np.random.Generator) -> tuple[tuple[FigureBone, ...], tuple[Marker, ...]]:
    bones = [FigureBone("palm", NO_PARENT, (0.0, 0.0, 0.0))]
    places: list[tuple[str, int, tuple[float, float, float], bool]] = [
        ("wrist_radial", 0, (4.0, 24.0, 8.0), False),
        ("wrist_ulnar", 0, (0.0, -24.0, 8.0), False),
        ("back", 0, (48.0, -6.0, 16.0), False),
    ]
    for finger, (knuckle, lengths, *_) in FINGERS.items():
        first, (proximal, middle, distal) = len(bones), lengths
        joints = (knuckle, (proximal, 0, 0), (middle, 0, 0))
        for k, (bone, joint) in enumerate(zip(BONES_OF_A_FINGER, joints, strict=True)):
            bones.append(FigureBone(f"{finger} {bone}", first + k - 1 if k else 0, _times(size, joint)))
            places.append((f"{finger}_{k + 1}", first + k, (0, 0, 10), True))
        places.append((f"{finger}_shaft", first, (proximal / 2, 2, 13), False))
        places.append((f"{finger}_tip", first + 2, (distal - 4, 0, 8), False))
    markers = [
        Marker(name, bone, _times(1, np.array(place) * size + rng.normal(0, 0.7, 3)), 1.0, shared)
        for name, bone, place, shared in places
    ]
    return tuple(bones), tuple(markers)


def _grips(seconds, rng: np.random.Generator):
    """Turns of every bone: fingers that fold each in its own time, and a hand that points here and there (degrees)."""
    degrees = np.zeros((len(seconds), 1 + 3 * len(FINGERS), 3))
    degrees[:, 0] = np.array([30, 35, 50]) * np.tanh(smooth(rng, seconds, 0.4, (3,)))
    together = smooth(rng, seconds, 0.5)
    for f, (_, _, spread, fold) in enumerate(FINGERS.values()):
        own = np.tanh(0.6 * together + 0.6 * smooth(rng, seconds, 0.8))
        other = np.tanh(0.6 * together + 0.6 * smooth(rng, seconds, 0.8))
        first = 1 + 3 * f
        degrees[:, first, Y] = fold + 24 * own
        degrees[:, first, Z] = spread + 3 * np.tanh(smooth(rng, seconds, 0.8))
        degrees[:, first + 1, Y] = 32 + 26 * other
        degrees[:, first + 2, Y] = 0.6 * degrees[:, first + 1, Y]
    return degrees
