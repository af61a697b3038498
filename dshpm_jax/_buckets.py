"""The sizes that requests are padded to, so that few programs are compiled."""

from collections.abc import Sequence

POINT_BUCKETS = (64, 128, 256, 512, 1024)
COLUMN_BUCKETS = (8, 18)
FIT_BUCKETS = (64, 1024)
SLOT_BUCKETS = (32, 64, 96, 128, 192, *POINT_BUCKETS[2:])  # life evidence takes time for every slot, so these are finer


def bucket(size: int, buckets: Sequence[int], what: str) -> int:
    """The smallest bucket that holds `size`."""
    for limit in buckets:
        if size <= limit:
            return limit
    raise ValueError(f"{size} {what} at once, more than {buckets[-1]}: this recording is too crowded to label")


MARKER_BUCKETS = (32, 64, 128, 256)
START_BUCKETS = (1, 4, 16, 32, 64, 128, 256)
FOUR_BUCKETS = (128, 256, 384, 512, 768, 1024, 1536, 2048, 4096)
