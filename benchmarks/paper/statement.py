"""A statement of the paper beside what the runs give, and when the two agree."""

from dataclasses import dataclass

TIME_TOLERANCE = 0.2
"""s: events agree in time within this."""


@dataclass(frozen=True)
class Statement:
    """One statement.

    Attributes:
        where: section or figure of the paper.
        paper: what it says.
        ours: what the runs give.
        agrees: yes, no, in part; "given" for what was taken over.
    """

    where: str
    paper: str
    ours: str
    agrees: str


def verdict(*agreed: bool) -> str:
    """yes if all hold, no if none does, else in part."""
    return "yes" if all(agreed) else "in part" if any(agreed) else "no"


def near(time: float, paper: float) -> bool:
    """Whether an event happens when the paper has it, s."""
    return abs(time - paper) <= TIME_TOLERANCE
