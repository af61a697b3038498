"""Every number of marker sets, with its unit, its use and what speaks for it.

Three data sets (28, 19 and 47 markers) were looked at while the numbers were chosen; the others show whether they hold.
Log distances are natural logarithms of distances in mm; a deviation of .05 is 5 %.
"""

from dataclasses import dataclass

from dshpm_jax._numbers import number


@dataclass(frozen=True)
class SetTuning:
    """The numbers by stage; each field says in its metadata what it is (see `_numbers.number`)."""

    # How a marker set is made

    min_worn: float = number(
        0.25,
        unit="share of subjects",
        used="making: a marker that fewer of the subjects wear is left out, and named",
        evidence="by hand: a name that one of many subjects has is a slip or another marker set",
        group="making",
    )
    rigid_share: float = number(
        0.4,
        unit="share of pairs",
        used="between: a subject's size is the median log ratio over this share of the pairs, the most rigid ones",
        evidence="by hand: postures move the rest",
        group="making",
    )
    size_rounds: int = number(
        10,
        unit="rounds",
        used="between: sizes and mean distances are found in turn",
        evidence="by hand: they settle after three",
        group="making",
    )
    softness_classes: int = number(
        6,
        unit="classes",
        used="between: the variance between subjects is drawn towards the median of pairs of like softness",
        evidence="by hand",
        group="making",
    )
    pool_subjects: float = number(
        3.0,
        unit="subjects",
        used="between: the pairs of like softness count as this many subjects",
        evidence="by hand",
        group="making",
    )
    least_between: float = number(
        0.01,
        unit="log distance",
        used="between: the standard deviation between subjects is at least this",
        evidence="by hand: markers are placed by hand",
        group="making",
    )
    lone_between: float = number(
        0.04,
        unit="log distance",
        used="between: the standard deviation between subjects where only one is known",
        evidence="by hand: the usual one of sets of several subjects",
        group="making",
    )
    max_components: int = number(
        10,
        unit="components",
        used="between: principal components of what subjects differ in, at most",
        evidence="by hand: of twelve subjects the tenth explains under 1 %",
        group="making",
    )
    spread_floor_mm: float = number(
        1.5,
        unit="mm",
        used="between: added to spreads before their logarithm is taken",
        evidence="by hand: below it a spread is noise",
        group="making",
    )
    fours_drawn: int = number(
        6000,
        unit="fours of markers",
        used="handedness: this many are drawn; each marker keeps its most constant ones",
        evidence="by hand: cost",
        group="making",
    )
    fours_kept: int = number(
        12,
        unit="fours a marker",
        used="handedness: how many of the most constant ones each marker keeps",
        evidence="by hand",
        group="making",
    )
    fours_near: int = number(
        9,
        unit="markers",
        used="handedness: all fours of a marker and three of so many nearest ones are measured too",
        evidence="by hand: cost (84 fours a marker)",
        group="making",
    )
    fours_of_pair: int = number(
        3,
        unit="fours a pair",
        used="handedness: how many of the most constant ones each marker keeps with each of the nearest ones",
        evidence="by hand: wrists are told by these alone",
        group="making",
    )
    fours_frames: int = number(
        60,
        unit="frames of a subject",
        used="handedness: frames in which signed volumes are measured",
        evidence="by hand",
        group="making",
    )
    volume_noise: float = number(
        0.03,
        unit="normalised volume",
        used="handedness: the standard deviation of a signed volume is at least this",
        evidence="by hand",
        group="making",
    )
    odd_sds: float = number(
        3.0,
        unit="standard deviations",
        used="oddities: a marker whose near-rigid distances typically deviate by more sits otherwise in this subject",
        evidence="by hand",
        group="making",
    )
    odd_share: float = number(
        0.10,
        unit="log distance",
        used="oddities: and they deviate by at least this",
        evidence="by hand: less is a difference of builds",
        group="making",
    )

    # How far a new subject's distances may be off

    size_sd: float = number(
        0.05,
        unit="log distance",
        used="posterior: the size of a new subject varies by this",
        evidence="by hand: grown people; what is smaller or larger is found by the rounds",
        group="subject",
    )
    posture_slack: float = number(
        0.10,
        unit="log distance",
        used="posterior: the mean distance of a soft pair may be off by this, as a new subject takes other postures",
        evidence="by hand: with less, the truth scores below zero for whoever moves otherwise than the others did",
        group="subject",
    )
    soft_pair: float = number(
        0.06,
        unit="spread over mean distance",
        used="posterior: from this on a pair has the whole `posture_slack`, below it a proportional share",
        evidence="by hand",
        group="subject",
    )
    noise_mm: float = number(
        2.0,
        unit="mm",
        used="posterior: every distance may be off by this",
        evidence="by hand",
        group="subject",
    )
    component_share: float = number(
        0.9,
        unit="share",
        used="posterior: the components' own deviations count by this, as few subjects show them too large",
        evidence="by hand",
        group="subject",
    )
    least_own_share: float = number(
        0.3,
        unit="share of the variance between subjects",
        used="posterior: what components do not explain is at least this",
        evidence="by hand",
        group="subject",
    )
    explained_share: float = number(
        0.7,
        unit="share of the components' variance",
        used="posterior: this much of it counts as explained",
        evidence="by hand",
        group="subject",
    )
    posterior_floor: float = number(
        0.01,
        unit="log distance",
        used="posterior: added to the standard deviation of observed distances",
        evidence="by hand",
        group="subject",
    )
    evidence_per_marker: float = number(
        3.0,
        unit="distances a marker",
        used="posterior: all observed distances together count as this many a marker",
        evidence="derived: a point has three coordinates",
        group="subject",
    )

    # What a labelling is worth

    pair_dof: float = number(
        4.0,
        unit="degrees of freedom",
        used="scores: log distances miss by a t distribution with these",
        evidence="by hand: heavy tails",
        group="score",
    )
    background_sd: float = number(
        0.7,
        unit="log distance",
        used="scores: distances of points that are no pair of markers vary by this about the mean of the set's",
        evidence="by hand: that of all pairs of a body",
        group="score",
    )
    min_pair_llr: float = number(
        -3.0,
        unit="nats",
        used="scores: no pair says less",
        evidence="by hand",
        group="score",
    )
    max_pair_llr: float = number(
        6.0,
        unit="nats",
        used="scores: no pair says more",
        evidence="by hand",
        group="score",
    )
    spread_weight: float = number(
        0.7,
        unit="weight",
        used="scores: what the spread of a distance says counts by this",
        evidence="by hand: recordings move more or less than others",
        group="score",
    )
    unlabelled_llr: float = number(
        -0.6,
        unit="nats a partner",
        used="scores: what an unlabelled point costs for each partner that it could have",
        evidence="by hand: right labels of whoever moves otherwise reach below zero",
        group="score",
    )
    pairs_per_marker: float = number(
        6.0,
        unit="pairs a marker",
        used="scores: all pairs of a marker together count as this many beside signed volumes",
        evidence="derived: three coordinates of each of two points",
        group="score",
    )
    volume_dof: float = number(
        4.0,
        unit="degrees of freedom",
        used="scores: signed volumes miss by a t distribution with these",
        evidence="by hand: heavy tails",
        group="score",
    )
    volume_background: float = number(
        0.35,
        unit="normalised volume",
        used="scores: signed volumes of four points that are not those markers vary by this about zero",
        evidence="by hand: that of random fours of a body",
        group="score",
    )
    max_volume_llr: float = number(
        4.0,
        unit="nats",
        used="scores: no signed volume says more, for or against",
        evidence="by hand",
        group="score",
    )

    # Moments and search

    min_life_seconds: float = number(
        0.3,
        unit="s",
        used="moments: trajectories of shorter lives are left to the full method",
        evidence="by hand",
        group="search",
    )
    full_life_seconds: float = number(
        3.0,
        unit="s",
        used="moments: lives longer than this count no more",
        evidence="by hand",
        group="search",
    )
    max_moments: int = number(
        5,
        unit="moments a recording",
        used="moments: at most these",
        evidence="by hand",
        group="search",
    )
    min_new_share: float = number(
        0.1,
        unit="share of the first moment's weight",
        used="moments: if what a further one adds is less, there is no further one",
        evidence="by hand",
        group="search",
    )
    moment_seconds: float = number(
        0.05,
        unit="s",
        used="moments: distances are measured in frames this far apart",
        evidence="by hand",
        group="search",
    )
    moment_frames: int = number(
        400,
        unit="frames",
        used="moments: and in at most this many",
        evidence="by hand: cost",
        group="search",
    )
    max_points: int = number(
        192,
        unit="points",
        used="moments: of more points alive at a moment the longest lived are taken",
        evidence="by hand: cost",
        group="search",
    )
    max_rounds: int = number(
        3,
        unit="rounds",
        used="rounds: labels, the subject's own distances from them, and labels again, at most this often",
        evidence="by hand",
        group="search",
    )
    starts_kept: int = number(
        3,
        unit="labellings",
        used="search: so many of the best are bettered by exchanges",
        evidence="by hand",
        group="search",
    )
    rebuilt_markers: int = number(
        16,
        unit="markers",
        used="search: the labels of so many markers near each one, and of half as many, are given anew",
        evidence="by hand: the labels of a spine shifted by one need as many",
        group="search",
    )
    exchange_rounds: int = number(
        4,
        unit="rounds",
        used="search: exchanges are tried again for as long as one pays, at most this often",
        evidence="by hand",
        group="search",
    )
    permutations_climbed: int = number(
        8,
        unit="permutations",
        used="search: of exchanges of limbs so many of the best are bettered further before they are judged",
        evidence="by hand: cost",
        group="search",
    )
    exchanges_tried: int = number(
        96,
        unit="exchanges",
        used="search: of two labels, the most promising by their distances",
        evidence="by hand: cost",
        group="search",
    )
    min_exchange_gain: float = number(
        0.5,
        unit="nats",
        used="search: an exchange is made if it pays at least this",
        evidence="by hand: less is rounding",
        group="search",
    )
    trusted_llr: float = number(
        0.2,
        unit="nats a partner",
        used="rounds: labels with less do not tell of the subject's distances",
        evidence="by hand",
        group="search",
    )
    trusted_share: float = number(
        0.5,
        unit="share of the median",
        used="rounds: nor do labels with less than this share of what labels have in the median",
        evidence="by hand",
        group="search",
    )

    # Confidence

    clear_base: float = number(
        -0.2,
        unit="log odds",
        used="confidence: a label is right with log odds of this, and `clear_per_nat` for each nat of its margin",
        evidence="by hand: of 822 labels of three sets, of those with margins under 6 half were wrong, of those "
        "from 16 on one in a hundred; not fitted on sets left out yet",
        group="confidence",
    )
    clear_per_nat: float = number(
        0.2,
        unit="log odds a nat",
        used="confidence: see `clear_base`",
        evidence="by hand, as clear_base; signed volumes overlap, so a nat says less than it seems",
        group="confidence",
    )


TUNING = SetTuning()
