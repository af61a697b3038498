"""Libraries that only those need who ask for them."""

from collections.abc import Sequence
from importlib import import_module
from typing import Any

from dshpm_jax._recording import is_unlabelled


def optional(module: str, purpose: str, install: str = "") -> Any:
    """A module that may not be installed.

    Raises:
        ImportError: it is not; the message says what it is for and how it is installed.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name != module:
            raise
        how = f"pip install {install or module}"
        raise ImportError(f"{purpose} needs {module}, which is not installed; {how}", name=module) from None


def distinct(labels: Sequence[str]) -> list[str]:
    """The labels with a name for each column that has none, and numbers after those that come again.

    Tables by name hold one column a name, and C3D knows no column without one.
    """
    taken, found = set(labels), []
    for k, label in enumerate(labels):
        again = label in found
        if not label or (again and is_unlabelled(label)):
            label = next(name for n in range(k + 1, len(labels) + k + 2) if (name := f"*{n}") not in taken)
        elif again:
            label = next(name for n in range(2, len(labels) + 2) if (name := f"{label}_{n}") not in taken)
        taken.add(label)
        found.append(label)
    return found
