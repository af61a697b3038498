"""What subjects of one marker set have in common, on the host: data, which `making` makes."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from dshpm_jax._model import SubjectModel
from dshpm_jax._recording import Recording

SHOWN_SUBJECTS = 3
"""count; subjects that the line about a set names; more are counted."""


@dataclass(frozen=True, eq=False)
class HandedFour:
    """Four markers whose signed volume keeps one sign in all subjects.

    Attributes:
        markers: the four identities.
        mean, sd: of the volume over the product of the three edges at the first marker, from -1 to 1.
    """

    markers: tuple[int, ...]
    mean: float
    sd: float


@dataclass(frozen=True, eq=False)
class OddSubject:
    """Markers that sit otherwise in one subject than in the others."""

    subject: str
    markers: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class MarkerSet:
    """What subjects who wear the same markers have in common; it labels a subject of whom nothing is labelled.

    All logarithms are natural ones of lengths in mm. Tables of pairs are symmetric, NaN for a pair that no subject
    shows, and 0 on the diagonal.

    Attributes:
        markers: names; the position in this tuple is the marker's identity.
        subjects: names of those it was made from.
        sizes: log size of each, about 0 on average.
        worn: the share of the subjects who wear each marker.
        mean_log: mean over subjects of the log distance of a pair, less the subject's size.
        between_sd: standard deviation of that between subjects, as far as it is known, drawn towards pairs like it.
        within: how much the distance varies while a subject moves, over the distance.
        spread_log, spread_sd: mean and standard deviation over subjects of the log spread of each distance.
        components: principal components of how subjects differ, each of length one standard deviation.
        fours: what tells a body from its mirror image.
        model: the typical body of size 0: segments, neighbourhoods and spreads.
        odd: subjects whose markers sit otherwise.
    """

    markers: tuple[str, ...]
    subjects: tuple[str, ...]
    sizes: Float[np.ndarray, " subjects"]
    worn: Float[np.ndarray, " markers"]
    mean_log: Float[np.ndarray, "markers markers"]
    between_sd: Float[np.ndarray, "markers markers"]
    within: Float[np.ndarray, "markers markers"]
    spread_log: Float[np.ndarray, "markers markers"]
    spread_sd: Float[np.ndarray, "markers markers"]
    components: Float[np.ndarray, "components markers markers"]
    fours: tuple[HandedFour, ...]
    model: SubjectModel
    odd: tuple[OddSubject, ...] = ()

    def __repr__(self) -> str:
        names = self.subjects if len(self.subjects) <= SHOWN_SUBJECTS else (f"{len(self.subjects)} subjects",)
        return f"MarkerSet({self.num_markers} markers, from {' and '.join(names)})"

    @property
    def num_markers(self) -> int:
        return len(self.markers)

    @classmethod
    def from_subjects(
        cls, subjects: Mapping[str, Recording | str | Path | Iterable[Recording | str | Path]]
    ) -> "MarkerSet":
        """A marker set from labelled recordings of subjects who wear it.

        Arguments:
            subjects: the name of each, and one or more labelled recordings of theirs, or the files; names of markers
                must be the same in all. From one subject on; four or more tell how people differ.

        Raises:
            ReadError: a file cannot be read.
            ValueError: there is no subject, or one has no labelled marker, or too few of the markers that others have.
        """
        from dshpm_jax._given import recordings_of
        from dshpm_jax._marker_set.making import marker_set_of

        return marker_set_of({name: recordings_of(given) for name, given in subjects.items()})


def pairs_of(markers: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of all pairs of so many markers, each once."""
    return np.triu_indices(markers, 1)


def squares(values: Float[np.ndarray, "*rows pairs"], markers: int, diagonal: float = 0.0) -> np.ndarray:
    """Values of pairs as symmetric tables."""
    rows, columns = pairs_of(markers)
    table = np.full((*values.shape[:-1], markers, markers), diagonal)
    table[..., rows, columns] = table[..., columns, rows] = values
    return table


def names_of(given: Sequence[str], most: int = 5) -> str:
    """Some names for a message."""
    return ", ".join(given[:most]) + (f" and {len(given) - most} more" if len(given) > most else "")
