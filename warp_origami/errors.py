"""What the program says when the input is wrong."""


class InputError(ValueError):
    """A scene, pattern or FOLD file that cannot be run.

    The message is one line for the user: where (key), what was found, what is wanted. The command line prints it and
    exits with 2.
    """

    def __init__(self, key: str, got: object, wants: str):
        self.key = key
        self.got = got
        self.wants = wants
        super().__init__(f"{key}: got {got}, wants {wants}")
