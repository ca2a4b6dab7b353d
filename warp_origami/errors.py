"""What the program says when it cannot go on."""

from collections.abc import Iterable


class InputError(ValueError):
    """A scene, pattern or FOLD file that cannot be run.

    The message is one line for the user: where (key), what was found, what is wanted. The command line prints it and
    exits with 2. Further faults of the same input follow, a line for each.

    Attributes:
        key, got, wants: the parts of the message's first line.
        others: further faults.
    """

    def __init__(self, key: str, got: object, wants: str):
        self.key = key
        self.got = got
        self.wants = wants
        self.others: tuple[InputError, ...] = ()
        super().__init__(f"{key}: got {got}, wants {wants}")

    def and_also(self, others: Iterable["InputError"]) -> "InputError":
        """The same error with further faults."""
        self.others = (*self.others, *others)
        return self

    def __str__(self) -> str:
        return "\n".join([super().__str__(), *map(str, self.others)])


class NumericalFailure(RuntimeError):
    """The numerics failed before the end of the run; all that was computed up to then is kept.

    Attributes:
        result: what was computed, as after a run that ended well; its summary tells time, reason and advice.
    """

    def __init__(self, message: str, result: object):
        self.result = result
        super().__init__(message)
