"""What people do, as joint angles over time: standing, walking, running and freeform movement.

Angles are in degrees and anatomical: flexion, abduction, inward rotation; for the trunk forward, sideways, to the left.
The curves follow the usual shapes of gait analysis; they need not be exact, only to move each joint as a body does.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Float

from dshpm_jax.synthesis._curves import bump, integral, smooth

SEGMENTS = (
    *("pelvis", "thorax", "head"),
    *("left upper arm", "left forearm", "left hand", "right upper arm", "right forearm", "right hand"),
    *("left thigh", "left shank", "left foot", "right thigh", "right shank", "right foot"),
)
INDEX = {name: k for k, name in enumerate(SEGMENTS)}
SIDES = (("left", 0.0), ("right", 0.5))  # the right side is half a cycle behind

RESTLESSNESS = {  # standard deviation of what joints do beside the activity (degrees)
    **{"pelvis": (1.5, 1.5, 2.0), "thorax": (3.0, 2.0, 4.0), "head": (7.0, 4.0, 14.0)},
    **{"upper arm": (5.0, 3.0, 7.0), "forearm": (6.0, 0.0, 9.0), "hand": (5.0, 9.0, 0.0)},
    **{"thigh": (1.5, 0.6, 2.0), "shank": (1.5, 0.0, 1.5), "foot": (1.5, 1.5, 1.5)},
}


@dataclass(frozen=True, eq=False)
class Movement:
    """Joint angles and the way of the whole body.

    Attributes:
        angles: of each segment relative to its parent (degrees).
        speed: forwards (mm/s). turn: of the heading, to the left (degrees/s). flight: height over the ground (mm).
    """

    angles: Float[np.ndarray, "frames segments 3"]
    speed: Float[np.ndarray, "frames"]
    turn: Float[np.ndarray, "frames"]
    flight: Float[np.ndarray, "frames"]


@dataclass(frozen=True)
class Gait:
    """A cyclic gait: strides a second, mm/s, metres of the circle that is walked; then angles in degrees."""

    cadence: float
    speed: float
    radius: float
    hip: tuple[float, float]  # mean and swing
    knee: tuple[float, float, float]  # at rest, under load, in swing
    ankle: tuple[float, float, float]  # at heel strike, in mid-stance, at push-off
    arm: tuple[float, float, float]  # mean, swing and abduction
    elbow: tuple[float, float]  # mean and swing
    lean: float
    flight: float  # mm


WALKING = Gait(0.92, 1250.0, 2.0, (9, 21), (5, 12, 52), (-5, 11, -19), (2, 19, 14), (24, 10), 3, 0.0)
RUNNING = Gait(1.35, 3000.0, 3.5, (15, 30), (14, 24, 74), (4, 18, -24), (-8, 34, 17), (82, 14), 9, 70.0)


def activity(name: str, seconds: Float[np.ndarray, "frames"], rate: float, rng: np.random.Generator) -> Movement:
    """The motion of the activity `name` at the times `seconds`."""
    if name == "walking":
        return _restless(_gait(WALKING, seconds, rate, rng), seconds, rng, 0.7)
    if name == "running":
        return _restless(_gait(RUNNING, seconds, rate, rng), seconds, rng, 0.7)
    if name == "freeform":
        return _restless(_freeform(seconds, rate, rng), seconds, rng, 1.3)
    if name == "standing":
        return _restless(_still(len(seconds)), seconds, rng, 0.1)
    raise ValueError(f"unknown activity {name!r}: choose standing, walking, running or freeform")


def _still(frames: int) -> Movement:
    """Standing with the arms a little away from the body, to be filled in by a movement."""
    angles = np.zeros((frames, len(SEGMENTS), 3))
    for side, _ in SIDES:
        angles[:, INDEX[f"{side} upper arm"], 1] = 14
        angles[:, INDEX[f"{side} forearm"]] = (12, 0, 20)
        angles[:, INDEX[f"{side} thigh"], 1] = 2
    return Movement(angles, np.zeros(frames), np.zeros(frames), np.zeros(frames))


def _restless(motion: Movement, seconds, rng: np.random.Generator, amount: float) -> Movement:
    """Adds what joints do beside the activity; nobody repeats a cycle exactly."""
    size = np.array([RESTLESSNESS[name.removeprefix("left ").removeprefix("right ")] for name in SEGMENTS])
    # two standard deviations at most: a rare sum of all waves would break a joint
    wander = 2 * np.tanh(smooth(rng, seconds, 0.7, size.shape) / 2)
    return Movement(motion.angles + amount * size * wander, motion.speed, motion.turn, motion.flight)


def _gait(gait: Gait, seconds, rate: float, rng: np.random.Generator) -> Movement:
    """Walking or running round a circle that wanders."""
    motion = _still(len(seconds))
    cycle = rng.uniform() + integral(gait.cadence * (1 + 0.04 * smooth(rng, seconds, 0.3)), rate)
    vigour = 1 + 0.07 * smooth(rng, seconds, 0.3)
    for side, delay in SIDES:
        _leg(gait, motion.angles, side, cycle - delay, vigour)
        _arm(gait, motion.angles, side, cycle - delay, vigour)
    _trunk(gait, motion.angles, cycle)
    motion.speed[:] = gait.speed * vigour
    motion.turn[:] = np.rad2deg(gait.speed / 1000 / gait.radius) * (1 + 0.25 * smooth(rng, seconds, 0.3))
    motion.flight[:] = gait.flight * (bump(cycle, 0.43, 0.06) + bump(cycle, 0.93, 0.06))
    return motion


def _leg(gait: Gait, angles, side: str, cycle, vigour) -> None:
    """One leg over a cycle that begins with its heel strike."""
    at_rest, loaded, swinging = gait.knee
    strike, stance, push = gait.ankle
    wave = np.cos(2 * np.pi * (cycle - 0.02))
    thigh, shank, foot = (INDEX[f"{side} {name}"] for name in ("thigh", "shank", "foot"))
    angles[:, thigh, 0] = gait.hip[0] + gait.hip[1] * vigour * wave
    angles[:, thigh, 1] = 0.5 + 2.5 * np.sin(2 * np.pi * (cycle - 0.4))
    angles[:, thigh, 2] = 4 * np.sin(2 * np.pi * cycle)
    angles[:, shank, 0] = at_rest + loaded * bump(cycle, 0.14, 0.06) + swinging * vigour * bump(cycle, 0.72, 0.1)
    bends = strike * bump(cycle, 0.07, 0.04) + stance * bump(cycle, 0.40, 0.11) + push * bump(cycle, 0.62, 0.07)
    angles[:, foot, 0] = 2 + bends
    angles[:, foot, 1] = 4 * np.sin(2 * np.pi * (cycle - 0.2))


def _arm(gait: Gait, angles, side: str, cycle, vigour) -> None:
    """One arm, against the leg of its side."""
    mean, swing, abduction = gait.arm
    wave = -np.cos(2 * np.pi * cycle)
    angles[:, INDEX[f"{side} upper arm"], 0] = mean + swing * vigour * wave
    angles[:, INDEX[f"{side} upper arm"], 1] = abduction + 2 * np.sin(2 * np.pi * cycle)
    angles[:, INDEX[f"{side} forearm"], 0] = gait.elbow[0] + gait.elbow[1] * vigour * np.cos(2 * np.pi * (cycle - 0.55))
    angles[:, INDEX[f"{side} forearm"], 2] = 20 + 6 * wave
    angles[:, INDEX[f"{side} hand"], 1] = 5 * np.sin(2 * np.pi * (cycle - 0.1))


def _trunk(gait: Gait, angles, cycle) -> None:
    """Pelvis and thorax turn against each other, the head looks ahead."""
    sway = np.sin(2 * np.pi * cycle)
    angles[:, INDEX["pelvis"]] = np.stack(
        [4 + 1.5 * np.sin(4 * np.pi * cycle), 4 * np.sin(2 * np.pi * (cycle - 0.12)), -5 * np.cos(2 * np.pi * cycle)],
        -1,
    )
    angles[:, INDEX["thorax"]] = np.stack([gait.lean - 4 + 0 * sway, -3 * sway, 11 * np.cos(2 * np.pi * cycle)], -1)
    angles[:, INDEX["head"]] = np.stack(
        [-gait.lean + 1.5 * np.sin(4 * np.pi * cycle), sway, -6 * np.cos(2 * np.pi * cycle)], -1
    )


def _freeform(seconds, rate: float, rng: np.random.Generator) -> Movement:
    """Walking, jumping, bending, turning on the spot and swinging the arms, one after the other in random order."""
    slow = Gait(0.85, 850.0, 1.5, (10, 19), *(getattr(WALKING, f.name) for f in fields(Gait)[4:]))
    movements = [
        _gait(slow, seconds, rate, rng),
        _jumping(seconds, rng),
        _bending(seconds, rng),
        _turning(seconds, rate, rng),
        _swinging(seconds, rng),
    ]
    return _mixed(movements, _turns(rng, seconds, len(movements)))


def _mixed(motions: Sequence[Movement], weights: Float[np.ndarray, "frames movements"]) -> Movement:
    """The weighted mean of several motions."""
    mixed = {
        f.name: np.einsum("tk,kt...->t...", weights, np.stack([getattr(m, f.name) for m in motions]))
        for f in fields(Movement)
    }
    return Movement(**mixed)


def _turns(rng: np.random.Generator, seconds, count: int) -> Float[np.ndarray, "frames movements"]:
    """Whose turn it is: each movement once before any comes again, for 1.4 to 2.4 s, crossing over in half a second."""
    weights = np.zeros((len(seconds), count))
    begin = -rng.uniform(0, 1)
    while begin < seconds[-1] + 1:
        for which in rng.permutation(count):
            end = begin + rng.uniform(1.4, 2.4)
            weights[:, which] += _rise(seconds - begin) - _rise(seconds - end)
            begin = end
    weights[:, 0] += np.maximum(0, 1 - weights.sum(-1))  # before the first turn has come up
    return weights


def _rise(seconds):
    """From 0 to 1 within half a second, smoothly."""
    x = np.clip(seconds / 0.5 + 0.5, 0, 1)
    return x * x * (3 - 2 * x)


def _jumping(seconds, rng: np.random.Generator) -> Movement:
    """Jumps on both feet, the arms thrown up."""
    motion = _still(len(seconds))
    cycle = rng.uniform() + seconds / 1.5
    crouch = bump(cycle, 0.28, 0.075) + 0.7 * bump(cycle, 0.72, 0.07)
    air = bump(cycle, 0.5, 0.065)
    for side, _ in SIDES:
        motion.angles[:, INDEX[f"{side} thigh"], 0] = 4 + 56 * crouch + 6 * air
        motion.angles[:, INDEX[f"{side} thigh"], 1] = 4 + 4 * crouch
        motion.angles[:, INDEX[f"{side} shank"], 0] = 5 + 78 * crouch + 8 * air
        motion.angles[:, INDEX[f"{side} foot"], 0] = 2 + 26 * crouch - 32 * air
        motion.angles[:, INDEX[f"{side} upper arm"], 0] = (
            8 - 38 * bump(cycle, 0.25, 0.09) + 115 * bump(cycle, 0.5, 0.09)
        )
        motion.angles[:, INDEX[f"{side} upper arm"], 1] = 18 + 8 * air
        motion.angles[:, INDEX[f"{side} forearm"], 0] = 25 + 25 * crouch
    motion.angles[:, INDEX["pelvis"], 0] = 3 + 14 * crouch
    motion.angles[:, INDEX["thorax"], 0] = 2 + 16 * crouch - 6 * air
    motion.angles[:, INDEX["head"], 0] = -18 * crouch
    motion.flight[:] = 260 * air
    return motion


def _bending(seconds, rng: np.random.Generator) -> Movement:
    """Bends down, a little to one side, and reaches for the ground."""
    motion = _still(len(seconds))
    cycle = rng.uniform() + seconds / 2.6
    down = bump(cycle, 0.5, 0.13)
    aside = 12 * np.sin(2 * np.pi * cycle / 2)
    for side, sign in (("left", 1), ("right", -1)):
        motion.angles[:, INDEX[f"{side} thigh"], 0] = 3 + 44 * down
        motion.angles[:, INDEX[f"{side} thigh"], 1] = 3
        motion.angles[:, INDEX[f"{side} shank"], 0] = 4 + 32 * down
        motion.angles[:, INDEX[f"{side} foot"], 0] = 2 + 14 * down
        motion.angles[:, INDEX[f"{side} upper arm"], 0] = 6 + (68 + sign * aside) * down
        motion.angles[:, INDEX[f"{side} upper arm"], 1] = 16 + 6 * down
        motion.angles[:, INDEX[f"{side} hand"], 1] = -12 * down
    motion.angles[:, INDEX["pelvis"], 0] = 3 + 30 * down
    motion.angles[:, INDEX["thorax"]] = np.stack([2 + 38 * down, aside * down, aside], -1)
    motion.angles[:, INDEX["head"]] = np.stack([-22 * down, 0 * down, -aside], -1)
    return motion


def _turning(seconds, rate: float, rng: np.random.Generator) -> Movement:
    """Turns on the spot in small steps, the arms half raised."""
    steps = Gait(1.1, 150.0, 1.0, (8, 9), (6, 4, 34), (0, 4, -8), (22, 8, 30), (35, 6), 2, 0.0)
    motion = _gait(steps, seconds, rate, rng)
    motion.turn[:] = rng.choice([-1, 1]) * (110 + 35 * np.tanh(smooth(rng, seconds, 0.4)))
    motion.angles[:, INDEX["head"], 2] += 0.15 * motion.turn
    return motion


def _swinging(seconds, rng: np.random.Generator) -> Movement:
    """Stands with bending knees and swings both arms wide, each in its own time."""
    motion = _still(len(seconds))
    for side, _ in SIDES:
        cycle = rng.uniform() + seconds * rng.uniform(0.5, 0.8)
        wave, cross = np.sin(2 * np.pi * cycle), np.cos(2 * np.pi * cycle)
        motion.angles[:, INDEX[f"{side} upper arm"]] = np.stack([45 + 62 * wave, 52 + 26 * cross, 14 * cross], -1)
        motion.angles[:, INDEX[f"{side} forearm"]] = np.stack([38 + 28 * cross, 0 * wave, 20 + 30 * wave], -1)
        motion.angles[:, INDEX[f"{side} hand"]] = np.stack([8 * wave, 22 * cross, 0 * wave], -1)
    beat = 0.5 + 0.5 * np.sin(2 * np.pi * seconds * rng.uniform(0.6, 0.9))
    for side, _ in SIDES:
        motion.angles[:, INDEX[f"{side} thigh"], :2] = np.stack([4 + 16 * beat, 6 + 2 * beat], -1)
        motion.angles[:, INDEX[f"{side} shank"], 0] = 5 + 28 * beat
        motion.angles[:, INDEX[f"{side} foot"], 0] = 2 + 12 * beat
    motion.angles[:, INDEX["thorax"]] = np.stack(
        [3 + 4 * beat, 8 * smooth(rng, seconds, 0.5), 16 * smooth(rng, seconds, 0.5)], -1
    )
    return motion
