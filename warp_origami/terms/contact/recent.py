"""Searches made lately: Newton's iterates leave the state where pairs were found, and come back to it."""

from collections.abc import Callable, Iterator
from typing import Generic, TypeVar

Found = TypeVar("Found")

KEPT = 3
"""Searches that are kept: those around the accepted state, the present iterate and a trial far from both."""


class Recent(Generic[Found]):
    """The last few searches, the one in use first."""

    def __init__(self) -> None:
        self._found: list[Found] = []

    def use(self, fits: Callable[[Found], bool], search: Callable[[], Found]) -> Found:
        """A search that fits the present state, of those there are or a new one."""
        for place, found in enumerate(self._found):
            if fits(found):
                self._found.insert(0, self._found.pop(place))
                return found
        self._found = [search(), *self._found[: KEPT - 1]]
        return self._found[0]

    def __iter__(self) -> Iterator[Found]:
        return iter(self._found)

    def forget(self) -> None:
        """No search holds any more."""
        self._found = []
