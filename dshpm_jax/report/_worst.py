"""The worst of many entries, as many as fit into a page."""

import json
from typing import Any


class Worst:
    """Takes any number of entries, and keeps those that come first and fit into a number of bytes as JSON.

    Arguments:
        most_bytes: of the entries kept. No more than twice this is held, whatever was added.
    """

    def __init__(self, most_bytes: int):
        self.added = 0
        self._most = most_bytes
        self._held: list[tuple[tuple, str]] = []
        self._bytes = 0
        self._first_cut: tuple | None = None  # what comes behind it is not kept either

    def add(self, key: tuple, entry: Any) -> None:
        """Adds an entry; those with the least `key` come first, and no two have the same."""
        self.added += 1
        if self._first_cut is not None and key > self._first_cut:
            return
        text = json.dumps(entry, separators=(",", ":"))
        self._held.append((key, text))
        self._bytes += _size(text)
        if self._bytes > 2 * self._most:
            self._cut()

    def entries(self) -> list[Any]:
        """What is kept, in order."""
        self._cut()
        return [json.loads(text) for _, text in self._held]

    def _cut(self) -> None:
        self._held.sort()
        kept = total = 0
        for _, text in self._held:
            total += _size(text)
            if total > self._most:
                break
            kept += 1
        if kept < len(self._held):
            self._first_cut = self._held[kept][0]
        del self._held[kept:]
        self._bytes = sum(_size(text) for _, text in self._held)


def _size(text: str) -> int:
    """Bytes in a page, in which `<` is written as an escape, with the comma behind."""
    return len(text) + 5 * text.count("<") + 1
