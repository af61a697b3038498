"""Says that programs are compiled where they have to be: a first run on a machine is slow, and people ask why."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from dshpm_jax._compile_cache import cache_folder

ONCE = "compiling, once on this machine"
EVERY_TIME = "compiling, in every run as no programs are kept (see DSHPM_CACHE)"

_MISS = "/jax/compilation_cache/cache_misses"


@contextmanager
def notice_of_compiling(notice: Callable[[str], object]) -> Iterator[None]:
    """Calls `notice` once if something has to be compiled within.

    Where no programs are there at all it says so at once; where one is lacking, when that one is made.
    """
    folder = cache_folder()
    if folder is None and not os.environ.get("JAX_COMPILATION_CACHE_DIR"):
        notice(EVERY_TIME)
        yield
        return
    if folder is not None and not any(folder.iterdir()):
        notice(ONCE)
        yield
        return
    from jax import monitoring

    said = []

    def on_event(event: str, **_: Any) -> None:
        if event == _MISS and not said:
            said.append(event)
            notice(ONCE)

    monitoring.register_event_listener(on_event)
    try:
        yield
    finally:
        monitoring.unregister_event_listener(on_event)
