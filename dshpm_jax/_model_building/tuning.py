"""Every chosen number of model making, with what it does and what speaks for it."""

from dataclasses import dataclass

from dshpm_jax._numbers import number


@dataclass(frozen=True)
class ModelTuning:
    """The numbers by which a model is made of recordings; `TUNING` has those that are used.

    A *spread* without a unit is normalised (see `partition`). What each number is for stands in its metadata
    (`_numbers.numbers_of`).
    """

    # Distances of pairs over the recordings.
    max_frames: int = number(
        1000,
        unit="count",
        used="pair_statistics, build_neighbourhoods: frames taken of a recording at most",
        evidence="by hand: more say nothing new about a distance",
        group="statistics",
    )
    trimmed_share: float = number(
        0.01,
        unit="share",
        used="pair_statistics: the shortest and the longest distances of a pair that are left out, each",
        evidence="by hand: hand labels are wrong in a few frames of many public files",
        group="statistics",
    )
    few_frames: int = number(
        20,
        unit="count",
        used="pair_statistics: a pair seen in this many frames of a recording counts half as much as one always seen",
        evidence="by hand",
        group="statistics",
    )
    still_weight: float = number(
        0.1,
        unit="share of the weight of the liveliest recording",
        used="pair_statistics: least weight of a recording",
        evidence="by hand: a long static must not drown a short clip of motion",
        group="statistics",
    )
    lively_mm: float = number(
        40.0,
        unit="mm",
        used="pair_statistics: if the typical spread of a recording < this, its seconds count less, in proportion",
        evidence="by hand: a slow walk has this spread",
        group="statistics",
    )
    typical_quantile: float = number(
        0.75,
        unit="quantile",
        used="pair_statistics: of the spreads of all pairs, the one that says how much the subject moves",
        evidence="by hand",
        group="statistics",
    )

    # What bodies do in general, beside what the recordings show.
    general_mm: float = number(
        2.0,
        unit="mm",
        used="expected_spread, build_neighbourhoods: spread of two markers on skin, whatever their distance",
        evidence="by hand",
        group="general",
    )
    general_one_part: float = number(
        0.01,
        unit="share of the distance",
        used="expected_spread: spread of a pair if both sit on one part; build_neighbourhoods: what any distance "
        "changes between recordings",
        evidence="fitted: medians over public recordings of what was seen in motions that the model's own recording "
        "did not have; the script is not kept",
        group="general",
    )
    general_at_joint: float = number(
        0.025,
        unit="share of the distance",
        used="expected_spread: spread of a pair on one part if one sits at its joint or both on the trunk",
        evidence="fitted: as general_one_part",
        group="general",
    )
    general_soft: float = number(
        0.05,
        unit="share of the distance",
        used="expected_spread: spread of a pair on the trunk or an upper arm if one sits at the shoulder",
        evidence="fitted: as general_one_part",
        group="general",
    )
    general_across: float = number(
        0.10,
        unit="share of the distance",
        used="expected_spread: spread of a pair across a joint",
        evidence="fitted: as general_one_part",
        group="general",
    )
    general_far: float = number(
        0.20,
        unit="share of the distance",
        used="expected_spread: spread of a pair further apart than across a joint",
        evidence="fitted: as general_one_part",
        group="general",
    )
    general_unnamed: float = number(
        0.02,
        unit="share of the distance",
        used="expected_spread: spread of a pair if a name says no part of the body",
        evidence="fitted: as general_one_part",
        group="general",
    )
    general_seconds: float = number(
        1.5,
        unit="s of lively motion",
        used="expected_spread, build_neighbourhoods: weight of the general spread beside the learnt one",
        evidence="by hand",
        group="general",
    )

    # Neighbourhoods.
    min_marker_sd_mm: float = number(
        4.0,
        unit="mm",
        used="build_neighbourhoods: added to the error of a prediction, as squares",
        evidence="by hand: a short clip may predict a marker better than the next recording will",
        group="neighbourhoods",
    )
    kept_error_share: float = number(
        0.99,
        unit="share",
        used="build_neighbourhoods: frames whose prediction errors count, the least first",
        evidence="by hand: hand labels are wrong in a few frames",
        group="neighbourhoods",
    )

    # Groups of markers that do not overlap.
    skin_mm: float = number(
        4.0,
        unit="mm",
        used="normalised_spread: spread that markers of one bone show, whatever their distance",
        evidence="by hand: of this order",
        group="partition",
    )
    skin_share: float = number(
        0.03,
        unit="share of the distance",
        used="normalised_spread: spread that markers of one bone show, added to skin_mm as squares",
        evidence="by hand: of this order",
        group="partition",
    )
    reach_mm: float = number(
        400.0,
        unit="mm",
        used="normalised_spread: distance at which it is doubled",
        evidence="by hand: two markers far apart may keep their distance by chance",
        group="partition",
    )
    same_part: float = number(
        0.6,
        unit="factor",
        used="normalised_spread: of a pair whose names say one part of the body",
        evidence="by hand",
        group="partition",
    )
    next_part: float = number(
        1.5,
        unit="factor",
        used="normalised_spread: of a pair whose names say parts that meet",
        evidence="by hand",
        group="partition",
    )
    other_part: float = number(
        4.0,
        unit="factor",
        used="normalised_spread: of a pair whose names say parts that do not meet",
        evidence="by hand",
        group="partition",
    )
    unknown_spread: float = number(
        1.2,
        unit="normalised spread",
        used="normalised_spread: least one of a pair without evidence",
        evidence="by hand: such a pair is neither rigid nor not",
        group="partition",
    )
    still_spread: float = number(
        0.2,
        unit="normalised spread",
        used="normalised_spread: added to all, for two markers that never moved apart",
        evidence="by hand: so that distance and names have something to weigh",
        group="partition",
    )
    cut_low: float = number(
        0.9,
        unit="normalised spread",
        used="groups: if the mean one between two groups < this, they become one",
        evidence="by hand",
        group="partition",
    )
    cut_high: float = number(
        1.8,
        unit="normalised spread",
        used="groups: if the mean one between two groups > this, they stay two; up to this the widest gap decides",
        evidence="by hand",
        group="partition",
    )
    max_group: int = number(
        16,
        unit="count",
        used="groups, build_segments: markers of a segment at most",
        evidence="by hand: more make no better pose, and a match is as long as its largest segment",
        group="partition",
    )
    move_factor: float = number(
        0.8,
        unit="factor",
        used="groups: if a marker's mean spread to another group < this times that to its own, it moves there",
        evidence="by hand",
        group="partition",
    )
    move_rounds: int = number(
        10,
        unit="count",
        used="groups: rounds in which single markers move, at most",
        evidence="by hand",
        group="partition",
    )

    # Segments that overlap.
    grow_size: int = number(
        4,
        unit="count",
        used="overlapping: if a segment has fewer markers than this, it takes in the most rigid others",
        evidence="by hand",
        group="overlap",
    )
    grow_spread: float = number(
        1.5,
        unit="normalised spread",
        used="overlapping: if a marker's mean one to a small segment > this, it is not taken in",
        evidence="by hand",
        group="overlap",
    )
    share_most: int = number(
        2,
        unit="count",
        used="overlapping: markers that two segments share at their joint, at most",
        evidence="by hand",
        group="overlap",
    )
    share_spread: float = number(
        1.2,
        unit="normalised spread",
        used="overlapping: if a marker's mean one to the other segment < this, the two may share it",
        evidence="by hand",
        group="overlap",
    )
    link_size: int = number(
        3,
        unit="count",
        used="overlapping: markers of a link between two segments, at most",
        evidence="derived: MIN_FIT_POINTS, which a pose needs",
        group="overlap",
    )
    link_spread: float = number(
        5.0,
        unit="normalised spread",
        used="overlapping: if a marker's mean one to a link > this, the link grows no more",
        evidence="by hand",
        group="overlap",
    )
    rigid_link: float = number(
        1.5,
        unit="normalised spread",
        used="overlapping: if that of a pair across two segments < this and its names say a part of its own, "
        "a link joins them",
        evidence="by hand",
        group="overlap",
    )
    merge_size: int = number(
        6,
        unit="count",
        used="overlapping: if two segments that share markers have more than this, they stay two",
        evidence="by hand",
        group="overlap",
    )
    merge_spread: float = number(
        1.65,
        unit="normalised spread",
        used="overlapping: if the mean one of both together < this, two segments become one",
        evidence="by hand",
        group="overlap",
    )
    closeness_pairs: int = number(
        3,
        unit="count",
        used="closeness: most rigid pairs between two groups whose mean says how near they are",
        evidence="by hand",
        group="overlap",
    )

    # Segments as the model has them.
    object_turn_degrees: float = number(
        30.0,
        unit="degrees",
        used="_turns: if markers of unknown names keep their distances and turn together by more, they are one rigid "
        "object",
        evidence="by hand: who stands for a static does not turn",
        group="segments",
    )
    still_mm: float = number(
        8.0,
        unit="mm",
        used="is_still: if the spread of still_share of the pairs < this, the recordings show no motion",
        evidence="by hand",
        group="segments",
    )
    still_share: float = number(
        0.9,
        unit="share",
        used="is_still: of the pairs, see still_mm",
        evidence="by hand",
        group="segments",
    )
    known_names: float = number(
        0.8,
        unit="share",
        used="build_segments: if fewer names than this are known, a still recording gives no segments",
        evidence="by hand",
        group="segments",
    )
    distortion_factor: float = number(
        3.0,
        unit="factor",
        used="build_segments: distortion ratio of a segment, over its typical spread",
        evidence="by hand",
        group="segments",
    )
    ratio_low: float = number(
        0.05,
        unit="share",
        used="build_segments: least distortion ratio",
        evidence="paper",
        group="segments",
    )
    ratio_high: float = number(
        0.2,
        unit="share",
        used="build_segments: largest distortion ratio",
        evidence="paper",
        group="segments",
    )
    quantity_low: float = number(
        0.8,
        unit="share",
        used="build_segments: matching quantity at ratio_low",
        evidence="paper",
        group="segments",
    )
    quantity_high: float = number(
        0.9,
        unit="share",
        used="build_segments: matching quantity at ratio_high",
        evidence="paper",
        group="segments",
    )
    split_shares: int = number(
        3,
        unit="count",
        used="build_segments: markers that neighbouring strips of a split segment share",
        evidence="derived: MIN_FIT_POINTS, which a pose needs",
        group="segments",
    )
    max_joint_spread_mm: float = number(
        40.0,
        unit="mm",
        used="build_segments: if the recordings place a joint's centre worse than this, it is none",
        evidence="by hand",
        group="segments",
    )

    # Shapes and the centres of joints.
    shape_frames: int = number(
        400,
        unit="count",
        used="mean_shape, build_segments: frames that a shape and a joint are made from, at most",
        evidence="by hand",
        group="shapes",
    )
    shape_rounds: int = number(
        8,
        unit="count",
        used="mean_shape: rounds",
        evidence="by hand: it settles to a hundredth of a millimetre in fewer",
        group="shapes",
    )
    distance_rounds: int = number(
        100,
        unit="count",
        used="with_distances: rounds",
        evidence="by hand: what they still change are the loosest, by a millimetre",
        group="shapes",
    )
    nearest_to_joint: int = number(
        2,
        unit="count",
        used="build_segments: nearest markers in whose middle a joint is guessed",
        evidence="by hand",
        group="shapes",
    )
    joint_prior_mm: float = number(
        60.0,
        unit="mm",
        used="joint_centre: standard deviation of its place about the guess",
        evidence="by hand",
        group="shapes",
    )
    joint_noise_mm: float = number(
        8.0,
        unit="mm",
        used="joint_centre: standard deviation of a pose about a joint",
        evidence="by hand",
        group="shapes",
    )
    joint_frames: float = number(
        30.0,
        unit="count",
        used="joint_centre: independent frames that all frames together count as",
        evidence="by hand",
        group="shapes",
    )

    # Poses of a subject file.
    poses: int = number(
        400,
        unit="count",
        used="posed_clip: poses of the clip",
        evidence="by hand: the spreads of pairs settle to a few per cent",
        group="skeleton",
    )
    posed_seconds: float = number(
        3.0,
        unit="s of lively motion",
        used="model_from_skeleton: what the clip counts as",
        evidence="by hand: a recording of the subject's own would say more",
        group="skeleton",
    )
    loose_turn: float = number(
        2.5,
        unit="rad",
        used="posed_clip: standard deviation of a turn of which nothing is known",
        evidence="by hand",
        group="skeleton",
    )


TUNING = ModelTuning()
"""The numbers that are used."""
