"""Every number of the full method, each with its unit, its use and what speaks for it.

`Settings` holds what a user turns. These numbers are for who develops the method: `label_many(..., tuning=...)` takes
others, `bench/sensitivity.py` moves each, `bench/calibrate.py` fits those of the confidence. Evidence is in nats: the
log-likelihood ratio (llr) that a point is the marker against that it is none of the model's, see `_null_model`.
"""

from dataclasses import dataclass

from dshpm_jax._null_model import NullModel
from dshpm_jax._numbers import number


@dataclass(frozen=True)
class Tuning:
    """The numbers by stage; each field says in its metadata what it is (see `_numbers.number`)."""

    # What the matcher is given

    matching_quantity: float = number(
        0.6,
        unit="share",
        used="targets: a match of the full method holds at least this share of a segment's markers, as the whole life "
        "of its trajectories judges it later",
        evidence="by hand",
        group="targets",
    )
    reach_ratio: float = number(
        1.5,
        unit="ratio",
        used="targets: a lost marker is recruited within this many times the mean pair tolerance of its column",
        evidence="by hand",
        group="targets",
    )
    join_slack_sds: float = number(
        2.0,
        unit="standard deviations",
        used="segment: the centre of a joint, as the parent predicts it, may be off by this, and by the noise",
        evidence="by hand",
        group="targets",
    )
    symmetry_tolerances: float = number(
        2.0,
        unit="pair tolerances",
        used="targets: if all distances change by less, a permutation of a segment's markers is a symmetry of it",
        evidence="by hand",
        group="targets",
    )
    max_symmetric_markers: int = number(
        6,
        unit="markers",
        used="targets, counterparts: larger segments are not permuted (720 permutations at six)",
        evidence="by hand: cost",
        group="targets",
    )

    # Evidence of a point for a label

    t_dof: float = number(
        3.0,
        unit="degrees of freedom",
        used="_null_model: the errors of a marker are distributed by a t distribution with these",
        evidence="by hand: soft tissue has heavy tails",
        group="evidence",
    )
    background_mm: float = number(
        700.0,
        unit="mm",
        used="_null_model, prepared_model: a point that is no marker may be anywhere within this, along each axis",
        evidence="by hand: the volume of a grown body",
        group="evidence",
    )
    min_llr: float = number(
        -12.0,
        unit="nats",
        used="life_evidence: no point says less, so that a few bad frames do not condemn a life",
        evidence="by hand",
        group="evidence",
    )
    unknown_llr: float = number(
        0.0,
        unit="nats",
        used="life_evidence: what a point says where too few neighbours of the marker are known",
        evidence="derived: nothing speaks for the label or against it",
        group="evidence",
    )
    robust_rounds: int = number(
        2,
        unit="fits",
        used="life_evidence: reweighted fits of a marker's neighbours after the first",
        evidence="by hand",
        group="evidence",
    )
    robust_scale: float = number(
        2.0,
        unit="standard deviations",
        used="life_evidence: a neighbour that misses by this many counts a quarter",
        evidence="by hand",
        group="evidence",
    )
    max_pose_sd_ratio: float = number(
        3.0,
        unit="ratio",
        used="life_evidence: if a pose is this many times softer than the second neighbour, it turns about a line and "
        "distances say more",
        evidence="by hand",
        group="evidence",
    )
    min_distances: int = number(
        2,
        unit="neighbours",
        used="life_evidence, rematch: fewer known neighbours say nothing",
        evidence="by hand: one distance leaves a sphere",
        group="evidence",
    )
    max_distances: int = number(
        3,
        unit="neighbours",
        used="life_evidence: of more known neighbours the most rigid count",
        evidence="derived: a point has three coordinates, however many distances are known",
        group="evidence",
    )
    min_weight_share: float = number(
        0.02,
        unit="share",
        used="life_evidence: neighbours with less of the weight do not count as present",
        evidence="by hand",
        group="evidence",
    )
    leverage_offset: float = number(
        0.5,
        unit="ratio",
        used="life_evidence: leverage of a marker amid its neighbours; that of one farther out is added",
        evidence="by hand",
        group="evidence",
    )
    few_neighbours_variance: float = number(
        0.5,
        unit="ratio",
        used="life_evidence: share of the neighbours' variance, over their number, that a prediction has besides",
        evidence="by hand",
        group="evidence",
    )
    pair_noise_mm: float = number(
        5.0,
        unit="mm",
        used="prepared_model: least deviation of a pair distance between two recordings",
        evidence="by hand",
        group="evidence",
    )

    # What a labelling is worth

    sample_seconds: float = number(
        0.1,
        unit="s",
        used="evidence: lives are judged at frames so far apart, as a body moves little in this time",
        evidence="by hand",
        group="objective",
    )
    max_samples: int = number(
        100,
        unit="frames",
        used="evidence: in a long recording lives are judged at this many frames, evenly spaced",
        evidence="by hand: cost",
        group="objective",
    )
    accept_llr: float = number(
        2.0,
        unit="nats",
        used="objective: a label pays by what its mean evidence exceeds; real points that belong to no marker lie near "
        "markers more often than evenly spread ones would",
        evidence="by hand",
        group="objective",
    )
    distance_weight: float = number(
        4.0,
        unit="pairs",
        used="objective: all distances of a marker to others together count as this many, as most say the same",
        evidence="by hand",
        group="objective",
    )
    whole_body_weight: float = number(
        2.0,
        unit="pairs",
        used="whole_body: what the mean distances of a marker to all others lose together counts as that of this many",
        evidence="by hand",
        group="objective",
    )
    min_usual_gain: float = number(
        1.0,
        unit="nats",
        used="objective: a right label is expected to pay this much at the least",
        evidence="by hand",
        group="objective",
    )

    # Key-frames

    first_share: float = number(
        0.3,
        unit="share",
        used="search: share of the key-frames that are asked first; most recordings need no more",
        evidence="by hand: cost",
        group="key-frames",
    )
    key_frame_factors: tuple[int, ...] = number(
        (1, 3),
        unit="times num_key_frames",
        used="key_frames: sets of key-frames that are asked one after the other while the votes are at odds",
        evidence="by hand",
        group="key-frames",
    )
    key_frame_seconds: float = number(
        20.0,
        unit="s",
        used="key_frames: a long recording has a key-frame for each of these; labels spread over some lives of "
        "trajectories and no farther",
        evidence="by hand",
        group="key-frames",
    )
    min_vote_agreement: float = number(
        0.95,
        unit="share",
        used="key_frames: if fewer of the votes go to the label that wins, the next set is asked",
        evidence="by hand",
        group="key-frames",
    )
    min_segments_found: float = number(
        0.9,
        unit="share",
        used="key_frames: if fewer of the segments were found, the next set is asked",
        evidence="by hand",
        group="key-frames",
    )
    divided_below: float = number(
        0.5,
        unit="share",
        used="key_frames: if fewer of the votes go to the label that wins, several starts are tried",
        evidence="fitted: agreement of votes on eight groups of dev cases under four conditions; only a static alone "
        "as model had less, the next .54",
        group="key-frames",
    )
    extra_starts: tuple[float, ...] = number(
        (1.3, 2.0, 4.0),
        unit="times num_key_frames",
        used="search: starts that are tried besides while votes are divided",
        evidence="by hand",
        group="key-frames",
    )
    min_consensus: float = number(
        0.75,
        unit="share",
        used="search: a label of the best of several starts stays if this share of them leads to it",
        evidence="fitted: a climb with a static alone as model, three draws; without it F1 was higher on some and far "
        "lower under hard (.731 .583 .675)",
        group="key-frames",
    )

    # Search

    restart_below: float = number(
        0.8,
        unit="share of the usual evidence",
        used="search: if labels hold less, more key-frames are asked, and stages are gone through while anything leads "
        "farther",
        evidence="by hand",
        group="search",
    )
    more_key_frames_below: float = number(
        0.95,
        unit="share of the usual evidence",
        used="search: if labels hold less and key-frames are at odds, more are asked, and restarts are judged in all "
        "sampled frames; a limb may carry its labels shifted by one",
        evidence="by hand",
        group="search",
    )
    restart_schedules: tuple[tuple[float, ...], ...] = number(
        ((2.0, 0.0), (6.0, 4.0, 2.0, 0.0)),
        unit="nats",
        used="search: a restart gives the labels first that win by the first of these, then by the next",
        evidence="by hand",
        group="search",
    )
    restart_frame_step: int = number(
        3,
        unit="sampled frames",
        used="search: where labels hold enough, restarts are judged in every so many-th frame first",
        evidence="by hand: cost",
        group="search",
    )
    max_passes: int = number(
        3,
        unit="passes",
        used="search: times that the stages are gone through",
        evidence="by hand",
        group="search",
    )

    # Refinement

    max_refine_rounds: int = number(
        12,
        unit="rounds",
        used="refine: times that labels are judged and assigned in turn, for each margin of a schedule",
        evidence="by hand",
        group="refine",
    )
    patience: int = number(
        3,
        unit="rounds",
        used="refine: rounds without a better solution after which it ends, as most go round in circles by then",
        evidence="by hand",
        group="refine",
    )
    keep_llr: float = number(
        0.5,
        unit="nats",
        used="refine: a label must win by this to be taken from where it is; else near ties swap back and forth",
        evidence="by hand",
        group="refine",
    )

    # Moves

    max_move_rounds: int = number(
        6,
        unit="rounds",
        used="refine: times that moves are proposed and made",
        evidence="by hand",
        group="moves",
    )
    max_moves: int = number(
        100,
        unit="moves",
        used="exchanges: moves that are tried at once, the most promising first",
        evidence="by hand: cost",
        group="moves",
    )
    move_frames: int = number(
        6,
        unit="frames",
        used="moves: sampled frames in which a move is judged",
        evidence="by hand: cost",
        group="moves",
    )
    max_exchange_loss: float = number(
        8.0,
        unit="nats",
        used="exchanges: if two trajectories lose less together by each other's labels, the exchange is tried",
        evidence="by hand",
        group="moves",
    )
    min_take_llr: float = number(
        -8.0,
        unit="nats",
        used="ejection_chains, rematch: an unlabelled trajectory tries to take a label from this evidence on",
        evidence="by hand",
        group="moves",
    )
    labels_tried: int = number(
        3,
        unit="labels",
        used="ejection_chains: an unlabelled trajectory tries its best this many",
        evidence="by hand",
        group="moves",
    )
    max_chain_length: int = number(
        6,
        unit="labels",
        used="ejection_chains: labels that one take passes on",
        evidence="by hand",
        group="moves",
    )

    # Labels of near markers permuted

    cluster_size: int = number(
        5,
        unit="markers",
        used="prepared_model: a marker and those nearest to it are permuted together, 120 ways at five",
        evidence="by hand: cost",
        group="permutations",
    )
    permutations_tried: int = number(
        6,
        unit="permutations",
        used="permutations: of each cluster, the best by mean distances",
        evidence="by hand: cost",
        group="permutations",
    )
    max_permutations: int = number(
        40,
        unit="permutations",
        used="permutations: of all clusters, tried at once",
        evidence="by hand: cost",
        group="permutations",
    )
    max_permutation_loss: float = number(
        12.0,
        unit="nats",
        used="permutations: if mean distances say less against a permutation, it is tried",
        evidence="by hand",
        group="permutations",
    )
    mean_noise_mm: float = number(
        4.0,
        unit="mm",
        used="permutations: least deviation of a mean distance from the model's",
        evidence="by hand",
        group="permutations",
    )
    mean_share: float = number(
        0.01,
        unit="share",
        used="permutations: share of a mean distance by which it may differ from the model's besides",
        evidence="by hand",
        group="permutations",
    )
    min_mean_llr: float = number(
        -5.0,
        unit="nats",
        used="permutations: a pair says no less, so that a few soft pairs do not decide",
        evidence="by hand",
        group="permutations",
    )

    max_near_loss: float = number(
        2.0,
        unit="nats a frame",
        used="near_swaps: if mean distances say more against a swap of two near labels, it is not tried",
        evidence="by hand",
        group="permutations",
    )
    max_near_swaps: int = number(
        40,
        unit="swaps",
        used="near_swaps: swaps of near labels that are tried at once",
        evidence="by hand: cost",
        group="permutations",
    )

    # Side swaps

    max_side_rounds: int = number(
        4,
        unit="rounds",
        used="side_swaps: times that chains are exchanged with their counterparts",
        evidence="by hand",
        group="side swaps",
    )
    max_counterpart_difference: float = number(
        0.2,
        unit="share of the mean distance",
        used="counterparts: if the distances of two chains differ by less, they are counterparts",
        evidence="by hand",
        group="side swaps",
    )
    min_spell_seconds: float = number(
        0.5,
        unit="s",
        used="side_swaps: the shortest spell in which chains are exchanged; short trajectories let both legs be "
        "exchanged between two steps",
        evidence="by hand",
        group="side swaps",
    )
    min_spell_shortfall: float = number(
        0.1,
        unit="share of the usual evidence",
        used="side_swaps: if a spell lacks less, nothing is exchanged in it",
        evidence="by hand",
        group="side swaps",
    )
    max_spells: int = number(
        60,
        unit="spells",
        used="side_swaps: spells tried at once, those that lack the most first",
        evidence="by hand: cost",
        group="side swaps",
    )

    # Segments matched again

    max_rematch_rounds: int = number(
        6,
        unit="rounds",
        used="rematch: times that segments which lack evidence are looked for again",
        evidence="by hand",
        group="rematch",
    )
    rematch_frames: int = number(
        8,
        unit="frames",
        used="rematch: frames in which a segment is matched again",
        evidence="by hand: cost",
        group="rematch",
    )
    rematch_tolerance: float = number(
        2.0,
        unit="ratio",
        used="rematch: factor on all tolerances, as few points are left to be mistaken for the segment's",
        evidence="by hand",
        group="rematch",
    )
    min_evidence_share: float = number(
        0.65,
        unit="share",
        used="rematch: if the labels of a segment hold less of their usual evidence in a frame than this share of what "
        "all labels hold on average, the segment lacks evidence there",
        evidence="by hand",
        group="rematch",
    )
    max_poor_share: float = number(
        0.03,
        unit="share",
        used="rematch: if a segment lacks evidence in more of the frames, it is looked for again",
        evidence="by hand",
        group="rematch",
    )
    max_rematched: int = number(
        6,
        unit="segments",
        used="rematch: segments that are looked for in one round, the worst first",
        evidence="by hand: cost",
        group="rematch",
    )
    held_votes: float = number(
        0.5,
        unit="votes",
        used="rematch: what the label that a trajectory has counts against votes of matches",
        evidence="by hand",
        group="rematch",
    )

    # Several subjects

    max_subject_rounds: int = number(
        6,
        unit="rounds",
        used="subject_swaps: times that parts of two subjects are exchanged",
        evidence="by hand",
        group="subject swaps",
    )

    # Trajectories split

    max_split_rounds: int = number(
        3,
        unit="rounds",
        used="split: times that trajectories are cut and the parts labelled",
        evidence="by hand",
        group="split",
    )
    min_part_frames: int = number(
        3,
        unit="sampled frames",
        used="split: the shortest part that is found",
        evidence="by hand",
        group="split",
    )
    min_part_llr: float = number(
        30.0,
        unit="nats",
        used="split: if another label fits a part better by less in all, it stays whole",
        evidence="by hand",
        group="split",
    )
    min_part_frame_llr: float = number(
        5.0,
        unit="nats a frame",
        used="split: if another label fits a part better by less in a frame on average, it stays whole",
        evidence="by hand",
        group="split",
    )
    max_frame_llr: float = number(
        12.0,
        unit="nats",
        used="split: a frame counts no more, so that no single one decides",
        evidence="by hand",
        group="split",
    )
    max_cut_seconds: float = number(
        0.5,
        unit="s",
        used="split: the cut is looked for within this of where the evidence changes, as two points that are near each "
        "other are not told apart",
        evidence="by hand",
        group="split",
    )

    # Confidence

    confidence_base: float = number(
        -3.87,
        unit="log odds",
        used="confidence: that a label is right which has one second without evidence",
        evidence="fitted: logistic regression on 280 labellings of the dev cases under seven conditions, before near "
        "labels were exchanged; bench/calibrate.py does it anew and says how far these hold on each data set left out",
        group="confidence",
    )
    confidence_per_nat: float = number(
        0.26,
        unit="log odds a nat",
        used="confidence: for each nat of mean evidence",
        evidence="fitted: as confidence_base",
        group="confidence",
    )
    confidence_per_decade: float = number(
        0.65,
        unit="log odds",
        used="confidence: for a life ten times as long",
        evidence="fitted: as confidence_base",
        group="confidence",
    )
    confidence_per_own_nat: float = number(
        0.37,
        unit="log odds a nat",
        used="confidence: for each nat that the recording's own distances say",
        evidence="fitted: as confidence_base",
        group="confidence",
    )
    confidence_per_margin_nat: float = number(
        0.17,
        unit="log odds a nat",
        used="confidence: for each nat by which they say more than of the best rival",
        evidence="fitted: as confidence_base",
        group="confidence",
    )
    confidence_per_swap_nat: float = number(
        1.67,
        unit="log odds a nat a frame",
        used="confidence: for each nat a frame that the cheapest swap with a near label costs",
        evidence="fitted: as confidence_base",
        group="confidence",
    )
    confidence_seconds: tuple[float, float] = number(
        (0.01, 10.0),
        unit="s",
        used="confidence: lives count as no shorter and no longer",
        evidence="by hand",
        group="confidence",
    )
    confidence_llr: tuple[float, float] = number(
        (-6.0, 12.0),
        unit="nats",
        used="confidence: mean evidence counts as no less and no more",
        evidence="by hand",
        group="confidence",
    )
    confidence_own_llr: tuple[float, float] = number(
        (-6.0, 14.0),
        unit="nats",
        used="confidence: the evidence of own distances counts as no less and no more",
        evidence="by hand",
        group="confidence",
    )
    confidence_margin: tuple[float, float] = number(
        (-3.0, 5.0),
        unit="nats",
        used="confidence: a margin to the best rival counts as no less and no more",
        evidence="by hand: 3 and 10 as upper bound sort right labels from wrong ones as well",
        group="confidence",
    )
    confidence_swap_loss: tuple[float, float] = number(
        (0.0, 1.5),
        unit="nats a frame",
        used="confidence: the cheapest swap with a near label counts as no cheaper and no dearer",
        evidence="by hand",
        group="confidence",
    )
    rival_frames: float = number(
        10.0,
        unit="frames",
        used="confidence: so many frames tell two readings apart at the most, as frames repeat one another",
        evidence="by hand",
        group="confidence",
    )
    rivals_tried: int = number(
        4,
        unit="labels",
        used="own_distances: other labels that a trajectory might have, the best by its evidence",
        evidence="by hand: cost",
        group="confidence",
    )
    model_frames: float = number(
        4.0,
        unit="sampled frames",
        used="own_distances: as many frames of the recording weigh as much as the model's spread of a distance",
        evidence="by hand: 1 to 12 sort right labels from wrong ones as well",
        group="confidence",
    )
    own_noise_mm: float = number(
        2.0,
        unit="mm",
        used="own_distances: least deviation of a distance within a recording",
        evidence="by hand: 2 to 5 sort right labels from wrong ones nearly as well",
        group="confidence",
    )
    rescaled_share: float = number(
        0.86,
        unit="share",
        used="confidence: factor where the model is another subject's and rescaled; a turned trunk fits a model that "
        "was made from its own labels",
        evidence="fitted: share right over nine pairs of subjects",
        group="confidence",
    )
    poor_fit_below: float = number(
        0.8,
        unit="share of the usual evidence",
        used="confidence: if labels hold less (`model_fit`), the model is doubtful and no label surer than "
        "poor_fit_share",
        evidence="fitted: of 107 labellings with the subject's model 102 held .82 or more, of 15 with another's 2 did",
        group="confidence",
    )
    poor_fit_share: float = number(
        0.83,
        unit="share",
        used="confidence: highest confidence where the model is doubtful",
        evidence="fitted: share right in 17 labellings with a doubtful model",
        group="confidence",
    )
    known_doubt_llr: float = number(
        -2.0,
        unit="nats",
        used="confidence: if a label that is given has less evidence than this, that is said",
        evidence="by hand: all of 30 labels given at random are below it, none of 30 right ones",
        group="confidence",
    )
    divided_share: float = number(
        0.84,
        unit="share",
        used="confidence: highest confidence where the votes of key-frames were divided, as the model says little",
        evidence="fitted: share right of 347 labels of a climb with a static alone as model, under seven conditions",
        group="confidence",
    )
    near_tie_llr: float = number(
        2.0,
        unit="nats",
        used="confidence: a rival within this is named as the reason why a label is withheld",
        evidence="by hand",
        group="confidence",
    )

    # Labels carried on while a capture runs

    start_anew_below: float = number(
        0.5,
        unit="share of the usual evidence",
        used="incremental: if labels carried on hold less, all are looked for anew",
        evidence="by hand",
        group="incremental",
    )

    # Labels audited

    break_llr: float = number(
        5.0,
        unit="nats",
        used="audit: a column is cut where the evidence for its own label changes by more within a frame",
        evidence="by hand",
        group="audit",
    )
    decisive_llr: float = number(
        8.0,
        unit="nats",
        used="audit: if other labels beat those of the file by less in a single frame, nothing is said; the mean of n "
        "frames of a life counts sqrt(n) times, as they repeat one another",
        evidence="by hand",
        group="audit",
    )
    min_better_llr: float = number(
        2.0,
        unit="nats a frame",
        used="audit: if other labels are better by less on average, nothing is said, however many frames",
        evidence="by hand",
        group="audit",
    )
    max_taken_share: float = number(
        0.25,
        unit="share",
        used="audit: if another point is the marker for more of a column's life, the column's label is wrong",
        evidence="by hand",
        group="audit",
    )
    misplaced_llr: float = number(
        -6.0,
        unit="nats",
        used="audit: if a label has no more evidence, it is called wrong although no other point is the marker",
        evidence="by hand",
        group="audit",
    )

    # Points that leap off for some frames

    leap_mm: float = number(
        10.0,
        unit="mm",
        used="spikes, audit: a point that leaves its course by more in one step may become another point",
        evidence="by hand",
        group="spikes",
    )
    spike_llr: tuple[float, ...] = number(
        (6.0, 8.0),
        unit="nats",
        used="spikes: evidence for a label falls below its median by this while its point has leapt off",
        evidence="by hand",
        group="spikes",
    )
    min_spike_mm: float = number(
        25.0,
        unit="mm",
        used="spikes: a point that misses the way from before to after by less is no spike but a wobble of skin",
        evidence="by hand",
        group="spikes",
    )
    spike_context: int = number(
        3,
        unit="frames",
        used="spikes: on each side, these show the way, a parabola",
        evidence="by hand",
        group="spikes",
    )
    max_spike_seconds: float = number(
        0.2,
        unit="s",
        used="spikes: what stays off for longer may be a posture that the model has not seen",
        evidence="by hand",
        group="spikes",
    )

    # Another subject's model

    sizes: tuple[float, float, int] = number(
        (0.82, 1.22, 10),
        unit="ratio, ratio, count",
        used="population: smallest and largest size that is tried, and how many from one to the other",
        evidence="by hand: from a child of twelve to a tall man, each within `proportions` of the next",
        group="population",
    )
    proportions: float = number(
        0.04,
        unit="share",
        used="population: bodies of one height differ in their lengths by this, and markers are put on elsewhere",
        evidence="by hand",
        group="population",
    )
    sizes_chosen: int = number(
        3,
        unit="sizes",
        used="population: sizes that are looked at closely",
        evidence="by hand: cost",
        group="population",
    )
    min_refit_frames: int = number(
        20,
        unit="frames",
        used="population: a marker labelled in fewer keeps the place that the scaled model gives it",
        evidence="by hand",
        group="population",
    )

    @property
    def null_model(self) -> NullModel:
        """The numbers of the evidence, for kernels and control alike."""
        return NullModel(
            t_dof=self.t_dof,
            background_mm=self.background_mm,
            min_llr=self.min_llr,
            unknown_llr=self.unknown_llr,
            robust_rounds=self.robust_rounds,
            robust_scale=self.robust_scale,
            max_pose_sd_ratio=self.max_pose_sd_ratio,
            min_distances=self.min_distances,
            max_distances=self.max_distances,
            min_weight_share=self.min_weight_share,
            leverage_offset=self.leverage_offset,
            few_neighbours_variance=self.few_neighbours_variance,
        )


TUNING = Tuning()
"""The numbers that are used unless others are given."""
