"""A subject who wears a marker set, of whom an own model has been found."""

from dataclasses import dataclass

from dshpm_jax._marker_set.marker_set import MarkerSet
from dshpm_jax._model import SubjectModel


@dataclass(frozen=True, eq=False)
class Member:
    """A subject of a marker set.

    Attributes:
        markers: what is known of all who wear it.
        model: what was found of this subject, as `find_subject` gives it; its markers are those of the set.
    """

    markers: MarkerSet
    model: SubjectModel

    def __post_init__(self):
        if self.model.markers != self.markers.markers:
            raise ValueError("the subject's model has other markers than the marker set; find the subject anew")
