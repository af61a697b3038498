"""Lines for people that do not run into a progress bar."""

import sys
from typing import TextIO


def say(text: object, stream: TextIO | None = None) -> None:
    """A line to standard output, or to `stream`."""
    stream = stream or sys.stdout
    if sys.stderr.isatty():
        from tqdm import tqdm

        tqdm.write(str(text), file=stream)
    else:
        print(text, file=stream, flush=True)


def complain(text: object) -> None:
    """A line to standard error."""
    say(f"dshpm-jax: {text}", sys.stderr)
