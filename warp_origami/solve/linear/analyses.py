"""Analyses of patterns that are kept from one factorization to the next."""

import weakref
from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

import numpy as np

KEPT = 2
"""Analyses that no factor uses but are kept: those of a sheet with and without what touches."""


class Pattern(Protocol):
    """Compressed columns or rows."""

    indptr: np.ndarray
    indices: np.ndarray


class Analysis(Protocol):
    """What is known about a pattern, with the memory of one factor."""

    pattern: Pattern


A = TypeVar("A", bound=Analysis)


class Analyses(Generic[A]):
    """Hands out analyses whose memory no living factor uses.

    Args:
        analyse: makes one for a pattern; it may borrow from another one for the same pattern, if there is one.

    Attributes:
        count: of analyses made for new patterns.
    """

    def __init__(self, analyse: Callable[[Pattern, A | None], A]) -> None:
        self._analyse, self.count = analyse, 0
        self._known: list[A] = []  # the one used last comes last
        self._users: dict[int, weakref.ref] = {}

    def take(self, pattern: Pattern) -> A:
        """An analysis of the pattern, for the next factor."""
        fitting = [known for known in self._known if _equal(known.pattern, pattern)]
        found = next((known for known in fitting if not self._is_used(known)), None)
        if found is None:
            self.count += not fitting
            found = self._analyse(pattern, fitting[0] if fitting else None)
        else:
            self._known.remove(found)
        self._known.append(found)
        spare = [known for known in self._known[:-1] if not self._is_used(known)]
        for known in spare[: max(len(spare) + 1 - KEPT, 0)]:
            self._known.remove(known)
            self._users.pop(id(known), None)
        return found

    def give(self, analysis: A, factor: object) -> None:
        """Keeps the memory of an analysis for a factor, as long as that lives."""
        self._users[id(analysis)] = weakref.ref(factor)

    def _is_used(self, analysis: A) -> bool:
        user = self._users.get(id(analysis))
        return user is not None and user() is not None


def _equal(one: Pattern, other: Pattern) -> bool:
    if one is other:
        return True
    return np.array_equal(one.indptr, other.indptr) and np.array_equal(one.indices, other.indices)
