"""What reading and writing raise: one line that names the file, what is wrong and what to do."""

from pathlib import Path

from dshpm_jax._messages import one_line


class ReadError(ValueError):
    """A file that cannot be read, or not as what it should be."""

    def __init__(self, path: Path | str, wrong: str, remedy: str):
        super().__init__(f"{path}: {one_line(wrong)}; {one_line(remedy)}")


class NoPoints(ReadError):
    """A sound file that holds no points at all, such as a trial of muscle activity alone."""


class WriteError(ValueError):
    """A file that cannot be written."""

    def __init__(self, path: Path | str, wrong: str, remedy: str):
        super().__init__(f"{path}: {one_line(wrong)}; {one_line(remedy)}")
