"""Memory: what there is, and the end of a process that uses more than it may."""

import os
import sys
import time
from pathlib import Path

LOOK_SECONDS = 0.1  # between two looks at the memory that a process uses


def end_beyond(most: float) -> None:
    """Ends this process when it uses more than `most` bytes, before the system ends something else instead."""
    while (used := memory_used()) is not None and used <= most:
        time.sleep(LOOK_SECONDS)
    if used is not None:
        os._exit(1)


def memory_used() -> int | None:
    """Bytes that this process holds, if the system tells."""
    try:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        pass
    try:
        import resource

        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return peak if sys.platform == "darwin" else 1024 * peak
    except ImportError:  # Windows
        return None


def machine_memory() -> int | None:
    """Bytes of memory that this machine has, or that we may use of it, if the system tells."""
    found = []
    for limit in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        try:
            found.append(int(Path(limit).read_text()))
        except (OSError, ValueError):
            pass
    try:
        found.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):  # Windows
        pass
    return min((size for size in found if size > 0), default=None)
