"""That programs are compiled is said only where they are."""

import os
import subprocess
import sys

from dshpm_jax._archive.compiling import EVERY_TIME, ONCE

RUN = """
import sys
from dshpm_jax._archive.compiling import notice_of_compiling
from dshpm_jax._compile_cache import cache_programs
lines = []
for factor in map(float, sys.argv[1:]):
    with notice_of_compiling(lines.append):
        lines.append(str(factor))
        cache_programs()
        import jax
        jax.jit(lambda x: factor * x)(1.0)
print("; ".join(lines))
"""


def lines(folder, *factors: str) -> list[str]:
    """What is said of programs, each multiplying by a factor of its own."""
    environment = dict(os.environ, DSHPM_CACHE=str(folder))
    environment.pop("JAX_COMPILATION_CACHE_DIR", None)
    order = [sys.executable, "-c", RUN, *factors]
    return subprocess.run(order, capture_output=True, text=True, env=environment).stdout.strip().split("; ")


def test_only_where_programs_are_made(tmp_path):
    assert lines(tmp_path, "2") == [ONCE, "2.0"]  # at once, as none is there
    assert lines(tmp_path, "2", "3", "3") == ["2.0", "3.0", ONCE, "3.0"]  # as soon as one is lacking
    assert lines(tmp_path, "2", "3") == ["2.0", "3.0"]


def test_where_none_are_kept():
    assert lines("", "2") == [EVERY_TIME, "2.0"]
