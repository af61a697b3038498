"""Words that everything else uses: named constants and the vocabulary of axes.

Axes in shape strings: `frames`, `points` (columns of a recording), `slots` (places of a packed frame),
`trajectories`, `markers` (identities of a model), `segment_markers` (markers of one segment, padded on the device).
Lengths are millimetres and times are seconds unless a name says otherwise. Every index counts from 0.
"""

UNKNOWN = -2  # a point or a trajectory of which nobody has said which marker it is, nor that it is none
NO_MATCH = -1  # an identity, a point or a trajectory that is not there
NO_PARENT = -1  # the parent of the root segment
MIN_FIT_POINTS = 3  # fewer correspondences give no pose
