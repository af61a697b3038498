"""Lines for people that do not run into a progress bar, and what several commands ask in the same words."""

import sys
from typing import Any, TextIO


def say(text: object, stream: TextIO | None = None) -> None:
    """A line to standard output, or to `stream`."""
    stream = stream or sys.stdout
    encoding = getattr(stream, "encoding", None) or "utf-8"  # names of files may be none that it can show
    text = str(text).encode(encoding, "backslashreplace").decode(encoding)
    if sys.stderr.isatty():
        from tqdm import tqdm

        tqdm.write(text, file=stream)
    else:
        print(text, file=stream, flush=True)


def add_reading(options: Any) -> None:
    """The options about which columns of a recording are read, and as what (see `io.read`)."""
    about = "columns with such names have no label, as those that capture systems call '*12' and so on; may be repeated"
    options.add_argument("--unlabelled", action="append", default=[], metavar="NAME*", help=about)
    about = "leave out columns with such names, or by number ('#12'); '!NAME*' keeps what is left out otherwise"
    options.add_argument("--drop", action="append", default=[], metavar="NAME*", help=about)
    about = "points that keep their coordinates to the last bit while others move are measured, no gaps"
    options.add_argument("--keep-frozen", action="store_true", help=about)


def complain(text: object) -> None:
    """A line to standard error."""
    say(f"dshpm-jax: {text}", sys.stderr)
