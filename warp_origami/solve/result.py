"""Outcomes of numerical work: success or a failure that carries advice, never an exception."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Failure:
    """Why a step or a run did not succeed.

    Attributes:
        reason: what happened, one sentence.
        advice: what to try.
    """

    reason: str
    advice: str
