"""The folder that the demo writes into."""

import sys
from pathlib import Path


def is_free(folder: Path) -> bool:
    """Whether `folder` is not there yet or empty; says so if it is not: the demo overwrites nothing."""
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        print(f"{folder} is there already and not empty: give another folder with -o", file=sys.stderr)
        return False
    return True
