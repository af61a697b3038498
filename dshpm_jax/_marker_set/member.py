"""A subject who wears a marker set, of whom an own model has been found."""

from dataclasses import dataclass

from dshpm_jax._marker_set.marker_set import MarkerSet
from dshpm_jax._model import SubjectModel


@dataclass(frozen=True, eq=False)
class Member:
    """A subject of a marker set.

    Attributes:
        marker_set: what is known of all who wear it.
        model: what was found of this subject, as `find_subject` gives it; its markers are those of the set.
    """

    marker_set: MarkerSet
    model: SubjectModel

    def __post_init__(self):
        if self.model.markers != self.marker_set.markers:
            raise ValueError("the subject's model has other markers than the marker set; find the subject anew")

    @property
    def markers(self) -> tuple[str, ...]:
        """Names of the markers."""
        return self.model.markers
