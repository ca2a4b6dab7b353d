"""One study at a time in a folder."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from warp_origami.errors import InputError

FILE = ".sweep.lock"


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Keeps other studies out of a folder; the system lets go when this process ends, however it does.

    Raises:
        InputError: another one is at work there.
    """
    handle = os.open(folder / FILE, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o644)
    try:
        if not _take(handle):
            raise InputError("--out", f"{str(folder)!r}, where a study is running", "its end, or another folder")
        yield
    finally:
        os.close(handle)


def _take(handle: int) -> bool:
    try:
        import fcntl
    except ImportError:  # a system without such locks
        return True
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
