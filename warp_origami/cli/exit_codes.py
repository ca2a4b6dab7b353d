"""Exit codes: 0 done, 2 wrong input, 3 the numerics failed, 130 interrupted."""

WRONG_INPUT, FAILED, INTERRUPTED = 2, 3, 130
