"""How large a sheet may be: what is larger is refused before it takes memory."""

from math import prod

from ..errors import InputError

MOST_ELEMENTS = 1_000_000

MOST_CORNERS = 2_000
"""Of a face of a FOLD file, which takes the square of their number to triangulate."""

MOST_FRAMES = 1_000
"""Of a FOLD file."""


def check_counts(parameters: dict) -> None:
    """Refuses whole numbers whose product is beyond the number of elements: those of cells, rings and segments.

    Raises:
        InputError: naming the largest.
    """
    counts = {key: value for key, value in parameters.items() if type(value) is int and value > 1}
    if prod(counts.values()) > MOST_ELEMENTS:
        key = max(counts, key=counts.__getitem__)
        got = " x ".join(f"{name} {value}" for name, value in counts.items())
        raise InputError(f"pattern.{key}", got, f"at most {MOST_ELEMENTS} elements in all")


def check_elements(key: str, count: int) -> None:
    """Refuses too many elements.

    Raises:
        InputError: calling them `key`.
    """
    if count > MOST_ELEMENTS:
        raise InputError(key, f"{count} elements", f"at most {MOST_ELEMENTS}")
