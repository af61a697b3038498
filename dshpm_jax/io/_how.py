"""How a recording is to be read: what people may ask of a reader, whatever the format."""

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from glob import escape


@dataclass(frozen=True)
class How:
    """Arguments of `read`, in one piece."""

    unlabelled: tuple[str, ...] = ()
    drop: tuple[str, ...] = ()
    frozen_gaps: bool = True

    def dropped(self, names: Sequence[str], number: int) -> bool | None:
        """Whether a column is left out: None where nobody said.

        Arguments:
            names: what the column is called, with and without its prefix.
            number: of the column in its file, from 1.
        """
        said = [pattern for pattern in self.drop if _names(pattern.removeprefix("!"), names, number)]
        return None if not said else not said[-1].startswith("!")


def kept(markers: Sequence[str]) -> list[str]:
    """Patterns for `drop` of `read` by which columns stay, however much they look like computed points.

    Arguments:
        markers: their names, with or without a subject's prefix.
    """
    return [f"!{escape(marker.rpartition(':')[2])}" for marker in markers]


def _names(pattern: str, names: Sequence[str], number: int) -> bool:
    return pattern == f"#{number}" or any(fnmatchcase(name, pattern) for name in names if name)
