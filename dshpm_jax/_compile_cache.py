"""Compiled programs kept on disk between runs of the command; who imports the package is left alone.

They lie in a folder for each version of jax and each kind of processor: a program for another processor may crash here.
"""

import hashlib
import os
import platform
import secrets
import warnings
from functools import cache
from importlib.metadata import version
from multiprocessing import parent_process
from pathlib import Path
from typing import Any

from dshpm_jax._console import complain

FOLDER = "DSHPM_CACHE"  # the variable that says where, or that nothing is kept if it is empty
NAME = "dshpm-jax"  # of the folder in the user's folder of caches
_ADMINISTRATOR = 0  # number of the user who may change everything anyway
_OF_THE_PROCESSOR = {  # lines of /proc/cpuinfo that say what it can, not what it is doing
    *("vendor_id", "cpu family", "model", "model name", "stepping", "flags"),
    *("Features", "CPU implementer", "CPU architecture", "CPU variant", "CPU part", "isa", "uarch"),
}


def cache_programs() -> None:
    """From now on jax keeps what it compiles in `cache_folder`, and takes from there what an earlier run compiled."""
    if (folder := cache_folder()) is None:
        return
    import jax

    jax.config.update("jax_compilation_cache_dir", str(folder))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    # A full disk, or a folder that was deleted meanwhile: the program is compiled, as it would be without the cache.
    warnings.filterwarnings("ignore", "Error (reading|writing) persistent compilation cache entry")
    _write_whole_files()


def cache_folder() -> Path | None:
    """The folder for compiled programs of this machine, made if it is not there; `None` if nothing is to be kept.

    It is below the folder that DSHPM_CACHE names, else below the user's folder of caches. A folder that the user asked
    for and that cannot be made is complained of once.
    """
    return _made(os.environ.get(FOLDER))


@cache
def _made(asked: str | None) -> Path | None:
    above = _of_the_user() if asked is None else Path(asked) if asked else None
    if above is None:
        return None
    folder = above / f"{version('jax')}-{fingerprint()}"
    try:
        folder.mkdir(mode=0o777 if asked else 0o700, parents=True, exist_ok=True)
        if asked is None and not _is_trusted(folder):
            return None
    except OSError as error:
        if asked and parent_process() is None:
            complain(f"{asked}: compiled programs cannot be kept there ({error.strerror}); see {FOLDER}")
        return None
    return folder.absolute()


def _of_the_user() -> Path | None:
    """Our folder among the user's caches, if the user has any and has not told jax itself where to keep programs."""
    if os.environ.get("JAX_COMPILATION_CACHE_DIR"):
        return None
    if (caches := os.environ.get("XDG_CACHE_HOME", "")) and Path(caches).is_absolute():
        return Path(caches) / NAME
    if home := os.environ.get("HOME"):
        return Path(home) / ".cache" / NAME
    local = os.environ.get("LOCALAPPDATA")  # Windows
    return Path(local) / NAME if local else None


def _is_trusted(folder: Path) -> bool:
    """Whether nobody but this user and the system's own writes there: what lies there is run."""
    return not hasattr(os, "getuid") or folder.stat().st_uid in (_ADMINISTRATOR, os.getuid())


@cache
def fingerprint() -> str:
    """Tells processors apart for which XLA compiles different programs; programs of one never reach another."""
    what = [version("jaxlib"), platform.system(), platform.machine(), *_processor()]
    return hashlib.sha256("\n".join(what).encode()).hexdigest()[:16]


def _processor() -> list[str]:
    """What the system says of the processor: of all its cores, if they differ."""
    try:
        lines = Path("/proc/cpuinfo").read_text(errors="replace").splitlines()
    except OSError:
        return [platform.processor()]
    return sorted({line for line in lines if line.split(":")[0].strip() in _OF_THE_PROCESSOR})


def _write_whole_files() -> None:
    """Has jax's files appear whole or not at all.

    jax writes them in place. A process that is killed meanwhile, or a full disk, leaves a torn file, which jax can
    neither read nor would ever write again. A jax that keeps files in another way is left as it is.
    """
    try:
        from jax._src.lru_cache import LRUCache

        theirs: Any = LRUCache.put
    except (ImportError, AttributeError):
        return
    if theirs.__module__ == __name__:
        return

    def put(self: Any, key: str, value: bytes) -> None:
        if getattr(self, "eviction_enabled", True):
            theirs(self, key, value)
            return
        path = Path(self.path) / f"{key}-cache"
        if path.exists():
            return
        new = path.with_name(f".{secrets.token_hex(8)}.part")
        try:
            new.write_bytes(value)
            os.replace(new, path)
        except BaseException:
            new.unlink(missing_ok=True)
            raise

    LRUCache.put = put
