"""What a bench ran on, and how much memory its process took."""

import os
import platform
from datetime import datetime
from importlib.metadata import version
from pathlib import Path


def description() -> dict[str, str | int | float]:
    """Processor, cores, memory (GB), load before the run, versions and the day."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") if hasattr(os, "sysconf") else 0
    return {
        "processor": _processor(),
        "cores": os.cpu_count() or 0,
        "memory_gb": round(memory / 1e9, 1),
        "load": round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else 0.0,
        "system": platform.system(),
        "python": platform.python_version(),
        **{name.replace("-", "_"): version(name) for name in ("dshpm-jax", "jax", "numpy", "scipy")},
        "date": datetime.now().date().isoformat(),
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), "")


def peak_memory(pid: int | str = "self") -> int:
    """The most that a process ever had resident (bytes), 0 if that is not known or the process is gone."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    except OSError:
        return 0
    return next((int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM")), 0)
