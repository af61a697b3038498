"""What reading and writing raise: one line that names the file, what is wrong and what to do."""

from pathlib import Path


class ReadError(ValueError):
    """A file that cannot be read, or not as what it should be."""

    def __init__(self, path: Path | str, wrong: str, remedy: str):
        super().__init__(f"{path}: {wrong}; {remedy}")


class WriteError(ValueError):
    """A file that cannot be written."""

    def __init__(self, path: Path | str, wrong: str, remedy: str):
        super().__init__(f"{path}: {wrong}; {remedy}")
